//! The linear model: its poles, its gain against a simulation, and the sampling limits.

use steadyarm::design::{LinearModel, MAX_DELAY};
use steadyarm::riccati::joint;
use steadyarm::{Error, Problem};

/// The paper's joint with the right inertia.
fn model(k_i: f64) -> LinearModel {
    let p = joint(8.0, 5.5, 10.0, 10.0, 1.0).unwrap();
    LinearModel {
        kp: 8.0,
        kv: 5.5,
        p12: p.p12,
        p22: p.p22,
        k_i,
        leak_rate: 0.0,
        inertia_ratio: 1.0,
        velocity_filter: None,
    }
}

const SHARED_700: f64 = 700.0 * 0.42163;
const CONCAT_7: f64 = 7.0 * 8.94112;
const CONCAT_70: f64 = 70.0 * 8.94112;

fn close(got: f64, wanted: f64, tolerance: f64) {
    assert!((got - wanted).abs() <= tolerance * wanted.abs(), "got {got}, wanted {wanted}");
}

#[test]
fn sampling_limits_of_the_right_model_are_the_golden_ones() {
    // Computed torque alone: h k_v = 2 exactly.
    close(model(0.0).max_period(0).unwrap(), 2.0 / 5.5, 1e-12);
    close(model(SHARED_700).max_period(0).unwrap(), 14.487e-3, 1e-4);
    close(model(CONCAT_7).max_period(0).unwrap(), 66.905e-3, 1e-4);
    close(model(CONCAT_70).max_period(0).unwrap(), 6.852e-3, 1e-4);
}

#[test]
fn one_sample_of_delay_roughly_halves_the_limit() {
    for k_i in [0.0, SHARED_700, CONCAT_7, CONCAT_70] {
        let ratio = model(k_i).max_period(1).unwrap() / model(k_i).max_period(0).unwrap();
        assert!((0.4..0.51).contains(&ratio), "{k_i}: {ratio}");
    }
}

#[test]
fn more_delay_never_allows_a_longer_period() {
    let mut before = f64::INFINITY;
    for delay in 0..=MAX_DELAY {
        let period = model(CONCAT_7).max_period(delay).unwrap();
        assert!(period < before);
        before = period;
    }
}

#[test]
fn radius_is_one_at_the_longest_period() {
    for inertia_ratio in [0.3, 0.5, 1.0, 1.5] {
        for delay in [0, 1, 3] {
            let model = LinearModel { inertia_ratio, ..model(CONCAT_7) };
            let period = model.max_period(delay).unwrap();
            close(model.sampled_radius(period, delay).unwrap(), 1.0, 1e-12);
            assert!(model.sampled_radius(0.9 * period, delay).unwrap() < 1.0);
            assert!(model.sampled_radius(1.1 * period, delay).unwrap() > 1.0);
        }
    }
}

#[test]
fn twice_the_inertia_shortens_the_limit_of_the_integrator() {
    let half = LinearModel { inertia_ratio: 0.5, ..model(CONCAT_70) };
    close(half.max_period(0).unwrap(), 6.07e-3, 1e-3);
    let half = LinearModel { inertia_ratio: 0.5, ..model(0.0) };
    close(half.max_period(0).unwrap(), 4.0 / 5.5, 1e-12);
}

#[test]
fn fine_sampling_approaches_the_poles() {
    let model = model(CONCAT_7);
    let slowest = model.poles().unwrap().iter().fold(f64::NEG_INFINITY, |most, z| most.max(z.re));
    let h = 1e-5;
    close(model.sampled_radius(h, 0).unwrap().ln() / h, slowest, 1e-2);
}

/// The sampled loop, written out: the largest |e| late in a run.
fn late_error(model: &LinearModel, h: f64, delay: usize, steps: usize) -> f64 {
    let (mut e, mut de, mut rho, mut late) = (1.0_f64, 0.0, 0.0, 0.0_f64);
    let (mut before, mut filtered) = (e, de);
    let keep = (-model.leak_rate * h).exp();
    let mut under_way = std::collections::VecDeque::from(vec![0.0; delay]);
    for step in 0..steps {
        let mut rate = de;
        if let Some(cut_off) = model.velocity_filter {
            let share = 1.0 - (-std::f64::consts::TAU * cut_off * h).exp();
            filtered += share * ((e - before) / h - filtered);
            (before, rate) = (e, filtered);
        }
        under_way.push_back(-model.kv * rate - model.kp * e - rho);
        let acceleration = model.inertia_ratio * under_way.pop_front().unwrap();
        rho = keep * (rho + h * model.k_i * (model.p12 * e + model.p22 * rate));
        e += h * de + 0.5 * h * h * acceleration;
        de += h * acceleration;
        if step > steps / 2 {
            late = late.max(e.abs());
        }
    }
    late
}

