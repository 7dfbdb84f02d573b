//! A built-in signal without its joint count: a reference, or a disturbance.

use core::any::Any as Type;

use pyo3::prelude::*;

use super::convert::{Array1, array1};
use crate::math::Vector;
use crate::reference::{Reference, Setpoint};
use crate::scenario::Motion;

/// (q_d, dq_d, ddq_d).
pub(super) type Triple<'py> = (Array1<'py>, Array1<'py>, Array1<'py>);

/// A built-in signal of any joint count: what `Sines`, `Quintic` and `Table` hold.
pub(super) trait Signal: Send + Sync {
    fn at_time<'py>(&self, py: Python<'py>, t: f64) -> Triple<'py>;

    /// The [`Motion`] itself.
    fn as_any(&self) -> &dyn Type;
}

impl<const N: usize> Signal for Motion<N> {
    fn at_time<'py>(&self, py: Python<'py>, t: f64) -> Triple<'py> {
        let Setpoint { q, dq, ddq } = self.at(t);
        let array = |x: &Vector<N>| array1(py, x.as_slice());
        (array(&q), array(&dq), array(&ddq))
    }

    fn as_any(&self) -> &dyn Type {
        self
    }
}
