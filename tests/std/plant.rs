//! What pushes the arm: impulses, steps, noise, a wrench at the tip, and their sums.

use nalgebra::SMatrix;
use steadyarm::arm::{Arm, Serial, Tip, TwoLink, TwoLinkParameters};
use steadyarm::error::Result;
use steadyarm::math::{Vector, sin_cos};
use steadyarm::plant::{Disturbance, Noise, Plant, Pulse, Pulses, Shape, Wrench};
use steadyarm::reference::{Harmonic, Sines};

use crate::chains::chain;
use crate::random::Random;

fn pulse(time: f64, duration: f64, height: f64) -> Pulse<2> {
    Pulse { time, duration, torque: [height, -2.0 * height] }
}

#[test]
fn a_step_has_no_end_and_an_impulse_has_one() {
    let both = [pulse(1.0, f64::INFINITY, 3.0), pulse(2.0, 0.5, 10.0)];
    let pushes = Pulses::new(both, Shape::Rectangle).unwrap();
    for (t, height) in
        [(0.999, 0.0), (1.0, 3.0), (1.9, 3.0), (2.0, 13.0), (2.49, 13.0), (2.5, 3.0), (1e9, 3.0)]
    {
        assert_eq!(pushes.value(t), Vector::<2>::new(height, -2.0 * height), "{t}");
        assert_eq!(pushes.at_time(t), Some(pushes.value(t)));
    }
}

/// The area of a half sine is 2/π of its rectangle.
#[test]
fn a_half_sine_begins_and_ends_at_zero() {
    let push = Pulses::new([pulse(1.0, 0.2, 5.0)], Shape::HalfSine).unwrap();
    for (t, wanted) in [(0.99, 0.0), (1.0, 0.0), (1.1, 5.0), (1.2, 0.0), (1.3, 0.0)] {
        assert!((push.value(t)[0] - wanted).abs() < 1e-14, "{t}");
    }
    let sum: f64 = (0..2000).map(|k| push.value(1.0 + 1e-4 * (f64::from(k) + 0.5))[0]).sum();
    assert!((sum * 1e-4 - 5.0 * 0.2 * 2.0 / core::f64::consts::PI).abs() < 1e-7);
}

#[test]
fn pulses_that_cannot_be_are_refused_by_the_pulse() {
    let refused = |shape, change: fn(&mut Pulse<2>)| {
        let mut pulses = [pulse(0.0, 1.0, 1.0); 2];
        assert!(Pulses::new(pulses, shape).is_ok());
        change(&mut pulses[1]);
        Pulses::new(pulses, shape).unwrap_err().to_string()
    };
    let (flat, round) = (Shape::Rectangle, Shape::HalfSine);
    for (got, wanted) in [
        (refused(flat, |it| it.time = f64::NAN), "time[1]: got NaN, wants a finite number"),
        (refused(flat, |it| it.duration = 0.0), "duration[1]: got 0, wants a number > 0"),
        (refused(flat, |it| it.duration = f64::NAN), "duration[1]: got NaN, wants a number > 0"),
        (refused(flat, |it| it.torque[1] = f64::INFINITY), "torque[3]: got inf, wants a finite"),
        (refused(round, |it| it.duration = f64::INFINITY), "duration[1]: got inf, wants an end"),
    ] {
        assert!(got.starts_with(wanted), "{got}");
    }
}

fn noise(seed: u64) -> Noise<3> {
    Noise::new([1.0, 2.0, 0.5], 1.0, seed).unwrap()
}

/// Moments over 20 000 time constants, 0.5 time constants apart. Each estimate is off by its
/// standard error, below 0.013 for a variance of 1, at the most 4 times.
#[test]
fn noise_is_stationary_with_its_deviation_and_correlation() {
    let (noise, omega) = (noise(7), core::f64::consts::TAU);
    let step = 0.5 / omega;
    let samples: Vec<Vector<3>> =
        (-20_000..20_000).map(|k| noise.value(step * f64::from(k))).collect();
    let mean =
        |of: &dyn Fn(usize) -> f64, count: usize| (0..count).map(of).sum::<f64>() / count as f64;
    let count = samples.len();
    for (joint, deviation) in [1.0, 2.0, 0.5].into_iter().enumerate() {
        let x = |k: usize| samples[k][joint] / deviation;
        assert!(mean(&x, count).abs() < 0.04);
        // At random places of the last intervals, straight lines: 1 − 1/96 of the variance.
        assert!((mean(&|k| x(k) * x(k), count) - 1.0).abs() < 0.05);
        assert!((mean(&|k| x(k).powi(4), count) - 3.0).abs() < 0.3);
        for lag in [1, 2, 4, 8] {
            let got = mean(&|k| x(k) * x(k + lag), count - lag);
            assert!((got - (-0.5 * lag as f64).exp()).abs() < 0.05, "{joint} {lag} {got}");
        }
        let other = |k: usize| samples[k][(joint + 1) % 3];
        assert!(mean(&|k| x(k) * other(k) / deviation, count).abs() < 0.1);
    }
}

/// The first values of an Ornstein-Uhlenbeck process are rough: steps grow like √h.
#[test]
fn noise_is_continuous_and_rough() {
    let (noise, omega) = (noise(3), core::f64::consts::TAU);
    for scale in [1.0 / 8.0, 1.0 / 2.0] {
        let h = scale / omega;
        let square = |k: i32| {
            let t = 0.977 * f64::from(k);
            (noise.value(t + h)[0] - noise.value(t)[0]).powi(2)
        };
        let got = (0..20_000).map(square).sum::<f64>() / 20_000.0;
        let wanted = 2.0 * (1.0 - (-scale).exp());
        assert!((got / wanted - 1.0).abs() < 0.1, "{scale}: {got} {wanted}");
    }
    let h = 1e-9;
    let jump =
        |k: i32| (noise.value(0.01 * f64::from(k) + h) - noise.value(0.01 * f64::from(k))).amax();
    assert!((0..10_000).map(jump).fold(0.0, f64::max) < 1e-6);
}

