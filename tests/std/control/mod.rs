//! The controller: one step of it, the adaptive law against a dense integration, the robust
//! modifications, what may be done to the weights, the refusals, and laws from outside.

mod allocations;
mod dense;
mod guard;
mod histories;
mod hold;
mod memory;
mod rival;
mod saving;
mod soak;
mod step;
mod weights;
