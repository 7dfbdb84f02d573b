//! One error type: which parameter, what it got, what it wants.
//!
//! [`Error`] is `Copy` and holds no strings of its own, so that returning one in a control step costs no allocation.

use core::fmt;

/// Why a constructor refused its arguments, or a step its sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A number is NaN or infinite.
    NotFinite {
        /// Name of the parameter.
        parameter: &'static str,
        /// Position in the parameter, if it has several entries.
        index: Option<usize>,
        /// The value found there.
        got: f64,
    },
    /// A number lies outside what the parameter allows.
    OutOfRange {
        /// Name of the parameter.
        parameter: &'static str,
        /// Position in the parameter, if it has several entries.
        index: Option<usize>,
        /// The value found there.
        got: f64,
        /// What would be accepted, in words and units.
        wanted: &'static str,
    },
    /// A parameter has the wrong number of entries.
    WrongLength {
        /// Name of the parameter.
        parameter: &'static str,
        /// Number of entries found.
        got: usize,
        /// Number of entries needed.
        wanted: usize,
    },
    /// A count is larger than this crate accepts, or does not even fit an integer.
    TooMany {
        /// Name of what is counted.
        parameter: &'static str,
        /// The count, or `None` if it overflows.
        got: Option<usize>,
        /// The largest count accepted.
        limit: usize,
    },
    /// The record of a run would be larger than memory, or than this crate makes one.
    RecordTooLarge {
        /// Only every so many steps enter the record.
        every: usize,
        /// Rows of the record.
        rows: usize,
        /// What a row takes [bytes].
        row_bytes: usize,
        /// The largest record made [bytes].
        limit: u64,
    },
    /// A matrix that must be symmetric is not.
    NotSymmetric {
        /// Name of the matrix.
        parameter: &'static str,
        /// Row of the worst pair.
        row: usize,
        /// Column of the worst pair.
        column: usize,
        /// Difference between the two entries of that pair.
        difference: f64,
    },
    /// A symmetric matrix has a negative (or, where that is not allowed, a zero) eigenvalue.
    NotPositive {
        /// Name of the matrix.
        parameter: &'static str,
        /// Its smallest eigenvalue.
        smallest: f64,
        /// `"positive definite"` or `"positive semidefinite"`.
        wanted: &'static str,
    },
    /// A matrix that must be Hurwitz (every eigenvalue left of the imaginary axis) is not.
    NotHurwitz {
        /// Name of the matrix.
        parameter: &'static str,
        /// Its largest real part [1/s].
        max_real: f64,
    },
    /// The Riccati equation has no stabilising solution.
    NoStabilizingSolution {
        /// The attenuation level that was asked for.
        gamma: f64,
        /// The smallest level that has a solution: γ must be larger.
        gamma_opt: f64,
        /// The factor by which Q would have to be multiplied at this γ: a smaller one is admissible.
        max_scale: f64,
    },
    /// The system cannot be stabilised by this input.
    NotStabilizable {
        /// Name of the input matrix.
        parameter: &'static str,
    },
    /// The Hamiltonian matrix of a Riccati equation has an eigenvalue on the imaginary axis: no solution is stabilising.
    ModeOnAxis {
        /// Name of the weight, which would have to see that mode.
        parameter: &'static str,
        /// Its distance from the origin [rad/s].
        frequency: f64,
    },
    /// A computation with a fixed number of iterations did not reach its accuracy.
    NoConvergence {
        /// What was being computed.
        computing: &'static str,
    },
    /// Saved data is not what it claims to be.
    Damaged {
        /// What is wrong with it.
        problem: &'static str,
    },
}

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = core::result::Result<T, E>;

/// A number, in powers of ten where its digits would fill a line.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || !size.is_finite() || (1e-5..1e16).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

struct Place(&'static str, Option<usize>);

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.1 {
            Some(index) => write!(f, "{}[{index}]", self.0),
            None => f.write_str(self.0),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotFinite { parameter, index, got } => {
                write!(f, "{}: got {}, wants a finite number", Place(parameter, index), Number(got))
            }
            Self::OutOfRange { parameter, index, got, wanted } => {
                write!(f, "{}: got {}, wants {wanted}", Place(parameter, index), Number(got))
            }
            Self::WrongLength { parameter, got, wanted } => {
                write!(f, "{parameter}: got {got} entries, wants {wanted}")
            }
            Self::TooMany { parameter, got: Some(got), limit } => {
                write!(f, "{parameter}: got {got}, wants at most {limit}")
            }
            Self::TooMany { parameter, got: None, limit } => {
                write!(f, "{parameter}: got more than fit an integer, wants at most {limit}")
            }
            Self::RecordTooLarge { every, rows, row_bytes, limit } => write!(
                f,
                "record_every: got {every}, which makes a record of {:.2} GB ({rows} rows of \
                 {row_bytes} bytes), wants at most {:.2} GB and what fits memory; take a larger \
                 number, or record=\"motion\", the motion alone",
                rows as f64 * row_bytes as f64 / 1e9,
                limit as f64 / 1e9,
            ),
            Self::NotSymmetric { parameter, row, column, difference } => write!(
                f,
                "{parameter}: got {parameter}[{row}, {column}] and {parameter}[{column}, {row}] \
                 {difference:e} apart, wants a symmetric matrix"
            ),
            Self::NotPositive { parameter, smallest, wanted } => write!(
                f,
                "{parameter}: got smallest eigenvalue {smallest:e}, wants a {wanted} matrix"
            ),
            Self::NotHurwitz { parameter, max_real } => write!(
                f,
                "{parameter}: got an eigenvalue with real part {max_real:e} 1/s, wants all real \
                 parts negative"
            ),
            Self::NoStabilizingSolution { gamma, gamma_opt, max_scale } => write!(
                f,
                "gamma: got {gamma}, wants more than {gamma_opt:.10} for this Q; or at this gamma, \
                 multiply Q by less than {max_scale:.10}"
            ),
            Self::NotStabilizable { parameter } => write!(
                f,
                "{parameter}: got an input that does not reach every unstable mode of A, wants a \
                 stabilisable pair (A, {parameter})"
            ),
            Self::ModeOnAxis { parameter, frequency } => write!(
                f,
                "{parameter}: got a Hamiltonian matrix with an eigenvalue on the imaginary axis, or \
                 too near to tell, at {frequency:e} rad/s, so that no solution is stabilising; wants \
                 a {parameter} that sees every such mode of A, or, if it is indefinite, a larger one"
            ),
            Self::NoConvergence { computing } => write!(
                f,
                "{computing}: did not reach its accuracy in the iterations allowed; rescale the \
                 problem so that its entries are of similar size"
            ),
            Self::Damaged { problem } => write!(f, "saved state: {problem}"),
        }
    }
}

impl core::error::Error for Error {}

/// Refuses NaN and infinities in `values`.
pub(crate) fn finite(parameter: &'static str, values: &[f64]) -> Result<()> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::NotFinite { parameter, index: index_of(values, i), got: values[i] }),
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
    match values.iter().position(|&v| !accept(v)) {
        None => Ok(()),
        Some(i) => {
            Err(Error::OutOfRange { parameter, index: index_of(values, i), got: values[i], wanted })
        }
    }
}

fn index_of(values: &[f64], i: usize) -> Option<usize> {
    (values.len() > 1).then_some(i)
}
