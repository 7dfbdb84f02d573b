//! The inner loops over rules: plain loops of 8 lanes, compiled for several instruction sets.
//!
//! The lanes are added in a fixed order and nothing is fused, so every instruction set gives the same bits.

use multiversion::multiversion;

/// Length of every inner row is a multiple of this.
pub(crate) const LANES: usize = 8;

/// Weights smaller than this are set to zero: denormal numbers would slow every later step.
const FLUSH_BELOW: f64 = 1e-300;

/// Σ_a u_a Σ_b W_ab v_b for a row-major W with `v.len()` columns.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn contract(weights: &[f64], u: &[f64], v: &[f64]) -> f64 {
    let mut total = [0.0; LANES];
    for (row, scale) in weights.chunks_exact(v.len()).zip(u) {
        let mut sum = [0.0; LANES];
        for (w, x) in row.chunks_exact(LANES).zip(v.chunks_exact(LANES)) {
            for lane in 0..LANES {
                sum[lane] += w[lane] * x[lane];
            }
        }
        for lane in 0..LANES {
            total[lane] += scale * sum[lane];
        }
    }
    add_lanes(&total)
}

/// W ← keep W + Σ_m c_m u_m v_mᵀ, row-major; returns |W|² of the result.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn accumulate<const M: usize>(
    weights: &mut [f64],
    keep: f64,
    coefficients: &[f64; M],
    u: &[&[f64]; M],
    v: &[&[f64]; M],
) -> f64 {
    let mut squares = [0.0; LANES];
    let columns = v[0].len();
    for (a, row) in weights.chunks_exact_mut(columns).enumerate() {
        let mut scales = [0.0; M];
        for m in 0..M {
            scales[m] = coefficients[m] * u[m][a];
        }
        for (b, w) in row.chunks_exact_mut(LANES).enumerate() {
            let mut sum = [0.0; LANES];
            for lane in 0..LANES {
                sum[lane] = keep * w[lane];
            }
            for m in 0..M {
                let x = &v[m][b * LANES..(b + 1) * LANES];
                for lane in 0..LANES {
                    sum[lane] += scales[m] * x[lane];
                }
            }
            for lane in 0..LANES {
                w[lane] = if sum[lane].abs() < FLUSH_BELOW { 0.0 } else { sum[lane] };
                squares[lane] += w[lane] * w[lane];
            }
        }
    }
    add_lanes(&squares)
}

/// Σ x_i y_i.
#[inline]
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sum = [0.0; LANES];
    let (xs, ys) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let rest: f64 = xs.remainder().iter().zip(ys.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in xs.zip(ys) {
        for lane in 0..LANES {
            sum[lane] += a[lane] * b[lane];
        }
    }
    add_lanes(&sum) + rest
}

#[inline]
fn add_lanes(x: &[f64; LANES]) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}
