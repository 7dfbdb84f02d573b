//! 06: what was learnt goes into a file, and another controller goes on with it.
#![allow(clippy::print_stdout, missing_docs)]

use std::{env::temp_dir, error::Error, fs, ops::ControlFlow::Continue, process};

use steadyarm::control::{FuzzyState, State};
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::Reference;
use steadyarm::sim::{Options, Window, metrics, simulate};
use steadyarm::{Result, fuzzy::Form, paper};

pub fn main() -> Result<(), Box<dyn Error>> {
    let reading = paper::Reading { form: Form::Grid, normalized: true, gain: 1000.0 };
    let controller = paper::controller(reading)?;
    let mut learnt = State::new(controller.compensator.state());
    let mut restored = State::new(controller.compensator.state());

    let (plant, path) = (Plant::new(paper::actual()?, Undisturbed), paper::reference()?);
    let start = path.at(0.0);
    let run = |name, state: &mut State<2, FuzzyState<2, Vec<f64>>>, duration| -> Result<()> {
        let (q0, dq0, control_period) = (start.q.into(), start.dq.into(), Some(1e-3));
        let options = Options { duration, control_period, q0, dq0, ..Default::default() };
        let run = simulate(&plant, &controller, state, &path, &options, |_| Continue(()))?;
        let window = Window { from: 0.0, to: 5.0, band: 0.01 };
        let joint = |n| metrics(n, &run.t, &run.e, &run.tau, window);
        let (rms, done) = ([joint(0)?.rms_e, joint(1)?.rms_e], state.steps);
        println!("{name:9} RMS of e = {:.4} {:.4} rad   {done} steps", rms[0], rms[1]);
        Ok(())
    };

    run("new:", &mut learnt, 40.0)?;
    let file = temp_dir().join(format!("learnt_{}.bin", process::id()));
    fs::write(&file, controller.save(&learnt))?;
    controller.restore(&mut restored, &fs::read(&file)?)?;
    fs::remove_file(&file)?;
    run("goes on:", &mut learnt, 5.0)?;
    Ok(run("restored:", &mut restored, 5.0)?)
}
