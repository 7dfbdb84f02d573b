//! Motions through poses: limits, poses, pauses, derivatives, and the refusals.

use proptest::prelude::*;
use steadyarm::reference::{MAX_POSES, MotionLimits, Reference, Setpoint, Waypoints};
use steadyarm::{Error, Problem};

use crate::counting::calls_during;
use crate::random::Random;

/// Limits are kept to the rounding of a few operations.
const KEPT: f64 = 1.0 + 1e-12;

fn limits<const N: usize>(velocity: f64, acceleration: f64, jerk: f64) -> MotionLimits<N> {
    MotionLimits { velocity: [velocity; N], acceleration: [acceleration; N], jerk: [jerk; N] }
}

fn alone(distance: f64, [velocity, acceleration, jerk]: [f64; 3]) -> Waypoints<1> {
    let poses = [[0.0], [distance]];
    Waypoints::new(&poses, &limits(velocity, acceleration, jerk), &[0.0], 0.0).unwrap()
}

/// The four shapes of L. Biagiotti, C. Melchiorri, "Trajectory planning for automatic machines and
/// robots" (2008), section 3.4, by their closed forms.
#[test]
fn the_fastest_motion_of_one_joint_has_the_duration_of_the_closed_form() {
    for (distance, most, wanted) in [
        // No limit but jerk: 4 ∛(d/2J).
        (1.0, [10.0, 10.0, 4.0], 2.0),
        // Velocity and jerk: d/V + 2 √(V/J).
        (2.0, [1.0, 10.0, 4.0], 2.0 + 1.0),
        // Acceleration and jerk: A/J + √((A/J)² + 4d/A).
        (10.0, [100.0, 2.0, 2.0], 1.0 + 21.0_f64.sqrt()),
        // All: d/V + V/A + A/J.
        (10.0, [2.0, 2.0, 4.0], 5.0 + 1.0 + 0.5),
        (-10.0, [2.0, 2.0, 4.0], 6.5),
    ] {
        let duration = alone(distance, most).duration();
        assert!((duration / wanted - 1.0).abs() < 1e-9, "{distance} {most:?}: {duration} {wanted}");
    }
}

#[test]
fn joints_start_and_arrive_together_on_a_straight_line() {
    let poses = [[0.0, 0.0, 0.5], [1.0, -0.4, 0.5]];
    let path = Waypoints::new(&poses, &limits::<3>(1.0, 5.0, 50.0), &[0.0], 0.0).unwrap();
    // d/V + V/A + A/J of the first joint.
    assert!((path.duration() - 1.3).abs() < 1e-9);
    for k in 0..=1000 {
        let at = path.at(path.duration() * f64::from(k) / 1000.0);
        assert!((at.q[1] + 0.4 * at.q[0]).abs() < 1e-15);
        assert_eq!(at.q[2], 0.5);
    }
}

/// What a motion must be, whatever its poses and limits.
fn check<const N: usize>(
    path: &Waypoints<N>,
    poses: &[[f64; N]],
    most: &MotionLimits<N>,
    pause: f64,
    start: f64,
) {
    for t in [f64::MIN, start - 1.0, start] {
        assert_eq!(path.at(t), Setpoint::at_rest(poses[0].into()));
    }
    let end = path.end();
    for t in [end, end + 1.0, f64::MAX] {
        assert_eq!(path.at(t), Setpoint::at_rest(poses[poses.len() - 1].into()), "{t} {end}");
    }
    let arrivals: Vec<f64> = path.arrivals().collect();
    for (k, (pose, &t)) in poses.iter().zip(&arrivals).enumerate() {
        let rests = if k == 0 || k == poses.len() - 1 { 0.0 } else { pause };
        for t in [t, t + 0.5 * rests, t + rests] {
            let at = path.at(t);
            let spread = pose.iter().fold(1.0, |most: f64, q| most.max(q.abs()));
            // Times are sums: a few last bits of them may be missing to the arrival.
            assert!((at.q - nalgebra::SVector::from(*pose)).amax() < 1e-12 * spread);
            assert!(at.dq.amax() < 1e-9 * most.velocity.iter().fold(0.0, |a: f64, b| a.max(*b)));
        }
        if rests > 0.0 {
            let middle = path.at(t + 0.5 * rests);
            assert_eq!(middle, Setpoint::at_rest((*pose).into()));
        }
    }
    within_limits(path, most, start, end);
}

