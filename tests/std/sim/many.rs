//! Many runs have the bits of one at a time: in lanes, in threads, in any order.

use std::array::from_fn;
use std::ops::ControlFlow;

use crate::common::{self, hash};
use nalgebra::Vector3;
use steadyarm::arm::{
    Arm, Inertia, JointFriction, JointKind, Link, Pose, Serial, SerialParameters, TwoLink,
    TwoLinkParameters,
};
use steadyarm::control::{
    Adaptation, Compensator, ComputedTorque, Controller, Front, FuzzyCompensator, FuzzyParameters,
    Gains, Inputs, Law, Limits, NoCompensation, State,
};
use steadyarm::effects::{Effects, Sensors};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::math::{Matrix, Vector};
use steadyarm::paper::{self, Reading};
use steadyarm::plant::{Disturbance, Plant, Undisturbed};
use steadyarm::reference::{Harmonic, Reference, Setpoint, Sines};
use steadyarm::sim::{
    Case, Method, Metrics, Options, Record, Run, Status, Tolerance, Window, simulate, simulate_many,
};

/// Two batches of eight, and some that are left over.
const RUNS: usize = 19;

const ALL: Record = Record::Metrics(Window { from: 0.0, to: f64::INFINITY, band: 0.01 });

/// FNV-1a of the metrics of all runs, as those of `determinism`.
const TWO_LINK: u64 = 0xf795_5f97_99f6_a826;
const CHAIN: u64 = 0x36e5_2edb_86ce_b16f;

fn go_on(_: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn metrics<const N: usize>(runs: &[Run<N>]) -> Vec<u64> {
    let numbers = |m: &Metrics| {
        let Metrics { rms_e, max_abs_e, itae, settling_time, .. } = *m;
        let Metrics { rms_tau, max_abs_tau, torque_variation, .. } = *m;
        [rms_e, max_abs_e, itae, settling_time, rms_tau, max_abs_tau, torque_variation]
    };
    let of_run = |run: &Run<N>| run.metrics.map(|m| m.map(|m| numbers(&m).map(f64::to_bits)));
    runs.iter().flat_map(|run| of_run(run).unwrap().into_iter().flatten()).collect()
}

/// Runs these with 1 and 2 threads, forwards and backwards, and each alone: the same bits and
/// statuses, which are returned.
fn check<const N: usize, A, D, L, C, R, S>(
    cases: &[Case<'_, N, A, D, L, C, R, S>],
    options: &Options<N>,
) -> Vec<Run<N>>
where
    A: Arm<N> + Sync,
    D: Disturbance<N> + Sync,
    L: Law<N> + Sync,
    C: Compensator<N, S> + Sync,
    R: Reference<N> + Sync,
    S: Clone + Sync,
{
    let alone: Vec<Run<N>> = cases
        .iter()
        .map(|&Case { plant, controller, state, reference, q0, dq0, effects }| {
            let options = Options { q0, dq0, effects, ..*options };
            simulate(plant, controller, &mut state.clone(), reference, &options, common::on)
                .unwrap()
        })
        .collect();
    let finished = |runs: Vec<Option<steadyarm::Result<Run<N>>>>| -> Vec<Run<N>> {
        runs.into_iter().map(|run| run.unwrap().unwrap()).collect()
    };
    let same = |runs: &[Run<N>]| {
        assert_eq!(metrics(runs), metrics(&alone));
        assert!(runs.iter().zip(&alone).all(|(run, one)| run.status == one.status));
    };
    for threads in [1, 2] {
        same(&finished(simulate_many(cases, options, threads, go_on)));
    }
    let backwards: Vec<_> = cases.iter().rev().map(again).collect();
    let mut runs = finished(simulate_many(&backwards, options, 1, go_on));
    runs.reverse();
    same(&runs);
    alone
}

/// The same run once more.
fn again<'a, const N: usize, A, D, L, C, R, S>(
    case: &Case<'a, N, A, D, L, C, R, S>,
) -> Case<'a, N, A, D, L, C, R, S> {
    let Case { plant, controller, state, reference, q0, dq0, effects } = *case;
    Case { plant, controller, state, reference, q0, dq0, effects }
}

