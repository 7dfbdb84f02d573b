//! The record as named channels: one declaration a signal, and those of a compensator beside them.

use steadyarm::control::{
    Applied, Audit, Channel, Compensator, ComputedTorque, Controller, KernelParameters, Sample,
    Stage, State, Width,
};
use steadyarm::error::Result;
use steadyarm::math::Vector;
use steadyarm::sim::{
    ClosedLoop, MAX_RECORD_BYTES, Method, Motion, Options, Record, Run, Status, Tolerance, simulate,
};
use steadyarm::{Error, Problem, paper};

use crate::common::{self, bits, everything, on};
use crate::kernel::scene::{Kernel, both, fresh};

const DT: f64 = 1e-3;

/// A dictionary so small that atoms are merged and dropped within the run.
fn kernel() -> Kernel {
    let KernelParameters { merge_tolerance, .. } = KernelParameters::default();
    both(true, everything(40.0), 12, merge_tolerance).1
}

fn options() -> Options<2> {
    Options { duration: 0.2, q0: [0.5, -0.5], ..Options::default() }
}

fn run(options: &Options<2>) -> Run<2> {
    let (controller, plant, reference) = (kernel(), common::plant(), common::reference());
    let run = simulate(&plant, &controller, &mut fresh(&controller), &reference, options, on);
    run.unwrap()
}

/// Whoever writes a record to a file, or shows it, finds in it what the fields hold, in this order.
#[test]
fn columns_are_the_fields_by_name() {
    let run = run(&options());
    assert_eq!(run.status, Status::Finished);
    assert_eq!(run.values("t"), Some(&run.t[..]));
    assert_eq!(run.values("tau_compensation"), Some(run.tau_compensation.as_flattened()));
    assert_eq!(run.values("V"), Some(&run.v[..]));
    assert_eq!((run.values("v"), run.values("weights")), (None, None));
    let columns = run.clone().into_columns();
    let names: Vec<_> = columns.iter().map(|column| column.channel.name).collect();
    let common =
        "t q dq q_d dq_d ddq_d e de tau tau_model tau_compensation rho rho_hat weights_norm V";
    assert_eq!(names.join(" "), format!("{common} atoms error_bound"));
    assert_eq!(Run::<2>::channels().count(), 15);
    for column in columns {
        let Channel { name, unit, width, doc } = column.channel;
        assert_eq!(run.values(name), Some(&column.values[..]));
        assert_eq!(column.values.len(), width.of(2) * run.t.len(), "{name}");
        assert!(!unit.is_empty() && !doc.is_empty() && !doc.ends_with('.'), "{name}");
    }
}

/// The dictionary of a loop that a user writes, row by row.
#[test]
fn a_compensators_own_signals_are_those_of_its_state() {
    let (controller, plant, reference) = (kernel(), common::plant(), common::reference());
    let recorded = run(&options());
    let (atoms, bound) = (recorded.values("atoms"), recorded.values("error_bound"));
    let (atoms, bound) = (atoms.unwrap(), bound.unwrap());
    let mut state = controller.compensator.state();
    let mut motion = Motion { q: options().q0.into(), dq: options().dq0.into() };
    let mut system = ClosedLoop::new(&plant, &controller, &reference);
    for k in 0..recorded.t.len() {
        let (t, end) = (k as f64 * DT, (k + 1) as f64 * DT);
        let start = system.start(&mut state, DT, t, &motion);
        assert_eq!(atoms[k], state.atoms() as f64, "{k}");
        assert_eq!(bits(&bound[2 * k..2 * k + 2]), bits(state.error_bound().as_slice()), "{k}");
        motion = system.finish(&mut state, (t, DT, end), &motion, &start).unwrap().motion;
    }
    assert_eq!(atoms[0], 0.0);
    assert!(state.dropped() > 0 && bound[bound.len() - 1] > 0.0);
}

#[test]
fn every_kind_of_run_has_the_rows_of_the_compensator() {
    let dp54 = Method::Dp54(Tolerance { rtol: 1e-6, atol: 1e-8 });
    for (method, control_period) in
        [(Method::Rk4, None), (dp54, None), (Method::Rk4, Some(4e-3)), (dp54, Some(4e-3))]
    {
        let options = Options { method, control_period, record_every: 3, ..options() };
        let run = run(&options);
        assert_eq!(run.values("atoms").unwrap().len(), run.t.len());
        assert_eq!(run.values("error_bound").unwrap().len(), 2 * run.t.len());
        assert!(run.values("atoms").unwrap().iter().any(|&atoms| atoms > 1.0));
        let motion = self::run(&Options { record: Record::Motion, ..options });
        assert_eq!((motion.values("atoms"), motion.values("V")), (Some(&[][..]), Some(&[][..])));
    }
}

