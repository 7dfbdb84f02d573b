//! An arm as one of several that stand side by side.

use super::planar::Planar;
use super::serial::Chain;

/// What of an arm without friction and stops is put beside others, for many runs at a time.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a, const N: usize>(pub(super) Form<'a, N>);

#[derive(Clone, Copy, Debug)]
pub(super) enum Form<'a, const N: usize> {
    /// Only where `N` is 2.
    TwoLink(&'a Planar),
    Chain(&'a Chain<N>),
}

impl<'a, const N: usize> Side<'a, N> {
    pub(super) fn two_link(arm: &'a Planar) -> Self {
        Self(Form::TwoLink(arm))
    }

    pub(super) fn chain(chain: &'a Chain<N>) -> Self {
        Self(Form::Chain(chain))
    }

    /// The same of an arm of two joints, where `N` is 2.
    #[cfg(feature = "python")]
    pub(crate) fn of_two(Side(form): Side<'a, 2>) -> Option<Self> {
        match form {
            Form::TwoLink(arm) if N == 2 => Some(Self::two_link(arm)),
            _ => None,
        }
    }
}
