//! Joints that give: frequencies, energy, the rigid limit, play.

use steadyarm::arm::{Arm, JointFriction, TwoLink, TwoLinkParameters};
use steadyarm::math::{Matrix, Vector};
use steadyarm::plant::{Elastic, MotorState, Plant, Undisturbed};
use steadyarm::sim::{Motion, hold_torque};

use crate::random::Random;

/// A mass on a line, with friction.
#[derive(Clone)]
struct Mass {
    mass: f64,
    friction: JointFriction,
}

impl Arm<1> for Mass {
    fn mass_matrix(&self, _: &Vector<1>) -> Matrix<1> {
        Matrix::<1>::new(self.mass)
    }

    fn rigid_bias(&self, _: &Vector<1>, _: &Vector<1>) -> Vector<1> {
        Vector::<1>::zeros()
    }

    fn joint_friction(&self, _: usize) -> JointFriction {
        self.friction
    }
}

/// An arm with rotors that its joints carry along.
struct WithRotors<A>(A, [f64; 2]);

impl<A: Arm<2>> Arm<2> for WithRotors<A> {
    fn mass_matrix(&self, q: &Vector<2>) -> Matrix<2> {
        self.0.mass_matrix(q) + Matrix::<2>::from_diagonal(&self.1.into())
    }

    fn rigid_bias(&self, q: &Vector<2>, dq: &Vector<2>) -> Vector<2> {
        self.0.rigid_bias(q, dq)
    }
}

type Links<const N: usize> = (Vector<N>, Vector<N>);

/// One step of gears on this plant.
fn advance<const N: usize, A: Arm<N>>(
    gears: &Elastic<N>,
    plant: &Plant<N, A, Undisturbed>,
    links: Links<N>,
    motor: &mut MotorState<N>,
    tau: &Vector<N>,
    (t, h): (f64, f64),
) -> Links<N> {
    gears.advance(&plant.arm, links, motor, tau, (t, h), |(q, dq), torque, t, h| {
        let moved = hold_torque(plant, &Motion { q: *q, dq: *dq }, torque, t, h);
        (moved.q, moved.dq)
    })
}

fn mass(mass: f64) -> Plant<1, Mass> {
    Plant::new(Mass { mass, friction: JointFriction::default() }, Undisturbed)
}

fn two_link(gravity: f64) -> TwoLink {
    TwoLink::new(TwoLinkParameters { gravity, ..Default::default() }).unwrap()
}

const ONE: Vector<1> = Vector::<1>::new(1.0);

/// x = θ − q swings with ω² = K (1/B + 1/m), and the centre of mass moves on.
#[test]
fn two_masses_swing_with_their_frequency() {
    for (stiffness, rotor, m, h) in [
        (100.0, 0.5, 2.0, 1e-3),
        (1e4, 0.1, 3.0, 1e-3),
        (1e6, 0.02, 0.5, 1e-3),
        (50.0, 1.0, 1.0, 0.3),
    ] {
        let gears = Elastic::new([stiffness], [rotor]).unwrap();
        let plant = mass(m);
        let mut motor = MotorState { theta: ONE * 0.01, dtheta: ONE * 0.3 };
        let mut links = (Vector::zeros(), ONE * 0.3);
        let omega: f64 = (stiffness * (1.0 / rotor + 1.0 / m)).sqrt();
        let mut turned = 0.0;
        for k in 0..40 {
            let t = h * f64::from(k);
            links = advance(&gears, &plant, links, &mut motor, &Vector::zeros(), (t, h));
            turned += omega * h;
            let twist = motor.theta[0] - links.0[0];
            // The phase is off by (ω part)²/24 < 0.2 % for the implicit mean, to the worst.
            let off = 0.01 * (4e-3 * turned).min(2.0) + 1e-9;
            assert!((twist - 0.01 * turned.cos()).abs() < off, "{stiffness} {k}: {twist}");
            let centre = (rotor * motor.theta[0] + m * links.0[0]) / (rotor + m);
            let wanted = 0.01 * rotor / (rotor + m) + 0.3 * (t + h);
            assert!((centre - wanted).abs() < 1e-12);
        }
    }
}

