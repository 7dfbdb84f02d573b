//! The parameters of everything that is configured, each said once: what they are called, what they
//! are by default, what they may be.
//!
//! The core's structs have a size, `N` joints, and no heap; these have neither, so one number may
//! stand for all joints. `build` makes the core's struct from them, for as many joints as it is
//! asked for. Python's classes hold them and TOML is read into them ([`Scenario`]): keys, defaults
//! and refusals are the same everywhere.

mod comparison;
mod controller;
mod curve;
mod disturbance;
mod effects;
mod file;
mod fuzzy;
mod inputs;
mod law;
mod numbers;
mod paper;
mod run;

pub use comparison::{
    ActualSettings, ChangeSettings, MetricsSettings, PayloadSettings, RobotSettings,
};
pub use controller::{ControllerSettings, TwoLinkSettings};
pub use curve::{
    Curve, CurveSettings, QuinticSettings, SinesSettings, TableSettings, WaypointsSettings,
};
pub use disturbance::{
    DisturbanceSettings, NoiseSettings, PulsesSettings, Push, PushSettings, ShapeName, Signal,
    WrenchSettings,
};
pub use effects::{EffectsSettings, FrontSettings, SideName, VelocityName};
pub use file::Scenario;
pub use fuzzy::{BasisSettings, CompensatorSettings, Rules};
pub use inputs::InputSettings;
#[cfg(feature = "python")]
pub(crate) use law::no_bodies;
pub use law::*;
pub use numbers::{Numbers, PerJoint};
pub use run::{MethodName, RunSettings};
