//! The arms of eight runs and the laws that drive them, side by side: what of a step needs no
//! more to be known than the number of joints.
//!
//! Each part of a step is compiled for the instruction set at hand, once for all loops. Nothing in
//! it is a closure over numbers, or `map` of an array: these would not be compiled for it.

use pulp::{Arch, Simd, WithSimd};

use super::case::Case;
use super::surroundings::Desired;
use crate::arm::{Alike, Arm, ArmsAbreast, Frame, Frames, Kind};
use crate::control::{Controller, Law, LawsAbreast, Limits, Sample};
use crate::math::{
    Abreast, LANES, Load, Real, Register, Vector, in_lanes, none_missing, side_by_side, store,
};
use crate::plant::Disturbance;
use crate::reference::Setpoint;
use crate::sim::integrators::{Motion, RK4};
use crate::sim::metrics::{Figures, Metrics, Row, Sums, Window};
use crate::sim::recorder::DIVERGED;
use crate::sim::resolution::Smooth;
use crate::sim::stiff::Moved;

/// The arms of eight runs, and how they are doing.
pub(super) struct Bodies<const N: usize> {
    /// The instruction set.
    pub arch: Arch,
    pub plants: ArmsAbreast<N>,
    pub wraps: [bool; N],
    pub now: Now<N>,
    /// Places for the frames of plants and of models.
    pub frames: [Frames<N, Abreast>; 2],
    pub figures: Figures<N, Abreast>,
    pub smooth: Smooth<N, Abreast>,
    /// Zero as long as all numbers of the run in a lane are finite, and the farthest that it went.
    pub lost: Abreast,
    pub farthest: Abreast,
}

/// Where they are in a step.
pub(super) struct Now<const N: usize> {
    /// The start of the step, and the rates at its stages.
    pub start: Motion<N, Abreast>,
    pub rates: [Motion<N, Abreast>; 4],
    /// The latest stage: what the controllers see there, what they ask for, and what acts; v and
    /// ρ̂.
    pub seen: Sample<N, Abreast>,
    pub asked: Vector<N, Abreast>,
    pub applied: Vector<N, Abreast>,
    pub v: Vector<N, Abreast>,
    pub rho_hat: Vector<N, Abreast>,
    /// What friction there is, and what the laws believe of it, where they differ.
    pub resisted: Vector<N, Abreast>,
    pub believed: Vector<N, Abreast>,
}

/// The laws that drive them.
pub(super) struct Drivers<const N: usize> {
    pub laws: LawsAbreast<N>,
    /// Whether the laws' arms move as the plants at every q and q̇, and have their friction.
    pub alike: bool,
    pub one_friction: bool,
    /// Limits of the controllers, and of the plants.
    pub limits: [Limits<N, Abreast>; 2],
    /// Whether any of these limits what is asked for.
    pub limited: bool,
}

impl<const N: usize> Drivers<N> {
    /// Those of these runs; `None` where they cannot go side by side with each other and the plants
    /// of `bodies`.
    pub fn new<A: Arm<N>, D: Disturbance<N>, L: Law<N>, C, R, S>(
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
        bodies: &Bodies<N>,
    ) -> Option<Self> {
        let sides = cases.map(|Case { controller: Controller { law, .. }, .. }| {
            law.model().zip(law.constant_gains())
        });
        let laws = LawsAbreast::of(none_missing(sides)?)?;
        let actuators = cases
            .map(|case| Limits { effort_limit: *case.plant.effort_limit(), ..Limits::default() });
        let limits = [
            Limits::abreast(cases.map(|case| &case.controller.limits)),
            Limits::abreast(actuators.each_ref()),
        ];
        let alike = bodies.plants.moves_as(laws.arms())?;
        let one_friction = bodies.plants.friction == laws.arms().friction;
        let mut efforts = limits.iter().flat_map(|limits| limits.effort_limit);
        let limited = efforts.any(|limit| limit != Abreast::all(f64::INFINITY));
        Some(Self { laws, alike, one_friction, limits, limited })
    }
}

/// Limits of controllers, and of plants.
pub(super) fn limits<const N: usize, A: Arm<N>, D: Disturbance<N>, L, C, R, S>(
    cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
) -> [Limits<N, Abreast>; 2] {
    let actuators =
        cases.map(|case| Limits { effort_limit: *case.plant.effort_limit(), ..Limits::default() });
    [
        Limits::abreast(cases.map(|case| &case.controller.limits)),
        Limits::abreast(actuators.each_ref()),
    ]
}

impl<const N: usize> Bodies<N> {
    /// Those of these runs at their start; `None` where they cannot go side by side.
    pub fn new<A: Arm<N>, D: Disturbance<N>, L: Law<N>, C, R, S>(
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
        window: Window,
        arch: Arch,
    ) -> Option<Self> {
        let wraps = cases[0].controller.law.wraps();
        if cases.iter().any(|case| case.controller.law.wraps() != wraps) {
            return None;
        }
        let zero = Abreast::all(0.0);
        let zeros = Vector::<N, Abreast>::repeat(zero);
        let start = Motion {
            q: side_by_side(&cases.map(|case| case.q0.into())),
            dq: side_by_side(&cases.map(|case| case.dq0.into())),
        };
        let desired = Setpoint { q: zeros, dq: zeros, ddq: zeros };
        Some(Self {
            arch,
            plants: ArmsAbreast::of(none_missing(cases.map(|case| case.plant.arm.side()))?)?,
            wraps,
            now: Now {
                start,
                rates: [start; 4],
                seen: Sample { q: zeros, dq: zeros, desired, e: zeros, de: zeros },
                asked: zeros,
                applied: zeros,
                v: zeros,
                rho_hat: zeros,
                resisted: zeros,
                believed: zeros,
            },
            frames: [[Frame::place(zero); N]; 2],
            figures: Figures::over(window, zero),
            smooth: Smooth::new(zero),
            lost: zero,
            farthest: zero,
        })
    }

