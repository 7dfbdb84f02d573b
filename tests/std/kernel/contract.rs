//! Seven joints on a grid of 6.1 billion rules, and the contract of a step: finite, refusals
//! without a trace, no allocation; and what a constructor refuses.

use steadyarm::control::{
    Adaptation, FuzzyParameters, Gains, Inputs, KernelCompensator, KernelParameters, KernelState,
    State,
};
use steadyarm::fuzzy::{Axis, KernelBasis, MAX_INPUTS, MAX_SETS};
use steadyarm::math::Vector;
use steadyarm::reference::Setpoint;
use steadyarm::{Error, Problem};

use super::scene::{self, Memory, PAPER_AXIS, fresh, joints};
use crate::common::{Random, bits};
use crate::counting::calls_during;

const SMALL: KernelParameters = KernelParameters { capacity: 24, merge_tolerance: 0.3 };

fn leaking<const N: usize>() -> Adaptation<N> {
    Adaptation { gain: [50.0; N], leak_rate: 0.2, ..Adaptation::default() }
}

fn vector<const N: usize>(random: &mut Random, size: f64) -> Vector<N> {
    Vector::from_fn(|_, _| random.within(-size, size))
}

fn sample(random: &mut Random, size: f64) -> (Vector<7>, Vector<7>, Setpoint<7>) {
    let desired =
        Setpoint { q: vector(random, 1.0), dq: vector(random, 1.0), ddq: vector(random, 1.0) };
    // Positions are at most 1e5.
    (
        desired.q + vector::<7>(random, size.min(9e4)),
        desired.dq + vector::<7>(random, size),
        desired,
    )
}

/// All of a state that later steps depend on.
fn snapshot(
    controller: &KernelCompensator<7>,
    state: &KernelState<7, Vec<f64>>,
) -> (usize, [u64; 2], Vec<u64>) {
    let mut memberships = vec![0.0; controller.basis().sets()];
    let mut numbers = vec![state.weights_norm()];
    numbers.extend(state.error_bound().iter());
    for atom in 0..state.atoms() {
        let c = controller.read_atom(state, atom, &mut memberships).unwrap().unwrap();
        numbers.extend(c.iter().chain(&memberships));
    }
    (state.atoms(), [state.merged(), state.dropped()], bits(&numbers))
}

fn out_of_range(error: Error) -> bool {
    matches!(error.problem(), Problem::OutOfRange { .. })
}

#[test]
fn seven_joints_step_on_six_billion_rules() {
    let kernel = KernelParameters { capacity: 256, merge_tolerance: 0.3 };
    for normalized in [true, false] {
        let controller = joints::<7>(normalized, leaking(), kernel);
        let basis = controller.compensator.basis();
        assert_eq!((basis.inputs(), basis.sets(), basis.rules()), (14, 70, 5f64.powi(14)));
        let mut state = fresh(&controller);
        let mut random = Random(1);
        let mut largest = 0.0_f64;
        for k in 0..20_000 {
            let size = [0.1, 1.0, 100.0, 1e9][k % 4];
            let (q, dq, desired) = sample(&mut random, size);
            let command = controller.step(&mut state, &q, &dq, &desired, 1e-3).unwrap();
            assert!(command.tau.iter().chain(&command.rho_hat).all(|x| x.is_finite()));
            largest = largest.max(command.rho_hat.amax());
        }
        let memory = controller.settle(&mut state);
        assert!(largest > 1e-3 && memory.weights_norm().is_finite());
        assert!(memory.error_bound().iter().all(|x| x.is_finite()));
        assert_eq!(memory.atoms(), 256);
        assert!(memory.dropped() > 1000);
    }
}

#[test]
fn a_refused_sample_changes_nothing() {
    let controller = joints::<7>(true, leaking(), SMALL);
    let mut state = fresh(&controller);
    let mut random = Random(2);
    let mut refused = 0;
    for k in 0..3000 {
        let before = snapshot(&controller.compensator, state.compensator());
        let (mut q, mut dq, mut desired) = sample(&mut random, 1.0);
        let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e11][k % 4];
        let (n, mut dt) = (k % 7, 1e-3);
        match k % 6 {
            0 => q[n] = bad,
            1 => dq[n] = bad,
            2 => desired.q[n] = bad,
            3 => desired.dq[n] = bad,
            4 => desired.ddq[n] = bad,
            _ => dt = [0.0, -1.0, f64::NAN, 1e3][k % 4],
        }
        assert!(controller.step(&mut state, &q, &dq, &desired, dt).is_err());
        refused += 1;
        assert_eq!(before, snapshot(&controller.compensator, state.compensator()));
        // Every sample twice: the second of them is merged.
        let (q, dq, desired) = sample(&mut Random(k as u64 / 2), 1.0);
        controller.step(&mut state, &q, &dq, &desired, 1e-3).unwrap();
    }
    assert_eq!((refused, state.steps), (3000, 3000));
    let own = controller.settle(&mut state);
    assert!(own.merged() > 0 && own.dropped() > 0);
}

