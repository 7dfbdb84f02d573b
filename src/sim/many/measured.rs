//! Controllers of eight loops side by side whose laws do not see their arms as they are: sensors
//! measure these, or something stands before the laws.

use pulp::{Arch, Simd, WithSimd};

use super::bodies::{Bodies, limits};
use super::case::Case;
use super::together::{Together, learns};
use crate::arm::{Arm, ModelsAbreast};
use crate::control::{
    Asks, Command, Compensator, Controller, Demand, FrontsAbreast, Law, LawsAbreast, Limits,
    Sample, State,
};
use crate::math::{
    Abreast, LANES, Load, Real, Register, Vector, in_lanes, lane, none_missing, put, store,
};
use crate::plant::Disturbance;
use crate::reference::Setpoint;

/// Eight controllers, what they see, and what they ask for.
pub(super) struct Measured<const N: usize> {
    laws: Laws<N>,
    /// What stands before laws, and limits of rates, if there are any.
    fronts: Option<FrontsAbreast<N>>,
    /// Limits of controllers, and of plants.
    limits: [Limits<N, Abreast>; 2],
    pub seen: Sample<N, Abreast>,
    demand: Demand<N, Abreast>,
    asked: Vector<N, Abreast>,
    tau: Vector<N, Abreast>,
    rho_hat: Vector<N, Abreast>,
    /// What acts of it; with drives, what they told of the period that ends.
    told: Vector<N, Abreast>,
}

/// Laws, with what compensates.
enum Laws<const N: usize> {
    /// Computed torque, with M₀ and H₀ at the motion that laws see.
    Computed(Box<Together<N>>, Box<ModelsAbreast<N>>),
    Own(Box<dyn Asks<N>>),
}

impl<const N: usize> Measured<N> {
    /// Those of these runs, with their states, of which no period is pending; `None` where they
    /// cannot go side by side.
    pub fn new<A: Arm<N>, D: Disturbance<N>, L: Law<N>, C: Compensator<N, S>, R, S>(
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
        states: &[State<N, S>; LANES],
        bodies: &Bodies<N>,
    ) -> Option<Self> {
        let fronts = if cases.iter().all(|case| case.controller.is_bare()) {
            None
        } else {
            Some(FrontsAbreast::of(core::array::from_fn(|i| (cases[i].controller, &states[i])))?)
        };
        let laws = match Together::new(cases, states, bodies) {
            Some(together) => {
                let models = none_missing(cases.map(|case| case.controller.law.model()))?;
                Laws::Computed(Box::new(together), Box::new(ModelsAbreast::of(models)?))
            }
            None => {
                let laws = none_missing(cases.map(|case| case.controller.law.beliefs()))?;
                let learns = learns(cases, states);
                let own = none_missing(learns.map(|it| it.and_then(|it| it.as_own())))?;
                Laws::Own((own[0].put)(laws, own)?)
            }
        };
        let zeros = Vector::<N, Abreast>::repeat(Abreast::all(0.0));
        let desired = Setpoint { q: zeros, dq: zeros, ddq: zeros };
        Some(Self {
            laws,
            fronts,
            limits: limits(cases),
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
        if let Some(fronts) = &mut self.fronts {
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
        let Self { laws, fronts, limits, seen, demand, asked, tau, rho_hat, told } = self;
        if let Some(fronts) = &mut *fronts {
            fronts.look(arch, seen, lost);
        }
        match laws {
            Laws::Computed(together, models) => {
                models.find(arch, (&seen.q, &seen.dq));
                *rho_hat = *together.estimate(arch, seen, lost);
                let laws = &together.drivers.laws;
                in_lanes(arch, Compute { laws, models, seen, rho_hat, demand });
            }
            Laws::Own(laws) => laws.ask(arch, seen, (demand, rho_hat)),
        }
        let (fronts, torques) = (fronts.as_mut(), [asked, tau, told]);
        in_lanes(arch, Limit { fronts, limits, period, demand, torques, lost });
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
        let Self { laws, fronts, asked, told, .. } = self;
        let acted = fronts.as_ref().map_or(&*asked, |fronts| fronts.acting(asked));
        match laws {
            Laws::Computed(together, _) => {
                together.end(arch, (acted, told), true, period, lost);
            }
            Laws::Own(laws) => laws.end(arch, (acted, told), period, lost),
        }
        if let Some(fronts) = fronts {
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

struct Compute<'a, const N: usize> {
    laws: &'a LawsAbreast<N>,
    models: &'a ModelsAbreast<N>,
    seen: &'a Sample<N, Abreast>,
    rho_hat: &'a Vector<N, Abreast>,
    demand: &'a mut Demand<N, Abreast>,
}

impl<const N: usize> WithSimd for Compute<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { laws, models, seen, rho_hat, demand } = self;
        for part in 0..Register::<S>::PARTS {
            let (mass, bias) = (models.mass.load(simd, part), models.bias.load(simd, part));
            let (seen, rho_hat) = (seen.load(simd, part), rho_hat.load(simd, part));
            let own = laws.torque((simd, part), (&mass, &bias), &seen, &rho_hat);
            store(&own.model, &mut demand.model, part);
            store(&own.compensation, &mut demand.compensation, part);
            store(&own.v, &mut demand.v, part);
        }
    }
}

struct Limit<'a, const N: usize> {
    fronts: Option<&'a mut FrontsAbreast<N>>,
    limits: &'a [Limits<N, Abreast>; 2],
    period: f64,
    demand: &'a mut Demand<N, Abreast>,
    /// What is asked for, commanded, and acts.
    torques: [&'a mut Vector<N, Abreast>; 3],
    lost: &'a mut Abreast,
}

impl<const N: usize> WithSimd for Limit<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { mut fronts, limits, period, demand, torques: [asked, tau, acts], lost } = self;
        let [controllers, actuators] = limits;
        for part in 0..Register::<S>::PARTS {
            let mut model = demand.model.load(simd, part);
            let compensation = demand.compensation.load(simd, part);
            if let Some(fronts) = &mut fronts {
                fronts.cushion((simd, part), &mut model, &compensation);
                store(&model, &mut demand.model, part);
            }
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
            store(&sum, asked, part);
            store(&clamped, tau, part);
            store(&actuators.load(simd, part).clamp(&clamped), acts, part);
            infinite.store(lost, part);
        }
    }
}
