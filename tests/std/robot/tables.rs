//! The published tables of the arms that ship.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Vector3};
use steadyarm::arm::{Inertia, JointFriction, JointLimits};
use steadyarm::math::exp;
use steadyarm::robot::{Convention, Description, DhRow, GRAVITY};

pub fn inertia(mass: f64, com: [f64; 3], [xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Inertia {
    let moments = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    Inertia { mass, com: Vector3::from(com), moments }
}

fn named(mut arm: Description, names: &[[&str; 2]]) -> Description {
    for (joint, [name, link]) in arm.joints.iter_mut().zip(names) {
        joint.name = (*name).to_owned();
        joint.link_name = (*link).to_owned();
    }
    arm
}

/// Corke and Armstrong-Hélouvry 1994: standard table, masses, moments, and per motor: inertia,
/// gear, viscous, Coulomb.
pub fn puma_rows() -> [DhRow; 6] {
    let row = |a,
               d,
               alpha,
               inertia,
               [rotor, gear, viscous, plus, minus]: [f64; 5],
               [lower, upper]: [f64; 2]| {
        let gear: f64 = gear;
        let friction = JointFriction {
            viscous: gear * gear * viscous,
            coulomb: [gear.abs() * plus, gear.abs() * minus],
            ..Default::default()
        };
        let (lower, upper) = (f64::to_radians(lower), f64::to_radians(upper));
        let limits = JointLimits { lower, upper, ..DhRow::default().limits };
        DhRow {
            a,
            d,
            alpha,
            inertia,
            friction,
            limits,
            armature: gear * gear * rotor,
            ..Default::default()
        }
    };
    let diagonal = |mass, com, [x, y, z]: [f64; 3]| inertia(mass, com, [x, y, z, 0.0, 0.0, 0.0]);
    [
        row(
            0.0,
            0.0,
            FRAC_PI_2,
            diagonal(0.0, [0.0; 3], [0.0, 0.35, 0.0]),
            [200e-6, -62.6111, 1.48e-3, 0.395, 0.435],
            [-160.0, 160.0],
        ),
        row(
            0.4318,
            0.0,
            0.0,
            diagonal(17.4, [-0.3638, 0.006, 0.2275], [0.13, 0.524, 0.539]),
            [200e-6, 107.815, 0.817e-3, 0.126, 0.071],
            [-45.0, 225.0],
        ),
        row(
            0.0203,
            0.15005,
            -FRAC_PI_2,
            diagonal(4.8, [-0.0203, -0.0141, 0.070], [0.066, 0.086, 0.0125]),
            [200e-6, -53.7063, 1.38e-3, 0.132, 0.105],
            [-225.0, 45.0],
        ),
        row(
            0.0,
            0.4318,
            FRAC_PI_2,
            diagonal(0.82, [0.0, 0.019, 0.0], [1.8e-3, 1.3e-3, 1.8e-3]),
            [33e-6, 76.0364, 71.2e-6, 11.2e-3, 16.9e-3],
            [-110.0, 170.0],
        ),
        row(
            0.0,
            0.0,
            -FRAC_PI_2,
            diagonal(0.34, [0.0; 3], [0.3e-3, 0.4e-3, 0.3e-3]),
            [33e-6, 71.923, 82.6e-6, 9.26e-3, 14.5e-3],
            [-100.0, 100.0],
        ),
        row(
            0.0,
            0.0,
            0.0,
            diagonal(0.09, [0.0, 0.0, 0.032], [0.15e-3, 0.15e-3, 0.04e-3]),
            [33e-6, 76.686, 36.7e-6, 3.96e-3, 10.5e-3],
            [-266.0, 266.0],
        ),
    ]
}

/// The published figures made those of rigid bodies, without a change to any torque.
///
/// Link 1 turns about its y only: its other moments and its mass, on the axis, do nothing. A body's
/// moments about the axes across a joint may be moved to the link before: δ (1 − z zᵀ) turns with
/// the one as with the other.
pub fn puma_bodies() -> [DhRow; 6] {
    const MOVED: f64 = 0.01;
    let mut rows = puma_rows();
    rows[0].inertia = inertia(1.0, [0.0; 3], [0.35, 0.35, 0.35, 0.0, 0.0, 0.0]);
    // The axis of joint 3 is z of frame 2 and −y of frame 3.
    rows[1].inertia.moments -= Matrix3::from_diagonal(&Vector3::new(MOVED, MOVED, 0.0));
    rows[2].inertia.moments += Matrix3::from_diagonal(&Vector3::new(MOVED, 0.0, MOVED));
    rows
}

pub fn puma() -> Description {
    Description::from_dh("Puma 560", &puma_bodies(), Convention::Standard, GRAVITY).unwrap()
}

/// Universal Robots: standard table, masses and centres of mass; tensors about them, in the same
/// frames.
pub fn ur5e() -> Description {
    let row = |a, d, alpha, inertia, effort| {
        let limits = JointLimits { lower: -2.0 * PI, upper: 2.0 * PI, velocity: PI, effort };
        DhRow { a, d, alpha, inertia, limits, ..Default::default() }
    };
    let rows = [
        row(
            0.0,
            0.1625,
            FRAC_PI_2,
            inertia(
                3.761,
                [0.0, -0.02561, 0.00193],
                [0.00700210, 0.00648091, 0.00657286, 0.00000073, -0.00001053, 0.00049994],
            ),
            150.0,
        ),
        row(
            -0.425,
            0.0,
            0.0,
            inertia(
                8.058,
                [0.2125, 0.0, 0.11336],
                [0.01505885, 0.33388086, 0.33247207, -0.00005400, 0.00000563, -0.00000181],
            ),
            150.0,
        ),
        row(
            -0.3922,
            0.0,
            0.0,
            inertia(
                2.846,
                [0.15, 0.0, 0.0265],
                [0.00399632, 0.07879254, 0.07848510, -0.00001365, 0.00137272, -0.00000660],
            ),
            150.0,
        ),
        row(
            0.0,
            0.1333,
            FRAC_PI_2,
            inertia(
                1.37,
                [0.0, -0.0018, 0.01634],
                [0.00165491, 0.00135962, 0.00126279, -0.00000282, -0.00000438, 0.00010157],
            ),
            28.0,
        ),
        row(
            0.0,
            0.0997,
            -FRAC_PI_2,
            inertia(
                1.3,
                [0.0, 0.0018, 0.01634],
                [0.00135617, 0.00127827, 0.00096614, -0.00000274, 0.00000444, -0.00005048],
            ),
            28.0,
        ),
        row(
            0.0,
            0.0996,
            0.0,
            inertia(
                0.365,
                [0.0, 0.0, -0.001159],
                [0.00018694, 0.00018908, 0.00025756, 0.00000006, -0.00000017, -0.00000092],
            ),
            28.0,
        ),
    ];
    let names = [
        ["shoulder_pan_joint", "shoulder_link"],
        ["shoulder_lift_joint", "upper_arm_link"],
        ["elbow_joint", "forearm_link"],
        ["wrist_1_joint", "wrist_1_link"],
        ["wrist_2_joint", "wrist_2_link"],
        ["wrist_3_joint", "wrist_3_link"],
    ];
    named(Description::from_dh("UR5e", &rows, Convention::Standard, GRAVITY).unwrap(), &names)
}

/// Friction of Gaz et al., f = φ₁ σ(φ₂ (q̇ + φ₃)) − φ₁ σ(φ₂ φ₃), as heights in each direction and a
/// width: σ is half of 1 + tanh(·/2). Its shift along the speed is left out.
pub fn sigmoid([height, steepness, shift]: [f64; 3]) -> JointFriction {
    let below = height / (1.0 + exp(-steepness * shift));
    JointFriction {
        coulomb: [height - below, below],
        smoothing: 2.0 / steepness,
        ..Default::default()
    }
}

/// Gaz et al. 2019: modified table of Franka Emika, identified masses, moments and friction.
pub fn panda() -> Description {
    let row =
        |a, d, alpha, inertia, friction, [lower, upper]: [f64; 2], [velocity, effort]: [f64; 2]| {
            DhRow {
                a,
                d,
                alpha,
                inertia,
                friction: sigmoid(friction),
                limits: JointLimits { lower, upper, velocity, effort },
                ..Default::default()
            }
        };
    let (proximal, distal) = ([2.175, 87.0], [2.61, 12.0]);
    let rows = [
        row(
            0.0,
            0.333,
            0.0,
            inertia(
                4.970684,
                [3.875e-3, 2.081e-3, 0.0],
                [7.0337e-1, 7.0661e-1, 9.1170e-3, -1.3900e-4, 6.7720e-3, 1.9169e-2],
            ),
            [0.54615, 5.1181, 0.039533],
            [-2.8973, 2.8973],
            proximal,
        ),
        row(
            0.0,
            0.0,
            -FRAC_PI_2,
            inertia(
                0.646926,
                [-3.141e-3, -2.872e-2, 3.495e-3],
                [7.9620e-3, 2.8110e-2, 2.5995e-2, -3.9250e-3, 1.0254e-2, 7.0400e-4],
            ),
            [0.87224, 9.0657, 0.025882],
            [-1.7628, 1.7628],
            proximal,
        ),
        row(
            0.0,
            0.316,
            FRAC_PI_2,
            inertia(
                3.228604,
                [2.7518e-2, 3.9252e-2, -6.6502e-2],
                [3.7242e-2, 3.6155e-2, 1.0830e-2, -4.7610e-3, -1.1396e-2, -1.2805e-2],
            ),
            [0.64068, 10.136, -0.04607],
            [-2.8973, 2.8973],
            proximal,
        ),
        row(
            0.0825,
            0.0,
            FRAC_PI_2,
            inertia(
                3.587895,
                [-5.317e-2, 1.04419e-1, 2.7454e-2],
                [2.5853e-2, 1.9552e-2, 2.8323e-2, 7.7960e-3, -1.3320e-3, 8.6410e-3],
            ),
            [1.2794, 5.5903, 0.036194],
            [-3.0718, -0.0698],
            proximal,
        ),
        row(
            -0.0825,
            0.384,
            -FRAC_PI_2,
            inertia(
                1.225946,
                [-1.1953e-2, 4.1065e-2, -3.8437e-2],
                [3.5549e-2, 2.9474e-2, 8.6270e-3, -2.1170e-3, -4.0370e-3, 2.2900e-4],
            ),
            [0.83904, 8.3469, 0.026226],
            [-2.8973, 2.8973],
            distal,
        ),
        row(
            0.0,
            0.0,
            FRAC_PI_2,
            inertia(
                1.666555,
                [6.0149e-2, -1.4117e-2, -1.0517e-2],
                [1.9640e-3, 4.3540e-3, 5.4330e-3, 1.0900e-4, -1.1580e-3, 3.4100e-4],
            ),
            [0.30301, 17.133, -0.021047],
            [-0.0175, 3.7525],
            distal,
        ),
        row(
            0.088,
            0.0,
            FRAC_PI_2,
            inertia(
                7.35522e-1,
                [1.0517e-2, -4.252e-3, 6.1597e-2],
                [1.2516e-2, 1.0027e-2, 4.8150e-3, -4.2800e-4, -1.1960e-3, -7.4100e-4],
            ),
            [0.56489, 10.336, 0.0035526],
            [-2.8973, 2.8973],
            distal,
        ),
    ];
    let names: Vec<_> =
        (1..8).map(|i| [format!("panda_joint{i}"), format!("panda_link{i}")]).collect();
    let names: Vec<_> = names.iter().map(|[joint, link]| [joint.as_str(), link.as_str()]).collect();
    let mut arm = named(
        Description::from_dh("Franka Emika Panda", &rows, Convention::Modified, GRAVITY).unwrap(),
        &names,
    );
    arm.tip.translation.z = 0.107; // the flange
    arm
}
