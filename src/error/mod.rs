//! One error type: which parameter, what it got, what it wants.
//!
//! An [`Error`] is a place and a [`Problem`]. It is `Copy` and holds no strings of its own, so that
//! returning one in a control step costs no allocation. Who knows the place better than the one who
//! refused says so on the way up: `error.named("payload.mass").at(joint)`.

mod problem;

use core::fmt;

pub use problem::Problem;

/// Why a constructor refused its arguments, or a step its sample.
///
/// ```
/// use steadyarm::{Error, Problem};
///
/// let error = Error::out_of_range("kp", -8.0, "a number > 0").at(1);
/// assert_eq!(error.to_string(), "kp[1]: got -8, wants a number > 0");
/// assert_eq!((error.parameter(), error.index()), ("kp", Some(1)));
/// assert!(matches!(error.problem(), Problem::OutOfRange { got: -8.0, .. }));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Error {
    place: Place,
    problem: Problem,
}

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = core::result::Result<T, E>;

/// The parameter, or the part of a computation, that is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    parameter: &'static str,
    index: Option<usize>,
}

impl Error {
    const fn new(parameter: &'static str, problem: Problem) -> Self {
        Self { place: Place { parameter, index: None }, problem }
    }

    /// [`Problem::NotFinite`] of the parameter of this name.
    pub const fn not_finite(parameter: &'static str, got: f64) -> Self {
        Self::new(parameter, Problem::NotFinite { got })
    }

    /// [`Problem::OutOfRange`]; `wanted` says in words and units what would be accepted.
    pub const fn out_of_range(parameter: &'static str, got: f64, wanted: &'static str) -> Self {
        Self::new(parameter, Problem::OutOfRange { got, wanted })
    }

    /// [`Problem::WrongLength`], both in entries.
    pub const fn wrong_length(parameter: &'static str, got: usize, wanted: usize) -> Self {
        Self::new(parameter, Problem::WrongLength { got, wanted })
    }

    /// [`Problem::TooMany`]; `got` is `None` if the count overflows.
    pub const fn too_many(parameter: &'static str, got: Option<usize>, limit: usize) -> Self {
        Self::new(parameter, Problem::TooMany { got, limit })
    }

    /// [`Problem::NotGiven`].
    #[cfg(feature = "std")]
    pub(crate) const fn not_given(parameter: &'static str, wanted: &'static str) -> Self {
        Self::new(parameter, Problem::NotGiven { wanted })
    }

    /// [`Problem::Missing`].
    #[cfg(feature = "urdf")]
    pub(crate) const fn missing(parameter: &'static str) -> Self {
        Self::new(parameter, Problem::Missing)
    }

    /// [`Problem::RecordTooLarge`], naming `record_every`.
    #[cfg(feature = "std")]
    pub(crate) const fn record_too_large(
        every: usize,
        (rows, row_bytes): (usize, usize),
        limit: u64,
    ) -> Self {
        Self::new("record_every", Problem::RecordTooLarge { every, rows, row_bytes, limit })
    }

    /// [`Problem::NotSingle`].
    pub(crate) const fn not_single(parameter: &'static str, wanted: &'static str) -> Self {
        Self::new(parameter, Problem::NotSingle { wanted })
    }

    /// [`Problem::NotSymmetric`], with the entries (row, column) and (column, row) so far apart.
    pub(crate) const fn not_symmetric(
        parameter: &'static str,
        (row, column): (usize, usize),
        difference: f64,
    ) -> Self {
        Self::new(parameter, Problem::NotSymmetric { row, column, difference })
    }

    /// [`Problem::NotPositive`], with the smallest eigenvalue.
    pub(crate) const fn not_positive(
        parameter: &'static str,
        smallest: f64,
        wanted: &'static str,
    ) -> Self {
        Self::new(parameter, Problem::NotPositive { smallest, wanted })
    }

    /// [`Problem::NotHurwitz`], with the largest real part [1/s].
    pub(crate) const fn not_hurwitz(parameter: &'static str, max_real: f64) -> Self {
        Self::new(parameter, Problem::NotHurwitz { max_real })
    }

    /// [`Problem::NoStabilizingSolution`], naming `gamma`.
    pub(crate) const fn no_stabilizing_solution(
        gamma: f64,
        gamma_opt: f64,
        max_scale: f64,
    ) -> Self {
        Self::new("gamma", Problem::NoStabilizingSolution { gamma, gamma_opt, max_scale })
    }

    /// [`Problem::NotStabilizable`] by the input matrix of this name.
    pub(crate) const fn not_stabilizable(parameter: &'static str) -> Self {
        Self::new(parameter, Problem::NotStabilizable)
    }

    /// [`Problem::ModeOnAxis`] at this frequency [rad/s], unseen by the weight of this name.
    pub(crate) const fn mode_on_axis(parameter: &'static str, frequency: f64) -> Self {
        Self::new(parameter, Problem::ModeOnAxis { frequency })
    }

    /// [`Problem::NoConvergence`] of what is being computed.
    pub(crate) const fn no_convergence(computing: &'static str) -> Self {
        Self::new(computing, Problem::NoConvergence)
    }

    /// [`Problem::BeyondRadius`] of weights.
    #[cold]
    pub(crate) const fn beyond_radius(norm: f64, radius: f64) -> Self {
        Self::new("weights", Problem::BeyondRadius { norm, radius })
    }

    /// [`Problem::OtherController`] of a saved state.
    pub(crate) const fn other_controller(
        arm: bool,
        gains: bool,
        compensator: bool,
        basis: bool,
    ) -> Self {
        let problem = Problem::OtherController { arm, gains, compensator, basis };
        Self::new("saved state", problem)
    }

