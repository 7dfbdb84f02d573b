//! The arms of eight runs and the laws that drive them, side by side: what of a step needs no more
//! to be known than the number of joints.
//!
//! Each part of a step is compiled for the instruction set at hand, once for all loops. Nothing in
//! it is a closure over numbers, or `map` of an array: these would not be compiled for it.

use pulp::{Arch, Simd, WithSimd};

use crate::arm::ArmsAbreast;
use crate::control::{LawsAbreast, Limits, Sample};
use crate::math::{Abreast, Load, Real, Register, Vector, store};
use crate::reference::Setpoint;
use crate::sim::integrators::{Motion, RK4};
use crate::sim::metrics::{Figures, Row, Sums};
use crate::sim::recorder::DIVERGED;
use crate::sim::resolution::Smooth;
use crate::sim::stiff::Moved;

/// The arms and laws of eight runs, and where they are in a step.
pub(super) struct Bodies<const N: usize> {
    /// The instruction set.
    pub arch: Arch,
    pub plants: ArmsAbreast<N>,
    pub laws: LawsAbreast<N>,
    /// Whether the laws' arms have the frames of the plants at every q.
    pub one_pose: bool,
    /// Limits of the controllers, and of the plants.
    pub limits: [Limits<N, Abreast>; 2],
    pub wraps: [bool; N],
    /// The start of the step, and the rates at its stages.
    pub start: Motion<N, Abreast>,
    pub rates: [Motion<N, Abreast>; 4],
    /// The latest stage: what the controllers see there, ask for, and what acts.
    pub seen: Sample<N, Abreast>,
    pub asked: Vector<N, Abreast>,
    pub applied: Vector<N, Abreast>,
    pub rho: Vector<N, Abreast>,
    pub figures: Figures<N, Abreast>,
    pub smooth: Smooth<N, Abreast>,
    /// Zero as long as all numbers of the run in a lane are finite, and the farthest that it went.
    pub lost: Abreast,
    pub farthest: Abreast,
}

impl<const N: usize> Bodies<N> {
    /// Whether all has been ordinary in a lane.
    pub fn is_ordinary(&self, lane: usize) -> bool {
        self.lost.0[lane] == 0.0 && self.farthest.0[lane] <= DIVERGED
    }

    /// Goes to stage i of a step of `h` \[s\].
    pub fn go(&mut self, i: usize, h: f64, desired: &Setpoint<N, Abreast>) {
        self.arch.dispatch(Go { bodies: self, i, h, desired });
    }

    /// Moves stage i by the laws, with estimates `rho_hat` and under disturbances `tau_d`.
    pub fn act(&mut self, i: usize, rho_hat: &Vector<N, Abreast>, tau_d: &Vector<N, Abreast>) {
        self.arch.dispatch(Act { bodies: self, i, rho_hat, tau_d });
    }

    /// Notes a row at time `t` \[s\]: what is not finite, how far the motion went; and what it
    /// says, if it `counts`.
    pub fn note(&mut self, t: f64, counts: bool) {
        let row = if counts { self.figures.row(t) } else { None };
        self.arch.dispatch(Note { bodies: self, row });
    }

    /// Ends a step of `h` \[s\].
    pub fn end(&mut self, h: f64) {
        self.arch.dispatch(End { bodies: self, h });
    }
}

struct Go<'a, const N: usize> {
    bodies: &'a mut Bodies<N>,
    i: usize,
    h: f64,
    desired: &'a Setpoint<N, Abreast>,
}

impl<const N: usize> WithSimd for Go<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { bodies, i, h, desired } = self;
        for part in 0..Register::<S>::PARTS {
            let (start, rates) = (bodies.start.load(simd, part), bodies.rates.load(simd, part));
            let Motion { q, dq } = if i == 0 { start } else { RK4.at(i, h, &start, &rates) };
            let seen = Sample::wrapped(q, dq, desired.load(simd, part), &bodies.wraps);
            let Sample { q, dq, desired, e, de } = &mut bodies.seen;
            store(&seen.q, q, part);
            store(&seen.dq, dq, part);
            store(&seen.e, e, part);
            store(&seen.de, de, part);
            store(&seen.desired.q, &mut desired.q, part);
            store(&seen.desired.dq, &mut desired.dq, part);
            store(&seen.desired.ddq, &mut desired.ddq, part);
        }
    }
}