/// T + U + ½Kφ² + ½Bθ̇² stays, and falls with damping, in every step and with any play.
#[test]
fn energy_stays_without_damping_and_never_grows_with_it() {
    let mut random = Random(4);
    for case in 0..24 {
        let damped = case % 2 == 1;
        let stiffness = [random.decades(1.0, 5.0), random.decades(1.0, 5.0)];
        let rotor = [random.decades(-2.0, 0.5), random.decades(-2.0, 0.5)];
        let backlash = if case % 3 == 0 { [0.0; 2] } else { [random.decades(-4.0, -1.0); 2] };
        let damping = if damped { [random.decades(-2.0, 2.0); 2] } else { [0.0; 2] };
        let gears = Elastic::new(stiffness, rotor).unwrap();
        let gears = gears.with_damping(damping).unwrap().with_backlash(backlash).unwrap();
        let plant = Plant::new(two_link(9.81), Undisturbed);
        let mut links = (Vector::<2>::new(0.4, -0.9), Vector::<2>::new(0.5, 1.0));
        let mut motor = gears.carrying(&links.0, &links.1, &Vector::<2>::new(5.0, -2.0));
        let total = |links: &Links<2>, motor: &MotorState<2>| {
            let (q, dq) = links;
            plant.arm.kinetic_energy(q, dq) + plant.arm.potential_energy(q) + gears.energy(q, motor)
        };
        let mut before = total(&links, &motor);
        let (first, mut lowest) = (before, before);
        for k in 0..300 {
            let at = (2e-3 * f64::from(k), 2e-3);
            links = advance(&gears, &plant, links, &mut motor, &Vector::zeros(), at);
            let now = total(&links, &motor);
            // RK4's own error: 1e-7 J a step of an arm of 60 J.
            assert!(now - before < 1e-6, "{case} {k}: {before} {now}");
            if !damped && backlash[0] == 0.0 {
                assert!((now - first).abs() < 1e-4, "{case} {k}: {first} {now}");
            }
            lowest = now.min(lowest);
            before = now;
        }
        assert!(!damped || lowest < first - 1e-5, "{case}: {first} {lowest}");
    }
}

/// As K grows, the arm moves as a rigid one with the rotors in its mass matrix: q is off by about
/// τ/K.
#[test]
fn stiff_gears_are_a_rigid_arm_with_its_rotors() {
    let rotor = [0.3, 0.1];
    let rigid = Plant::new(WithRotors(two_link(9.81), rotor), Undisturbed);
    let elastic = Plant::new(two_link(9.81), Undisturbed);
    let mut off = Vec::new();
    for stiffness in [1e4, 1e5, 1e6] {
        let gears = Elastic::new([stiffness; 2], rotor).unwrap();
        // ζ = ½ about.
        let gears = gears.with_damping([(stiffness * 0.1f64).sqrt(); 2]).unwrap();
        let mut links = (Vector::<2>::new(0.4, -0.9), Vector::<2>::zeros());
        let tau = |t: f64| Vector::<2>::new(40.0 + 10.0 * t, 12.0 - 8.0 * t);
        let mut motor = gears.carrying(&links.0, &links.1, &tau(0.0));
        let mut motion = Motion { q: links.0, dq: links.1 };
        let mut worst: f64 = 0.0;
        for k in 0..500 {
            let (t, h) = (1e-3 * f64::from(k), 1e-3);
            links = advance(&gears, &elastic, links, &mut motor, &tau(t), (t, h));
            motion = hold_torque(&rigid, &motion, &tau(t), t, h);
            worst = worst.max((links.0 - motion.q).amax());
        }
        off.push(worst);
    }
    assert!(off[0] < 0.02 && off[1] < 0.15 * off[0] && off[2] < 0.15 * off[1], "{off:?}");
}

