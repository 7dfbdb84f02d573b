//! The linear model of one joint under computed torque with a basis that sits at ξ(0).
//!
//! While the joint tracks, inputs [e; ė] keep the basis at ξ(0), and the fuzzy compensator is an
//! integrator: `ë = G (−k_v ė − k_p e + ρ_d − ρ̂)`, `ρ̂' = k_I (p12 e + p22 ė) − λ ρ̂`,
//! `k_I = gain |ξ(0)|² / (1 + ν |ξ(0)|²)`, with the leak λ and the normalisation ν.
//!
//! G = M⁻¹M₀ is the inertia ratio of the joint (nominal over true inertia: 1 for the right model,
//! 0.5 in the paper's example), `ρ_d = M₀⁻¹[ΔM q̈_d + ΔH − τ_d]` [rad/s²] the uncertainty ρ* along
//! the reference. The part ΔM (v − q̈_d) of ρ* is feedback, not disturbance, and is what puts G
//! before the gains.
//!
//! A velocity that is made of positions comes late, through a filter of cut-off f: wherever the law
//! has ė it is r then, `ṙ = 2πf (ė − r)`. From sample to sample that is the filter of
//! [`Front`](crate::control::Front).
//!
//! Source: paper (8), (12), (18), linearised at e = 0.

use core::f64::consts::TAU;

use crate::eigen::{Complex, eigenvalues, eigenvalues_in_place, modulus};
use crate::error::{Error, Result, at_most, finite, non_negative, positive};
use crate::math::{Matrix, exp, sqrt};

/// The longest delay accepted, in samples.
pub const MAX_DELAY: usize = 8;

/// e, ė, ρ̂, the commands under way, and what the filter keeps.
const STATES: usize = 5 + MAX_DELAY;
/// The search for the longest period starts at this share of the fastest time constant, where
/// sampling hardly matters …
const FIRST: f64 = 0.02;
/// … halves it so often if that is too long already …
const HALVINGS: usize = 20;
/// … grows by this factor, to step over no pocket of instability wider than that …
const GROWTH: f64 = 1.1;
/// … for so many steps (5e5 fold), and then bisects down to the rounding.
const STEPS: usize = 138;
const BISECTIONS: usize = 52;

/// One joint: gains, entries of P, integral gain and inertia ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearModel {
    /// k_p [1/s²], > 0.
    pub kp: f64,
    /// k_v [1/s], > 0.
    pub kv: f64,
    /// Entry of P of this joint's position with its velocity, ≥ 0.
    pub p12: f64,
    /// Entry of P of this joint's velocity with itself, ≥ 0.
    pub p22: f64,
    /// k_I = gain |ξ(0)|², weakened by normalisation, ≥ 0; 0 is computed torque alone.
    pub k_i: f64,
    /// λ, the leak [1/s], ≥ 0.
    pub leak_rate: f64,
    /// G = nominal over true inertia, > 0.
    pub inertia_ratio: f64,
    /// Cut-off f of the filter that makes the velocity of positions \[Hz\], > 0; `None`: it is
    /// measured.
    pub velocity_filter: Option<f64>,
}

/// What a velocity filter, called every `h` \[s\], makes of a position: of what it had, it keeps
/// one part, and of the new difference it takes another [1/s].
pub(super) fn filtering(cut_off: f64, h: f64) -> (f64, f64) {
    let kept = exp(-TAU * cut_off * h);
    (kept, (1.0 - kept) / h)
}

impl LinearModel {
    /// The poles [1/s]: roots of
    /// `s³ + (G k_v + λ) s² + G (k_p + k_I p22 + λ k_v) s + G (k_I p12 + λ k_p)`, and with a filter
    /// a fourth; without one that is at −∞. Without an integrator one of them is −λ.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange` for a field, as in every method here; `NoConvergence`.
    pub fn poles(&self) -> Result<[Complex; 4]> {
        self.check()?;
        let Self { kp, kv, p12, p22, k_i, leak_rate, inertia_ratio: g, velocity_filter } = *self;
        if let Some(cut_off) = velocity_filter {
            let w = TAU * cut_off;
            // [e, ė, ρ̂, r]
            #[rustfmt::skip]
            let a = Matrix::<4>::new(
                0.0,       1.0, 0.0,        0.0,
                -g * kp,   0.0, -g,         -g * kv,
                k_i * p12, 0.0, -leak_rate, k_i * p22,
                0.0,       w,   0.0,        -w,
            );
            return eigenvalues(&a);
        }
        // [e, ė, ρ̂]
        #[rustfmt::skip]
        let a = Matrix::<3>::new(
            0.0,       1.0,       0.0,
            -g * kp,   -g * kv,   -g,
            k_i * p12, k_i * p22, -leak_rate,
        );
        let [first, second, third] = eigenvalues(&a)?;
        Ok([first, second, third, Complex::new(f64::NEG_INFINITY, 0.0)])
    }

