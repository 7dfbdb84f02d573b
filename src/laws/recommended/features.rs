//! What the torque of a joint is made of, a column a parameter:
//!
//! | columns | of joint n | what |
//! |---|---|---|
//! | K | those from the first that acts on it | inertial regressor Y(q_d, q̇_d, q̈_d) |
//! | 4 a joint | its own | tanh(v/.005), tanh(v/.05), tanh(v/.5), v: friction |
//! | R a joint | its own | residual basis ξ(q_d, q̇_d, q̈_d) and a constant, if there is one |
//!
//! Three widths, so that no width of the friction needs to be known.

use super::regression::{Row, stride};
use crate::arm::Parametric;
use crate::control::{Inputs, Sample};
use crate::fuzzy::FuzzyBasis;
use crate::math::{FNV_START, Real, Vector, fnv_of};

/// Widths of the steps of friction [rad/s].
pub(super) const WIDTHS: [f64; 3] = [0.005, 0.05, 0.5];
/// Columns of friction of a joint.
pub(super) const FRICTION: usize = WIDTHS.len() + 1;
/// Share of the largest torque of a joint that each column of its own may be, before it is learnt.
const OWN: f64 = 0.1;
/// Share of its parameters that each link may be off, before that is learnt.
const LINK: f64 = 1.0;
/// Where a link's mass may be \[m\].
const REACH: f64 = 0.15;

/// What is learnt.
#[derive(Clone, Debug, Default)]
pub struct Learns {
    /// Of the inertial parameters, those of the last link alone, and so of a load that it carries.
    pub payload_only: bool,
    /// A basis for what no parameter describes, and its inputs. What it learns does not hold on
    /// another path.
    pub residual: Option<(FuzzyBasis, Inputs)>,
}

/// A basis for what no parameter describes, and its inputs.
#[derive(Clone, Debug)]
pub(super) struct Residual {
    basis: FuzzyBasis,
    inputs: Inputs,
}

impl Residual {
    /// Columns of a joint, the constant with them.
    fn columns(&self) -> usize {
        self.basis.rules() + 1
    }

    /// Scratch for [`write`](Self::write).
    fn work(&self, joints: usize) -> usize {
        self.inputs.len(joints) + self.basis.work_len()
    }

    /// The columns of a sample.
    pub fn write<const N: usize>(&self, seen: &Sample<N>, columns: &mut [f64], work: &mut [f64]) {
        let Some((last, xi)) = columns.split_last_mut() else { return };
        let (x, work) = work.split_at_mut(self.inputs.len(N));
        self.inputs.gather(seen, x);
        // A sample is finite, and the lengths are right.
        _ = self.basis.evaluate(x, work, xi);
        *last = 1.0;
    }
}

/// How many columns there are, and where.
#[derive(Clone, Debug)]
pub(super) struct Shape<const N: usize> {
    /// Inertial parameters, and the first of each joint that is learnt.
    inertial: usize,
    first: [usize; N],
    pub residual: Option<Residual>,
    /// Largest torque of each joint, over 4 [N·m].
    scale: [f64; N],
}

impl<const N: usize> Shape<N> {
    /// Inertial parameters.
    #[cfg(feature = "std")]
    pub fn inertial(&self) -> usize {
        self.inertial
    }

    /// Whether there are as many columns at the same places in the other.
    #[cfg(feature = "std")]
    pub fn counts_as(&self, other: &Self) -> bool {
        let counts = |it: &Self| (it.inertial, it.first, it.residuals());
        counts(self) == counts(other)
    }

    /// Columns of the residual of a joint.
    fn residuals(&self) -> usize {
        self.residual.as_ref().map_or(0, Residual::columns)
    }

    /// Columns of a joint's own.
    pub fn own(&self) -> usize {
        FRICTION + self.residuals()
    }

    /// Scratch for the columns of the residual.
    pub fn work(&self) -> usize {
        self.residual.as_ref().map_or(0, |residual| residual.work(N))
    }

    /// Where those are in a sample's columns.
    pub fn places(&self) -> core::ops::Range<usize> {
        N * self.inertial..self.columns()
    }

    /// All parameters.
    pub fn parameters(&self) -> usize {
        self.inertial + N * self.own()
    }

    /// Length of a row of P.
    pub fn stride(&self) -> usize {
        stride(self.parameters())
    }

