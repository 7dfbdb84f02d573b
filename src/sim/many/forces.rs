//! What moves the arms of eight runs at a stage: the torque of laws that are asked, or one that is
//! held, against disturbances and friction.
//!
//! Arms of two links and chains have a kernel each, and friction has its own: what stands in a loop
//! that is not unrolled stays in memory, in all of a kernel.

use pulp::{Simd, WithSimd};

use super::bodies::{Bodies, Drivers, Now};
use super::surroundings::Told;
use crate::arm::{Alike, Dynamics, Factor, Frames, Frictions, Kind};
use crate::control::Sample;
use crate::math::{Abreast, Load, Matrix, Register, Vector, column, columns, in_lanes, store};
use crate::sim::held::in_one_part;
use crate::sim::stiff::none_beyond_rk4;

/// What pushes plants at stage i of a step of `h` \[s\], under a torque that is `held` or not.
#[derive(Clone, Copy)]
pub(super) struct Push<'a, const N: usize> {
    pub i: usize,
    pub h: f64,
    pub tau_d: &'a Told<N>,
    pub held: bool,
}

impl<const N: usize> Bodies<N> {
    /// Moves a stage by the laws of `drivers`, with estimates `rho_hat`.
    #[inline(never)]
    pub fn act(&mut self, drivers: &Drivers<N>, rho_hat: &Vector<N, Abreast>, push: Push<'_, N>) {
        let Self { arch, plants, now, frames, lost, .. } = self;
        let arms = drivers.laws.arms();
        plants.resist(*arch, &now.seen.dq, &mut now.resisted);
        if !drivers.one_friction {
            arms.resist(*arch, &now.seen.dq, &mut now.believed);
        }
        let pushed = Pushed { friction: plants.friction.as_deref(), now, lost, push };
        match (&plants.kind, &arms.kind) {
            (Kind::TwoLinks(plants), Kind::TwoLinks(models)) if const { N == 2 } => {
                in_lanes(
                    *arch,
                    Act { drivers, arms: (&**plants, &**models), frames, rho_hat, pushed },
                );
            }
            (Kind::Chains(plants), Kind::Chains(models)) => {
                in_lanes(
                    *arch,
                    Act { drivers, arms: (&**plants, &**models), frames, rho_hat, pushed },
                );
            }
            // Arms of two kinds do not go side by side.
            _ => {}
        }
    }

    /// Moves a stage by what is applied.
    #[inline(never)]
    pub fn fly(&mut self, push: Push<'_, N>) {
        let Self { arch, plants, now, frames: [frames, _], lost, .. } = self;
        plants.resist(*arch, &now.seen.dq, &mut now.resisted);
        let pushed = Pushed { friction: plants.friction.as_deref(), now, lost, push };
        match &plants.kind {
            Kind::TwoLinks(plants) if const { N == 2 } => {
                in_lanes(*arch, Fly { plants: &**plants, frames, pushed });
            }
            Kind::Chains(plants) => in_lanes(*arch, Fly { plants: &**plants, frames, pushed }),
            // Arms of two links have two joints.
            Kind::TwoLinks(_) => {}
        }
    }
}

/// Plants that are pushed, against this friction of theirs; and what is lost.
struct Pushed<'a, const N: usize> {
    friction: Option<&'a Frictions<N>>,
    now: &'a mut Now<N>,
    lost: &'a mut Abreast,
    push: Push<'a, N>,
}

/// Plants and what laws believe of them, of one kind.
struct Act<'a, const N: usize, K> {
    drivers: &'a Drivers<N>,
    arms: (&'a K, &'a K),
    frames: &'a mut [Frames<N, Abreast>; 2],
    rho_hat: &'a Vector<N, Abreast>,
    pushed: Pushed<'a, N>,
}

