//! The guard: faults of every kind at every sample, pairs of them, stops, limits that exclude each
//! other.

use std::cell::Cell;

use crate::common::{self, Adaptive, Random};
use steadyarm::arm::TwoLink;
use steadyarm::control::{
    Brake, ComputedTorque, Controller, Demand, Event, FuzzyCompensator, FuzzyParameters,
    FuzzyState, Gains, Guard, GuardParameters, GuardState, Guarded, Inputs, Law, Limits, Sample,
    State,
};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::paper::{self, Reading};
use steadyarm::reference::{Reference, Setpoint};
use steadyarm::sim::{Motion, Options, hold_torque, simulate, simulate_guarded};

const H: f64 = 1e-3;

fn vec2(x: f64, y: f64) -> Vector<2> {
    Vector::from([x, y])
}
const EFFORT: [f64; 2] = [200.0, 100.0];
const RATE: [f64; 2] = [10_000.0, 6000.0];
const POWER: [f64; 2] = [200.0, 100.0];

/// Computed torque that can be made to fail.
struct Fragile {
    law: ComputedTorque<2, TwoLink>,
    broken: Cell<bool>,
}

impl Law<2> for Fragile {
    fn torque(&self, seen: &Sample<2>, rho_hat: &Vector<2>) -> Demand<2> {
        let mut demand = self.law.torque(seen, rho_hat);
        if self.broken.get() {
            demand.model[1] = f64::NAN;
        }
        demand
    }

    fn resting_torque(&self, q: &Vector<2>) -> Vector<2> {
        self.law.resting_torque(q)
    }

    fn inertia_torque(&self, q: &Vector<2>, acceleration: &Vector<2>) -> Vector<2> {
        self.law.inertia_torque(q, acceleration)
    }
}

type Guardian<L = Fragile> = Guard<2, L, FuzzyCompensator<2>>;
type Memory = GuardState<2, FuzzyState<2, Vec<f64>>>;

fn parameters() -> GuardParameters<2> {
    let brake = Brake { bandwidth: [10.0; 2], deceleration: [10.0; 2] };
    GuardParameters {
        position_limits: [[-2.0, 2.0]; 2],
        velocity_limit: [6.0; 2],
        slack: [1e-3; 2],
        effort_limit: EFFORT,
        effort_rate_limit: RATE,
        power_limit: POWER,
        envelope: [1.0; 2],
        ..GuardParameters::new(H, brake)
    }
}

/// A loop that settles within a second, as the paper's gains do not.
fn adaptive() -> Adaptive {
    let (inputs, form) = (Inputs::error(), Form::PerJoint { joints: 2 });
    let reading = Reading { form, normalized: false, gain: 1.0 };
    let basis = paper::basis(reading, inputs.len(2)).unwrap();
    let gains = Gains::new([100.0; 2], [20.0; 2]).unwrap();
    let parameters =
        FuzzyParameters { inputs, adaptation: common::law(70.0), ..FuzzyParameters::default() };
    let compensator = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
    Controller::new(ComputedTorque::new(paper::nominal().unwrap(), gains), compensator)
}

fn guard() -> Guardian {
    let Controller { law, compensator, .. } = adaptive();
    let law = Fragile { law, broken: Cell::new(false) };
    Guard::new(Controller::new(law, compensator), parameters()).unwrap()
}

fn new(guard: &Guardian) -> Memory {
    GuardState::new(State::new(guard.controller.compensator.state()))
}

/// What can go wrong with one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    NotANumber(usize),
    Infinite,
    Huge,
    Spike(f64),
    VelocitySpike,
    Dropped,
    Late(usize),
    Doubled,
    ClockBack,
    ClockNaN,
    Suspended,
    Stuck,
    NoSetpoint,
    SetpointAway,
    BrokenLaw,
    DriveCuts,
    DriveSaysNaN,
    Asked,
}

const FAULTS: [Fault; 20] = [
    Fault::NotANumber(0),
    Fault::NotANumber(1),
    Fault::Infinite,
    Fault::Huge,
    Fault::Spike(1.0),
    Fault::Spike(-0.02),
    Fault::VelocitySpike,
    Fault::Dropped,
    Fault::Late(3),
    Fault::Late(200),
    Fault::Doubled,
    Fault::ClockBack,
    Fault::ClockNaN,
    Fault::Suspended,
    Fault::Stuck,
    Fault::NoSetpoint,
    Fault::SetpointAway,
    Fault::BrokenLaw,
    Fault::DriveCuts,
    Fault::DriveSaysNaN,
];

