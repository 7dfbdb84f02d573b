//! Ctrl-C and progress, while the core computes.

use core::ops::ControlFlow;
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Signals are looked for this often.
const CHECK_EVERY: Duration = Duration::from_millis(20);

/// The clock is read about this often, or after this many steps.
const READ_EVERY: Duration = Duration::from_millis(1);
const MAX_STRIDE: u32 = 8;

/// Looks for Ctrl-C and shows progress, now and then.
///
/// The clock is read once in so many steps, fewer the longer they take, and never more than
/// [`MAX_STRIDE`]: steps that become slow at once must not put off Ctrl-C.
pub(super) struct Monitor {
    checked: Instant,
    /// Steps from one reading of the clock to the next, and those left.
    stride: u32,
    left: u32,
    read: Instant,
    progress: Option<Py<PyAny>>,
    pub raised: Option<PyErr>,
}

impl Monitor {
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        let now = Instant::now();
        Self { checked: now, stride: 1, left: 1, read: now, progress, raised: None }
    }

    pub fn look(&mut self, t: f64) -> ControlFlow<()> {
        self.left -= 1;
        if self.left > 0 {
            return ControlFlow::Continue(());
        }
        let now = Instant::now();
        let brief = now - self.read < READ_EVERY;
        self.stride = if brief { (2 * self.stride).min(MAX_STRIDE) } else { 1 };
        (self.left, self.read) = (self.stride, now);
        if now - self.checked < CHECK_EVERY {
            return ControlFlow::Continue(());
        }
        self.checked = now;
        let result = Python::attach(|py| {
            if let Some(progress) = &self.progress {
                progress.call1(py, (t,))?;
            }
            py.check_signals()
        });
        match result {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.raised = Some(error);
                ControlFlow::Break(())
            }
        }
    }
}
