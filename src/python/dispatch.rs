//! The joint count of an arm, known when Python runs, becomes the `N` of the core, known when it is
//! compiled.
//!
//! A Python class holds an `enum` with a variant a count, made by [`by_joints`]; [`each`] calls
//! what is inside. What an arm or a compensator of `N` joints may be is told apart at run time too,
//! by the enums `AnyArm<N>` and `AnyCompensator<N>`: the loops of the core are then compiled once a
//! count, and not once a combination.

use core::any::Any;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Most joints of an arm.
pub(super) const MAX_JOINTS: usize = 12;

/// Joints of an object that was given scalars only, as long as no arm says otherwise: those of the
/// paper's arm.
pub(super) const DEFAULT_JOINTS: usize = 2;

/// Calls `$function::<N>` for the joint count `$joints`.
macro_rules! for_joints {
    ($joints:expr, $function:ident($($argument:expr),* $(,)?)) => {
        $crate::python::dispatch::for_joints!(
            @ $joints, $function, ($($argument),*), 1 2 3 4 5 6 7 8 9 10 11 12
        )
    };
    (@ $joints:expr, $function:ident, $arguments:tt, $($n:literal)*) => {
        match $joints {
            $($n => $function::<$n> $arguments,)*
            other => Err($crate::python::dispatch::too_many_joints(other)),
        }
    };
}

/// Declares an `enum` that holds a `$of<N>` for any joint count, in a box.
macro_rules! by_joints {
    ($(#[$doc:meta])* $name:ident of $of:ident) => {
        $crate::python::dispatch::by_joints!(@ $(#[$doc])* $name $of
            J1 1, J2 2, J3 3, J4 4, J5 5, J6 6, J7 7, J8 8, J9 9, J10 10, J11 11, J12 12);
    };
    (@ $(#[$doc:meta])* $name:ident $of:ident $($variant:ident $n:literal),*) => {
        $(#[$doc])*
        pub(super) enum $name {
            $($variant(Box<$of<$n>>),)*
        }

        $(impl From<$of<$n>> for $name {
            fn from(inner: $of<$n>) -> Self {
                Self::$variant(Box::new(inner))
            }
        })*

        impl $name {
            /// The number of joints.
            #[allow(dead_code, reason = "not every kind is asked")]
            pub fn joints(&self) -> usize {
                match self { $(Self::$variant(_) => $n,)* }
            }
        }
    };
}

/// `$body` for what is inside an `enum` of [`by_joints`].
macro_rules! each {
    ($any:expr, $name:ident, $inner:ident => $body:expr) => {
        match $any {
            $name::J1($inner) => $body,
            $name::J2($inner) => $body,
            $name::J3($inner) => $body,
            $name::J4($inner) => $body,
            $name::J5($inner) => $body,
            $name::J6($inner) => $body,
            $name::J7($inner) => $body,
            $name::J8($inner) => $body,
            $name::J9($inner) => $body,
            $name::J10($inner) => $body,
            $name::J11($inner) => $body,
            $name::J12($inner) => $body,
        }
    };
}

/// What is inside one of them, if it is for the joint count of a `T`.
pub(super) fn of_joints<T: Any>(inner: &dyn Any) -> Option<&T> {
    inner.downcast_ref()
}

pub(super) use {by_joints, each, for_joints};

/// For a joint count that was not checked before.
pub(super) fn too_many_joints(joints: usize) -> PyErr {
    PyValueError::new_err(format!("joints: got {joints}, wants 1 to {MAX_JOINTS}"))
}

/// Refuses an object of another joint count.
pub(super) fn same_joints(name: &str, got: usize, wanted: usize) -> PyResult<()> {
    if got == wanted { Ok(()) } else { Err(other_joints(name, got, wanted)) }
}

/// For an object of another joint count.
pub(super) fn other_joints(name: &str, got: usize, wanted: usize) -> PyErr {
    PyValueError::new_err(format!("{name}: got one of {got} joints, wants one of {wanted}"))
}
