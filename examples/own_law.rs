//! A law of one's own beside those of the crate, through the sensors of a real machine: one table.
#![allow(clippy::print_stdout, missing_docs)]

use std::ops::ControlFlow;

use steadyarm::arm::{Arm, TwoLink};
use steadyarm::control::{
    Compensator, ComputedTorque, Controller, Demand, DynamicState, Front, Gains, Law,
    NoCompensation, Sample, State,
};
use steadyarm::effects::{Effects, Sensors, Timing, Velocity};
use steadyarm::laws::{DisturbanceObserver, Integral};
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::sim::{Options, Status, Window, metrics, simulate};

/// Computed torque with the inertia of the desired pose, so that all of the model can be worked out
/// before the motion.
#[derive(Clone, Copy)]
struct Feedforward<A> {
    arm: A,
    gains: Gains<2>,
}

impl<A: Arm<2>> Law<2> for Feedforward<A> {
    fn torque(&self, seen: &Sample<2>, rho_hat: &Vector<2>) -> Demand<2> {
        let Sample { desired, e, de, .. } = seen;
        let Gains { kp, kv } = self.gains;
        let v = Vector::from_fn(|n, _| desired.ddq[n] - kv[n] * de[n] - kp[n] * e[n]);
        let (mass, bias) = self.arm.mass_matrix_and_bias(&desired.q, &desired.dq);
        Demand { model: mass * v + bias, compensation: -(mass * rho_hat), v }
    }

    fn resting_torque(&self, q: &Vector<2>) -> Vector<2> {
        self.arm.gravity(q)
    }
}

/// A line of the table: RMS of e over 20 to 40 s [rad], Σ|Δτ|/s, largest torque [N·m].
fn row<L, C, S>(name: &str, law: L, compensator: C, memory: S) -> steadyarm::Result<()>
where
    L: Law<2>,
    C: Compensator<2, S>,
{
    let effects = Effects {
        sensors: Sensors {
            encoder: [std::f64::consts::TAU / 65536.0; 2],
            velocity: Velocity::Difference(100.0),
            ..Sensors::default()
        },
        timing: Timing { delay: 1, ..Timing::default() },
        ..Effects::default()
    };
    let front =
        Front { hand_over: Some(2.0), velocity_filter: Some(100.0), delay: 1, bumpless: None };
    let controller = Controller::new(law, compensator).with_front(front)?;
    let options = Options { control_period: Some(1e-3), effects, ..Options::default() };
    let (plant, reference) = (paper::plant()?, paper::reference()?);
    let go_on = |_| ControlFlow::Continue(());
    let mut state = State::new(memory);
    let run = simulate(&plant, &controller, &mut state, &reference, &options, go_on)?;
    if run.status != Status::Finished {
        println!("{name:22} {:?}", run.status);
        return Ok(());
    }
    let window = Window { from: 20.0, to: 40.0, band: 0.01 };
    let late = [0, 1].map(|n| metrics(n, &run.t, &run.e, &run.tau, window));
    let [one, two] = late;
    let (one, two) = (one?, two?);
    let peak = run.tau.iter().flatten().fold(0.0, |most: f64, tau| most.max(tau.abs()));
    let (rms, variation) =
        (one.rms_e.hypot(two.rms_e), one.torque_variation + two.torque_variation);
    println!("{name:22} {rms:8.4} {variation:8.0} {peak:8.1}");
    Ok(())
}

pub fn main() -> steadyarm::Result<()> {
    let arm: TwoLink = paper::nominal()?;
    let gains = paper::gains()?;
    println!("controller              RMS rad    N·m/s      N·m");
    row("computed torque", ComputedTorque::new(arm, gains), NoCompensation, ())?;
    row("feed-forward, my own", Feedforward { arm, gains }, NoCompensation, ())?;
    let observer = DisturbanceObserver::new(arm, [50.0; 2])?;
    row("disturbance observer", ComputedTorque::new(arm, gains), observer, DynamicState::new())?;
    row("my own with observer", Feedforward { arm, gains }, observer, DynamicState::new())?;
    let (gains, integral) = Integral::with_bandwidth([12.0; 2])?;
    row("PID", ComputedTorque::new(arm, gains), integral, DynamicState::new())
}
