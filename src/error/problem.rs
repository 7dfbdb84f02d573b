//! What can be wrong with a parameter, and how a message says it.

use core::fmt;

const NOT_REACHED: &str = "got an input that does not reach every unstable mode of A";
const NOT_CONVERGED: &str = "did not reach its accuracy in the iterations allowed; rescale the \
                             problem so that its entries are of similar size";

/// What is wrong: what was found, and what is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Problem {
    /// A number is NaN or infinite.
    #[non_exhaustive]
    NotFinite {
        /// The value found.
        got: f64,
    },
    /// A number lies outside what the parameter allows.
    #[non_exhaustive]
    OutOfRange {
        /// The value found.
        got: f64,
        /// What would be accepted, in words and units.
        wanted: &'static str,
    },
    /// A parameter that has to be there is not.
    Missing,
    /// A parameter that need not be there must be here.
    #[non_exhaustive]
    NotGiven {
        /// What would be accepted, and why, in words and units.
        wanted: &'static str,
    },
    /// A part of a controller has no form in single precision.
    #[non_exhaustive]
    NotSingle {
        /// What has one, in words.
        wanted: &'static str,
    },
    /// A parameter has the wrong number of entries.
    #[non_exhaustive]
    WrongLength {
        /// Number of entries found.
        got: usize,
        /// Number of entries needed.
        wanted: usize,
    },
    /// A count is larger than this crate accepts, or does not even fit an integer.
    #[non_exhaustive]
    TooMany {
        /// The count, or `None` if it overflows.
        got: Option<usize>,
        /// The largest count accepted.
        limit: usize,
    },
    /// The record of a run would be larger than memory, or than this crate makes one.
    #[non_exhaustive]
    RecordTooLarge {
        /// Only every so many steps enter the record.
        every: usize,
        /// Rows of the record.
        rows: usize,
        /// What a row takes \[bytes\].
        row_bytes: usize,
        /// The largest record made \[bytes\].
        limit: u64,
    },
    /// A matrix that must be symmetric is not.
    #[non_exhaustive]
    NotSymmetric {
        /// Row of the worst pair.
        row: usize,
        /// Column of the worst pair.
        column: usize,
        /// Difference between the two entries of that pair.
        difference: f64,
    },
    /// A symmetric matrix has a negative (or, where that is not allowed, a zero) eigenvalue.
    #[non_exhaustive]
    NotPositive {
        /// Its smallest eigenvalue.
        smallest: f64,
        /// `"positive definite"` or `"positive semidefinite"`.
        wanted: &'static str,
    },
    /// A matrix that must be Hurwitz (every eigenvalue left of the imaginary axis) is not.
    #[non_exhaustive]
    NotHurwitz {
        /// Its largest real part [1/s].
        max_real: f64,
    },
    /// The Riccati equation has no stabilising solution.
    #[non_exhaustive]
    NoStabilizingSolution {
        /// The attenuation level that was asked for.
        gamma: f64,
        /// The smallest level that has a solution: γ must be larger.
        gamma_opt: f64,
        /// The factor by which Q would have to be multiplied at this γ: a smaller one is
        /// admissible.
        max_scale: f64,
    },
    /// The system cannot be stabilised by this input matrix.
    NotStabilizable,
    /// The Hamiltonian matrix of a Riccati equation has an eigenvalue on the imaginary axis: no
    /// solution is stabilising. The weight would have to see that mode.
    #[non_exhaustive]
    ModeOnAxis {
        /// Its distance from the origin [rad/s].
        frequency: f64,
    },
    /// A computation with a fixed number of iterations did not reach its accuracy.
    NoConvergence,
    /// Weights lie farther from their prior than the projection of the update law lets them.
    #[non_exhaustive]
    BeyondRadius {
        /// |W − W₀| of the weights.
        norm: f64,
        /// The radius of the projection.
        radius: f64,
    },
    /// A saved state is that of another controller.
    #[non_exhaustive]
    OtherController {
        /// Whether its nominal arm is another.
        arm: bool,
        /// Whether its feedback gains are others.
        gains: bool,
        /// Whether gain, Q, γ or the modifications of its compensator are others.
        compensator: bool,
        /// Whether its sets, or their inputs, are others.
        basis: bool,
    },
    /// Saved data is not what it claims to be.
    #[non_exhaustive]
    Damaged {
        /// What is wrong with it.
        flaw: &'static str,
    },
}

