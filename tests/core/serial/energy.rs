//! Undriven swings of 10 s: energy is lost to friction only, up to the order of the integrator.

use nalgebra::SVector;
use steadyarm::arm::{Arm, JointFriction, JointKind, Serial};
use steadyarm::math::Vector;

use crate::chains;
use crate::random::Random;

const DURATION: f64 = 10.0;

/// A random arm that turns only, as undriven sliding joints fall out of reach.
fn swing<const N: usize>(seed: u64, friction: JointFriction) -> Serial<N> {
    let mut parameters = *chains::chain::<N>(&mut Random(seed)).parameters();
    for link in &mut parameters.links {
        (link.kind, link.friction) = (JointKind::Revolute, friction);
        link.armature += 0.2;
    }
    Serial::new(parameters).unwrap()
}

/// Position, velocity and the work of friction.
struct State<const N: usize>(Vector<N>, Vector<N>, f64);

fn rate<const N: usize>(arm: &Serial<N>, x: &State<N>) -> State<N> {
    let ddq = arm.forward_dynamics(&x.0, &x.1, &Vector::zeros());
    State(x.1, ddq, arm.friction(&x.1).dot(&x.1))
}

fn moved<const N: usize>(x: &State<N>, rate: &State<N>, h: f64) -> State<N> {
    State(x.0 + rate.0 * h, x.1 + rate.1 * h, x.2 + rate.2 * h)
}

/// The largest error of the energy balance in RK4 with the given number of steps, and the energy
/// lost to friction.
fn imbalance<const N: usize>(arm: &Serial<N>, steps: usize) -> (f64, f64) {
    let h = DURATION / steps as f64;
    let mut x = State(SVector::repeat(0.5), SVector::zeros(), 0.0);
    let energy = |x: &State<N>| arm.kinetic_energy(&x.0, &x.1) + arm.potential_energy(&x.0) + x.2;
    let (start, mut worst) = (energy(&x), 0.0f64);
    for _ in 0..steps {
        let a = rate(arm, &x);
        let b = rate(arm, &moved(&x, &a, 0.5 * h));
        let c = rate(arm, &moved(&x, &b, 0.5 * h));
        let d = rate(arm, &moved(&x, &c, h));
        for (stage, weight) in [(a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)] {
            x = moved(&x, &stage, weight * h / 6.0);
        }
        worst = worst.max((energy(&x) - start).abs());
    }
    (worst, x.2)
}

fn drift_is_of_fourth_order<const N: usize>(friction: JointFriction, loses: bool) {
    // The largest over some arms: one that happens to move little shows rounding alone.
    let (mut coarse, mut fine) = (0.0f64, 0.0f64);
    for seed in 0..4 {
        let arm = swing::<N>(50 + seed, friction);
        let (large, _) = imbalance(&arm, 2_500);
        let (small, lost) = imbalance(&arm, 5_000);
        (coarse, fine) = (coarse.max(large), fine.max(small));
        assert_eq!(lost > 0.0, loses, "{lost}");
    }
    // 2⁴ = 16, less where the next order still shows.
    assert!(coarse / fine > 12.0, "{N} joints: {coarse:e} {fine:e}");
    assert!((1e-11..1e-4).contains(&fine), "{N} joints: {fine:e}");
}

#[test]
fn energy_of_an_undriven_swing_drifts_with_the_fourth_power_of_the_step() {
    drift_is_of_fourth_order::<1>(JointFriction::default(), false);
    drift_is_of_fourth_order::<2>(JointFriction::default(), false);
    drift_is_of_fourth_order::<3>(JointFriction::default(), false);
    drift_is_of_fourth_order::<5>(JointFriction::default(), false);
    drift_is_of_fourth_order::<8>(JointFriction::default(), false);
}

#[test]
fn energy_of_a_rubbing_swing_goes_into_friction() {
    let friction = JointFriction {
        viscous: 0.2,
        coulomb: [0.3; 2],
        stribeck: 0.2,
        stribeck_speed: 2.0,
        smoothing: 1.0,
    };
    drift_is_of_fourth_order::<2>(friction, true);
    drift_is_of_fourth_order::<6>(friction, true);
}
