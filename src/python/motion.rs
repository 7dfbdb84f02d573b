//! Built-in signals of any joint count: a reference, or a disturbance.

use core::any::Any as Type;

use pyo3::prelude::*;

use super::convert::{Array1, array1};
use crate::math::Vector;
use crate::reference::{Harmonic, Quintic, Reference, Setpoint, Sines, Table};

/// (q_d, dq_d, ddq_d).
pub(super) type Triple<'py> = (Array1<'py>, Array1<'py>, Array1<'py>);

/// A built-in signal of `N` joints.
#[derive(Clone)]
pub(super) enum Motion<const N: usize> {
    Sines(Sines<N, Vec<Harmonic<N>>>),
    Quintic(Quintic<N>),
    Table(Table<N, Vec<f64>>),
}

/// A built-in signal of any joint count: what `Sines`, `Quintic` and `Table` hold.
pub(super) trait Signal: Send + Sync {
    fn at_time<'py>(&self, py: Python<'py>, t: f64) -> Triple<'py>;

    /// The samples of a table.
    fn columns(&self) -> Option<[&[f64]; 4]>;

    /// The [`Motion`] itself.
    fn as_any(&self) -> &dyn Type;
}

impl<const N: usize> Signal for Motion<N> {
    fn at_time<'py>(&self, py: Python<'py>, t: f64) -> Triple<'py> {
        let Setpoint { q, dq, ddq } = self.at(t);
        let array = |x: &Vector<N>| array1(py, x.as_slice());
        (array(&q), array(&dq), array(&ddq))
    }

    fn columns(&self) -> Option<[&[f64]; 4]> {
        if let Self::Table(table) = self { Some(table.columns()) } else { None }
    }

    fn as_any(&self) -> &dyn Type {
        self
    }
}

impl<const N: usize> Motion<N> {
    /// The signal without its derivatives.
    #[inline(always)]
    pub fn position(&self, t: f64) -> Vector<N> {
        match self {
            Self::Sines(sines) => sines.value(t),
            motion => motion.at(t).q,
        }
    }
}

impl<const N: usize> Reference<N> for Motion<N> {
    #[inline(always)]
    fn at(&self, t: f64) -> Setpoint<N> {
        match self {
            Self::Sines(sines) => sines.at(t),
            Self::Quintic(quintic) => quintic.at(t),
            Self::Table(table) => table.at(t),
        }
    }
}
