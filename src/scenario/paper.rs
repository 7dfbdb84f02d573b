//! The paper's simulations as settings: the numbers of [`paper`](crate::paper) under their names.

use super::{
    BasisSettings, CompensatorSettings, ControllerSettings, CurveSettings, Rules, RunSettings,
    Scenario, SinesSettings,
};
use crate::error::Result;
use crate::fuzzy::Form;
use crate::paper::{self, Reading};

impl Scenario {
    /// The third simulation in this reading. The second is without its compensator; the first has
    /// the nominal arm for a plant and no disturbance, too.
    ///
    /// # Errors
    /// None with the paper's numbers.
    pub fn paper(reading: Reading) -> Result<Self> {
        let rules = match reading.form {
            Form::Grid => Rules::Grid,
            Form::Shared => Rules::Shared,
            Form::Concat => Rules::Concat,
            Form::PerJoint { .. } => Rules::PerJoint,
        };
        let basis = BasisSettings::new(rules, paper::CENTERS.into(), paper::WIDTH.into());
        let basis = BasisSettings { normalized: reading.normalized, ..basis };
        let compensator = CompensatorSettings::new(basis);
        let compensator = CompensatorSettings { gain: reading.gain.into(), ..compensator };
        let sines = |sines: SinesSettings| Some(CurveSettings::Sines(sines));
        Ok(Self {
            two_link: Some(paper::nominal()?.parameters().into()),
            plant: Some(paper::actual()?.parameters().into()),
            controller: Some(ControllerSettings::new(&paper::gains()?)),
            compensator: Some(compensator),
            reference: sines((&paper::reference()?).into()),
            disturbance: sines((&paper::disturbance()?).into()).map(Into::into),
            run: Some(RunSettings::default()),
            ..Self::default()
        })
    }
}
