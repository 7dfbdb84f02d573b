//! Any arm behind one type, for tracker, plant and the classes of arms.

use nalgebra::SMatrix;
use pyo3::prelude::*;

use super::dispatch::by_joints;
use crate::arm::{
    Arm, JointFriction, JointKind, JointLimits, JointStop, Parametric, Pose, Regressor, Serial,
    Side, Tip, TwoLink,
};
use crate::control::BoxedCompensator;
use crate::math::{Matrix, Vector};
use crate::robot::Description;
use crate::scenario::{Adapts, Natural, Uses, no_bodies};

by_joints! {
    /// Any arm of any joint count.
    Arms of AnyArm
}

by_joints! {
    /// A chain of any joint count.
    Chains of Serial
}

/// Any arm of `N` joints.
#[derive(Clone)]
pub(super) enum AnyArm<const N: usize> {
    /// Only where `N` is 2.
    TwoLink(TwoLink),
    Serial(Box<Serial<N>>),
}

/// The chain of a description, also as any arm.
pub(super) fn chain<const N: usize>(description: &Description) -> PyResult<(Chains, Arms)>
where
    Chains: From<Serial<N>>,
    Arms: From<AnyArm<N>>,
{
    let chain: Serial<N> = description.arm()?;
    Ok((chain.into(), AnyArm::Serial(Box::new(chain)).into()))
}

/// A method of the arm inside. A [`TwoLink`] is asked with the entries of two joints, and what it
/// gives becomes that of `N` by `$back`.
macro_rules! of_inner {
    ($arm:ident.$method:ident($($x:ident),*), $back:expr) => {
        match $arm {
            Self::TwoLink(inner) => $back(inner.$method($(&two($x)),*)),
            Self::Serial(inner) => inner.$method($($x),*),
        }
    };
}

impl<const N: usize> AnyArm<N> {
    /// The chain, which can do more than every arm can.
    pub fn chain(&self) -> Option<&Serial<N>> {
        if let Self::Serial(arm) = self { Some(arm) } else { None }
    }

    /// How the joints move.
    pub fn joint_kinds(&self) -> [JointKind; N] {
        self.chain().map_or([JointKind::Revolute; N], Serial::joint_kinds)
    }

    /// U(q) [J].
    pub fn potential_energy(&self, q: &Vector<N>) -> f64 {
        of_inner!(self.potential_energy(q), same)
    }

    /// Pose of the tip in the base.
    pub fn pose(&self, q: &Vector<N>) -> Pose {
        of_inner!(self.pose(q), same)
    }

    /// Poses of the joints' frames in the base.
    pub fn link_poses(&self, q: &Vector<N>) -> Vec<Pose> {
        match self {
            Self::TwoLink(arm) => arm.link_poses(&two(q)).to_vec(),
            Self::Serial(arm) => arm.link_poses(q).to_vec(),
        }
    }
}

impl<const N: usize> Tip<N> for AnyArm<N> {
    fn jacobian(&self, q: &Vector<N>) -> SMatrix<f64, 6, N> {
        match self {
            Self::TwoLink(arm) => {
                let of_two = arm.jacobian(&two(q));
                SMatrix::from_fn(|i, j| of_two.get((i, j)).copied().unwrap_or(f64::NAN))
            }
            Self::Serial(arm) => arm.as_ref().jacobian(q),
        }
    }
}

/// The entries of two joints. Nothing is left of this where `N` is 2; elsewhere no arm asks for it.
#[inline(always)]
fn two<const N: usize>(x: &Vector<N>) -> Vector<2> {
    Vector::<2>::from_fn(|i, _| x.get(i).copied().unwrap_or(f64::NAN))
}

/// The way back.
#[inline(always)]
fn back<const N: usize>(x: Vector<2>) -> Vector<N> {
    Vector::<N>::from_fn(|i, _| x.get(i).copied().unwrap_or(f64::NAN))
}

#[inline(always)]
fn square<const N: usize>(x: Matrix<2>) -> Matrix<N> {
    Matrix::<N>::from_fn(|i, j| x.get((i, j)).copied().unwrap_or(f64::NAN))
}

/// What no joint count is in.
#[inline(always)]
fn same<T>(x: T) -> T {
    x
}

