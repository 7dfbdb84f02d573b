//! A path with the arms along it: what the loop meets at every point, linearised.
//!
//! ```text
//! M δq̈ + D δq̇ + K δq = δτ      K = ∂/∂q, D = ∂/∂q̇ of M q̈ + C q̇ + G + b q̇ at the set-point
//! ρ_d = M₀⁻¹[(M₀ q̈_d + H₀) − (M q̈_d + H) − τ_d]
//! ```
//!
//! The symbols with 0 are those of the nominal arm. Dry friction and stops are in ρ_d, but not in
//! K and D.

use crate::arm::Arm;
use crate::control::Sample;
use crate::error::{Error, Result, finite, positive};
use crate::math::{Matrix, Vector};
use crate::plant::{Disturbance, Plant};
use crate::reference::{Reference, Setpoint};

/// Points along a path, evenly spaced in time; the end is left out.
pub(super) const POINTS: usize = 64;

/// Points at which a dictionary is tried.
const FINE: usize = 1024;

/// Steps of the differences \[rad\] or [rad/s]: the truncation error of K and D is below 1e-8 of
/// their curvature.
const STEP: f64 = 1e-4;

/// An arm near a point of the path.
#[derive(Clone, Copy, Debug)]
pub struct Local<const N: usize> {
    /// M [kg·m²].
    pub mass: Matrix<N>,
    /// K [N·m/rad].
    pub stiffness: Matrix<N>,
    /// D [N·m·s/rad].
    pub damping: Matrix<N>,
    /// The torque that the motion takes, without stops [N·m].
    pub torque: Vector<N>,
    /// Its part G(q) [N·m].
    pub gravity: Vector<N>,
}

impl<const N: usize> Local<N> {
    fn of<A: Arm<N>>(arm: &A, at: &Setpoint<N>) -> Self {
        let Setpoint { q, dq, ddq } = at;
        let viscous = Vector::<N>::from_fn(|joint, _| arm.joint_friction(joint).viscous);
        let smooth = |q: &Vector<N>, dq: &Vector<N>| {
            arm.mass_matrix(q) * ddq + arm.rigid_bias(q, dq) + viscous.component_mul(dq)
        };
        let unit = |joint: usize| Vector::from_fn(|i, _| if i == joint { STEP } else { 0.0 });
        let (mut stiffness, mut damping) = (Matrix::<N>::zeros(), Matrix::<N>::zeros());
        for joint in 0..N {
            let d = unit(joint);
            let along_q = (smooth(&(q + d), dq) - smooth(&(q - d), dq)) / (2.0 * STEP);
            let along_dq = (smooth(q, &(dq + d)) - smooth(q, &(dq - d))) / (2.0 * STEP);
            stiffness.set_column(joint, &along_q);
            damping.set_column(joint, &along_dq);
        }
        let mass = arm.mass_matrix(q);
        let torque = mass * ddq + arm.bias(q, dq);
        Self { mass, stiffness, damping, torque, gravity: arm.gravity(q) }
    }

    /// The same arm, all of it `times` as heavy.
    fn times(&self, times: f64) -> Self {
        let Self { mass, stiffness, damping, torque, gravity } = *self;
        Self {
            mass: mass * times,
            stiffness: stiffness * times,
            damping: damping * times,
            torque: torque * times,
            gravity: gravity * times,
        }
    }
}

/// A point of the path.
#[derive(Clone, Copy, Debug)]
pub struct Point<const N: usize> {
    /// When the reference is there \[s\].
    pub time: f64,
    /// What a controller without error sees there.
    pub sample: Sample<N>,
    /// The arm that the controller believes in.
    pub nominal: Local<N>,
    /// The arm that is there.
    pub actual: Local<N>,
    /// ρ_d, what the model leaves out there [rad/s²].
    pub rho: Vector<N>,
}

/// A path with both arms along it.
#[derive(Clone, Debug)]
pub struct Course<const N: usize> {
    /// Evenly spaced in time; the end of the path is left out, as where it begins anew.
    pub points: Vec<Point<N>>,
    /// Duration of the path \[s\].
    pub duration: f64,
    /// The largest torque of each joint, of the controller's limit and the plant's [N·m].
    pub effort_limit: [f64; N],
    /// Whether the plant was given: without it ρ_d is not known.
    pub measured: bool,
    /// What a controller without error sees along the path, in finer steps.
    pub fine: Vec<Sample<N>>,
}