    /// |e/ρ_d| \[s²\] at `omega` [rad/s] ≥ 0: `1 / |s²/G + k_v r + k_p + C(s)|`, s = jω, with
    /// the integrator `C(s) = k_I (p12 + p22 r) / (s + λ)` and r = s, or s / (1 + s/2πf) through
    /// the filter.
    ///
    /// # Errors
    /// As [`Self::poles`], and for `omega`.
    pub fn gain_at(&self, omega: f64) -> Result<f64> {
        self.check()?;
        non_negative("omega", &[omega])?;
        let Self { kp, kv, p12, p22, k_i, leak_rate, inertia_ratio: g, velocity_filter } = *self;
        let through = velocity_filter.map_or(0.0, |cut_off| omega / (TAU * cut_off));
        let rate = Complex::new(0.0, omega) / Complex::new(1.0, through);
        let mut stiffness = rate * kv + (kp - omega * omega / g);
        let drive = rate * (k_i * p22) + k_i * p12;
        let lag = Complex::new(leak_rate, omega);
        if lag != Complex::new(0.0, 0.0) {
            stiffness += drive / lag;
        } else if k_i * p12 > 0.0 {
            return Ok(0.0);
        } else {
            // ω = 0: r/s is 1.
            stiffness += k_i * p22;
        }
        Ok(1.0 / modulus(stiffness))
    }

    /// Steady RMS of e \[rad\] under ρ_d = `amplitude` sin(`omega` t), [rad/s²] and [rad/s].
    ///
    /// # Errors
    /// As [`Self::gain_at`].
    pub fn steady_rms(&self, amplitude: f64, omega: f64) -> Result<f64> {
        finite("amplitude", &[amplitude])?;
        Ok(amplitude.abs() * self.gain_at(omega)? / sqrt(2.0))
    }

    /// Spectral radius of the model sampled with `control_period` h \[s\], the command held and
    /// applied `delay_samples` d samples late.
    ///
    /// Exact for the double integrator: `e⁺ = e + h ė + ½h² G c`, `ė⁺ = ė + h G c`, with
    /// `c = −k_v ė − k_p e − ρ̂` of d samples ago; the weights advance after the command is
    /// computed, `ρ̂⁺ = e^(−λh) (ρ̂ + h k_I (p12 e + p22 ė))`. Through a filter ė is there
    /// `r⁺ = e^(−2πfh) r + (1 − e^(−2πfh)) (e − e₋)/h`. Stable below 1. An integrator that is not
    /// driven does not count.
    ///
    /// At k_p = 8, k_v = 5.5, Q = 10I, γ = 1 and G = 1 it passes 1 at 0.364 s for k_I = 0, at 14.5
    /// ms for k_I = 700 · 0.42163, at 67 ms for 7 · 8.94112 and at 6.9 ms for 70 · 8.94112; one
    /// sample of delay halves these. With G = 0.5 and k_I > 0 they are 11 % shorter.
    ///
    /// # Errors
    /// As [`Self::poles`]; `OutOfRange` for `control_period`, `TooMany` for more than [`MAX_DELAY`]
    /// samples.
    pub fn sampled_radius(&self, control_period: f64, delay_samples: usize) -> Result<f64> {
        self.check()?;
        positive("control_period", &[control_period])?;
        at_most("delay_samples", delay_samples, MAX_DELAY)?;
        self.radius(control_period, delay_samples)
    }

    /// The longest period \[s\] below which the sampled model is stable, with `delay_samples` of
    /// delay.
    ///
    /// # Errors
    /// As [`Self::sampled_radius`]; `NotHurwitz` if the model is unstable even without sampling.
    pub fn max_period(&self, delay_samples: usize) -> Result<f64> {
        let poles = self.poles()?;
        if !self.settles() {
            let max_real = poles.iter().fold(f64::NEG_INFINITY, |most, z| most.max(z.re));
            return Err(Error::not_hurwitz("linear model", max_real));
        }
        // The leak and the filter are exact at any period, however fast.
        let kept = Self { leak_rate: 0.0, velocity_filter: None, ..*self }.poles()?;
        let [loops @ .., _] = kept;
        let fastest = loops.iter().fold(0.0, |most: f64, &z| most.max(modulus(z)));
        let stable = |h: f64| Ok(self.sampled_radius(h, delay_samples)? < 1.0);
        let (good, bad) = bracket(FIRST / fastest, stable)?;
        bisect(good, bad, stable)
    }