/// Arms of other masses, some of which weigh something.
fn arms(gravity: f64) -> Vec<TwoLink> {
    let arm = |i: usize| {
        let mass = [6.0 + 0.3 * i as f64, 5.0 + 0.1 * i as f64];
        let parameters = TwoLinkParameters {
            mass,
            length: [0.5; 2],
            inertia: [0.4; 2],
            gravity,
            ..Default::default()
        };
        TwoLink::new(parameters).unwrap()
    };
    (0..RUNS).map(arm).collect()
}

fn starts(i: usize) -> [f64; 2] {
    [0.5 - 0.03 * i as f64, -0.5 + 0.02 * i as f64]
}

fn two_links<C, S>(
    controller: &Controller<2, ComputedTorque<2, TwoLink>, C>,
    state: &State<2, S>,
) -> u64
where
    C: Compensator<2, S> + Sync,
    S: Clone + Sync,
{
    two_links_by(controller, state, &Options { duration: 0.4, record: ALL, ..Options::default() })
}

fn two_links_by<C, S>(
    controller: &Controller<2, ComputedTorque<2, TwoLink>, C>,
    state: &State<2, S>,
    options: &Options<2>,
) -> u64
where
    C: Compensator<2, S> + Sync,
    S: Clone + Sync,
{
    let (reference, disturbance) = (common::reference(), paper::disturbance().unwrap());
    let mut all = Vec::new();
    for gravity in [0.0, 9.81] {
        let plants: Vec<_> =
            arms(gravity).into_iter().map(|arm| Plant::new(arm, disturbance)).collect();
        let (reference, effects) = (&reference, Effects::default());
        let case = |(i, plant)| Case {
            plant,
            controller,
            state,
            reference,
            q0: starts(i),
            dq0: [0.1; 2],
            effects,
        };
        let cases: Vec<_> = plants.iter().enumerate().map(case).collect();
        all.extend(metrics(&check(&cases, options)));
    }
    hash(all.into_iter().map(f64::from_bits))
}

fn fuzzy(form: Form, gain: f64) -> common::Adaptive {
    paper::controller(Reading { form, normalized: true, gain }).unwrap()
}

#[test]
fn two_link_arms_have_the_bits_of_one_at_a_time() {
    two_links(&common::plain(), &State::new(()));
    let controller = fuzzy(Form::Grid, 700.0);
    two_links(&controller, &State::new(controller.compensator.state()));
}

#[test]
fn a_grid_a_joint_learns_with_its_golden_bits() {
    let controller = fuzzy(Form::PerJoint { joints: 2 }, 300.0);
    let found = two_links(&controller, &State::new(controller.compensator.state()));
    assert!(found == TWO_LINK, "TWO_LINK: {found:#018x}");
}

#[test]
fn what_a_grid_learnt_before_and_limits_count() {
    let controller = fuzzy(Form::PerJoint { joints: 2 }, 3000.0);
    let limits = Limits { effort_limit: [9.0, 3.0], ..Limits::default() };
    let controller = controller.with_limits(limits).unwrap();
    let mut state = State::new(controller.compensator.state());
    let weights: Vec<f64> = (0..50).map(|k| (k % 7) as f64 - 3.0).collect();
    controller.compensator.load_weights(controller.settle(&mut state), &weights).unwrap();
    two_links(&controller, &state);
}

/// Sampled loops through a hand-over, a filter, limits of rate, a delay that the controller
/// believes in, and rows that do not all count.
#[test]
fn sampled_loops_have_the_bits_of_one_at_a_time() {
    let form = Form::PerJoint { joints: 2 };
    let controller = common::modified(form, false, Inputs::trajectory(), common::everything(70.0));
    let limits = Limits { effort_limit: [12.0; 2], effort_rate_limit: [800.0; 2] };
    let rates = Some(20.0);
    let front = Front { hand_over: rates, velocity_filter: rates, bumpless: rates, delay: 1 };
    let controller = controller.with_limits(limits).unwrap().with_front(front).unwrap();
    let state = State::new(controller.compensator.state());
    for (control_period, record_every) in [(1e-3, 1), (3e-3, 7)] {
        let control_period = Some(control_period);
        let base = Options { duration: 0.3, record: ALL, ..Options::default() };
        two_links_by(&controller, &state, &Options { control_period, record_every, ..base });
        two_links_by(&common::plain(), &State::new(()), &Options { control_period, ..base });
    }
}

