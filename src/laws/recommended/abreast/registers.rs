//! What recommended controllers remember, in registers.

use pulp::Simd;

use crate::laws::recommended::memory::{Decided, Filtered, Now};
use crate::laws::recommended::pull::Pull;
use crate::math::{Abreast, Load, Register, store};

impl<const N: usize, S: Simd> Now<N, Register<S>> {
    /// Puts it in its place.
    #[inline(always)]
    pub(super) fn store(&self, to: &mut Now<N, Abreast>, part: usize) {
        store(&self.velocity, &mut to.velocity, part);
        store(&self.alpha, &mut to.alpha, part);
        store(&self.cut, &mut to.cut, part);
        self.far.store(&mut to.far, part);
        store(&self.decided.torque, &mut to.decided.torque, part);
        store(&self.decided.v, &mut to.decided.v, part);
        store(&self.decided.dq, &mut to.decided.dq, part);
        store(&self.learned, &mut to.learned, part);
    }
}

impl<const N: usize, S: Simd> Filtered<N, Register<S>> {
    /// Puts it in its place.
    #[inline(always)]
    pub(super) fn store(&self, to: &mut Filtered<N, Abreast>, part: usize) {
        store(&self.velocity, &mut to.velocity, part);
        store(&self.slow, &mut to.slow, part);
        store(&self.zeta, &mut to.zeta, part);
        store(&self.torque, &mut to.torque, part);
        store(&self.momentum, &mut to.momentum, part);
        store(&self.rest, &mut to.rest, part);
        self.astray.store(&mut to.astray, part);
    }
}

impl<const N: usize> Load for Pull<N, Abreast> {
    type In<S: Simd> = Pull<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { bandwidth, braking } = self;
        Pull { bandwidth: bandwidth.load(simd, part), braking: braking.load(simd, part) }
    }
}

impl<const N: usize> Load for Decided<N, Abreast> {
    type In<S: Simd> = Decided<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { torque, v, dq } = self;
        Decided { torque: torque.load(simd, part), v: v.load(simd, part), dq: dq.load(simd, part) }
    }
}

impl<const N: usize> Load for Now<N, Abreast> {
    type In<S: Simd> = Now<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { velocity, alpha, cut, far, decided, learned } = self;
        Now {
            velocity: velocity.load(simd, part),
            alpha: alpha.load(simd, part),
            cut: cut.load(simd, part),
            far: far.load(simd, part),
            decided: decided.load(simd, part),
            learned: learned.load(simd, part),
        }
    }
}

impl<const N: usize> Load for Filtered<N, Abreast> {
    type In<S: Simd> = Filtered<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { velocity, slow, zeta, torque, momentum, rest, astray, period, since } = self;
        Filtered {
            velocity: velocity.load(simd, part),
            slow: slow.load(simd, part),
            zeta: zeta.load(simd, part),
            torque: torque.load(simd, part),
            momentum: momentum.load(simd, part),
            rest: rest.load(simd, part),
            astray: astray.load(simd, part),
            period: *period,
            since: *since,
        }
    }
}
