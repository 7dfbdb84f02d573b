//! What moves the arms of eight runs at a stage: the torque of laws that are asked, or one that is
//! held, against disturbances and friction.

use pulp::{Simd, WithSimd};

use super::bodies::{Bodies, Drivers, Now};
use crate::arm::{Alike, Factor, Frictions, Kind};
use crate::math::{Abreast, Load, Matrix, Real, Register, Vector, store};
use crate::sim::held::in_one_part;
use crate::sim::stiff::none_beyond_rk4;

impl<const N: usize> Bodies<N> {
    /// Moves stage i of a step of `h` \[s\] by the laws of `drivers`, with estimates `rho_hat` and
    /// under disturbances `tau_d`. Their torque is to be `held`, or each stage has its own.
    #[inline(never)]
    pub fn act(
        &mut self,
        drivers: &Drivers<N>,
        (i, h): (usize, f64),
        rho_hat: &Vector<N, Abreast>,
        tau_d: &Vector<N, Abreast>,
        held: bool,
    ) {
        self.arch.dispatch(Act { bodies: self, drivers, i, h, rho_hat, tau_d, held });
    }

    /// Moves stage i of a step of `h` \[s\] by what is applied, under disturbances `tau_d`.
    #[inline(never)]
    pub fn fly(&mut self, (i, h): (usize, f64), tau_d: &Vector<N, Abreast>) {
        self.arch.dispatch(Fly { bodies: self, i, h, tau_d });
    }
}

struct Act<'a, const N: usize> {
    bodies: &'a mut Bodies<N>,
    drivers: &'a Drivers<N>,
    i: usize,
    h: f64,
    rho_hat: &'a Vector<N, Abreast>,
    tau_d: &'a Vector<N, Abreast>,
    held: bool,
}

impl<const N: usize> WithSimd for Act<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { bodies, drivers, i, h, rho_hat, tau_d, held } = self;
        let Bodies { plants, now, lost, .. } = bodies;
        for part in 0..Register::<S>::PARTS {
            let (at, friction) = ((simd, part), plants.friction.as_deref());
            let rho_hat = rho_hat.load(simd, part);
            let pushed = Pushed { tau_d: tau_d.load(simd, part), friction, i, h, held };
            let ordinary = match (&plants.kind, &drivers.laws.arms().kind) {
                (Kind::TwoLinks(own), Kind::TwoLinks(models)) if const { N == 2 } => {
                    drivers.act(at, now, (&**own, &**models), &rho_hat, &pushed)
                }
                (Kind::Chains(own), Kind::Chains(models)) => {
                    drivers.act(at, now, (&**own, &**models), &rho_hat, &pushed)
                }
                // Arms of two kinds do not go side by side.
                _ => continue,
            };
            (lost.load(simd, part) + ordinary).store(lost, part);
        }
    }
}

struct Fly<'a, const N: usize> {
    bodies: &'a mut Bodies<N>,
    i: usize,
    h: f64,
    tau_d: &'a Vector<N, Abreast>,
}

impl<const N: usize> WithSimd for Fly<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { bodies: Bodies { plants, now, lost, .. }, i, h, tau_d } = self;
        for part in 0..Register::<S>::PARTS {
            let (at, friction) = ((simd, part), plants.friction.as_deref());
            let pushed = Pushed { tau_d: tau_d.load(simd, part), friction, i, h, held: true };
            let ordinary = match &plants.kind {
                Kind::TwoLinks(plants) if const { N == 2 } => now.fly(at, &**plants, &pushed),
                Kind::Chains(plants) => now.fly(at, &**plants, &pushed),
                // Arms of two links have two joints.
                Kind::TwoLinks(_) => continue,
            };
            (lost.load(simd, part) + ordinary).store(lost, part);
        }
    }
}

/// What opposes the motion of the plants in registers, at stage i of a step of `h` \[s\] under a
/// torque that is held or not.
struct Pushed<'a, const N: usize, S: Simd> {
    tau_d: Vector<N, Register<S>>,
    friction: Option<&'a Frictions<N>>,
    i: usize,
    h: f64,
    held: bool,
}