    /// Whether it is stable in continuous time, by Routh; all coefficients are positive.
    fn settles(&self) -> bool {
        let Self { kp, kv, p12, p22, k_i, leak_rate, inertia_ratio: g, velocity_filter } = *self;
        // Divided by G.
        let (first, last) = (kp + k_i * p22 + leak_rate * kv, k_i * p12 + leak_rate * kp);
        let Some(cut_off) = velocity_filter else {
            return (g * kv + leak_rate) * first > last;
        };
        // An integrator that is not driven is a factor of its own.
        if k_i * (p12 + p22) == 0.0 {
            return true;
        }
        // Of s⁴ + …, divided by 2πf and, but for the third and the second, by G.
        let lag = 1.0 / (TAU * cut_off);
        let third = 1.0 + leak_rate * lag;
        let second = g * (kv + kp * lag) + leak_rate;
        let first = first + last * lag;
        first * (third * second - g * first * lag) > third * third * last
    }

    fn radius(&self, h: f64, delay: usize) -> Result<f64> {
        let Self { kp, kv, p12, p22, k_i, leak_rate, inertia_ratio: g, velocity_filter } = *self;
        let keep = exp(-leak_rate * h);
        // [e, ė, commands under way with the oldest first, r₋ and e₋ of a filter, ρ̂]; ρ̂ counts
        // only if it is driven.
        let past = 2 + delay;
        let rho = if velocity_filter.is_some() { past + 2 } else { past };
        let n = if k_i * (p12 + p22) > 0.0 { rho + 1 } else { rho };
        let mut entries = [0.0; STATES * STATES];
        let mut add = |i: usize, j: usize, x: f64| {
            if i < n && j < n {
                entries[i + j * n] += x;
            }
        };
        for (i, j, x) in [(0, 0, 1.0), (0, 1, h), (1, 1, 1.0), (rho, rho, keep)] {
            add(i, j, x);
        }
        // The velocity that the law has, of which states.
        let mut rate = [(1, 1.0), (1, 0.0), (1, 0.0)];
        if let Some(cut_off) = velocity_filter {
            let (kept, taken) = filtering(cut_off, h);
            rate = [(0, taken), (past, kept), (past + 1, -taken)];
            rate.iter().for_each(|&(j, x)| add(past, j, x));
            add(past + 1, 0, 1.0);
        }
        let integrates = keep * h * k_i;
        add(rho, 0, integrates * p12);
        rate.iter().for_each(|&(j, x)| add(rho, j, integrates * p22 * x));
        // c of this sample: applied at once, or queued behind the others.
        let [first, second, third] = rate.map(|(j, x)| (j, -kv * x));
        for (j, c) in [(0, -kp), first, second, third, (rho, -1.0)] {
            if delay == 0 {
                add(0, j, 0.5 * h * h * g * c);
                add(1, j, h * g * c);
            } else {
                add(past - 1, j, c);
            }
        }
        if delay > 0 {
            add(0, 2, 0.5 * h * h * g);
            add(1, 2, h * g);
            (2..past - 1).for_each(|i| add(i, i + 1, 1.0));
        }
        finite("control_period", &entries[..n * n])?;
        let mut values = [Complex::new(0.0, 0.0); STATES];
        eigenvalues_in_place(n, &mut entries[..n * n], &mut values[..n])?;
        Ok(values[..n].iter().fold(0.0, |most: f64, &z| most.max(modulus(z))))
    }

    fn check(&self) -> Result<()> {
        positive("kp", &[self.kp])?;
        positive("kv", &[self.kv])?;
        non_negative("p12", &[self.p12])?;
        non_negative("p22", &[self.p22])?;
        non_negative("k_i", &[self.k_i])?;
        non_negative("leak_rate", &[self.leak_rate])?;
        positive("inertia_ratio", &[self.inertia_ratio])?;
        positive("velocity_filter", &[self.velocity_filter.unwrap_or(1.0)])
    }
}

/// A stable period and a longer one that is not.
fn bracket(first: f64, stable: impl Fn(f64) -> Result<bool>) -> Result<(f64, f64)> {
    let mut good = first;
    for _ in 0..HALVINGS {
        if stable(good)? {
            break;
        }
        good *= 0.5;
    }
    for _ in 0..STEPS {
        if !stable(good * GROWTH)? {
            return Ok((good, good * GROWTH));
        }
        good *= GROWTH;
    }
    Err(Error::no_convergence("longest period"))
}

fn bisect(mut good: f64, mut bad: f64, stable: impl Fn(f64) -> Result<bool>) -> Result<f64> {
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (good + bad);
        if stable(middle)? {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Ok(good)
}
