//! The sampled loop of all joints together along a path, linearised: from sample to sample
//! `z⁺ = Φₖ z + Γₖ ρ_d`, with z = [e, ė, commands under way, r₋ and e₋ of a filter, ρ̂].
//!
//! ```text
//! hold:  [e; ė]⁺ = A_d [e; ė] + B_d δτ     exact for M δq̈ + D δq̇ + K δq = δτ over h
//! law:   δτ = M₀ (−K_v r − K_p e − ρ̂) + K₀ e + D₀ r
//! learn: ρ̂⁺ = e^(−λh) (ρ̂ + h k_I (p12 e + p22 r))       k_I = gain m |ξ|² at the point
//! rate:  r = ė, or through a filter e^(−2πfh) r₋ + (1 − e^(−2πfh)) (e − e₋)/h
//! ```
//!
//! The law's terms are taken when it samples, the arm's in the middle of the hold. Over a lap of
//! the path the loop grows by the spectral radius of the product of all Φₖ; per sample that is the
//! radius that [`SampledLoop::radius`] gives. At rest it is the spectral radius of Φ.

use nalgebra::{DMatrix, DVector};

use super::conditions::Conditions;
use super::course::{Course, POINTS};
use super::linear_model::filtering;
use crate::control::Gains;
use crate::eigen::{modulus, spectrum};
use crate::error::{Error, Result};
use crate::math::{Matrix, exp, ln};
use crate::riccati::JointSolution;

/// A radius this close to 1 is one of rounding: an integrator that is not driven.
const ROUNDING: f64 = 1e-12;
/// An entry this small, of a matrix whose largest is 1, is below the rounding of its eigenvalues.
const FAINT: f64 = 1e-18;
/// A joint whose integrator moves less than this in a sample is without one.
const DRIVEN: f64 = 1e-12;
/// The search for the longest period grows by this factor, so often, and then bisects so often.
const GROWTH: f64 = 1.25;
const STEPS: usize = 60;
const BISECTIONS: usize = 10;
/// Samples of a lap in the prediction of the error at the most, and laps; the last one counts.
const MOST_SAMPLES: f64 = 20_000.0;
const LAPS: usize = 3;
/// Terms of the exponential of a matrix of norm ½ at the most: the rest is below 1e-16.
const TERMS: usize = 14;

type Dynamic = DMatrix<f64>;

/// A longest period counts if the loop is stable at these shares of it too: what grows at short
/// periods does not grow for being sampled.
const SHORTER: [f64; 3] = [1.0 / 4.0, 1.0 / 16.0, 1.0 / 64.0];

/// What a compensator does to the loop: P, the integral gain at every point, and the leak.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Integrators<const N: usize> {
    pub p: [JointSolution; N],
    pub k_i: Vec<[f64; N]>,
    pub leak_rate: f64,
}

/// A point of the path as matrices of any size.
struct Place {
    /// [0 I 0; −M⁻¹K −M⁻¹D M⁻¹; 0 0 0]
    hold: Dynamic,
    /// K₀ − M₀K_p and D₀ − M₀K_v.
    feedback: [Dynamic; 2],
    /// M₀.
    mass: Dynamic,
    /// k_I of each joint.
    k_i: DVector<f64>,
    /// ρ_d.
    rho: DVector<f64>,
}

/// The loop.
pub(super) struct SampledLoop {
    joints: usize,
    delay: usize,
    velocity_filter: Option<f64>,
    duration: f64,
    leak_rate: f64,
    /// p12 and p22 of each joint.
    p: [Vec<f64>; 2],
    places: Vec<Place>,
}

/// A matrix times e^log.
struct Scaled {
    matrix: Dynamic,
    log: f64,
}

