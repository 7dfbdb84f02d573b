//! A guard around a controller: an answer to every sample, good, bad or missing. The torque that
//! leaves it is finite and within its limits, always.
//!
//! The way through: `guard` is what a loop calls; a `turn` judges what came (`judge`), asks the
//! controller or brakes, and lets `bounds` have the last word. `parameters` says what is allowed,
//! `events` what was done about the rest, `brake` how an arm is brought to rest. Models: libfranka
//! (limits from the torque commanded last, twenty lost packets stop the robot), ros2_control
//! (measured periods, overruns).

mod bounds;
mod brake;
mod events;
mod guarded;
mod judge;
mod memory;
mod parameters;
mod turn;

pub use brake::Brake;
pub use events::{Cause, Event, Events};
pub use guarded::{Guard, GuardState};
pub use memory::GuardMemory;
pub use parameters::GuardParameters;
pub use turn::Guarded;
#[cfg(feature = "std")]
pub(crate) use turn::{Seen, Turn};
