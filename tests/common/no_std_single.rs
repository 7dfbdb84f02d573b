//! Controllers in single precision, as C programs step them: the paper's, and one of a Panda, each
//! with 25 rules a joint that learn.

use steadyarm::Result;
use steadyarm::control::{
    ComputedTorque, Controller, FuzzyCompensator, FuzzyParameters, Gains, Single, SingleState,
    State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::math::Vector;
use steadyarm::paper::{self, Reading};
use steadyarm::reference::Setpoint;

use crate::panda_numbers::panda;

/// Rules of a joint, and room for the state in double precision that a controller is made of.
const RULES: usize = 25;
const ROOM: usize = 8192;

pub struct Stepped<const N: usize> {
    controller: Single<N, RULES>,
    state: SingleState<N, RULES>,
}

pub fn two_link(room: &mut [f64; ROOM]) -> Result<Stepped<2>> {
    let form = Form::PerJoint { joints: 2 };
    let controller = paper::controller(Reading { form, normalized: true, gain: 700.0 })?;
    let mut state = State::new(controller.compensator.state_in(room)?);
    let (controller, state) = Single::of(&controller, &mut state)?;
    Ok(Stepped { controller, state })
}

pub fn of_panda(room: &mut [f64; ROOM]) -> Result<Stepped<7>> {
    let gains = Gains::new([100.0; 7], [20.0; 7])?;
    let axis = Axis { centers: &[-1.0, -0.5, 0.0, 0.5, 1.0], widths: &[0.6] };
    let mut sets = [0.0; 2048];
    let form = Form::PerJoint { joints: 7 };
    let basis = FuzzyBasis::new_in(form, true, &[axis; 14], &mut sets[..])?;
    let learns = FuzzyCompensator::new(basis, &gains, FuzzyParameters::default())?;
    let controller = Controller::new(ComputedTorque::new(panda()?, gains), learns);
    let mut state = State::new(controller.compensator.state_in(room)?);
    let (controller, state) = Single::of(&controller, &mut state)?;
    Ok(Stepped { controller, state })
}

impl<const N: usize> Stepped<N> {
    /// One sample of a millisecond; the arm is to stand still in its middle.
    pub fn step(&mut self, q: [f32; N], dq: [f32; N]) -> Result<[f32; N]> {
        let zero = Vector::<N, f32>::repeat(0.0);
        let desired = Setpoint { q: zero, dq: zero, ddq: zero };
        let tau = self.controller.step(&mut self.state, &q.into(), &dq.into(), &desired, 1e-3)?;
        Ok(tau.into())
    }
}
