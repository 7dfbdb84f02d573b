//! Arms of one kind side by side, an arm a lane.

use core::array::from_fn;

use pulp::{Arch, Simd, WithSimd};

use super::planar::{Planar, back, two};
use super::serial::{Chain, Frames, Links, Part};
use super::side::{Form, Side};
use super::{Factor, JointFriction};
use crate::math::{
    Abreast, LANES, Load, Matrix, Real, Register, Vector, column, dot, in_lanes, none_missing,
};

/// Arms side by side, without stops and dry friction.
#[derive(Clone, Debug)]
pub(crate) struct ArmsAbreast<const N: usize> {
    pub kind: Kind<N>,
    /// `None` if no joint has any.
    pub friction: Option<Box<Frictions<N>>>,
}

/// Their rigid bodies.
#[derive(Clone, Debug)]
pub(crate) enum Kind<const N: usize> {
    /// Only where `N` is 2.
    TwoLinks(Box<Planar<Abreast>>),
    Chains(Box<Chain<N, Abreast>>),
}

impl<const N: usize> ArmsAbreast<N> {
    /// These arms; `None` if they are not of one kind, only some have gravity, or friction, or dry
    /// friction in a joint, or their joints are not of the same kinds.
    pub fn of(each: [Side<'_, N>; LANES]) -> Option<Self> {
        let frictions = each.each_ref().map(|side| side.friction);
        let friction = if frictions.iter().all(Option::is_none) {
            None
        } else {
            Some(Box::new(Frictions::of(none_missing(frictions)?)?))
        };
        Some(Self { kind: Kind::of(each)?, friction })
    }

    /// Whether one moves as the other at every q and q̇, in every lane; `None` where they are not
    /// of one kind.
    pub fn moves_as(&self, other: &Self) -> Option<bool> {
        match (&self.kind, &other.kind) {
            (Kind::TwoLinks(one), Kind::TwoLinks(other)) => Some(one.moves_as(other)),
            (Kind::Chains(one), Kind::Chains(other)) => Some(one.moves_as(other)),
            _ => None,
        }
    }

    /// Writes f(q̇), if they have friction.
    pub fn resist(&self, arch: Arch, dq: &Vector<N, Abreast>, torque: &mut Vector<N, Abreast>) {
        if let Some(friction) = &self.friction {
            in_lanes(arch, Resist { friction, dq, torque });
        }
    }
}

impl<const N: usize> Kind<N> {
    fn of(each: [Side<'_, N>; LANES]) -> Option<Self> {
        if let Form::TwoLink(first) = each[0].form {
            let mut arms = [first; LANES];
            for (arm, side) in arms.iter_mut().zip(each) {
                let Form::TwoLink(own) = side.form else { return None };
                *arm = own;
            }
            return Planar::abreast(arms).map(Box::new).map(Self::TwoLinks);
        }
        let Form::Chain(first) = each[0].form else { return None };
        let mut chains = [first; LANES];
        for (chain, side) in chains.iter_mut().zip(each) {
            let Form::Chain(own) = side.form else { return None };
            *chain = own;
        }
        Chain::abreast(chains).map(Box::new).map(Self::Chains)
    }
}

/// The friction of arms side by side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frictions<const N: usize> {
    pub joints: [JointFriction<Abreast>; N],
    /// Bounds of ∂f/∂q̇ and of −∂f/∂q̇ [N·m·s/rad].
    pub steepest: [Abreast; N],
    pub falls: [Abreast; N],
}

impl<const N: usize> Frictions<N> {
    /// These; `None` if only some have a dry part in a joint.
    fn of(each: [[JointFriction; N]; LANES]) -> Option<Self> {
        let of = |n: usize, number: fn(&JointFriction) -> f64| {
            Abreast(each.map(|joints| number(&joints[n])))
        };
        let dry = each.map(|joints| joints.map(|joint| joint.is_viscous()));
        dry.iter().all(|own| *own == dry[0]).then(|| Self {
            joints: from_fn(|n| JointFriction {
                viscous: of(n, |it| it.viscous),
                coulomb: [of(n, |it| it.coulomb[0]), of(n, |it| it.coulomb[1])],
                stribeck: of(n, |it| it.stribeck),
                stribeck_speed: of(n, |it| it.stribeck_speed),
                smoothing: of(n, |it| it.smoothing),
            }),
            steepest: from_fn(|n| of(n, JointFriction::steepest)),
            falls: from_fn(|n| of(n, JointFriction::falls)),
        })
    }
}

struct Resist<'a, const N: usize> {
    friction: &'a Frictions<N>,
    dq: &'a Vector<N, Abreast>,
    torque: &'a mut Vector<N, Abreast>,
}

