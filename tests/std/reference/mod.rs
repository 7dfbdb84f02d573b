//! Desired motions: derivatives, end conditions, the paper's reference, and the refusals.

mod table;
mod waypoints;

use steadyarm::Error;
use steadyarm::math::{Vector, sin_cos};
use steadyarm::reference::{Harmonic, Quintic, Reference, Setpoint, Sines};

/// Rounding of a few operations on numbers of size 1.
const ROUNDING: f64 = 1e-14;
/// Central differences with a step of 1e-5 on motions whose third derivative stays below 1000.
const DIFFERENCE: f64 = 1e-6;
const STEP: f64 = 1e-5;

fn paper() -> Sines<2, [Harmonic<2>; 2]> {
    let slow = Harmonic { frequency: 1.0, sin: [0.0, -0.2], cos: [0.5, -0.5] };
    let fast = Harmonic { frequency: 3.0, sin: [0.2, 0.0], cos: [0.0; 2] };
    Sines::new([0.0; 2], [slow, fast]).unwrap()
}

fn assert_close(got: &Setpoint<2>, q: [f64; 2], dq: [f64; 2], ddq: [f64; 2]) {
    assert!((got.q - Vector::from(q)).amax() < ROUNDING, "{got:?}");
    assert!((got.dq - Vector::from(dq)).amax() < ROUNDING, "{got:?}");
    assert!((got.ddq - Vector::from(ddq)).amax() < ROUNDING, "{got:?}");
}

fn assert_derivatives<const N: usize>(reference: &impl Reference<N>, times: &[f64]) {
    for &t in times {
        let (behind, here, ahead) =
            (reference.at(t - STEP), reference.at(t), reference.at(t + STEP));
        let dq = (ahead.q - behind.q) / (2.0 * STEP);
        let ddq = (ahead.dq - behind.dq) / (2.0 * STEP);
        assert!((dq - here.dq).amax() < DIFFERENCE, "t = {t}: {dq} {here:?}");
        assert!((ddq - here.ddq).amax() < DIFFERENCE, "t = {t}: {ddq} {here:?}");
    }
}

fn grid(from: f64, to: f64) -> Vec<f64> {
    (0..200).map(|k| from + (to - from) * (f64::from(k) + 0.37) / 200.0).collect()
}

fn is_nan<const N: usize>(setpoint: &Setpoint<N>) -> bool {
    [setpoint.q, setpoint.dq, setpoint.ddq].iter().all(|v| v.iter().all(|x| x.is_nan()))
}

#[test]
fn a_closure_is_a_reference() {
    let still = |_: f64| Setpoint::at_rest(Vector::<2>::new(0.1, 0.2));
    assert_close(&still.at(3.0), [0.1, 0.2], [0.0; 2], [0.0; 2]);
}

#[test]
fn paper_reference_has_the_paper_values() {
    assert_close(&paper().at(0.0), [0.5, -0.5], [0.6, -0.2], [-0.5, 0.5]);
    assert_close(
        &paper().at(0.8),
        [0.483_445_990_783_812_8, -0.491_824_572_853_487_24],
        [-0.801_114_274_774_508_8, 0.219_336_703_580_328_3],
        [-1.564_187_079_665_653_8, 0.491_824_572_853_487_24],
    );
    assert_close(
        &paper().at(17.3),
        [0.210_213_502_124_279_2, 0.189_335_482_127_779_23],
        [0.461_680_354_143_176_15, -0.504_134_977_171_234_8],
        [-1.806_966_286_423_928_4, -0.189_335_482_127_779_23],
    );
}

#[test]
fn sines_derivatives_agree_with_finite_differences() {
    assert_derivatives(&paper(), &grid(-10.0, 40.0));
}

