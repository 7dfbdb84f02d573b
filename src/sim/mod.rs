//! Closed-loop simulation: the loop that a user would write with the public step, and its record.

mod adaptive;
mod affected;
mod certificate;
mod certified;
mod channels;
mod closed_loop;
mod continuous;
mod doubt;
mod evaluation;
mod held;
mod integrators;
mod many;
mod metrics;
mod options;
mod recorder;
mod resolution;
mod run;
mod sampled;
mod simulate;
mod status;
mod stiff;

pub use certificate::Certificate;
pub use channels::Column;
pub use closed_loop::{ClosedLoop, Start};
pub use doubt::{Coarse, Doubt};
pub use evaluation::Evaluation;
pub use held::hold_torque;
pub use integrators::{DP54, DP54_ERROR, Motion, RK4, Rates, Tableau, Tolerance, dp54_dense};
pub use many::{Case, simulate_many};
pub use metrics::{Metrics, Window, metrics};
pub use options::{MAX_RECORD_BYTES, Method, Options, Record};
pub use run::Run;
#[cfg(feature = "python")]
pub(crate) use simulate::simulate_by;
pub use simulate::{simulate, simulate_guarded};
pub use status::{Cause, Status};
pub use stiff::Moved;