struct Act<'a, const N: usize> {
    bodies: &'a mut Bodies<N>,
    i: usize,
    rho_hat: &'a Vector<N, Abreast>,
    tau_d: &'a Vector<N, Abreast>,
}

impl<const N: usize> WithSimd for Act<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { bodies, i, rho_hat, tau_d } = self;
        for part in 0..Register::<S>::PARTS {
            let (seen, rho_hat) = (bodies.seen.load(simd, part), rho_hat.load(simd, part));
            let (at, Sample { q, dq, .. }) = ((simd, part), &seen);
            let poses = bodies.plants.poses(at, q);
            let demand = if bodies.one_pose {
                bodies.laws.torque(at, &poses, &seen, &rho_hat)
            } else {
                let believed = bodies.laws.arms().poses(at, q);
                bodies.laws.torque(at, &believed, &seen, &rho_hat)
            };
            let (mut asked, mut rho) = (demand.model, rho_hat);
            for n in 0..N {
                asked[n] += demand.compensation[n];
            }
            let [controllers, plants] = &bodies.limits;
            let tau = controllers.load(simd, part).clamp(&asked);
            let applied = plants.load(simd, part).clamp(&tau);
            let (mut net, tau_d) = (applied, tau_d.load(simd, part));
            for n in 0..N {
                net[n] -= tau_d[n];
            }
            let ddq = bodies.plants.forward_dynamics(at, &poses, dq, &net);
            for n in 0..N {
                rho[n] = ddq[n] - demand.v[n] + rho_hat[n];
            }
            store(&asked, &mut bodies.asked, part);
            store(&applied, &mut bodies.applied, part);
            store(&rho, &mut bodies.rho, part);
            store(&seen.dq, &mut bodies.rates[i].q, part);
            store(&ddq, &mut bodies.rates[i].dq, part);
        }
    }
}

struct Note<'a, const N: usize> {
    bodies: &'a mut Bodies<N>,
    row: Option<Row>,
}

impl<const N: usize> WithSimd for Note<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { bodies, row } = self;
        for part in 0..Register::<S>::PARTS {
            let (seen, rho) = (bodies.seen.load(simd, part), bodies.rho.load(simd, part));
            let Sample { q, dq, desired, e, .. } = &seen;
            let [mut lost, mut farthest] = [bodies.lost, bodies.farthest].load(simd, part);
            let zero = lost.like(0.0);
            for n in 0..N {
                lost += (q[n] + dq[n] + desired.q[n]) * zero;
                lost += (desired.dq[n] + desired.ddq[n] + rho[n]) * zero;
                farthest = farthest.or_larger(q[n].abs()).or_larger(dq[n].abs());
            }
            lost.store(&mut bodies.lost, part);
            farthest.store(&mut bodies.farthest, part);
            let Some(row) = &row else { continue };
            let applied = bodies.applied.load(simd, part);
            for n in 0..N {
                let mut kept = bodies.figures.joints[n].numbers();
                let mut sums = Sums::of(kept.load(simd, part));
                sums.add(row, e[n], applied[n]);
                for (sum, kept) in sums.numbers().iter().zip(&mut kept) {
                    sum.store(kept, part);
                }
                bodies.figures.joints[n] = Sums::of(kept);
            }
        }
    }
}

struct End<'a, const N: usize> {
    bodies: &'a mut Bodies<N>,
    h: f64,
}

impl<const N: usize> WithSimd for End<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { bodies, h } = self;
        for part in 0..Register::<S>::PARTS {
            let (start, rates) = (bodies.start.load(simd, part), bodies.rates.load(simd, part));
            let moved = Moved::of_rates(h, &start, &rates);
            let Smooth { errors, swing } = &mut bodies.smooth;
            let mut smooth =
                Smooth { errors: errors.load(simd, part), swing: swing.load(simd, part) };
            smooth.add(h, &start, &moved);
            store(&smooth.errors, errors, part);
            smooth.swing.store(swing, part);
            store(&moved.motion.q, &mut bodies.start.q, part);
            store(&moved.motion.dq, &mut bodies.start.dq, part);
        }
    }
}

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
