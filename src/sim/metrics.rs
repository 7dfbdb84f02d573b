//! How good a run was: figures over a window of time.

use crate::error::{Error, Result, length};
use crate::math::sqrt;

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
    let first = t.partition_point(|&x| x < window.from);
    let last = t.partition_point(|&x| x <= window.to);
    if first >= last {
        let wanted = "a window (from, to) with at least one recorded time";
        return Err(Error::out_of_range("window", window.from, wanted));
    }
    let mut figures = Metrics::default();
    let mut outside = None;
    for k in first..last {
        let torque = |k: usize| tau.get(k).map_or(f64::NAN, |tau| tau[n]);
        let (error, torque, next) = (e[k][n].abs(), torque(k), torque(k + 1));
        figures.rms_e += error * error;
        figures.max_abs_e = figures.max_abs_e.max(error);
        figures.rms_tau += torque * torque;
        figures.max_abs_tau = larger(figures.max_abs_tau, torque.abs());
        if error > window.band {
            outside = Some(k);
        }
        if k + 1 < last {
            let dt = t[k + 1] - t[k];
            let ramp = |k: usize| (t[k] - t[first]) * e[k][n].abs();
            figures.itae += 0.5 * dt * (ramp(k) + ramp(k + 1));
            figures.torque_variation += (next - torque).abs();
        }
    }
    let count = (last - first) as f64;
    figures.rms_e = sqrt(figures.rms_e / count);
    figures.rms_tau = sqrt(figures.rms_tau / count);
    let length = t[last - 1] - t[first];
    figures.torque_variation = if length > 0.0 { figures.torque_variation / length } else { 0.0 };
    figures.settling_time = match outside {
        None => 0.0,
        Some(k) if k + 1 < last => t[k + 1] - t[first],
        Some(_) => f64::INFINITY,
    };
    Ok(figures)
}

/// As `f64::max`, but NaN stays NaN.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}
