//! Mass distributions that no rigid body can have: which they are, and what is done about them.
//!
//! A body has `Σ = ∫ r rᵀ dm ⪰ 0` about its centre of mass; with `Σ = ½ tr(I) 1 − I` that is the
//! triangle inequality of the principal moments, and with it none of them is negative. Source:
//! Wensing, Kim and Slotine 2018, "Linear matrix inequalities for physically consistent inertial
//! parameter identification", IEEE RA-L 3(1).

use super::body::Inertia;
use super::place::{InertiaNames, Of};
use crate::eigen::symmetric_eigenvalues;
use crate::error::{Error, Result};
use crate::math::{Matrix, sqrt};

/// The principal moments may miss the triangle inequality by this share of the largest: figures are
/// rounded.
const MOMENTS: f64 = 1e-6;
/// They may also miss it by what moving the mass by a micrometre changes [m²]: files have −1e-20
/// where they mean zero.
const SPECK: f64 = 1e-12;
/// Entries of the moments across the diagonal may differ by this share of the largest.
const SYMMETRY: f64 = 1e-9;
/// What the moments must be.
pub(crate) const SYMMETRIC: &str = "a symmetric matrix";
/// Sweeps of Jacobi's method; three entries off the diagonal are rounding after four or five.
const SWEEPS: usize = 10;

/// What is done about a mass distribution that no rigid body can have. In every case M must be
/// positive definite at the positions that are tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unphysical {
    /// It is refused.
    #[default]
    Refuse,
    /// It is taken as it stands, as Pinocchio does.
    Note,
    /// The [nearest](Inertia::nearest) one is taken.
    Nearest,
}

/// Why no rigid body can have a mass distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Flaw {
    /// This mass is negative \[kg\].
    Mass(f64),
    /// These principal moments, in ascending order, break the triangle inequality [kg·m²].
    Moments([f64; 3]),
    /// There are moments, and no mass.
    Massless,
}

impl Flaw {
    /// What would be accepted instead.
    pub fn wanted(&self) -> &'static str {
        match self {
            Self::Mass(_) => "a number >= 0",
            Self::Moments([least, _, most]) if *least < -MOMENTS * most => {
                "none negative among the principal moments"
            }
            Self::Moments(_) => {
                "the largest principal moment at most the sum of the other two (the triangle \
                 inequality of every rigid body)"
            }
            Self::Massless => "a number > 0 where there are moments",
        }
    }

    fn error(&self, names: InertiaNames, joint: Option<usize>) -> Error {
        let (parameter, got) = match *self {
            Self::Mass(mass) => (names.mass, mass),
            Self::Moments([least, _, most]) if least < -MOMENTS * most => (names.moments, least),
            Self::Moments([.., most]) => (names.moments, most),
            Self::Massless => (names.mass, 0.0),
        };
        Error::out_of_range(parameter, got, self.wanted()).at(joint)
    }
}

impl Unphysical {
    /// Its name in files and in Python: "refuse", "note" or "nearest".
    pub const fn name(self) -> &'static str {
        match self {
            Self::Refuse => "refuse",
            Self::Note => "note",
            Self::Nearest => "nearest",
        }
    }

    /// What is taken for `inertia`. Numbers that are not finite and moments that are not symmetric
    /// are refused.
    pub(super) fn take(
        self,
        inertia: &Inertia,
        names: InertiaNames,
        joint: Option<usize>,
    ) -> Result<Inertia> {
        check_form(inertia, names, joint)?;
        let Some(flaw) = inertia.flaw()? else { return Ok(*inertia) };
        match (self, flaw) {
            (Self::Note, _) | (Self::Nearest, Flaw::Massless) => Ok(*inertia),
            (Self::Nearest, Flaw::Moments(_)) => Ok(inertia.projected()),
            _ => Err(flaw.error(names, joint)),
        }
    }
}

impl Inertia {
    /// The nearest mass distribution that a rigid body can have; a valid one stays as it is. Mass,
    /// centre of mass and principal axes are kept. The negative part of Σ about the centre of mass
    /// is left out, which gives the nearest `Σ ⪰ 0` in the Frobenius norm. This choice does not
    /// depend on the frame, and it keeps the weight, which is known best. It only ever adds to I,
    /// so no mass matrix becomes smaller. Moments without mass are kept: they are a limit of
    /// bodies.
    ///
    /// # Errors
    /// As [`validate`](Self::validate), except for moments that no rigid body can have.
    pub fn nearest(&self) -> Result<Self> {
        Unphysical::Nearest.take(self, InertiaNames::ALONE, None)
    }

