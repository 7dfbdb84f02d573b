//! Friction that is stiff at the period of the step: right where RK4 is not, dry friction that
//! sticks, what is said where a step is too long.

use steadyarm::arm::{
    Arm, Friction, Inertia, JointFriction, JointKind, JointLimits, JointStop, Link, Pose, Serial,
    SerialParameters, TwoLink, TwoLinkParameters,
};
use steadyarm::control::{
    Adaptation, ComputedTorque, Controller, FuzzyCompensator, FuzzyParameters, Gains, Inputs,
    NoCompensation, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::math::Vector;
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::Quintic;
use steadyarm::sim::{
    Coarse, Method, Motion, Options, Run, Status, Tolerance, Window, hold_torque, metrics, simulate,
};

use crate::chains;
use crate::common::{self, adaptive, fresh, on};
use crate::random::Random;

/// One joint without gravity, of this inertia [kg m²].
fn joint(inertia: f64, friction: JointFriction) -> Serial<1> {
    let moments = nalgebra::Matrix3::identity() * inertia;
    let body = Inertia { mass: 0.2, com: nalgebra::Vector3::zeros(), moments };
    let link = Link::new(JointKind::Revolute, Pose::IDENTITY, nalgebra::Vector3::z(), body);
    let links = [Link { friction, ..link }];
    Serial::new(SerialParameters { links, tip: Pose::IDENTITY, gravity: [0.0; 3] }).unwrap()
}

fn smooth(viscous: f64, coulomb: f64) -> JointFriction {
    JointFriction { viscous, coulomb: [coulomb; 2], ..JointFriction::default() }
}

fn dry(viscous: f64, coulomb: f64) -> JointFriction {
    JointFriction { smoothing: 0.0, ..smooth(viscous, coulomb) }
}

/// A quarter of a second's worth of methods: continuous and sampled, fixed and error-controlled.
fn options(dt: f64, sampled: bool, method: Method) -> Options<1> {
    let control_period = sampled.then_some(1e-3);
    Options { duration: 4.0, dt, method, control_period, ..Options::default() }
}

const TIGHT: Method = Method::Dp54(Tolerance { rtol: 1e-8, atol: 1e-10 });

fn rms<const N: usize>(run: &Run<N>) -> f64 {
    let window = Window { from: 0.0, to: 1e3, band: 0.01 };
    metrics(0, &run.t, &run.e, &run.tau, window).unwrap().rms_e
}

/// 5e-4 kg m² with 0.6 N m of Coulomb friction, 0.3 N m s/rad: at 1 ms RK4 loses the friction and
/// turns the comparison round. RMS over 4 s from an independent program: ARS(4,4,3) with steps of 5
/// µs and RK4 with 1 µs, which agree to 4e-10 rad.
#[test]
fn a_comparison_on_a_light_stiff_wrist_is_not_turned_round() {
    let plant = Plant::new(joint(5e-4, smooth(0.3, 0.6)), Undisturbed);
    let nominal = plant.arm.without_friction();
    let gains = Gains::new([400.0], [40.0]).unwrap();
    let path = Quintic::new([0.0], [0.3], 0.0, 2.0).unwrap();
    let axes = [
        Axis { centers: &[-0.3, 0.0, 0.3, 0.6], widths: &[0.2] },
        Axis { centers: &[-0.6, -0.3, 0.0, 0.3, 0.6], widths: &[0.2] },
    ];
    let basis = FuzzyBasis::new(Form::PerJoint { joints: 1 }, true, &axes).unwrap();
    let parameters = FuzzyParameters {
        inputs: Inputs::reference(),
        q_position: [400.0],
        q_velocity: [40.0],
        adaptation: Adaptation { gain: [1e4], ..Adaptation::default() },
        ..FuzzyParameters::default()
    };
    let compensator = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
    for sampled in [false, true] {
        for (method, dt, tol) in [(Method::Rk4, 1e-3, 1e-4), (TIGHT, 1e-3, 1e-4)] {
            let options = options(dt, sampled, method);
            let plain = Controller::new(ComputedTorque::new(nominal, gains), NoCompensation);
            let run = simulate(&plant, &plain, &mut State::new(()), &path, &options, on).unwrap();
            assert_eq!(run.status, Status::Finished);
            assert!((rms(&run) / 248.829e-3 - 1.0).abs() < tol, "{sampled} {:e}", rms(&run));
            let adaptive =
                Controller::new(ComputedTorque::new(nominal, gains), compensator.clone());
            let mut state = State::new(adaptive.compensator.state());
            let run = simulate(&plant, &adaptive, &mut state, &path, &options, on).unwrap();
            assert!((rms(&run) / 243.222e-3 - 1.0).abs() < tol, "{sampled} {:e}", rms(&run));
        }
    }
}

/// v(t) = v₀ e^(−t b/I) for viscous friction alone, b/I = 1e5 /s: R(−100) is to be nearly 0, where
/// RK4 grows to 4e6.
#[test]
fn a_damped_joint_stops_in_one_step() {
    let plant = Plant::new(joint(1e-4, smooth(10.0, 0.0)), Undisturbed);
    let start = Motion { q: Vector::<1>::zeros(), dq: Vector::repeat(1.0) };
    let next = hold_torque(&plant, &start, &Vector::zeros(), 0.0, 1e-3);
    assert!(next.dq[0].abs() < 0.05, "{}", next.dq[0]);
}

/// From rest under a held force f: v = (1 − e^(−x)) f/b and q = (h f − m v)/b exactly, x = h b/m. A
/// loop whose torque cancels b q̇ adds up what a step leaves of that, so it is held to 0.5 % from
/// x = 0.01 to 1000: on a slide alone, where RK4 follows the parts of a step, and below another at
/// right angles to it, at rest in stiff friction.
#[test]
fn what_a_held_force_gives_a_damped_slide_is_right_however_much_it_is_damped() {
    let (h, mass, force) = (1e-3, 2.0, 3.0);
    let body = |mass| Inertia { mass, com: Default::default(), moments: Default::default() };
    let slide = |axis, mass, friction| {
        let link = Link::new(JointKind::Prismatic, Pose::IDENTITY, axis, body(mass));
        Link { friction, ..link }
    };
    let (x_axis, y_axis) = (nalgebra::Vector3::x(), nalgebra::Vector3::y());
    let tip = Pose::IDENTITY;
    for k in 0..=50 {
        let x = 0.01 * f64::powf(10.0, 0.1 * f64::from(k));
        let damped = smooth(x * mass / h, 0.0);
        let alone = [slide(x_axis, mass, damped)];
        let below = [slide(x_axis, 1.0, damped), slide(y_axis, 1.0, smooth(0.0, 50.0))];
        let alone = Serial::new(SerialParameters { links: alone, tip, gravity: [0.0; 3] }).unwrap();
        let below = Serial::new(SerialParameters { links: below, tip, gravity: [0.0; 3] }).unwrap();
        let speed = (1.0 - (-x).exp()) * force / damped.viscous;
        let travel = (force * h - mass * speed) / damped.viscous;
        for Motion { q, dq } in [first_of(alone, force, h), first_of(below, force, h)] {
            assert!((dq[0] / speed - 1.0).abs() < 5e-3, "x = {x}: {} {speed}", dq[0]);
            assert!((q[0] - travel).abs() < 0.04 * h * speed, "x = {x}: {} {travel}", q[0]);
        }
    }
}

/// The first joint a step after it was at rest.
fn first_of<const N: usize>(arm: Serial<N>, force: f64, h: f64) -> Motion<1> {
    let start = Motion { q: Vector::<N>::zeros(), dq: Vector::zeros() };
    let mut tau = Vector::<N>::zeros();
    tau[0] = force;
    let end = hold_torque(&Plant::new(arm, Undisturbed), &start, &tau, 0.0, h);
    Motion { q: Vector::<1>::repeat(end.q[0]), dq: Vector::repeat(end.dq[0]) }
}

#[test]
fn a_joint_with_dry_friction_stays_exactly_where_it_is_below_what_holds_it() {
    let friction = JointFriction { stribeck: 0.1, ..dry(0.2, 0.3) };
    let plant = Plant::new(joint(1e-3, friction), Undisturbed);
    let mut motion = Motion { q: Vector::<1>::repeat(0.7), dq: Vector::zeros() };
    for k in 0..10_000 {
        // Up to 0.39999 N m in both directions.
        let tau = Vector::<1>::repeat(if k % 2 == 0 { 1.0 } else { -1.0 } * 0.399_99);
        motion = hold_torque(&plant, &motion, &tau, 0.0, 1e-3);
        assert_eq!((motion.q[0], motion.dq[0]), (0.7, 0.0));
        assert_eq!(plant.acceleration(&motion.q, &motion.dq, &tau, 0.0)[0], 0.0);
    }
    // It breaks away above coulomb + stribeck.
    let next = hold_torque(&plant, &motion, &Vector::repeat(0.400_01), 0.0, 1e-3);
    assert!(next.dq[0] > 0.0);
    let ddq = plant.acceleration(&motion.q, &motion.dq, &Vector::repeat(-0.5), 0.0)[0];
    assert!((ddq + 0.1 / 1e-3).abs() < 1e-9, "{ddq}");
}

/// The tanh law creeps at s atanh(τ/c), 5.5 mrad/s at half the Coulomb torque: that is its truth.
#[test]
fn smooth_friction_creeps_at_its_own_speed() {
    let plant = Plant::new(joint(1e-4, smooth(0.0, 0.6)), Undisturbed);
    let mut motion = Motion { q: Vector::<1>::zeros(), dq: Vector::zeros() };
    for _ in 0..1000 {
        motion = hold_torque(&plant, &motion, &Vector::repeat(0.3), 0.0, 1e-3);
    }
    assert!((motion.dq[0] - 0.01 * 0.5_f64.atanh()).abs() < 1e-9, "{}", motion.dq[0]);
}

fn two_link(friction: Friction<2>) -> TwoLink {
    let inertia = [0.02, 1e-4];
    TwoLink::new(TwoLinkParameters {
        mass: [1.0, 0.05],
        length: [0.3, 0.1],
        inertia,
        gravity: 9.81,
        friction,
    })
    .unwrap()
}

fn fall(arm: TwoLink, dt: f64) -> Motion<2> {
    let plant = Plant::new(arm, Undisturbed);
    let mut motion = Motion { q: Vector::<2>::new(0.3, 0.4), dq: Vector::zeros() };
    for k in 0..(0.5 / dt).round() as usize {
        motion = hold_torque(&plant, &motion, &Vector::zeros(), k as f64 * dt, dt);
    }
    motion
}

/// A pendulum of two links, its friction 200 times too stiff for RK4 at 1 ms, against steps of 2
/// µs, which are not. Where a step is stiff the order of the method is not reached: the error falls
/// about as the step.
#[test]
fn the_error_of_a_stiff_step_is_small_and_falls_with_it() {
    let friction = Friction { viscous: [0.5, 20.0], coulomb: [0.02, 0.2], smoothing: [0.01; 2] };
    let truth = fall(two_link(friction), 2e-6);
    let error = |dt| (fall(two_link(friction), dt).q - truth.q).amax();
    let [coarse, fine, finer] = [error(1e-3), error(1e-4), error(2.5e-5)];
    assert!(coarse < 2e-5 && fine < 1e-5 && finer < fine / 2.0, "{coarse:e} {fine:e} {finer:e}");
}

/// Where friction is not stiff, and where there is none, the step is RK4's: errors fall by 16.
#[test]
fn a_smooth_arm_keeps_order_four() {
    for viscous in [0.0, 0.01] {
        let friction = Friction { viscous: [viscous; 2], ..Friction::default() };
        let truth = fall(two_link(friction), 1.25e-4);
        let error = |dt| (fall(two_link(friction), dt).q - truth.q).amax();
        let ratio = error(2e-3) / error(1e-3);
        assert!((13.0..19.0).contains(&ratio), "{ratio}");
    }
}

/// A controller that knows the friction cancels it: the loop is the one without, to the error of
/// RK4.
#[test]
fn friction_that_the_controller_knows_is_cancelled_in_continuous_time() {
    let gains = Gains::new([100.0], [20.0]).unwrap();
    let path = Quintic::new([0.0], [0.3], 0.0, 2.0).unwrap();
    let run = |friction, known, start: f64| {
        let plant = Plant::new(joint(1e-3, friction), Undisturbed);
        let controller =
            Controller::new(ComputedTorque::new(joint(1e-3, known), gains), NoCompensation);
        let options = Options { q0: [start], ..options(1e-3, false, Method::Rk4) };
        simulate(&plant, &controller, &mut State::new(()), &path, &options, on).unwrap()
    };
    let none = run(smooth(0.0, 0.0), smooth(0.0, 0.0), 0.1);
    for friction in [smooth(0.3, 0.6), smooth(5.0, 0.0), smooth(0.0, 2.0)] {
        let known = run(friction, friction, 0.1);
        for (a, b) in known.q.iter().zip(&none.q) {
            assert!((a[0] - b[0]).abs() < 1e-8, "{friction:?}: {} {}", a[0], b[0]);
        }
    }
    // Half of it known: the plant whose friction is the other half.
    let half = run(smooth(0.3, 0.6), smooth(0.15, 0.3), 0.1);
    let rest = run(smooth(0.15, 0.3), smooth(0.0, 0.0), 0.1);
    for (a, b) in half.q.iter().zip(&rest.q) {
        assert!((a[0] - b[0]).abs() < 1e-8, "{} {}", a[0], b[0]);
    }
}

/// E [J] of an arm.
fn energy<const N: usize>(arm: &Serial<N>, at: &Motion<N>) -> f64 {
    arm.kinetic_energy(&at.q, &at.dq) + arm.potential_energy(&at.q)
}

/// Ten seconds of undriven chains without gravity: through friction alone, energy never rises by
/// more than 1e-4 of its start.
fn friction_takes_energy<const N: usize>(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let mut random = Random(seed);
        let chain = chains::chain::<N>(&mut random);
        let mut parameters = *chain.parameters();
        parameters.gravity = [0.0; 3];
        for link in &mut parameters.links {
            link.friction = JointFriction {
                viscous: random.decades(-3.0, 1.0),
                coulomb: [random.decades(-3.0, 0.5), random.decades(-3.0, 0.5)],
                smoothing: if random.next() > 0.0 { 0.0 } else { 0.01 },
                ..JointFriction::default()
            };
        }
        let plant = Plant::new(Serial::new(parameters).unwrap(), Undisturbed);
        let dq = chains::vector(&mut random, 2.0);
        let mut motion = Motion { q: chains::vector(&mut random, 2.0), dq };
        let start = energy(&plant.arm, &motion);
        let mut lowest = start;
        for k in 0..10_000 {
            motion = hold_torque(&plant, &motion, &Vector::zeros(), k as f64 * 1e-3, 1e-3);
            let now = energy(&plant.arm, &motion);
            assert!(now <= lowest + 1e-4 * start, "chain {seed}, step {k}: {now} {lowest} {start}");
            lowest = lowest.min(now);
        }
    }
}

