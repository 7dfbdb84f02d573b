//! Control: a law for the nominal arm plus a compensator for what the model leaves out, such as
//! `τ = M₀(v − ρ̂) + H₀` (eqs. 7, 11, 12).
//!
//! The way through: a `controller` makes a `sample` of what was measured, as its `front` says, asks
//! its `compensator`
//! for ρ̂ and its `law` for τ, keeps τ within its `limits`, and tells the compensator what acted.
//! `computed_torque` is a law. `dynamic` makes a compensator of a memory of a few numbers.
//! `fuzzy_compensator` and `kernel_compensator` hold the weights that the `update` law (18) moves,
//! with the modifications of `adaptation`; `stages` is what a step of it records. `guard/` stands
//! around a controller in a real loop. Of many runs, `learns`, `memories` and the files `abreast`
//! put eight controllers side by side, and `beside` those of which only `laws` knows more.

#[cfg(feature = "std")]
mod abreast;
mod adaptation;
#[cfg(feature = "std")]
mod beliefs;
#[cfg(feature = "std")]
mod beside;
#[cfg(feature = "std")]
mod boxed;
mod bytes;
mod channel;
mod checks;
mod compensator;
mod computed_torque;
mod controller;
mod dynamic;
mod front;
mod fuzzy_compensator;
mod gains;
mod guard;
mod inputs;
mod kernel_compensator;
mod law;
mod learns;
mod limits;
#[cfg(feature = "std")]
mod memories;
mod sample;
mod saved;
mod single;
mod stages;
mod state;
mod update;

pub use crate::fuzzy::Buffer;
#[cfg(feature = "std")]
pub(crate) use abreast::{EstimatorsAbreast, LawsAbreast};
pub use adaptation::Adaptation;
#[cfg(feature = "std")]
pub use beliefs::Beliefs;
#[cfg(feature = "std")]
pub(crate) use beside::{Asks, OwnSide};
#[cfg(feature = "std")]
pub use boxed::{BoxedCompensator, BoxedLaw, BoxedState};
pub(crate) use bytes::{Numbers, put_all};
pub use channel::{Channel, Width};
#[cfg(feature = "std")]
pub(crate) use checks::{FARTHEST, check_period};
pub use compensator::{Audit, Compensator, NoCompensation, Stage};
pub use computed_torque::{ComputedTorque, Feedback};
pub use controller::{Command, Controller};
pub use dynamic::{Dynamic, DynamicState};
pub use front::{Front, MAX_DELAY};
#[cfg(feature = "std")]
pub(crate) use front::{FrontsAbreast, held_on, mean_acting};
pub use fuzzy_compensator::{FuzzyCompensator, FuzzyState};
pub use gains::Gains;
pub(crate) use gains::keeps_up;
pub use guard::{
    Brake, Cause, Event, Events, Guard, GuardMemory, GuardParameters, GuardState, Guarded,
};
#[cfg(feature = "std")]
pub(crate) use guard::{Seen, Turn};
pub use inputs::{Inputs, Signal};
pub use kernel_compensator::{KernelCompensator, KernelParameters, KernelState};
pub use law::{Applied, Demand, Law};
pub use learns::{Learns, Moved};
pub(crate) use learns::{missed, pushed};
pub use limits::Limits;
pub(crate) use limits::possible;
pub use sample::Sample;
pub use saved::{Origin, Saves};
pub use single::{Single, SingleState};
pub use stages::MAX_STAGES;
pub use state::State;
pub use update::FuzzyParameters;
