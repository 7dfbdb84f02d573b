//! 03: your own loop. The controller takes a sample and gives the torque to hold for 1 ms.
#![allow(clippy::print_stdout, missing_docs)]

use steadyarm::control::{Limits, State};
use steadyarm::paper;
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::{Quintic, Reference};
use steadyarm::sim::{Motion, hold_torque};

const PERIOD: f64 = 1e-3; // s

pub fn main() -> steadyarm::Result<()> {
    // The controller of 02, with motors of 20 N·m. Its state is all that changes; you own it.
    let limits = Limits { effort_limit: [20.0; 2], ..Default::default() };
    let controller = paper::controller(paper::CLAIMED)?.with_limits(limits)?;
    let mut state = State::new(controller.compensator.state());
    let path = Quintic::new([0.0, 0.0], [0.8, -0.5], 0.0, 2.0)?;

    // In place of your robot: an arm twice as heavy as believed.
    let robot = Plant::new(paper::actual()?, Undisturbed);
    let mut seen = Motion::<2>::zeros();

    for tick in 0..=4000 {
        let t = f64::from(tick) * PERIOD;
        let desired = path.at(t);
        let tau = controller.step(&mut state, &seen.q, &seen.dq, &desired, PERIOD)?.tau;
        if tick % 500 == 0 {
            let e = 1e3 * (seen.q - desired.q);
            println!(
                "t = {t:.1} s   e = {:+7.3} {:+7.3} mrad   tau = {:+7.4} {:+7.4} N·m",
                e[0], e[1], tau[0], tau[1]
            );
        }
        seen = hold_torque(&robot, &seen, &tau, t, PERIOD);
    }
    Ok(())
}