/// Raw sets, other inputs, a dead zone: side by side or not, the bits are the same.
#[test]
fn other_bases_inputs_and_laws_have_the_bits_of_one_at_a_time() {
    let form = Form::PerJoint { joints: 2 };
    for (normalized, inputs, law) in [
        (false, Inputs::state(), common::law(40.0)),
        (true, Inputs::trajectory(), common::law(40.0)),
        (true, Inputs::error(), common::everything(70.0)),
        (true, Inputs::error(), Adaptation { leak_rate: 0.3, ..common::law(100.0) }),
    ] {
        let controller = common::modified(form, normalized, inputs, law);
        two_links(&controller, &State::new(controller.compensator.state()));
    }
}

/// One of eight that go side by side diverges, one does not resolve its motion, one is disturbed by
/// what depends on its motion: the others do not notice.
#[test]
fn a_run_that_diverges_ends_alone() {
    let reference = |t: f64| Setpoint::at_rest(Vector::<2>::new(0.1 * t, 0.0));
    let pushed = |strength: f64| {
        move |q: &Vector<2>, dq: &Vector<2>, t: f64| {
            if t > 0.2 { (q + dq) * -strength } else { q * 0.1 }
        }
    };
    let plants: Vec<_> = arms(0.0)
        .into_iter()
        .enumerate()
        .map(|(i, arm)| Plant::new(arm, pushed(if i % 5 == 3 { 3e4 } else { 1.0 })))
        .collect();
    let (controller, state) = (common::plain(), State::new(()));
    let (controller, state, reference, effects) =
        (&controller, &state, &reference, Effects::default());
    let case = |(i, plant)| Case {
        plant,
        controller,
        state,
        reference,
        q0: starts(i),
        dq0: [0.0; 2],
        effects,
    };
    let cases: Vec<_> = plants.iter().enumerate().map(case).collect();
    let options = Options { duration: 0.6, record: ALL, ..Options::default() };
    let runs = check(&cases, &options);
    for (i, run) in runs.iter().enumerate() {
        assert_eq!(run.status == Status::Finished, i % 5 != 3, "{i}: {}", run.status);
    }
}

/// A chain whose third joint slides and whose last one turns without an end.
fn chain(payload: f64, viscous: f64) -> Serial<5> {
    let links = from_fn(|i| {
        let t = i as f64;
        let axis = Vector3::new(0.3 * t.sin(), t.cos(), 0.5).normalize();
        let inertia = Inertia {
            moments: Matrix::<3>::identity() * (0.3 - 0.05 * t),
            ..Inertia::point_mass(4.0 - 0.6 * t + payload, Vector3::new(0.1, 0.05 * t, 0.2))
        };
        let kinds = [JointKind::Revolute, JointKind::Prismatic, JointKind::Continuous];
        let kind = kinds[usize::from(i == 2) + 2 * usize::from(i == 4)];
        let friction = JointFriction { viscous, ..JointFriction::default() };
        let place = Pose::at(Vector3::new(0.1, 0.2, 0.3));
        Link { friction, armature: 0.1, ..Link::new(kind, place, axis, inertia) }
    });
    let gravity = [0.0, 0.0, -9.81];
    Serial::new(SerialParameters { links, tip: Pose::IDENTITY, gravity }).unwrap()
}

/// A basis of a joint's error over sets of other distances.
fn per_joint<const N: usize>(gains: &Gains<N>) -> FuzzyCompensator<N> {
    let axes: Vec<_> = (0..2 * N)
        .map(|_| Axis { centers: &[-1.0, -0.4, 0.0, 0.6, 1.0], widths: &[0.5] })
        .collect();
    let basis = FuzzyBasis::new(Form::PerJoint { joints: N }, true, &axes).unwrap();
    let adaptation = Adaptation { gain: [60.0; N], ..Adaptation::default() };
    let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
    FuzzyCompensator::new(basis, gains, parameters).unwrap()
}