#[test]
fn sampled_loop_decays_below_the_limit_and_grows_above_it() {
    for (delay, leak_rate) in [(0, 0.0), (1, 0.0), (2, 3.0), (5, 0.0), (0, 20.0)] {
        decays_and_grows(LinearModel { inertia_ratio: 0.5, leak_rate, ..model(CONCAT_70) }, delay);
    }
}

fn decays_and_grows(model: LinearModel, delay: usize) {
    let period = model.max_period(delay).unwrap();
    let (below, above) = (0.98 * period, 1.02 * period);
    let steps = |radius: f64| (60.0 / radius.ln().abs()) as usize;
    let radius = model.sampled_radius(below, delay).unwrap();
    assert!(late_error(&model, below, delay, steps(radius)) < 1e-6);
    let radius = model.sampled_radius(above, delay).unwrap();
    assert!(late_error(&model, above, delay, steps(radius)) > 1e6);
}

#[test]
fn sampled_loop_through_a_filter_decays_below_the_limit_and_grows_above_it() {
    for (delay, k_i, leak_rate) in [(0, 0.0, 0.0), (1, CONCAT_7, 0.0), (4, CONCAT_7, 3.0)] {
        for cut_off in [2.5, 30.0, 1e6] {
            let velocity_filter = Some(cut_off);
            let model = LinearModel { leak_rate, velocity_filter, ..model(k_i) };
            decays_and_grows(model, delay);
        }
    }
}

#[test]
fn a_slow_filter_shortens_the_longest_period_and_a_slower_one_leaves_none() {
    let through = |cut_off| LinearModel { velocity_filter: Some(cut_off), ..model(CONCAT_70) };
    let mut before = model(CONCAT_70).max_period(0).unwrap();
    for cut_off in [1e3, 100.0, 50.0] {
        let period = through(cut_off).max_period(0).unwrap();
        assert!(period < before, "{cut_off}: {period}");
        before = period;
    }
    assert!(matches!(
        through(1.0).max_period(0).unwrap_err().problem(),
        Problem::NotHurwitz { .. }
    ));
    // Computed torque alone is slower for it, but stable.
    assert!(LinearModel { k_i: 0.0, ..through(0.1) }.max_period(0).is_ok());
}

/// By Routh if there is a longest period, by the poles if they are on the left.
#[test]
fn there_is_a_longest_period_where_all_poles_are_stable() {
    let (mut stable, mut unstable) = (0, 0);
    for k_i in [3.0, 62.6, 300.0, 626.0, 5000.0] {
        for cut_off in [0.3, 1.0, 3.0, 10.0, 30.0, 100.0] {
            for leak_rate in [0.0, 0.4, 9.0] {
                let velocity_filter = Some(cut_off);
                let model =
                    LinearModel { inertia_ratio: 0.6, leak_rate, velocity_filter, ..model(k_i) };
                let left = model.poles().unwrap().iter().all(|z| z.re < 0.0);
                assert_eq!(model.max_period(0).is_ok(), left, "{model:?}");
                if left { stable += 1 } else { unstable += 1 }
            }
        }
    }
    assert!(stable > 10 && unstable > 10, "{stable} {unstable}");
}

#[test]
fn a_filter_of_a_high_cut_off_is_as_good_as_none() {
    let sharp = LinearModel { velocity_filter: Some(1e6), leak_rate: 0.3, ..model(CONCAT_7) };
    let none = LinearModel { velocity_filter: None, ..sharp };
    close(sharp.gain_at(3.0).unwrap(), none.gain_at(3.0).unwrap(), 1e-6);
    let (mut left, right) = (sharp.poles().unwrap().to_vec(), none.poles().unwrap());
    left.sort_by(|a, b| b.re.total_cmp(&a.re));
    for wanted in &right[..3] {
        assert!(left.iter().any(|z| (z - wanted).norm_sqr() < 1e-8), "{left:?} {right:?}");
    }
    assert_eq!(right[3].re, f64::NEG_INFINITY);
}

