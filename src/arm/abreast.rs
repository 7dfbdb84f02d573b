//! Arms of one kind side by side, an arm a lane.

use pulp::Simd;

use super::Factor;
use super::planar::Planar;
use super::serial::{Chain, Turn};
use super::side::{Form, Side};
use crate::math::{Abreast, LANES, Load, Matrix, Real, Register, Vector};

/// Arms of one kind side by side, without friction and stops.
#[derive(Clone, Debug)]
pub(crate) struct ArmsAbreast<const N: usize>(Kind<N>);

#[derive(Clone, Debug)]
enum Kind<const N: usize> {
    /// Only where `N` is 2.
    TwoLink(Box<Planar<Abreast>>),
    Chain(Box<Chain<N, Abreast>>),
}

impl<const N: usize> ArmsAbreast<N> {
    /// These arms; `None` if they are not of one kind, only some have gravity, or their joints are
    /// not of the same kinds.
    pub fn of(each: [Side<'_, N>; LANES]) -> Option<Self> {
        if let Form::TwoLink(first) = each[0].0 {
            let mut arms = [first; LANES];
            for (arm, side) in arms.iter_mut().zip(each) {
                let Form::TwoLink(own) = side.0 else { return None };
                *arm = own;
            }
            return Planar::abreast(arms).map(Box::new).map(Kind::TwoLink).map(Self);
        }
        let Form::Chain(first) = each[0].0 else { return None };
        let mut chains = [first; LANES];
        for (chain, side) in chains.iter_mut().zip(each) {
            let Form::Chain(own) = side.0 else { return None };
            *chain = own;
        }
        Chain::abreast(chains).map(Box::new).map(Kind::Chain).map(Self)
    }

    /// Whether the pose of one is that of the other, in every lane.
    pub fn pose_as(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Kind::TwoLink(_), Kind::TwoLink(_)) => true,
            (Kind::Chain(one), Kind::Chain(other)) => one.poses_as(other),
            _ => false,
        }
    }

    /// A part of them at q.
    #[inline(always)]
    pub fn poses<S: Simd>(
        &self,
        (simd, part): (S, usize),
        q: &Vector<N, Register<S>>,
    ) -> Poses<N, Register<S>> {
        match &self.0 {
            Kind::TwoLink(_) => {
                let q = two(q);
                Poses::TwoLink(q[0], q[1].sin_cos())
            }
            Kind::Chain(chain) => Poses::Chain(chain.turns_of((simd, part), q)),
        }
    }

    /// M(q) and H(q, q̇) = C q̇ + G of a part of them.
    #[inline(always)]
    pub fn mass_matrix_and_bias<S: Simd>(
        &self,
        (simd, part): (S, usize),
        poses: &Poses<N, Register<S>>,
        dq: &Vector<N, Register<S>>,
    ) -> (Matrix<N, Register<S>>, Vector<N, Register<S>>) {
        match (&self.0, poses) {
            (Kind::TwoLink(arms), &Poses::TwoLink(q1, trig)) => {
                let arms = arms.load(simd, part);
                let (own, bias) = (arms.mass(trig.1), arms.rigid_at(q1, trig, &two(dq)));
                let mut mass = Matrix::<N, _>::repeat(own[(0, 0)]);
                for i in 0..N {
                    for j in 0..N {
                        mass[(i, j)] = own[(i.min(1), j.min(1))];
                    }
                }
                (mass, back(&bias))
            }
            (Kind::Chain(chain), Poses::Chain(turns)) => {
                let chain = chain.load(simd, part);
                (chain.mass_matrices(turns), chain.bias(turns, dq))
            }
            // Poses of other arms: nobody asks.
            _ => (Matrix::<N, _>::repeat(dq[0]), *dq),
        }
    }

    /// q̈ = M⁻¹(τ − H) of a part of them.
    #[inline(always)]
    pub fn forward_dynamics<S: Simd>(
        &self,
        (simd, part): (S, usize),
        poses: &Poses<N, Register<S>>,
        dq: &Vector<N, Register<S>>,
        tau: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>> {
        match (&self.0, poses) {
            (Kind::TwoLink(arms), &Poses::TwoLink(q1, trig)) => {
                let (arms, tau) = (arms.load(simd, part), two(tau));
                let bias = arms.rigid_at(q1, trig, &two(dq));
                back(&arms.solve(trig, [tau[0] - bias[0], tau[1] - bias[1]]))
            }
            (Kind::Chain(chain), Poses::Chain(turns)) => {
                let chain = chain.load(simd, part);
                let (bias, mut net) = (chain.bias(turns, dq), *tau);
                for n in 0..N {
                    net[n] -= bias[n];
                }
                Factor::of(&chain.mass_matrices(turns)).solve(&net)
            }
            // Poses of other arms: nobody asks.
            _ => *tau,
        }
    }
}

/// What arms need to know of a pose, in registers.
pub(crate) enum Poses<const N: usize, T> {
    /// q₁, and sine and cosine of q₂.
    TwoLink(T, (T, T)),
    /// The frames.
    Chain([Turn<T>; N]),
}

impl Planar<Abreast> {
    /// Arms of which all have gravity, or none; `None` if they are others.
    fn abreast(each: [&Planar; LANES]) -> Option<Self> {
        let has_gravity = each[0].has_gravity;
        let of = |number: fn(&Planar) -> f64| Abreast::of(each, number);
        each.iter().all(|arm| arm.has_gravity == has_gravity).then(|| Self {
            theta: [of(|it| it.theta[0]), of(|it| it.theta[1]), of(|it| it.theta[2])],
            det_0: of(|it| it.det_0),
            weight: [of(|it| it.weight[0]), of(|it| it.weight[1])],
            has_gravity,
        })
    }
}

impl Load for Planar<Abreast> {
    type In<S: Simd> = Planar<Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        Planar {
            theta: self.theta.load(simd, part),
            det_0: self.det_0.load(simd, part),
            weight: self.weight.load(simd, part),
            has_gravity: self.has_gravity,
        }
    }
}

/// The entries of two joints. Nothing is left of this where `N` is 2; elsewhere nobody asks.
#[inline(always)]
fn two<const N: usize, T: Real>(x: &Vector<N, T>) -> Vector<2, T> {
    Vector::<2, T>::new(x[0], x[1.min(N - 1)])
}

/// The way back.
#[inline(always)]
fn back<const N: usize, T: Real>(x: &Vector<2, T>) -> Vector<N, T> {
    let mut all = Vector::<N, T>::repeat(x[0]);
    for n in 1..N {
        all[n] = x[1];
    }
    all
}
