//! A guarded loop of the five-rule compensator and the plant, with faults drawn at random, that
//! checks every torque and counts what happened. A second after a stop it is rearmed.

use std::fmt::{Display, Formatter, Result};

use crate::common::{self, AdaptiveState, PaperPlant, Random};
use steadyarm::arm::TwoLink;
use steadyarm::control::{
    Brake, ComputedTorque, Controller, Event, FuzzyCompensator, FuzzyParameters, FuzzyState, Gains,
    Guard, GuardParameters, GuardState, Guarded, Inputs, State,
};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::paper::{self, PaperSines, Reading};
use steadyarm::reference::{Reference, Setpoint};
use steadyarm::sim::{Motion, hold_torque};

/// Period of the loop [s].
const H: f64 = 1e-3;
const EFFORT: [f64; 2] = [200.0, 100.0];
const RATE: [f64; 2] = [10_000.0, 6000.0];
const ENVELOPE: f64 = 1.0;
/// What a drive lets through where it cuts [N·m].
const CUT: f64 = 5.0;
/// Periods without a fault after which the loop must track again.
const CALM: u64 = 2000;
/// Periods from a stop to rearming, and to where the arm is carried back to its path.
const REST: u64 = 1000;
const CARRIED: u64 = 20_000;
/// The weights are looked at so often: to read them costs as much as many steps.
const LOOK: u64 = 1 << 16;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    NotANumber,
    Infinite,
    Huge,
    Spike,
    VelocitySpike,
    NoSetpoint,
    Dropped,
    Late,
    Doubled,
    ClockBack,
    ClockNaN,
    Suspended,
    DriveCuts,
    DriveSaysNaN,
}

const FAULTS: [Fault; 14] = [
    Fault::NotANumber,
    Fault::Infinite,
    Fault::Huge,
    Fault::Spike,
    Fault::VelocitySpike,
    Fault::NoSetpoint,
    Fault::Dropped,
    Fault::Late,
    Fault::Doubled,
    Fault::ClockBack,
    Fault::ClockNaN,
    Fault::Suspended,
    Fault::DriveCuts,
    Fault::DriveSaysNaN,
];

/// What one call of the guard is given.
struct Call {
    q: Vector<2>,
    dq: Vector<2>,
    desired: Setpoint<2>,
    elapsed: f64,
    applied: Option<Vector<2>>,
}

/// The loop.
pub struct Soak {
    guard: Guard<2, ComputedTorque<2, TwoLink>, FuzzyCompensator<2>>,
    memory: GuardState<2, FuzzyState<2, Vec<f64>>>,
    plant: PaperPlant,
    reference: PaperSines,
    motion: Motion<2>,
    random: Random,
    /// Calls of the guard, and periods of the plant.
    pub steps: u64,
    periods: u64,
    fault: Option<Fault>,
    /// Calls to the end of the burst of faults, or to the next one.
    left: u64,
    calm: u64,
    stopped: u64,
    sent: Option<Vector<2>>,
    /// What the drive let through of the torque sent last, where it cut.
    cut: Option<Vector<2>>,
    /// Stops, and times that the arm was carried back.
    pub stops: u64,
    pub carried: u64,
    /// Largest error where the loop must track [rad], and the largest norm of W seen.
    pub worst_calm_error: f64,
    pub largest_weights: f64,
    hash: u64,
}

impl Soak {
    pub fn new(seed: u64) -> Self {
        let gains = Gains::new([100.0; 2], [20.0; 2]).unwrap();
        let reading = Reading { form: Form::Shared, normalized: false, gain: 1.0 };
        let basis = paper::basis(reading, Inputs::error().len(2)).unwrap();
        let adaptation = common::law(70.0);
        let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
        let compensator = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
        let law = ComputedTorque::new(paper::nominal().unwrap(), gains);
        let guard = Guard::new(Controller::new(law, compensator), limits()).unwrap();
        let state: AdaptiveState = State::new(guard.controller.compensator.state());
        let reference = common::reference();
        let at = reference.at(0.0);
        Self {
            memory: GuardState::new(state),
            guard,
            plant: common::plant(),
            reference,
            motion: Motion { q: at.q, dq: at.dq },
            random: Random(seed),
            steps: 0,
            periods: 0,
            fault: None,
            left: CALM,
            calm: 0,
            stopped: 0,
            sent: None,
            cut: None,
            stops: 0,
            carried: 0,
            worst_calm_error: 0.0,
            largest_weights: 0.0,
            hash: 0xcbf2_9ce4_8422_2325,
        }
    }

    /// So many calls of the guard more.
    pub fn run(&mut self, steps: u64) {
        for _ in 0..steps {
            self.step();
        }
    }

    pub fn count(&self, event: Event) -> u64 {
        self.memory.guard.count(event)
    }

    fn step(&mut self) {
        self.draw();
        let given = if self.fault == Some(Fault::Dropped) {
            self.guard.missed(&mut self.memory)
        } else {
            let Call { q, dq, desired, elapsed, applied } = self.call();
            let seen = (&q, &dq);
            self.guard.step(&mut self.memory, applied.as_ref(), seen, &desired, elapsed)
        };
        self.check(&given);
        self.cut = (self.fault == Some(Fault::DriveCuts)).then(|| given.tau.map(cut));
        if self.fault != Some(Fault::Doubled) {
            self.hold(&self.cut.unwrap_or(given.tau));
        }
        self.steps += 1;
        self.look_on();
        self.rearm();
    }

