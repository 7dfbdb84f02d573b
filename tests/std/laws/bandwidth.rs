//! Gains from one bandwidth, on three arms: the paper's two links, and a Panda and a UR5e that
//! carry 2 kg of which no law knows.

use std::ops::ControlFlow;

use steadyarm::arm::{Arm, Parametric};
use steadyarm::control::{
    Compensator, ComputedTorque, Controller, DynamicState, Feedback, Gains, Inputs, Law,
    NoCompensation, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::laws::{
    AdaptiveComputedTorque, AdaptiveComputedTorqueState, AdaptiveParameters, DisturbanceObserver,
    HInfinity, Inertia, Integral, Mismatch, MomentumObserver, Pace, Passive, PassiveFuzzy,
    PdGravity, RbfNetwork, Rise, Robust, SlidingMode, SuperTwisting, TimeDelay, TimeDelayState,
};
use steadyarm::paper;
use steadyarm::plant::{Disturbance, Plant};
use steadyarm::reference::Reference;
use steadyarm::sim::{Options, Run, Status, simulate};

use crate::counting::calls_during;

const PERIOD: f64 = 1e-3;

/// A nominal arm, what is there, where it goes, and what a user would declare.
struct Scene<const N: usize, A, P, D, R> {
    name: &'static str,
    nominal: A,
    plant: Plant<N, P, D>,
    reference: R,
    bandwidth: f64,
    mismatch: Mismatch,
    pace: Pace<N>,
    duration: f64,
    /// Largest error that counts as followed, over the second half [rad].
    bound: f64,
}

impl<const N: usize, A: Arm<N> + Copy + Send + Sync, P: Arm<N>, D: Disturbance<N>, R: Reference<N>>
    Scene<N, A, P, D, R>
{
    fn p(&self) -> [f64; N] {
        [self.bandwidth; N]
    }

    fn computed<F: Feedback<N>>(&self, feedback: F) -> ComputedTorque<N, A, F> {
        ComputedTorque::new(self.nominal, feedback)
    }

    /// Simulates, and steps on by hand: no step allocates.
    fn follows<L, C, S>(&self, name: &str, law: L, compensator: C, memory: S)
    where
        L: Law<N> + Clone + Send + Sync,
        C: Compensator<N, S> + Clone + Send + Sync,
        S: Clone + Send + Sync,
    {
        let first = self.reference.at(0.0);
        let options = Options {
            duration: self.duration,
            q0: first.q.into(),
            dq0: first.dq.into(),
            control_period: Some(PERIOD),
            ..Options::default()
        };
        let controller = Controller::new(law, compensator);
        let mut state = State::new(memory);
        let go_on = |_| ControlFlow::Continue(());
        let run = simulate(&self.plant, &controller, &mut state, &self.reference, &options, go_on);
        let run = run.unwrap();
        let largest = last_half(&run);
        assert_eq!(run.status, Status::Finished, "{}: {name}", self.name);
        assert!(largest < self.bound, "{}: {name}: {largest}", self.name);
        let calls = calls_during(|| {
            for k in 0..10 {
                let desired = self.reference.at(1e-3 * f64::from(k));
                controller.step(&mut state, &desired.q, &desired.dq, &desired, PERIOD).unwrap();
            }
        });
        assert_eq!(calls, 0, "{name}");
    }

    /// Laws without a memory, and those that integrate.
    fn feedbacks(&self) {
        let (p, none) = (self.p(), NoCompensation);
        let gains = Gains::with_bandwidth(p).unwrap();
        gains.suits(PERIOD, 0.0).unwrap();
        self.follows("computed torque", self.computed(gains), none, ());
        let pd = PdGravity::with_bandwidth(self.nominal, p).unwrap();
        pd.suits(PERIOD, 0.0).unwrap();
        self.follows("PD + gravity", pd, none, ());
        let (of_integral, integral) = Integral::with_bandwidth(p).unwrap();
        of_integral.suits(PERIOD, 0.0).unwrap();
        integral.covers(&of_integral, &self.mismatch).unwrap();
        self.follows("PID", self.computed(of_integral), integral, DynamicState::new());
        let sliding = SlidingMode::with_bandwidth(p, &self.mismatch).unwrap();
        sliding.suits(PERIOD, 0.0).unwrap();
        sliding.covers(&self.mismatch, 0.0).unwrap();
        self.follows("sliding mode", self.computed(sliding), none, ());
        let robust = Robust::with_bandwidth(p, &self.mismatch).unwrap();
        robust.suits(PERIOD, 0.0).unwrap();
        robust.covers(&self.mismatch).unwrap();
        self.follows("robust", self.computed(robust), none, ());
        let h_infinity = HInfinity::with_bandwidth(p).unwrap();
        h_infinity.suits(PERIOD, 0.0).unwrap();
        self.follows("H infinity", self.computed(h_infinity), none, ());
        let twisting = SuperTwisting::with_bandwidth(p, &self.mismatch).unwrap();
        twisting.suits(PERIOD, 0.0).unwrap();
        self.follows("super-twisting", self.computed(twisting), twisting, DynamicState::new());
        let rise = Rise::with_bandwidth(p, &self.mismatch).unwrap();
        rise.suits(PERIOD, 0.0).unwrap();
        self.follows("RISE", self.computed(rise), rise, DynamicState::new());
        let passive = Passive::with_bandwidth(self.nominal, p).unwrap();
        passive.suits(PERIOD, 0.0).unwrap();
        self.follows("passive", passive, none, ());
    }

    fn observers(&self) {
        let (p, nominal) = (self.p(), self.nominal);
        let gains = Gains::with_bandwidth(p).unwrap();
        let observer = DisturbanceObserver::with_bandwidth(nominal, p).unwrap();
        observer.suits(PERIOD, 0.0).unwrap();
        self.follows("disturbance observer", self.computed(gains), observer, DynamicState::new());
        let momentum = MomentumObserver::with_bandwidth(nominal, self.bandwidth).unwrap();
        momentum.suits(PERIOD, 0.0).unwrap();
        self.follows("momentum observer", self.computed(gains), momentum, DynamicState::new());
        let (delayed, inertia) =
            Inertia::with_bandwidth(nominal, self.bandwidth, PERIOD, 0.0).unwrap();
        inertia.covers(&self.mismatch).unwrap();
        let law = ComputedTorque::new(inertia, delayed);
        self.follows("time delay", law, TimeDelay { arm: inertia }, TimeDelayState::new());
        let centers = [-2.0, -1.0, 0.0, 1.0, 2.0];
        let network = RbfNetwork { centers: &centers, width: 3.0 };
        let (of_network, network) = network.with_bandwidth(p).unwrap();
        let weights = network.state();
        self.follows("RBF network", self.computed(of_network), network, weights);
        let passive = Passive::with_bandwidth(nominal, p).unwrap();
        let axis = Axis { centers: &[-1.0, 0.0, 1.0], widths: &[0.5] };
        let basis = FuzzyBasis::new(Form::Concat, true, &[axis; 64][..2 * N]).unwrap();
        let fuzzy = PassiveFuzzy::with_bandwidth(nominal, basis, p, Inputs::reference()).unwrap();
        let weights = fuzzy.approximator().state();
        self.follows("passivity form", passive, fuzzy, weights);
    }

    fn parameters<const K: usize>(&self)
    where
        A: Parametric<N, K>,
    {
        let (p, nominal) = (self.p(), self.nominal);
        let passive = Passive::with_bandwidth(nominal, p).unwrap();
        let plain = AdaptiveParameters::with_bandwidth(nominal, p, &self.pace).unwrap();
        self.follows("Slotine-Li", passive, plain, DynamicState::<K>::new());
        let (gains, model) =
            AdaptiveComputedTorque::with_bandwidth(nominal, p, &self.pace).unwrap();
        let memory = AdaptiveComputedTorqueState::<N, K>::new();
        self.follows("adaptive computed torque", self.computed(gains), model, memory);
    }
}

/// Largest |e| over the second half [rad].
fn last_half<const N: usize>(run: &Run<N>) -> f64 {
    run.e[run.e.len() / 2..].iter().flatten().fold(0.0, |most, e| most.max(e.abs()))
}

#[test]
fn every_law_follows_on_the_papers_plant_with_gains_from_one_bandwidth() {
    let scene = Scene {
        name: "two links",
        nominal: paper::nominal().unwrap(),
        plant: paper::plant().unwrap(),
        reference: paper::reference().unwrap(),
        bandwidth: 10.0,
        mismatch: Mismatch { inertia: 0.5, acceleration: 5.0, disturbance: 5.0 },
        pace: Pace { speed: [1.0; 2], acceleration: [2.0; 2] },
        duration: 20.0,
        bound: 0.2,
    };
    scene.feedbacks();
    scene.observers();
    scene.parameters::<5>();
}

#[cfg(feature = "urdf")]
mod shipped {
    use nalgebra::Vector3;
    use steadyarm::arm::{self, Serial};
    use steadyarm::laws::NaturalParameters;
    use steadyarm::math::Matrix;
    use steadyarm::plant::Undisturbed;
    use steadyarm::reference::{Harmonic, Sines};
    use steadyarm::robot;

    use super::*;

    fn natural<const N: usize, const K: usize, R: Reference<N>>(
        scene: &Scene<N, Serial<N>, Serial<N>, Undisturbed, R>,
    ) where
        Serial<N>: Parametric<N, K>,
    {
        let passive = Passive::with_bandwidth(scene.nominal, scene.p()).unwrap();
        let natural = NaturalParameters::with_bandwidth(scene.nominal, scene.p(), &scene.pace);
        scene.follows("Slotine-Li, natural", passive, natural.unwrap(), DynamicState::<K>::new());
    }

    /// A shipped arm with rotors of 0.1 kg m² that are known, and 2 kg and friction that are not.
    fn scene<const N: usize>(
        name: &'static str,
        start: [f64; N],
    ) -> Scene<N, Serial<N>, Serial<N>, Undisturbed, Sines<N, [Harmonic<N>; 1]>> {
        let shipped: Serial<N> = robot::shipped(name).unwrap().arm().unwrap();
        let mut parameters = *shipped.without_friction().parameters();
        parameters.links.iter_mut().for_each(|link| link.armature = 0.1);
        let nominal = Serial::new(parameters).unwrap();
        for link in &mut parameters.links {
            link.friction.coulomb = [0.01 * link.limits.effort; 2];
            link.friction.viscous = 0.01 * link.limits.effort;
            link.friction.smoothing = 0.01;
        }
        let com = Vector3::new(0.0, 0.0, 0.05);
        let load = arm::Inertia { mass: 2.0, com, moments: Matrix::<3>::zeros() };
        let actual = Serial::new(parameters).unwrap().with_payload(&load).unwrap();
        let sin = core::array::from_fn(|n| if n % 2 == 0 { 0.3 } else { -0.3 });
        let swing = Harmonic { frequency: 2.0, sin, cos: [0.0; N] };
        Scene {
            name,
            nominal,
            plant: Plant::new(actual, Undisturbed),
            reference: Sines::new(start, [swing]).unwrap(),
            bandwidth: 15.0,
            mismatch: Mismatch { inertia: 0.5, acceleration: 10.0, disturbance: 10.0 },
            pace: Pace { speed: [0.6; N], acceleration: [1.2; N] },
            duration: 8.0,
            bound: 0.3,
        }
    }

    #[test]
    fn every_law_follows_on_a_loaded_panda_with_gains_from_one_bandwidth() {
        let scene = scene("panda", [0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8]);
        scene.feedbacks();
        scene.observers();
        scene.parameters::<70>();
        natural::<7, 70, _>(&scene);
    }

    #[test]
    fn every_law_follows_on_a_loaded_ur5e_with_gains_from_one_bandwidth() {
        let scene = scene("ur5e", [0.0, -1.2, 1.4, -1.8, -1.5, 0.3]);
        scene.feedbacks();
        scene.observers();
        scene.parameters::<60>();
        natural::<6, 60, _>(&scene);
    }
}