/// A loop of plant and guard.
struct Rig {
    guard: Guardian,
    memory: Memory,
    motion: Motion<2>,
    k: usize,
    last: Option<Vector<2>>,
}

impl Rig {
    fn new() -> Self {
        let guard = guard();
        let memory = new(&guard);
        let at = common::reference().at(0.0);
        Self { memory, motion: Motion { q: at.q, dq: at.dq }, k: 0, last: None, guard }
    }

    fn desired(&self) -> Setpoint<2> {
        common::reference().at(self.k as f64 * H)
    }

    /// One period, with a fault in it. What leaves the guard is checked here, always.
    fn period(&mut self, fault: Option<Fault>) -> Guarded<2> {
        let (Motion { mut q, mut dq }, mut desired) = (self.motion, self.desired());
        let (mut elapsed, mut applied) = (H, None);
        let cut = vec2(0.5, 0.1);
        match fault {
            Some(Fault::NotANumber(n)) => q[n] = f64::NAN,
            Some(Fault::Infinite) => dq[1] = f64::NEG_INFINITY,
            Some(Fault::Huge) => q[0] = 1e300,
            Some(Fault::Spike(size)) => q[0] += size,
            Some(Fault::VelocitySpike) => dq[0] = 100.0,
            Some(Fault::Late(periods)) => {
                let tau = self.last.unwrap_or_else(Vector::zeros);
                (0..periods).for_each(|_| self.plant(&tau));
                (q, dq, desired) = (self.motion.q, self.motion.dq, self.desired());
                elapsed = (periods + 1) as f64 * H;
            }
            Some(Fault::Doubled) => elapsed = 0.1 * H,
            Some(Fault::ClockBack) => elapsed = -3.0,
            Some(Fault::ClockNaN) => elapsed = f64::NAN,
            Some(Fault::Suspended) => elapsed = 5.0,
            Some(Fault::Stuck) => {
                q = self.memory.guard.last_tau().map_or(q, |_| self.motion.q - self.motion.dq * H)
            }
            Some(Fault::NoSetpoint) => desired.ddq[0] = f64::NAN,
            Some(Fault::SetpointAway) => desired.q[1] += 0.5,
            Some(Fault::DriveCuts) => applied = Some(&cut),
            Some(Fault::DriveSaysNaN) => applied = None,
            _ => {}
        }
        self.guard.controller.law.broken.set(fault == Some(Fault::BrokenLaw));
        let nan = Vector::repeat(f64::NAN);
        if fault == Some(Fault::DriveSaysNaN) {
            applied = Some(&nan);
        }
        let given = match fault {
            Some(Fault::Dropped) => self.guard.missed(&mut self.memory),
            Some(Fault::Asked) => {
                self.guard.stop(&mut self.memory);
                self.guard.step(&mut self.memory, applied, (&q, &dq), &desired, elapsed)
            }
            _ => self.guard.step(&mut self.memory, applied, (&q, &dq), &desired, elapsed),
        };
        self.check(&given, &dq);
        self.last = Some(given.tau);
        if fault != Some(Fault::Doubled) {
            self.plant(&given.tau);
        }
        given
    }

    fn periods(&mut self, range: std::ops::Range<usize>, fault: Option<Fault>) {
        for _ in range {
            self.period(fault);
        }
    }

    fn check(&self, given: &Guarded<2>, dq: &Vector<2>) {
        for n in 0..2 {
            let tau = given.tau[n];
            assert!(tau.is_finite() && tau.abs() <= EFFORT[n], "{given:?}");
            if let Some(last) = &self.last {
                let change = (tau - last[n]).abs();
                assert!(change <= RATE[n] * H * (1.0 + 1e-12), "{change} {given:?}");
                let power = tau * dq[n];
                let used = self.memory.guard.lost() == 0 && !given.events.contains(Event::Early);
                if used && power > POWER[n] * (1.0 + 1e-12) {
                    // The rate excludes it: the guard brakes, at the full rate.
                    assert!(self.memory.guard.stopped().is_some(), "{power} {given:?}");
                    assert!((change - RATE[n] * H).abs() < 1e-9, "{change} {power} {given:?}");
                    assert!(tau.abs() < last[n].abs());
                }
            }
        }
    }

