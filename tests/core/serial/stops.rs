//! Stops at the ends of the joints' ranges: what they do, where they count, and what they do with
//! energy.

use approx::assert_relative_eq;
use steadyarm::arm::{
    Arm, Inertia, JointKind, JointLimits, JointStop, Link, Pose, Serial, SerialParameters,
};
use steadyarm::math::Vector;

use crate::chains;
use crate::random::Random;

const STOP: JointStop = JointStop { stiffness: 2e3, dissipation: 0.5 };
const RANGE: JointLimits = JointLimits { lower: 0.2, upper: 1.0, ..JointLimits::NONE };

#[test]
fn a_stop_pushes_back_beyond_its_end_only_and_never_pulls() {
    let torque = |q, dq| STOP.torque(&RANGE, q, dq);
    for dq in [-5.0, 0.0, 5.0] {
        assert_eq!([torque(0.2, dq), torque(0.5, dq), torque(1.0, dq)], [0.0; 3]);
    }
    // k δ (1 + c δ̇)
    assert_relative_eq!(torque(1.1, 0.0), 200.0, max_relative = 1e-14);
    assert_relative_eq!(torque(1.1, 1.0), 300.0, max_relative = 1e-14);
    assert_relative_eq!(torque(1.1, -1.0), 100.0, max_relative = 1e-14);
    assert_eq!(torque(1.1, -3.0), 0.0);
    assert_relative_eq!(torque(0.1, 0.0), -200.0, max_relative = 1e-14);
    assert_relative_eq!(torque(0.1, -1.0), -300.0, max_relative = 1e-14);
    assert_eq!(torque(0.1, 3.0), 0.0);
    assert_eq!(STOP.torque(&JointLimits::NONE, 1e9, 1.0), 0.0);
    assert_eq!(JointStop::default().torque(&RANGE, 9.0, 1.0), 0.0);
}

fn counts_in_both_dynamics<const N: usize>() {
    let mut hit = [false; N];
    for seed in 0..50 {
        let mut random = Random(300 + seed);
        let free = chains::chain::<N>(&mut random);
        let stops = [(); N].map(|()| JointStop {
            stiffness: random.decades(0.0, 4.0),
            dissipation: random.between(0.0, 2.0),
        });
        let arm = free.with_stops(&stops).unwrap();
        // The ranges are −3 … 3: some joints within them, some beyond an end.
        let q = chains::vector::<N>(&mut random, 6.0);
        let (dq, ddq) = (chains::vector(&mut random, 1.0), chains::vector(&mut random, 1.0));
        let stop = arm.stops(&q, &dq);
        for n in 0..N {
            assert_eq!(stop[n], stops[n].torque(&free.links()[n].limits, q[n], dq[n]));
            hit[n] |= stop[n] != 0.0;
        }
        let tau = arm.inverse_dynamics(&q, &dq, &ddq);
        let without = free.inverse_dynamics(&q, &dq, &ddq);
        let size = stop.amax().max(without.amax());
        assert!((tau - without - stop).amax() <= 1e-13 * size);
        let back = arm.forward_dynamics(&q, &dq, &tau);
        let amplified = arm.mass_matrix(&q).try_inverse().unwrap().amax() * size;
        assert!((back - ddq).amax() <= 1e-11 * amplified.max(1.0), "{:e}", (back - ddq).amax());
        assert_eq!(arm.bias(&q, &dq), free.bias(&q, &dq));
        assert_eq!(arm.with_stops(&[JointStop::default(); N]).unwrap(), free);
    }
    assert_eq!(hit, [true; N]);
}

#[test]
fn stops_count_in_inverse_and_forward_dynamics_and_not_in_the_bias() {
    counts_in_both_dynamics::<1>();
    counts_in_both_dynamics::<3>();
    counts_in_both_dynamics::<7>();
    counts_in_both_dynamics::<12>();
}

