//! Choices that do nothing, or ruin it: one list, for the report and for every simulation.

use super::course::Course;
use super::learning::diagonals;
use super::spectrum::Signals;
use super::{Finding, Subject};
use crate::control::{Gains, Sample, Signal};
use crate::error::Result;
use crate::math::{Vector, sqrt};

/// A start farther from the path than this is far \[rad, m\].
const FAR: f64 = 1.0;
/// A share of the effort limit that unknown friction has at least, and the bend \[rad\] under it
/// that is too much.
const FRICTION: f64 = 0.01;
const BEND: f64 = 0.5;
/// Stiffness of a joint, over that of the stiffest one, where no effort limit is known.
const STIFFEST: f64 = 1e-3;
/// Damping ratio above which k_p and k_v look swapped, and range of it that is usual.
const CREEPING: f64 = 3.0;
const USUAL: core::ops::RangeInclusive<f64> = 0.3..=CREEPING;
/// An input is off its centres where it is so many widths from the next one …
const WIDTHS: f64 = 2.0;
/// … for more than this share of the path.
const OFF: f64 = 0.2;
/// Limits are held against what is needed up to rounding.
const ROUNDING: f64 = 1e-9;

/// What was chosen.
pub struct Choices<'a, const N: usize> {
    /// Feedback gains.
    pub gains: &'a Gains<N>,
    /// The compensator, if there is one.
    pub compensator: Option<&'a dyn Subject<N>>,
    /// k_p M₀ⱼⱼ, the smallest that is known [N·m/rad].
    pub stiffness: [f64; N],
    /// Effort limit of each joint, of the arm, the plant and the controller; infinite for none.
    pub effort_limit: [f64; N],
    /// The path, if it is known.
    pub course: Option<&'a Course<N>>,
    /// What the compensator sees at the start of a run.
    pub start: Option<Sample<N>>,
}

impl<const N: usize> Choices<'_, N> {
    /// Those that do nothing, or ruin it.
    ///
    /// # Errors
    /// As `LinearModel::gain_at`.
    pub fn findings(&self) -> Result<Vec<Finding>> {
        let mut found: Vec<Finding> = (0..N).filter_map(|joint| self.swapped(joint)).collect();
        found.extend(self.far_start());
        let Some(course) = self.course else { return Ok(found) };
        found.extend((0..N).filter_map(|joint| weak_effort(course, joint)));
        if let Some(subject) = self.compensator {
            found.extend(off_centers(subject, course));
            found.extend(self.small_dictionary(subject, course));
            if course.measured {
                found.extend(self.dead_zone(subject, course)?);
                found.extend(small_ball(subject, course)?);
            }
        }
        Ok(found)
    }

    fn swapped(&self, joint: usize) -> Option<Finding> {
        let (kp, kv) = (self.gains.kp[joint], self.gains.kv[joint]);
        let damping = |kp: f64, kv: f64| 0.5 * kv / sqrt(kp);
        let swapped = damping(kp, kv) > CREEPING && USUAL.contains(&damping(kv, kp));
        swapped.then_some(Finding::Swapped { joint, kp, kv })
    }

    /// Joints that are hardly held. A run shows nothing of it where no friction is modelled: a
    /// report alone says so.
    pub(super) fn weak(&self) -> impl Iterator<Item = Finding> {
        (0..N).filter_map(|joint| self.weak_joint(joint))
    }

    fn weak_joint(&self, joint: usize) -> Option<Finding> {
        let (stiffness, effort_limit) = (self.stiffness[joint], self.effort_limit[joint]);
        let weak = if effort_limit.is_finite() {
            FRICTION * effort_limit > BEND * stiffness
        } else {
            stiffness < STIFFEST * self.stiffness.iter().copied().fold(0.0, f64::max)
        };
        weak.then_some(Finding::Weak { joint, stiffness, effort_limit })
    }

    fn far_start(&self) -> Option<Finding> {
        let e = self.start?.e;
        let joint = e.iamax();
        let distance = e[joint].abs();
        (distance > FAR * (1.0 + ROUNDING)).then_some(Finding::FarStart { joint, distance })
    }

    fn small_dictionary(&self, subject: &dyn Subject<N>, course: &Course<N>) -> Option<Finding> {
        let (parameters, wanted) = subject.dictionary(&self.seen(course))?;
        let capacity = parameters.capacity;
        (wanted > capacity).then_some(Finding::SmallDictionary { capacity })
    }

    /// What the rules see along the path before anything is learnt: with the error of computed
    /// torque alone, which is slowly ρ_d/k_p.
    fn seen(&self, course: &Course<N>) -> Vec<Sample<N>> {
        let last = course.points.len() - 1;
        let (fine, dt) = (course.fine.len() / (last + 1), course.duration / (last + 1) as f64);
        let known = if course.measured { 1.0 } else { 0.0 };
        let err = |(k, sample): (usize, &Sample<N>)| {
            let (from, share) = (k / fine, (k % fine) as f64 / fine as f64);
            let [rho, next] = [from, last.min(from + 1)].map(|it| course.points[it].rho);
            let over_kp = |it: Vector<N>| Vector::from_fn(|n, _| known * it[n] / self.gains.kp[n]);
            let (e, de) = (over_kp(rho.lerp(&next, share)), over_kp((next - rho) / dt));
            Sample { q: sample.q + e, dq: sample.dq + de, e, de, ..*sample }
        };
        course.fine.iter().enumerate().map(err).collect()
    }

    fn dead_zone(&self, subject: &dyn Subject<N>, course: &Course<N>) -> Result<Option<Finding>> {
        let dead_zone = subject.parameters().adaptation.dead_zone;
        if dead_zone == 0.0 {
            return Ok(None);
        }
        let signal = Signals::new(subject, self.gains, course).alone()?;
        Ok((dead_zone >= signal).then_some(Finding::DeadZone { dead_zone, signal }))
    }
}