    fn plant(&mut self, tau: &Vector<2>) {
        self.motion = hold_torque(&common::plant(), &self.motion, tau, self.k as f64 * H, H);
        self.k += 1;
    }

    fn learnt(&self) -> Vec<u64> {
        let state = common::ended(&self.guard.controller, &self.memory.controller);
        let compensator = &self.guard.controller.compensator;
        let mut weights = vec![0.0; compensator.weights_len()];
        compensator.read_weights(&state, &mut weights).unwrap();
        common::bits(&weights)
    }

    fn error(&self) -> f64 {
        (self.motion.q - self.desired().q).abs().max()
    }
}

/// Refused samples by their event; the others are used.
fn refused(fault: Fault) -> Option<Event> {
    match fault {
        Fault::NotANumber(_) | Fault::Infinite | Fault::Huge | Fault::NoSetpoint => {
            Some(Event::NotFinite)
        }
        Fault::Spike(_) | Fault::VelocitySpike => Some(Event::Jump),
        Fault::Dropped => Some(Event::Missed),
        Fault::Doubled => Some(Event::Early),
        Fault::ClockBack | Fault::ClockNaN | Fault::Suspended => Some(Event::Clock),
        Fault::BrokenLaw => Some(Event::Controller),
        _ => None,
    }
}

#[test]
fn a_fault_of_every_kind_at_every_sample_leaves_a_torque_that_can_be_sent() {
    for fault in FAULTS {
        for at in 1..120 {
            let mut rig = Rig::new();
            rig.periods(0..at, None);
            let before = rig.learnt();
            let given = rig.period(Some(fault));
            if let Some(event) = refused(fault) {
                assert!(given.events.contains(event), "{fault:?} at {at}: {given:?}");
                assert_eq!(given.command, None);
                assert_eq!(rig.memory.guard.count(event), 1);
                if fault != Fault::BrokenLaw {
                    assert_eq!(rig.learnt(), before, "{fault:?} at {at}");
                }
            }
            rig.periods(0..60, None);
        }
    }
}

/// Whatever happened, a second after its end or after rearming the error is that of the loop to
/// which nothing happened, but for what the compensator learnt on the way back, up to 0.9 rad.
#[test]
fn the_loop_recovers_within_a_second() {
    for fault in FAULTS.into_iter().chain([Fault::Asked]) {
        for (at, periods) in [(5, 1), (300, 1), (300, 10), (700, 30), (1100, 60)] {
            if matches!(fault, Fault::Late(200)) && periods > 1 {
                continue;
            }
            let mut rig = Rig::new();
            rig.periods(0..at, None);
            rig.periods(0..periods, Some(fault));
            for _ in 0..1000 {
                rig.period(None);
            }
            if rig.memory.guard.stopped().is_some() {
                assert!(rig.motion.dq.norm() < 0.1, "{fault:?}: {}", rig.motion.dq);
                rig.memory.guard.rearm();
            }
            // The set-point went on while the arm stood still; beyond the envelope there is no
            // rearming.
            if rig.error() > 0.9 {
                continue;
            }
            rig.periods(0..1000, None);
            assert_eq!(rig.memory.guard.stopped(), None, "{fault:?} × {periods} at {at}");
            let mut calm = Rig::new();
            calm.periods(0..rig.k, None);
            let (error, usual) = (rig.error(), calm.error());
            assert!(error < usual + 0.07, "{fault:?} × {periods} at {at}: {error} {usual}");
        }
    }
}

#[test]
fn ten_thousand_pairs_of_faults_leave_torques_that_can_be_sent() {
    let mut random = Random(11);
    let mut pick = |count: usize| (random.bits() % count as u64) as usize;
    for _ in 0..10_000 {
        let faults = [FAULTS[pick(20)], FAULTS[pick(20)]];
        let starts = [pick(60), pick(60)];
        let periods = [1 + pick(30), 1 + pick(30)];
        let mut rig = Rig::new();
        for k in 0..90 {
            let now = (0..2).rev().find(|&i| (starts[i]..starts[i] + periods[i]).contains(&k));
            rig.period(now.map(|i| faults[i]));
        }
    }
}