impl Problem {
    /// The message after "`name`: ".
    pub(super) fn say(self, name: &str, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { got } => write!(f, "got {}, wants a finite number", Number(got)),
            Self::OutOfRange { got, wanted } => write!(f, "got {}, wants {wanted}", Number(got)),
            Self::NotSingle { wanted } => {
                write!(f, "has no form in single precision, wants {wanted}")
            }
            Self::Missing => f.write_str("is missing, wants a value"),
            Self::NotGiven { wanted } => write!(f, "got None, wants {wanted}"),
            Self::WrongLength { got, wanted } => write!(f, "got {got} entries, wants {wanted}"),
            Self::TooMany { got: Some(got), limit } => {
                write!(f, "got {got}, wants at most {limit}")
            }
            Self::TooMany { got: None, limit } => {
                write!(f, "got more than fit an integer, wants at most {limit}")
            }
            Self::RecordTooLarge { every, rows, row_bytes, limit } => {
                say_too_large(f, every, (rows, row_bytes), limit)
            }
            Self::NotSymmetric { row, column, difference } => write!(
                f,
                "got {name}[{row}, {column}] and {name}[{column}, {row}] {difference:e} apart, \
                 wants a symmetric matrix"
            ),
            Self::NotPositive { smallest, wanted } => {
                write!(f, "got smallest eigenvalue {smallest:e}, wants a {wanted} matrix")
            }
            Self::NotHurwitz { max_real } => write!(
                f,
                "got an eigenvalue with real part {max_real:e} 1/s, wants all real parts negative"
            ),
            Self::NoStabilizingSolution { gamma, gamma_opt, max_scale } => write!(
                f,
                "got {gamma}, wants more than {gamma_opt:.10} for this Q; or at this gamma, \
                 multiply Q by less than {max_scale:.10}"
            ),
            Self::NotStabilizable => {
                write!(f, "{NOT_REACHED}, wants a stabilisable pair (A, {name})")
            }
            Self::ModeOnAxis { frequency } => say_on_axis(f, name, frequency),
            Self::NoConvergence => f.write_str(NOT_CONVERGED),
            Self::BeyondRadius { norm, radius } => write!(
                f,
                "got a norm of {}, wants at most the projection_radius, {}; take a larger radius, \
                 or make them the prior by a warm start",
                Number(norm),
                Number(radius)
            ),
            Self::OtherController { arm, gains, compensator, basis } => {
                say_other(f, [arm, gains, compensator, basis])
            }
            Self::Damaged { flaw } => f.write_str(flaw),
        }
    }
}

fn say_too_large(
    f: &mut fmt::Formatter<'_>,
    every: usize,
    (rows, row_bytes): (usize, usize),
    limit: u64,
) -> fmt::Result {
    write!(
        f,
        "got {every}, which makes a record of {:.2} GB ({rows} rows of {row_bytes} bytes), wants \
         at most {:.2} GB and what fits memory; take a larger number, or record=\"motion\", the \
         motion alone",
        rows as f64 * row_bytes as f64 / 1e9,
        limit as f64 / 1e9,
    )
}

fn say_on_axis(f: &mut fmt::Formatter<'_>, name: &str, frequency: f64) -> fmt::Result {
    write!(
        f,
        "got a Hamiltonian matrix with an eigenvalue on the imaginary axis, or too near to tell, \
         at {frequency:e} rad/s, so that no solution is stabilising; wants a {name} that sees \
         every such mode of A, or, if it is indefinite, a larger one"
    )
}

const PARTS: [&str; 4] = [
    "another nominal arm",
    "other gains kp, kv",
    "another compensator (gain, q, gamma, modifications)",
    "another basis (sets, inputs)",
];

fn say_other(f: &mut fmt::Formatter<'_>, differs: [bool; 4]) -> fmt::Result {
    f.write_str("it is that of a controller with ")?;
    let parts = PARTS.iter().zip(differs).filter(|(_, differs)| *differs);
    for (i, (part, _)) in parts.enumerate() {
        write!(f, "{}{part}", if i > 0 { ", " } else { "" })?;
    }
    f.write_str(": what was learnt there may be wrong here")
}

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