#[test]
fn sines_value_is_the_position_bit_for_bit_in_any_container() {
    let harmonic = Harmonic { frequency: 2.0, sin: [0.3], cos: [-0.1] };
    let array = Sines::new([0.7], [harmonic]).unwrap();
    let vec = Sines::new([0.7], vec![harmonic]).unwrap();
    let harmonics = [harmonic];
    let slice = Sines::new([0.7], &harmonics[..]).unwrap();
    for t in grid(-5.0, 5.0) {
        assert_eq!(array.value(t), array.at(t).q);
        assert_eq!(array.at(t), vec.at(t));
        assert_eq!(array.at(t), slice.at(t));
    }
    let constant = Sines::<1, [Harmonic<1>; 0]>::new([0.7], []).unwrap();
    assert_eq!(constant.at(1.0), Setpoint::at_rest(Vector::<1>::new(0.7)));
}

#[test]
fn sines_work_as_the_paper_disturbance() {
    let disturbance =
        Sines::new([0.0; 2], [Harmonic { frequency: 1.0, sin: [1.0, 0.0], cos: [0.0, 1.0] }])
            .unwrap();
    let (s, c) = sin_cos(0.9);
    assert_eq!(disturbance.value(0.9), Vector::<2>::new(s, c));
}

#[test]
fn sines_with_a_start_stand_still_before_it_and_are_no_disturbance_there() {
    let late = paper().starting_at(2.0).unwrap();
    for t in [-1e300, 0.0, 1.999] {
        assert_eq!(late.at(t), Setpoint::at_rest(paper().at(0.0).q));
        assert_eq!(late.value(t), paper().value(0.0));
        assert_eq!(late.disturbance(t), Vector::<2>::zeros());
    }
    for t in [2.0, 2.5, 31.25] {
        assert_eq!(late.at(t), paper().at(t - 2.0));
        assert_eq!(late.disturbance(t), paper().value(t - 2.0));
    }
    let from_zero = paper().starting_at(0.0).unwrap();
    assert_eq!((from_zero.at(0.7), paper().start_time()), (paper().at(0.7), None));
    let error = paper().starting_at(INFINITY).unwrap_err();
    assert_eq!(error, not_finite("start_time", None));
}

fn move_up() -> Quintic<2> {
    Quintic::new([0.2, 1.0], [1.4, -2.0], 3.0, 2.0).unwrap()
}

#[test]
fn quintic_derivatives_agree_with_finite_differences() {
    assert_derivatives(&move_up(), &grid(2.0, 6.0));
}

#[test]
fn quintic_starts_and_ends_at_rest() {
    let near = 1e-9;
    for (t, q) in [(3.0, [0.2, 1.0]), (5.0, [1.4, -2.0])] {
        assert_eq!(move_up().at(t), Setpoint::at_rest(q.into()));
        for side in [t - near, t + near] {
            let setpoint = move_up().at(side);
            assert!((setpoint.q - Vector::from(q)).amax() < ROUNDING);
            assert!(setpoint.dq.amax() < ROUNDING);
            // The jerk is 60 (q₁ − q₀)/T³ = 22.5 rad/s³ at the ends.
            assert!(setpoint.ddq.amax() < 23.0 * near);
        }
    }
}

#[test]
fn quintic_holds_before_and_after() {
    for t in [-1e300, 0.0, 2.999] {
        assert_eq!(move_up().at(t), Setpoint::at_rest(Vector::<2>::new(0.2, 1.0)));
    }
    for t in [5.001, 1e300] {
        assert_eq!(move_up().at(t), Setpoint::at_rest(Vector::<2>::new(1.4, -2.0)));
    }
}

#[test]
fn quintic_passes_the_middle_at_fifteen_eighths_of_the_mean_speed() {
    let middle = move_up().at(4.0);
    assert_close(&middle, [0.8, -0.5], [0.6 * 1.875, -1.5 * 1.875], [0.0; 2]);
}

#[test]
fn a_time_that_is_nan_gives_a_setpoint_that_is_nan() {
    assert!(is_nan(&paper().at(f64::NAN)));
    assert!(is_nan(&move_up().at(f64::NAN)));
}

