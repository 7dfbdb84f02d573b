//! What stands abreast in memory, in registers.

use pulp::Simd;

use crate::control::{Limits, Sample};
use crate::math::{Abreast, Load, Register};
use crate::reference::Setpoint;
use crate::sim::integrators::Motion;

impl<const N: usize> Load for Motion<N, Abreast> {
    type In<S: Simd> = Motion<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        Motion { q: self.q.load(simd, part), dq: self.dq.load(simd, part) }
    }
}

impl<const N: usize> Load for [Motion<N, Abreast>; 4] {
    type In<S: Simd> = [Motion<N, Register<S>>; 4];

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let [a, b, c, d] = self;
        [a.load(simd, part), b.load(simd, part), c.load(simd, part), d.load(simd, part)]
    }
}

impl<const N: usize> Load for Setpoint<N, Abreast> {
    type In<S: Simd> = Setpoint<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { q, dq, ddq } = self;
        Setpoint { q: q.load(simd, part), dq: dq.load(simd, part), ddq: ddq.load(simd, part) }
    }
}

impl<const N: usize> Load for Sample<N, Abreast> {
    type In<S: Simd> = Sample<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { q, dq, desired, e, de } = self;
        Sample {
            q: q.load(simd, part),
            dq: dq.load(simd, part),
            desired: desired.load(simd, part),
            e: e.load(simd, part),
            de: de.load(simd, part),
        }
    }
}

impl<const N: usize> Load for Limits<N, Abreast> {
    type In<S: Simd> = Limits<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { effort_limit, effort_rate_limit } = self;
        Limits {
            effort_limit: effort_limit.load(simd, part),
            effort_rate_limit: effort_rate_limit.load(simd, part),
        }
    }
}
