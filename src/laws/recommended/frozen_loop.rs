//! The sampled loop of law and observer at a pose, with the arm's true mass matrix M there:
//! `z⁺ = Φz`, z = [e, ė, e₋, two filtered ė, ζ, the last `delay` v].
//!
//! Over a period the torque is held, so e and ė move exactly. What changes with the pose is slow
//! beside the loop, and left out, and so is what is learnt.

use nalgebra::DMatrix;

use super::learned_torque::{LearningGains, filter};
use crate::arm::Factor;
use crate::eigen::{modulus, spectrum};
use crate::error::Result;
use crate::math::{Matrix, Vector};

/// The largest modulus of the loop's roots, where the velocity comes through a first filter with
/// the cut-off `velocity` \[Hz\], D is `weight` and M is `mass`.
///
/// # Errors
/// As [`spectrum`].
pub(super) fn slowest_root<const N: usize>(
    gains: &LearningGains<N>,
    velocity: f64,
    weight: &Matrix<N>,
    mass: &Matrix<N>,
) -> Result<f64> {
    let size = (6 + gains.delay) * N;
    let mut step = DMatrix::<f64>::zeros(size, size);
    let push = Push::of(weight, mass);
    for column in 0..size {
        let mut z = vec![Vector::<N>::zeros(); 6 + gains.delay];
        z[column / N][column % N] = 1.0;
        let next = after(gains, velocity, &push, &z);
        let entries = next.iter().flat_map(|part| part.iter());
        step.column_mut(column).iter_mut().zip(entries).for_each(|(cell, x)| *cell = *x);
    }
    Ok(spectrum(&step)?.iter().fold(0.0, |most, root| most.max(modulus(*root))))
}

/// M⁻¹D.
struct Push<const N: usize>(Matrix<N>);

impl<const N: usize> Push<N> {
    fn of(weight: &Matrix<N>, mass: &Matrix<N>) -> Self {
        let factor = Factor::of(mass);
        let mut push = Matrix::<N>::zeros();
        for (mut column, of_weight) in push.column_iter_mut().zip(weight.column_iter()) {
            column.copy_from(&factor.solve(&of_weight.into_owned()));
        }
        Self(push)
    }
}

/// z a sample later.
fn after<const N: usize>(
    gains: &LearningGains<N>,
    velocity: f64,
    push: &Push<N>,
    z: &[Vector<N>],
) -> Vec<Vector<N>> {
    let (h, p) = (gains.control_period, Vector::from(gains.pull.bandwidth));
    let [e, de, before, first, second, zeta] = [z[0], z[1], z[2], z[3], z[4], z[5]];
    let under_way = &z[6..];
    let first = first + ((e - before) / h - first) * filter(velocity, h);
    let second =
        Vector::from_fn(|n, _| second[n] + (first[n] - second[n]) * filter(gains.cut_off[n], h));
    let alpha = zeta - p.component_mul(&second);
    let v = alpha - p.component_mul(&(second * 2.0 + p.component_mul(&e)));
    let acting = under_way.last().copied().unwrap_or(v);
    let acceleration = push.0 * acting;
    let zeta = zeta + p.component_mul(&(acting - alpha)) * h;
    let mut next = vec![
        e + de * h + acceleration * (0.5 * h * h),
        de + acceleration * h,
        e,
        first,
        second,
        zeta,
    ];
    if !under_way.is_empty() {
        next.push(v);
        next.extend_from_slice(&under_way[..under_way.len() - 1]);
    }
    next
}
