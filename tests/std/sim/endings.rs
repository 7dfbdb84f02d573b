//! Runs that cannot go on, runs that are interrupted, and options that make no sense.

use std::ops::ControlFlow;

use super::identity::flipped;
use crate::common::{self, adaptive, fresh, on, plain, run};
use steadyarm::control::{Limits, State};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::{Reference, Setpoint};
use steadyarm::sim::{
    Cause, MAX_RECORD_BYTES, Method, Options, Record, Run, Status, Tolerance, simulate,
};
use steadyarm::{Error, Problem};

const METHODS: [(Method, Option<f64>); 4] = [
    (Method::Rk4, None),
    (Method::Dp54(Tolerance { rtol: 1e-6, atol: 1e-8 }), None),
    (Method::Rk4, Some(2e-3)),
    (Method::Dp54(Tolerance { rtol: 1e-6, atol: 1e-8 }), Some(2e-3)),
];

fn options((method, control_period): (Method, Option<f64>)) -> Options<2> {
    Options { duration: 2.0, method, control_period, ..Options::default() }
}

/// As many rows of every kind, times that increase, and nothing but finite numbers.
fn assert_whole(run: &Run<2>) {
    let rows = [
        &run.q,
        &run.dq,
        &run.q_d,
        &run.dq_d,
        &run.ddq_d,
        &run.e,
        &run.de,
        &run.tau,
        &run.tau_model,
        &run.tau_compensation,
        &run.rho,
        &run.rho_hat,
    ];
    for rows in rows {
        assert_eq!(rows.len(), run.t.len());
        assert!(rows.iter().flatten().all(|x| x.is_finite()));
    }
    for numbers in [&run.v, &run.weights_norm] {
        assert!(numbers.is_empty() || numbers.len() == run.t.len());
        assert!(numbers.iter().all(|x| x.is_finite()));
    }
    assert!(run.t.windows(2).all(|t| t[0] < t[1]));
    if let Some(c) = run.certificate {
        assert!([c.v_start, c.v_end, c.supplied, c.turnover].iter().all(|x| x.is_finite()));
    }
}

fn assert_stopped(run: &Run<2>, from: f64, to: f64, expected: &[Cause]) {
    assert_whole(run);
    let Status::Diverged { t, cause, .. } = run.status else { panic!("{}", run.status) };
    assert!((from..=to).contains(&t), "stopped at {t}: {cause}");
    assert!(expected.contains(&cause), "{cause:?}");
    assert!(run.t.len() > 900 && run.t[run.t.len() - 1] <= t);
}

#[test]
fn a_run_that_blows_up_ends_with_a_status_and_finite_rows() {
    let run = flipped(&Options { dt: 4e-3, ..Options::default() });
    assert_whole(&run);
    assert!(matches!(run.status, Status::Diverged { cause: Cause::Motion, .. }), "{}", run.status);
    let explosive = adaptive(Form::Concat, false, 1e8);
    for method in METHODS {
        let run = run_of(&explosive, method);
        assert_whole(&run);
    }
}

fn run_of(controller: &common::Adaptive, method: (Method, Option<f64>)) -> Run<2> {
    run(controller, &options(method))
}

#[test]
fn a_reference_that_becomes_nan_stops_the_run_there() {
    let smooth = common::reference();
    for bad in [f64::NAN, f64::INFINITY] {
        for place in 0..3 {
            let reference = |t: f64| {
                let mut desired: Setpoint<2> = smooth.at(t);
                let entries = [&mut desired.q, &mut desired.dq, &mut desired.ddq];
                if t > 1.0 {
                    entries.into_iter().nth(place).unwrap()[1] = bad;
                }
                desired
            };
            for method in METHODS {
                let controller = adaptive(Form::Concat, false, 7.0);
                let mut state = fresh(&controller);
                let options = options(method);
                let plant = common::plant();
                let run =
                    simulate(&plant, &controller, &mut state, &reference, &options, on).unwrap();
                assert_stopped(&run, 0.998, 1.002, &[Cause::Reference]);
            }
        }
    }
}

#[test]
fn a_disturbance_that_becomes_nan_stops_the_run_there() {
    let disturbance = |_: &Vector<2>, _: &Vector<2>, t: f64| {
        Vector::<2>::new(0.0, if t > 1.0 { f64::NAN } else { 0.0 })
    };
    let plant = Plant::new(paper::actual().unwrap(), disturbance);
    for method in METHODS {
        let controller = adaptive(Form::Concat, false, 7.0);
        let mut state = fresh(&controller);
        let (reference, options) = (common::reference(), options(method));
        let run = simulate(&plant, &controller, &mut state, &reference, &options, on).unwrap();
        let causes = [Cause::Motion, Cause::Acceleration, Cause::StepTooShort];
        assert_stopped(&run, 0.998, 1.002, &causes);
    }
}

#[test]
fn an_interrupted_run_keeps_its_rows() {
    let controller = adaptive(Form::Concat, false, 7.0);
    for method in METHODS {
        let whole = run_of(&controller, method);
        let mut state = fresh(&controller);
        let monitor =
            |t: f64| if t < 0.5 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
        let (plant, reference) = (common::plant(), common::reference());
        let options = options(method);
        let run = simulate(&plant, &controller, &mut state, &reference, &options, monitor).unwrap();
        assert_whole(&run);
        let Status::Interrupted { t } = run.status else { panic!("{}", run.status) };
        let rows = run.t.len();
        assert!((0.5..0.8).contains(&t) && (501..800).contains(&rows), "{t} {rows}");
        assert_eq!((&run.t[..], &run.q[..]), (&whole.t[..rows], &whole.q[..rows]));
        assert_eq!((&run.tau[..], &run.rho[..]), (&whole.tau[..rows], &whole.rho[..rows]));
    }
}

