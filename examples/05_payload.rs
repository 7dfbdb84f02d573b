//! 05: a Panda carries 2 kg that its controller knows nothing of. A small compensator a joint.
#![allow(clippy::print_stdout, missing_docs)]

use std::{error::Error, ops::ControlFlow::Continue};

use steadyarm::arm::{Inertia, Serial};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::{control::*, math::Matrix, plant::*, reference::Quintic, robot::shipped, sim::*};

const START: [f64; 7] = [0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8];
pub fn main() -> Result<(), Box<dyn Error>> {
    let arm: Serial<7> = shipped("panda")?.arm()?;
    let load = Inertia { mass: 2.0, com: [0.0, 0.0, 0.05].into(), moments: Matrix::<3>::zeros() };
    let plant = Plant::new(arm.with_payload(&load)?, Undisturbed);
    let path = Quintic::new(START, [0.3, -0.3, 0.3, -1.7, 0.3, 1.9, 1.1], 0.0, 2.0)?;
    // What a joint lacks depends on where it should be and how fast it goes: 5 × 5 rules a joint.
    let around = |q| [q - 0.6, q - 0.3, q, q + 0.3, q + 0.6];
    let centers = [START.map(around), [around(0.0); 7]].concat();
    let axes: Vec<_> = centers.iter().map(|c| Axis { centers: c, widths: &[0.2] }).collect();
    let basis = FuzzyBasis::new(Form::PerJoint { joints: 7 }, true, &axes)?;
    let adaptation = Adaptation { gain: [1e4; 7], ..Default::default() };
    let (inputs, q_position, q_velocity) = (Inputs::reference(), [400.0; 7], [40.0; 7]);
    let parameters = FuzzyParameters { inputs, q_position, q_velocity, gamma: 1.0, adaptation };
    let gains = Gains::new([400.0; 7], [40.0; 7])?;
    let compensator = FuzzyCompensator::new(basis, &gains, parameters)?;
    let law = ComputedTorque::new(arm.without_friction(), gains);
    let controller = Controller::new(law, compensator);
    let options =
        Options { duration: 4.0, control_period: Some(1e-3), q0: START, ..Default::default() };
    for (name, learning) in [("learning off", false), ("learning on", true)] {
        let mut state = State::new(controller.compensator.state());
        if !learning {
            controller.settle(&mut state).freeze()
        }
        let run = simulate(&plant, &controller, &mut state, &path, &options, |_| Continue(()))?;
        let e = run.e[4000].map(|e| format!("{:7.3}", 1e3 * e.abs())).join(" ");
        println!("{name:12}   after {:.0} s   |e| = {e} mrad", run.t[4000]);
    }
    Ok(())
}