impl<const N: usize> WithSimd for Resist<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { friction, dq, torque } = self;
        for part in 0..Register::<S>::PARTS {
            for n in 0..N {
                let joint = friction.joints[n].load(simd, part);
                joint.torque(dq[n].load(simd, part)).store(&mut torque[n], part);
            }
        }
    }
}

impl Load for JointFriction<Abreast> {
    type In<S: Simd> = JointFriction<Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { viscous, coulomb, stribeck, stribeck_speed, smoothing } = self;
        JointFriction {
            viscous: viscous.load(simd, part),
            coulomb: coulomb.load(simd, part),
            stribeck: stribeck.load(simd, part),
            stribeck_speed: stribeck_speed.load(simd, part),
            smoothing: smoothing.load(simd, part),
        }
    }
}

/// What arms of one kind side by side do, a part at a time, with a place for what they know of a
/// motion: the same for all that move alike. Chains keep their frames there, and arms of two links
/// sines and cosines.
pub(crate) trait Alike<const N: usize> {
    /// Whether that is a few numbers. They are found as soon as the motion is known, beside other
    /// work; more would have left the nearest cache before it is used.
    const FEW: bool;

    /// Finds how they move at q and q̇.
    fn find<S: Simd>(
        &self,
        at: (S, usize),
        motion: (&Vector<N, Register<S>>, &Vector<N, Register<S>>),
        frames: &mut Frames<N, Abreast>,
    );

    /// Writes M.
    fn write_mass_matrix<S: Simd>(
        &self,
        at: (S, usize),
        frames: &mut Frames<N, Abreast>,
        mass: &mut Matrix<N, Register<S>>,
    );

