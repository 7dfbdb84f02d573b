//! Numbers that others have printed.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2};

use nalgebra::{Matrix3, SMatrix, Vector3};
use steadyarm::arm::{
    Arm, Inertia, JointFriction, JointKind, Link, Pose, Serial, SerialParameters, Unphysical,
};
use steadyarm::math::{Matrix, Vector};

fn diagonal(moments: [f64; 3]) -> Matrix3<f64> {
    Matrix3::from_diagonal(&moments.into())
}

/// The three-link arm in the docstrings of the Python package `modern_robotics` (Lynch and Park,
/// Modern Robotics, 2017).
///
/// Its first screw has |ω| = √2, so that its joint turns by √2 θ₁: see `SCALE`.
fn modern_robotics() -> Serial<3> {
    let turned = Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0);
    let m01 = Pose::at(Vector3::new(0.0, 0.0, 0.089159));
    let m12 = Pose::new(turned, Vector3::new(0.28, 0.13585, 0.0));
    let m23 = Pose::at(Vector3::new(0.0, -0.1197, 0.395));
    let m34 = Pose::at(Vector3::new(0.0, 0.0, 0.14225));
    let m02 = m01.then(&m12);
    let m03 = m02.then(&m23);
    // Axes and a point on each: (ω, v) = (1, 0, 1, 0, 1, 0), (0, 1, 0, −0.089, 0, 0), (0, 1, 0,
    // −0.089, 0, 0.425), v = −ω × p.
    let axes = [Vector3::new(1.0, 0.0, 1.0) / SQRT_2, Vector3::y(), Vector3::y()];
    let points = [[-0.5, 0.0, 0.5], [0.0, 0.0, 0.089], [0.425, 0.0, 0.089]].map(Vector3::from);
    let masses = [3.7, 8.393, 2.275];
    let moments = [
        [0.010267, 0.010267, 0.00666],
        [0.22689, 0.22689, 0.0151074],
        [0.0494433, 0.0494433, 0.004095],
    ];
    let centres = [m01, m02, m03];
    let links = core::array::from_fn(|i| {
        let body =
            Inertia { mass: masses[i], com: Vector3::zeros(), moments: diagonal(moments[i]) };
        let inertia = body.transformed(&Pose::at(-points[i]).then(&centres[i]));
        let before = if i == 0 { Vector3::zeros() } else { points[i - 1] };
        Link::new(JointKind::Revolute, Pose::at(points[i] - before), axes[i], inertia)
    });
    let tip = Pose::at(-points[2]).then(&m03.then(&m34));
    Serial::new(SerialParameters { links, tip, gravity: [0.0, 0.0, -9.8] }).unwrap()
}

/// dφ/dθ.
const SCALE: Vector<3> = Vector::<3>::new(SQRT_2, 1.0, 1.0);
/// Eight decimals are printed.
const PRINTED: f64 = 6e-9;

fn scaled(v: [f64; 3]) -> Vector<3> {
    Vector::<3>::from(v).component_mul(&SCALE)
}

#[test]
fn modern_robotics_docstrings_are_reproduced() {
    let arm = modern_robotics();
    let (q, dq, ddq) = (scaled([0.1; 3]), scaled([0.1, 0.2, 0.3]), scaled([2.0, 1.5, 1.0]));
    let close = |got: Vector<3>, wanted: [f64; 3]| {
        let off = got.component_mul(&SCALE) - Vector::<3>::from(wanted);
        assert!(off.amax() < PRINTED, "{off}");
    };
    // MassMatrix
    let scale = Matrix::<3>::from_diagonal(&SCALE);
    let mass = scale * arm.mass_matrix(&q) * scale;
    let printed = Matrix::<3>::new(
        2.25433380e+01,
        -3.07146754e-01,
        -7.18426391e-03,
        -3.07146754e-01,
        1.96850717e+00,
        4.32157368e-01,
        -7.18426391e-03,
        4.32157368e-01,
        1.91630858e-01,
    );
    assert!((mass - printed).amax() < 6e-8, "{mass}");
    // VelQuadraticForces, GravityForces
    close(arm.coriolis(&q, &dq) * dq, [0.26453118, -0.05505157, -0.00689132]);
    close(arm.gravity(&q), [28.40331262, -37.64094817, -5.4415892]);
    // EndEffectorForces: a moment and a force of (1, 1, 1) in the tip's axes.
    let ones = arm.pose(&q).rotation * Vector3::repeat(1.0);
    let wrench = SMatrix::<f64, 6, 1>::from_fn(|i, _| ones[i % 3]);
    let at_tip = arm.jacobian(&q).transpose() * wrench;
    close(at_tip, [1.40954608, 1.85771497, 1.392409]);
    // InverseDynamics, ForwardDynamics
    let tau = arm.inverse_dynamics(&q, &dq, &ddq) + at_tip;
    close(tau, [74.69616155, -33.06766016, -3.23057314]);
    let tau = Vector::<3>::new(0.5, 0.6, 0.7).component_div(&SCALE) - at_tip;
    let ddq = arm.forward_dynamics(&q, &dq, &tau).component_div(&SCALE);
    let off = ddq - Vector::<3>::new(-0.97392907, 25.58466784, -32.91499212);
    assert!(off.amax() < 2e-8, "{off}");
}

