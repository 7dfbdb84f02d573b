//! A scenario in TOML: sections with the keys of the settings.

use std::collections::BTreeMap;
use std::fmt::Display;

use serde::{Deserialize, Serialize};

use super::{
    ActualSettings, CompensatorSettings, ControllerSettings, Curve, CurveSettings,
    DisturbanceSettings, EffectsSettings, FrontSettings, LawSettings, MetricsSettings, Push,
    PushSettings, RobotSettings, RunSettings, TwoLinkSettings,
};
use crate::arm::Tip;
use crate::error::Error;
use crate::robot::{ReadError, limited};

/// What a file says; a section that is absent is `None`.
///
/// ```
/// use steadyarm::scenario::Scenario;
///
/// let text = "[reference.sines]\nfrequency = 1.0\nsin = [0.5, -0.2]\n";
/// let scenario = Scenario::from_toml(text)?;
/// assert!(scenario.reference::<2>()?.is_some());
/// assert_eq!(Scenario::from_toml(&scenario.to_toml()?)?, scenario);
/// let error = Scenario::from_toml("[controller]\nkp = [8.0, -8.0]\nkv = 5.5\n").unwrap_err();
/// assert_eq!(error.to_string(), "controller.kp[1]: got -8, wants a number > 0");
/// # Ok::<(), steadyarm::robot::ReadError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// What it is, in a line.
    pub title: Option<String>,
    /// The robot that the controllers believe in.
    pub robot: Option<RobotSettings>,
    /// The two-link arm that the controller believes in.
    pub two_link: Option<TwoLinkSettings>,
    /// The one that is really there.
    pub plant: Option<TwoLinkSettings>,
    /// Gains and limits.
    pub controller: Option<ControllerSettings>,
    /// What is learnt beside the model.
    pub compensator: Option<CompensatorSettings>,
    /// Where the arm should be.
    pub reference: Option<CurveSettings>,
    /// Another motion, on which what was learnt is tried.
    pub transfer: Option<CurveSettings>,
    /// The torque that nobody asked for: `[disturbance.noise]`, or a list `[[disturbance]]` of
    /// such sections, which add up.
    pub disturbance: Option<DisturbanceSettings>,
    /// How it is simulated.
    pub run: Option<RunSettings>,
    /// What is different on the arm that is really there.
    pub actual: Option<ActualSettings>,
    /// What stands between controller and arm.
    pub effects: Option<EffectsSettings>,
    /// What stands before every law.
    pub front: Option<FrontSettings>,
    /// Which figures count.
    pub metrics: Option<MetricsSettings>,
    /// Controllers to compare, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub controllers: BTreeMap<String, LawSettings>,
}

impl Scenario {
    /// A scenario from TOML. Unknown keys are refused.
    ///
    /// # Errors
    /// With the path of the key: what is not TOML, of the wrong type or out of range. What depends
    /// on the number of joints shows when something is built.
    pub fn from_toml(text: &str) -> Result<Self, ReadError> {
        limited(text)?;
        let syntax = |path: String, error: &toml::de::Error| {
            let place = if path.is_empty() || path == "." { "scenario" } else { &path };
            let message = format!("{place}: {}", error.message());
            match error.span() {
                Some(span) => ReadError::at(text, span.start, message),
                None => ReadError::new(message),
            }
        };
        let file = toml::Deserializer::parse(text).map_err(|e| syntax(String::new(), &e))?;
        let scenario: Self = serde_path_to_error::deserialize(file)
            .map_err(|error| syntax(error.path().to_string(), error.inner()))?;
        scenario.checked()
    }

    /// The scenario as TOML; [`from_toml`](Self::from_toml) gives it back bit for bit.
    ///
    /// # Errors
    /// A number that TOML does not have: a count of 2⁶³ and more.
    pub fn to_toml(&self) -> Result<String, ReadError> {
        toml::to_string(self).map_err(|error| ReadError::new(format!("scenario: {error}")))
    }

    /// The same with what is known filled in.
    ///
    /// # Errors
    /// With the path of what is out of range.
    pub fn checked(mut self) -> Result<Self, ReadError> {
        for (arm, path) in [(&self.two_link, "two_link"), (&self.plant, "plant")] {
            arm.as_ref().map(|arm| arm.build().map_err(below(path))).transpose()?;
        }
        if let Some(controller) = &self.controller {
            controller.check().map_err(below("controller"))?;
        }
        if let Some(mut settings) = self.compensator.take() {
            let basis = settings.basis.checked().map_err(below("compensator.basis"))?;
            settings.basis = basis;
            self.compensator = Some(settings.checked().map_err(below("compensator"))?);
        }
        for (motion, path) in self.motions() {
            motion.joints().map_err(below(path))?;
        }
        for (push, path) in self.pushes() {
            push.joints().map_err(below(path))?;
        }
        if let Some(run) = &self.run {
            run.check().map_err(below("run"))?;
        }
        self.check_comparison()?;
        Ok(self)
    }

    /// Refuses what makes no sense in the sections of a comparison.
    fn check_comparison(&self) -> Result<(), ReadError> {
        if let Some(actual) = &self.actual {
            if let Some(arm) = &actual.two_link {
                arm.build().map_err(below("actual.two_link"))?;
            }
            actual.check().map_err(below("actual"))?;
        }
        if let Some(effects) = &self.effects {
            effects.check().map_err(below("effects"))?;
        }
        if let Some(front) = &self.front {
            front.build().map_err(below("front"))?;
        }
        self.metrics.as_ref().map_or(Ok(()), |metrics| metrics.check().map_err(below("metrics")))
    }

    /// The reference of `N` joints, if the file has one.
    ///
    /// # Errors
    /// As [`CurveSettings::build`], with the path.
    pub fn reference<const N: usize>(&self) -> Result<Option<Curve<N>>, ReadError> {
        let motion = self.motions().find(|(_, path)| path.starts_with("reference"));
        motion.map(|(motion, path)| motion.build().map_err(below(path))).transpose()
    }

    /// What pushes this arm of `N` joints; nothing if the file has no disturbance.
    ///
    /// # Errors
    /// As [`PushSettings::build`], with the path.
    pub fn disturbance<const N: usize, A: Tip<N> + Clone>(
        &self,
        arm: &A,
    ) -> Result<Vec<Push<N, A>>, ReadError> {
        self.pushes().map(|(push, path)| push.build(arm).map_err(below(path))).collect()
    }

    /// The motions, with their paths.
    fn motions(&self) -> impl Iterator<Item = (&CurveSettings, String)> {
        let sections = [("reference", &self.reference), ("transfer", &self.transfer)];
        sections.into_iter().filter_map(|(section, motion)| {
            let motion = motion.as_ref()?;
            Some((motion, format!("{section}.{}", motion.name())))
        })
    }

    /// The disturbances, with their paths.
    fn pushes(&self) -> impl Iterator<Item = (&PushSettings, String)> {
        let pushes = self.disturbance.as_ref().map_or(&[][..], |list| &list.0);
        let path = move |place: usize| match pushes.len() {
            1 => "disturbance".to_owned(),
            _ => format!("disturbance[{place}]"),
        };
        let named = move |(place, push): (usize, &'_ PushSettings)| {
            format!("{}.{}", path(place), push.name())
        };
        pushes.iter().enumerate().map(move |each| (each.1, named(each)))
    }
}

/// An error of what stands below this path.
fn below(path: impl Display) -> impl FnOnce(Error) -> ReadError {
    move |error| ReadError::new(format!("{path}.{error}"))
}
