//! Laws and compensators from outside: what the example shows, and what the traits promise to them.
use std::ops::ControlFlow;

use steadyarm::arm::{Arm, TwoLink, TwoLinkParameters};
use steadyarm::control::{
    Applied, ComputedTorque, Controller, Dynamic, DynamicState, Gains, Law, NoCompensation, Sample,
    State,
};
use steadyarm::math::{Matrix, Vector};
use steadyarm::paper;
use steadyarm::plant::{Disturbance, Plant, Undisturbed};
use steadyarm::reference::Setpoint;
use steadyarm::sim::{Method, Options, Run, Tolerance, simulate};

use self::example::{Observer, SlotineLi, rms};

#[allow(dead_code)]
#[path = "../../../examples/rival.rs"]
mod example;

/// A mass on a rail, m = 2 kg: the closed loop is linear.
#[derive(Clone, Copy)]
struct Mass;

const M: f64 = 2.0;

impl Arm<1> for Mass {
    fn mass_matrix(&self, _: &Vector<1>) -> Matrix<1> {
        Matrix::<1>::new(M)
    }
    fn rigid_bias(&self, _: &Vector<1>, _: &Vector<1>) -> Vector<1> {
        Vector::zeros()
    }
}

/// The pole of the observer [1/s], and a constant push [N].
const POLE: f64 = 12.0;
const PUSH: f64 = 3.0;

fn push(_: &Vector<1>, _: &Vector<1>, _: f64) -> Vector<1> {
    Vector::<1>::new(PUSH)
}

/// A run of the mass towards 0.3 under the constant push.
fn mass<D: Dynamic<1, K>, const K: usize>(
    dynamic: D,
    effort_limit: f64,
    options: &Options<1>,
) -> (Run<1>, State<1, DynamicState<K>>) {
    let plant = Plant::new(Mass, push).with_effort_limit([effort_limit]).unwrap();
    let law = ComputedTorque::new(Mass, Gains::new([9.0], [6.0]).unwrap());
    let controller = Controller::new(law, dynamic);
    let mut state = State::new(DynamicState::new());
    let run = run_of(&plant, &controller, &mut state, options);
    (run, state)
}

fn run_of<const N: usize, const K: usize, A: Arm<N>, L: Law<N>, D: Dynamic<N, K>>(
    plant: &Plant<N, A, impl Disturbance<N>>,
    controller: &Controller<N, L, D>,
    state: &mut State<N, DynamicState<K>>,
    options: &Options<N>,
) -> Run<N> {
    let reference = |_| Setpoint::at_rest(Vector::repeat(0.3));
    let go_on = |_| ControlFlow::Continue(());
    simulate(plant, controller, state, &reference, options, go_on).unwrap()
}

fn observer() -> Observer<Mass> {
    Observer { arm: Mass, pole: POLE }
}

/// Largest |ρ̂ − ρ(1 − e^(−l t))| with ρ = −d/m: the observer's transfer function l/(s + l),
/// answered by a step.
fn misses(run: &Run<1>) -> f64 {
    let exact = |t: f64| -PUSH / M * (1.0 - (-POLE * t).exp());
    let misses = run.t.iter().zip(&run.rho_hat).map(|(&t, &[rho_hat])| (rho_hat - exact(t)).abs());
    misses.fold(0.0, f64::max)
}

#[test]
fn each_rival_tracks_better_with_the_observer_than_alone() {
    let arm = paper::nominal().unwrap();
    let passive = SlotineLi { arm, lambda: 3.0, damping: 5.0 };
    let computed = ComputedTorque::new(arm, paper::gains().unwrap());
    let observer = Observer { arm, pole: 20.0 };
    for period in [None, Some(1e-3)] {
        let alone = [
            rms(passive, NoCompensation, (), period).unwrap(),
            rms(computed, NoCompensation, (), period).unwrap(),
        ];
        let observed = [
            rms(passive, observer, DynamicState::new(), period).unwrap(),
            rms(computed, observer, DynamicState::new(), period).unwrap(),
        ];
        for (alone, observed) in alone.into_iter().zip(observed) {
            assert!(observed < 0.2 * alone, "{period:?}: {observed} with, {alone} without");
        }
    }
}