#[test]
fn steady_rms_is_that_of_a_fine_simulation() {
    for (leak_rate, velocity_filter) in [(0.0, None), (0.7, None), (15.0, None), (0.7, Some(4.0))] {
        let model =
            LinearModel { inertia_ratio: 0.5, leak_rate, velocity_filter, ..model(CONCAT_7) };
        let (h, omega, amplitude) = (1e-4, 1.3, 2.0);
        let (mut e, mut de, mut rho, mut rate) = (0.0_f64, 0.0, 0.0, 0.0);
        let (mut sum, mut count) = (0.0, 0);
        for tick in 0..600_000 {
            let t = f64::from(tick) * h;
            let disturbance = amplitude * (omega * t).sin();
            rate = match velocity_filter {
                Some(cut_off) => rate + h * std::f64::consts::TAU * cut_off * (de - rate),
                None => de,
            };
            let acceleration = 0.5 * (-model.kv * rate - model.kp * e + disturbance - rho);
            rho += h * (model.k_i * (model.p12 * e + model.p22 * rate) - leak_rate * rho);
            e += h * de + 0.5 * h * h * acceleration;
            de += h * acceleration;
            // The last six periods.
            if t > 60.0 - 6.0 * std::f64::consts::TAU / omega {
                sum += e * e;
                count += 1;
            }
        }
        let predicted = model.steady_rms(amplitude, omega).unwrap();
        close((sum / f64::from(count)).sqrt(), predicted, 1e-3);
    }
}

#[test]
fn a_leak_without_end_leaves_computed_torque_alone() {
    let alone = model(0.0);
    let leaking = LinearModel { leak_rate: 1e9, ..model(CONCAT_70) };
    close(leaking.gain_at(2.0).unwrap(), alone.gain_at(2.0).unwrap(), 1e-5);
    close(leaking.max_period(0).unwrap(), alone.max_period(0).unwrap(), 1e-5);
    // At rest the integrator leaks what it gathers: 1 / (k_p + k_I p12 / λ).
    let slow = LinearModel { leak_rate: 2.0, ..model(CONCAT_7) };
    close(slow.gain_at(0.0).unwrap(), 1.0 / (8.0 + CONCAT_7 * slow.p12 / 2.0), 1e-12);
}

#[test]
fn an_integrator_removes_a_constant_disturbance() {
    assert_eq!(model(CONCAT_7).gain_at(0.0).unwrap(), 0.0);
    assert_eq!(model(0.0).gain_at(0.0).unwrap(), 1.0 / 8.0);
}

#[test]
fn gain_falls_with_the_integral_gain_at_low_frequency() {
    // |e/ρ_d| ≈ ω/(k_I p12)
    let model = model(CONCAT_70);
    close(model.gain_at(0.01).unwrap(), 0.01 / (CONCAT_70 * model.p12), 0.02);
}

#[test]
fn integrator_too_strong_for_the_damping_is_refused() {
    let weak = LinearModel { kv: 0.05, p22: 0.0, ..model(CONCAT_7) };
    let refusal = weak.max_period(0).unwrap_err();
    assert_eq!(refusal.parameter(), "linear model");
    assert!(matches!(refusal.problem(), Problem::NotHurwitz { max_real, .. } if max_real > 0.0));
}

fn out_of_range(error: Error) -> bool {
    matches!(error.problem(), Problem::OutOfRange { .. })
}

#[test]
fn field_out_of_range_is_refused_by_name() {
    let good = model(CONCAT_7);
    for (broken, name) in [
        (LinearModel { kp: 0.0, ..good }, "kp"),
        (LinearModel { kv: -1.0, ..good }, "kv"),
        (LinearModel { p12: -1.0, ..good }, "p12"),
        (LinearModel { p22: -1.0, ..good }, "p22"),
        (LinearModel { k_i: -1.0, ..good }, "k_i"),
        (LinearModel { leak_rate: -1.0, ..good }, "leak_rate"),
        (LinearModel { inertia_ratio: 0.0, ..good }, "inertia_ratio"),
        (LinearModel { velocity_filter: Some(0.0), ..good }, "velocity_filter"),
    ] {
        let named = |e: Error| e.parameter() == name && out_of_range(e);
        assert!(named(broken.poles().unwrap_err()));
        assert!(named(broken.gain_at(1.0).unwrap_err()));
        assert!(named(broken.max_period(0).unwrap_err()));
    }
}

#[test]
fn period_and_delay_out_of_range_are_refused_by_name() {
    let good = model(CONCAT_7);
    let zero = good.sampled_radius(0.0, 0).unwrap_err();
    assert!(zero.parameter() == "control_period" && out_of_range(zero), "{zero}");
    let nan = good.sampled_radius(f64::NAN, 0).unwrap_err();
    assert_eq!(nan.parameter(), "control_period");
    assert!(matches!(nan.problem(), Problem::NotFinite { .. }), "{nan}");
    let too_many = Error::too_many("delay_samples", Some(9), 8);
    assert_eq!(good.sampled_radius(1e-3, 9).unwrap_err(), too_many);
    assert_eq!(good.max_period(9).unwrap_err(), too_many);
    let negative = good.gain_at(-1.0).unwrap_err();
    assert!(negative.parameter() == "omega" && out_of_range(negative), "{negative}");
}
