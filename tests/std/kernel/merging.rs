//! What merging and dropping lose stays below the bound that the state reports, and |W| is that of
//! the dictionary.

use steadyarm::control::{Adaptation, Compensator, Sample};
use steadyarm::math::Vector;
use steadyarm::sim::RK4;

use super::scene::{Kernel, Memory, both, difference, drive, expanded, fresh, row_norms};
use crate::common::{self, Adaptive, ended, everything, law};

/// |W|² is a running sum, here of thousands of terms: relative to its largest value.
const NORM_TOL: f64 = 1e-11;

const STEPS: usize = 2000;
const DT: f64 = 0.01;

/// Laws whose drive and pull do not depend on W: the grid that is written out takes the very same
/// terms.
fn open_laws() -> [(&'static str, Adaptation<2>); 4] {
    let plain = law(40.0);
    [
        ("plain", plain),
        ("leak", Adaptation { leak_rate: 0.5, ..plain }),
        ("dead zone", Adaptation { dead_zone: 0.05, ..plain }),
        ("normalisation", Adaptation { normalization: 0.7, ..plain }),
    ]
}

/// The rows of W are no farther from those written out than the state says; returns the bound and
/// the true distance.
fn assert_bounded(
    name: &str,
    (dense, kernel): &(Adaptive, Kernel),
    left: &common::AdaptiveState,
    right: &Memory<2>,
) -> [f64; 2] {
    let wanted = common::learnt(dense, left);
    let found = expanded(kernel, right.compensator());
    let (bound, lost) =
        (right.compensator().error_bound(), row_norms(&difference(&wanted, &found)));
    for n in 0..2 {
        assert!(lost[n] <= bound[n] + 1e-14, "{name}, joint {n}: {} > {}", lost[n], bound[n]);
    }
    [bound.norm(), lost.norm()]
}

/// |W| as it is kept against that of the atoms.
fn assert_norm(name: &str, kernel: &Kernel, state: &Memory<2>, largest: &mut f64) {
    let (kept, found) = (
        state.compensator().weights_norm(),
        row_norms(&expanded(kernel, state.compensator())).norm(),
    );
    *largest = largest.max(found * found);
    let error = (kept * kept - found * found).abs();
    assert!(error <= NORM_TOL * *largest, "{name}: {kept} {found}");
}

#[test]
fn what_is_merged_stays_below_the_bound() {
    for normalized in [true, false] {
        for (name, adaptation) in open_laws() {
            for tolerance in [0.01, 0.05, 0.2] {
                let pair = both(normalized, adaptation, STEPS, tolerance);
                let name = format!("{name} {normalized} {tolerance}");
                let (mut sizes, mut norm) = ([0.0; 2], 0.0);
                drive(&pair, STEPS, DT, |k, dense, kernel| {
                    if k % 50 == 49 {
                        sizes = assert_bounded(&name, &pair, dense, kernel);
                        assert_norm(&name, &pair.1, kernel, &mut norm);
                    }
                    if k + 1 == STEPS {
                        let state = kernel.compensator();
                        assert!(state.merged() > 200 && state.dropped() == 0, "{name}");
                        let added = state.atoms() as u64 + state.merged();
                        assert!(
                            added <= STEPS as u64 && added > STEPS as u64 / 4,
                            "{name}: {added}"
                        );
                    }
                });
                // A bound that is never near the truth would be worth nothing, and a loss of
                // nothing no test.
                let [bound, lost] = sizes;
                assert!(lost > 1e-6 && bound < 1e3 * lost, "{name}: {bound:e} for {lost:e}");
            }
        }
    }
}

#[test]
fn a_full_dictionary_stays_full_counts_what_goes_and_keeps_its_bound() {
    for normalized in [true, false] {
        for (name, adaptation) in open_laws() {
            for (capacity, tolerance) in [(1, 0.1), (16, 0.01), (40, 0.0)] {
                let pair = both(normalized, adaptation, capacity, tolerance);
                let name = format!("{name} {normalized} {capacity}");
                let (mut norm, mut fewest) = (0.0, 0);
                drive(&pair, STEPS, DT, |k, dense, kernel| {
                    let state = kernel.compensator();
                    assert!(state.atoms() <= capacity && state.atoms() >= fewest);
                    fewest = state.atoms();
                    if k % 50 == 49 {
                        assert_bounded(&name, &pair, dense, kernel);
                        assert_norm(&name, &pair.1, kernel, &mut norm);
                    }
                    if k + 1 == STEPS {
                        assert_eq!(state.atoms(), capacity, "{name}");
                        assert!(state.dropped() > 50, "{name}: {}", state.dropped());
                        assert_eq!(state.merged() > 0, tolerance > 0.0, "{name}");
                    }
                });
            }
        }
    }
}

/// RK4's four stages at given samples: later ones see what earlier ones of the same step became,
/// merged or not.
#[test]
fn stages_of_one_step_are_merged_one_after_the_other() {
    for (capacity, tolerance) in [(2000, 0.02), (24, 0.02), (3, 0.0), (500, 0.3)] {
        for (name, adaptation) in open_laws() {
            let pair = both(true, adaptation, capacity, tolerance);
            let (mut left, mut right) = (common::fresh(&pair.0), fresh(&pair.1));
            let samples = common::samples();
            let mut norm = 0.0;
            for (k, step) in samples.windows(4).step_by(2).enumerate() {
                for (index, (q, dq, desired)) in step.iter().enumerate() {
                    let (stage, sample) = (RK4.stage(index, DT), Sample::new(*q, *dq, *desired));
                    pair.0.compensator.estimate(pair.0.settle(&mut left), &stage, &sample);
                    pair.1.compensator.estimate(pair.1.settle(&mut right), &stage, &sample);
                }
                pair.0.compensator.advance(pair.0.settle(&mut left), &RK4.end(DT, 4)).unwrap();
                pair.1.compensator.advance(pair.1.settle(&mut right), &RK4.end(DT, 4)).unwrap();
                if k % 10 == 9 {
                    assert_bounded(name, &pair, &left, &right);
                    assert_norm(name, &pair.1, &right, &mut norm);
                }
            }
            let state = right.compensator();
            assert_eq!(state.merged() > 0, tolerance > 0.0);
            assert_eq!(state.dropped() > 0, capacity < 30, "{}", state.atoms());
        }
    }
}

#[test]
fn the_norm_is_that_of_the_dictionary_with_every_modification() {
    for normalized in [true, false] {
        for (capacity, tolerance) in [(400, 0.05), (20, 0.05), (20, 0.0)] {
            let pair = both(normalized, everything(40.0), capacity, tolerance);
            let name = format!("{normalized} {capacity} {tolerance}");
            let (mut largest, mut radius) = (0.0, 0.0_f64);
            drive(&pair, STEPS, DT, |k, _, kernel| {
                radius = radius.max(kernel.compensator().weights_norm());
                if k % 50 == 49 {
                    assert_norm(&name, &pair.1, kernel, &mut largest);
                }
            });
            assert!(radius > 0.1 && radius < 2.0 + 1e-12, "{name}: {radius}");
        }
    }
}

#[test]
fn a_frozen_state_keeps_every_atom_and_a_reset_one_forgets_them() {
    let (_, kernel) = both(true, Adaptation { leak_rate: 0.5, ..law(40.0) }, 100, 0.05);
    let mut state = fresh(&kernel);
    let samples = common::samples();
    let run = |state: &mut Memory<2>, count: usize| {
        let step = |(q, dq, desired): &_| kernel.step(state, q, dq, desired, DT).unwrap().tau;
        samples.iter().take(count).map(step).collect::<Vec<_>>()
    };
    let first = run(&mut state, 300);
    kernel.settle(&mut state).freeze();
    let figures = |state: &Memory<2>| {
        let own = ended(&kernel, state);
        (own.atoms(), own.weights_norm(), own.error_bound())
    };
    let (atoms, norm, bound) = figures(&state);
    assert!(atoms > 5 && norm > 0.1 && bound.norm() > 0.0);
    let again = run(&mut state, 300);
    assert_eq!(again, run(&mut state, 300));
    assert_eq!(figures(&state), (atoms, norm, bound));
    kernel.compensator.reset(kernel.settle(&mut state));
    assert_eq!(figures(&state), (0, 0.0, Vector::zeros()));
    assert_eq!(first, run(&mut state, 300));
}