    /// The metrics of the runs in which all was ordinary.
    pub fn metrics(&self) -> [Option<[Metrics; N]>; LANES] {
        core::array::from_fn(|lane| {
            let ordinary = self.is_ordinary(lane) && self.smooth.is_resolved(lane);
            self.figures.finish(|x| x.0[lane]).filter(|_| ordinary)
        })
    }

    /// Whether there is a lane in which all has been ordinary.
    pub fn goes_on(&self) -> bool {
        (0..LANES).any(|lane| self.is_ordinary(lane))
    }

    /// Whether all has been ordinary in a lane.
    pub fn is_ordinary(&self, lane: usize) -> bool {
        self.lost.0[lane] == 0.0 && self.farthest.0[lane] <= DIVERGED
    }

    /// Goes to stage i of a step of `h` \[s\].
    #[inline(never)]
    pub fn go(&mut self, i: usize, h: f64, desired: &Desired<N>) {
        let Self { arch, plants, wraps, now, frames: [frames, _], .. } = self;
        match &plants.kind {
            Kind::TwoLinks(plants) if const { N == 2 } => {
                in_lanes(*arch, Go { plants: &**plants, now, wraps, frames, i, h, desired });
            }
            Kind::Chains(plants) => {
                in_lanes(*arch, Go { plants: &**plants, now, wraps, frames, i, h, desired });
            }
            // Arms of two links have two joints.
            Kind::TwoLinks(_) => {}
        }
    }

    /// Notes a row at time `t` \[s\]: what is not finite, how far the motion went; and what it
    /// says, if it `counts`.
    #[inline(never)]
    pub fn note(&mut self, t: f64, counts: bool) {
        let row = if counts { self.figures.row(t) } else { None };
        in_lanes(self.arch, Note { bodies: self, row });
    }

    /// Ends a step of `h` \[s\].
    #[inline(never)]
    pub fn end(&mut self, h: f64) {
        in_lanes(self.arch, End { bodies: self, h });
    }
}

struct Go<'a, const N: usize, K> {
    plants: &'a K,
    now: &'a mut Now<N>,
    wraps: &'a [bool; N],
    frames: &'a mut Frames<N, Abreast>,
    i: usize,
    h: f64,
    desired: &'a Desired<N>,
}

impl<const N: usize, K: Alike<N>> WithSimd for Go<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { plants, now, wraps, frames, i, h, desired } = self;
        for part in 0..Register::<S>::PARTS {
            let mut motion = now.start.load(simd, part);
            if i > 0 {
                // RK4 goes on from the stage before, and from no other.
                let rate = now.rates[i - 1].load(simd, part);
                motion = motion.plus(h, &RK4.rows[i][i - 1..i], &[rate]);
            }
            let Motion { q, dq } = motion;
            let seen = Sample::wrapped(q, dq, desired.load(simd, part), wraps);
            seen.store(&mut now.seen, part);
            if K::FEW {
                plants.find((simd, part), (&seen.q, &seen.dq), &mut *frames);
            }
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
        let now = &bodies.now;
        for part in 0..Register::<S>::PARTS {
            let (seen, ddq) = (now.seen.load(simd, part), now.rates[0].dq.load(simd, part));
            let (v, rho_hat) = (now.v.load(simd, part), now.rho_hat.load(simd, part));
            let Sample { q, dq, desired, e, .. } = &seen;
            let [mut lost, mut farthest] = [bodies.lost, bodies.farthest].load(simd, part);
            let zero = lost.like(0.0);
            for n in 0..N {
                lost += (q[n] + dq[n] + desired.q[n]) * zero;
                let rho = ddq[n] - v[n] + rho_hat[n];
                lost += (desired.dq[n] + desired.ddq[n] + rho) * zero;
                farthest = farthest.or_larger(q[n].abs()).or_larger(dq[n].abs());
            }
            lost.store(&mut bodies.lost, part);
            farthest.store(&mut bodies.farthest, part);
            let Some(row) = &row else { continue };
            let applied = now.applied.load(simd, part);
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
        let Self { bodies: Bodies { now, smooth, .. }, h } = self;
        for part in 0..Register::<S>::PARTS {
            let (start, rates) = (now.start.load(simd, part), now.rates.load(simd, part));
            let moved = Moved::of_rates(h, &start, &rates);
            let Smooth { errors, swing } = &mut *smooth;
            let mut smooth =
                Smooth { errors: errors.load(simd, part), swing: swing.load(simd, part) };
            smooth.add(h, &start, &moved);
            store(&smooth.errors, errors, part);
            smooth.swing.store(swing, part);
            store(&moved.motion.q, &mut now.start.q, part);
            store(&moved.motion.dq, &mut now.start.dq, part);
        }
    }
}
