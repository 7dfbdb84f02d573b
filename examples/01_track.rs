//! 01: an arm whose model is right follows a path. Computed torque, in continuous time.
#![allow(clippy::print_stdout, missing_docs)]

use std::ops::ControlFlow::Continue;

use steadyarm::arm::{TwoLink, TwoLinkParameters};
use steadyarm::control::{ComputedTorque, Controller, Gains, NoCompensation, State};
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::{Harmonic, Sines};
use steadyarm::sim::{Options, simulate};

pub fn main() -> steadyarm::Result<()> {
    // The paper's arm: two links of 4 kg [kg, m, kg·m²], flat on a table.
    let arm = TwoLink::new(TwoLinkParameters {
        mass: [4.0, 4.0],
        length: [0.5, 0.5],
        inertia: [0.2, 0.2],
        ..Default::default()
    })?;
    // q_d = [0.5 cos t + 0.2 sin 3t, −0.2 sin t − 0.5 cos t] [rad]
    let slow = Harmonic { frequency: 1.0, sin: [0.0, -0.2], cos: [0.5, -0.5] };
    let fast = Harmonic { frequency: 3.0, sin: [0.2, 0.0], cos: [0.0, 0.0] };
    let path = Sines::new([0.0; 2], [slow, fast])?;

    // The error obeys ë + 5.5 ė + 8 e = 0: it dies out, whatever the path.
    let law = ComputedTorque::new(arm, Gains::new([8.0; 2], [5.5; 2])?);
    let controller = Controller::new(law, NoCompensation);
    let (plant, mut state) = (Plant::new(arm, Undisturbed), State::new(()));
    let options = Options { duration: 4.0, ..Default::default() };
    let run = simulate(&plant, &controller, &mut state, &path, &options, |_| Continue(()))?;

    for row in (0..=4000).step_by(1000) {
        let (e, tau) = (run.e[row].map(|e| 1e3 * e), run.tau[row]);
        println!(
            "t = {:.1} s   e = {:+8.3} {:+8.3} mrad   tau = {:+8.4} {:+8.4} N·m",
            run.t[row], e[0], e[1], tau[0], tau[1]
        );
    }
    Ok(())
}
