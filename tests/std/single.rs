//! The numbers of the Panda that microcontrollers are measured with.

use steadyarm::arm::{Arm, Serial};
use steadyarm::math::Vector;
use steadyarm::robot::shipped;

use crate::panda_numbers::panda;

#[test]
fn the_panda_without_a_file_is_that_of_the_file() {
    let file: Serial<7> = shipped("panda").unwrap().arm().unwrap();
    let (own, q) = (panda().unwrap(), Vector::<7>::from_fn(|i, _| 0.4 - 0.3 * i as f64));
    assert_eq!(own.fingerprint(), file.fingerprint());
    assert_eq!(own.mass_matrix_and_bias(&q, &q), file.mass_matrix_and_bias(&q, &q));
}