impl SampledLoop {
    /// The loop with these integrators, or of computed torque alone.
    pub fn new<const N: usize>(
        course: &Course<N>,
        gains: &Gains<N>,
        integrators: Option<&Integrators<N>>,
        conditions: &Conditions<'_>,
    ) -> Result<Self> {
        let dynamic = |m: &Matrix<N>| Dynamic::from_column_slice(N, N, m.as_slice());
        let mut places = Vec::with_capacity(course.points.len());
        for (k, point) in course.points.iter().enumerate() {
            let (nominal, actual) = (&point.nominal, &point.actual);
            let Some(inverse) = actual.mass.try_inverse() else {
                return Err(Error::not_positive("mass_matrix", f64::NAN, "positive definite"));
            };
            let mut hold = Dynamic::zeros(3 * N, 3 * N);
            hold.view_mut((0, N), (N, N)).fill_with_identity();
            hold.view_mut((N, 0), (N, N)).copy_from(&dynamic(&-(inverse * actual.stiffness)));
            hold.view_mut((N, N), (N, N)).copy_from(&dynamic(&-(inverse * actual.damping)));
            hold.view_mut((N, 2 * N), (N, N)).copy_from(&dynamic(&inverse));
            let times = |by: &[f64; N]| Matrix::from_fn(|i, j| nominal.mass[(i, j)] * by[j]);
            let on_e = nominal.stiffness - times(&gains.kp);
            let on_rate = nominal.damping - times(&gains.kv);
            let k_i = integrators.map_or([0.0; N], |it| it.k_i[k]);
            places.push(Place {
                hold,
                feedback: [dynamic(&on_e), dynamic(&on_rate)],
                mass: dynamic(&nominal.mass),
                k_i: DVector::from_column_slice(&k_i),
                rho: DVector::from_column_slice(point.rho.as_slice()),
            });
        }
        let p = integrators.map_or([JointSolution::default(); N], |it| it.p);
        Ok(Self {
            joints: N,
            delay: conditions.delay_samples,
            velocity_filter: conditions.velocity_filter,
            duration: course.duration,
            leak_rate: integrators.map_or(0.0, |it| it.leak_rate),
            p: [p.map(|p| p.p12).to_vec(), p.map(|p| p.p22).to_vec()],
            places,
        })
    }

    /// Growth per sample along the path, sampled with period `h` \[s\]; below 1 the loop is stable.
    pub fn radius(&self, h: f64) -> Result<f64> {
        let samples = (self.duration / h).round().max(1.0);
        let mut lap = Scaled { matrix: Dynamic::identity(self.order(), self.order()), log: 0.0 };
        let mut count = 0.0;
        if samples <= POINTS as f64 {
            for k in 0..samples as usize {
                lap = lap.after(&Scaled::new(self.step(k as f64 * h, h).0));
            }
            count = samples;
        } else {
            let repeated = (samples / POINTS as f64).round() as u64;
            for k in 0..POINTS {
                let time = self.duration * k as f64 / POINTS as f64;
                lap = lap.after(&Scaled::new(self.step(time, h).0).power(repeated));
                count += repeated as f64;
            }
        }
        // What the sums of a lap cannot tell from 0 would keep the iterations from ending.
        let values = spectrum(&lap.matrix.map(|x| if x.abs() < FAINT { 0.0 } else { x }))?;
        let largest = values.iter().fold(0.0, |most: f64, &z| most.max(modulus(z)));
        if largest == 0.0 {
            return Ok(0.0);
        }
        let radius = exp((ln(largest) + lap.log) / count);
        Ok(if (radius - 1.0).abs() < ROUNDING { 1.0 - ROUNDING } else { radius })
    }

    /// The longest period \[s\] below which the loop is stable, found from a first guess on; 0 if
    /// there is none.
    pub fn max_period(&self, guess: f64) -> Result<f64> {
        let stable = |h: f64| Ok::<_, Error>(self.radius(h)? < 1.0);
        let (mut good, mut bad) = (guess, guess);
        if stable(guess)? {
            for _ in 0..STEPS {
                bad = good * GROWTH;
                if !stable(bad)? {
                    break;
                }
                good = bad;
            }
        } else {
            for _ in 0..STEPS {
                good = bad / GROWTH;
                if stable(good)? {
                    break;
                }
                bad = good;
            }
            if bad == good {
                return Ok(0.0);
            }
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (good + bad);
            if stable(middle)? { good = middle } else { bad = middle }
        }
        for share in SHORTER {
            if !stable(share * good)? {
                return Ok(0.0);
            }
        }
        Ok(good)
    }

    /// Steady RMS of e of each joint \[rad\] along the path under ρ_d, infinite beyond `longest`,
    /// the longest stable period.
    pub fn rms(&self, control_period: f64, longest: f64) -> Vec<f64> {
        if control_period >= longest {
            return vec![f64::INFINITY; self.joints];
        }
        let coarse = self.duration / MOST_SAMPLES;
        let h = if coarse < longest / 10.0 { control_period.max(coarse) } else { control_period };
        let samples = (self.duration / h).round().clamp(1.0, MOST_SAMPLES) as usize;
        let steps: Vec<_> = (0..samples.min(POINTS))
            .map(|k| self.step(self.duration * k as f64 / samples.min(POINTS) as f64, h))
            .collect();
        let mut z = DVector::zeros(self.order());
        let mut sums = vec![0.0; self.joints];
        for lap in 0..LAPS {
            for k in 0..samples {
                let (step, push) = &steps[k * steps.len() / samples];
                z = step * z + push;
                if lap + 1 == LAPS {
                    sums.iter_mut().zip(z.iter()).for_each(|(sum, e)| *sum += e * e);
                }
            }
        }
        sums.iter().map(|sum| (sum / samples as f64).sqrt()).collect()
    }

