//! Controllers of eight loops side by side that see what sensors measured.

use pulp::{Arch, Simd, WithSimd};

use super::bodies::{Bodies, Drivers};
use super::case::Case;
use super::together::Together;
use crate::arm::{Arm, ModelsAbreast};
use crate::control::{Command, Compensator, Demand, Law, Sample};
use crate::math::{
    Abreast, LANES, Load, Real, Register, Vector, in_lanes, lane, none_missing, store,
};
use crate::plant::Disturbance;
use crate::reference::Setpoint;

/// Eight controllers, what they see, and what they ask for.
pub(super) struct Measured<const N: usize> {
    together: Together<N>,
    /// M₀ and H₀ at the measured motion.
    models: ModelsAbreast<N>,
    seen: Sample<N, Abreast>,
    demand: Demand<N, Abreast>,
    asked: Vector<N, Abreast>,
    tau: Vector<N, Abreast>,
    rho_hat: Vector<N, Abreast>,
    /// What the drives told of the period that ends.
    told: Vector<N, Abreast>,
}

impl<const N: usize> Measured<N> {
    /// Those of these runs; `None` where they cannot go side by side.
    pub fn new<A: Arm<N>, D: Disturbance<N>, L: Law<N>, C: Compensator<N, S>, R, S: Clone>(
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
        bodies: &Bodies<N>,
    ) -> Option<Self> {
        let together = Together::new(cases, bodies)?;
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

    /// Shows the controller in a lane its sample, as it feels it, and what the drives told of the
    /// period before.
    pub fn show(&mut self, i: usize, seen: &Sample<N>, told: Option<&Vector<N>>) {
        let Sample { q, dq, desired, e, de } = seen;
        let all = &mut self.seen;
        for n in 0..N {
            (all.q[n].0[i], all.dq[n].0[i]) = (q[n], dq[n]);
            (all.e[n].0[i], all.de[n].0[i]) = (e[n], de[n]);
            all.desired.q[n].0[i] = desired.q[n];
            all.desired.dq[n].0[i] = desired.dq[n];
            all.desired.ddq[n].0[i] = desired.ddq[n];
        }
        if let Some(told) = told {
            self.tell(i, told);
        }
    }

    /// Tells the controller in a lane what the drives told of the last period.
    pub fn tell(&mut self, i: usize, told: &Vector<N>) {
        for n in 0..N {
            self.told[n].0[i] = told[n];
        }
    }

    /// Decides on the torques of a period \[s\]; the one before, if it has `begun`, ends. What is
    /// out of the ordinary is `lost`.
    pub fn decide(&mut self, arch: Arch, begun: bool, period: f64, lost: &mut Abreast) {
        if begun {
            self.end(arch, period, lost);
        }
        let Self { together, models, seen, demand, asked, tau, rho_hat, .. } = self;
        models.find(arch, (&seen.q, &seen.dq));
        *rho_hat = *together.estimate(arch, seen, lost);
        let drivers = &together.drivers;
        in_lanes(arch, Ask { drivers, models, seen, rho_hat, demand, asked, tau, lost });
    }

    /// Ends a period \[s\] with what the drives told of it.
    pub fn end(&mut self, arch: Arch, period: f64, lost: &mut Abreast) {
        let Self { together, asked, told, .. } = self;
        together.end(arch, (asked, told), true, period, lost);
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
    models: &'a ModelsAbreast<N>,
    seen: &'a Sample<N, Abreast>,
    rho_hat: &'a Vector<N, Abreast>,
    demand: &'a mut Demand<N, Abreast>,
    asked: &'a mut Vector<N, Abreast>,
    tau: &'a mut Vector<N, Abreast>,
    lost: &'a mut Abreast,
}

impl<const N: usize> WithSimd for Ask<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { drivers, models, seen, rho_hat, demand, asked, tau, lost } = self;
        let Drivers { laws, limits: [controllers, _], .. } = drivers;
        for part in 0..Register::<S>::PARTS {
            let (mass, bias) = (models.mass.load(simd, part), models.bias.load(simd, part));
            let (seen, rho_hat) = (seen.load(simd, part), rho_hat.load(simd, part));
            let Demand { model, compensation, v } =
                laws.torque((simd, part), (&mass, &bias), &seen, &rho_hat);
            let (mut sum, mut infinite) = (model, lost.load(simd, part));
            for n in 0..N {
                sum[n] += compensation[n];
            }
            let clamped = controllers.load(simd, part).clamp(&sum);
            for n in 0..N {
                infinite += clamped[n] * infinite.like(0.0);
            }
            store(&model, &mut demand.model, part);
            store(&compensation, &mut demand.compensation, part);
            store(&v, &mut demand.v, part);
            store(&sum, asked, part);
            store(&clamped, tau, part);
            infinite.store(lost, part);
        }
    }
}
