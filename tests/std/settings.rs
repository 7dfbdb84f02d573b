//! Laws and effects by their settings: in TOML and back, built, and refused by the path of a key.

use steadyarm::arm::{Serial, TwoLink};
use steadyarm::control::{Controller, Front, State};
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::reference::{Reference, Setpoint};
use steadyarm::scenario::{Adapts, Around, BuiltLaw, EffectsSettings, LawSettings, Scenario};

use crate::chains;
use crate::counting::calls_during;
use crate::random::Random;

/// One of every law, with a bandwidth.
const LAWS: &str = r#"
[controllers.a]
law = "computed_torque"
bandwidth = 10.0
[controllers.b]
law = "pd_gravity"
bandwidth = 10.0
[controllers.c]
law = "pid"
bandwidth = [10.0, 12.0]
[controllers.d]
law = "sliding_mode"
bandwidth = 10.0
uncertainty = { inertia = 0.5, acceleration = 5.0, disturbance = 2.0 }
[controllers.e]
law = "robust"
bandwidth = 10.0
uncertainty = { inertia = 0.5, acceleration = 5.0, disturbance = 2.0 }
[controllers.f]
law = "h_infinity"
bandwidth = 10.0
[controllers.g]
law = "super_twisting"
bandwidth = 10.0
uncertainty = { inertia = 0.5, acceleration = 5.0, disturbance = 2.0 }
[controllers.h]
law = "rise"
bandwidth = 10.0
uncertainty = { inertia = 0.5, acceleration = 5.0, disturbance = 2.0 }
[controllers.i]
law = "slotine_li"
bandwidth = 10.0
[controllers.j]
law = "natural_slotine_li"
bandwidth = 10.0
[controllers.k]
law = "passive_fuzzy"
bandwidth = 10.0
[controllers.k.compensator.basis]
form = "per_joint"
centers = [-1.0, 0.0, 1.0]
width = 0.7
[controllers.l]
law = "rbf_network"
bandwidth = 10.0
centers = [-1.0, 0.0, 1.0]
width = 1.0
[controllers.m]
law = "adaptive_computed_torque"
bandwidth = 10.0
[controllers.n]
law = "time_delay"
bandwidth = 10.0
[controllers.o]
law = "disturbance_observer"
bandwidth = 10.0
[controllers.p]
law = "momentum_observer"
bandwidth = 10.0
[controllers.q]
law = "recommended"
light_joints = true
"#;

fn all() -> Vec<LawSettings> {
    let scenario = Scenario::from_toml(LAWS).unwrap();
    assert_eq!(Scenario::from_toml(&scenario.to_toml().unwrap()).unwrap(), scenario);
    scenario.controllers.into_values().collect()
}

/// Fifty samples, saved after a half and restored: the same torques, to the bit. A reset is a new
/// one.
fn steps_are_saved<const N: usize>(built: BuiltLaw<N>, name: &str) {
    let Some(compensator) = built.compensator else { return };
    let controller = Controller::new(built.law, compensator);
    let reference = |t: f64| Setpoint {
        q: Vector::<N>::from_fn(|n, _| 0.3 * (t + n as f64).sin()),
        dq: Vector::<N>::from_fn(|n, _| 0.3 * (t + n as f64).cos()),
        ddq: Vector::<N>::from_fn(|n, _| -0.3 * (t + n as f64).sin()),
    };
    let step = |state: &mut State<N, _>, k: u32| {
        let t = f64::from(k) * 1e-3;
        let desired = reference.at(t);
        let q = desired.q + Vector::repeat(0.02 * (9.0 * t).cos());
        controller.step(state, &q, &(desired.dq * 0.9), &desired, 1e-3).unwrap().tau
    };
    let mut state = State::new(controller.compensator.state());
    let first: Vec<_> = (0..25).map(|k| step(&mut state, k)).collect();
    let mut restored = State::new(controller.compensator.state());
    controller.restore(&mut restored, &controller.save(&state)).unwrap();
    let on: Vec<_> = (25..50).map(|k| step(&mut state, k)).collect();
    let again: Vec<_> = (25..50).map(|k| step(&mut restored, k)).collect();
    assert_eq!(on, again, "{name}");
    assert!(on.iter().flatten().all(|tau| tau.is_finite()), "{name}");
    controller.reset(&mut state);
    let anew: Vec<_> = (0..25).map(|k| step(&mut state, k)).collect();
    assert_eq!(first, anew, "{name}");
    // What is frozen does not move any more.
    controller.settle(&mut state).set_frozen(true);
    let kept = controller.save(&state);
    let mut other = state.clone();
    step(&mut other, 25);
    controller.settle(&mut other);
    let tail = |bytes: &[u8]| bytes[bytes.len() - 16..bytes.len() - 8].to_vec();
    assert_eq!(tail(&kept), tail(&controller.save(&other)), "{name}");
    // Saved while frozen, loaded and set free, it is as one that was never frozen.
    let mut free = State::new(controller.compensator.state());
    controller.restore(&mut free, &controller.save(&state)).unwrap();
    for it in [&mut free, &mut state] {
        controller.settle(it).set_frozen(false);
        (25..28).for_each(|k| _ = step(it, k));
    }
    assert_eq!(controller.save(&free), controller.save(&state), "{name}");
}

/// A loop of 1 kHz.
fn around<const N: usize>(delay: usize) -> Around<N> {
    let front = Front { velocity_filter: Some(100.0), delay, ..Front::default() };
    Around { period: Some(1e-3), front, effort_limit: [30.0; N] }
}

