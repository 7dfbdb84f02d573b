//! A sampled motion: between the samples at tₖ and tₖ₊₁ = tₖ + h runs the quintic Hermite
//! polynomial, with x = t − tₖ, s = x/h,
//!
//! ```text
//! q_d = q + q̇ x + q̈ x²/2 + s³ (c₃ + c₄ s + c₅ s²)
//! c₃ = 10r − 4r' + r''/2    c₄ = −15r + 7r' − r''    c₅ = 6r − 3r' + r''/2
//! ```
//!
//! where r, r' h⁻¹, r'' h⁻² are what the parabola q + q̇ x + q̈ x²/2 misses at the next sample in
//! value and derivatives.

use super::{Reference, Setpoint};
use crate::error::{Error, Result, finite, length, within};
use crate::math::Vector;

const TOO_CLOSE: &str = "a step whose velocity and acceleration are finite";

/// Samples of a motion at increasing times, interpolated with continuous velocity and acceleration.
///
/// It passes through every sample; in between, a smooth motion is met to order h⁶ in q, h⁵ in q̇,
/// h⁴ in q̈. Before the first and after the last sample it stands still at that position. Finding
/// the interval takes log₂(samples) comparisons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table<const N: usize, T> {
    t: T,
    q: T,
    dq: T,
    ddq: T,
    /// When it is at the first sample \[s\], if not when that says.
    start_time: Option<f64>,
}

impl<const N: usize, T: AsRef<[f64]>> Table<N, T> {
    /// Times `t` \[s\], and `q` \[rad\], `dq` [rad/s], `ddq` [rad/s²]: the `N` joints of sample 0,
    /// then those of sample 1, and so on.
    ///
    /// # Errors
    /// `OutOfRange` naming `t` for fewer than two samples (got = their number), for a time that
    /// does not increase, and for a step so short or long that the interpolation overflows;
    /// `WrongLength` or `NotFinite` naming `t`, `q`, `dq` or `ddq`.
    pub fn new(t: T, q: T, dq: T, ddq: T) -> Result<Self> {
        check_times(t.as_ref())?;
        let samples = t.as_ref().len();
        check_rows::<N>("q", q.as_ref(), samples)?;
        check_rows::<N>("dq", dq.as_ref(), samples)?;
        check_rows::<N>("ddq", ddq.as_ref(), samples)?;
        let table = Self { t, q, dq, ddq, start_time: None };
        for k in 0..samples - 1 {
            let h = table.step(k);
            let per_h = 1.0 / h;
            for i in 0..N {
                let [c3, c4, c5] = table.coefficients(k, i, h);
                // More than the sums of `inside` can reach; NaN if any of them overflowed.
                let bound = 60.0 * (c3.abs() + c4.abs() + c5.abs());
                if !(bound + bound * per_h + bound * (per_h * per_h)).is_finite() {
                    return Err(too_close(table.t.as_ref(), k + 1));
                }
            }
        }
        Ok(table)
    }

    /// The same motion with the first sample at `start_time` \[s\].
    ///
    /// # Errors
    /// `NotFinite`, naming `start_time`.
    pub fn starting_at(self, start_time: f64) -> Result<Self> {
        finite("start_time", &[start_time])?;
        Ok(Self { start_time: Some(start_time), ..self })
    }

    /// The samples: t, q, q̇, q̈, row-major.
    pub fn columns(&self) -> [&[f64]; 4] {
        [self.t.as_ref(), self.q.as_ref(), self.dq.as_ref(), self.ddq.as_ref()]
    }

    #[inline]
    fn step(&self, k: usize) -> f64 {
        self.t.as_ref()[k + 1] - self.t.as_ref()[k]
    }

    /// c₃, c₄, c₅ of joint `i` after sample `k`.
    #[inline]
    fn coefficients(&self, k: usize, i: usize, h: f64) -> [f64; 3] {
        let (now, next) = (k * N + i, (k + 1) * N + i);
        let (q, dq, ddq) = (self.q.as_ref(), self.dq.as_ref(), self.ddq.as_ref());
        let r = q[next] - q[now] - h * (dq[now] + 0.5 * h * ddq[now]);
        let r1 = h * (dq[next] - dq[now] - h * ddq[now]);
        let r2 = h * h * (ddq[next] - ddq[now]);
        [10.0 * r - 4.0 * r1 + 0.5 * r2, -15.0 * r + 7.0 * r1 - r2, 6.0 * r - 3.0 * r1 + 0.5 * r2]
    }

