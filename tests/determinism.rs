//! The same bits on every machine, with every instruction set, in every build: hashes of final states.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use common::{Adaptive, adaptive, everything, fresh, hash, modified, on, weights};
use steadyarm::control::{Inputs, Limits};
use steadyarm::fuzzy::Form;
use steadyarm::sim::{Method, Options, Status, Tolerance, simulate};

/// FNV-1a of q, dq, W, V and tau at the end. They change with every change of the arithmetic, and with nothing else:
/// when that is meant, copy them from the message of the failing test.
const CONTINUOUS: u64 = 0x9edb_8046_ce63_9da2;
const SAMPLED: u64 = 0x8175_0e4e_2b61_24ac;
const ERROR_CONTROLLED: u64 = 0x99d1_78f0_4c87_575a;

fn final_hash(controller: &Adaptive, options: &Options<2>) -> u64 {
    let mut state = fresh(controller);
    let (plant, reference) = (common::plant(), common::reference());
    let run = simulate(&plant, controller, &mut state, &reference, options, on).unwrap();
    assert_eq!(run.status, Status::Finished);
    let last = run.t.len() - 1;
    let motion = run.q[last].into_iter().chain(run.dq[last]).chain(run.tau[last]);
    hash(motion.chain([run.v[last]]).chain(weights(controller, &state.compensator)))
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