#[test]
fn friction_never_gives_energy() {
    friction_takes_energy::<1>(0..5);
    friction_takes_energy::<2>(100..110);
    friction_takes_energy::<7>(200..210);
}

/// Every joint is either held within what its friction can hold, or slips against all of it: the
/// box problem of the acceleration, substituted back.
#[test]
fn accelerations_at_rest_satisfy_what_friction_may_be() {
    for seed in 0..300 {
        let mut random = Random(seed);
        let mut parameters = *chains::chain::<7>(&mut random).parameters();
        for link in &mut parameters.links {
            let coulomb = [random.decades(-2.0, 2.0), random.decades(-2.0, 2.0)];
            link.friction = JointFriction { coulomb, smoothing: 0.0, ..JointFriction::default() };
        }
        let arm = Serial::new(parameters).unwrap();
        let q = chains::vector::<7>(&mut random, 2.0);
        let tau = chains::vector::<7>(&mut random, 30.0);
        let rest = Vector::zeros();
        let ddq = arm.forward_dynamics(&q, &rest, &tau);
        let lambda = tau - arm.gravity(&q) - arm.mass_matrix(&q) * ddq;
        for n in 0..7 {
            let [up, down] = arm.links()[n].friction.coulomb;
            let off = 1e-9 * tau.amax().max(up.max(down));
            let fits = match ddq[n] {
                0.0 => lambda[n] <= up + off && lambda[n] >= -down - off,
                a if a > 0.0 => (lambda[n] - up).abs() < off,
                _ => (lambda[n] + down).abs() < off,
            };
            assert!(fits, "chain {seed}, joint {n}: {} {} {up} {down}", ddq[n], lambda[n]);
        }
    }
}