/// A mass of 2 kg that hangs half a metre below a hinge, and is kept from its lowest position by a
/// stop.
fn pendulum(stop: JointStop) -> Serial<1> {
    let below = nalgebra::Vector3::z() * -0.5;
    let mut link = Link::new(
        JointKind::Revolute,
        Pose::IDENTITY,
        nalgebra::Vector3::y(),
        Inertia::point_mass(2.0, below),
    );
    (link.limits, link.stop) = (RANGE, stop);
    let gravity = [0.0, 0.0, -9.81];
    Serial::new(SerialParameters { links: [link], tip: Pose::IDENTITY, gravity }).unwrap()
}

/// The energy of the arm and of its stops' springs along 5 s of RK4 from within the range, and the
/// last position.
fn energies(arm: &Serial<1>, steps: usize) -> (Vec<f64>, f64) {
    let h = 5.0 / steps as f64;
    let (mut q, mut dq) = (Vector::<1>::new(0.9), Vector::<1>::new(2.0));
    let rate = |q: &Vector<1>, dq: &Vector<1>| arm.forward_dynamics(q, dq, &Vector::zeros());
    let mut energies = Vec::new();
    for _ in 0..steps {
        let depth = (q[0] - RANGE.upper).max(RANGE.lower - q[0]).max(0.0);
        let spring = 0.5 * arm.links()[0].stop.stiffness * depth * depth;
        energies.push(arm.kinetic_energy(&q, &dq) + arm.potential_energy(&q) + spring);
        let a = (dq, rate(&q, &dq));
        let step = |k: (Vector<1>, Vector<1>), h: f64| {
            let (q, dq) = (q + k.0 * h, dq + k.1 * h);
            (dq, rate(&q, &dq))
        };
        let b = step(a, 0.5 * h);
        let c = step(b, 0.5 * h);
        let d = step(c, h);
        q += (a.0 + (b.0 + c.0) * 2.0 + d.0) * (h / 6.0);
        dq += (a.1 + (b.1 + c.1) * 2.0 + d.1) * (h / 6.0);
    }
    (energies, q[0])
}

#[test]
fn a_stop_without_dissipation_keeps_the_energy_and_one_with_it_loses_some() {
    let worst = |steps: usize| {
        let (kept, _) = energies(&pendulum(JointStop { dissipation: 0.0, ..STOP }), steps);
        kept.iter().map(|e| (e - kept[0]).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (worst(10_000), worst(100_000));
    assert!(coarse < 1e-3, "{coarse:e}");
    // The torque has a kink at an end. What that costs goes with the second power of the step, but
    // also with where in a step the kink falls: ten times shorter steps give a hundred on average.
    assert!(coarse / fine > 10.0, "{coarse:e} {fine:e}");
    let (lost, _) = energies(&pendulum(STOP), 100_000);
    assert!(lost.windows(2).all(|pair| pair[1] <= pair[0] + fine));
    assert!(lost[0] - lost[lost.len() - 1] > 1.0);
}

#[test]
fn a_pendulum_comes_to_rest_on_its_stop() {
    let (_, q) = energies(&pendulum(JointStop { dissipation: 5.0, ..STOP }), 100_000);
    let depth = RANGE.lower - q;
    assert_relative_eq!(STOP.stiffness * depth, 9.81 * q.sin(), max_relative = 1e-3);
}

#[test]
fn a_stop_that_cannot_be_is_refused() {
    let arm = chains::chain::<3>(&mut Random(17));
    for (change, parameter) in [
        (JointStop { stiffness: -1.0, ..STOP }, "stop.stiffness"),
        (JointStop { stiffness: f64::INFINITY, ..STOP }, "stop.stiffness"),
        (JointStop { dissipation: -1e-9, ..STOP }, "stop.dissipation"),
        (JointStop { dissipation: f64::NAN, ..STOP }, "stop.dissipation"),
    ] {
        let mut links = *arm.links();
        links[2].stop = change;
        let refusals = [
            arm.with_stops(&[STOP, STOP, change]).unwrap_err(),
            Serial::new(SerialParameters { links, ..*arm.parameters() }).unwrap_err(),
        ];
        for refusal in refusals {
            assert_eq!((refusal.parameter(), refusal.index()), (parameter, Some(2)));
        }
    }
}
