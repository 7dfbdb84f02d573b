//! What of an arm adaptation needs: its parameters, of which there are as many as the arm says.

use crate::arm::{Parametric, Serial, TwoLink};
use crate::control::{BoxedCompensator, DynamicState};
use crate::error::{Error, Result};
use crate::laws::{NaturalParameters, Pace};

/// An arm whose parameters can be adapted.
pub trait Adapts<const N: usize> {
    /// What `uses` makes of the arm with its parameters.
    fn with_parameters<U: Uses<N>>(&self, uses: U) -> U::Output;

    /// The natural adaptation of the arm's bodies: with Λ and γ, or of a bandwidth and a motion.
    ///
    /// # Errors
    /// `arm`: it has no bodies. As [`NaturalParameters::new`].
    fn natural(&self, how: &Natural<N>) -> Result<BoxedCompensator<N>>;
}

/// A use of an arm with `K` parameters, for any `K`.
pub trait Uses<const N: usize> {
    /// What it makes.
    type Output;

    /// Makes it.
    fn of<const K: usize, A>(self, arm: &A) -> Self::Output
    where
        A: Parametric<N, K> + Clone + Send + Sync + 'static;
}

/// How bodies are adapted.
pub enum Natural<const N: usize> {
    /// Λ [1/s] and γ [1/J].
    Gains([f64; N], f64),
    /// A bandwidth [rad/s], and how the arm will move.
    Bandwidth([f64; N], Pace<N>),
}

impl Adapts<2> for TwoLink {
    fn with_parameters<U: Uses<2>>(&self, uses: U) -> U::Output {
        uses.of(self)
    }

    fn natural(&self, _: &Natural<2>) -> Result<BoxedCompensator<2>> {
        Err(no_bodies())
    }
}

/// For an arm without bodies.
pub(crate) fn no_bodies() -> Error {
    let wanted = "a chain of bodies (a Serial); a two-link arm has lumped parameters";
    Error::out_of_range("arm", 2.0, wanted)
}

macro_rules! chains {
    ($($joints:literal $parameters:literal),*) => {$(
        impl Adapts<$joints> for Serial<$joints> {
            fn with_parameters<U: Uses<$joints>>(&self, uses: U) -> U::Output {
                uses.of(self)
            }

            fn natural(&self, how: &Natural<$joints>) -> Result<BoxedCompensator<$joints>> {
                let adaptation = match how {
                    Natural::Gains(slope, gain) => NaturalParameters::new(*self, *slope, *gain),
                    Natural::Bandwidth(bandwidth, pace) => {
                        NaturalParameters::with_bandwidth(*self, *bandwidth, pace)
                    }
                }?;
                let new = |_: &NaturalParameters<$joints, $parameters>| DynamicState::new();
                Ok(BoxedCompensator::new(adaptation, new))
            }
        }
    )*};
}

chains!(1 10, 2 20, 3 30, 4 40, 5 50, 6 60, 7 70, 8 80, 9 90, 10 100, 11 110, 12 120);