impl<const N: usize> Course<N> {
    /// The path of `reference` over `duration` \[s\], with the arm that is there.
    ///
    /// # Errors
    /// `duration`: not > 0. `path`: a set-point, or the torque that it takes, is not finite.
    pub fn new<A: Arm<N>, B: Arm<N>, D: Disturbance<N>>(
        nominal: &A,
        plant: &Plant<N, B, D>,
        reference: &impl Reference<N>,
        duration: f64,
    ) -> Result<Self> {
        let arms = |at: &Setpoint<N>, time: f64| {
            let disturbance = plant.disturbance.torque(&at.q, &at.dq, time);
            (Local::of(nominal, at), Local::of(&plant.arm, at), disturbance)
        };
        Self::of(reference, duration, *plant.effort_limit(), true, arms)
    }

    /// The path alone: the arm that is there is the nominal one, or all of it
    /// 1/`inertia_ratio` as heavy.
    ///
    /// # Errors
    /// As [`new`](Self::new), and `inertia_ratio`: not > 0.
    pub fn believed<A: Arm<N>>(
        nominal: &A,
        inertia_ratio: f64,
        reference: &impl Reference<N>,
        duration: f64,
    ) -> Result<Self> {
        positive("inertia_ratio", &[inertia_ratio])?;
        let arms = |at: &Setpoint<N>, _: f64| {
            let local = Local::of(nominal, at);
            (local, local.times(1.0 / inertia_ratio), Vector::zeros())
        };
        Self::of(reference, duration, [f64::INFINITY; N], false, arms)
    }

    fn of(
        reference: &impl Reference<N>,
        duration: f64,
        effort_limit: [f64; N],
        measured: bool,
        arms: impl Fn(&Setpoint<N>, f64) -> (Local<N>, Local<N>, Vector<N>),
    ) -> Result<Self> {
        positive("duration", &[duration])?;
        let mut points = Vec::with_capacity(POINTS);
        for k in 0..POINTS {
            let time = duration * k as f64 / POINTS as f64;
            let desired = reference.at(time);
            let Setpoint { q, dq, ddq } = desired;
            for values in [&q, &dq, &ddq] {
                finite("path", values.as_slice())?;
            }
            let (nominal, actual, disturbance) = arms(&desired, time);
            let missing = nominal.torque - actual.torque - disturbance;
            let Some(factor) = nominal.mass.cholesky() else {
                return Err(Error::not_positive("mass_matrix", f64::NAN, "positive definite"));
            };
            let rho = factor.solve(&missing);
            finite("path", actual.torque.as_slice())?;
            finite("path", rho.as_slice())?;
            let sample = Sample::new(q, dq, desired);
            points.push(Point { time, sample, nominal, actual, rho });
        }
        let fine = (0..FINE).map(|k| {
            let desired = reference.at(duration * k as f64 / FINE as f64);
            Sample::new(desired.q, desired.dq, desired)
        });
        Ok(Self { points, duration, effort_limit, measured, fine: fine.collect() })
    }

    /// Also limited by the controller.
    pub fn limited(mut self, effort_limit: &[f64; N]) -> Self {
        for (known, other) in self.effort_limit.iter_mut().zip(effort_limit) {
            *known = known.min(*other);
        }
        self
    }

    /// G of joint `n`, nominal over true inertia: the mean of (M⁻¹M₀)ⱼⱼ.
    pub fn ratio(&self, n: usize) -> f64 {
        let ratios = self.points.iter().filter_map(|point| {
            Some((point.actual.mass.try_inverse()? * point.nominal.mass)[(n, n)])
        });
        ratios.sum::<f64>() / self.points.len() as f64
    }

    /// What the points see.
    pub fn samples(&self) -> Vec<Sample<N>> {
        self.points.iter().map(|point| point.sample).collect()
    }
}

/// What a controller without error sees in the origin.
pub(super) fn at_rest<const N: usize>() -> Sample<N> {
    let zeros = Vector::zeros();
    Sample::new(zeros, zeros, Setpoint::at_rest(zeros))
}