/// From the first run, on x86-64: the same on every machine, in whatever order it is asked.
#[test]
fn noise_has_the_same_bits_for_the_same_seed_and_others_for_another() {
    let times = [1e6, -3.7, 0.0, 0.25, 1e-9, 12.34];
    let bits = |seed| -> Vec<u64> {
        let noise = noise(seed);
        times.iter().flat_map(|t| noise.value(*t).data.0[0].map(f64::to_bits)).collect()
    };
    assert_eq!(bits(5), bits(5));
    assert!(bits(5).iter().zip(bits(6)).all(|(a, b)| *a != b));
    let hash = bits(5).iter().fold(0u64, |hash, x| hash.rotate_left(7) ^ x);
    assert_eq!(format!("{hash:016x}"), GOLDEN);
}

const GOLDEN: &str = "aaf4745f2f4b529b";

#[test]
fn noise_that_cannot_be_is_refused() {
    let words = |made: Result<Noise<2>>| made.unwrap_err().to_string();
    assert_eq!(words(Noise::new([0.1, -1.0], 1.0, 0)), "deviation[1]: got -1, wants a number >= 0");
    assert_eq!(words(Noise::new([0.1; 2], 0.0, 0)), "cutoff: got 0, wants a number > 0");
    assert_eq!(words(Noise::new([0.1; 2], f64::NAN, 0)), "cutoff: got NaN, wants a finite number");
    assert!(noise(1).value(f64::NAN).iter().all(|x| x.is_nan()));
    assert!(noise(1).value(1e300).iter().all(|x| x.is_finite()));
}

#[test]
fn several_add_up() {
    let sines = Sines::new([0.5; 2], [Harmonic { frequency: 2.0, sin: [1.0, 0.0], cos: [0.0; 2] }]);
    let sines = sines.unwrap();
    let twice = vec![sines, sines];
    let (q, dq) = (Vector::<2>::zeros(), Vector::<2>::zeros());
    let wanted = Vector::<2>::new(1.0 + 2.0 * sin_cos(1.4).0, 1.0);
    assert!((twice.torque(&q, &dq, 0.7) - wanted).amax() < 1e-15);
    assert_eq!(twice.at_time(0.7), Some(twice.torque(&q, &dq, 0.7)));
    assert_eq!(Vec::<Sines<2, [Harmonic<2>; 1]>>::new().at_time(0.7), Some(Vector::zeros()));
}

fn two_link() -> TwoLink {
    TwoLink::new(TwoLinkParameters { length: [0.5, 0.7], ..Default::default() }).unwrap()
}

/// The Jacobian by central differences of the tip's pose: its origin, and the axial vector of ṘRᵀ.
fn differences<const N: usize>(
    pose: impl Fn(&Vector<N>) -> steadyarm::arm::Pose,
    q: &Vector<N>,
) -> SMatrix<f64, 6, N> {
    let h = 1e-6;
    let mut jacobian = SMatrix::<f64, 6, N>::zeros();
    for joint in 0..N {
        let (mut low, mut high) = (*q, *q);
        low[joint] -= h;
        high[joint] += h;
        let (low, high) = (pose(&low), pose(&high));
        let speed = (high.translation - low.translation) / (2.0 * h);
        let spin = (high.rotation - low.rotation) * pose(q).rotation.transpose() / (2.0 * h);
        let column = [speed[0], speed[1], speed[2], spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]];
        jacobian.set_column(joint, &column.into());
    }
    jacobian
}

#[test]
fn the_jacobian_of_the_tip_is_the_derivative_of_its_pose() {
    let two = two_link();
    let mut random = Random(11);
    let seven: Serial<7> = chain(&mut random);
    for _ in 0..20 {
        let q = Vector::<2>::from_fn(|_, _| 3.0 * random.next());
        assert!((Tip::jacobian(&two, &q) - differences(|q| two.pose(q), &q)).amax() < 1e-8);
        let q = Vector::<7>::from_fn(|_, _| 3.0 * random.next());
        assert!((Tip::jacobian(&seven, &q) - differences(|q| seven.pose(q), &q)).amax() < 1e-8);
    }
}

/// A wrench does the work F·ẋ + m·ω on the arm, and M q̈ = Jᵀ (F, m) at rest without gravity.
#[test]
fn a_wrench_does_the_work_of_its_force_and_moment() {
    let arm = two_link();
    let (q, dq) = (Vector::<2>::new(0.4, -1.1), Vector::<2>::new(0.7, 0.3));
    let wrench = [3.0, -20.0, 5.0, 0.1, 0.2, -0.7];
    let step = [Pulse { time: 0.0, duration: f64::INFINITY, torque: wrench }];
    let push = Wrench::new(arm, Pulses::new(step, Shape::Rectangle).unwrap());
    let tau_d = push.torque(&q, &dq, 1.0);
    let twist = differences(|q| arm.pose(q), &q) * dq;
    assert!((-tau_d.dot(&dq) - twist.dot(&Vector::from(wrench))).abs() < 1e-7);
    let still = Vector::zeros();
    let ddq = Plant::new(arm, push).acceleration(&q, &still, &still, 1.0);
    assert!((arm.mass_matrix(&q) * ddq + tau_d).amax() < 1e-12);
}
