//! Compensators of eight runs side by side, a run a lane: a grid a joint over two inputs, as
//! [`step`](super::step) computes it of one run, with the same sums in the same order. Weights may
//! leak, and drives be weakened; what pulls weights by their size does not go side by side.
//!
//! The rules of a joint are products of two memberships, so the memberships of each stage are all
//! that is kept of it.

mod end;
mod per_joint;
mod stage;

use pulp::Arch;

use self::end::{Acted, Advance};
pub(in crate::control) use self::per_joint::PerJoint;
use self::stage::Estimate;
use crate::control::{Sample, Stage};
use crate::math::{Abreast, Vector, in_lanes};

impl<const N: usize> PerJoint<N> {
    /// ρ̂ at a stage, and what drives the weights there; an input out of reach is `lost`.
    #[inline(never)]
    pub fn estimate(
        &mut self,
        arch: Arch,
        stage: &Stage<'_>,
        seen: &Sample<N, Abreast>,
        lost: &mut Abreast,
    ) {
        self.mix(stage);
        in_lanes(arch, Estimate { it: self, stage, seen, lost });
    }

    /// Holds the weights of the runs whose torque was limited.
    #[inline(never)]
    pub fn acted(
        &mut self,
        arch: Arch,
        index: usize,
        asked: &Vector<N, Abreast>,
        applied: &Vector<N, Abreast>,
    ) {
        in_lanes(arch, Acted { drive: &mut self.stages[index].drive, asked, applied });
    }

    /// Moves the weights to the end of a step.
    #[inline(never)]
    pub fn advance(&mut self, arch: Arch, end: &Stage<'_>) {
        self.advances += 1;
        self.mix(end);
        in_lanes(arch, Advance { it: self, end });
    }
}