fn built<const N: usize, A>(arm: &A) -> usize
where
    A: steadyarm::arm::Arm<N> + Adapts<N> + Clone + Send + Sync + 'static,
{
    let laws = all();
    let built = laws.iter().filter_map(|law| {
        // Two entries of a bandwidth are for two joints.
        let built = law.build(arm, &around(1));
        if built.is_err() {
            assert!(N != 2 && law.name() == "pid" || law.name() == "natural_slotine_li");
        }
        Some((law.name(), built.ok()?))
    });
    built.map(|(name, built)| steps_are_saved(built, name)).count()
}

#[test]
fn every_law_is_built_of_its_settings_saved_and_reset_to_the_bit() {
    let arm: TwoLink = paper::nominal().unwrap();
    assert_eq!(built(&arm), 16);
    let mut random = Random(11);
    let chain: Serial<3> = chains::chain(&mut random);
    assert_eq!(built(&chain), 16);
    let chain: Serial<2> = chains::chain(&mut random);
    assert_eq!(built(&chain), 17);
}

/// Behind pointers too, and with all that stands before the law.
#[test]
fn a_step_of_no_law_allocates() {
    let front =
        Front { hand_over: Some(2.0), velocity_filter: Some(60.0), bumpless: Some(4.0), delay: 2 };
    let mut random = Random(3);
    let arm: Serial<2> = chains::chain(&mut random);
    for law in all() {
        let built = law.build(&arm, &around(2)).unwrap();
        let Some(compensator) = built.compensator else { continue };
        let controller = Controller::new(built.law, compensator).with_front(front).unwrap();
        let mut state = State::new(controller.compensator.state());
        let calls = calls_during(|| {
            for k in 0..2000 {
                let t = f64::from(k) * 1e-3;
                let desired = Setpoint::at_rest(Vector::from([t.sin(), 0.3]));
                let q = Vector::from([t.sin() + 0.01, 0.3 - 0.01 * t]);
                controller.step(&mut state, &q, &Vector::zeros(), &desired, 1e-3).unwrap();
            }
        });
        assert_eq!(calls, 0, "{}", law.name());
    }
}

fn refused(settings: &str) -> String {
    let text = format!("[controllers.it]\n{settings}");
    match Scenario::from_toml(&text) {
        Err(error) => error.to_string(),
        Ok(scenario) => {
            let built = scenario.controllers["it"].build(&paper::nominal().unwrap(), &around(0));
            built.map_or_else(|error| error.to_string(), |_| "accepted".into())
        }
    }
}

#[test]
fn what_is_wrong_with_a_law_is_said_by_the_name_of_its_parameter() {
    for (settings, wanted) in [
        ("law = \"pid\"", "kp: is missing, wants a value"),
        ("law = \"pid\"\nbandwidth = 10.0\nki = 3.0", "ki: got 3, wants no value beside"),
        ("law = \"pid\"\nbandwidth = -1.0", "bandwidth[0]: got -1, wants a number > 0"),
        ("law = \"pid\"\nbandwidth = [1.0, 2.0, 3.0]", "bandwidth: got 3 entries, wants 2"),
        ("law = \"pid\"\nkp = 8.0\nkv = 5.5\nki = 50.0", "ki[0]: got 50, wants less than"),
        ("law = \"slotine_li\"\nslope = 0.0\ndamping = 1.0\ngain = 1.0", "slope[0]: got 0"),
        ("law = \"super_twisting\"\nbandwidth = 10.0", "uncertainty: is missing"),
        (
            "law = \"momentum_observer\"\nbandwidth = 600.0",
            "kv[0]: got 1200, wants a loop whose fastest rate",
        ),
        ("law = \"pd\"\nbandwidth = 1.0", "controllers.it.law: unknown variant `pd`"),
        ("law = \"pid\"\nbandwith = 1.0", "unknown field `bandwith`"),
        ("bandwidth = 1.0", "controllers.it: missing field `law`"),
    ] {
        let error = refused(settings);
        assert!(error.contains(wanted), "{settings}: {error}");
    }
    assert_eq!(refused("law = \"pid\"\nbandwidth = 10.0"), "accepted");
}

#[test]
fn what_is_wrong_with_effects_is_said_by_the_path_of_the_key() {
    for (key, wanted) in [
        ("encoder_bits = 0", "effects.encoder_bits: got 0, wants bits in a turn"),
        ("encoder_bits = [16, 65]", "effects.encoder_bits[1]: got 65"),
        ("noise = -1.0", "effects.noise"),
        ("velocity = \"guessed\"", "effects.velocity: unknown variant `guessed`"),
        ("velocity = \"kalman\"", "effects.noise: got 0, wants noise or an encoder"),
        ("velocity = \"difference\"\nvelocity_cutoff = 0.0", "effects.velocity_cutoff: got 0"),
        ("delay = 9", "effects.delay: got 9, wants at most 4"),
        ("delay = 1.5", "effects.delay: invalid type"),
        ("jitter = 2.0", "effects.jitter: got 2"),
        ("drop = nan", "effects.drop: got NaN"),
        ("gain = 0.0", "effects.gain"),
        ("lag = -0.1", "effects.lag"),
        ("seed = -1", "effects.seed: invalid value"),
        ("encoder = 16", "effects.encoder: unknown field"),
    ] {
        let error = Scenario::from_toml(&format!("[effects]\n{key}")).unwrap_err().to_string();
        assert!(error.contains(wanted), "{key}: {error}");
    }
    let settings = EffectsSettings::default();
    assert!(!settings.build::<3>().unwrap().is_on());
}
