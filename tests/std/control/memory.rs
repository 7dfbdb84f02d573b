//! A basis whose sets stand in memory that was lent, and the controllers over it: the same bits.

use crate::common::{bits, everything, nominal_law};
use steadyarm::control::{
    Buffer, Compensator, Controller, FuzzyCompensator, FuzzyParameters, KernelCompensator,
    KernelParameters, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis, KernelBasis};
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::reference::Reference;

const SHARED: Axis<'_> = Axis { centers: &paper::CENTERS, widths: &[paper::WIDTH] };
const NARROW: Axis<'_> = Axis { widths: &[0.2], ..SHARED };
const UNEVEN: Axis<'_> =
    Axis { centers: &[-1.3, 0.1, 0.2, 0.9, 1.7], widths: &[0.3, 0.4, 0.5, 0.6, 0.7] };

/// ξ of a basis at x.
fn xi<B: Buffer>(basis: &FuzzyBasis<B>, x: &[f64]) -> Vec<u64> {
    let mut xi = vec![0.0; basis.rules()];
    basis.evaluate(x, &mut vec![0.0; basis.work_len()], &mut xi).unwrap();
    bits(&xi)
}

#[test]
fn a_basis_in_lent_memory_is_the_same_to_the_bit_and_short_memory_is_refused() {
    for axes in [[SHARED; 4], [UNEVEN; 4], [SHARED, UNEVEN, NARROW, SHARED]] {
        let wanted = FuzzyBasis::buffer_len(&axes).unwrap();
        for form in [Form::Grid, Form::Shared, Form::Concat, Form::PerJoint { joints: 2 }] {
            let owned = FuzzyBasis::new(form, true, &axes).unwrap();
            let mut memory = vec![f64::NAN; wanted];
            let lent = FuzzyBasis::new_in(form, true, &axes, &mut memory[..]).unwrap();
            for x in [[0.1, -0.2, 0.3, 0.7], [40.0, 0.0, -1e9, 1.0]] {
                assert_eq!(xi(&owned, &x), xi(&lent, &x), "{form:?} {x:?}");
            }
            let short = FuzzyBasis::new_in(form, true, &axes, &mut memory[1..]).unwrap_err();
            let wants = format!("buffer: got {} entries, wants {wanted}", wanted - 1);
            assert_eq!(short.to_string(), wants);
        }
    }
}

#[test]
fn inputs_with_the_same_sets_share_their_numbers() {
    let one = FuzzyBasis::buffer_len(&[UNEVEN]).unwrap();
    assert_eq!(FuzzyBasis::buffer_len(&[UNEVEN; 40]).unwrap(), one);
    // Ten numbers of the sets; of the lattice four rows of eight lanes and one a set.
    assert_eq!(FuzzyBasis::buffer_len(&[SHARED; 8]).unwrap(), 7 + 10 + 8 * (4 + 5));
    assert_eq!(FuzzyBasis::buffer_len(&[SHARED, NARROW]).unwrap(), 7 + 20 + 8 * (4 + 5));
}

/// The torques of a run of samples along the paper's path.
fn torques<S>(compensator: impl Compensator<2, S>, memory: S) -> Vec<u64> {
    let controller = Controller::new(nominal_law(), compensator);
    let (mut state, reference) = (State::new(memory), paper::reference().unwrap());
    let step = |k: u32| {
        let t = f64::from(k) * 2e-3;
        let (q, dq) = (Vector::<2>::new(0.3 * t.sin(), 0.2 - t), Vector::<2>::new(t.cos(), -0.1));
        let command = controller.step(&mut state, &q, &dq, &reference.at(t), 2e-3);
        bits(command.unwrap().tau.as_slice())
    };
    (0..200).flat_map(step).collect()
}

#[test]
fn controllers_over_a_lent_basis_give_the_same_torques() {
    let gains = paper::gains().unwrap();
    let parameters = FuzzyParameters { adaptation: everything(7.0), ..Default::default() };
    let kernel = KernelParameters { capacity: 20, merge_tolerance: 0.05 };
    let axes = [SHARED, UNEVEN, NARROW, SHARED];
    let room = || vec![f64::NAN; FuzzyBasis::buffer_len(&axes).unwrap()];

    let basis = FuzzyBasis::new(Form::Grid, true, &axes).unwrap();
    let lent = FuzzyBasis::new_in(Form::Grid, true, &axes, room().into_boxed_slice()).unwrap();
    let owned = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
    let lent = FuzzyCompensator::new(lent, &gains, parameters).unwrap();
    let (left, right) = (owned.state(), lent.state());
    assert_eq!(torques(owned, left), torques(lent, right));

    let basis = KernelBasis::new(true, &axes).unwrap();
    let lent = KernelBasis::new_in(true, &axes, room().into_boxed_slice()).unwrap();
    let owned = KernelCompensator::new(basis, &gains, parameters, kernel).unwrap();
    let lent = KernelCompensator::new(lent, &gains, parameters, kernel).unwrap();
    let (left, right) = (owned.state(), lent.state());
    assert_eq!(torques(owned, left), torques(lent, right));
}