    /// C q̇ + G.
    fn bias<S: Simd>(
        &self,
        at: (S, usize),
        frames: &Frames<N, Abreast>,
        dq: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>>;

    /// Writes both.
    #[inline(always)]
    fn write_dynamics<S: Simd>(
        &self,
        at: (S, usize),
        (frames, dq): (&mut Frames<N, Abreast>, &Vector<N, Register<S>>),
        (mass, bias): Dynamics<'_, N, S>,
    ) {
        self.write_mass_matrix(at, &mut *frames, mass);
        *bias = self.bias(at, frames, dq);
    }

    /// Cᵀ q̇.
    fn carried<S: Simd>(
        &self,
        at: (S, usize),
        frames: &mut Frames<N, Abreast>,
        dq: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>>;

    /// Writes the entries of Y(q, q̇, q̈) that are not zero for every motion, row by row.
    fn write_regressor<S: Simd>(
        &self,
        at: (S, usize),
        frames: &Frames<N, Abreast>,
        motion: [&Vector<N, Register<S>>; 3],
        rows: &mut [Abreast],
    );

    /// M⁻¹ `net`.
    fn solve<S: Simd>(
        &self,
        at: (S, usize),
        frames: &Frames<N, Abreast>,
        mass: &Matrix<N, Register<S>>,
        net: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>>;
}

/// Places for M and C q̇ + G.
pub(crate) type Dynamics<'a, const N: usize, S> =
    (&'a mut Matrix<N, Register<S>>, &'a mut Vector<N, Register<S>>);

impl<const N: usize> Alike<N> for Planar<Abreast> {
    const FEW: bool = true;

    #[inline(always)]
    fn find<S: Simd>(
        &self,
        (simd, part): (S, usize),
        (q, _): (&Vector<N, Register<S>>, &Vector<N, Register<S>>),
        frames: &mut Frames<N, Abreast>,
    ) {
        let q = two(q);
        if let Some(first) = self.load(simd, part).first(q[0]) {
            frames[0].keep_angle(first, part);
        }
        frames[N - 1].keep_angle(q[1].sin_cos(), part);
    }

    #[inline(always)]
    fn write_mass_matrix<S: Simd>(
        &self,
        at: (S, usize),
        frames: &mut Frames<N, Abreast>,
        mass: &mut Matrix<N, Register<S>>,
    ) {
        *mass = self.load(at.0, at.1).mass_matrix(frames[N - 1].angle(at).1);
    }

    #[inline(always)]
    fn bias<S: Simd>(
        &self,
        at: (S, usize),
        frames: &Frames<N, Abreast>,
        dq: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>> {
        let first = if self.has_gravity { Some(frames[0].angle(at)) } else { None };
        back(&self.load(at.0, at.1).rigid_at(first, frames[N - 1].angle(at), &two(dq)))
    }

    #[inline(always)]
    fn carried<S: Simd>(
        &self,
        at: (S, usize),
        frames: &mut Frames<N, Abreast>,
        dq: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>> {
        let (dq, (sin_2, _)) = (two(dq), frames[N - 1].angle(at));
        let [first, other] = self.load(at.0, at.1).coriolis(sin_2, &dq);
        back(&column([dot(&column(first), &dq), dot(&column(other), &dq)]))
    }

    #[inline(always)]
    fn write_regressor<S: Simd>(
        &self,
        at: (S, usize),
        _: &Frames<N, Abreast>,
        [q, dq, ddq]: [&Vector<N, Register<S>>; 3],
        rows: &mut [Abreast],
    ) {
        let (q, dq, ddq) = (two(q), two(dq), two(ddq));
        let entries = self.load(at.0, at.1).regressor(&q, &dq, &dq, &ddq);
        for (to, entry) in rows.iter_mut().zip(entries.as_flattened()) {
            entry.store(to, at.1);
        }
    }

    #[inline(always)]
    fn solve<S: Simd>(
        &self,
        at: (S, usize),
        frames: &Frames<N, Abreast>,
        _: &Matrix<N, Register<S>>,
        net: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>> {
        let net = two(net);
        back(&self.load(at.0, at.1).solve(frames[N - 1].angle(at), [net[0], net[1]]))
    }
}

impl<const N: usize> Alike<N> for Chain<N, Abreast> {
    const FEW: bool = false;

    #[inline(always)]
    fn find<S: Simd>(
        &self,
        at: (S, usize),
        (q, dq): (&Vector<N, Register<S>>, &Vector<N, Register<S>>),
        frames: &mut Frames<N, Abreast>,
    ) {
        Part { chains: self, at }.find(q, dq, frames);
    }

    #[inline(always)]
    fn write_mass_matrix<S: Simd>(
        &self,
        at: (S, usize),
        frames: &mut Frames<N, Abreast>,
        mass: &mut Matrix<N, Register<S>>,
    ) {
        Part { chains: self, at }.write_mass_matrix(frames, mass);
    }

    #[inline(always)]
    fn bias<S: Simd>(
        &self,
        at: (S, usize),
        frames: &Frames<N, Abreast>,
        _: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>> {
        Part { chains: self, at }.bias(frames)
    }

    #[inline(always)]
    fn carried<S: Simd>(
        &self,
        at: (S, usize),
        frames: &mut Frames<N, Abreast>,
        dq: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>> {
        Part { chains: self, at }.carried(dq, frames)
    }

    #[inline(always)]
    fn write_regressor<S: Simd>(
        &self,
        at: (S, usize),
        frames: &Frames<N, Abreast>,
        [_, dq, ddq]: [&Vector<N, Register<S>>; 3],
        rows: &mut [Abreast],
    ) {
        Part { chains: self, at }.write_regressor(frames, (dq, ddq), rows);
    }

    #[inline(always)]
    fn solve<S: Simd>(
        &self,
        _: (S, usize),
        _: &Frames<N, Abreast>,
        mass: &Matrix<N, Register<S>>,
        net: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>> {
        Factor::of(mass).solve(net)
    }
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

    /// Whether one moves as the other at every q and q̇.
    fn moves_as(&self, other: &Self) -> bool {
        self.has_gravity == other.has_gravity
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