const GRAVITY: &str = "gravity alone";

fn weak_effort<const N: usize>(course: &Course<N>, joint: usize) -> Option<Finding> {
    let limit = course.effort_limit[joint];
    let largest = |value: fn(&super::Local<N>) -> &Vector<N>| {
        course.points.iter().fold(0.0, |most: f64, it| most.max(value(&it.actual)[joint].abs()))
    };
    let needs = [(largest(|it| &it.gravity), GRAVITY), (largest(|it| &it.torque), "the path")];
    let (need, taken_by) = needs.into_iter().find(|(need, _)| *need > limit * (1.0 + ROUNDING))?;
    let sags = taken_by == GRAVITY;
    Some(Finding::WeakEffort { joint, sags, limit, need, taken_by })
}

/// The worst joint of every signal.
fn off_centers<const N: usize>(
    subject: &dyn Subject<N>,
    course: &Course<N>,
) -> impl Iterator<Item = Finding> {
    let (inputs, reaches) = (subject.parameters().inputs, subject.reaches());
    let samples = course.samples();
    let runs: Vec<Vec<f64>> = samples
        .iter()
        .map(|sample| {
            let mut x = vec![0.0; reaches.len()];
            inputs.gather(sample, &mut x);
            x
        })
        .collect();
    let signals: Vec<Signal> = inputs.signals().iter().map(|(signal, _)| *signal).collect();
    signals.into_iter().enumerate().filter_map(move |(k, signal)| {
        let off = |joint: &usize| {
            let sets = &reaches[k * N + joint];
            let far =
                |x: f64| sets.iter().all(|(center, width)| (x - center).abs() > WIDTHS * width);
            runs.iter().filter(|x| far(x[k * N + joint])).count()
        };
        let joint = (0..N).max_by_key(off)?;
        (off(&joint) as f64 > OFF * runs.len() as f64).then(|| Finding::OffCenters {
            signal: signal.name(),
            joint,
            runs: range(runs.iter().map(|x| x[k * N + joint])),
            centers: range(reaches[k * N + joint].iter().map(|(center, _)| *center)),
        })
    })
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, -f64::INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// |Wₙ| ≥ |ρ_d,n| / |ξ| at every point.
fn small_ball<const N: usize>(
    subject: &dyn Subject<N>,
    course: &Course<N>,
) -> Result<Option<Finding>> {
    let radius = subject.parameters().adaptation.projection_radius;
    if radius.is_infinite() {
        return Ok(None);
    }
    let products = subject.products(&course.samples())?;
    let need =
        course.points.iter().zip(diagonals(&products)).map(|(point, xi_squared): (_, [f64; N])| {
            let squares = (0..N).filter(|&n| xi_squared[n] > f64::MIN_POSITIVE);
            sqrt(squares.map(|n| point.rho[n] * point.rho[n] / xi_squared[n]).sum())
        });
    let need = need.fold(0.0, f64::max);
    Ok((need > radius).then_some(Finding::SmallBall { radius, need }))
}