#[test]
fn weights_that_would_be_too_large_are_refused_and_change_nothing() {
    let huge = Adaptation { gain: [1e150; 7], ..Adaptation::default() };
    let controller = joints::<7>(true, huge, SMALL);
    let mut state = fresh(&controller);
    let (q, dq, desired) = sample(&mut Random(3), 1e4);
    let before = snapshot(&controller.compensator, state.compensator());
    let error = controller.step(&mut state, &q, &dq, &desired, 1.0).unwrap_err();
    assert!(error.parameter() == "weights" && out_of_range(error), "{error}");
    assert_eq!(before, snapshot(&controller.compensator, state.compensator()));
}

#[test]
fn a_hundred_thousand_steps_allocate_nothing() {
    assert_eq!(calls_during(|| drop(std::hint::black_box(vec![0.0; 100]))), 2);
    let everything = Adaptation {
        error_modification: 0.01,
        projection_radius: 2.0,
        dead_zone: 1e-3,
        normalization: 0.1,
        ..leaking()
    };
    let controller = joints::<7>(true, everything, SMALL);
    let mut state = fresh(&controller);
    let mut refused = 0;
    let calls = calls_during(|| {
        for k in 0..100_000 {
            let size = [0.1, 1.0, 1.0, 1e9][k / 2 % 4];
            let (mut q, dq, desired) = sample(&mut Random(k as u64 / 2), size);
            q[k % 7] *= if k % 10 == 0 { f64::NAN } else { 1.0 };
            let result = controller.step(&mut state, &q, &dq, &desired, 1e-3);
            refused += usize::from(result.is_err());
        }
    });
    assert_eq!((calls, refused), (0, 10_000));
    let memory = controller.settle(&mut state);
    assert!(memory.merged() > 100 && memory.dropped() > 100);
}

#[test]
fn any_buffer_long_enough_gives_the_same_torques() {
    let controller = joints::<7>(true, leaking(), SMALL);
    let wanted = controller.compensator.buffer_len();
    let mut memory = vec![f64::NAN; wanted + 3];
    let short = controller.compensator.state_in(&mut memory[..wanted - 1]).unwrap_err();
    assert_eq!(short, Error::wrong_length("buffer", wanted - 1, wanted));
    for shift in 0..3 {
        let (mut left, mut random) = (fresh(&controller), Random(6));
        let place = &mut memory[shift..];
        let mut right = State::new(controller.compensator.state_in(place).unwrap());
        for _ in 0..500 {
            let (q, dq, desired) = sample(&mut random, 0.5);
            let a = controller.step(&mut left, &q, &dq, &desired, 1e-3).unwrap();
            let b = controller.step(&mut right, &q, &dq, &desired, 1e-3).unwrap();
            assert_eq!(bits(a.tau.as_slice()), bits(b.tau.as_slice()));
        }
    }
}

#[test]
fn an_atom_is_read_where_there_is_one() {
    let controller = joints::<7>(true, leaking(), SMALL);
    let mut state: Memory<7> = fresh(&controller);
    let (q, dq, desired) = sample(&mut Random(7), 0.5);
    controller.step(&mut state, &q, &dq, &desired, 1e-3).unwrap();
    let (compensator, state) = (&controller.compensator, &*controller.settle(&mut state));
    let mut memberships = [0.0; 70];
    assert!(compensator.read_atom(state, 0, &mut memberships).unwrap().is_some());
    let sums = memberships.chunks_exact(5).map(|p| p.iter().sum::<f64>());
    assert!(sums.into_iter().all(|sum| (sum - 1.0).abs() < 1e-15));
    assert_eq!(compensator.read_atom(state, 1, &mut memberships), Ok(None));
    let refused = compensator.read_atom(state, 0, &mut memberships[..69]);
    assert_eq!(refused, Err(Error::wrong_length("memberships", 69, 70)));
}

