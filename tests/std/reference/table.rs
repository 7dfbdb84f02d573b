//! Sampled motions: orders of accuracy, samples met exactly, ends, and the refusals.

use super::*;
use core::f64::consts::TAU;
use steadyarm::reference::Table;

/// q = [sin 2t, cos(t) + t/2] and its derivatives, at each of `times`, as the rows of a table.
fn samples(times: &[f64]) -> [Vec<f64>; 3] {
    let rows = |f: &dyn Fn(f64) -> [f64; 2]| times.iter().flat_map(|&t| f(t)).collect::<Vec<_>>();
    [
        rows(&|t| [sin_cos(2.0 * t).0, sin_cos(t).1 + t / 2.0]),
        rows(&|t| [2.0 * sin_cos(2.0 * t).1, 0.5 - sin_cos(t).0]),
        rows(&|t| [-4.0 * sin_cos(2.0 * t).0, -sin_cos(t).1]),
    ]
}

/// `n` + 1 times from 0 to 4, unevenly but smoothly spaced.
fn times(n: usize) -> Vec<f64> {
    let uneven = |u: f64| 4.0 * (u + 0.08 * sin_cos(TAU * u).0);
    (0..=n).map(|k| if k == n { 4.0 } else { uneven(k as f64 / n as f64) }).collect()
}

fn table(n: usize) -> Table<2, Vec<f64>> {
    let t = times(n);
    let [q, dq, ddq] = samples(&t);
    Table::new(t, q, dq, ddq).unwrap()
}

/// Largest error in q, q̇, q̈ between the samples.
fn errors(table: &Table<2, Vec<f64>>) -> [f64; 3] {
    let mut worst = [0.0_f64; 3];
    for t in (0..2000).map(|k| (f64::from(k) + 0.5) / 500.0) {
        let exact = samples(&[t]);
        let got = table.at(t);
        for (order, value) in [got.q, got.dq, got.ddq].iter().enumerate() {
            let error = (value - Vector::<2>::from_row_slice(&exact[order])).amax();
            worst[order] = worst[order].max(error);
        }
    }
    worst
}

fn assert_orders(build: impl Fn(usize) -> Table<2, Vec<f64>>, orders: [f64; 3]) {
    let (coarse, fine) = (errors(&build(40)), errors(&build(80)));
    for i in 0..3 {
        let order = (coarse[i] / fine[i]).log2();
        assert!((order - orders[i]).abs() < 0.4, "order {order} of derivative {i}: {fine:?}");
    }
}

#[test]
fn table_reproduces_a_smooth_motion_to_order_6_5_4() {
    assert_orders(table, [6.0, 5.0, 4.0]);
}

#[test]
fn table_from_positions_reproduces_a_smooth_motion_to_order_4_3_2() {
    let from_positions = |n| {
        let t = times(n);
        Table::from_positions(&t, &samples(&t)[0]).unwrap()
    };
    assert_orders(from_positions, [4.0, 3.0, 2.0]);
}

#[test]
fn table_from_positions_differentiates_a_cubic_exactly() {
    let t = [0.0, 0.4, 0.5, 1.1, 1.3, 2.0];
    let q = t.map(|t: f64| 1.0 + t * (2.0 + t * (-3.0 + t)));
    let table = Table::<1, _>::from_positions(&t, &q).unwrap();
    for t in t {
        let setpoint = table.at(t);
        assert!((setpoint.dq[0] - (2.0 + t * (-6.0 + 3.0 * t))).abs() < 20.0 * ROUNDING);
        assert!((setpoint.ddq[0] - (-6.0 + 6.0 * t)).abs() < 100.0 * ROUNDING);
    }
}

#[test]
fn table_from_two_or_three_positions_is_a_line_or_a_parabola() {
    let line = Table::<1, _>::from_positions(&[1.0, 3.0], &[0.0, 4.0]).unwrap();
    assert_eq!(line.at(1.5).q[0], 1.0);
    assert_eq!((line.at(1.5).dq[0], line.at(1.5).ddq[0]), (2.0, 0.0));
    let parabola = Table::<1, _>::from_positions(&[0.0, 1.0, 3.0], &[0.0, 1.0, 9.0]).unwrap();
    for t in [0.0, 0.5, 1.0, 2.0, 3.0] {
        assert!((parabola.at(t).q[0] - t * t).abs() < 10.0 * ROUNDING);
        assert!((parabola.at(t).dq[0] - 2.0 * t).abs() < 10.0 * ROUNDING);
        assert!((parabola.at(t).ddq[0] - 2.0).abs() < 20.0 * ROUNDING);
    }
}

#[test]
fn table_hits_its_samples_exactly() {
    let t = times(40);
    let [q, dq, ddq] = samples(&t);
    for (k, &time) in t.iter().enumerate() {
        let row = |data: &[f64]| Vector::<2>::from_row_slice(&data[2 * k..2 * k + 2]);
        assert_eq!(table(40).at(time), Setpoint { q: row(&q), dq: row(&dq), ddq: row(&ddq) });
    }
}