/// A joint pressed against its stop rests where the spring holds it, at any stiffness.
#[test]
fn a_stop_too_stiff_for_the_step_holds_the_joint_and_is_told() {
    let path = Quintic::new([0.0], [0.0], 0.0, 1.0).unwrap();
    let gains = Gains::new([1.0], [1.0]).unwrap();
    for (stiffness, told) in [(1e2, false), (1e3, false), (1e5, true)] {
        let limits = JointLimits { lower: -1.0, upper: 0.1, ..JointLimits::NONE };
        let mut parameters = *joint(1e-3, JointFriction::default()).parameters();
        parameters.links[0].limits = limits;
        let arm = Serial::new(parameters).unwrap();
        let stop = JointStop { stiffness, dissipation: 0.5 };
        let plant = Plant::new(arm.with_stops(&[stop]).unwrap(), |_: &_, _: &_, _: f64| {
            Vector::<1>::repeat(-3.0)
        });
        let controller = Controller::new(
            ComputedTorque::new(joint(1e-3, JointFriction::default()), gains),
            NoCompensation,
        );
        let options = options(1e-3, true, Method::Rk4);
        let run = simulate(&plant, &controller, &mut State::new(()), &path, &options, on).unwrap();
        let rest = 0.1 + 3.0 / stiffness;
        let end = run.q.last().unwrap()[0];
        assert!((end - rest).abs() < 0.02 * (rest - 0.1) + 1e-6, "{stiffness}: {end} {rest}");
        let bounced =
            matches!(run.status, Status::Unresolved(doubt) if doubt.coarse == Coarse::Bounce);
        assert_eq!(bounced, told, "{stiffness}: {}", run.status);
    }
}