fn within_limits<const N: usize>(
    path: &Waypoints<N>,
    most: &MotionLimits<N>,
    start: f64,
    end: f64,
) {
    let steps = 4000;
    let h = (end - start) / f64::from(steps);
    let mut before = path.at(start);
    for k in 1..=steps {
        let at = path.at(start + h * f64::from(k));
        for i in 0..N {
            assert!(at.dq[i].abs() <= KEPT * most.velocity[i]);
            assert!(at.ddq[i].abs() <= KEPT * most.acceleration[i]);
            // Means over the step: of the jerk no more than its limit, and derivatives one of
            // another.
            let rounding = 1e-13 * (end.abs() + 1.0) / h;
            let jerk = (at.ddq[i] - before.ddq[i]).abs() / h;
            assert!(jerk <= most.jerk[i] * KEPT + rounding * most.acceleration[i], "{jerk}");
            let (mean_dq, mean_ddq) =
                (0.5 * (at.dq + before.dq)[i], 0.5 * (at.ddq + before.ddq)[i]);
            let dq = (at.q[i] - before.q[i]) / h;
            let off = most.jerk[i] * h * h + rounding * (at.q[i].abs() + 1.0);
            assert!((dq - mean_dq).abs() <= off, "{dq} {mean_dq}");
            let ddq = (at.dq[i] - before.dq[i]) / h;
            let off = most.jerk[i] * h + rounding * most.velocity[i];
            assert!((ddq - mean_ddq).abs() <= off, "{ddq} {mean_ddq}");
        }
        before = at;
    }
}

