//! The joint count of an arm, known when Python runs, becomes the `N` of the core, known when it is
//! compiled.
//!
//! Every Python class holds one object behind a trait (`Tracked`, `Planted`, `Signal`) that is
//! implemented once for all `N`; [`for_joints`] makes the object of the right `N`, and a call goes
//! through one pointer. An `enum` with a variant a count would do the same with a `match` at every
//! method. What is inside an `N` is told apart by enums instead (`AnyArm<N>`, `AnyReference<N>`,
//! `AnyDisturbance<N>`): the loops of the core are then compiled once a count, not once a
//! combination, and the small closed form of `TwoLink` is still inlined into them. The compensator
//! alone has loops of its own in every form (`Tracker<N, C>`): a stage spends most of its time
//! there.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Most joints of an arm.
pub(super) const MAX_JOINTS: usize = 8;

/// Joints of an object that was given scalars only, as long as no arm says otherwise: those of the
/// paper's arm.
pub(super) const DEFAULT_JOINTS: usize = 2;

/// Calls `$function::<N>` for the joint count `$joints`.
macro_rules! for_joints {
    ($joints:expr, $function:ident($($argument:expr),* $(,)?)) => {
        $crate::python::dispatch::for_joints!(
            @ $joints, $function, ($($argument),*), 1 2 3 4 5 6 7 8
        )
    };
    (@ $joints:expr, $function:ident, $arguments:tt, $($n:literal)*) => {
        match $joints {
            $($n => $function::<$n> $arguments,)*
            other => Err($crate::python::dispatch::too_many_joints(other)),
        }
    };
}

pub(super) use for_joints;

/// For a joint count that was not checked before.
pub(super) fn too_many_joints(joints: usize) -> PyErr {
    PyValueError::new_err(format!("joints: got {joints}, wants 1 to {MAX_JOINTS}"))
}

/// Refuses an object of another joint count.
pub(super) fn same_joints(name: &str, got: usize, wanted: usize) -> PyResult<()> {
    if got == wanted {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("{name}: got one of {got} joints, wants one of {wanted}")))
}
