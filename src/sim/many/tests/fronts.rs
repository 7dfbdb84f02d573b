//! What stands before laws, and limits of the torques' rates.

use super::*;
use crate::control::FrontsAbreast;

/// What stands before a law, alone and all at once, and a limit of the torque's rate; also from the
/// middle of a course, and where a joint turns without an end.
#[test]
fn fronts_and_limits_of_rates_go_side_by_side() {
    let plants = core::array::from_fn(|i| pushed(two_link(5.0 + i as f64, Friction::default())));
    let (gains, integral) = Integral::with_bandwidth([8.0; 2]).unwrap();
    let law = ComputedTorque::new(two_link(4.0, Friction::default()), gains);
    let limits = |rate| Limits { effort_limit: [60.0; 2], effort_rate_limit: [rate; 2] };
    let off = Front::default();
    let all = Front {
        hand_over: Some(10.0),
        velocity_filter: Some(100.0),
        bumpless: Some(30.0),
        delay: 2,
    };
    let fronts = [
        Front { hand_over: all.hand_over, ..off },
        Front { velocity_filter: all.velocity_filter, ..off },
        Front { bumpless: all.bumpless, ..off },
        Front { delay: 4, ..off },
        off,
        all,
    ];
    for front in fronts {
        let controller = Controller::new(law, integral).with_front(front).unwrap();
        let controller = &controller.with_limits(limits(800.0)).unwrap();
        let new = State::new(DynamicState::new());
        let mut begun = new.clone();
        let (q, dq) = (Vector::<2>::new(0.3, 0.2), Vector::<2>::zeros());
        for _ in 0..3 {
            let desired = Setpoint::at_rest(Vector::<2>::repeat(0.1));
            controller.step(&mut begun, &q, &dq, &desired, 1e-3).unwrap();
        }
        for state in [&new, &begun] {
            for effects in [Effects::default(), noisy(0.0)] {
                let went = together(&plants, controller, state, (Some(1e-3), effects));
                assert_eq!(went, [true; LANES], "{front:?}");
            }
        }
        let mut settled = begun.clone();
        controller.settle(&mut settled);
        let others = Front { hand_over: all.hand_over.xor(front.hand_over), ..front };
        let others = &(*controller).with_front(others).unwrap();
        let mut each = [(controller, &settled); LANES];
        assert!(FrontsAbreast::of(each).is_some());
        each[3].0 = others;
        assert!(FrontsAbreast::of(each).is_none());
    }
}
