//! Any law behind one type, for a tracker: computed torque, compiled as one; another law behind a
//! pointer; a controller of one's own, a Python object.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use pyo3::PyTraverseError;
use pyo3::exceptions::PyTypeError;
use pyo3::gc::PyVisit;
use pyo3::prelude::*;

use super::any_arm::AnyArm;
use super::convert::{array1, type_name, vector};
use crate::arm::{Arm, JointFriction, Side};
use crate::control::{Beliefs, BoxedLaw, ComputedTorque, Demand, Gains, Law, Sample};
use crate::math::{Matrix, Vector};

/// Any law of an arm of `N` joints.
pub(super) enum AnyLaw<const N: usize> {
    Computed(ComputedTorque<N, AnyArm<N>>),
    Other(AnyArm<N>, BoxedLaw<N>),
    Own(AnyArm<N>, Own),
}

impl<const N: usize> AnyLaw<N> {
    /// What it believes of the arm.
    pub fn arm(&self) -> &AnyArm<N> {
        match self {
            Self::Computed(law) => &law.arm,
            Self::Other(arm, _) | Self::Own(arm, _) => arm,
        }
    }

    /// It, as computed torque with constant gains.
    pub fn computed(&self) -> PyResult<&ComputedTorque<N, AnyArm<N>>> {
        match self {
            Self::Computed(law) => Ok(law),
            _ => Err(PyTypeError::new_err(
                "tracker: got a controller with another law, wants a ComputedTorque",
            )),
        }
    }

    /// Tells a controller of one's own the period of its next torque \[s\].
    pub fn tell(&self, period: f64) {
        if let Self::Own(_, own) = self {
            own.period.store(period.to_bits(), Ordering::Relaxed);
        }
    }

    /// Whether a controller of one's own has raised something.
    pub fn has_raised(&self) -> bool {
        let Self::Own(_, own) = self else { return false };
        own.raised.lock().is_ok_and(|raised| raised.is_some())
    }

    /// What a controller of one's own raised, if it did; it is forgotten here.
    pub fn raised(&self) -> Option<PyErr> {
        if let Self::Own(_, own) = self { own.raised.lock().ok()?.take() } else { None }
    }

    /// Resets a controller of one's own by its method of that name.
    pub fn reset(&self) -> PyResult<()> {
        let Self::Own(_, own) = self else { return Ok(()) };
        if let Ok(mut raised) = own.raised.lock() {
            raised.take();
        }
        Python::attach(|py| {
            let controller = own.controller.bind(py);
            if controller.hasattr("reset")? {
                return controller.call_method0("reset").map(drop);
            }
            let message = "law: a controller of your own without a method reset() cannot be reset; \
                           give it one, or make a new one";
            Err(PyTypeError::new_err(message))
        })
    }

    /// Refuses a controller of one's own, of which nobody knows here what it remembers.
    pub fn saves(&self) -> PyResult<()> {
        if let Self::Own(..) = self {
            let message = "law: nobody but you knows what a controller of your own remembers; \
                           pickle it, or save what is in it yourself";
            return Err(PyTypeError::new_err(message));
        }
        Ok(())
    }

    /// Shows the objects of Python in it to the garbage collector.
    pub fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        if let Self::Own(_, own) = self { visit.call(&own.controller) } else { Ok(()) }
    }
}