impl<const N: usize> Arm<N> for AnyArm<N> {
    fn side(&self) -> Option<Side<'_, N>> {
        match self {
            Self::TwoLink(arm) => Side::of_two(arm.side()?),
            Self::Serial(chain) => chain.side(),
        }
    }

    #[inline]
    fn wraps(&self) -> [bool; N] {
        self.chain().map_or([false; N], Serial::wraps)
    }

    #[inline]
    fn mass_matrix(&self, q: &Vector<N>) -> Matrix<N> {
        of_inner!(self.mass_matrix(q), square)
    }

    #[inline]
    fn rigid_bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        of_inner!(self.rigid_bias(q, dq), back)
    }

    #[inline]
    fn coriolis(&self, q: &Vector<N>, dq: &Vector<N>) -> Matrix<N> {
        of_inner!(self.coriolis(q, dq), square)
    }

    #[inline]
    fn gravity(&self, q: &Vector<N>) -> Vector<N> {
        of_inner!(self.gravity(q), back)
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
        of_inner!(self.resists(), same)
    }

    fn rigid_dynamics(
        &self,
        q: &Vector<N>,
        choose: &mut dyn FnMut(&Matrix<N>) -> Vector<N>,
    ) -> (Matrix<N>, Vector<N>, Vector<N>) {
        match self {
            Self::TwoLink(arm) => {
                let (mass, dq, rigid) =
                    arm.rigid_dynamics(&two(q), &mut |mass| two(&choose(&square(*mass))));
                (square(mass), back(dq), back(rigid))
            }
            Self::Serial(arm) => arm.rigid_dynamics(q, choose),
        }
    }

    #[inline]
    fn bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        of_inner!(self.bias(q, dq), back)
    }

    #[inline(always)]
    fn mass_matrix_and_bias(&self, q: &Vector<N>, dq: &Vector<N>) -> (Matrix<N>, Vector<N>) {
        of_inner!(self.mass_matrix_and_bias(q, dq), |(mass, bias)| (square(mass), back(bias)))
    }

    #[inline]
    fn inverse_dynamics(&self, q: &Vector<N>, dq: &Vector<N>, ddq: &Vector<N>) -> Vector<N> {
        of_inner!(self.inverse_dynamics(q, dq, ddq), back)
    }

    #[inline(always)]
    fn forward_dynamics(&self, q: &Vector<N>, dq: &Vector<N>, tau: &Vector<N>) -> Vector<N> {
        of_inner!(self.forward_dynamics(q, dq, tau), back)
    }
}

/// Of the two-link arm; no other has five.
impl<const N: usize> Parametric<N, 5> for AnyArm<N> {
    fn slotine_li_regressor(
        &self,
        q: &Vector<N>,
        dq: &Vector<N>,
        dq_r: &Vector<N>,
        ddq_r: &Vector<N>,
    ) -> Regressor<N, 5> {
        let Self::TwoLink(arm) = self else { return Regressor::<N, 5>::zeros() };
        let of_two = arm.slotine_li_regressor(&two(q), &two(dq), &two(dq_r), &two(ddq_r));
        Regressor::<N, 5>::from_fn(|n, k| of_two[(n, k)])
    }

    fn inertial_parameters(&self) -> Vector<5> {
        let Self::TwoLink(arm) = self else { return Vector::<5>::zeros() };
        arm.inertial_parameters()
    }

    fn burdened(&self, scale: f64, load: f64) -> crate::error::Result<Self> {
        match self {
            Self::TwoLink(arm) => arm.burdened(scale, load).map(Self::TwoLink),
            Self::Serial(_) => Ok(self.clone()),
        }
    }
}

impl<const N: usize> Adapts<N> for AnyArm<N>
where
    Serial<N>: Adapts<N>,
{
    fn with_parameters<U: Uses<N>>(&self, uses: U) -> U::Output {
        match self {
            Self::TwoLink(_) => uses.of::<5, Self>(self),
            Self::Serial(arm) => Adapts::with_parameters(&**arm, uses),
        }
    }

    fn natural(&self, how: &Natural<N>) -> crate::error::Result<BoxedCompensator<N>> {
        match self {
            Self::TwoLink(_) => Err(no_bodies()),
            Self::Serial(arm) => arm.natural(how),
        }
    }
}
