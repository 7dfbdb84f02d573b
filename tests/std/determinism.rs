//! The same bits on every machine, with every instruction set, in every build: hashes of final
//! states.

use crate::common::{self, Adaptive, adaptive, everything, fresh, hash, learnt, modified, on};
use steadyarm::arm::{
    Arm, Inertia, JointFriction, JointKind, Link, Pose, Serial, SerialParameters,
};
use steadyarm::control::{ComputedTorque, Controller, DynamicState, Front, Inputs, Limits, State};
use steadyarm::effects::{Actuators, Effects, Sensors, Side, Timing, Transmission, Velocity};
use steadyarm::fuzzy::Form;
use steadyarm::laws::{Circumstances, FeedForward, LearnedTorque, Learns, MomentumObserver, Rule};
use steadyarm::math::{Vector, sin_cos};
use steadyarm::paper;
use steadyarm::plant::{Elastic, Plant};
use steadyarm::reference::Setpoint;
use steadyarm::sim::{Method, Options, Status, Tolerance, simulate};

/// FNV-1a of q, dq, W, V and tau at the end. They change with every change of the arithmetic, and
/// with nothing else: when that is meant, copy them from the message of the failing test.
const CONTINUOUS: u64 = 0x1802_cf8f_085f_b7af;
const SAMPLED: u64 = 0xb7b3_12b5_986e_5759;
const ERROR_CONTROLLED: u64 = 0x8e5b_6893_7854_f167;
const SERIAL: u64 = 0x57fd_cf5b_1b13_ebdf;
const RECOMMENDED: u64 = 0x6d04_52e3_f35f_3925;
const AFFECTED: u64 = 0xd464_5217_0c58_7d2c;

fn final_hash(controller: &Adaptive, options: &Options<2>) -> u64 {
    let mut state = fresh(controller);
    let (plant, reference) = (common::plant(), common::reference());
    let run = simulate(&plant, controller, &mut state, &reference, options, on).unwrap();
    assert_eq!(run.status, Status::Finished);
    let last = run.t.len() - 1;
    let motion = run.q[last].into_iter().chain(run.dq[last]).chain(run.tau[last]);
    hash(motion.chain([run.v[last]]).chain(learnt(controller, &state)))
}

/// The run of the comparison with other stacks, its first 5 s.
fn peers() -> (Adaptive, Options<2>) {
    let options = Options { duration: 5.0, q0: [0.5, -0.5], ..Options::default() };
    (adaptive(Form::Grid, true, 7000.0), options)
}

fn assert_golden(name: &str, found: u64, golden: u64) {
    assert!(found == golden, "{name}: {found:#018x}, golden {golden:#018x}");
}

#[test]
fn continuous_run_ends_in_its_golden_bits() {
    let (controller, options) = peers();
    assert_golden("CONTINUOUS", final_hash(&controller, &options), CONTINUOUS);
}

#[test]
fn sampled_run_with_everything_switched_on_ends_in_its_golden_bits() {
    let limits = Limits { effort_limit: [12.0; 2], effort_rate_limit: [800.0; 2] };
    let form = Form::PerJoint { joints: 2 };
    let controller = modified(form, false, Inputs::trajectory(), everything(70.0));
    let controller = controller.with_limits(limits).unwrap();
    let options = Options { duration: 5.0, control_period: Some(2e-3), ..Options::default() };
    assert_golden("SAMPLED", final_hash(&controller, &options), SAMPLED);
}

#[test]
fn error_controlled_run_ends_in_its_golden_bits() {
    let method = Method::Dp54(Tolerance { rtol: 1e-8, atol: 1e-10 });
    let (controller, options) = peers();
    let found = final_hash(&controller, &Options { method, ..options });
    assert_golden("ERROR_CONTROLLED", found, ERROR_CONTROLLED);
}

/// Seven joints, one of them sliding, with friction and rotors.
fn serial() -> Serial<7> {
    let links = core::array::from_fn(|n| {
        let x = 0.1 * (n + 1) as f64;
        let kind = if n == 4 { JointKind::Prismatic } else { JointKind::Revolute };
        let turn = nalgebra::Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
        let placement = Pose { rotation: turn, translation: nalgebra::Vector3::new(x, 0.2, -x) };
        let moments = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(0.3, 0.2, 0.25));
        let inertia = Inertia { mass: 4.0 - 5.0 * x / 2.0, com: [0.1, x, 0.05].into(), moments };
        let friction = JointFriction { viscous: x, coulomb: [0.3, 0.2], ..Default::default() };
        let link = Link::new(kind, placement, [0.0, 0.6, 0.8].into(), inertia);
        Link { friction, armature: x, ..link }
    });
    Serial::new(SerialParameters { links, tip: Pose::IDENTITY, gravity: [0.0, 0.3, -9.81] })
        .unwrap()
}

#[test]
fn dynamics_of_a_serial_arm_have_their_golden_bits() {
    let arm = serial();
    let (mut q, mut dq) = (Vector::<7>::repeat(0.3), Vector::<7>::repeat(-0.4));
    for k in 0..1000 {
        let tau = Vector::<7>::from_fn(|n, _| 5.0 - (k % 11) as f64 - n as f64) - dq * 3.0;
        dq += arm.forward_dynamics(&q, &dq, &tau) * 1e-3;
        q += dq * 1e-3;
    }
    let (mass, bias) = arm.mass_matrix_and_bias(&q, &dq);
    let values = q.iter().chain(&dq).chain(&mass).chain(&bias).copied();
    let torque = arm.inverse_dynamics(&q, &dq, &bias);
    let found =
        hash(values.chain(torque.iter().copied()).chain(arm.coriolis(&q, &dq).iter().copied()));
    assert!(q.iter().chain(&dq).all(|x| x.is_finite()));
    assert_golden("SERIAL", found, SERIAL);
}

