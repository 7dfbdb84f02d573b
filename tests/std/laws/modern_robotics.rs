//! Modern Robotics' worked example of computed torque, to all its digits.

use nalgebra::{Matrix3, Vector3};
use steadyarm::arm::{
    Inertia, JointFriction, JointKind, JointLimits, JointStop, Link, Pose, Serial, SerialParameters,
};
use steadyarm::control::{ComputedTorque, Dynamic, Gains, Law, Sample};
use steadyarm::laws::Integral;
use steadyarm::math::Vector;
use steadyarm::reference::Setpoint;

/// Screws [ω, v] of the example, links' frames one in the other, mass and moments.
const SCREWS: [[f64; 6]; 3] = [
    [1.0, 0.0, 1.0, 0.0, 1.0, 0.0],
    [0.0, 1.0, 0.0, -0.089, 0.0, 0.0],
    [0.0, 1.0, 0.0, -0.089, 0.0, 0.425],
];
const MASSES: [(f64, [f64; 3]); 3] = [
    (3.7, [0.010267, 0.010267, 0.00666]),
    (8.393, [0.22689, 0.22689, 0.0151074]),
    (2.275, [0.0494433, 0.0494433, 0.004095]),
];

/// Centres of mass in the base at q = 0.
fn centers() -> [Pose; 3] {
    let turned = Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0);
    let first = Pose::at(Vector3::new(0.0, 0.0, 0.089159));
    let second = first.then(&Pose::new(turned, Vector3::new(0.28, 0.13585, 0.0)));
    [first, second, second.then(&Pose::at(Vector3::new(0.0, -0.1197, 0.395)))]
}

/// Joint frames are the base's at q = 0, moved to a point of the axis: p = ω × v/|ω|².
fn arm() -> Serial<3> {
    let mut before = Vector3::zeros();
    let links = core::array::from_fn(|i| {
        let [wx, wy, wz, vx, vy, vz] = SCREWS[i];
        let (w, v) = (Vector3::new(wx, wy, wz), Vector3::new(vx, vy, vz));
        let point = w.cross(&v) / w.norm_squared();
        let placement = Pose::at(point - before);
        before = point;
        let (mass, moments) = MASSES[i];
        let center = centers()[i];
        let r = center.rotation;
        Link {
            kind: JointKind::Revolute,
            placement,
            axis: w.normalize(),
            inertia: Inertia {
                mass,
                com: center.translation - point,
                moments: r * Matrix3::from_diagonal(&moments.into()) * r.transpose(),
            },
            friction: JointFriction::default(),
            armature: 0.0,
            limits: JointLimits::default(),
            stop: JointStop::default(),
        }
    });
    let gravity = [0.0, 0.0, -9.8];
    Serial::new(SerialParameters { links, tip: Pose::IDENTITY, gravity }).unwrap()
}

/// The docstring of `ComputedTorque` in modern_robotics 1.1.1 (Lynch and Park 2017, 11.4.1). Its
/// first screw is √2 long: that joint counts in units of 1/√2 rad, and its torque is √2 as large.
#[test]
fn computed_torque_with_an_integral_is_that_of_modern_robotics_to_all_digits() {
    let unit = Vector::<3>::new(2.0_f64.sqrt(), 1.0, 1.0);
    let scaled = |x: [f64; 3]| unit.component_mul(&Vector::<3>::from(x));
    let gains = Gains::new([1.3; 3], [1.1; 3]).unwrap();
    let integral = Integral::new([1.2; 3], &gains).unwrap();
    let desired =
        Setpoint { q: scaled([1.0; 3]), dq: scaled([2.0, 1.2, 2.0]), ddq: scaled([0.1; 3]) };
    let seen = Sample::new(scaled([0.1; 3]), scaled([0.1, 0.2, 0.3]), desired);
    // Its error is q_d − q, and the integral that it feeds back has taken the step of 1 s.
    let z = seen.e - scaled([0.2; 3]);
    let rho_hat = Dynamic::estimate(&integral, &z, &seen);
    let demand = ComputedTorque::new(arm(), gains).torque(&seen, &rho_hat);
    let tau = unit.component_mul(&(demand.model + demand.compensation));
    for (got, wanted) in tau.iter().zip([133.00525246, -29.94223324, -3.03276856]) {
        assert!((got - wanted).abs() < 5.1e-9, "{tau} {wanted}");
    }
}