    /// Numbers that a sample's columns take but for those of friction: `N` rows of the inertial
    /// ones, and the residual's, which all joints share.
    pub fn columns(&self) -> usize {
        N * self.inertial + self.residuals()
    }

    /// The diagonal of P₀, with these entries of the inertial parameters.
    pub fn prior<'a>(&'a self, inertial: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let of_joint = |scale: f64| {
            let largest = OWN * scale;
            core::iter::repeat_n(largest * largest, self.own())
        };
        inertial.iter().copied().chain(self.scale.into_iter().flat_map(of_joint))
    }

    /// Where the inertial entries of joint `n` are in its row of columns.
    pub fn acting(&self, n: usize) -> core::ops::Range<usize> {
        n * self.inertial + self.first[n]..(n + 1) * self.inertial
    }

    /// Where the parameters of joint `n` are: the inertial ones that act on it, and its own.
    pub fn first(&self, n: usize) -> [usize; 2] {
        [self.first[n], self.inertial + n * self.own()]
    }

    /// The row of joint `n`, of entries in these two stretches.
    pub fn row<'a>(&self, n: usize, inertial: &'a [f64], own: &'a [f64]) -> Row<'a> {
        Row { first: self.first(n), entries: [inertial, own] }
    }
}

/// The columns of `N` joints.
#[derive(Clone, Debug)]
pub(super) struct Features<const N: usize, const K: usize> {
    pub shape: Shape<N>,
    /// The first entries of the diagonal of P₀.
    pub inertial_prior: Vector<K>,
}

impl<const N: usize, const K: usize> Features<N, K> {
    /// Those of an arm; with `payload`, of its last link's parameters alone.
    pub fn new<A>(
        arm: &A,
        scale: [f64; N],
        payload: bool,
        residual: Option<(FuzzyBasis, Inputs)>,
    ) -> Self
    where
        A: Parametric<N, K>,
    {
        let mut first = arm.first_parameters();
        if payload {
            first = [first[N - 1]; N];
        }
        let residual = residual.map(|(basis, inputs)| Residual { basis, inputs });
        Self {
            shape: Shape { inertial: K, first, residual, scale },
            inertial_prior: inertial_prior(&arm.inertial_parameters(), A::BODIES),
        }
    }

    /// The diagonal of P₀.
    pub fn prior(&self) -> impl Iterator<Item = f64> + '_ {
        self.shape.prior(self.inertial_prior.as_slice())
    }

    /// A number for the meaning of the columns.
    pub fn fingerprint(&self) -> u64 {
        let Shape { first, scale, residual, .. } = &self.shape;
        let first = first.map(|first| first as f64);
        let prior = self.inertial_prior.iter().copied();
        let known = fnv_of(FNV_START, prior.chain(*scale).chain(first));
        let Some(Residual { basis, inputs }) = residual else { return known };
        let scales =
            inputs.signals().iter().flat_map(|(signal, scale)| [*signal as u8 as f64, *scale]);
        fnv_of(known, scales.chain([f64::from_bits(basis.fingerprint())]))
    }

    /// The columns of a sample but for those of friction.
    pub fn write<A>(&self, arm: &A, seen: &Sample<N>, columns: &mut [f64], work: &mut [f64])
    where
        A: Parametric<N, K>,
    {
        let (inertial, places) = columns.split_at_mut(N * K);
        arm.regressor_rows(&seen.desired.q, &seen.desired.dq, &seen.desired.ddq, inertial);
        if let Some(residual) = &self.shape.residual {
            residual.write(seen, places, work);
        }
    }
}

/// The columns of friction at a velocity [rad/s].
#[inline(always)]
pub(super) fn friction<T: Real>(velocity: T) -> [T; FRICTION] {
    let mut columns = [velocity; FRICTION];
    for (column, width) in columns.iter_mut().zip(WIDTHS) {
        *column = (velocity / velocity.like(width)).tanh();
    }
    columns
}

/// Of the bodies of a chain, ten parameters each; of lumped parameters, as much as they are.
fn inertial_prior<const K: usize>(parameters: &Vector<K>, bodies: bool) -> Vector<K> {
    Vector::from_fn(|k, _| {
        let spread = if bodies {
            let (mass, place) = (parameters[k - k % 10], k % 10);
            mass * [1.0, REACH, REACH * REACH][usize::from(place > 0) + usize::from(place > 3)]
        } else {
            parameters[k]
        };
        LINK * LINK * spread * spread
    })
}