fn chains<C, S>(compensator: C, state: S, viscous: f64, options: &Options<5>) -> u64
where
    C: Compensator<5, S> + Sync,
    S: Clone + Sync,
{
    let plants: Vec<_> =
        (0..RUNS).map(|i| Plant::new(chain(0.05 * i as f64, viscous), Undisturbed)).collect();
    let law = ComputedTorque::new(chain(0.0, 0.0), Gains::new([60.0; 5], [15.0; 5]).unwrap());
    let controller = Controller::new(law, compensator);
    let wave = Harmonic { frequency: 2.0, sin: [0.2, -0.1, 0.05, 0.3, 1.0], cos: [0.1; 5] };
    let reference = Sines::new([0.1, -0.4, 0.2, 0.0, 3.0], [wave]).unwrap();
    let q0 = |i: usize| from_fn(|n| 0.1 * n as f64 - 0.01 * i as f64);
    let (controller, state, reference, effects) =
        (&controller, &State::new(state), &reference, options.effects);
    let case = |(i, plant)| Case {
        plant,
        controller,
        state,
        reference,
        q0: q0(i),
        dq0: [0.0; 5],
        effects,
    };
    let cases: Vec<_> = plants.iter().enumerate().map(case).collect();
    hash(metrics(&check(&cases, options)).into_iter().map(f64::from_bits))
}

#[test]
fn chains_learn_with_their_golden_bits() {
    let options = Options { duration: 0.3, record: ALL, ..Options::default() };
    chains(NoCompensation, (), 0.0, &options);
    let gains = Gains::new([60.0; 5], [15.0; 5]).unwrap();
    let compensator = per_joint(&gains);
    let state = compensator.state();
    let found = chains(compensator, state, 0.0, &options);
    assert!(found == CHAIN, "CHAIN: {found:#018x}");
}

/// What does not go side by side goes alone: friction, sensors, error control.
#[test]
fn what_goes_alone_has_the_bits_of_one_at_a_time() {
    let sensors = Sensors { noise: [1e-4; 5], ..Sensors::default() };
    let effects = Effects { sensors, seed: 7, ..Effects::default() };
    let base = Options { duration: 0.1, record: ALL, ..Options::default() };
    let sampled = Options { control_period: Some(2e-3), ..base };
    let by_error = Options { method: Method::Dp54(Tolerance::default()), ..base };
    chains(NoCompensation, (), 0.0, &sampled);
    for options in [Options { effects, ..sampled }, by_error] {
        chains(NoCompensation, (), 0.0, &options);
    }
    chains(NoCompensation, (), 3.0, &base);
}

#[test]
fn runs_that_were_not_begun_are_none() {
    let plants: Vec<_> = arms(0.0).into_iter().map(|arm| Plant::new(arm, Undisturbed)).collect();
    let (controller, state, reference) = (common::plain(), State::new(()), common::reference());
    let (controller, state, reference) = (&controller, &state, &reference);
    let effects = Effects::default();
    let case = |(i, plant)| Case {
        plant,
        controller,
        state,
        reference,
        q0: starts(i),
        dq0: [0.0; 2],
        effects,
    };
    let cases: Vec<_> = plants.iter().enumerate().map(case).collect();
    let options = Options { duration: 4000.0, record: ALL, ..Options::default() };
    let runs = simulate_many(&cases, &options, 1, |_| ControlFlow::Break(()));
    let began = runs.iter().flatten();
    assert!(began.clone().count() < RUNS);
    for run in began {
        let status = run.as_ref().unwrap().status;
        assert!(matches!(status, Status::Interrupted { .. }), "{status}");
    }
}

#[test]
fn options_that_make_no_sense_are_refused_run_by_run() {
    let plant = Plant::new(paper::nominal().unwrap(), Undisturbed);
    let (controller, state, reference) = (common::plain(), State::new(()), common::reference());
    let (plant, controller, state, reference) = (&plant, &controller, &state, &reference);
    let case = |dt: f64| Case {
        plant,
        controller,
        state,
        reference,
        q0: [dt, 0.0],
        dq0: [0.0; 2],
        effects: Effects::default(),
    };
    let cases: Vec<_> = (0..8).map(|i| case(if i == 5 { f64::NAN } else { 0.1 })).collect();
    let options = Options { duration: 0.05, record: ALL, ..Options::default() };
    let runs = simulate_many(&cases, &options, 2, go_on);
    for (i, run) in runs.into_iter().enumerate() {
        assert_eq!(run.unwrap().is_err(), i == 5);
    }
}