fn refusal(change: impl Fn(&mut Options<2>)) -> Error {
    let mut options = Options::default();
    change(&mut options);
    let plant = Plant::new(paper::nominal().unwrap(), Undisturbed);
    let (mut state, reference) = (State::new(()), common::reference());
    let error = simulate(&plant, &plain(), &mut state, &reference, &options, |_| {
        panic!("a run with bad options began")
    });
    assert_eq!(state, State::new(()));
    error.unwrap_err()
}

#[test]
fn every_bad_option_is_refused_by_name() {
    let text = |change: &dyn Fn(&mut Options<2>)| refusal(change).to_string();
    let wanted = "wants a number > 0";
    for bad in [0.0, -1.0] {
        assert_eq!(text(&|o| o.dt = bad), format!("dt: got {bad}, {wanted}"));
        assert_eq!(text(&|o| o.duration = bad), format!("duration: got {bad}, {wanted}"));
        let period = text(&|o| o.control_period = Some(bad));
        assert_eq!(
            period,
            format!("control_period: got {bad}, wants a period between 1e-9 and 1 s")
        );
    }
    for bad in [f64::NAN, f64::INFINITY] {
        let wanted = "wants a finite number";
        assert_eq!(text(&|o| o.dt = bad), format!("dt: got {bad}, {wanted}"));
        assert_eq!(text(&|o| o.duration = bad), format!("duration: got {bad}, {wanted}"));
        assert_eq!(text(&|o| o.q0[1] = bad), format!("q0[1]: got {bad}, {wanted}"));
        assert_eq!(text(&|o| o.dq0[0] = bad), format!("dq0[0]: got {bad}, {wanted}"));
    }
    let whole = "wants a whole number of dt";
    assert_eq!(text(&|o| o.duration = 1.0005), format!("duration: got 1.0005, {whole}"));
    assert_eq!(text(&|o| o.duration = 1e-4), format!("duration: got 0.0001, {whole}"));
    let period = text(&|o| o.control_period = Some(1.5e-3));
    assert_eq!(period, format!("control_period: got 0.0015, {whole}"));
    assert!(text(&|o| o.record_every = 0).starts_with("record_every: got 0, wants"));
    for bad in [0.0, 1.0, 1e-30, f64::NAN] {
        let tolerance = |rtol, atol| Method::Dp54(Tolerance { rtol, atol });
        let rtol = text(&|o| o.method = tolerance(bad, 1e-9));
        assert!(rtol.starts_with("rtol: got "), "{rtol}");
        let atol = text(&|o| o.method = tolerance(1e-9, bad));
        assert!(atol.starts_with("atol: got "), "{atol}");
    }
    for (dt, duration) in [(1e-9, 1.0), (1e-300, 1e300)] {
        let error = refusal(|o| (o.dt, o.duration) = (dt, duration));
        assert!(matches!(error.problem(), Problem::TooMany { .. }), "{error}");
        assert_eq!(error.parameter(), "duration / dt");
    }
    let period = refusal(|o| (o.dt, o.duration, o.control_period) = (1e-9, 0.05, Some(1.0)));
    assert!(matches!(period.problem(), Problem::TooMany { .. }), "{period}");
    assert_eq!(period.parameter(), "control_period / dt");
}

/// A row of all signals holds t, |W|, V and twelve vectors, one of the motion t and two; both ends
/// are rows.
#[test]
fn a_record_too_large_is_refused_with_its_size() {
    for (every, record, rows, row_bytes) in [
        (1, Record::All, 100_000_001, 216),
        (7, Record::All, 14_285_716, 216),
        (1, Record::Motion, 100_000_001, 40),
    ] {
        let error = refusal(|o| (o.duration, o.record_every, o.record) = (1e5, every, record));
        let Problem::RecordTooLarge { every: k, rows: n, row_bytes: bytes, limit, .. } =
            error.problem()
        else {
            panic!("{error}")
        };
        assert_eq!((k, n, bytes, limit), (every, rows, row_bytes, MAX_RECORD_BYTES));
    }
    // The largest that is taken: 2^31 / 40 rows, and one more.
    let last = (MAX_RECORD_BYTES / 40 - 1) as f64 * 1e-3;
    let past = refusal(|o| (o.duration, o.record) = (last + 1e-3, Record::Motion));
    assert!(matches!(past.problem(), Problem::RecordTooLarge { rows: 53_687_092, .. }), "{past}");
    let bounded = |options: &Options<2>| {
        let controller = adaptive(Form::Shared, true, 7.0);
        let (plant, reference, mut state) =
            (common::plant(), common::reference(), fresh(&controller));
        let stop =
            |t: f64| if t > 0.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        simulate(&plant, &controller, &mut state, &reference, options, stop)
    };
    let taken = bounded(&Options { duration: last, record: Record::Motion, ..Options::default() });
    assert!(matches!(taken.unwrap().status, Status::Interrupted { .. }));
}

/// A rate needs a period: there is none in continuous time.
#[test]
fn a_rate_limit_is_refused_in_continuous_time() {
    let limits = Limits { effort_rate_limit: [f64::INFINITY, 500.0], ..Limits::default() };
    let controller = adaptive(Form::Shared, true, 7.0).with_limits(limits).unwrap();
    let (plant, reference, mut state) = (common::plant(), common::reference(), fresh(&controller));
    for method in METHODS {
        let options = options(method);
        let found = simulate(&plant, &controller, &mut state, &reference, &options, on);
        let Err(error) = found else {
            assert!(method.1.is_some());
            continue;
        };
        let name = "effort_rate_limit[1]: got 500, wants no rate limit in continuous time";
        assert!(method.1.is_none() && error.to_string().starts_with(name), "{error}");
    }
}
