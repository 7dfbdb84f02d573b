//! `simulate` is the loop that a user would write with the public step: the same bits.

use crate::common::{
    self, Adaptive, AdaptiveState, adaptive, bits, everything, fresh, learnt, modified, on, weights,
};
use steadyarm::control::{Inputs, Limits};
use steadyarm::error::Error;
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::reference::Reference;
use steadyarm::sim::{
    ClosedLoop, Method, Motion, Options, Record, Run, Status, Tolerance, Window, hold_torque,
    metrics, simulate,
};

const H: f64 = 1e-3;
const STEPS: usize = 2000;

fn options(control_period: Option<f64>) -> Options<2> {
    let (duration, q0, dq0) = (STEPS as f64 * H, [0.4, -0.3], [0.1, 0.2]);
    Options { duration, control_period, q0, dq0, ..Options::default() }
}

fn start() -> Motion<2> {
    Motion { q: options(None).q0.into(), dq: options(None).dq0.into() }
}

/// Every law that a loop can treat differently: plain, all modifications, limits.
fn controllers() -> [Adaptive; 3] {
    let limits = Limits { effort_limit: [6.0; 2], effort_rate_limit: [500.0; 2] };
    [
        adaptive(Form::Grid, false, 7.0),
        modified(Form::PerJoint { joints: 2 }, true, Inputs::trajectory(), everything(70.0)),
        adaptive(Form::Concat, false, 7.0).with_limits(limits).unwrap(),
    ]
}

fn simulated(controller: &Adaptive, options: &Options<2>) -> (Run<2>, AdaptiveState) {
    simulated_with(&common::plant(), controller, options)
}

fn simulated_with(
    plant: &common::PaperPlant,
    controller: &Adaptive,
    options: &Options<2>,
) -> (Run<2>, AdaptiveState) {
    let mut state = fresh(controller);
    let reference = common::reference();
    let run = simulate(plant, controller, &mut state, &reference, options, on).unwrap();
    assert_eq!(run.status, Status::Finished);
    assert_eq!(run.t.len(), STEPS + 1);
    (run, state)
}

fn assert_same_rows(run: &Run<2>, k: usize, motion: &Motion<2>, tau: &Vector<2>) {
    assert_eq!(run.t[k].to_bits(), (k as f64 * H).to_bits());
    assert_eq!(bits(&run.q[k]), bits(motion.q.as_slice()), "q, row {k}");
    assert_eq!(bits(&run.dq[k]), bits(motion.dq.as_slice()), "dq, row {k}");
    assert_eq!(bits(&run.tau[k]), bits(tau.as_slice()), "tau, row {k}");
}

#[test]
fn simulate_equals_manual_sampled_loop_bit_for_bit() {
    let reference = common::reference();
    for controller in controllers() {
        for (hold, drive) in [(1, f64::INFINITY), (5, f64::INFINITY), (1, 4.0), (5, 4.0)] {
            let plant = common::plant().with_effort_limit([drive; 2]).unwrap();
            let period = hold as f64 * H;
            let (run, after) = simulated_with(&plant, &controller, &options(Some(period)));
            let (mut state, mut motion) = (fresh(&controller), start());
            let (mut tau, mut applied) = (Vector::zeros(), None);
            for k in 0..STEPS {
                let t = k as f64 * H;
                if k % hold == 0 {
                    let (q, dq, desired) = (&motion.q, &motion.dq, reference.at(t));
                    let told = applied.as_ref();
                    let command =
                        controller.step_after(&mut state, told, q, dq, &desired, period).unwrap();
                    tau = plant.applied(&command.tau);
                    applied = Some(tau);
                }
                assert_same_rows(&run, k, &motion, &tau);
                motion = hold_torque(&plant, &motion, &tau, t, H);
            }
            assert_same_rows(&run, STEPS, &motion, &tau);
            controller.end_period(&mut state, applied.as_ref()).unwrap();
            assert_eq!(controller.save(&state), controller.save(&after));
            assert_eq!((state.steps, state.last_tau), (after.steps, after.last_tau));
            assert_eq!(bits(&learnt(&controller, &state)), bits(&learnt(&controller, &after)));
        }
    }
}