/// Every effect at once, random ones included, around a rival with all that can stand before it.
#[test]
fn run_through_every_effect_ends_in_its_golden_bits() {
    let effects = Effects {
        sensors: Sensors {
            encoder: [1e-4; 2],
            noise: [1e-4, 2e-4],
            velocity: Velocity::Kalman(20.0),
        },
        timing: Timing { delay: 1, jitter: 0.3, drop: 0.02 },
        actuators: Actuators {
            effort_rate_limit: [2e4; 2],
            gain: [0.95, 1.05],
            lag: [1e-3, 2e-3],
            cogging: [0.1; 2],
            ..Actuators::default()
        },
        transmission: Some(Transmission {
            gears: Elastic::new([5e3; 2], [0.05; 2])
                .and_then(|gears| gears.with_damping([3.0; 2]))
                .and_then(|gears| gears.with_backlash([1e-4; 2]))
                .unwrap(),
            encoders: Side::Motor,
        }),
        seed: 3,
    };
    let front =
        Front { hand_over: Some(2.0), velocity_filter: Some(60.0), bumpless: Some(4.0), delay: 1 };
    let (nominal, actual) = (paper::nominal().unwrap(), paper::actual().unwrap());
    let observer = MomentumObserver::new(nominal, 20.0).unwrap();
    let law = ComputedTorque::new(nominal, paper::gains().unwrap());
    let controller = Controller::new(law, observer).with_front(front).unwrap();
    let plant = Plant::new(nominal, paper::disturbance().unwrap());
    let plant = plant.with_effort_limit([11.0; 2]).unwrap().with_change(2.0, actual).unwrap();
    let options =
        Options { duration: 5.0, control_period: Some(1e-3), effects, ..Options::default() };
    let (reference, mut state) = (paper::reference().unwrap(), State::new(DynamicState::new()));
    let run = simulate(&plant, &controller, &mut state, &reference, &options, on).unwrap();
    assert_eq!(run.status, Status::Finished);
    let last = run.t.len() - 1;
    let own = run.own.iter().flat_map(|column| column.values.last().copied());
    let motion = run.q[last].into_iter().chain(run.dq[last]).chain(run.tau[last]);
    assert_golden("AFFECTED", hash(motion.chain(own)), AFFECTED);
}

/// The rule of the recommended controller, and 3000 steps of it: friction, a limit, rests.
#[test]
fn recommended_controller_ends_in_its_golden_bits() {
    let arm = serial();
    let known = Circumstances {
        control_period: 1e-3,
        delay: 1,
        noise: [2.8e-5; 7],
        velocity_filter: 100.0,
        effort_limit: [60.0; 7],
        payload: 1.0,
        inertia_range: [0.8, 1.5],
        light_joints: true,
        range: None,
    };
    let Rule { gains, weight, .. } = Rule::new(&arm, &known).unwrap();
    let law = FeedForward::new(arm, weight, gains.pull).unwrap();
    let learned =
        LearnedTorque::new(arm, weight, gains, known.effort_limit, Learns::default()).unwrap();
    let front =
        Front { hand_over: Some(3.0), velocity_filter: Some(100.0), bumpless: None, delay: 1 };
    let limits = Limits { effort_limit: known.effort_limit, ..Limits::default() };
    let it = Controller::new(law, learned).with_front(front).unwrap().with_limits(limits).unwrap();
    let mut state = State::new(it.compensator.state());
    let mut torques = Vec::new();
    for k in 0..3000 {
        let t = f64::from(k) * 1e-3;
        let wave = |n: usize, shift: f64| sin_cos(t * (1.0 + 0.1 * n as f64) + n as f64 + shift).0;
        let desired = Setpoint {
            q: Vector::<7>::from_fn(|n, _| 0.4 * wave(n, 0.0)),
            dq: Vector::<7>::from_fn(|n, _| 0.4 * wave(n, 1.5)),
            ddq: Vector::<7>::from_fn(|n, _| -0.4 * wave(n, 0.0)),
        };
        let q = desired.q + Vector::<7>::from_fn(|n, _| 0.01 * wave(n, 2.0));
        let tau = it.step(&mut state, &q, &desired.dq, &desired, 1e-3).unwrap().tau;
        torques.extend_from_slice(tau.as_slice());
    }
    assert_golden("RECOMMENDED", hash(torques), RECOMMENDED);
}

#[test]
fn runs_in_four_threads_have_the_same_bits() {
    let hashes: Vec<u64> = std::thread::scope(|scope| {
        let threads = [(); 4].map(|()| {
            scope.spawn(|| {
                let (controller, options) = peers();
                final_hash(&controller, &Options { duration: 0.5, ..options })
            })
        });
        threads.map(|thread| thread.join().unwrap()).to_vec()
    });
    assert!(hashes.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn one_configuration_drives_many_states_without_mixing_them() {
    let (controller, options) = peers();
    let options = Options { duration: 0.5, ..options };
    let first = final_hash(&controller, &options);
    final_hash(&controller, &Options { q0: [1.0, 1.0], ..options });
    assert_eq!(final_hash(&controller, &options), first);
}
