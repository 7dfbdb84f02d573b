//! Runge-Kutta steps of a second-order system q̈ = f(t, q, q̇): classical RK4, and Dormand-Prince
//! 5(4) with its error estimate and dense output (Hairer, Nørsett, Wanner, Solving ODEs I, table
//! II.5.2; Shampine 1986).

use crate::control::Stage;
use crate::math::{Real, Vector, sqrt};

/// Position and velocity at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<const N: usize, T = f64> {
    /// q \[rad\].
    pub q: Vector<N, T>,
    /// q̇ [rad/s].
    pub dq: Vector<N, T>,
}

/// An explicit Runge-Kutta method of `S` stages.
#[derive(Debug)]
pub struct Tableau<const S: usize> {
    /// cᵢ.
    pub nodes: [f64; S],
    /// aᵢⱼ.
    pub rows: [[f64; S]; S],
    /// bᵢ.
    pub weights: [f64; S],
}

/// The classical method of order 4.
pub const RK4: Tableau<4> = Tableau {
    nodes: [0.0, 0.5, 0.5, 1.0],
    rows: [[0.0; 4], [0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    weights: [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
};

/// bᵢ of Dormand-Prince, the last stage's row too: that stage is the end of the step.
const DP54_WEIGHTS: [f64; 7] =
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0, 0.0];

/// Dormand and Prince's method of order 5.
pub const DP54: Tableau<7> = Tableau {
    nodes: [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0],
    rows: [
        [0.0; 7],
        [0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0, 0.0],
        [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0, 0.0],
        [
            9017.0 / 3168.0,
            -355.0 / 33.0,
            46732.0 / 5247.0,
            49.0 / 176.0,
            -5103.0 / 18656.0,
            0.0,
            0.0,
        ],
        DP54_WEIGHTS,
    ],
    weights: DP54_WEIGHTS,
};

/// bᵢ − b̂ᵢ: the difference to the embedded method of order 4.
pub const DP54_ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Coefficients of θ, θ², θ³, θ⁴ in bᵢ(θ), the dense output of order 4.
const DP54_DENSE: [[f64; 4]; 7] = [
    [
        1.0,
        -8048581381.0 / 2820520608.0,
        8663915743.0 / 2820520608.0,
        -12715105075.0 / 11282082432.0,
    ],
    [0.0; 4],
    [
        0.0,
        131558114200.0 / 32700410799.0,
        -68118460800.0 / 10900136933.0,
        87487479700.0 / 32700410799.0,
    ],
    [0.0, -1754552775.0 / 470086768.0, 14199869525.0 / 1410260304.0, -10690763975.0 / 1880347072.0],
    [
        0.0,
        127303824393.0 / 49829197408.0,
        -318862633887.0 / 49829197408.0,
        701980252875.0 / 199316789632.0,
    ],
    [0.0, -282668133.0 / 205662961.0, 2019193451.0 / 616988883.0, -1453857185.0 / 822651844.0],
    [0.0, 40617522.0 / 29380423.0, -110615467.0 / 29380423.0, 69997945.0 / 29380423.0],
];

/// bᵢ(θ) of the dense output of Dormand-Prince, θ in [0, 1].
pub fn dp54_dense(theta: f64) -> [f64; 7] {
    DP54_DENSE.map(|p| theta * (p[0] + theta * (p[1] + theta * (p[2] + theta * p[3]))))
}

/// Dense output of Dormand-Prince over one step as a polynomial: y(θ) = y₀ + h Σ θᵖ yₚ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dense<const N: usize> {
    start: Motion<N>,
    h: f64,
    powers: [Motion<N>; 4],
}

impl<const N: usize> Dense<N> {
    /// The polynomial of the step of length `h` from `start`.
    pub fn new(h: f64, start: &Motion<N>, rates: &Rates<N, 7>) -> Self {
        let mut powers = [Motion::zeros(); 4];
        for (power, sum) in powers.iter_mut().enumerate() {
            for (stage, rate) in rates.iter().enumerate() {
                sum.q += rate.q * DP54_DENSE[stage][power];
                sum.dq += rate.dq * DP54_DENSE[stage][power];
            }
        }
        Self { start: *start, h, powers }
    }

    /// The motion at θ in [0, 1].
    #[inline]
    pub fn at(&self, theta: f64) -> Motion<N> {
        let [a, b, c, d] = &self.powers;
        let sum = |a: &Vector<N>, b, c, d: &Vector<N>| {
            let horner: Vector<N> = ((d * theta + c) * theta + b) * theta + a;
            horner * (theta * self.h)
        };
        let Motion { q, dq } = &self.start;
        Motion { q: q + sum(&a.q, b.q, c.q, &d.q), dq: dq + sum(&a.dq, b.dq, c.dq, &d.dq) }
    }
}

/// The rates (q̇, q̈) at the stages of one step.
pub type Rates<const N: usize, const S: usize> = [Motion<N>; S];

impl<const N: usize> Motion<N> {
    /// At rest in the origin.
    pub fn zeros() -> Self {
        Self { q: Vector::zeros(), dq: Vector::zeros() }
    }
}

impl<const N: usize, T: Real> Motion<N, T> {
    /// y + h Σ cᵢ kᵢ, position and velocity one after the other: in one sum, the compiler would
    /// read half of each as one register. That misses store forwarding when both were just written.
    #[inline(always)]
    pub fn plus(&self, h: f64, coefficients: &[f64], rates: &[Self]) -> Self {
        let Self { mut q, mut dq } = *self;
        for n in 0..N {
            let mut sum = q[n].like(0.0);
            for (c, rate) in coefficients.iter().zip(rates) {
                if *c != 0.0 {
                    sum += rate.q[n] * sum.like(*c);
                }
            }
            q[n] += sum * sum.like(h);
        }
        for n in 0..N {
            let mut sum = dq[n].like(0.0);
            for (c, rate) in coefficients.iter().zip(rates) {
                if *c != 0.0 {
                    sum += rate.dq[n] * sum.like(*c);
                }
            }
            dq[n] += sum * sum.like(h);
        }
        Self { q, dq }
    }
}

impl<const N: usize> Motion<N> {
    /// Root mean square of h Σ cᵢ kᵢ over atol + rtol max(|y|, |y'|), entry by entry.
    pub fn error(
        h: f64,
        coefficients: &[f64],
        rates: &[Self],
        ends: [&Self; 2],
        tolerance: Tolerance,
    ) -> f64 {
        let Self { q, dq } = Self::zeros().plus(h, coefficients, rates);
        let scaled = |error: f64, a: f64, b: f64| {
            let ratio = error / (tolerance.atol + tolerance.rtol * a.abs().max(b.abs()));
            ratio * ratio
        };
        let mut sum = 0.0;
        for n in 0..N {
            sum += scaled(q[n], ends[0].q[n], ends[1].q[n]);
            sum += scaled(dq[n], ends[0].dq[n], ends[1].dq[n]);
        }
        sqrt(sum / (2 * N) as f64)
    }
}

/// Relative and absolute tolerance of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Relative to the larger of both ends.
    pub rtol: f64,
    /// Absolute [rad, rad/s].
    pub atol: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { rtol: 1e-8, atol: 1e-10 }
    }
}

