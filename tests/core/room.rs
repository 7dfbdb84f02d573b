//! Without an allocator a basis has room for some sets, and takes lent memory for more.

use steadyarm::control::{FuzzyState, KernelState, MAX_STAGES};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis, KernelBasis};
use steadyarm::paper::{self, CLAIMED};

/// Sets on no lattice, so that each takes two numbers; and up to seven to whole lines.
const SETS: usize = 100;
const WANTED: usize = 2 * SETS + 7;

#[test]
fn a_basis_with_more_sets_than_its_room_takes_lent_memory() {
    let centers: [f64; SETS] = core::array::from_fn(|j| (0.02 * j as f64).powi(2));
    let axes = [Axis { centers: &centers, widths: &[0.5] }];
    assert_eq!(FuzzyBasis::buffer_len(&axes).unwrap(), WANTED);
    let refused =
        [FuzzyBasis::new(Form::Grid, true, &axes).err(), KernelBasis::new(true, &axes).err()];
    for error in refused {
        if cfg!(feature = "std") {
            assert_eq!(error, None);
        } else {
            assert_eq!(error.unwrap().to_string(), "buffer: got 192 entries, wants 207");
        }
    }
    let basis = FuzzyBasis::new_in(Form::Grid, true, &axes, [0.0; WANTED]).unwrap();
    let (mut work, mut xi) = ([0.0; 1200], [0.0; SETS]);
    let work = &mut work[..basis.work_len()];
    basis.evaluate(&[0.3], work, &mut xi).unwrap();
    // The nearest centre is 0.02² · 27².
    assert!((xi.iter().sum::<f64>() - 1.0).abs() < 1e-13 && xi.iter().all(|p| *p <= xi[27]));
}

#[test]
fn a_basis_of_sixteen_inputs_with_the_same_five_sets_needs_no_lent_memory() {
    let axes = [Axis { centers: &[-1.5, -0.5, 0.0, 0.5, 1.5], widths: &[0.7] }; 16];
    assert!(FuzzyBasis::new(Form::PerJoint { joints: 8 }, true, &axes).is_ok());
    assert!(KernelBasis::new(true, &axes).is_ok());
    if cfg!(not(feature = "std")) {
        assert!(size_of::<FuzzyBasis>() <= 3072);
    }
}

#[test]
fn without_integrators_a_state_has_the_one_stage_of_a_sampled_loop() {
    let buffer = paper::controller(CLAIMED).unwrap().compensator.buffer_len();
    // 625 rules and 7 of padding for each joint; ξ of a stage is 120 numbers long.
    let beside = buffer - 2 * 632 - MAX_STAGES * 120;
    assert!(beside < 64, "{beside}");
    let (fuzzy, kernel) =
        (size_of::<FuzzyState<7, &mut [f64]>>(), size_of::<KernelState<7, &mut [f64]>>());
    if cfg!(not(feature = "std")) {
        assert_eq!(MAX_STAGES, 1);
        assert!(fuzzy.max(kernel) < 1024, "{fuzzy} {kernel}");
    }
}