impl<const N: usize, K: Alike<N>> WithSimd for Act<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { drivers, arms: (plants, models), frames, rho_hat, mut pushed } = self;
        let zero = Abreast::all(0.0).load(simd, 0);
        let (mut mass, mut bias) = (columns([[zero; N]; N]), column([zero; N]));
        let Drivers { laws, alike, one_friction, limits: [controllers, actuators], .. } = drivers;
        for part in 0..Register::<S>::PARTS {
            let (at, now) = ((simd, part), &mut *pushed.now);
            let (q, dq) = (now.seen.q.load(simd, part), now.seen.dq.load(simd, part));
            let [own, believed] = &mut *frames;
            if !K::FEW {
                plants.find(at, (&q, &dq), &mut *own);
            }
            if *alike {
                models.write_dynamics(at, (&mut *own, &dq), (&mut mass, &mut bias));
            } else {
                models.find(at, (&q, &dq), &mut *believed);
                models.write_dynamics(at, (believed, &dq), (&mut mass, &mut bias));
            }
            if laws.arms().friction.is_some() {
                let believed = if *one_friction { &now.resisted } else { &now.believed };
                for n in 0..N {
                    bias[n] += believed[n].load(simd, part);
                }
            }
            let (seen, rho_hat) = (now.seen.load(simd, part), rho_hat.load(simd, part));
            let demand = laws.torque(at, (&mass, &bias), &seen, &rho_hat);
            let mut asked = demand.model;
            for n in 0..N {
                asked[n] += demand.compensation[n];
            }
            let tau = controllers.load(simd, part).clamp(&asked);
            let applied = actuators.load(simd, part).clamp(&tau);
            store(&asked, &mut now.asked, part);
            store(&applied, &mut now.applied, part);
            store(&demand.v, &mut now.v, part);
            store(&rho_hat, &mut now.rho_hat, part);
            pushed.accelerate(at, plants, own, (&mut mass, &mut bias));
        }
    }
}

struct Fly<'a, const N: usize, K> {
    plants: &'a K,
    frames: &'a mut Frames<N, Abreast>,
    pushed: Pushed<'a, N>,
}

impl<const N: usize, K: Alike<N>> WithSimd for Fly<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { plants, frames, mut pushed } = self;
        let zero = Abreast::all(0.0).load(simd, 0);
        let (mut mass, mut bias) = (columns([[zero; N]; N]), column([zero; N]));
        for part in 0..Register::<S>::PARTS {
            if !K::FEW {
                let Sample { q, dq, .. } = &pushed.now.seen;
                let motion = (&q.load(simd, part), &dq.load(simd, part));
                plants.find((simd, part), motion, &mut *frames);
            }
            pushed.accelerate((simd, part), plants, &mut *frames, (&mut mass, &mut bias));
        }
    }
}

impl<const N: usize> Pushed<'_, N> {
    /// The rates at the stage of a part of the plants, which move so, under what is applied; lost
    /// where a step of RK4 alone cannot follow them.
    #[inline(always)]
    fn accelerate<S: Simd, K: Alike<N>>(
        &mut self,
        (simd, part): (S, usize),
        plants: &K,
        frames: &mut Frames<N, Abreast>,
        (mass, bias): Dynamics<'_, N, S>,
    ) {
        let Self { friction, now, lost, push: Push { i, h, tau_d, held } } = self;
        let dq = now.seen.dq.load(simd, part);
        plants.write_dynamics((simd, part), (&mut *frames, &dq), (&mut *mass, &mut *bias));
        let (mut net, tau_d) = (now.applied.load(simd, part), tau_d.load(simd, part));
        for n in 0..N {
            net[n] -= tau_d[n];
            let against = if friction.is_some() {
                bias[n] + now.resisted[n].load(simd, part)
            } else {
                bias[n]
            };
            net[n] -= against;
        }
        let ddq = match friction {
            Some(friction) if *i == 0 => {
                let factor = Factor::of(mass);
                let ordinary = friction.as_smooth((simd, part), (mass, &factor), *h, *held);
                (lost.load(simd, part) + ordinary).store(lost, part);
                factor.solve(&net)
            }
            _ => plants.solve((simd, part), frames, mass, &net),
        };
        let rates = &mut now.rates[*i];
        for n in 0..N {
            dq[n].store(&mut rates.q[n], part);
        }
        store(&ddq, &mut rates.dq, part);
    }
}

impl<const N: usize> Frictions<N> {
    /// NaN where a step of `h` \[s\] from arms with this mass is not one of RK4 alone, under a
    /// torque that is `held` or not, and 0 elsewhere.
    #[inline(always)]
    fn as_smooth<S: Simd>(
        &self,
        (simd, part): (S, usize),
        (mass, factor): (&Matrix<N, Register<S>>, &Factor<N, Register<S>>),
        h: f64,
        held: bool,
    ) -> Register<S> {
        let (steepest, inverse) = (self.steepest.load(simd, part), factor.inverse_diagonal());
        let mut ordinary = none_beyond_rk4(mass, &inverse, &steepest, h);
        if held {
            let mut viscous = steepest;
            for n in 0..N {
                viscous[n] = self.joints[n].viscous.load(simd, part);
            }
            ordinary += in_one_part(&inverse, (&viscous, &self.falls.load(simd, part)), h);
        }
        ordinary
    }
}
