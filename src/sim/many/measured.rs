//! Controllers of eight loops side by side whose laws do not see their arms as they are: sensors
//! measure these, or something stands before the laws.

use pulp::{Arch, Simd, WithSimd};

use super::bodies::{Bodies, Drivers};
use super::case::Case;
use super::together::Together;
use crate::arm::ModelsAbreast;
use crate::control::{Command, Controller, Demand, FrontsAbreast, Law, Sample};
use crate::math::{
    Abreast, LANES, Load, Real, Register, Vector, in_lanes, lane, none_missing, put, store,
};
use crate::reference::Setpoint;

/// Eight controllers, what they see, and what they ask for.
pub(super) struct Measured<const N: usize> {
    together: Together<N>,
    /// M₀ and H₀ at the measured motion.
    models: ModelsAbreast<N>,
    pub seen: Sample<N, Abreast>,
    demand: Demand<N, Abreast>,
    asked: Vector<N, Abreast>,
    tau: Vector<N, Abreast>,
    rho_hat: Vector<N, Abreast>,
    /// What acts of it; with drives, what they told of the period that ends.
    told: Vector<N, Abreast>,
}

impl<const N: usize> Measured<N> {
    /// Those of these runs; `None` where they cannot go side by side.
    pub fn new<A, D, L: Law<N>, C, R, S>(
        together: Together<N>,
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
    ) -> Option<Self> {
        let models =
            ModelsAbreast::of(none_missing(cases.map(|case| case.controller.law.model()))?)?;
        let zeros = Vector::<N, Abreast>::repeat(Abreast::all(0.0));
        let desired = Setpoint { q: zeros, dq: zeros, ddq: zeros };
        Some(Self {
            together,
            models,
            seen: Sample { q: zeros, dq: zeros, desired, e: zeros, de: zeros },
            demand: Demand { model: zeros, compensation: zeros, v: zeros },
            asked: zeros,
            tau: zeros,
            rho_hat: zeros,
            told: zeros,
        })
    }

    /// Shows the controller in a lane where its arm is measured first. One that cannot be shown is
    /// `lost`.
    pub fn begin<L: Law<N>, C>(
        &mut self,
        i: usize,
        controller: &Controller<N, L, C>,
        q: &Vector<N>,
        lost: &mut Abreast,
    ) {
        if let Some(fronts) = &mut self.together.fronts {
            fronts.begin(i, controller, q, lost);
        }
    }

    /// Tells the controller in a lane what the drives told of the last period.
    pub fn tell(&mut self, i: usize, told: &Vector<N>) {
        put(told, &mut self.told, i);
    }

    /// Decides on the torques of a period \[s\]; the one before, if it has `begun`, ends. What is
    /// out of the ordinary is `lost`.
    pub fn decide(&mut self, arch: Arch, begun: bool, period: f64, lost: &mut Abreast) {
        Together::feel(arch, &self.seen, lost);
        if begun {
            self.end(arch, period, lost);
        }
        if let Some(fronts) = &mut self.together.fronts {
            fronts.look(arch, &mut self.seen, lost);
        }
        let Self { together, models, seen, demand, asked, tau, rho_hat, told } = self;
        models.find(arch, (&seen.q, &seen.dq));
        *rho_hat = *together.estimate(arch, seen, lost);
        let Together { drivers, fronts, .. } = together;
        let fronts = fronts.as_mut();
        let torques = [asked, tau, told];
        in_lanes(
            arch,
            Ask { drivers, fronts, models, seen, rho_hat, period, demand, torques, lost },
        );
    }

    /// The same for arms that are seen as they are; what plants let through of the torques acts.
    pub fn drive(&mut self, bodies: &mut Bodies<N>, begun: bool, period: f64) {
        let Bodies { arch, now, lost, .. } = bodies;
        self.seen = now.seen;
        self.decide(*arch, begun, period, lost);
        (now.applied, now.v, now.rho_hat) = (self.told, self.demand.v, self.rho_hat);
    }

    /// Ends a period \[s\] with what acted in it.
    pub fn end(&mut self, arch: Arch, period: f64, lost: &mut Abreast) {
        let Self { together, asked, told, .. } = self;
        let acted = together.fronts.as_ref().map_or(*asked, |fronts| *fronts.acting(asked));
        together.end(arch, (&acted, told), true, period, lost);
        if let Some(fronts) = &mut together.fronts {
            fronts.ended(asked, period);
        }
    }

    /// What the controller in a lane commands.
    pub fn command(&self, i: usize) -> Command<N> {
        let Self { demand: Demand { model, compensation, v }, asked, tau, rho_hat, .. } = self;
        let tau = lane(tau, i);
        Command {
            tau,
            model: lane(model, i),
            compensation: lane(compensation, i),
            v: lane(v, i),
            rho_hat: lane(rho_hat, i),
            limited: tau != lane(asked, i),
        }
    }
}

struct Ask<'a, const N: usize> {
    drivers: &'a Drivers<N>,
    fronts: Option<&'a mut FrontsAbreast<N>>,
    models: &'a ModelsAbreast<N>,
    seen: &'a Sample<N, Abreast>,
    rho_hat: &'a Vector<N, Abreast>,
    period: f64,
    demand: &'a mut Demand<N, Abreast>,
    /// What is asked for, commanded, and acts.
    torques: [&'a mut Vector<N, Abreast>; 3],
    lost: &'a mut Abreast,
}

impl<const N: usize> WithSimd for Ask<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { drivers, models, seen, rho_hat, period, .. } = self;
        let Self { mut fronts, demand, torques: [asked, tau, acts], lost, .. } = self;
        let Drivers { laws, limits: [controllers, actuators], .. } = drivers;
        for part in 0..Register::<S>::PARTS {
            let (mass, bias) = (models.mass.load(simd, part), models.bias.load(simd, part));
            let (seen, rho_hat) = (seen.load(simd, part), rho_hat.load(simd, part));
            let mut wanted = laws.torque((simd, part), (&mass, &bias), &seen, &rho_hat);
            if let Some(fronts) = &mut fronts {
                fronts.cushion((simd, part), &mut wanted);
            }
            let Demand { model, compensation, v } = wanted;
            let (mut sum, mut infinite) = (model, lost.load(simd, part));
            for n in 0..N {
                sum[n] += compensation[n];
            }
            let limits = controllers.load(simd, part);
            let mut clamped = limits.clamp(&sum);
            for n in 0..N {
                infinite += clamped[n] * infinite.like(0.0);
            }
            if let Some(fronts) = &mut fronts {
                clamped = fronts.follow((simd, part), &limits, &clamped, period);
            }
            store(&model, &mut demand.model, part);
            store(&compensation, &mut demand.compensation, part);
            store(&v, &mut demand.v, part);
            store(&sum, asked, part);
            store(&clamped, tau, part);
            store(&actuators.load(simd, part).clamp(&clamped), acts, part);
            infinite.store(lost, part);
        }
    }
}
