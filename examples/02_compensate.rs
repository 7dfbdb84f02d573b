//! 02: the arm is twice as heavy as believed, and something pushes. The compensator learns that.
#![allow(clippy::print_stdout, missing_docs)]

use std::ops::ControlFlow::Continue;

use steadyarm::control::{
    Adaptation, ComputedTorque, Controller, FuzzyCompensator, FuzzyParameters, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::paper;
use steadyarm::sim::{Options, Window, metrics, simulate};

pub fn main() -> steadyarm::Result<()> {
    // Links of 4 kg are believed; there are links of 8 kg, pushed with [sin t, cos t] N·m.
    let (believed, plant, path) = (paper::nominal()?, paper::plant()?, paper::reference()?);
    let gains = paper::gains()?;

    // Five sets for each of e₁, e₂, ė₁, ė₂ make 5⁴ = 625 rules.
    let axis = Axis { centers: &[-1.5, -0.5, 0.0, 0.5, 1.5], widths: &[0.5_f64.sqrt()] };
    let basis = FuzzyBasis::new(Form::Grid, false, &[axis; 4])?;
    let adaptation = Adaptation { gain: [7.0; 2], ..Default::default() };
    let parameters = FuzzyParameters { adaptation, ..Default::default() };
    let compensator = FuzzyCompensator::new(basis, &gains, parameters)?;
    let controller = Controller::new(ComputedTorque::new(believed, gains), compensator);

    for (name, learning) in [("learning off", false), ("learning on", true)] {
        let mut state = State::new(controller.compensator.state());
        if !learning {
            controller.settle(&mut state).freeze(); // at zero: computed torque alone
        }
        let options = Options { duration: 20.0, ..Default::default() };
        let run = simulate(&plant, &controller, &mut state, &path, &options, |_| Continue(()))?;
        let window = Window { from: 10.0, to: 20.0, band: 0.01 };
        let joint = |n| metrics(n, &run.t, &run.e, &run.tau, window);
        let rms = [joint(0)?.rms_e, joint(1)?.rms_e];
        println!("{name:12}   RMS of e = {:.4} {:.4} rad", rms[0], rms[1]);
    }
    Ok(())
}
