//! How good a run was: figures over a window of time.

use crate::error::{Error, Result, length};
use crate::math::{Real, Vector, sqrt};

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
    let mut figures = Figures::<1>::over(window, 0.0);
    for (k, (t, e)) in t.iter().zip(e).enumerate() {
        let torque = tau.get(k).map_or(f64::NAN, |tau| tau[n]);
        figures.add(*t, &[e[n]].into(), &[torque].into());
    }
    let wanted = "a window (from, to) with at least one recorded time";
    let [figures] =
        figures.finish(|x| x).ok_or(Error::out_of_range("window", window.from, wanted))?;
    Ok(figures)
}

/// The figures of all joints, row by row, of a run or of several side by side: nothing of a row is
/// kept but the last one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Figures<const N: usize, T = f64> {
    window: Window,
    rows: f64,
    /// Times of the first row in the window and of the last one \[s\].
    first: f64,
    last: f64,
    joints: [Sums<T>; N],
}

/// What the figures of a joint are made of.
#[derive(Clone, Copy, Debug)]
struct Sums<T> {
    /// t |e| of the last row, t from the first, and its torque.
    ramp: T,
    torque: T,
    squares: T,
    largest: T,
    ramps: T,
    /// Time of the row after the last one outside the band, from the first; infinite after one.
    settled: T,
    torque_squares: T,
    largest_torque: T,
    changes: T,
}

impl<const N: usize, T: Real> Figures<N, T> {
    /// Those of no row yet; `zero` is 0.
    pub fn over(window: Window, zero: T) -> Self {
        let none = Sums {
            ramp: zero,
            torque: zero,
            squares: zero,
            largest: zero,
            ramps: zero,
            settled: zero,
            torque_squares: zero,
            largest_torque: zero,
            changes: zero,
        };
        Self { window, rows: 0.0, first: 0.0, last: 0.0, joints: [none; N] }
    }

    /// Adds a row at time `t` \[s\], later than those before, if it is in the window.
    #[inline(always)]
    pub fn add(&mut self, t: f64, e: &Vector<N, T>, tau: &Vector<N, T>) {
        if !(self.window.from <= t && t <= self.window.to) {
            return;
        }
        let begun = self.rows > 0.0;
        if !begun {
            self.first = t;
        }
        let (since, dt) = (t - self.first, t - self.last);
        for n in 0..N {
            let (error, torque, sums) = (e[n].abs(), tau[n], &mut self.joints[n]);
            let like = |x: f64| error.like(x);
            let ramp = like(since) * error;
            if begun {
                sums.ramps += like(0.5 * dt) * (sums.ramp + ramp);
                sums.changes += (torque - sums.torque).abs();
                // The row before was the last one outside so far.
                sums.settled = sums.settled.if_less(like(f64::INFINITY), sums.settled, like(since));
            }
            sums.squares += error * error;
            sums.largest = sums.largest.or_larger(error);
            sums.torque_squares += torque * torque;
            sums.largest_torque = sums.largest_torque.or_larger(torque.abs());
            let outside = like(f64::INFINITY);
            sums.settled = like(self.window.band).if_less(error, outside, sums.settled);
            (sums.ramp, sums.torque) = (ramp, torque);
        }
        (self.last, self.rows) = (t, self.rows + 1.0);
    }

    /// The figures of the run in a lane, of which `of` gives the number; `None` if no row was in
    /// the window.
    pub fn finish(&self, of: impl Fn(T) -> f64) -> Option<[Metrics; N]> {
        let (count, length) = (self.rows, self.last - self.first);
        let figures = self.joints.map(|sums| Metrics {
            rms_e: sqrt(of(sums.squares) / count),
            max_abs_e: of(sums.largest),
            itae: of(sums.ramps),
            settling_time: of(sums.settled),
            rms_tau: sqrt(of(sums.torque_squares) / count),
            // NaN is never the larger one.
            max_abs_tau: if of(sums.torque_squares).is_nan() {
                f64::NAN
            } else {
                of(sums.largest_torque)
            },
            torque_variation: if length > 0.0 { of(sums.changes) / length } else { 0.0 },
        });
        (count > 0.0).then_some(figures)
    }
}