#[test]
fn simulate_equals_manual_continuous_loop_bit_for_bit() {
    let (plant, reference) = (common::plant(), common::reference());
    for mut controller in controllers() {
        controller.limits.effort_rate_limit = [f64::INFINITY; 2];
        let (run, after) = simulated(&controller, &options(None));
        let (mut state, mut motion) = (controller.compensator.state(), start());
        let mut system = ClosedLoop::new(&plant, &controller, &reference);
        for k in 0..=STEPS {
            let (t, end) = (k as f64 * H, (k + 1) as f64 * H);
            let start = system.start(&mut state, H, t, &motion);
            let evaluation = system.evaluation().unwrap();
            assert_same_rows(&run, k, &motion, &evaluation.applied);
            assert_eq!(bits(&run.rho[k]), bits(evaluation.rho.as_slice()));
            assert_eq!(run.v[k].to_bits(), evaluation.audit.unwrap().value.to_bits());
            if k < STEPS {
                motion = system.finish(&mut state, (t, H, end), &motion, &start).unwrap().motion;
            }
        }
        assert_eq!(bits(&weights(&controller, &state)), bits(&learnt(&controller, &after)));
    }
}

#[test]
fn every_other_row_is_the_same_row() {
    let controller = adaptive(Form::Concat, false, 7.0);
    let tolerance = Tolerance { rtol: 1e-6, atol: 1e-8 };
    for method in [Method::Rk4, Method::Dp54(tolerance)] {
        for control_period in [None, Some(4e-3)] {
            let every = Options { method, ..options(control_period) };
            let (all, _) = simulated(&controller, &every);
            let mut state = fresh(&controller);
            let (plant, reference) = (common::plant(), common::reference());
            let seldom = Options { record_every: 7, ..every };
            let some = simulate(&plant, &controller, &mut state, &reference, &seldom, on).unwrap();
            let kept: Vec<_> = (0..=STEPS).filter(|k| k % 7 == 0 || *k == STEPS).collect();
            assert_eq!(some.t.len(), kept.len());
            for (row, k) in kept.into_iter().enumerate() {
                assert_eq!(
                    (some.t[row], some.q[row], some.tau[row]),
                    (all.t[k], all.q[k], all.tau[k])
                );
                assert_eq!((some.v[row], some.rho[row]), (all.v[k], all.rho[k]));
            }
            assert_eq!(some.certificate, all.certificate);
        }
    }
}

#[test]
fn a_record_of_the_motion_has_the_rows_of_the_whole_record() {
    let controller = adaptive(Form::Grid, false, 7.0);
    let tolerance = Tolerance { rtol: 1e-6, atol: 1e-8 };
    for method in [Method::Rk4, Method::Dp54(tolerance)] {
        for control_period in [None, Some(4e-3)] {
            let all = Options { method, ..options(control_period) };
            let motion = Options { record: Record::Motion, ..all };
            let (all, _) = simulated(&controller, &all);
            let (mut motion, _) = simulated(&controller, &motion);
            assert!(motion.q_d.is_empty() && motion.e.is_empty());
            let window = Window { from: 0.0, to: 1.0, band: 0.01 };
            let refused = metrics(0, &motion.t, &motion.e, &[], window).unwrap_err();
            assert_eq!(refused, Error::wrong_length("e", 0, motion.t.len()));
            motion.add_reference(&common::reference(), &[false; 2]);
            motion.add_reference(&common::reference(), &[false; 2]);
            assert_eq!((&motion.t, &motion.q, &motion.dq), (&all.t, &all.q, &all.dq));
            assert_eq!(
                (&motion.q_d, &motion.dq_d, &motion.ddq_d),
                (&all.q_d, &all.dq_d, &all.ddq_d)
            );
            assert_eq!((&motion.e, &motion.de), (&all.e, &all.de));
            assert_eq!((motion.status, motion.certificate), (all.status, all.certificate));
            assert!(motion.tau.is_empty() && motion.rho.is_empty() && motion.v.is_empty());
        }
    }
}

/// What a row says must agree within the row.
#[test]
fn rows_are_consistent() {
    for control_period in [None, Some(H)] {
        let controller = adaptive(Form::Grid, false, 7.0);
        let (run, _) = simulated(&controller, &options(control_period));
        for k in 0..=STEPS {
            for n in 0..2 {
                assert_eq!(run.e[k][n], run.q[k][n] - run.q_d[k][n]);
                assert_eq!(run.de[k][n], run.dq[k][n] - run.dq_d[k][n]);
                assert_eq!(run.tau[k][n], run.tau_model[k][n] + run.tau_compensation[k][n]);
            }
        }
    }
}
