//! Rank-one updates against a dense integration of (q, q̇, W), weight by weight.

use crate::common::{self, Adaptive, FORMS, Random, everything, fresh, law, learnt, modified, on};
use steadyarm::control::{Adaptation, Feedback, Inputs, Signal};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::reference::{Reference, Setpoint};
use steadyarm::sim::{Options, simulate};

/// Both take the same steps and differ in the order of their sums only: 2e-15 was seen after 2000
/// steps.
const DENSE_TOL: f64 = 1e-12;
const H: f64 = 1e-3;

/// The whole state (q, q̇, W), with W multiplied by exp(leak t): RK4 of that is what "the leak is
/// integrated exactly" means.
#[derive(Clone)]
struct Whole {
    q: Vector<2>,
    dq: Vector<2>,
    z: Vec<f64>,
}

impl Whole {
    fn plus(&self, h: f64, rate: &Self) -> Self {
        let z = self.z.iter().zip(&rate.z).map(|(z, r)| z + h * r).collect();
        Self { q: self.q + rate.q * h, dq: self.dq + rate.dq * h, z }
    }
}

/// The loop with the law written out as the equations have it, weight by weight.
struct Dense<'a> {
    controller: &'a Adaptive,
    blocks: usize,
    prior: Vec<f64>,
}

impl Dense<'_> {
    fn rate(&self, t: f64, y: &Whole) -> Whole {
        let (plant, controller) = (common::plant(), self.controller);
        let a = controller.compensator.parameters().adaptation;
        let desired = common::reference().at(t);
        let (e, de) = (y.q - desired.q, y.dq - desired.dq);
        let xi = self.xi(&[y.q, y.dq], &[e, de], &desired);
        let rules = y.z.len() / 2;
        let row = |n: usize| n * rules..(n + 1) * rules;
        let xi_of = |n: usize| if self.blocks == 1 { &xi[..] } else { &xi[row(n)] };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let d: Vec<f64> = y.z.iter().map(|z| z * (-a.leak_rate * t).exp()).collect();
        let learnt = Vector::<2>::from_fn(|n, _| dot(&d[row(n)], xi_of(n)));
        let prior = Vector::<2>::from_fn(|n, _| dot(&self.prior[row(n)], xi_of(n)));
        let p = controller.compensator.p();
        let s = Vector::<2>::from_fn(|n, _| p[n].p12 * e[n] + p[n].p22 * de[n]);
        let drive = Vector::<2>::from_fn(|n, _| {
            let zone = (1.0 - a.dead_zone / s.norm()).max(0.0);
            a.gain[n] * s[n] * zone / (1.0 + a.normalization * dot(xi_of(n), xi_of(n)))
        });
        let pull = a.error_modification * s.norm() + projection(&a, &d, drive.dot(&learnt));
        let (grow, mut z) = ((a.leak_rate * t).exp(), y.z.clone());
        for n in 0..2 {
            for (j, k) in row(n).enumerate() {
                z[k] = grow * (drive[n] * xi_of(n)[j] - a.gain[n] * pull * d[k]);
            }
        }
        let v =
            controller.law.gains.acceleration(&steadyarm::control::Sample::new(y.q, y.dq, desired));
        let tau = steadyarm::arm::Arm::inverse_dynamics(
            &controller.law.arm,
            &y.q,
            &y.dq,
            &(v - learnt - prior),
        );
        Whole { q: y.dq, dq: plant.acceleration(&y.q, &y.dq, &tau, t), z }
    }

    fn xi(
        &self,
        measured: &[Vector<2>; 2],
        error: &[Vector<2>; 2],
        desired: &Setpoint<2>,
    ) -> Vec<f64> {
        let compensator = &self.controller.compensator;
        let signals = compensator.parameters().inputs;
        let x = signals.signals().iter().flat_map(|(signal, scale)| {
            let value = match signal {
                Signal::E => error[0],
                Signal::De => error[1],
                Signal::Q => measured[0],
                Signal::Dq => measured[1],
                Signal::QDesired => desired.q,
                Signal::DqDesired => desired.dq,
                Signal::DdqDesired => desired.ddq,
            };
            [scale * value[0], scale * value[1]]
        });
        let (basis, x) = (compensator.basis(), x.collect::<Vec<_>>());
        let mut xi = vec![0.0; basis.rules()];
        basis.evaluate(&x, &mut vec![0.0; basis.work_len()], &mut xi).unwrap();
        xi
    }

    /// RK4 from t = 0, with the weights brought back into the projection's ball after each step;
    /// returns (q, q̇, W).
    fn run(&self, start: [f64; 2], steps: usize) -> (Vector<2>, Vector<2>, Vec<f64>) {
        let a = self.controller.compensator.parameters().adaptation;
        let z = vec![0.0; self.controller.compensator.weights_len()];
        let mut y = Whole { q: start.into(), dq: Vector::zeros(), z };
        for k in 0..steps {
            let t = k as f64 * H;
            let k1 = self.rate(t, &y);
            let k2 = self.rate(t + H / 2.0, &y.plus(H / 2.0, &k1));
            let k3 = self.rate(t + H / 2.0, &y.plus(H / 2.0, &k2));
            let k4 = self.rate(t + H, &y.plus(H, &k3));
            y = y.plus(H / 6.0, &k1).plus(H / 3.0, &k2).plus(H / 3.0, &k3).plus(H / 6.0, &k4);
            let largest = a.projection_radius * (a.leak_rate * (t + H)).exp();
            let norm = y.z.iter().map(|z| z * z).sum::<f64>().sqrt();
            if norm > largest {
                y.z.iter_mut().for_each(|z| *z *= largest / norm);
            }
        }
        let fade = (-a.leak_rate * steps as f64 * H).exp();
        (y.q, y.dq, y.z.iter().zip(&self.prior).map(|(z, w)| w + z * fade).collect())
    }
}