impl<const N: usize> Law<N> for AnyLaw<N> {
    fn model(&self) -> Option<Side<'_, N>> {
        match self {
            Self::Computed(law) => law.model(),
            Self::Other(_, law) => law.model(),
            Self::Own(..) => None,
        }
    }

    fn torque_by(
        &self,
        dynamics: &(Matrix<N>, Vector<N>),
        seen: &Sample<N>,
        rho_hat: &Vector<N>,
    ) -> Demand<N> {
        match self {
            Self::Computed(law) => law.torque_by(dynamics, seen, rho_hat),
            Self::Other(_, law) => law.torque_by(dynamics, seen, rho_hat),
            Self::Own(_, own) => own.torque(seen),
        }
    }

    fn constant_gains(&self) -> Option<&Gains<N>> {
        match self {
            Self::Computed(law) => law.constant_gains(),
            Self::Other(_, law) => law.constant_gains(),
            Self::Own(..) => None,
        }
    }

    fn beliefs(&self) -> Option<Beliefs<'_, N>> {
        if let Self::Other(_, law) = self { law.beliefs() } else { None }
    }

    #[inline(always)]
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> Demand<N> {
        match self {
            Self::Computed(law) => law.torque(seen, rho_hat),
            Self::Other(_, law) => law.torque(seen, rho_hat),
            Self::Own(_, own) => own.torque(seen),
        }
    }

    fn resting_torque(&self, q: &Vector<N>) -> Vector<N> {
        self.arm().gravity(q)
    }

    fn inertia_torque(&self, q: &Vector<N>, acceleration: &Vector<N>) -> Vector<N> {
        self.arm().mass_matrix(q) * acceleration
    }

    fn joint_friction(&self, joint: usize) -> JointFriction {
        match self {
            Self::Computed(law) => law.joint_friction(joint),
            Self::Other(_, law) => law.joint_friction(joint),
            Self::Own(..) => JointFriction::default(),
        }
    }

    #[inline]
    fn wraps(&self) -> [bool; N] {
        self.arm().wraps()
    }

    fn fingerprint(&self) -> u64 {
        match self {
            Self::Computed(law) => law.fingerprint(),
            Self::Other(_, law) => law.fingerprint(),
            Self::Own(arm, _) => arm.fingerprint(),
        }
    }

    fn tuning(&self) -> u64 {
        match self {
            Self::Computed(law) => law.tuning(),
            Self::Other(_, law) => law.tuning(),
            Self::Own(..) => 0,
        }
    }
}

/// A controller of one's own: a Python object with `step`. What it raises is kept, and the loop
/// sees NaN.
pub(super) struct Own {
    controller: Py<PyAny>,
    /// The bits of the period that a torque is for \[s\], which it is told.
    period: AtomicU64,
    raised: Mutex<Option<PyErr>>,
}

impl Own {
    /// The controller, to be told this period.
    pub fn new(controller: &Bound<'_, PyAny>, period: f64) -> PyResult<Self> {
        if !controller.getattr("step").is_ok_and(|step| step.is_callable()) {
            let message = format!(
                "law: got {}, wants an object with a method step(q, dq, q_d, dq_d, ddq_d, dt)",
                type_name(controller)
            );
            return Err(PyTypeError::new_err(message));
        }
        let period = AtomicU64::new(period.to_bits());
        Ok(Self { controller: controller.clone().unbind(), period, raised: Mutex::new(None) })
    }

    fn torque<const N: usize>(&self, seen: &Sample<N>) -> Demand<N> {
        let lost = self.raised.lock().map_or(true, |raised| raised.is_some());
        let tau = if lost { Vector::repeat(f64::NAN) } else { self.asked(seen) };
        Demand { model: tau, compensation: Vector::zeros(), v: seen.desired.ddq }
    }

    fn asked<const N: usize>(&self, seen: &Sample<N>) -> Vector<N> {
        Python::attach(|py| {
            let row = |x: &Vector<N>| array1(py, x.as_slice());
            let Sample { q, dq, desired, .. } = seen;
            let given = (
                row(q),
                row(dq),
                row(&desired.q),
                row(&desired.dq),
                row(&desired.ddq),
                f64::from_bits(self.period.load(Ordering::Relaxed)),
            );
            let tau = self.controller.bind(py).call_method1("step", given);
            let tau = tau.and_then(|tau| vector::<N>(&tau, "step"));
            let known = |tau: &Vector<N>| tau.iter().all(|x| x.is_finite());
            let tau = tau.map(|tau| if known(&tau) { tau } else { Vector::repeat(f64::NAN) });
            tau.unwrap_or_else(|error| {
                if let Ok(mut raised) = self.raised.lock() {
                    raised.get_or_insert(error);
                }
                Vector::repeat(f64::NAN)
            })
        })
    }
}