    /// Bursts of up to 60 faults, and up to 10 s between them.
    fn draw(&mut self) {
        if self.left == 0 {
            let pick = |random: &mut Random, count: u64| random.bits() % count;
            (self.fault, self.left) = match self.fault {
                None => {
                    let fault = FAULTS[pick(&mut self.random, FAULTS.len() as u64) as usize];
                    let longest = [1, 1, 3, 20, 60][pick(&mut self.random, 5) as usize];
                    (Some(fault), pick(&mut self.random, longest))
                }
                Some(_) => {
                    let longest = [100, 1000, 10_000][pick(&mut self.random, 3) as usize];
                    (None, pick(&mut self.random, longest))
                }
            };
        } else {
            self.left -= 1;
        }
        self.calm = if self.fault.is_none() { self.calm + 1 } else { 0 };
    }

    /// What the guard is given in this period.
    fn call(&mut self) -> Call {
        let mut elapsed = H;
        if self.fault == Some(Fault::Late) {
            let late = 1 + self.random.bits() % 30;
            let tau = self.sent.unwrap_or_else(Vector::zeros);
            (0..late).for_each(|_| self.hold(&tau));
            elapsed = (late + 1) as f64 * H;
        }
        let Motion { mut q, mut dq } = self.motion;
        let (mut desired, mut applied) = (self.desired(), self.cut);
        let n = (self.random.bits() % 2) as usize;
        match self.fault {
            Some(Fault::NotANumber) => q[n] = f64::NAN,
            Some(Fault::Infinite) => dq[n] = f64::NEG_INFINITY,
            Some(Fault::Huge) => q[n] = 1e300,
            Some(Fault::Spike) => q[n] += self.random.within(0.1, 1.0),
            Some(Fault::VelocitySpike) => dq[n] += 100.0,
            Some(Fault::NoSetpoint) => desired.ddq[n] = f64::NAN,
            Some(Fault::Doubled) => elapsed = 0.1 * H,
            Some(Fault::ClockBack) => elapsed = -3.0,
            Some(Fault::ClockNaN) => elapsed = f64::NAN,
            Some(Fault::Suspended) => elapsed = 5.0,
            Some(Fault::DriveSaysNaN) => applied = Some(Vector::repeat(f64::NAN)),
            _ => {}
        }
        Call { q, dq, desired, elapsed, applied }
    }

    /// What leaves the guard is finite and within effort and rate, always.
    fn check(&mut self, given: &Guarded<2>) {
        for n in 0..2 {
            let tau = given.tau[n];
            assert!(tau.is_finite() && tau.abs() <= EFFORT[n], "{}: {given:?}", self.steps);
            if let Some(sent) = &self.sent {
                let most = RATE[n] * H * (1.0 + 1e-12);
                assert!((tau - sent[n]).abs() <= most, "{}: {given:?} {sent}", self.steps);
            }
            self.hash = (self.hash ^ tau.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
            self.hash = self.hash.rotate_left(29);
        }
        self.sent = Some(given.tau);
    }

    /// The plant and the weights are finite, and the error is small where nothing happened.
    fn look_on(&mut self) {
        let Motion { q, dq } = &self.motion;
        assert!(q.iter().chain(dq).all(|x| x.is_finite()), "{}: {q} {dq}", self.steps);
        if self.steps.is_multiple_of(LOOK) {
            let ended = common::ended(&self.guard.controller, &self.memory.controller);
            let compensator = &self.guard.controller.compensator;
            let mut weights = vec![0.0; compensator.weights_len()];
            compensator.read_weights(&ended, &mut weights).unwrap();
            assert!(weights.iter().all(|w| w.is_finite()), "{}: {weights:?}", self.steps);
            let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
            self.largest_weights = self.largest_weights.max(norm);
        }
        if self.calm > CALM && self.stopped == 0 {
            self.worst_calm_error = self.worst_calm_error.max(self.error());
        }
    }

    /// After a stop the arm comes to rest. The guard is rearmed where the set-point comes by; an
    /// arm that stands outside its limits is carried back.
    fn rearm(&mut self) {
        if self.memory.guard.stopped().is_none() {
            self.stopped = 0;
            return;
        }
        self.stops += u64::from(self.stopped == 0);
        self.stopped += 1;
        if self.stopped > CARRIED {
            let at = self.desired();
            self.motion = Motion { q: at.q, dq: at.dq };
            self.carried += 1;
        }
        if self.stopped > REST && self.error() < 0.5 * ENVELOPE {
            self.memory.guard.rearm();
            (self.stopped, self.calm) = (0, 0);
        }
    }

    fn desired(&self) -> Setpoint<2> {
        self.reference.at(self.periods as f64 * H)
    }

    fn error(&self) -> f64 {
        (self.motion.q - self.desired().q).abs().max()
    }

    fn hold(&mut self, tau: &Vector<2>) {
        self.motion = hold_torque(&self.plant, &self.motion, tau, self.periods as f64 * H, H);
        self.periods += 1;
    }
}

impl Display for Soak {
    /// The line of a log.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{} steps, {} periods, hash {:#018x}", self.steps, self.periods, self.hash)?;
        write!(f, ", error {:.2e} rad, |W| {:.2}", self.worst_calm_error, self.largest_weights)?;
        write!(f, ", stops {}, carried back {}", self.stops, self.carried)?;
        Event::ALL.iter().try_for_each(|e| write!(f, ", {} {}", e.name(), self.count(*e)))
    }
}

fn cut(tau: f64) -> f64 {
    tau.clamp(-CUT, CUT)
}

fn limits() -> GuardParameters<2> {
    let brake = Brake { bandwidth: [10.0; 2], deceleration: [10.0; 2] };
    GuardParameters {
        position_limits: [[-2.0, 2.0]; 2],
        velocity_limit: [6.0; 2],
        slack: [1e-3; 2],
        effort_limit: EFFORT,
        effort_rate_limit: RATE,
        power_limit: [200.0, 100.0],
        envelope: [ENVELOPE; 2],
        ..GuardParameters::new(H, brake)
    }
}