/// θ about z, then d along z, a along the new x, α about it: what follows θ.
fn denavit_hartenberg(d: f64, a: f64, alpha: f64) -> Pose {
    let (s, c) = alpha.sin_cos();
    let rotation = Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c);
    Pose::new(rotation, Vector3::new(a, 0.0, d))
}

/// The Puma 560 of Corke's Robotics Toolbox for MATLAB (`mdl_puma560`), after Corke and
/// Armstrong-Hélouvry 1994.
///
/// Two figures there belong to no body: link 1 has no mass, and moments about its y alone; link 3's
/// moments (0.066, 0.086, 0.0125) break the triangle inequality. They are taken as they stand.
fn puma() -> Serial<6> {
    // d, a, α | m, centre, moments about it | motor inertia, gear, motor viscous, motor Coulomb
    type Row = ([f64; 3], f64, [f64; 3], [f64; 3], [f64; 3], [f64; 2]);
    let rows: [Row; 6] = [
        (
            [0.0, 0.0, FRAC_PI_2],
            0.0,
            [0.0; 3],
            [0.0, 0.35, 0.0],
            [200e-6, -62.6111, 1.48e-3],
            [0.395, 0.435],
        ),
        (
            [0.0, 0.4318, 0.0],
            17.4,
            [-0.3638, 0.006, 0.2275],
            [0.13, 0.524, 0.539],
            [200e-6, 107.815, 0.817e-3],
            [0.126, 0.071],
        ),
        (
            [0.15005, 0.0203, -FRAC_PI_2],
            4.8,
            [-0.0203, -0.0141, 0.070],
            [0.066, 0.086, 0.0125],
            [200e-6, -53.7063, 1.38e-3],
            [0.132, 0.105],
        ),
        (
            [0.4318, 0.0, FRAC_PI_2],
            0.82,
            [0.0, 0.019, 0.0],
            [1.8e-3, 1.3e-3, 1.8e-3],
            [33e-6, 76.0364, 71.2e-6],
            [11.2e-3, 16.9e-3],
        ),
        (
            [0.0, 0.0, -FRAC_PI_2],
            0.34,
            [0.0; 3],
            [0.3e-3, 0.4e-3, 0.3e-3],
            [33e-6, 71.923, 82.6e-6],
            [9.26e-3, 14.5e-3],
        ),
        (
            [0.0, 0.0, 0.0],
            0.09,
            [0.0, 0.0, 0.032],
            [0.15e-3, 0.15e-3, 0.04e-3],
            [33e-6, 76.686, 36.7e-6],
            [3.96e-3, 10.5e-3],
        ),
    ];
    let ends = rows.map(|([d, a, alpha], ..)| denavit_hartenberg(d, a, alpha));
    let links = core::array::from_fn(|i| {
        let (_, mass, com, moments, [rotor, gear, viscous], coulomb) = rows[i];
        let gear: f64 = f64::abs(gear);
        let body = Inertia { mass, com: com.into(), moments: diagonal(moments) };
        let placement = if i == 0 { Pose::IDENTITY } else { ends[i - 1] };
        let friction = JointFriction {
            viscous: viscous * gear * gear,
            coulomb: coulomb.map(|c| c * gear),
            ..JointFriction::default()
        };
        let inertia = body.transformed(&ends[i]);
        let link = Link::new(JointKind::Revolute, placement, Vector3::z(), inertia);
        Link { friction, armature: rotor * gear * gear, ..link }
    });
    let parameters = SerialParameters { links, tip: ends[5], gravity: [0.0, 0.0, -9.81] };
    Serial::new_with(parameters, Unphysical::Note).unwrap()
}

