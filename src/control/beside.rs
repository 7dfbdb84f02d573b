//! A law that only `laws` knows, and what goes with it, as one of eight that stand side by side.

use core::any::Any;
use std::boxed::Box;

use pulp::Arch;

use super::{Beliefs, Demand, Sample};
use crate::math::{Abreast, LANES, Vector};

/// A compensator with its state, and how eight of its kind are put side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OwnSide<'a, const N: usize> {
    pub beliefs: Beliefs<'a, N>,
    /// More numbers of its own.
    pub shape: &'a dyn Any,
    pub known: [&'a [f64]; 3],
    pub put: Put<N>,
}

/// Puts laws that believe this beside each other, with what compensates; `None` if they cannot be.
pub(crate) type Put<const N: usize> =
    fn([Beliefs<'_, N>; LANES], [OwnSide<'_, N>; LANES]) -> Option<Box<dyn Asks<N>>>;

/// Laws with what compensates, of eight runs side by side.
pub(crate) trait Asks<const N: usize> {
    /// Asks for torques, for what the laws see; and ρ̂.
    fn ask(
        &mut self,
        arch: Arch,
        seen: &Sample<N, Abreast>,
        asked: (&mut Demand<N, Abreast>, &mut Vector<N, Abreast>),
    );

    /// Ends a period of `dt` \[s\] with what was `asked` for what was `applied`. What is not finite
    /// is `lost`.
    fn end(
        &mut self,
        arch: Arch,
        torques: (&Vector<N, Abreast>, &Vector<N, Abreast>),
        dt: f64,
        lost: &mut Abreast,
    );
}
