//! Poses of the links and the tip, and the Jacobian of the tip.

use super::joint::Chain;
use super::space::{Turn, V3};
use super::{Pose, Serial};
use crate::arm::Tip;
use crate::math::{Matrix, Vector};

/// A frame in the base: columns of its rotation, and its origin.
#[derive(Clone, Copy)]
struct Frame {
    columns: [V3; 3],
    origin: V3,
}

impl Frame {
    fn point(&self, p: V3) -> V3 {
        let [x, y, z] = self.columns;
        self.origin + (x * p.x + y * p.y + z * p.z)
    }

    fn next(&self, turn: &Turn) -> Self {
        Self { columns: turn.columns(self.columns), origin: self.point(turn.p) }
    }

    fn rotation(&self) -> Matrix<3> {
        Matrix::<3>::from_columns(&self.columns.map(V3::to_na))
    }
}

impl<const N: usize> Chain<N> {
    fn frames(&self, q: &Vector<N>) -> [Frame; N] {
        let column = |j| V3::new(self.base[(0, j)], self.base[(1, j)], self.base[(2, j)]);
        let mut frame = Frame { columns: [column(0), column(1), column(2)], origin: V3::ZERO };
        let mut frames = [frame; N];
        for i in 0..N {
            frame = frame.next(&self.joints[i].turn(q[i]));
            frames[i] = frame;
        }
        frames
    }
}

impl<const N: usize> Serial<N> {
    /// Pose of the tip in the base.
    pub fn pose(&self, q: &Vector<N>) -> Pose {
        let last = self.chain.frames(q)[N - 1];
        let tip = &self.chain.tip;
        Pose {
            rotation: last.rotation() * tip.rotation,
            translation: last.point(tip.translation.into()).to_na(),
        }
    }

    /// Poses of the joints' frames, as the links gave them, in the base.
    pub fn link_poses(&self, q: &Vector<N>) -> [Pose; N] {
        let frames = self.chain.frames(q);
        core::array::from_fn(|i| Pose {
            rotation: frames[i].rotation() * self.chain.joints[i].user.transpose(),
            translation: frames[i].origin.to_na(),
        })
    }

    /// Jacobian of the tip in the axes of the base: q̇ to its velocity [m/s] (rows 0 to 2) and
    /// angular velocity [rad/s] (rows 3 to 5). Pinocchio's `LOCAL_WORLD_ALIGNED`.
    pub fn jacobian(&self, q: &Vector<N>) -> nalgebra::SMatrix<f64, 6, N> {
        let frames = self.chain.frames(q);
        let tip = frames[N - 1].point(self.chain.tip.translation.into());
        let mut jacobian = nalgebra::SMatrix::<f64, 6, N>::zeros();
        for (j, frame) in frames.iter().enumerate() {
            let axis = frame.columns[2];
            let (linear, angular) = if self.chain.joints[j].revolute {
                (axis.cross(tip - frame.origin), axis)
            } else {
                (axis, V3::ZERO)
            };
            let column = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z];
            jacobian.set_column(j, &column.into());
        }
        jacobian
    }
}

impl<const N: usize> Tip<N> for Serial<N> {
    fn jacobian(&self, q: &Vector<N>) -> nalgebra::SMatrix<f64, 6, N> {
        Self::jacobian(self, q)
    }
}