impl<const N: usize, S: Simd> Pushed<'_, N, S> {
    /// f(q̇) of the plants; `None` without friction.
    #[inline(always)]
    fn friction_at(
        &self,
        at: (S, usize),
        dq: &Vector<N, Register<S>>,
    ) -> Option<Vector<N, Register<S>>> {
        if let Some(friction) = self.friction { Some(friction.torque(at, dq)) } else { None }
    }
}

impl<const N: usize> Drivers<N> {
    /// Moves a stage; NaN where a step of RK4 alone cannot follow it, and 0 elsewhere.
    #[inline(always)]
    fn act<S: Simd, K: Alike<N>>(
        &self,
        (simd, part): (S, usize),
        now: &mut Now<N>,
        (plants, models): (&K, &K),
        rho_hat: &Vector<N, Register<S>>,
        pushed: &Pushed<'_, N, S>,
    ) -> Register<S> {
        let Self { laws, alike, one_friction, limits } = self;
        let (at, seen) = ((simd, part), now.seen.load(simd, part));
        let moves = plants.moves(at, &seen.q, &seen.dq);
        let friction = pushed.friction_at(at, &seen.dq);
        let mut dynamics = if *alike {
            models.mass_matrix_and_bias(at, &moves)
        } else {
            models.mass_matrix_and_bias(at, &models.moves(at, &seen.q, &seen.dq))
        };
        let believed = if *one_friction { friction } else { laws.arms().friction_at(at, &seen.dq) };
        if let Some(believed) = believed {
            for n in 0..N {
                dynamics.1[n] += believed[n];
            }
        }
        let demand = laws.torque(at, &dynamics, &seen, rho_hat);
        let mut asked = demand.model;
        for n in 0..N {
            asked[n] += demand.compensation[n];
        }
        let [controllers, actuators] = limits;
        let tau = controllers.load(simd, part).clamp(&asked);
        let applied = actuators.load(simd, part).clamp(&tau);
        store(&asked, &mut now.asked, part);
        store(&applied, &mut now.applied, part);
        store(&demand.v, &mut now.v, part);
        store(rho_hat, &mut now.rho_hat, part);
        now.accelerate(at, plants, (&moves, friction.as_ref()), pushed)
    }
}

impl<const N: usize> Now<N> {
    /// The rates at a stage of a part, under what is applied; NaN as [`Drivers::act`].
    #[inline(always)]
    fn fly<S: Simd, K: Alike<N>>(
        &mut self,
        (simd, part): (S, usize),
        plants: &K,
        pushed: &Pushed<'_, N, S>,
    ) -> Register<S> {
        let (q, dq) = (self.seen.q.load(simd, part), self.seen.dq.load(simd, part));
        let moves = plants.moves((simd, part), &q, &dq);
        let friction = pushed.friction_at((simd, part), &dq);
        self.accelerate((simd, part), plants, (&moves, friction.as_ref()), pushed)
    }

    /// The same of plants that move so, against friction.
    #[inline(always)]
    fn accelerate<S: Simd, K: Alike<N>>(
        &mut self,
        (simd, part): (S, usize),
        plants: &K,
        (moves, friction): (&K::Moves<S>, Option<&Vector<N, Register<S>>>),
        pushed: &Pushed<'_, N, S>,
    ) -> Register<S> {
        let (at, mut net) = ((simd, part), self.applied.load(simd, part));
        for n in 0..N {
            net[n] -= pushed.tau_d[n];
        }
        let mut ordinary = net[0].like(0.0);
        let ddq = match (pushed.friction, friction) {
            (Some(friction), Some(torque)) if pushed.i == 0 => {
                let (mass, bias) = plants.mass_matrix_and_bias(at, moves);
                for n in 0..N {
                    net[n] -= bias[n] + torque[n];
                }
                let factor = Factor::of(&mass);
                ordinary = friction.as_smooth(at, (&mass, &factor), pushed.h, pushed.held);
                factor.solve(&net)
            }
            _ => plants.forward_dynamics(at, moves, &net, friction),
        };
        store(&self.seen.dq.load(simd, part), &mut self.rates[pushed.i].q, part);
        store(&ddq, &mut self.rates[pushed.i].dq, part);
        ordinary
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
