//! Arms of one kind side by side, an arm a lane.

use super::serial::Chain;
use super::two_link::Planar;
use super::{Factor, Serial, TwoLink};
use crate::math::{Abreast, LANES, Matrix, Real, Vector};

/// Arms of one kind side by side, without friction and stops.
#[derive(Clone, Debug)]
pub struct ArmsAbreast<const N: usize>(Kind<N>);

#[derive(Clone, Debug)]
enum Kind<const N: usize> {
    /// Only where `N` is 2.
    TwoLink(Planar<Abreast>),
    Chain(Box<Chain<N, Abreast>>),
}

impl<const N: usize> ArmsAbreast<N> {
    /// Two-link arms; `None` if one of them has friction, or only some have gravity.
    pub fn of_two_links(each: [&TwoLink; LANES]) -> Option<Self> {
        let [first, ..] = each;
        let alike = each
            .iter()
            .all(|arm| arm.is_frictionless() && arm.planar.has_gravity == first.planar.has_gravity);
        let each = each.map(|arm| &arm.planar);
        let of = |number: fn(&Planar) -> f64| Abreast::of(each, number);
        (alike && N == 2).then(|| {
            Self(Kind::TwoLink(Planar {
                theta: [of(|it| it.theta[0]), of(|it| it.theta[1]), of(|it| it.theta[2])],
                det_0: of(|it| it.det_0),
                weight: [of(|it| it.weight[0]), of(|it| it.weight[1])],
                has_gravity: first.planar.has_gravity,
            }))
        })
    }

    /// Chains; `None` if one of them has friction or stops, or their joints are not of one kind.
    pub fn of_chains(each: [&Serial<N>; LANES]) -> Option<Self> {
        let free = each.iter().all(|arm| arm.is_free());
        let chain = free.then(|| Chain::abreast(each.map(Serial::chain)))??;
        Some(Self(Kind::Chain(Box::new(chain))))
    }

    /// M(q) and H(q, q̇) = C q̇ + G of each.
    #[inline(always)]
    pub fn mass_matrix_and_bias(
        &self,
        q: &Vector<N, Abreast>,
        dq: &Vector<N, Abreast>,
    ) -> (Matrix<N, Abreast>, Vector<N, Abreast>) {
        match &self.0 {
            Kind::TwoLink(arms) => {
                let (q, dq) = (two(q), two(dq));
                let trig = q[1].sin_cos();
                let (mass, bias) = (arms.mass(trig.1), arms.rigid_at(q[0], trig, &dq));
                let mass = Matrix::from_fn(|i, j| mass[(i.min(1), j.min(1))]);
                (mass, back(&bias))
            }
            Kind::Chain(chain) => {
                let turns = chain.turns(q);
                (chain.mass_matrices(&turns), chain.bias(&turns, dq))
            }
        }
    }

    /// q̈ = M⁻¹(τ − H) of each.
    #[inline(always)]
    pub fn forward_dynamics(
        &self,
        q: &Vector<N, Abreast>,
        dq: &Vector<N, Abreast>,
        tau: &Vector<N, Abreast>,
    ) -> Vector<N, Abreast> {
        match &self.0 {
            Kind::TwoLink(arms) => {
                let (q, dq) = (two(q), two(dq));
                let trig = q[1].sin_cos();
                let bias = arms.rigid_at(q[0], trig, &dq);
                let tau = two(tau);
                back(&arms.solve(trig, [tau[0] - bias[0], tau[1] - bias[1]]))
            }
            Kind::Chain(chain) => {
                let turns = chain.turns(q);
                let bias = chain.bias(&turns, dq);
                let net = Vector::from_fn(|i, _| tau[i] - bias[i]);
                Factor::of(&chain.mass_matrices(&turns)).solve(&net)
            }
        }
    }
}

/// The entries of two joints. Nothing is left of this where `N` is 2; elsewhere nobody asks.
#[inline(always)]
fn two<const N: usize>(x: &Vector<N, Abreast>) -> Vector<2, Abreast> {
    Vector::<2, Abreast>::from_fn(|i, _| x[i.min(N - 1)])
}

/// The way back.
#[inline(always)]
fn back<const N: usize>(x: &Vector<2, Abreast>) -> Vector<N, Abreast> {
    Vector::from_fn(|i, _| x[i.min(1)])
}