/// Where nothing happens, a guard changes no bit, and `simulate_guarded` is the loop of the guard.
#[test]
fn a_guard_without_work_is_not_there() {
    let options = Options { duration: 0.5, control_period: Some(2e-3), ..Options::default() };
    let (plant, path) = (common::plant(), common::reference());
    let controller = adaptive();
    let brake = parameters().brake;
    let guard = Guard::new(adaptive(), GuardParameters::new(2e-3, brake)).unwrap();
    let mut bare = State::new(controller.compensator.state());
    let mut state = GuardState::new(bare.clone());
    let on = common::on;
    let alone = simulate(&plant, &controller, &mut bare, &path, &options, on).unwrap();
    let guarded = simulate_guarded(&plant, &guard, &mut state, &path, &options, on).unwrap();
    assert_eq!(guarded.tau, alone.tau);
    assert_eq!(guarded.q, alone.q);
    assert_eq!(controller.save(&state.controller), controller.save(&bare));
    let other = Options { control_period: Some(1e-3), ..options };
    let refused = simulate_guarded(&plant, &guard, &mut state, &path, &other, on).unwrap_err();
    assert_eq!(refused.parameter(), "control_period");
    let continuous = Options { control_period: None, ..options };
    assert!(simulate_guarded(&plant, &guard, &mut state, &path, &continuous, on).is_err());
}

#[test]
fn after_any_history_a_reset_guard_is_a_new_one() {
    let mut rig = Rig::new();
    for (k, fault) in FAULTS.into_iter().enumerate() {
        rig.periods(0..5 + k, None);
        rig.periods(0..k, Some(fault));
    }
    rig.guard.reset(&mut rig.memory);
    let fresh = new(&rig.guard);
    assert_eq!(rig.memory.guard, fresh.guard);
    let save = |memory: &Memory| adaptive().save(&memory.controller);
    assert_eq!(save(&rig.memory), save(&fresh));
}

/// A stop latches: a set-point that is near again does not end it, rearming does.
#[test]
fn a_stop_latches_until_it_is_rearmed() {
    let mut rig = Rig::new();
    rig.periods(0..100, None);
    rig.period(Some(Fault::Asked));
    for _ in 0..500 {
        let given = rig.period(None);
        assert_eq!(given.command, None);
    }
    let cause = rig.memory.guard.stopped().unwrap();
    assert_eq!((cause.event, cause.joint), (Event::Stop, None));
    assert_eq!(rig.memory.guard.count(Event::Stop), 1);
    rig.memory.guard.rearm();
    assert!(rig.period(None).command.is_some());
}

/// A fault that stays is a stop: what the controller refuses for ever, too.
#[test]
fn a_fault_that_stays_stops_the_guard_and_is_its_cause() {
    for fault in FAULTS {
        let Some(event) = refused(fault).filter(|event| *event != Event::Early) else { continue };
        let mut rig = Rig::new();
        rig.periods(0..50, None);
        let (before, patience) = (rig.guard.parameters().hold, rig.guard.parameters().decay);
        rig.periods(0..(before + patience) as usize, Some(fault));
        let sudden = matches!(fault, Fault::Suspended | Fault::Spike(-0.02));
        assert!(sudden || rig.memory.guard.stopped().is_none(), "{fault:?}");
        rig.periods(0..1, Some(fault));
        let stopped = rig.memory.guard.stopped();
        if fault != Fault::Spike(-0.02) {
            assert_eq!(stopped.map(|cause| cause.event), Some(event), "{fault:?}");
        }
    }
}

#[test]
fn what_is_outside_its_limits_stops_the_guard_and_names_the_joint() {
    for (q, dq, event) in [
        ([0.0, 2.1], [0.0, 0.0], Event::Position),
        ([0.0, 0.3], [0.0, -6.5], Event::Velocity),
        ([0.0, 1.2], [0.0, 0.0], Event::Envelope),
    ] {
        let guard = guard();
        let mut memory = new(&guard);
        let (q, dq) = (Vector::from(q), Vector::from(dq));
        let given =
            guard.step(&mut memory, None, (&q, &dq), &Setpoint::at_rest(Vector::zeros()), H);
        assert!(given.events.contains(event));
        let cause = memory.guard.stopped().unwrap();
        assert_eq!((cause.event, cause.joint), (event, Some(1)));
    }
}

