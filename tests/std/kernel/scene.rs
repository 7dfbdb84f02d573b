//! The paper's grid in both forms, and seven joints with the largest one.
#![allow(dead_code)]

use steadyarm::arm::{Arm, TwoLink};
use steadyarm::control::{
    Adaptation, ComputedTorque, Controller, FuzzyParameters, Gains, Inputs, KernelCompensator,
    KernelParameters, KernelState, State,
};
use steadyarm::fuzzy::{Axis, Form, KernelBasis};
use steadyarm::math::{Matrix, Vector};
use steadyarm::paper::{self, CENTERS, WIDTH};

use crate::common::{self, Adaptive, with_parameters};

pub type Kernel = Controller<2, ComputedTorque<2, TwoLink>, KernelCompensator<2>>;
pub type Memory<const N: usize> = State<N, KernelState<N, Vec<f64>>>;

pub const PAPER_AXIS: Axis<'static> = Axis { centers: &CENTERS, widths: &[WIDTH] };

pub fn parameters(adaptation: Adaptation<2>) -> FuzzyParameters<2> {
    FuzzyParameters { adaptation, ..FuzzyParameters::default() }
}

/// The paper's grid of 625 rules written out, and in kernel form.
pub fn both(
    normalized: bool,
    adaptation: Adaptation<2>,
    capacity: usize,
    merge_tolerance: f64,
) -> (Adaptive, Kernel) {
    let parameters = parameters(adaptation);
    let dense = with_parameters(Form::Grid, normalized, parameters);
    let basis = KernelBasis::new(normalized, &[PAPER_AXIS; 4]).unwrap();
    let kernel = KernelParameters { capacity, merge_tolerance };
    let gains = paper::gains().unwrap();
    let compensator = KernelCompensator::new(basis, &gains, parameters, kernel).unwrap();
    (dense, Controller::new(ComputedTorque::new(paper::nominal().unwrap(), gains), compensator))
}

pub fn fresh<const N: usize, A>(
    controller: &Controller<N, ComputedTorque<N, A>, KernelCompensator<N>>,
) -> Memory<N> {
    State::new(controller.compensator.state())
}

/// W of the dictionary, every rule written out, row-major.
pub fn expanded(controller: &Kernel, state: &KernelState<2, Vec<f64>>) -> Vec<f64> {
    let basis = controller.compensator.basis();
    let mut weights = vec![0.0; 2 * basis.rules() as usize];
    let mut memberships = vec![0.0; basis.sets()];
    for atom in 0..state.atoms() {
        let c = controller.compensator.read_atom(state, atom, &mut memberships).unwrap().unwrap();
        let xi = memberships.chunks_exact(CENTERS.len()).fold(vec![1.0], |xi, p| {
            xi.iter().flat_map(|a| p.iter().map(move |b| a * b)).collect::<Vec<_>>()
        });
        for (row, c) in weights.chunks_exact_mut(xi.len()).zip(c.iter()) {
            row.iter_mut().zip(&xi).for_each(|(w, xi)| *w += c * xi);
        }
    }
    weights
}

/// |W| of each joint's row.
pub fn row_norms(weights: &[f64]) -> Vector<2> {
    let norm = |row: &[f64]| row.iter().map(|w| w * w).sum::<f64>().sqrt();
    let (first, second) = weights.split_at(weights.len() / 2);
    Vector::<2>::new(norm(first), norm(second))
}

pub fn difference(left: &[f64], right: &[f64]) -> Vec<f64> {
    left.iter().zip(right).map(|(a, b)| a - b).collect()
}

/// Both controllers see the same samples, whatever they answer, for `steps` periods of `dt`.
pub fn drive(
    (dense, kernel): &(Adaptive, Kernel),
    steps: usize,
    dt: f64,
    mut seen: impl FnMut(usize, &common::AdaptiveState, &Memory<2>),
) {
    let (mut left, mut right) = (common::fresh(dense), fresh(kernel));
    for (k, (q, dq, desired)) in common::samples().iter().cycle().take(steps).enumerate() {
        dense.step(&mut left, q, dq, desired, dt).unwrap();
        kernel.step(&mut right, q, dq, desired, dt).unwrap();
        // Looked at where the period has ended.
        _ = (dense.settle(&mut left), kernel.settle(&mut right));
        seen(k, &left, &right);
    }
}

/// N uncoupled joints with the inertia of a small arm.
#[derive(Clone, Copy, Debug)]
pub struct Joints;

impl<const N: usize> Arm<N> for Joints {
    fn mass_matrix(&self, _: &Vector<N>) -> Matrix<N> {
        Matrix::from_diagonal(&Vector::from_fn(|n, _| 2.0 / (n + 1) as f64))
    }
    fn rigid_bias(&self, q: &Vector<N>, _: &Vector<N>) -> Vector<N> {
        q.map(|q| 3.0 * q)
    }
    fn friction(&self, dq: &Vector<N>) -> Vector<N> {
        dq * 0.1
    }
}

/// N joints, 2 N inputs (q, q̇) of five sets each.
pub fn joints<const N: usize>(
    normalized: bool,
    adaptation: Adaptation<N>,
    kernel: KernelParameters,
) -> Controller<N, ComputedTorque<N, Joints>, KernelCompensator<N>> {
    let basis = KernelBasis::new(normalized, &vec![PAPER_AXIS; 2 * N]).unwrap();
    let gains = Gains::new([8.0; N], [5.5; N]).unwrap();
    let inputs = Inputs::state();
    let parameters = FuzzyParameters { inputs, adaptation, ..FuzzyParameters::default() };
    let compensator = KernelCompensator::new(basis, &gains, parameters, kernel).unwrap();
    Controller::new(ComputedTorque::new(Joints, gains), compensator)
}