impl<const S: usize> Tableau<S> {
    /// Evaluates the stages from `first` on: `rates[i] = (q̇ᵢ, acceleration(stage, motion
    /// at the stage))`.
    #[inline(always)]
    pub fn stages<const N: usize, T: Real>(
        &self,
        h: f64,
        start: &Motion<N, T>,
        first: usize,
        rates: &mut [Motion<N, T>; S],
        mut acceleration: impl FnMut(&Stage<'_>, &Motion<N, T>) -> Vector<N, T>,
    ) {
        for i in first..S {
            let motion = self.at(i, h, start, rates);
            let ddq = acceleration(&self.stage(i, h), &motion);
            rates[i] = Motion { q: motion.dq, dq: ddq };
        }
    }

    /// The motion at stage i of a step of length `h` \[s\], from the rates at those before.
    #[inline(always)]
    pub fn at<const N: usize, T: Real>(
        &self,
        i: usize,
        h: f64,
        start: &Motion<N, T>,
        rates: &[Motion<N, T>; S],
    ) -> Motion<N, T> {
        start.plus(h, &self.rows[i][..i], &rates[..i])
    }

    /// Row i as a compensator wants it.
    #[inline]
    pub fn stage(&self, i: usize, h: f64) -> Stage<'_> {
        let (coefficients, nodes) = (&self.rows[i][..i], &self.nodes[..i]);
        Stage { index: i, step: h, node: self.nodes[i], coefficients, nodes }
    }

    /// The end of the step, made of the first `count` stages.
    #[inline]
    pub fn end(&self, h: f64, count: usize) -> Stage<'_> {
        let (coefficients, nodes) = (&self.weights[..count], &self.nodes[..count]);
        Stage { index: count, step: h, node: 1.0, coefficients, nodes }
    }
}