fn random_path<const N: usize>(seed: u64) {
    let mut random = Random(seed);
    let count = 2 + (seed % 5) as usize;
    let poses: Vec<[f64; N]> =
        (0..count).map(|_| core::array::from_fn(|_| 3.0 * random.next())).collect();
    let mut joints = |low, high| core::array::from_fn(|_| random.decades(low, high));
    let most = MotionLimits {
        velocity: joints(-1.0, 1.0),
        acceleration: joints(-0.5, 1.5),
        jerk: joints(0.0, 3.0),
    };
    let (pause, start) = (random.between(0.0, 2.0), random.between(-5.0, 5.0));
    let path = Waypoints::new(&poses, &most, &[pause], start).unwrap();
    check(&path, &poses, &most, pause, start);
    // In every move some joint is at one of its limits, whatever the phase.
    let arrivals: Vec<f64> = path.arrivals().collect();
    let h = 1e-7 * (arrivals[1] - arrivals[0]);
    for k in 1..40 {
        let t = arrivals[0] + (arrivals[1] - arrivals[0]) * f64::from(k) / 40.0;
        let (at, ahead) = (path.at(t), path.at(t + h));
        let share = |x: f64, limit: f64| x.abs() / limit;
        let used = (0..N).map(|i| {
            let jerk = share((ahead.ddq[i] - at.ddq[i]) / h, most.jerk[i]);
            let rest =
                share(at.dq[i], most.velocity[i]).max(share(at.ddq[i], most.acceleration[i]));
            rest.max(jerk)
        });
        assert!(used.fold(0.0, f64::max) > 0.99, "{seed} {k}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn limits_are_kept_poses_reached_and_derivatives_consistent(seed in any::<u64>()) {
        random_path::<1>(seed);
        random_path::<2>(seed);
        random_path::<3>(seed);
        random_path::<7>(seed);
        random_path::<12>(seed);
    }
}

/// Poses that a computation made the same but for rounding, and moves of any size.
#[test]
fn a_move_may_be_of_any_size() {
    for distance in [5e-17, 1e-30, 1e-12, 1e-6, 1.0, 1e3, 1e6] {
        let path = alone(distance, [1.0, 5.0, 50.0]);
        let end = path.end();
        assert!(path.at(0.5 * end).q[0] > 0.49 * distance, "{distance}");
        assert_eq!(path.at(end).q[0], distance);
        let speed = path.at(0.5 * end).dq[0];
        assert!(speed <= KEPT && speed * end >= KEPT.recip() * distance, "{distance} {speed}");
    }
}

#[test]
fn a_pose_that_is_held_takes_no_time_but_its_pause() {
    let poses = [[0.3, 1.0], [0.3, 1.0], [0.5, 1.0]];
    let still = Waypoints::new(&poses[..2], &limits::<2>(1.0, 1.0, 1.0), &[2.0], 0.5).unwrap();
    assert_eq!((still.duration(), still.at(7.0)), (0.0, Setpoint::at_rest(poses[0].into())));
    let path = Waypoints::new(&poses, &limits::<2>(1.0, 1.0, 1.0), &[2.0], 0.5).unwrap();
    assert_eq!(path.arrivals().take(2).collect::<Vec<_>>(), [0.5, 0.5]);
    assert_eq!(path.at(2.5), Setpoint::at_rest(poses[0].into()));
    assert!(path.at(2.6).dq[0] > 0.0);
}

#[test]
fn pauses_may_differ_from_pose_to_pose() {
    let poses = [[0.0], [1.0], [0.0], [1.0]];
    let most = limits::<1>(2.0, 2.0, 4.0);
    let path = Waypoints::new(&poses, &most, &[0.5, 1.5], 1.0).unwrap();
    let once = alone(1.0, [2.0, 2.0, 4.0]).duration();
    let arrivals: Vec<f64> = path.arrivals().collect();
    for (got, wanted) in arrivals.iter().zip([0.0, once, 2.0 * once + 0.5, 3.0 * once + 2.0]) {
        assert!((got - 1.0 - wanted).abs() < 1e-14);
    }
}

#[test]
fn evaluation_does_not_allocate() {
    let poses = [[0.0; 7], [0.4; 7], [-0.3; 7]];
    let path = Waypoints::new(&poses, &limits::<7>(1.0, 5.0, 50.0), &[0.1], 0.0).unwrap();
    let mut sum = 0.0;
    let calls = calls_during(|| (0..1000).for_each(|k| sum += path.at(f64::from(k) * 1e-3).q[3]));
    assert!(calls == 0 && sum > 0.0);
}

#[test]
fn a_time_that_is_nan_gives_a_setpoint_that_is_nan() {
    let at = alone(1.0, [1.0; 3]).at(f64::NAN);
    assert!(at.q[0].is_nan() && at.dq[0].is_nan() && at.ddq[0].is_nan());
}

type Given = (Vec<[f64; 2]>, MotionLimits<2>, Vec<f64>, f64);

/// The refusal of a valid motion after one `change`.
fn refusal(change: impl Fn(&mut Given)) -> Error {
    let poses = vec![[0.0, 0.0], [1.0, 0.5], [0.2, 0.1], [0.0, 0.3]];
    let mut given: Given = (poses, limits(1.0, 2.0, 3.0), vec![0.5, 0.0], 0.0);
    let make = |(poses, limits, pause, start): &Given| Waypoints::new(poses, limits, pause, *start);
    assert!(make(&given).is_ok());
    change(&mut given);
    make(&given).unwrap_err()
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    for (error, words) in [
        (refusal(|it| it.0.truncate(1)), "poses: got 1, wants at least 2 poses"),
        (refusal(|it| it.0.clear()), "poses: got 0, wants at least 2 poses"),
        (refusal(|it| it.0[2][1] = f64::NAN), "poses[2]: got NaN, wants a finite number"),
        (refusal(|it| it.1.velocity[1] = 0.0), "velocity[1]: got 0, wants a number > 0"),
        (refusal(|it| it.1.acceleration[0] = -2.0), "acceleration[0]: got -2, wants a number > 0"),
        (refusal(|it| it.1.jerk[1] = f64::INFINITY), "jerk[1]: got inf, wants a finite number"),
        (refusal(|it| it.2[1] = -0.1), "pause[1]: got -0.1, wants a number >= 0"),
        (refusal(|it| it.2.push(0.1)), "pause: got 3 entries, wants 2"),
        (refusal(|it| it.3 = f64::NAN), "start_time: got NaN, wants a finite number"),
    ] {
        assert_eq!(error.to_string(), words);
    }
    let many = vec![[0.0; 2]; MAX_POSES + 1];
    let error = refusal(|it| (it.0, it.2) = (many.clone(), vec![0.0]));
    assert!(matches!(error.problem(), Problem::TooMany { limit: MAX_POSES, .. }), "{error}");
}

#[test]
fn a_move_without_an_end_is_refused_by_its_pose() {
    for change in [
        (|it: &mut Given| it.0[2][0] = 1e308) as fn(&mut Given),
        |it| (it.0[1][0], it.0[2][0]) = (-1e308, 1e308),
        |it| it.1.velocity = [1e-320; 2],
    ] {
        let error = refusal(change);
        assert_eq!(error.parameter(), "poses", "{error}");
        assert!(error.index().is_some() && matches!(error.problem(), Problem::OutOfRange { .. }));
    }
}