/// By hand: of link 1's Σ = diag(0.175, −0.175, 0.175) and link 3's diag(0.01625, −0.00375,
/// 0.06975) what is negative is left out, so that I = tr(Σ) 1 − Σ.
#[test]
fn nearest_bodies_of_the_puma() {
    let as_stated = puma();
    let moments = |link: usize| as_stated.links()[link].inertia.nearest().unwrap().moments;
    assert!(Serial::new(*as_stated.parameters()).is_err());
    let mut principal =
        Inertia { moments: moments(0), ..Inertia::NONE }.principal_moments().unwrap();
    for (got, wanted) in principal.into_iter().zip([0.175, 0.175, 0.35]) {
        assert!((got - wanted).abs() < 1e-15, "{principal:?}");
    }
    principal = Inertia { moments: moments(2), ..Inertia::NONE }.principal_moments().unwrap();
    for (got, wanted) in principal.into_iter().zip([0.01625, 0.06975, 0.086]) {
        assert!((got - wanted).abs() < 1e-15, "{principal:?}");
    }
    let nearest = Serial::new_with(*as_stated.parameters(), Unphysical::Nearest).unwrap();
    for link in [1, 3, 4, 5] {
        assert_eq!(nearest.links()[link], as_stated.links()[link]);
    }
    // Mass and centre are kept, so the weight is.
    let q = Vector::<6>::new(0.1, 0.2, 0.3, 0.4, 0.5, 0.6);
    assert!((nearest.gravity(&q) - as_stated.gravity(&q)).amax() < 1e-14);
}

#[test]
fn puma_560_of_the_robotics_toolbox_is_reproduced() {
    // Four decimals are printed (Corke, Robotics, Vision and Control, ch. 9).
    const PRINTED: f64 = 6e-5;
    let arm = puma();
    let q = Vector::<6>::new(0.0, FRAC_PI_4, PI, 0.0, FRAC_PI_4, 0.0);
    let rest = Vector::<6>::zeros();
    let close = |got: Vector<6>, wanted: [f64; 6]| {
        let off = got - Vector::<6>::from(wanted);
        assert!(off.amax() < PRINTED, "{got}");
    };
    // gravload(qn) and rne(qn, 0, 0)
    let gravity = [0.0, 31.6399, 6.0351, 0.0, 0.0283, 0.0];
    close(arm.gravity(&q), gravity);
    close(arm.inverse_dynamics(&q, &rest, &rest), gravity);
    // rne(qn, [1 0 0 0 0 0], 0) without gravity
    let turning = Vector::<6>::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let moved = arm.inverse_dynamics(&q, &turning, &rest) - arm.gravity(&q);
    close(moved, [30.5332, 0.6280, -0.3607, -0.0003, 0.0, 0.0]);
    // inertia(qn)
    let rows = [
        [3.6594, -0.4044, 0.1006, -0.0025, 0.0, 0.0],
        [-0.4044, 4.4137, 0.3509, 0.0, 0.0024, 0.0],
        [0.1006, 0.3509, 0.9378, 0.0, 0.0015, 0.0],
        [-0.0025, 0.0, 0.0, 0.1925, 0.0, 0.0],
        [0.0, 0.0024, 0.0015, 0.0, 0.1713, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.1941],
    ];
    let mass = arm.mass_matrix(&q);
    for (i, row) in rows.into_iter().enumerate() {
        close(mass.column(i).into(), row);
    }
    // fkine(qn), with the base at the shoulder as in the first edition
    let tip = arm.pose(&q).translation;
    assert!((tip - Vector3::new(0.5963, -0.1501, -0.0144)).amax() < PRINTED, "{tip}");
}