/// κ_p of Pomet and Praly: from 0.9 R on it takes a growing share of the growth of |D|, at R all of
/// it.
fn projection(a: &Adaptation<2>, d: &[f64], growth: f64) -> f64 {
    let (outer, rules) = (a.projection_radius * a.projection_radius, d.len() / 2);
    let inner = 0.81 * outer;
    let rows = [&d[..rules], &d[rules..]].map(|row| row.iter().map(|w| w * w).sum::<f64>());
    let depth = (rows[0] + rows[1] - inner) / (outer - inner);
    if outer.is_infinite() || growth <= 0.0 || depth <= 0.0 {
        return 0.0;
    }
    depth * growth / (a.gain[0] * rows[0] + a.gain[1] * rows[1])
}

/// 2 s of the crate and of the dense loop; `prior` are weights to start warm from.
fn assert_equals_dense(name: &str, controller: &Adaptive, prior: Option<Vec<f64>>) -> Vec<f64> {
    let mut state = fresh(controller);
    if let Some(prior) = &prior {
        controller.compensator.warm_start(controller.settle(&mut state), prior).unwrap();
    }
    let options = Options { duration: 2.0, dt: H, q0: [0.3, -0.2], ..Options::default() };
    let (plant, reference) = (common::plant(), common::reference());
    let run = simulate(&plant, controller, &mut state, &reference, &options, on).unwrap();
    let rules = controller.compensator.basis().rules();
    let blocks = if controller.compensator.weights_len() == 2 * rules { 1 } else { 2 };
    let prior = prior.unwrap_or(vec![0.0; controller.compensator.weights_len()]);
    let (q, dq, w) = Dense { controller, blocks, prior }.run(options.q0, 2000);
    let last = run.t.len() - 1;
    for n in 0..2 {
        let difference = (run.q[last][n] - q[n]).abs().max((run.dq[last][n] - dq[n]).abs());
        assert!(difference < DENSE_TOL, "{name}: q, dq differ by {difference:e}");
    }
    let found = learnt(controller, &state);
    let largest = found.iter().zip(&w).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(largest < DENSE_TOL, "{name}: weights differ by {largest:e}");
    assert!(w.iter().any(|w| w.abs() > 1e-3), "{name}: nothing was learnt");
    found
}

fn modifications() -> [(&'static str, Adaptation<2>); 7] {
    let plain = law(40.0);
    [
        ("plain", plain),
        ("leak", Adaptation { leak_rate: 0.5, ..plain }),
        ("e-modification", Adaptation { error_modification: 0.05, ..plain }),
        ("projection", Adaptation { projection_radius: 1.0, ..plain }),
        ("dead zone", Adaptation { dead_zone: 0.05, ..plain }),
        ("normalisation", Adaptation { normalization: 0.7, ..plain }),
        ("everything", everything(40.0)),
    ]
}

#[test]
fn rank_one_updates_equal_a_dense_integration_with_every_modification() {
    let mut seen: Vec<Vec<f64>> = Vec::new();
    for (name, adaptation) in modifications() {
        let controller = modified(Form::Grid, true, Inputs::error(), adaptation);
        let w = assert_equals_dense(name, &controller, None);
        let differs = |other: &Vec<f64>| w.iter().zip(other).any(|(a, b)| (a - b).abs() > 1e-4);
        assert!(seen.iter().all(differs), "{name} did not act");
        seen.push(w);
    }
}

#[test]
fn rank_one_updates_equal_a_dense_integration_for_every_form_and_choice_of_inputs() {
    let scaled = Inputs::new(&[(Signal::DqDesired, 0.5), (Signal::E, 2.0)]).unwrap();
    for form in FORMS {
        for normalized in [true, false] {
            for inputs in [Inputs::error(), Inputs::state(), Inputs::reference(), scaled] {
                for adaptation in [law(7.0), everything(7.0)] {
                    let controller = modified(form, normalized, inputs, adaptation);
                    let name = format!("{form:?} {normalized} {inputs:?} {adaptation:?}");
                    assert_equals_dense(&name, &controller, None);
                }
            }
        }
    }
}

#[test]
fn a_warm_start_pulls_to_its_own_weights() {
    let mut random = Random(3);
    for (name, adaptation) in modifications() {
        let controller = modified(Form::Concat, true, Inputs::error(), adaptation);
        let prior = (0..40).map(|_| random.within(-0.5, 0.5)).collect();
        assert_equals_dense(name, &controller, Some(prior));
    }
}
