//! One lane at a time, and with the registers of this machine: the same bits.

use pulp::Scalar;

use super::step::Estimate;
use super::*;
use crate::control::{Adaptation, Compensator, Sample, Stage};
use crate::fuzzy::Axis;
use crate::math::{Vector, sin_cos};
use crate::reference::Setpoint;

const STEPS: usize = 2000;

fn compensator(capacity: usize, merge_tolerance: f64) -> KernelCompensator<2> {
    let adaptation = Adaptation {
        gain: [60.0, 30.0],
        leak_rate: 0.3,
        error_modification: 0.01,
        projection_radius: 3.0,
        normalization: 0.1,
        ..Adaptation::default()
    };
    let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
    let axes = [Axis { centers: &[-1.5, -0.5, 0.0, 0.5, 1.5], widths: &[0.7] }; 4];
    let basis = KernelBasis::new(true, &axes).unwrap();
    let gains = Gains::new([8.0; 2], [5.5; 2]).unwrap();
    let kernel = KernelParameters { capacity, merge_tolerance };
    KernelCompensator::new(basis, &gains, parameters, kernel).unwrap()
}

fn sample(k: usize) -> Sample<2> {
    let (sin, cos) = sin_cos(0.037 * k as f64);
    let (fast, slow) = sin_cos(0.011 * k as f64);
    let zeros = Vector::zeros();
    let desired = Setpoint { q: zeros, dq: zeros, ddq: zeros };
    Sample::new(Vector::<2>::new(sin, fast), Vector::<2>::new(cos, -slow), desired)
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    for (capacity, tolerance) in [(1, 0.1), (13, 0.05), (60, 0.0), (500, 0.3)] {
        let compensator = compensator(capacity, tolerance);
        let (mut left, mut right) = (compensator.state(), compensator.state());
        for k in 0..STEPS {
            let (stage, sample) = (&Stage::NOW, &sample(k));
            let wide = compensator.estimate(&mut left, stage, sample);
            let state = &mut right;
            let estimate = Estimate { compensator: &compensator, state, stage, sample };
            let narrow = estimate.with(Scalar);
            assert_eq!(wide.map(f64::to_bits), narrow.map(f64::to_bits), "step {k}");
            compensator.advance(&mut left, &Stage::after(0.01)).unwrap();
            let end = Stage::after(0.01);
            compensator.update.finish(&mut right.stages, &right.norms, &end).unwrap();
            compensator.write(Scalar, &mut right, end.index);
        }
        assert!(left.weights_norm() > 0.1);
        assert_eq!(left.weights_norm().to_bits(), right.weights_norm().to_bits());
        assert_eq!(
            (left.atoms, left.merged, left.dropped),
            (right.atoms, right.merged, right.dropped)
        );
        assert_eq!(left.dropped > 0, capacity < 100);
        assert_eq!(left.merged > 0, tolerance > 0.0);
    }
}
