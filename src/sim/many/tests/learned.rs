//! The recommended controller.

use super::*;
use crate::arm::Parametric;
use crate::control::Inputs;
use crate::laws::{FeedForward, LearnedTorque, LearnedTorqueState, LearningGains, Learns, Pull};

/// Gains that are about right for these arms.
fn gains<const N: usize>(control_period: f64, delay: usize) -> LearningGains<N> {
    LearningGains {
        pull: Pull { bandwidth: [20.0; N], braking: [5.0; N] },
        cut_off: [60.0; N],
        learning: 20.0,
        acceleration_share: 0.9,
        unit: [10.0; N],
        control_period,
        delay,
        quickness: [f64::NAN; N],
        condition: f64::NAN,
    }
}

/// A motion in which no joint rests for long.
fn swing<const N: usize>(t: f64) -> Setpoint<N> {
    let (sin, cos) = (7.0 * t).sin_cos();
    let [q, dq, ddq] = [0.1 + 0.1 * sin, 0.7 * cos, -4.9 * sin].map(Vector::<N>::repeat);
    Setpoint { q, dq, ddq }
}

/// Whether anything is learnt there: else nothing would be compared.
fn learns_on<const N: usize, const K: usize, A: Parametric<N, K> + Clone>(
    plant: &Plant<N, A, Push<N>>,
    controller: &Controller<N, FeedForward<N, A>, LearnedTorque<N, K, A>>,
    mut state: State<N, LearnedTorqueState<N, Vec<f64>>>,
    (period, effects): (f64, Effects<N>),
) -> bool {
    let options = Options {
        duration: 0.25,
        control_period: Some(period),
        q0: [0.1; N],
        dq0: [0.05; N],
        effects,
        ..Options::default()
    };
    let go_on = |_| ControlFlow::Continue(());
    simulate(plant, controller, &mut state, &swing, &options, go_on).unwrap();
    let mut learnt = false;
    controller.compensator.describe(controller.settle(&mut state), &mut |name, numbers| {
        learnt |= name == "parameters" && numbers.iter().any(|number| *number != 0.0);
    });
    learnt
}

/// Runs with this arm in the place of what is believed go side by side, from their first sample.
fn goes<const N: usize, const K: usize, A: Parametric<N, K> + Clone>(
    plants: &[Plant<N, A, Push<N>>; LANES],
    believed: &A,
    learns: &Learns,
) {
    let weight = believed.burdened(1.5, 0.0).unwrap();
    for (period, delay, limit) in [(1e-3, 0, f64::INFINITY), (1e-3, 2, 150.0), (4e-3, 1, 130.0)] {
        let gains = gains(period, delay);
        let law = FeedForward::new(believed.clone(), weight.clone(), gains.pull).unwrap();
        let (arm, weight) = (believed.clone(), weight.clone());
        let learned = LearnedTorque::new(arm, weight, gains, [90.0; N], learns.clone()).unwrap();
        let state = State::new(learned.state());
        let limits = Limits { effort_limit: [limit; N], ..Limits::default() };
        let front =
            Front { velocity_filter: Some(150.0), hand_over: Some(8.0), bumpless: None, delay };
        let controller = Controller::new(law, learned).with_limits(limits).unwrap();
        let controller = &controller.with_front(front).unwrap();
        let beliefs = controller.law.beliefs().unwrap();
        let side = controller.compensator.learns(state.compensator()).unwrap();
        let side = side.as_own().unwrap();
        assert!((side.put)([beliefs; LANES], [side; LANES]).is_some());
        for effects in [Effects::default(), noisy(0.0)] {
            let went = together_along(&swing, plants, controller, &state, (Some(period), effects));
            assert_eq!(went, [true; LANES]);
            // Where the loop is not as late as it is told, it swings too much to learn.
            if effects.is_on() || delay == 0 {
                assert!(learns_on(&plants[3], controller, state.clone(), (period, effects)));
            }
        }
        // From the middle of a course they decide one after the other.
        let mut begun = state.clone();
        let (q, dq) = (Vector::<N>::repeat(0.2), Vector::<N>::zeros());
        let desired = Setpoint::at_rest(Vector::<N>::repeat(0.1));
        controller.step(&mut begun, &q, &dq, &desired, period).unwrap();
        assert!(controller.compensator.learns(controller.settle(&mut begun)).is_none());
        let way = (Some(period), Effects::default());
        let went = together_along(&swing, plants, controller, &begun, way);
        assert_eq!(went, [true; LANES]);
    }
}

#[test]
fn recommended_controllers_go_side_by_side() {
    let smooth = Friction { viscous: [0.4, 0.2], coulomb: [0.5, 0.1], smoothing: [0.2, 0.1] };
    let plants = core::array::from_fn(|i| pushed(two_link(5.0 + i as f64, smooth)));
    let axis = Axis { centers: &[-1.0, -0.5, 0.0, 0.5, 1.0], widths: &[0.6] };
    let basis = FuzzyBasis::new(Form::Concat, false, &[axis; 6]).unwrap();
    let residual = Some((basis, Inputs::trajectory()));
    let links = &Learns::default();
    goes(&plants, &two_link(4.0, Friction::default()), links);
    goes(&plants, &two_link(4.0, smooth), &Learns { residual, payload_only: false });
    let rubs =
        JointFriction { viscous: 0.5, coulomb: [0.3, 0.2], smoothing: 0.2, ..Default::default() };
    let plants = core::array::from_fn(|i| pushed(chain::<4>(0.2 * i as f64, rubs)));
    goes(&plants, &chain(0.5, rubs), links);
    let payload = Learns { payload_only: true, residual: None };
    goes(&plants, &chain(0.5, JointFriction::default()), &payload);
}