/// `steadyarm simulate --dt 1` used to finish with 0.273 / 0.483 rad where 0.193 / 0.448 is right.
#[test]
fn a_step_too_long_for_the_motion_is_told_and_named() {
    let run = |dt, gain| {
        let controller = adaptive(Form::Shared, true, gain);
        let (plant, path, mut state) = (common::plant(), common::reference(), fresh(&controller));
        let options = Options { dt, ..Options::default() };
        simulate(&plant, &controller, &mut state, &path, &options, on).unwrap()
    };
    let told = run(1.0, 1.0 / 7.0).status;
    let Status::Unresolved(doubt) = told else { panic!("{told}") };
    assert!(matches!(doubt.coarse, Coarse::Motion { .. }), "{told}");
    assert!(told.to_string().contains("dt = 1 s is too long for this motion"), "{told}");
    assert_eq!(run(1e-3, 1.0 / 7.0).status, Status::Finished);
    assert_eq!(run(1e-2, 1.0 / 7.0).status, Status::Finished);
    // Beyond its stability limit RK4 diverges, which is no fault of the controller.
    let told = run(2.0, 7.0).status;
    assert!(matches!(told, Status::Diverged { doubt: Some(_), .. }), "{told}");
    assert!(told.to_string().contains("before that, dt = 2 s is too long"), "{told}");
}

