//! An arm as one of several that stand side by side.

use super::JointFriction;
use super::planar::Planar;
use super::serial::Chain;

/// What of an arm without stops, and with no friction that is dry, is put beside others, for many
/// runs at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side<'a, const N: usize> {
    pub(super) form: Form<'a, N>,
    /// `None` if no joint has any.
    pub(super) friction: Option<[JointFriction; N]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Form<'a, const N: usize> {
    /// Only where `N` is 2.
    TwoLink(&'a Planar),
    Chain(&'a Chain<N>),
}

impl<'a, const N: usize> Side<'a, N> {
    pub(super) fn two_link(arm: &'a Planar, friction: Option<[JointFriction; N]>) -> Self {
        Self { form: Form::TwoLink(arm), friction }
    }

    pub(super) fn chain(chain: &'a Chain<N>, friction: Option<[JointFriction; N]>) -> Self {
        Self { form: Form::Chain(chain), friction }
    }

    /// Whether its links' axes, as their users gave them, are those of the other.
    #[cfg(feature = "std")]
    pub(crate) fn is_named_as(&self, other: &Self) -> bool {
        match (self.form, other.form) {
            (Form::Chain(one), Form::Chain(other)) => {
                one.joints.iter().zip(&other.joints).all(|(one, other)| one.user == other.user)
            }
            _ => true,
        }
    }

    /// The same of an arm of two joints, where `N` is 2.
    #[cfg(feature = "python")]
    pub(crate) fn of_two(Side { form, friction }: Side<'a, 2>) -> Option<Self> {
        let friction = friction.map(|joints| core::array::from_fn(|n| joints[n.min(1)]));
        match form {
            Form::TwoLink(arm) if N == 2 => Some(Self::two_link(arm, friction)),
            _ => None,
        }
    }
}
