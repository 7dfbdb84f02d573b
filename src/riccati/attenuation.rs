//! `AᵀP + PA + γ⁻² P B BᵀP + Q = 0` for a Hurwitz A and Q ≥ 0, and the smallest γ.

use nalgebra::{DefaultAllocator, Dim};

use super::certificate::{Certified, Wanted, certify, check_symmetric, definiteness};
use super::dense::{Modes, Room, Square, Tall};
use super::doubling::solve;
use super::gamma::{check_gamma, scale};
use super::peak::{Limit, peak};
use super::scaling::Scaled;
use crate::eigen::{largest_real, spectrum};
use crate::error::{Error, Result, finite};

/// γ this close above γ_opt, relative, cannot be told from it.
const INDISTINCT: f64 = 1e-9;
/// γ above γ_opt by this factor is believed to have a solution because the search has found no
/// frequency with a larger gain.
const SEARCHED: f64 = 1.001;
const UNSOLVED: Error = Error::no_convergence("riccati solution");

/// See [`super::bounded_real`].
pub(super) fn bounded_real<S: Dim, M: Dim>(
    a: &Square<S>,
    b: &Tall<S, M>,
    q: &Square<S>,
    gamma: f64,
) -> Result<Certified<S>>
where
    DefaultAllocator: Room<S, M> + Room<S, S> + Room<M, M>,
{
    check_gamma(gamma)?;
    let Plant { q, modes } = Plant::check(a, b, q)?;
    let scaled = Scaled::new(a, &(b / gamma), &q, true);
    let slow = modes.map(|z| z / scaled.time);
    if let Some(found) = solve(&scaled.balanced, &slow, false) {
        return certify(&scaled, &found.p, Wanted::POSITIVE);
    }
    let Limit { gamma_opt, proven } = peak(a, b, &q, &modes)?;
    if gamma <= gamma_opt * (1.0 + INDISTINCT) {
        let max_scale = scale(gamma, gamma_opt);
        return Err(Error::no_stabilizing_solution(gamma, gamma_opt, max_scale));
    }
    // Rounding hid the proof, near the limit or because P is large; the search for the peak
    // supplies it.
    let exists = gamma >= proven.min(gamma_opt * SEARCHED);
    let known = exists.then(|| solve(&scaled.balanced, &slow, true)).flatten();
    certify(&scaled, &known.ok_or(UNSOLVED)?.p, Wanted::POSITIVE)
}

/// See [`super::gamma_opt`].
pub(super) fn gamma_opt<S: Dim, M: Dim>(a: &Square<S>, b: &Tall<S, M>, q: &Square<S>) -> Result<f64>
where
    DefaultAllocator: Room<S, M> + Room<S, S> + Room<M, M>,
{
    let Plant { q, modes } = Plant::check(a, b, q)?;
    Ok(peak(a, b, &q, &modes)?.gamma_opt)
}

/// What the checks of A, B and Q leave: Q made exactly symmetric, and the eigenvalues of A.
struct Plant<S: Dim>
where
    DefaultAllocator: Room<S, S>,
{
    q: Square<S>,
    modes: Modes<S>,
}

impl<S: Dim> Plant<S>
where
    DefaultAllocator: Room<S, S>,
{
    fn check<M: Dim>(a: &Square<S>, b: &Tall<S, M>, q: &Square<S>) -> Result<Self>
    where
        DefaultAllocator: Room<S, M>,
    {
        finite("b", b.as_slice())?;
        let q = check_symmetric("q", q)?;
        let smallest = definiteness(&q)?;
        if smallest < 0.0 {
            return Err(Error::not_positive("q", smallest, "positive semidefinite"));
        }
        let modes = spectrum(a)?;
        let max_real = largest_real(modes.as_slice());
        if max_real < 0.0 { Ok(Self { q, modes }) } else { Err(Error::not_hurwitz("a", max_real)) }
    }
}