fn build(
    basis: KernelBasis,
    parameters: FuzzyParameters<2>,
    kernel: KernelParameters,
) -> Result<KernelCompensator<2>, Error> {
    KernelCompensator::new(basis, &Gains::new([8.0; 2], [5.5; 2]).unwrap(), parameters, kernel)
}

fn grid() -> KernelBasis {
    KernelBasis::new(true, &[PAPER_AXIS; 4]).unwrap()
}

#[test]
fn every_parameter_is_refused_by_name() {
    let (good, default) = (scene::parameters(leaking()), KernelParameters::default());
    assert!(build(grid(), good, default).is_ok());
    let of = |kernel| build(grid(), good, kernel).unwrap_err();
    let capacity = |capacity| of(KernelParameters { capacity, ..default });
    let wanted = Error::wrong_length("capacity", 0, 1);
    assert_eq!(capacity(0), wanted);
    let wanted = Error::too_many("capacity", Some(4097), 4096);
    assert_eq!(capacity(4097), wanted);
    let wanted = Error::too_many("capacity", Some(usize::MAX), 4096);
    assert_eq!(capacity(usize::MAX), wanted);
    let tolerance = |merge_tolerance| of(KernelParameters { merge_tolerance, ..default });
    for bad in [-1e-3, 1.0, 2.0] {
        let error = tolerance(bad);
        assert!(error.parameter() == "merge_tolerance" && out_of_range(error), "{error}");
    }
    for bad in [f64::NAN, f64::INFINITY] {
        let error = tolerance(bad);
        assert!(matches!(error.problem(), Problem::NotFinite { .. }), "{error}");
        assert_eq!(error.parameter(), "merge_tolerance");
    }
    let inputs = FuzzyParameters { inputs: Inputs::trajectory(), ..good };
    let wanted = Error::wrong_length("inputs", 4, 6);
    assert_eq!(build(grid(), inputs, default).unwrap_err(), wanted);
    let law = FuzzyParameters { adaptation: Adaptation { gain: [1.0, 0.0], ..leaking() }, ..good };
    let error = build(grid(), law, default).unwrap_err();
    let place = (error.parameter(), error.index());
    assert!(place == ("gain", Some(1)) && out_of_range(error), "{error}");
    let gamma = FuzzyParameters { gamma: 0.1, ..good };
    let error = build(grid(), gamma, default).unwrap_err();
    assert!(matches!(error.problem(), Problem::NoStabilizingSolution { .. }), "{error}");
}

#[test]
fn every_axis_is_refused_by_name() {
    let refused = |axes: &[Axis<'_>]| KernelBasis::new(true, axes).unwrap_err();
    let axis =
        |centers: &'static [f64], widths: &'static [f64]| [PAPER_AXIS, Axis { centers, widths }];
    assert!(KernelBasis::new(true, &axis(&[0.0, 1.0], &[0.5])).is_ok());
    let name = |error: Error| error.parameter();
    assert_eq!(name(refused(&[])), "inputs");
    assert_eq!(name(refused(&vec![PAPER_AXIS; MAX_INPUTS + 1])), "inputs");
    assert_eq!(name(refused(&axis(&[], &[0.5]))), "centers");
    assert_eq!(name(refused(&axis(&[0.0, f64::NAN], &[0.5]))), "centers");
    assert_eq!(name(refused(&axis(&[0.0, 1e10], &[0.5]))), "centers");
    assert_eq!(name(refused(&axis(&[0.0, 1.0], &[0.0]))), "width");
    assert_eq!(name(refused(&axis(&[0.0, 1.0, 2.0], &[0.5, 0.5]))), "width");
    let many = [0.0; 100];
    let wide = Axis { centers: &many, widths: &[1.0] };
    assert_eq!(name(refused(&[wide; MAX_SETS / 100 + 1])), "sets");
    let (basis, mut work) = (grid(), vec![0.0; grid().work_len()]);
    let x = [0.0; 4];
    assert!(basis.kernel(&x, &x, &mut work).is_ok());
    assert_eq!(name(basis.kernel(&x[..3], &x, &mut work).unwrap_err()), "x");
    assert_eq!(name(basis.kernel(&x, &x[..3], &mut work).unwrap_err()), "y");
    assert_eq!(name(basis.kernel(&x, &[0.0, 0.0, f64::NAN, 0.0], &mut work).unwrap_err()), "y");
    assert_eq!(name(basis.kernel(&x, &x, &mut work[1..]).unwrap_err()), "work");
}