/// From a torque that only the rate limit holds up, the power limit cannot be kept at once.
#[test]
fn effort_goes_before_rate_and_rate_before_power() {
    let guard = guard();
    let mut memory = new(&guard);
    memory.guard.take_over(&vec2(300.0, 60.0)).unwrap();
    let (q, dq) = (Vector::zeros(), vec2(0.0, 5.0));
    let given = guard.step(&mut memory, None, (&q, &dq), &Setpoint::at_rest(Vector::zeros()), H);
    // The effort limit at once, beyond what the rate allows; power 54 N·m × 5 rad/s > 100 W.
    assert_eq!(given.tau[0], EFFORT[0] - RATE[0] * H);
    assert_eq!(given.tau[1], 60.0 - RATE[1] * H);
    let cause = memory.guard.stopped().unwrap();
    assert_eq!((cause.event, cause.joint), (Event::Power, Some(1)));
    assert!(given.events.contains(Event::EffortRate) && given.events.contains(Event::Power));
}

/// Without samples: the last torque, then on the way to the one that carries the arm, then a stop.
#[test]
fn missing_samples_hold_then_decay_then_stop() {
    let arm = TwoLink::new(steadyarm::arm::TwoLinkParameters {
        mass: [1.0; 2],
        length: [0.5; 2],
        inertia: [0.05; 2],
        gravity: 9.81,
        ..Default::default()
    })
    .unwrap();
    let law = ComputedTorque::new(arm, paper::gains().unwrap());
    let free = GuardParameters { hold: 3, decay: 4, ..GuardParameters::new(H, parameters().brake) };
    let guard = Guard::new(Controller::new(law, adaptive().compensator), free).unwrap();
    let mut memory = GuardState::new(State::new(guard.controller.compensator.state()));
    let (q, dq) = (vec2(0.3, 0.2), Vector::zeros());
    let desired = Setpoint::at_rest(vec2(0.5, 0.0));
    let first = guard.step(&mut memory, None, (&q, &dq), &desired, H).tau;
    let carrying = guard.controller.law.resting_torque(&q);
    assert!((first - carrying).norm() > 0.1);
    for k in 1..=20 {
        let given = guard.missed(&mut memory);
        let share = ((k as f64 - 3.0) / 4.0).clamp(0.0, 1.0);
        let wanted = first + (carrying - first) * share;
        assert!((given.tau - wanted).norm() < 1e-12, "{k}: {} {wanted}", given.tau);
        assert_eq!(memory.guard.stopped().is_some(), k > 7, "{k}");
    }
    assert_eq!(memory.guard.lost(), 20);
    assert_eq!(memory.guard.count(Event::Missed), 20);
}

#[test]
fn limits_that_make_no_sense_are_refused_by_name() {
    let good = parameters();
    let joint = |error: steadyarm::Error| (error.parameter(), error.index());
    let refused = |parameters| joint(Guard::new(adaptive(), parameters).unwrap_err());
    let wrong = [f64::NAN, 0.0, -1.0];
    for x in wrong {
        let pair = [1.0, x];
        assert_eq!(
            refused(GuardParameters { velocity_limit: pair, ..good }),
            ("velocity_limit", Some(1))
        );
        assert_eq!(
            refused(GuardParameters { effort_limit: pair, ..good }),
            ("effort_limit", Some(1))
        );
        assert_eq!(
            refused(GuardParameters { effort_rate_limit: pair, ..good }),
            ("effort_rate_limit", Some(1))
        );
        assert_eq!(
            refused(GuardParameters { power_limit: pair, ..good }),
            ("power_limit", Some(1))
        );
        assert_eq!(refused(GuardParameters { envelope: pair, ..good }), ("envelope", Some(1)));
        assert_eq!(
            refused(GuardParameters { control_period: x, ..good }),
            ("control_period", None)
        );
        let brake = Brake { deceleration: pair, ..good.brake };
        assert_eq!(refused(GuardParameters { brake, ..good }), ("brake.deceleration", Some(1)));
    }
    let position_limits = [[-1.0, 1.0], [1.0, 1.0]];
    assert_eq!(refused(GuardParameters { position_limits, ..good }), ("position_limits", Some(1)));
    let position_limits = [[f64::NAN, 1.0], [-1.0, 1.0]];
    assert_eq!(refused(GuardParameters { position_limits, ..good }), ("position_limits", Some(0)));
    let slack = [0.0, f64::INFINITY];
    assert_eq!(refused(GuardParameters { slack, ..good }), ("slack", Some(1)));
    let unlimited = GuardParameters { control_period: H, ..GuardParameters::new(H, good.brake) };
    assert!(Guard::new(adaptive(), unlimited).is_ok());
    let controller = adaptive().with_limits(Limits { effort_limit: [1.0; 2], ..Limits::default() });
    assert!(Guard::new(controller.unwrap(), good).is_ok());
}