    fn order(&self) -> usize {
        self.joints * (3 + self.delay + if self.velocity_filter.is_some() { 2 } else { 0 })
    }

    fn place(&self, time: f64) -> &Place {
        let lap = (time / self.duration).fract();
        &self.places[(lap * POINTS as f64) as usize % POINTS]
    }

    /// Φ of the sample at `time`, and Γ ρ_d.
    fn step(&self, time: f64, h: f64) -> (Dynamic, DVector<f64>) {
        let (n, size) = (self.joints, self.order());
        let rho = size - n;
        let (seen, moving) = (self.place(time), self.place(time + 0.5 * h));
        let hold = exponential(&(&moving.hold * h));
        let input = hold.view((0, 2 * n), (2 * n, n)).into_owned();
        let mut step = Dynamic::zeros(size, size);
        step.view_mut((0, 0), (2 * n, 2 * n)).copy_from(&hold.view((0, 0), (2 * n, 2 * n)));
        // Where the commands under way end, and what a filter keeps begins.
        let past = n * (2 + self.delay);
        // The velocity that the law has, of which states.
        let mut rate = vec![(n, 1.0)];
        if let Some(cut_off) = self.velocity_filter {
            let (kept, taken) = filtering(cut_off, h);
            rate = vec![(0, taken), (past, kept), (past + n, -taken)];
            for joint in 0..n {
                rate.iter().for_each(|(from, x)| step[(past + joint, from + joint)] = *x);
                step[(past + n + joint, joint)] = 1.0;
            }
        }
        let mut command = Dynamic::zeros(n, size);
        let [on_e, on_rate] = &seen.feedback;
        command.columns_mut(0, n).copy_from(on_e);
        for &(from, x) in &rate {
            let mut part = command.columns_mut(from, n);
            part += on_rate * x;
        }
        command.columns_mut(rho, n).copy_from(&-&seen.mass);
        if self.delay == 0 {
            let mut moved = step.rows_mut(0, 2 * n);
            moved += &input * &command;
        } else {
            step.view_mut((0, 2 * n), (2 * n, n)).copy_from(&input);
            for i in 2 * n..past - n {
                step[(i, i + n)] = 1.0;
            }
            step.rows_mut(past - n, n).copy_from(&command);
        }
        let keep = exp(-self.leak_rate * h);
        for joint in 0..n {
            let (row, drive) = (rho + joint, keep * h * seen.k_i[joint]);
            let on = [drive * self.p[0][joint], drive * self.p[1][joint]];
            if on[0] + on[1] > DRIVEN {
                step[(row, row)] = keep;
                step[(row, joint)] = on[0];
                rate.iter().for_each(|(from, x)| step[(row, from + joint)] += on[1] * x);
            }
        }
        let mut push = DVector::zeros(size);
        push.rows_mut(0, 2 * n).copy_from(&(input * (&moving.mass * &moving.rho)));
        (step, push)
    }
}

impl Scaled {
    fn new(matrix: Dynamic) -> Self {
        let largest = matrix.amax();
        if largest > 0.0 && largest.is_finite() {
            Self { matrix: matrix / largest, log: ln(largest) }
        } else {
            Self { matrix, log: 0.0 }
        }
    }

    /// This one after another.
    fn after(&self, other: &Self) -> Self {
        let product = Self::new(&other.matrix * &self.matrix);
        Self { log: product.log + self.log + other.log, ..product }
    }

    fn power(self, mut exponent: u64) -> Self {
        let size = self.matrix.nrows();
        let mut result = Self { matrix: Dynamic::identity(size, size), log: 0.0 };
        let mut base = self;
        while exponent > 0 {
            if exponent & 1 == 1 {
                result = result.after(&base);
            }
            base = base.after(&base);
            exponent >>= 1;
        }
        result
    }
}

/// e^a, by scaling and squaring.
fn exponential(a: &Dynamic) -> Dynamic {
    let size = a.nrows();
    let norm = a.row_iter().map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max);
    let halvings = if norm > 0.5 { libm::ceil(libm::log2(norm / 0.5)) as i32 } else { 0 };
    let small = a / libm::exp2(f64::from(halvings));
    let mut term = Dynamic::identity(size, size);
    let mut sum = term.clone();
    for k in 1..=TERMS {
        term = &term * &small / k as f64;
        sum += &term;
    }
    for _ in 0..halvings {
        sum = &sum * &sum;
    }
    sum
}