/// V = ½ sᵀMs falls by ∫ sᵀK_D s for the right arm (Slotine and Li 1987); ∫ by Simpson's rule.
#[test]
fn slotine_li_dissipates_what_its_proof_says() {
    let (arm, lambda, damping) = (paper::nominal().unwrap(), 3.0, 5.0);
    let law = SlotineLi { arm, lambda, damping };
    let controller = Controller::new(law, NoCompensation);
    let options = Options { duration: 2.0, dt: 1e-4, q0: [-0.5, 0.4], ..Options::default() };
    let (reference, plant) = (paper::reference().unwrap(), Plant::new(arm, Undisturbed));
    let go_on = |_| ControlFlow::Continue(());
    let run =
        simulate(&plant, &controller, &mut State::new(()), &reference, &options, go_on).unwrap();
    let s = |k: usize| Vector::<2>::from(run.de[k]) + Vector::<2>::from(run.e[k]) * lambda;
    let v = |k: usize| 0.5 * s(k).dot(&(arm.mass_matrix(&run.q[k].into()) * s(k)));
    let last = run.t.len() - 1;
    let weight = |k: usize| if k == 0 || k == last { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
    let lost: f64 = (0..=last).map(|k| weight(k) * damping * s(k).norm_squared()).sum();
    let lost = lost * options.dt / 3.0;
    assert!(v(last) < 0.01 * v(0), "{} {}", v(0), v(last));
    assert!((v(0) - v(last) - lost).abs() < 1e-10, "{} {} {lost}", v(0), v(last));
    // v is the acceleration under the law's torque, so a right model leaves nothing out.
    assert!(run.rho.iter().flatten().all(|rho| rho.abs() < 1e-9));
}

#[test]
fn a_dynamic_follows_its_exact_solution_with_order_four() {
    let by = |dt| {
        let options = Options { duration: 1.0, dt, ..Options::default() };
        misses(&mass(observer(), f64::INFINITY, &options).0)
    };
    let (coarse, fine) = (by(2e-2), by(1e-2));
    assert!(fine < 1e-4 && (12.0..20.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

#[test]
fn a_dynamic_follows_its_exact_solution_under_error_control() {
    let method = Method::Dp54(Tolerance { rtol: 1e-10, atol: 1e-12 });
    let options = Options { duration: 1.0, dt: 0.01, method, dq0: [1.5], ..Options::default() };
    let found = misses(&mass(observer(), f64::INFINITY, &options).0);
    assert!(found < 1e-8, "{found:e}");
}

/// The actuators give a third of what is asked for, and the observer is told so: its answer does
/// not change.
#[test]
fn an_observer_is_told_the_torque_that_acted() {
    let options = Options { duration: 1.0, ..Options::default() };
    let (run, _) = mass(observer(), 1.0, &options);
    assert!(run.tau.iter().take(100).all(|tau| tau[0].abs() == 1.0));
    assert!(misses(&run) < 1e-7, "{:e}", misses(&run));
}

/// Under a held torque q̇ₖ₊₁ − q̇ₖ = h (τ − d)/m, so ρ̂ₖ = ρ(1 − (1 − l h)ᵏ) for Euler's step of z.
#[test]
fn a_sampled_dynamic_takes_one_step_of_euler_a_period() {
    let h = 0.01;
    let options =
        Options { duration: 1.0, dt: h, control_period: Some(h), dq0: [0.7], ..Options::default() };
    let (run, _) = mass(observer(), f64::INFINITY, &options);
    for (k, [rho_hat]) in run.rho_hat.iter().take(100).enumerate() {
        let exact = -PUSH / M * (1.0 - (1.0 - POLE * h).powi(k as i32));
        assert!((rho_hat - exact).abs() < 1e-12, "{k}: {rho_hat} {exact}");
    }
}

/// Integral action, z = ∫ e dt, ρ̂ = k_i z, which must hold while the torque is limited.
struct Integral(f64);

impl Dynamic<1, 1> for Integral {
    fn estimate(&self, z: &Vector<1>, _: &Sample<1>) -> Vector<1> {
        z * self.0
    }
    fn rate(&self, _: &Vector<1>, seen: &Sample<1>, applied: &Applied<1>) -> Vector<1> {
        if applied.limited() { Vector::zeros() } else { seen.e }
    }
}

/// PID: k_i < k_p k_v, so that a constant push leaves no error, and k_i z = −d/m in the end.
#[test]
fn integral_action_removes_a_constant_push() {
    for control_period in [None, Some(1e-3)] {
        let options = Options { duration: 20.0, control_period, ..Options::default() };
        let (run, state) = mass(Integral(8.0), f64::INFINITY, &options);
        let (e, z) = (run.e.last().unwrap()[0], state.compensator().z().unwrap()[0]);
        assert!(e.abs() < 1e-6, "{control_period:?}: {e:e}");
        assert!((8.0 * z + PUSH / M).abs() < 1e-5, "{control_period:?}: {z}");
    }
}

#[test]
fn nothing_winds_up_while_the_actuators_cannot_follow() {
    // The push is stronger than the actuators: the mass runs away, and e with it.
    let options = Options { duration: 2.0, ..Options::default() };
    let (run, state) = mass(Integral(8.0), 0.5 * PUSH, &options);
    assert!(run.tau.iter().all(|tau| tau[0].abs() == 0.5 * PUSH));
    assert_eq!(state.compensator().z().unwrap()[0], 0.0);
    assert!(run.e.last().unwrap()[0] < -1.0);
}

/// Its rate is ż = 1/(q₀ − 1): none at q₀ = 1.
struct Fragile;

impl Dynamic<2, 1> for Fragile {
    fn estimate(&self, z: &Vector<1>, _: &Sample<2>) -> Vector<2> {
        Vector::repeat(z[0])
    }
    fn rate(&self, _: &Vector<1>, seen: &Sample<2>, _: &Applied<2>) -> Vector<1> {
        Vector::<1>::new(1.0 / (seen.q[0] - 1.0))
    }
}

#[test]
fn a_period_that_cannot_end_is_left_out_and_locks_nothing() {
    let law = ComputedTorque::new(paper::nominal().unwrap(), paper::gains().unwrap());
    let controller = Controller::new(law, Fragile);
    let (mut state, desired) =
        (State::new(DynamicState::new()), Setpoint::at_rest(Vector::zeros()));
    let step = |state: &mut _, q| {
        let (q, dq) = (Vector::<2>::repeat(q), Vector::<2>::zeros());
        controller.step(state, &q, &dq, &desired, 1e-3)
    };
    step(&mut state, 0.1).unwrap();
    controller.settle(&mut state);
    let mut twin = state.clone();
    for _ in 0..3 {
        // q₀ = 1 can be answered; its period has no end.
        step(&mut state, 1.0).unwrap();
        let before = state.clone();
        assert!(step(&mut state, f64::NAN).unwrap_err().to_string().starts_with('q'));
        assert_eq!(state, before);
        let mut told = state.clone();
        let error = controller.end_period(&mut told, None).unwrap_err().to_string();
        assert!(error.starts_with('z'), "{error}");
        assert_eq!(controller.end_period(&mut told, None), Ok(()));
        // The next step learns nothing from it and goes on.
        assert_eq!(step(&mut state, 0.2).unwrap(), step(&mut twin, 0.2).unwrap());
        assert_eq!(controller.settle(&mut state).z(), controller.settle(&mut twin).z());
    }
    controller.reset(&mut state);
    assert_eq!(state, State::new(DynamicState::new()));
}

#[test]
fn the_memory_starts_as_the_first_sample_says() {
    let options = Options { duration: 0.1, dq0: [5.0], ..Options::default() };
    assert_eq!(mass(observer(), f64::INFINITY, &options).0.rho_hat[0], [0.0]);
}

#[test]
fn an_arm_under_the_resting_torque_of_its_law_stays_at_rest() {
    let upright = TwoLinkParameters { gravity: 9.81, ..TwoLinkParameters::default() };
    let arm = TwoLink::new(upright).unwrap();
    let law = ComputedTorque::new(arm, paper::gains().unwrap());
    for q in [[0.3, -1.1], [2.0, 0.4]].map(Vector::<2>::from) {
        let tau = law.resting_torque(&q);
        let ddq = arm.forward_dynamics(&q, &Vector::zeros(), &tau);
        assert!(tau.norm() > 1.0 && ddq.norm() < 1e-12, "{tau} {ddq}");
    }
}

#[test]
fn a_fingerprint_tells_arms_apart_and_nothing_else() {
    let law = |parameters, kp| {
        ComputedTorque::new(
            TwoLink::new(parameters).unwrap(),
            Gains::new([kp; 2], [5.0; 2]).unwrap(),
        )
    };
    let usual = TwoLinkParameters::default();
    let print = law(usual, 8.0).fingerprint();
    assert_eq!(print, law(usual, 9.0).fingerprint());
    let other = |change: fn(&mut TwoLinkParameters)| {
        let mut parameters = usual;
        change(&mut parameters);
        law(parameters, 8.0).fingerprint()
    };
    let others = [
        other(|p| p.mass[1] *= 1.0 + f64::EPSILON),
        other(|p| p.inertia[1] += 1e-9),
        other(|p| p.length[0] += 1e-9),
        other(|p| p.gravity += 1e-9),
        other(|p| p.friction.viscous[1] += 1e-9),
        other(|p| p.friction.coulomb[0] += 1e-9),
    ];
    for (k, other) in others.iter().enumerate() {
        assert!(*other != print && !others[..k].contains(other), "{k}");
    }
}