/// What friction does at the stages of a step enters the identity with the weights of the implicit
/// method.
#[test]
fn the_dissipation_identity_holds_through_stiff_friction() {
    let friction = Friction { viscous: [0.5, 0.2], coulomb: [1.0, 0.5], smoothing: [0.001; 2] };
    let mut parameters = *common::plant().arm.parameters();
    parameters.friction = friction;
    let plant = Plant::new(TwoLink::new(parameters).unwrap(), common::plant().disturbance);
    let controller = adaptive(Form::Concat, false, 70.0);
    let residual = |dt| {
        let options = Options { dt, duration: 5.0, ..Options::default() };
        let mut state = fresh(&controller);
        let path = common::reference();
        let run = simulate(&plant, &controller, &mut state, &path, &options, on).unwrap();
        run.certificate.unwrap().residual()
    };
    let [coarse, fine] = [residual(1e-3), residual(1.25e-4)];
    assert!(coarse < 1e-5 && fine < coarse / 8.0, "{coarse:e} {fine:e}");
}

/// b q + I v = ∫τ dt for viscous friction alone: q(h) = τ/b (h − T(1 − e^(−h/T))), T = I/b, from
/// rest.
#[test]
fn a_damped_joint_goes_as_far_as_its_impulse_says() {
    let plant = Plant::new(joint(1e-4, smooth(1.0, 0.0)), Undisturbed);
    let start = Motion { q: Vector::<1>::zeros(), dq: Vector::zeros() };
    let next = hold_torque(&plant, &start, &Vector::repeat(0.5), 0.0, 1e-3);
    let impulse = 1.0 * next.q[0] + 1e-4 * next.dq[0];
    assert!((impulse / 0.5e-3 - 1.0).abs() < 1e-6, "{impulse:e}");
    let exact = 0.5 * (1e-3 - 1e-4 * (1.0 - (-10.0_f64).exp()));
    assert!((next.q[0] / exact - 1.0).abs() < 0.01, "{:e} {exact:e}", next.q[0]);
}