/// t, |W|, V, the atoms; twelve vectors and the bound: 8 (4 + 13 · 2) bytes a row.
#[test]
fn a_row_is_as_large_as_its_signals() {
    let (controller, plant, reference) = (kernel(), common::plant(), common::reference());
    let options = Options { duration: 1e5, ..options() };
    let run = simulate(&plant, &controller, &mut fresh(&controller), &reference, &options, on);
    let Problem::RecordTooLarge { row_bytes, limit, .. } = run.unwrap_err().problem() else {
        panic!("it was taken")
    };
    assert_eq!((row_bytes, limit), (240, MAX_RECORD_BYTES));
}

/// A compensator that counts its samples, and names that as it is told.
struct Counting(&'static [Channel]);

impl Compensator<2, f64> for Counting {
    fn estimate(&self, _: &mut f64, _: &Stage<'_>, _: &Sample<2>) -> Vector<2> {
        Vector::zeros()
    }
    fn acted(&self, _: &mut f64, _: usize, _: &Sample<2>, _: &Applied<2>) {}
    fn advance(&self, count: &mut f64, _: &Stage<'_>) -> Result<()> {
        *count += 1.0;
        Ok(())
    }
    fn reset(&self, count: &mut f64) {
        *count = 0.0;
    }
    fn audit(&self, _: &f64, _: usize, _: &Sample<2>) -> Option<Audit<2>> {
        None
    }
    fn channels(&self) -> &'static [Channel] {
        self.0
    }
    fn signals(&self, count: &f64, seen: &Sample<2>, row: &mut [f64]) {
        row[0] = *count;
        row[1..].copy_from_slice(seen.q.as_slice());
    }
}

const COUNT: Channel = Channel { name: "count", unit: "1", width: Width::One, doc: "Samples" };
const SEEN: Channel = Channel { name: "seen", unit: "rad", width: Width::Joints, doc: "Position" };

/// Held torque: the controller's rows are those of its last sample, with the memory that it was
/// decided from: `Counting` counts the periods that have ended.
#[test]
fn rows_between_samples_are_those_of_the_sample() {
    let (plant, reference, options) = (common::plant(), common::reference(), options());
    let (arm, gains) = (paper::nominal().unwrap(), paper::gains().unwrap());
    let controller = Controller::new(ComputedTorque::new(arm, gains), Counting(&[COUNT, SEEN]));
    let options = Options { control_period: Some(4.0 * DT), ..options };
    let mut state = State::new(0.0);
    let run = simulate(&plant, &controller, &mut state, &reference, &options, on).unwrap();
    let (count, seen) = (run.values("count").unwrap(), run.values("seen").unwrap());
    for k in 0..run.t.len() - 1 {
        assert_eq!(count[k], (k / 4) as f64);
        assert_eq!(seen[2 * k..2 * k + 2], run.q[k - k % 4]);
    }
    assert!(run.v.is_empty() && run.weights_norm.is_empty());
}

#[test]
fn two_signals_of_one_name_are_refused() {
    let (plant, reference) = (common::plant(), common::reference());
    let refused = |own: &'static [Channel], at: usize| {
        let (arm, gains) = (paper::nominal().unwrap(), paper::gains().unwrap());
        let controller = Controller::new(ComputedTorque::new(arm, gains), Counting(own));
        let mut state = State::new(0.0);
        let run = simulate(&plant, &controller, &mut state, &reference, &options(), on);
        let wanted = "channels of names that no other signal of the record has";
        let error = Error::out_of_range("channels", at as f64, wanted).at(at);
        assert_eq!(run.unwrap_err(), error);
    };
    const LYAPUNOV: Channel = Channel { name: "V", ..COUNT };
    refused(&[COUNT, SEEN, COUNT], 2);
    refused(&[COUNT, LYAPUNOV], 1);
}

/// Without signals of its own, as without a proof, there is nothing beside the common ones.
#[test]
fn no_compensator_adds_nothing() {
    let (plant, reference) = (common::plant(), common::reference());
    let mut state = State::new(());
    let plain = common::plain();
    let run = simulate(&plant, &plain, &mut state, &reference, &options(), on).unwrap();
    assert!(run.own.is_empty() && run.v.is_empty());
}