    /// [`Problem::Damaged`] of a saved state.
    pub(crate) const fn damaged(flaw: &'static str) -> Self {
        Self::new("saved state", Problem::Damaged { flaw })
    }

    /// The same problem, of the parameter of another name.
    #[must_use]
    pub const fn named(mut self, parameter: &'static str) -> Self {
        self.place.parameter = parameter;
        self
    }

    /// The same problem, at this position of its parameter: of a list, a joint. `None`: of it all.
    #[must_use]
    pub fn at(mut self, index: impl Into<Option<usize>>) -> Self {
        self.place.index = index.into();
        self
    }

    /// Name of the parameter, or of what was being computed.
    pub const fn parameter(&self) -> &'static str {
        self.place.parameter
    }

    /// Position in the parameter, if it has several entries.
    pub const fn index(&self) -> Option<usize> {
        self.place.index
    }

    /// What is wrong with it.
    pub const fn problem(&self) -> Problem {
        self.problem
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { parameter, index } = self.place;
        f.write_str(parameter)?;
        if let Some(index) = index {
            write!(f, "[{index}]")?;
        }
        f.write_str(": ")?;
        self.problem.say(parameter, f)
    }
}

impl core::error::Error for Error {}

/// Refuses NaN and infinities in `values`.
pub(crate) fn finite(parameter: &'static str, values: &[f64]) -> Result<()> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::not_finite(parameter, values[i]).at(index_of(values, i))),
    }
}

/// Refuses what is not finite and > 0.
pub(crate) fn positive(parameter: &'static str, values: &[f64]) -> Result<()> {
    within(parameter, values, |v| v > 0.0, "a number > 0")
}

/// Refuses what is not finite and ≥ 0.
pub(crate) fn non_negative(parameter: &'static str, values: &[f64]) -> Result<()> {
    within(parameter, values, |v| v >= 0.0, "a number >= 0")
}

/// Refuses what is not finite or fails `accept`; `wanted` says in words what is accepted.
pub(crate) fn within(
    parameter: &'static str,
    values: &[f64],
    accept: impl Fn(f64) -> bool,
    wanted: &'static str,
) -> Result<()> {
    finite(parameter, values)?;
    accepted(parameter, values, accept, wanted)
}

/// Refuses what fails `accept`, which may let infinities pass.
pub(crate) fn accepted(
    parameter: &'static str,
    values: &[f64],
    accept: impl Fn(f64) -> bool,
    wanted: &'static str,
) -> Result<()> {
    match values.iter().position(|&v| !accept(v)) {
        None => Ok(()),
        Some(i) => Err(Error::out_of_range(parameter, values[i], wanted).at(index_of(values, i))),
    }
}

/// Refuses another number of entries.
pub(crate) fn length(parameter: &'static str, got: usize, wanted: usize) -> Result<()> {
    if got == wanted { Ok(()) } else { Err(Error::wrong_length(parameter, got, wanted)) }
}

/// Refuses none where at least one is needed.
pub(crate) fn not_empty(parameter: &'static str, got: usize) -> Result<()> {
    length(parameter, got, got.max(1))
}

/// Refuses a larger count.
pub(crate) fn at_most(parameter: &'static str, got: usize, limit: usize) -> Result<()> {
    if got <= limit { Ok(()) } else { Err(Error::too_many(parameter, Some(got), limit)) }
}

fn index_of(values: &[f64], i: usize) -> Option<usize> {
    (values.len() > 1).then_some(i)
}

#[cfg(test)]
#[cfg(feature = "std")]
mod tests {
    use super::*;

    #[test]
    fn another_place_keeps_the_problem() {
        let error = non_negative("coulomb", &[1.0, -2.0]).map_err(|e| e.named("friction.coulomb"));
        let error = error.expect_err("negative");
        assert_eq!(error.to_string(), "friction.coulomb[1]: got -2, wants a number >= 0");
        let moved = error.at(6);
        assert_eq!((moved.parameter(), moved.index()), ("friction.coulomb", Some(6)));
        assert_eq!(moved.problem(), error.problem());
        let whole = moved.at(None).named("coulomb");
        assert_eq!(whole, Error::out_of_range("coulomb", -2.0, "a number >= 0"));
    }

    /// The matrix is named three times in a message, under one name.
    #[test]
    fn a_renamed_matrix_has_the_new_name_throughout() {
        let pair = Error::not_symmetric("q", (0, 1), 0.5).named("Q");
        let words = "Q: got Q[0, 1] and Q[1, 0] 5e-1 apart, wants a symmetric matrix";
        assert_eq!(pair.to_string(), words);
        let input = Error::not_stabilizable("b").named("B").to_string();
        assert!(input.starts_with("B: ") && input.ends_with("a stabilisable pair (A, B)"));
        let weight = Error::mode_on_axis("q", 3.0).named("Q").to_string();
        assert!(weight.starts_with("Q: ") && weight.contains("at 3e0 rad/s"), "{weight}");
        assert!(weight.contains("wants a Q that sees"), "{weight}");
    }

    #[test]
    fn counts_are_refused_at_their_ends() {
        assert!(not_empty("links", 1).is_ok() && at_most("rules", 8, 8).is_ok());
        assert_eq!(not_empty("links", 0), Err(Error::wrong_length("links", 0, 1)));
        assert_eq!(at_most("rules", 9, 8), Err(Error::too_many("rules", Some(9), 8)));
        assert_eq!(length("x", 3, 2), Err(Error::wrong_length("x", 3, 2)));
        let overflow = Error::too_many("rules", None, 8).to_string();
        assert_eq!(overflow, "rules: got more than fit an integer, wants at most 8");
    }
}
