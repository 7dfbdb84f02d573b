//! A step allocates nothing, whatever it is given: a million of them under an allocator that
//! counts.

use crate::common::{self, Random, adaptive, everything, fresh, modified};
use crate::counting::calls_during;
use steadyarm::control::{Controller, Inputs, Limits, NoCompensation, State};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::reference::{Reference, Setpoint};
use steadyarm::sim::{ClosedLoop, Motion};

const STEPS: usize = 1_000_000;

/// Any sample: of an arm, of no arm, and no number at all.
fn sample(random: &mut Random) -> [Vector<2>; 5] {
    let size = [1.0, 5.0, 1e9][random.bits() as usize % 3];
    let mut sample = [(); 5].map(|()| random.vector(size));
    if random.bits().is_multiple_of(4) {
        let bad = [f64::NAN, f64::INFINITY, 1e11][random.bits() as usize % 3];
        sample[random.bits() as usize % 5][random.bits() as usize % 2] = bad;
    }
    sample
}

#[test]
fn the_allocator_counts() {
    assert!(calls_during(|| drop(std::hint::black_box(vec![0.0; 100]))) == 2);
}

#[test]
fn a_million_steps_allocate_nothing_errors_included() {
    let limits = Limits { effort_limit: [1e4; 2], effort_rate_limit: [1e6; 2] };
    let controllers = [
        adaptive(Form::Concat, true, 7.0),
        modified(Form::PerJoint { joints: 2 }, true, Inputs::state(), everything(7.0)),
        adaptive(Form::Shared, false, 7.0).with_limits(limits).unwrap(),
        adaptive(Form::Grid, true, 7.0),
    ];
    for (controller, share) in controllers.iter().zip([0.3, 0.3, 0.35, 0.05]) {
        let mut state = fresh(controller);
        let mut random = Random(8);
        let (mut accepted, mut refused, steps) = (0, 0, (share * STEPS as f64) as usize);
        let calls = calls_during(|| {
            for k in 0..steps {
                let [q, dq, q_d, dq_d, ddq_d] = sample(&mut random);
                let dt = [1e-3, 1e-3, 1e-3, 0.0][k % 4];
                let desired = Setpoint { q: q_d, dq: dq_d, ddq: ddq_d };
                match controller.step(&mut state, &q, &dq, &desired, dt) {
                    Ok(_) => accepted += 1,
                    Err(_) => refused += 1,
                }
            }
        });
        assert_eq!(calls, 0);
        assert!(accepted > steps / 3 && refused > steps / 3, "{accepted} {refused}");
    }
}

#[test]
fn plain_steps_and_the_continuous_loop_allocate_nothing() {
    let (plant, reference) = (common::plant(), common::reference());
    let plain = Controller::new(common::nominal_law(), NoCompensation);
    let adaptive = adaptive(Form::Concat, false, 7.0);
    let (mut memory, mut state) = (State::new(()), adaptive.compensator.state());
    let mut motion = Motion::<2>::zeros();
    let h = 1e-3;
    let calls = calls_during(|| {
        let mut system = ClosedLoop::new(&plant, &adaptive, &reference);
        for k in 0..20_000 {
            let (t, end) = (f64::from(k) * h, f64::from(k + 1) * h);
            let (q, dq) = (motion.q, motion.dq);
            plain.step(&mut memory, &q, &dq, &reference.at(t), h).unwrap();
            let start = system.start(&mut state, h, t, &motion);
            motion = system.finish(&mut state, (t, h, end), &motion, &start).unwrap().motion;
        }
    });
    assert_eq!(calls, 0);
}