const INFINITY: f64 = f64::INFINITY;

fn not_finite(parameter: &'static str, index: Option<usize>) -> Error {
    Error::not_finite(parameter, INFINITY).at(index)
}

/// The refusal of a valid sum of two harmonics over three joints after one `change`.
fn sines_refusal(change: impl Fn(&mut [f64; 3], &mut [Harmonic<3>; 2])) -> Error {
    let mut offset = [0.1; 3];
    let mut harmonics = [Harmonic { frequency: 2.0, sin: [0.3; 3], cos: [0.2; 3] }; 2];
    assert!(Sines::new(offset, harmonics).is_ok());
    change(&mut offset, &mut harmonics);
    Sines::new(offset, harmonics).unwrap_err()
}

#[test]
fn sines_refuse_an_infinite_offset() {
    assert_eq!(sines_refusal(|offset, _| offset[2] = INFINITY), not_finite("offset", Some(2)));
}

#[test]
fn sines_refuse_an_infinite_frequency() {
    let error = sines_refusal(|_, harmonics| harmonics[1].frequency = INFINITY);
    assert_eq!(error, not_finite("harmonics.frequency", Some(1)));
}

#[test]
fn sines_refuse_an_infinite_sine_amplitude() {
    let error = sines_refusal(|_, harmonics| harmonics[1].sin[2] = INFINITY);
    assert_eq!(error, not_finite("harmonics.sin", Some(5)));
}

#[test]
fn sines_refuse_an_infinite_cosine_amplitude() {
    let error = sines_refusal(|_, harmonics| harmonics[0].cos[1] = INFINITY);
    assert_eq!(error, not_finite("harmonics.cos", Some(1)));
}

#[test]
fn sines_refuse_an_acceleration_that_overflows() {
    let error = sines_refusal(|_, harmonics| harmonics[0].frequency = 1e200);
    assert_eq!(error, not_finite("acceleration", Some(0)));
}

fn quintic_refusal(change: impl Fn(&mut [f64; 2], &mut [f64; 2], &mut f64, &mut f64)) -> Error {
    let (mut start, mut goal, mut start_time, mut duration) = ([0.0; 2], [1.0; 2], 0.5, 2.0);
    assert!(Quintic::new(start, goal, start_time, duration).is_ok());
    change(&mut start, &mut goal, &mut start_time, &mut duration);
    Quintic::new(start, goal, start_time, duration).unwrap_err()
}

#[test]
fn quintic_refuses_an_infinite_start() {
    let error = quintic_refusal(|start, _, _, _| start[1] = INFINITY);
    assert_eq!(error, not_finite("start", Some(1)));
}

#[test]
fn quintic_refuses_an_infinite_goal() {
    let error = quintic_refusal(|_, goal, _, _| goal[0] = INFINITY);
    assert_eq!(error, not_finite("goal", Some(0)));
}

#[test]
fn quintic_refuses_an_infinite_start_time() {
    let error = quintic_refusal(|_, _, start_time, _| *start_time = INFINITY);
    assert_eq!(error, not_finite("start_time", None));
}

fn out_of_range(
    parameter: &'static str,
    index: Option<usize>,
    got: f64,
    wanted: &'static str,
) -> Error {
    Error::out_of_range(parameter, got, wanted).at(index)
}

#[test]
fn quintic_refuses_a_duration_of_zero() {
    let error = quintic_refusal(|_, _, _, duration| *duration = 0.0);
    assert_eq!(error, out_of_range("duration", None, 0.0, "a number > 0"));
}

#[test]
fn quintic_refuses_a_duration_of_no_length() {
    let error = quintic_refusal(|_, _, _, duration| *duration = 1e-200);
    let wanted = "a time in which the move needs no infinite acceleration";
    assert_eq!(error, out_of_range("duration", None, 1e-200, wanted));
}