#[test]
fn table_is_continuous_in_all_three_at_its_samples() {
    for &t in &times(40)[1..40] {
        let (before, at) = (table(40).at(t - 1e-10), table(40).at(t));
        // 1e-10 s at a jerk of up to 8 rad/s³, and rounding divided by h² = 1e-3 s².
        for jump in [before.q - at.q, before.dq - at.dq, before.ddq - at.ddq] {
            assert!(jump.amax() < 1e-8, "{before:?} {at:?}");
        }
    }
}

#[test]
fn table_derivatives_agree_with_finite_differences() {
    assert_derivatives(&table(40), &grid(0.1, 3.9));
}

#[test]
fn table_rests_at_its_ends_outside() {
    let [q, ..] = samples(&[0.0, 4.0]);
    assert_eq!(table(40).at(-0.001), Setpoint::at_rest(Vector::<2>::new(q[0], q[1])));
    assert_eq!(table(40).at(4.001), Setpoint::at_rest(Vector::<2>::new(q[2], q[3])));
}

#[test]
fn table_works_on_borrowed_arrays() {
    let rest = [0.0, 0.0];
    let table = Table::<1, &[f64]>::new(&[1.0, 3.0], &[0.0, 1.0], &rest, &rest).unwrap();
    let quintic = Quintic::new([0.0], [1.0], 1.0, 2.0).unwrap();
    for t in grid(0.0, 4.0) {
        let (a, b) = (table.at(t), quintic.at(t));
        assert!((a.q - b.q).amax() < ROUNDING);
        assert!((a.dq - b.dq).amax() < ROUNDING);
        assert!((a.ddq - b.ddq).amax() < 10.0 * ROUNDING);
    }
}

#[test]
fn a_time_that_is_nan_gives_a_setpoint_that_is_nan() {
    assert!(is_nan(&table(40).at(f64::NAN)));
}

/// The refusal of a valid table (t, q, dq, ddq) of three samples of two joints after one `change`.
fn table_refusal(change: impl Fn(&mut [Vec<f64>; 4])) -> Error {
    let mut data = [vec![0.0, 0.5, 1.0], vec![0.1; 6], vec![0.2; 6], vec![0.3; 6]];
    let build = |[t, q, dq, ddq]: [Vec<f64>; 4]| Table::<2, _>::new(t, q, dq, ddq);
    assert!(build(data.clone()).is_ok());
    change(&mut data);
    build(data).unwrap_err()
}

#[test]
fn table_refuses_a_single_sample() {
    let error = table_refusal(|data| data[0].truncate(1));
    assert_eq!(error, out_of_range("t", None, 1.0, "at least 2 samples"));
}

#[test]
fn table_refuses_a_time_that_does_not_increase() {
    let error = table_refusal(|data| data[0][2] = 0.5);
    assert_eq!(error, out_of_range("t", Some(2), 0.5, "a later time than the one before"));
}

#[test]
fn table_refuses_an_infinite_time() {
    assert_eq!(table_refusal(|data| data[0][2] = INFINITY), not_finite("t", Some(2)));
}

#[test]
fn table_refuses_a_step_of_no_length() {
    let error = table_refusal(|data| data[0][1] = 1e-200);
    let wanted = "a step whose velocity and acceleration are finite";
    assert_eq!(error, out_of_range("t", Some(1), 1e-200, wanted));
}

#[test]
fn table_refuses_rows_of_the_wrong_length() {
    for (i, parameter) in [(1, "q"), (2, "dq"), (3, "ddq")] {
        let error = table_refusal(|data| data[i].truncate(4));
        assert_eq!(error, Error::wrong_length(parameter, 4, 6));
    }
}

#[test]
fn table_refuses_rows_that_are_infinite() {
    for (i, parameter) in [(1, "q"), (2, "dq"), (3, "ddq")] {
        assert_eq!(table_refusal(|data| data[i][5] = INFINITY), not_finite(parameter, Some(5)));
    }
}

#[test]
fn table_from_positions_refuses_what_table_refuses() {
    let build = |t: &[f64], q: &[f64]| Table::<1, _>::from_positions(t, q);
    let (t, q) = ([0.0, 1.0, 2.0], [0.0, 1.0, 0.0]);
    assert!(build(&t, &q).is_ok());
    assert_eq!(build(&t, &q[..2]).unwrap_err(), Error::wrong_length("q", 2, 3));
    let wanted = "a later time than the one before";
    let error = build(&[0.0, 2.0, 2.0], &q).unwrap_err();
    assert_eq!(error, out_of_range("t", Some(2), 2.0, wanted));
    let wanted = "a step whose velocity and acceleration are finite";
    for step in [1e-200, 1e-310] {
        let error = build(&[0.0, step, 2.0], &q).unwrap_err();
        assert_eq!(error, out_of_range("t", Some(1), step, wanted));
    }
}

#[test]
fn a_table_with_a_start_is_at_its_first_sample_then() {
    let table = || Table::<1, _>::from_positions(&[5.0, 6.0, 8.0], &[0.5, 1.0, -1.0]).unwrap();
    let late = table().starting_at(2.0).unwrap();
    assert_eq!(late.at(1.9), Setpoint::at_rest([0.5].into()));
    for t in [2.0, 2.25, 3.0, 4.5, 5.0] {
        assert_eq!(late.at(t), table().at(t + 3.0));
    }
    let error = table().starting_at(f64::NAN).unwrap_err();
    assert_eq!(error.to_string(), "start_time: got NaN, wants a finite number");
}