/// The motor crosses the play alone, with θ̈ = τ/B, and the link does not move by one bit.
#[test]
fn in_the_play_the_link_is_left_alone() {
    let gears = Elastic::new([1000.0], [0.5]).unwrap().with_backlash([0.02]).unwrap();
    let plant = mass(2.0);
    let (q, still) = (ONE * 0.7, Vector::<1>::zeros());
    let mut motor = gears.carrying(&q, &still, &still);
    let (mut links, tau) = ((q, still), ONE * 2.0);
    assert_eq!(motor.theta, q);
    // 0.01 = ½ (τ/B) t²: contact after 70.7 ms.
    for k in 0..70 {
        links = advance(&gears, &plant, links, &mut motor, &tau, (1e-3 * f64::from(k), 1e-3));
        assert_eq!(links, (q, still), "{k}");
        let t = 1e-3 * f64::from(k + 1);
        assert!((motor.theta[0] - 0.7 - 2.0 * t * t).abs() < 1e-12);
    }
    for k in 70..90 {
        links = advance(&gears, &plant, links, &mut motor, &tau, (1e-3 * f64::from(k), 1e-3));
    }
    assert!(links.1[0] > 0.0);
    // In all, ∫τ dt = B θ̇ + m q̇.
    let momentum = 0.5 * motor.dtheta[0] + 2.0 * links.1[0];
    assert!((momentum - 2.0 * 0.09).abs() < 1e-12, "{momentum}");
}

/// A gear with play pushes; damping does not pull the link back when the motor leaves.
#[test]
fn a_gear_with_play_never_pulls() {
    let gears = Elastic::new([1e4], [0.1]).unwrap().with_backlash([0.01]).unwrap();
    let gears = gears.with_damping([30.0]).unwrap();
    let plant = mass(1.0);
    let still = Vector::<1>::zeros();
    let mut motor = gears.carrying(&still, &still, &(ONE * 5.0));
    let (mut links, mut fastest) = ((still, still), 0.0);
    for k in 0..20 {
        let at = (1e-3 * f64::from(k), 1e-3);
        links = advance(&gears, &plant, links, &mut motor, &(ONE * -20.0), at);
        if motor.theta[0] - links.0[0] <= -0.005 {
            return;
        }
        assert!(links.1[0] >= fastest, "{k}");
        fastest = links.1[0];
    }
    panic!("the motor crosses the play");
}

/// Dry friction holds the link to the bit under less than its torque, and the gear carries on.
#[test]
fn a_link_that_sticks_stays_where_it_is() {
    let friction = JointFriction {
        viscous: 0.5,
        coulomb: [10.0; 2],
        smoothing: 0.0,
        ..JointFriction::default()
    };
    let plant = Plant::new(Mass { mass: 2.0, friction }, Undisturbed);
    let gears = Elastic::new([1000.0], [0.05]).unwrap().with_damping([2.0]).unwrap();
    let (q, still) = (ONE * 0.3, Vector::<1>::zeros());
    let mut motor = gears.carrying(&q, &still, &still);
    let mut links = (q, still);
    for k in 0..2000 {
        links =
            advance(&gears, &plant, links, &mut motor, &(ONE * 4.0), (1e-3 * f64::from(k), 1e-3));
        assert_eq!(links, (q, still));
    }
    assert!((motor.theta[0] - 0.3 - 4.0 / 1000.0).abs() < 1e-9);
}

#[test]
fn gears_that_cannot_be_are_refused() {
    let words = |made: steadyarm::Result<Elastic<2>>| made.unwrap_err().to_string();
    let gears = Elastic::new([1e4; 2], [0.1; 2]).unwrap();
    for (got, wanted) in [
        (Elastic::new([1e4, 0.0], [0.1; 2]), "stiffness[1]: got 0, wants a number > 0"),
        (
            Elastic::new([1e4; 2], [f64::NAN, 0.1]),
            "rotor_inertia[0]: got NaN, wants a finite number",
        ),
        (gears.with_damping([-1.0, 0.0]), "damping[0]: got -1, wants a number >= 0"),
        (gears.with_backlash([0.0, -0.1]), "backlash[1]: got -0.1, wants a number >= 0"),
    ] {
        assert_eq!(words(got), wanted);
    }
}
