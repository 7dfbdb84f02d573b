//! How good a run was: figures over a window of time.

use crate::error::{Error, Result, length};
use crate::math::{Vector, sqrt};

/// Figures of one joint over a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Metrics {
    /// Root mean square of e \[rad\].
    pub rms_e: f64,
    /// Largest |e| \[rad\].
    pub max_abs_e: f64,
    /// ∫ t |e| dt, t from the start of the window [rad·s²].
    pub itae: f64,
    /// Time from the start of the window after which |e| stays within the band \[s\]; infinite if
    /// it never does.
    pub settling_time: f64,
    /// Root mean square of τ [N·m]; NaN, like all figures of τ, where it was not recorded.
    pub rms_tau: f64,
    /// Largest |τ| [N·m].
    pub max_abs_tau: f64,
    /// Σ |τₖ₊₁ − τₖ| over the length of the window [N·m/s]: how much the torque moves.
    pub torque_variation: f64,
}

/// The window and band of [`metrics`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// First and last time \[s\].
    pub from: f64,
    /// Last time \[s\].
    pub to: f64,
    /// |e| within this counts as settled \[rad\].
    pub band: f64,
}

/// The figures of joint `n`, from times, errors and torques of equal length; no torques where they
/// were not recorded.
///
/// # Errors
/// `window`: holds no sample. `e`: not as long as `t`, as in a record of the motion alone.
pub fn metrics<const N: usize>(
    n: usize,
    t: &[f64],
    e: &[[f64; N]],
    tau: &[[f64; N]],
    window: Window,
) -> Result<Metrics> {
    length("e", e.len(), t.len())?;
    let mut figures = Figures::<1>::over(window);
    for (k, (t, e)) in t.iter().zip(e).enumerate() {
        let torque = tau.get(k).map_or(f64::NAN, |tau| tau[n]);
        figures.add(*t, &[e[n]].into(), &[torque].into());
    }
    let wanted = "a window (from, to) with at least one recorded time";
    let [figures] = figures.finish().ok_or(Error::out_of_range("window", window.from, wanted))?;
    Ok(figures)
}

/// The figures of all joints, row by row: nothing of a row is kept but the last one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Figures<const N: usize> {
    window: Window,
    rows: f64,
    /// Times of the first row in the window and of the last one \[s\].
    first: f64,
    last: f64,
    /// t |e| of the last row, t from the first, and its torque.
    ramp: Vector<N>,
    torque: Vector<N>,
    /// Sums so far, in the fields of what they become. The settling time is the row after the last
    /// one outside the band.
    sums: [Metrics; N],
}

impl<const N: usize> Figures<N> {
    /// Those of no row yet.
    pub fn over(window: Window) -> Self {
        let (zeros, sums) = (Vector::zeros(), [Metrics::default(); N]);
        Self { window, rows: 0.0, first: 0.0, last: 0.0, ramp: zeros, torque: zeros, sums }
    }

    /// Adds a row at time `t` \[s\], later than those before, if it is in the window.
    #[inline]
    pub fn add(&mut self, t: f64, e: &Vector<N>, tau: &Vector<N>) {
        if !(self.window.from <= t && t <= self.window.to) {
            return;
        }
        let begun = self.rows > 0.0;
        if !begun {
            self.first = t;
        }
        let (since, dt) = (t - self.first, t - self.last);
        for n in 0..N {
            let (error, torque, sums) = (e[n].abs(), tau[n], &mut self.sums[n]);
            let ramp = since * error;
            if begun {
                sums.itae += 0.5 * dt * (self.ramp[n] + ramp);
                sums.torque_variation += (torque - self.torque[n]).abs();
                // The row before was the last outside so far.
                if sums.settling_time == f64::INFINITY {
                    sums.settling_time = since;
                }
            }
            sums.rms_e += error * error;
            sums.max_abs_e = sums.max_abs_e.max(error);
            sums.rms_tau += torque * torque;
            sums.max_abs_tau = larger(sums.max_abs_tau, torque.abs());
            if error > self.window.band {
                sums.settling_time = f64::INFINITY;
            }
            (self.ramp[n], self.torque[n]) = (ramp, torque);
        }
        (self.last, self.rows) = (t, self.rows + 1.0);
    }

    /// The figures; `None` if no row was in the window.
    pub fn finish(&self) -> Option<[Metrics; N]> {
        let (count, length) = (self.rows, self.last - self.first);
        let figures = self.sums.map(|sums| Metrics {
            rms_e: sqrt(sums.rms_e / count),
            rms_tau: sqrt(sums.rms_tau / count),
            torque_variation: if length > 0.0 { sums.torque_variation / length } else { 0.0 },
            ..sums
        });
        (count > 0.0).then_some(figures)
    }
}

/// As `f64::max`, but NaN stays NaN.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}
