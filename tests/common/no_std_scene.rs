//! The controller that the C program steps, and that the test with std steps beside it.

use steadyarm::Result;
use steadyarm::control::{Buffer, FuzzyState, Limits, State};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::paper::{self, Reading};
use steadyarm::reference::Reference;

/// Room for the weights of 625 rules and two joints, and for the scratch memory.
pub const MEMORY: usize = 4096;

const PERIOD: f64 = 1e-3;

pub struct Tracker<B: Buffer> {
    controller: paper::PaperController,
    reference: paper::PaperSines,
    state: State<2, FuzzyState<2, B>>,
}

pub fn tracker<B: Buffer>(memory: B) -> Result<Tracker<B>> {
    let reading = Reading { form: Form::Grid, normalized: true, gain: 700.0 };
    let limits = Limits { effort_limit: [30.0; 2], effort_rate_limit: [2000.0; 2] };
    let controller = paper::controller(reading)?.with_limits(limits)?;
    let state = State::new(controller.compensator.state_in(memory)?);
    Ok(Tracker { controller, reference: paper::reference()?, state })
}

pub fn step<B: Buffer>(tracker: &mut Tracker<B>, q: [f64; 2], dq: [f64; 2]) -> Result<[f64; 2]> {
    let Tracker { controller, reference, state } = tracker;
    let desired = reference.at(state.steps as f64 * PERIOD);
    let (q, dq) = (Vector::<2>::from(q), Vector::<2>::from(dq));
    Ok(controller.step(state, &q, &dq, &desired, PERIOD)?.tau.into())
}

/// Bytes of controller, basis, state, and of the memory lent to the state.
#[allow(dead_code)]
pub fn sizes<B: Buffer>(tracker: &Tracker<B>) -> [usize; 4] {
    let Tracker { controller, state, .. } = tracker;
    let memory = controller.compensator.buffer_len() * size_of::<f64>();
    let basis = size_of_val(controller.compensator.basis());
    [size_of_val(controller), basis, size_of_val(state), memory]
}