/// Stribeck's friction falls once the joint moves: 5 % above what holds it, it must run away with
/// at least (τ − hold)/I.
#[test]
fn a_joint_that_breaks_away_from_stribecks_friction_does_not_creep() {
    for (inertia, smoothing) in [(0.017, 0.0), (0.017, 0.01), (1e-3, 0.0), (0.1, 0.0)] {
        let friction = JointFriction { stribeck: 2.5, smoothing, ..dry(0.0, 5.0) };
        let plant = Plant::new(joint(inertia, friction), Undisturbed);
        for dt in [1e-3, 1e-4] {
            let mut motion = Motion { q: Vector::<1>::zeros(), dq: Vector::zeros() };
            for _ in 0..(0.05 / dt) as usize {
                let before = motion.dq[0];
                motion = hold_torque(&plant, &motion, &Vector::repeat(7.875), 0.0, dt);
                let least = 0.375 / inertia * dt * (1.0 - 1e-6);
                assert!(motion.dq[0] >= before + least, "{inertia} {dt}: {}", motion.dq[0]);
            }
            // Steps of 10 µs: 0.197 rad.
            let far = (motion.q[0] - 0.197).abs() < 0.005;
            assert!(inertia != 0.017 || smoothing > 0.0 || far, "{dt}: {}", motion.q[0]);
        }
    }
}

/// What a controller adds that is no part of the plant's friction (larger, or with another
/// smoothing) stays explicit: it is told where that is stiff, and right where it is not.
#[test]
fn friction_that_is_no_part_of_the_plants_is_told_where_it_is_stiff() {
    let gains = Gains::new([100.0], [20.0]).unwrap();
    let path = Quintic::new([0.0], [0.3], 0.0, 2.0).unwrap();
    let status = |inertia, friction, known| {
        let plant = Plant::new(joint(inertia, friction), Undisturbed);
        let controller =
            Controller::new(ComputedTorque::new(joint(inertia, known), gains), NoCompensation);
        let options = options(1e-3, false, Method::Rk4);
        let mut state = State::new(());
        simulate(&plant, &controller, &mut state, &path, &options, on).unwrap().status
    };
    let wide = |coulomb| JointFriction { smoothing: 0.05, ..smooth(0.0, coulomb) };
    for known in [wide(0.5), smooth(0.0, 0.66), dry(0.0, 0.6)] {
        let told = status(1e-4, smooth(0.0, 0.6), known);
        let Status::Unresolved(doubt) = told else { panic!("{told}") };
        assert_eq!(doubt.coarse, Coarse::Uncovered);
    }
    assert_eq!(status(0.1, dry(0.0, 0.1), wide(0.05)), Status::Finished);
    assert_eq!(status(1e-4, smooth(0.0, 0.6), smooth(0.0, 0.5)), Status::Finished);
}
