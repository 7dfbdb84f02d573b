//! An arm twice as heavy as believed, pushed by a disturbance, stepped at 1 kHz.
#![allow(clippy::print_stdout)]

use steadyarm::control::State;
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::reference::Reference;
use steadyarm::sim::{Motion, hold_torque};

fn main() -> steadyarm::Result<()> {
    const PERIOD: f64 = 1e-3;
    let (plant, reference) = (paper::plant()?, paper::reference()?);
    let controller = paper::controller(paper::CLAIMED)?;
    let mut state = State::new(controller.compensator.state());
    let mut motion = Motion { q: Vector::<2>::zeros(), dq: Vector::<2>::zeros() };
    for tick in 0..20_000 {
        let t = f64::from(tick) * PERIOD;
        let desired = reference.at(t);
        let command = controller.step(&mut state, &motion.q, &motion.dq, &desired, PERIOD)?;
        if tick % 2000 == 0 {
            let error = (motion.q - desired.q).norm();
            println!(
                "t = {t:4.1} s   |e| = {error:.4} rad   tau = {:+.2?} N·m",
                command.tau.as_slice()
            );
        }
        motion = hold_torque(&plant, &motion, &command.tau, t, PERIOD);
    }
    Ok(())
}
