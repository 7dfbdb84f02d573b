//! The golden values of the paper's simulations.

use std::ops::ControlFlow;

use steadyarm::control::{ComputedTorque, NoCompensation, State};
use steadyarm::fuzzy::Form;
use steadyarm::paper::{self, Reading};
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::sim::{Options, Run, Window, metrics, simulate};

fn figures(run: &Run<2>) -> [f64; 3] {
    let window = Window { from: 20.0 + 1e-9, to: 40.0, band: 1.0 };
    let all = Window { from: 0.0, ..window };
    let rms = |n| metrics(n, &run.t, &run.e, &run.tau, window).unwrap().rms_e;
    [rms(0), rms(1), metrics(0, &run.t, &run.e, &run.tau, all).unwrap().max_abs_tau]
}

fn third(reading: Reading) -> Run<2> {
    let controller = paper::controller(reading).unwrap();
    let mut state = State::new(controller.compensator.state());
    let (plant, reference) = (paper::plant().unwrap(), paper::reference().unwrap());
    let start = std::time::Instant::now();
    let run = simulate(&plant, &controller, &mut state, &reference, &Options::default(), |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    println!(
        "{reading:?} {:?} {:?} {:?}",
        start.elapsed(),
        figures(&run),
        run.certificate.unwrap().residual()
    );
    run
}

#[test]
fn simulation_3_matches_the_golden_values() {
    let table = [
        (Form::Shared, true, 1.0 / 7.0, 0.192160, 0.443569, 15.350),
        (Form::Grid, true, 1.0 / 7.0, 0.192933, 0.447706, 15.350),
        (Form::Shared, true, 7.0, 0.170362, 0.332090, 15.350),
        (Form::Shared, false, 7.0, 0.169970, 0.295614, 15.350),
        (Form::Shared, true, 70.0, 0.064579, 0.107421, 19.551),
        (Form::Shared, false, 70.0, 0.021925, 0.040805, 23.860),
        (Form::Concat, false, 7.0, 0.030918, 0.057160, 23.923),
        (Form::Concat, false, 70.0, 0.003015, 0.006027, 64.278),
        (Form::Grid, true, 7.0, 0.188632, 0.438626, 15.350),
        (Form::Grid, true, 70.0, 0.159819, 0.376522, 15.350),
        (Form::Grid, false, 7.0, 0.010938, 0.021588, 25.302),
    ];
    for (form, normalized, gain, rms1, rms2, tau) in table {
        let run = third(Reading { form, normalized, gain });
        let [a, b, c] = figures(&run);
        println!("{:.1e} {:.1e} {:.1e}", a - rms1, b - rms2, c - tau);
    }
}

#[test]
fn simulations_1_and_2() {
    let reference = paper::reference().unwrap();
    let controller =
        ComputedTorque::new(paper::nominal().unwrap(), paper::gains().unwrap(), NoCompensation);
    let run = simulate(
        &Plant::new(paper::nominal().unwrap(), Undisturbed),
        &controller,
        &mut State::new(()),
        &reference,
        &Options::default(),
        |_| ControlFlow::Continue(()),
    )
    .unwrap();
    println!("{:?}", figures(&run));
    let run = simulate(
        &paper::plant().unwrap(),
        &controller,
        &mut State::new(()),
        &reference,
        &Options::default(),
        |_| ControlFlow::Continue(()),
    )
    .unwrap();
    println!("{:?}", figures(&run));
}
