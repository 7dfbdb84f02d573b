//! Any arm behind one type, for tracker and plant.

use pyo3::prelude::*;

use super::arm::PyTwoLink;
use super::convert::{Any, wrong_type};
use super::dispatch::same_joints;
use super::serial::PySerial;
use crate::arm::{Arm, JointFriction, JointLimits, JointStop, Serial, TwoLink};
use crate::math::{Matrix, Vector};

/// Any arm of `N` joints.
pub(super) enum AnyArm<const N: usize> {
    /// Only where `N` is 2: [`AnyArm::new`] sees to it.
    TwoLink(TwoLink),
    Serial(Box<Serial<N>>),
}

/// Joints of the arm that was given as the argument `arm`.
pub(super) fn joints_of(arm: Any<'_, '_>) -> PyResult<usize> {
    if arm.is_instance_of::<PyTwoLink>() {
        return Ok(2);
    }
    match arm.cast::<PySerial>() {
        Ok(serial) => Ok(serial.get().arm.joints()),
        Err(_) => Err(wrong_type("arm", arm, "a TwoLink or a Serial")),
    }
}

impl<const N: usize> AnyArm<N> {
    /// The arm that was given as the argument `arm`.
    pub fn new(arm: Any<'_, '_>) -> PyResult<Self> {
        same_joints("arm", joints_of(arm)?, N)?;
        if let Ok(arm) = arm.cast::<PyTwoLink>() {
            return Ok(Self::TwoLink(arm.get().arm));
        }
        let serial = arm.cast::<PySerial>()?.get().arm.as_any().downcast_ref::<Serial<N>>();
        let serial = serial.ok_or_else(|| wrong_type("arm", arm, "a TwoLink or a Serial"))?;
        Ok(Self::Serial(Box::new(*serial)))
    }
}

/// The entries of two joints. Nothing is left of this where `N` is 2; elsewhere no arm asks for it.
#[inline(always)]
fn two<const N: usize>(x: &Vector<N>) -> Vector<2> {
    Vector::<2>::from_fn(|i, _| x.get(i).copied().unwrap_or(f64::NAN))
}

/// The way back.
#[inline(always)]
fn back<const N: usize>(x: &Vector<2>) -> Vector<N> {
    Vector::<N>::from_fn(|i, _| x.get(i).copied().unwrap_or(f64::NAN))
}

#[inline(always)]
fn square<const N: usize>(x: &Matrix<2>) -> Matrix<N> {
    Matrix::<N>::from_fn(|i, j| x.get((i, j)).copied().unwrap_or(f64::NAN))
}

impl<const N: usize> Arm<N> for AnyArm<N> {
    #[inline]
    fn wraps(&self) -> [bool; N] {
        match self {
            Self::TwoLink(_) => [false; N],
            Self::Serial(arm) => arm.wraps(),
        }
    }

    #[inline]
    fn mass_matrix(&self, q: &Vector<N>) -> Matrix<N> {
        match self {
            Self::TwoLink(arm) => square(&arm.mass_matrix(&two(q))),
            Self::Serial(arm) => arm.mass_matrix(q),
        }
    }

    #[inline]
    fn rigid_bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        match self {
            Self::TwoLink(arm) => back(&arm.rigid_bias(&two(q), &two(dq))),
            Self::Serial(arm) => arm.rigid_bias(q, dq),
        }
    }

    #[inline]
    fn coriolis(&self, q: &Vector<N>, dq: &Vector<N>) -> Matrix<N> {
        match self {
            Self::TwoLink(arm) => square(&arm.coriolis(&two(q), &two(dq))),
            Self::Serial(arm) => arm.coriolis(q, dq),
        }
    }

    #[inline]
    fn gravity(&self, q: &Vector<N>) -> Vector<N> {
        match self {
            Self::TwoLink(arm) => back(&arm.gravity(&two(q))),
            Self::Serial(arm) => arm.gravity(q),
        }
    }

    fn joint_friction(&self, joint: usize) -> JointFriction {
        match self {
            Self::TwoLink(arm) => arm.joint_friction(joint),
            Self::Serial(arm) => arm.joint_friction(joint),
        }
    }

    fn joint_stop(&self, joint: usize) -> (JointStop, JointLimits) {
        match self {
            Self::TwoLink(arm) => arm.joint_stop(joint),
            Self::Serial(arm) => arm.joint_stop(joint),
        }
    }

    #[inline]
    fn resists(&self) -> bool {
        match self {
            Self::TwoLink(arm) => arm.resists(),
            Self::Serial(arm) => arm.resists(),
        }
    }

    fn rigid_dynamics(
        &self,
        q: &Vector<N>,
        choose: &mut dyn FnMut(&Matrix<N>) -> Vector<N>,
    ) -> (Matrix<N>, Vector<N>, Vector<N>) {
        match self {
            Self::TwoLink(arm) => {
                let (mass, dq, rigid) =
                    arm.rigid_dynamics(&two(q), &mut |mass| two(&choose(&square(mass))));
                (square(&mass), back(&dq), back(&rigid))
            }
            Self::Serial(arm) => arm.rigid_dynamics(q, choose),
        }
    }

    #[inline]
    fn bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        match self {
            Self::TwoLink(arm) => back(&arm.bias(&two(q), &two(dq))),
            Self::Serial(arm) => arm.bias(q, dq),
        }
    }

    #[inline(always)]
    fn mass_matrix_and_bias(&self, q: &Vector<N>, dq: &Vector<N>) -> (Matrix<N>, Vector<N>) {
        match self {
            Self::TwoLink(arm) => {
                let (mass, bias) = arm.mass_matrix_and_bias(&two(q), &two(dq));
                (square(&mass), back(&bias))
            }
            Self::Serial(arm) => arm.mass_matrix_and_bias(q, dq),
        }
    }

    #[inline]
    fn inverse_dynamics(&self, q: &Vector<N>, dq: &Vector<N>, ddq: &Vector<N>) -> Vector<N> {
        match self {
            Self::TwoLink(arm) => back(&arm.inverse_dynamics(&two(q), &two(dq), &two(ddq))),
            Self::Serial(arm) => arm.inverse_dynamics(q, dq, ddq),
        }
    }

    #[inline(always)]
    fn forward_dynamics(&self, q: &Vector<N>, dq: &Vector<N>, tau: &Vector<N>) -> Vector<N> {
        match self {
            Self::TwoLink(arm) => back(&arm.forward_dynamics(&two(q), &two(dq), &two(tau))),
            Self::Serial(arm) => arm.forward_dynamics(q, dq, tau),
        }
    }
}
