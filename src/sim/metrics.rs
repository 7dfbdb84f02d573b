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
    rows: Rows,
    pub joints: [Sums<T>; N],
}

/// The rows in the window so far.
#[derive(Clone, Copy, Debug)]
struct Rows {
    window: Window,
    count: f64,
    /// Times of the first and of the last one \[s\].
    first: f64,
    last: f64,
}

/// A row in the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    begun: bool,
    /// Time since the first row, and since the one before \[s\].
    since: f64,
    dt: f64,
    band: f64,
}

impl<const N: usize, T: Copy> Figures<N, T> {
    /// Those of no row yet; `zero` is 0.
    pub fn over(window: Window, zero: T) -> Self {
        let rows = Rows { window, count: 0.0, first: 0.0, last: 0.0 };
        Self { rows, joints: [Sums::of([zero; SUMS]); N] }
    }

    /// Begins a row at time `t` \[s\], later than those before; `None` if it is not in the window.
    #[inline(always)]
    pub fn row(&mut self, t: f64) -> Option<Row> {
        let Rows { window, count, first, last } = &mut self.rows;
        if !(window.from <= t && t <= window.to) {
            return None;
        }
        let begun = *count > 0.0;
        if !begun {
            *first = t;
        }
        let row = Row { begun, since: t - *first, dt: t - *last, band: window.band };
        (*last, *count) = (t, *count + 1.0);
        Some(row)
    }

    /// The figures of the run of which `of` gives the numbers; `None` if no row was in the window.
    pub fn finish(&self, of: impl Fn(T) -> f64) -> Option<[Metrics; N]> {
        let (count, length) = (self.rows.count, self.rows.last - self.rows.first);
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

impl<const N: usize> Figures<N> {
    /// Adds a row at time `t` \[s\], later than those before, if it is in the window.
    #[inline]
    pub fn add(&mut self, t: f64, e: &Vector<N>, tau: &Vector<N>) {
        if let Some(row) = self.row(t) {
            for n in 0..N {
                self.joints[n].add(&row, e[n], tau[n]);
            }
        }
    }
}

/// Numbers in [`Sums`].
pub(super) const SUMS: usize = 9;

/// What the figures of a joint are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums<T> {
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

impl<T> Sums<T> {
    /// From its numbers.
    #[inline(always)]
    pub fn of(numbers: [T; SUMS]) -> Self {
        let [ramp, torque, squares, largest, ramps, settled, rest @ ..] = numbers;
        let [torque_squares, largest_torque, changes] = rest;
        Self {
            ramp,
            torque,
            squares,
            largest,
            ramps,
            settled,
            torque_squares,
            largest_torque,
            changes,
        }
    }

    /// Its numbers.
    #[inline(always)]
    pub fn numbers(self) -> [T; SUMS] {
        let Self { ramp, torque, squares, largest, ramps, settled, .. } = self;
        let Self { torque_squares, largest_torque, changes, .. } = self;
        [ramp, torque, squares, largest, ramps, settled, torque_squares, largest_torque, changes]
    }
}

impl<T: Real> Sums<T> {
    /// Adds a row.
    #[inline(always)]
    pub fn add(&mut self, row: &Row, e: T, torque: T) {
        let error = e.abs();
        let since = e.like(row.since);
        let ramp = since * error;
        let outside = e.like(f64::INFINITY);
        if row.begun {
            self.ramps += e.like(0.5 * row.dt) * (self.ramp + ramp);
            self.changes += (torque - self.torque).abs();
            // The row before was the last one outside so far.
            self.settled = self.settled.if_less(outside, self.settled, since);
        }
        self.squares += error * error;
        self.largest = self.largest.or_larger(error);
        self.torque_squares += torque * torque;
        self.largest_torque = self.largest_torque.or_larger(torque.abs());
        self.settled = e.like(row.band).if_less(error, outside, self.settled);
        (self.ramp, self.torque) = (ramp, torque);
    }
}
