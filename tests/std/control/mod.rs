//! The controller: one step of it, the adaptive law against a dense integration, the robust modifications, what may be
//! done to the weights, and the refusals.

mod allocations;
mod dense;
mod histories;
mod saving;
mod step;
mod weights;
