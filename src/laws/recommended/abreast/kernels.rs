//! What recommended controllers do side by side, a part of them at a time.

use pulp::{Simd, WithSimd};

use super::numbers::LearnedAbreast;
use crate::control::{Demand, Sample, possible};
use crate::laws::recommended::features::{FRICTION, friction};
use crate::laws::recommended::learning::nearer;
use crate::laws::recommended::memory::{Decided, Now};
use crate::math::{Abreast, Load, Real, Register, Vector, product, store};

/// Asks for torques, and ρ̂, with the columns of this turn.
pub(super) struct Ask<'a, const N: usize> {
    pub turn: usize,
    pub seen: &'a Sample<N, Abreast>,
    pub it: &'a mut LearnedAbreast<N>,
    pub asked: (&'a mut Demand<N, Abreast>, &'a mut Vector<N, Abreast>),
}

impl<const N: usize> WithSimd for Ask<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { turn, seen, it, asked: (demand, to) } = self;
        let first = it.periods == 0;
        for part in 0..Register::<S>::PARTS {
            let (pull, shares) = (it.pull.load(simd, part), it.shares.velocity.load(simd, part));
            let (seen, filtered) = (seen.load(simd, part), it.filtered.load(simd, part));
            let (weight, learned) =
                (it.weight.mass.load(simd, part), it.learned((simd, part), turn, &seen.desired.dq));
            let now = Now::seen(&filtered, (&pull, &shares), first, &seen, (&weight, &learned));
            let rho_hat = now.rho_hat(&pull, &weight, &seen.de);
            let (mass, bias) = (it.arm.mass.load(simd, part), it.arm.bias.load(simd, part));
            let Demand { model, compensation, v } =
                pull.torque((&mass, &bias), &weight, &seen, &rho_hat);
            now.store(&mut it.now, part);
            store(&model, &mut demand.model, part);
            store(&compensation, &mut demand.compensation, part);
            store(&v, &mut demand.v, part);
            store(&rho_hat, to, part);
        }
    }
}

/// The observers at the end of a period \[s\], with what was asked for what was applied.
pub(super) struct Observe<'a, const N: usize> {
    pub it: &'a mut LearnedAbreast<N>,
    pub torques: (&'a Vector<N, Abreast>, &'a Vector<N, Abreast>),
    /// Where that is which was decided for what acted.
    pub acting: Option<usize>,
    pub dt: f64,
    pub lost: &'a mut Abreast,
}

impl<const N: usize> WithSimd for Observe<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { it, torques: (asked, applied), acting, dt, lost } = self;
        let first = it.periods == 0;
        for part in 0..Register::<S>::PARTS {
            let (asked, applied) = (asked.load(simd, part), applied.load(simd, part));
            let (mut now, mut infinite) = (it.now.load(simd, part), lost.load(simd, part));
            let (zero, mut cut) = (infinite.like(0.0), applied);
            for n in 0..N {
                cut[n] -= asked[n];
                infinite += now.decided.torque[n] * zero;
            }
            now.cut = possible(&cut);
            let mut acted = Decided::nothing(zero);
            if let Some(turn) = acting {
                acted = it.decided[turn].load(simd, part);
            }
            let weight = it.weight.mass.load(simd, part);
            let momentum = product(&weight, &now.velocity);
            let bandwidth = it.pull.bandwidth.load(simd, part);
            let mut filtered = it.filtered.load(simd, part);
            filtered.observe(
                (&now, &acted.v),
                (&weight, &momentum),
                (&bandwidth, it.shares.slow.load(simd, part)),
                (dt, first),
            );
            let mut moving = acted.dq;
            for n in 0..N {
                moving[n] += filtered.slow[n];
            }
            store(&now.cut, &mut it.now.cut, part);
            filtered.store(&mut it.filtered, part);
            store(&momentum, &mut it.momentum, part);
            store(&moving, &mut it.moving, part);
            infinite.store(lost, part);
        }
        it.filtered.period = dt;
    }
}

/// What acted goes through filters.
pub(super) struct Take<'a, const N: usize> {
    pub it: &'a mut LearnedAbreast<N>,
    /// Where that is which was decided for what acted.
    pub turn: usize,
    pub dt: f64,
}

impl<const N: usize> WithSimd for Take<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { it, turn, dt } = self;
        for part in 0..Register::<S>::PARTS {
            let share = it.shares.learning.load(simd, part);
            it.smooth((simd, part), turn, share);
            let [desired, measured] = &it.rubbed;
            let (mut rubbed, measured) = (desired.load(simd, part), measured.load(simd, part));
            for n in 0..N {
                rubbed[n] -= measured[n];
            }
            let (now, acted) = (it.now.load(simd, part), it.decided[turn].load(simd, part));
            let (moving, momentum) = (it.moving.load(simd, part), it.momentum.load(simd, part));
            let shares = (share, it.shares.acceleration.load(simd, part));
            let mut filtered = it.filtered.load(simd, part);
            let wanted = filtered.take((&now, &acted), (&moving, &rubbed), &momentum, shares, dt);
            filtered.store(&mut it.filtered, part);
            store(&wanted, &mut it.wanted, part);
        }
        it.filtered.since += dt;
    }
}

impl<const N: usize> LearnedAbreast<N> {
    /// Φθ [N·m], of the columns of this turn, with the friction at the desired velocity.
    #[inline(always)]
    fn learned<S: Simd>(
        &self,
        (simd, part): (S, usize),
        turn: usize,
        dq: &Vector<N, Register<S>>,
    ) -> Vector<N, Register<S>> {
        let Self { shape, theta, columns, .. } = self;
        let columns = &columns[turn * shape.columns()..][..shape.columns()];
        let mut learned = *dq;
        for n in 0..N {
            let [first, own] = shape.first(n);
            let (zero, own) = (dq[n].like(0.0), &theta[own..][..shape.own()]);
            let [mut moved, mut rubbed, mut placed] = [zero; 3];
            for (column, theta) in columns[shape.acting(n)].iter().zip(&theta[first..]) {
                moved += column.load(simd, part) * theta.load(simd, part);
            }
            for (theta, column) in own.iter().zip(friction(dq[n])) {
                rubbed += theta.load(simd, part) * column;
            }
            for (theta, column) in own[FRICTION..].iter().zip(&columns[shape.places()]) {
                placed += theta.load(simd, part) * column.load(simd, part);
            }
            learned[n] = moved + rubbed + placed;
        }
        learned
    }

    /// The columns of the torque that acted, of this turn, through the filter.
    #[inline(always)]
    fn smooth<S: Simd>(&mut self, (simd, part): (S, usize), turn: usize, share: Register<S>) {
        let Self { shape, inertial, own, columns, moving, .. } = self;
        let columns = &columns[turn * shape.columns()..][..shape.columns()];
        for n in 0..N {
            let acting = shape.acting(n);
            for (y, x) in inertial[acting.clone()].iter_mut().zip(&columns[acting]) {
                nearer(y.load(simd, part), share, x.load(simd, part)).store(y, part);
            }
            let own = &mut own[n * shape.own()..][..shape.own()];
            for (y, x) in own.iter_mut().zip(friction(moving[n].load(simd, part))) {
                nearer(y.load(simd, part), share, x).store(y, part);
            }
            for (y, x) in own[FRICTION..].iter_mut().zip(&columns[shape.places()]) {
                nearer(y.load(simd, part), share, x.load(simd, part)).store(y, part);
            }
        }
    }
}