    /// The polynomial after sample `k`, `x` \[s\] later.
    #[inline]
    fn inside(&self, k: usize, x: f64) -> Setpoint<N> {
        let h = self.step(k);
        let per_h = 1.0 / h;
        let s = x * per_h;
        let mut setpoint = self.sample(k);
        for i in 0..N {
            let [c3, c4, c5] = self.coefficients(k, i, h);
            let (dq, ddq) = (setpoint.dq[i], setpoint.ddq[i]);
            setpoint.q[i] += x * (dq + 0.5 * x * ddq) + s * s * s * (c3 + s * (c4 + s * c5));
            setpoint.dq[i] +=
                x * ddq + s * s * (3.0 * c3 + s * (4.0 * c4 + s * (5.0 * c5))) * per_h;
            setpoint.ddq[i] += s * (6.0 * c3 + s * (12.0 * c4 + s * (20.0 * c5))) * (per_h * per_h);
        }
        setpoint
    }

    #[inline]
    fn sample(&self, k: usize) -> Setpoint<N> {
        let row = |data: &T| Vector::from_fn(|i, _| data.as_ref()[k * N + i]);
        Setpoint { q: row(&self.q), dq: row(&self.dq), ddq: row(&self.ddq) }
    }
}

impl<const N: usize, T: AsRef<[f64]>> Reference<N> for Table<N, T> {
    #[inline]
    fn at(&self, t: f64) -> Setpoint<N> {
        let times = self.t.as_ref();
        let t = self.start_time.map_or(t, |start| (t - start) + times[0]);
        let last = times.len() - 1;
        if t < times[0] {
            return Setpoint::at_rest(self.sample(0).q);
        }
        if t > times[last] {
            return Setpoint::at_rest(self.sample(last).q);
        }
        if t == times[last] {
            return self.sample(last);
        }
        // A time that is NaN falls to interval 0 and comes out as NaN.
        let k = times.partition_point(|&at| at <= t).saturating_sub(1);
        self.inside(k, t - times[k])
    }
}

#[cfg(feature = "std")]
impl<const N: usize> Table<N, Vec<f64>> {
    /// A table from positions alone: q̇ and q̈ of the cubic through each sample and its three
    /// nearest neighbours in the order of time, on any grid. Their errors are of order h³ and h²
    /// (h² and h with three samples; two give a straight line).
    ///
    /// # Errors
    /// As [`Table::new`], naming `t` or `q`.
    pub fn from_positions(t: &[f64], q: &[f64]) -> Result<Self> {
        check_times(t)?;
        check_rows::<N>("q", q, t.len())?;
        let (mut dq, mut ddq) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        for k in 0..t.len() {
            for i in 0..N {
                let (d, dd) = derivatives(t, |at| q[at * N + i], k);
                if !d.is_finite() || !dd.is_finite() {
                    return Err(too_close(t, k.max(1)));
                }
                dq[k * N + i] = d;
                ddq[k * N + i] = dd;
            }
        }
        Self::new(t.to_vec(), q.to_vec(), dq, ddq)
    }
}

/// First and second derivative at t\[k\] of the Newton polynomial through up to four samples around
/// it, `p = d₀ + d₁(t − t₀) + d₂(t − t₀)(t − t₁) + d₃(t − t₀)(t − t₁)(t − t₂)`.
#[cfg(feature = "std")]
fn derivatives(t: &[f64], value: impl Fn(usize) -> f64, k: usize) -> (f64, f64) {
    let count = t.len().min(4);
    let first = k.saturating_sub(1).min(t.len() - count);
    let mut d = [0.0; 4];
    for j in 0..count {
        d[j] = value(first + j);
    }
    for order in 1..count {
        for j in (order..count).rev() {
            d[j] = (d[j] - d[j - 1]) / (t[first + j] - t[first + j - order]);
        }
    }
    let x = |j: usize| t[k] - t[(first + j).min(t.len() - 1)];
    let (x0, x1, x2) = (x(0), x(1), x(2));
    (
        d[1] + d[2] * (x0 + x1) + d[3] * (x0 * x1 + x0 * x2 + x1 * x2),
        2.0 * d[2] + 2.0 * d[3] * (x0 + x1 + x2),
    )
}

fn check_times(t: &[f64]) -> Result<()> {
    finite("t", t)?;
    within("t", &[t.len() as f64], |samples| samples >= 2.0, "at least 2 samples")?;
    match t.windows(2).position(|pair| pair[1] <= pair[0]) {
        None => Ok(()),
        Some(k) => {
            let wanted = "a later time than the one before";
            Err(Error::out_of_range("t", t[k + 1], wanted).at(k + 1))
        }
    }
}

fn check_rows<const N: usize>(parameter: &'static str, data: &[f64], samples: usize) -> Result<()> {
    let too_many = Error::too_many(parameter, None, usize::MAX);
    length(parameter, data.len(), samples.checked_mul(N).ok_or(too_many)?)?;
    finite(parameter, data)
}

fn too_close(t: &[f64], index: usize) -> Error {
    Error::out_of_range("t", t[index], TOO_CLOSE).at(index)
}