    /// The principal moments about the centre of mass, in ascending order [kg·m²].
    ///
    /// # Errors
    /// `NotFinite` for moments that are not finite.
    pub fn principal_moments(&self) -> Result<[f64; 3]> {
        let i = &self.moments;
        let mut principal = symmetric_eigenvalues(&((i + i.transpose()) * 0.5))?;
        principal.sort_unstable_by(f64::total_cmp);
        Ok(principal)
    }

    /// Refuses numbers that are not finite, and moments that are not symmetric.
    #[cfg(feature = "std")]
    pub(crate) fn check_form(&self) -> Result<()> {
        check_form(self, InertiaNames::ALONE, None)
    }

    /// Why no rigid body can have it, beyond rounding. Its numbers are finite and its moments
    /// symmetric.
    pub(crate) fn flaw(&self) -> Result<Option<Flaw>> {
        let principal = self.principal_moments()?;
        let [least, middle, most] = principal;
        let allowed = (MOMENTS * most.abs().max(least.abs())).max(SPECK * self.mass);
        let flaws = [
            (self.mass < 0.0, Flaw::Mass(self.mass)),
            // The least is at least as much below zero as the largest is above the sum.
            (least + middle - most < -allowed, Flaw::Moments(principal)),
            (self.mass == 0.0 && most > 0.0, Flaw::Massless),
        ];
        Ok(flaws.into_iter().find_map(|(found, flaw)| found.then_some(flaw)))
    }

    /// Without the negative part of Σ.
    fn projected(&self) -> Self {
        let (values, axes) = symmetric_eigen(&second_moments(&self.moments));
        let kept = Matrix::<3>::from_diagonal(&values.map(|value| value.max(0.0)).into());
        let moments = moments_of(&(axes * kept * axes.transpose()));
        Self { moments: (moments + moments.transpose()) * 0.5, ..*self }
    }
}

/// Σ = ½ tr(I) 1 − I.
pub(super) fn second_moments(moments: &Matrix<3>) -> Matrix<3> {
    Matrix::<3>::identity() * (0.5 * moments.trace()) - moments
}

/// I = tr(Σ) 1 − Σ.
pub(super) fn moments_of(sigma: &Matrix<3>) -> Matrix<3> {
    Matrix::<3>::identity() * sigma.trace() - sigma
}

/// Refuses what is not finite, and moments that are not symmetric.
fn check_form(inertia: &Inertia, names: InertiaNames, joint: Option<usize>) -> Result<()> {
    let of = |parameter| Of { parameter, joint };
    of(names.mass).finite(&[inertia.mass])?;
    of(names.com).finite(inertia.com.as_slice())?;
    let i = &inertia.moments;
    of(names.moments).finite(i.as_slice())?;
    let off = (i - i.transpose()).amax();
    of(names.moments).within(off, off <= SYMMETRY * i.amax(), SYMMETRIC)
}

/// Eigenvalues and eigenvectors (columns) by Jacobi's rotations.
fn symmetric_eigen(of: &Matrix<3>) -> ([f64; 3], Matrix<3>) {
    let (mut a, mut axes) = (*of, Matrix::<3>::identity());
    for (p, q) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(3 * SWEEPS) {
        if a[(p, q)] == 0.0 {
            continue;
        }
        // t = tan of the angle that clears a_pq, the smaller of two.
        let ratio = 0.5 * (a[(q, q)] - a[(p, p)]) / a[(p, q)];
        let t = 1.0_f64.copysign(ratio) / (ratio.abs() + sqrt(ratio * ratio + 1.0));
        let c = 1.0 / sqrt(t * t + 1.0);
        let mut turn = Matrix::<3>::identity();
        (turn[(p, p)], turn[(q, q)]) = (c, c);
        (turn[(p, q)], turn[(q, p)]) = (t * c, -t * c);
        a = turn.transpose() * a * turn;
        axes *= turn;
    }
    ([a[(0, 0)], a[(1, 1)], a[(2, 2)]], axes)
}
