//! Base of the classes that are nothing but their arguments: equality, hash, repr, pickling and a
//! copy with changes, once for all of them.

use core::any::Any as Type;
use core::fmt::Debug;
use core::hash::{BuildHasher, BuildHasherDefault};
use std::hash::DefaultHasher;
use std::sync::Arc;

use pyo3::gc::PyVisit;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple, PyType};
use pyo3::{IntoPyObjectExt, PyClass, PyTraverseError};

use crate::scenario::{
    BasisSettings, CompensatorSettings, ControllerSettings, CurveSettings, EffectsSettings,
    InputSettings, MethodName, NoiseSettings, Numbers, PerJoint, PulsesSettings, QuinticSettings,
    Rules, RunSettings, ShapeName, SinesSettings, TableSettings, TwoLinkSettings,
    WaypointsSettings,
};

/// Lists with more entries are shown by their first and last.
const LONGEST_SHOWN: usize = 12;

/// What an object is made of, as the arguments of its class.
pub(super) trait Form: Send + Sync {
    /// The arguments by name, in the order of the constructor.
    fn arguments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>>;

    /// Whether both are of one kind and the same.
    fn same(&self, py: Python<'_>, other: &dyn Form) -> PyResult<bool>;

    /// Equal for what is the same.
    fn hash(&self, py: Python<'_>) -> PyResult<isize>;

    /// Shows the objects of Python in it to the garbage collector.
    fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError>;

    fn as_any(&self) -> &dyn Type;
}

/// Fields by name; what is a class of its own as an object of it.
pub(super) trait Fields {
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>>;
}

impl<T: Fields + Debug + PartialEq + Send + Sync + 'static> Form for T {
    fn arguments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.fields(py)
    }

    fn same(&self, _: Python<'_>, other: &dyn Form) -> PyResult<bool> {
        Ok(other.as_any().downcast_ref::<T>().is_some_and(|other| self == other))
    }

    fn hash(&self, _: Python<'_>) -> PyResult<isize> {
        // Zero has two signs, which are equal.
        let words = format!("{self:?}").replace("-0.0", "0.0");
        Ok(BuildHasherDefault::<DefaultHasher>::default().hash_one(words) as isize)
    }

    fn traverse(&self, _: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        Ok(())
    }

    fn as_any(&self) -> &dyn Type {
        self
    }
}

/// Arguments of which some are objects of Python: these say what is equal, and how it is hashed.
pub(super) struct Objects {
    names: &'static [&'static str],
    pub values: Py<PyTuple>,
}

impl Objects {
    /// `values`: a tuple, an entry a name; lists in it become tuples, which nobody can change.
    pub fn new<'py, T>(py: Python<'py>, names: &'static [&'static str], values: T) -> PyResult<Self>
    where
        T: IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
    {
        let values = values.into_pyobject(py)?;
        let fixed = values.iter().map(|value| match value.cast_exact::<PyList>() {
            Ok(list) => list.to_tuple().into_any(),
            Err(_) => value,
        });
        Ok(Self { names, values: PyTuple::new(py, fixed.collect::<Vec<_>>())?.unbind() })
    }

    pub fn clone_ref(&self, py: Python<'_>) -> Self {
        Self { names: self.names, values: self.values.clone_ref(py) }
    }

    /// An argument by its place.
    pub fn get<'py>(&self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyAny>> {
        self.values.bind(py).get_item(place)
    }
}

impl Form for Objects {
    fn arguments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let arguments = PyDict::new(py);
        let mut pairs = self.names.iter().zip(self.values.bind(py));
        pairs.try_for_each(|(name, value)| arguments.set_item(name, value))?;
        Ok(arguments)
    }

    fn same(&self, py: Python<'_>, other: &dyn Form) -> PyResult<bool> {
        let Some(other) = other.as_any().downcast_ref::<Self>() else { return Ok(false) };
        Ok(self.names == other.names && self.values.bind(py).eq(&other.values)?)
    }

    fn hash(&self, py: Python<'_>) -> PyResult<isize> {
        self.values.bind(py).hash()
    }

    fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.values)
    }

    fn as_any(&self) -> &dyn Type {
        self
    }
}

/// Limits as an argument: one a joint, or `None` where there are none.
pub(super) fn limits(values: &[f64]) -> Option<Vec<f64>> {
    values.iter().any(|limit| limit.is_finite()).then(|| values.to_vec())
}

/// What is nothing but its arguments: two are equal, with one hash, when these are.
///
/// ``copy.replace(it, argument=value)``, or before Python 3.13 ``it.__replace__(argument=value)``,
/// is a copy with other arguments. It can be pickled; its repr shows every argument, long lists by
/// their first and last entry.
#[pyclass(name = "Settings", module = "steadyarm", subclass, frozen)]
pub(super) struct PyForm(Arc<dyn Form>);

/// A new object of a class.
pub(super) struct New<T: PyClass>(pub PyClassInitializer<T>);

impl<'py, T: PyClass> IntoPyObject<'py> for New<T> {
    type Target = T;
    type Output = Bound<'py, T>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Bound<'py, T>> {
        Bound::new(py, self.0)
    }
}

impl PyForm {
    /// A class, above its settings.
    pub fn under<T>(settings: Arc<impl Form + 'static>, class: T) -> PyClassInitializer<T>
    where
        T: PyClass<BaseType = Self>,
    {
        PyClassInitializer::from(Self(settings)).add_subclass(class)
    }
}

#[pymethods]
impl PyForm {
    fn __eq__(&self, other: &Bound<'_, Self>) -> PyResult<bool> {
        self.0.same(other.py(), &*other.get().0)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.0.hash(py)
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        shown(slf, &*slf.get().0)
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyType>, Bound<'py, PyTuple>)> {
        Ok((slf.get_type(), values(slf)?))
    }

    /// A copy with other values of these arguments.
    #[pyo3(signature = (**changes))]
    fn __replace__<'py>(
        slf: &Bound<'py, Self>,
        changes: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        replaced(slf, &*slf.get().0, changes)
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.0.traverse(&visit)
    }
}

/// The arguments alone, in the order of the constructor.
pub(super) fn values<'py>(object: &Bound<'py, PyForm>) -> PyResult<Bound<'py, PyTuple>> {
    Ok(object.get().0.arguments(object.py())?.values().to_tuple())
}

/// The call that makes the object.
pub(super) fn shown(object: &Bound<'_, PyAny>, form: &dyn Form) -> PyResult<String> {
    let mut shown = Vec::new();
    for (name, value) in form.arguments(object.py())? {
        shown.push(format!("{name}={}", short(&value)?));
    }
    Ok(format!("{}({})", object.get_type().name()?, shown.join(", ")))
}

/// A copy of an object, and of all that is in it.
pub(super) fn deep_copy<'py>(object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    object.py().import("copy")?.call_method1("deepcopy", (object,))
}

/// An object of the same class with other arguments.
pub(super) fn replaced<'py>(
    object: &Bound<'py, PyAny>,
    form: &dyn Form,
    changes: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let arguments = form.arguments(object.py())?;
    if let Some(changes) = changes {
        arguments.update(changes.as_mapping())?;
    }
    object.get_type().call((), Some(&arguments))
}

fn short(value: &Bound<'_, PyAny>) -> PyResult<String> {
    match value.cast::<PyList>() {
        Ok(list) if list.len() > LONGEST_SHOWN => {
            let (first, last) = (list.get_item(0)?.repr()?, list.get_item(list.len() - 1)?.repr()?);
            Ok(format!("[{first}, ..., {last}]"))
        }
        _ => Ok(value.repr()?.to_string()),
    }
}

/// Settings by their fields, in the order of the constructor. A field that is missing here does not
/// compile.
macro_rules! fields {
    ($($settings:ident { $($name:ident),* $(,)? })*) => {$(
        impl Fields for $settings {
            fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
                let Self { $($name),* } = self;
                let fields = PyDict::new(py);
                $(fields.set_item(stringify!($name), $name)?;)*
                Ok(fields)
            }
        }
    )*};
}

pub(super) use fields;

fields! {
    BasisSettings { form, centers, width, normalized, inputs, joints }
    CompensatorSettings {
        basis, q, gain, gamma, leak_rate, error_modification, projection_radius, dead_zone,
        normalization, dictionary, merge_tolerance,
    }
    EffectsSettings {
        encoder_bits, noise, velocity, velocity_noise, velocity_cutoff, velocity_bandwidth,
        velocity_acceleration, delay, jitter, drop, effort_rate_limit, gain, lag, cogging,
        cogging_per_turn, joint_stiffness, joint_damping, rotor_inertia, backlash, encoder_side,
        seed,
    }
    ControllerSettings { kp, kv, effort_limit, effort_rate_limit }
    NoiseSettings { deviation, cutoff, seed }
    PulsesSettings { time, torque, duration, shape }
    QuinticSettings { start, goal, duration, start_time }
    RunSettings { duration, dt, method, control_period, q0, dq0, rtol, atol }
    SinesSettings { frequency, sin, cos, offset, start_time }
    TableSettings { t, q, dq, ddq, start_time }
    WaypointsSettings { poses, velocity, acceleration, jerk, pause, start_time }
    TwoLinkSettings { mass, length, inertia, gravity, viscous, coulomb, smoothing }
}

impl Fields for CurveSettings {
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match self {
            Self::Sines(sines) => sines.fields(py),
            Self::Quintic(quintic) => quintic.fields(py),
            Self::Table(table) => table.fields(py),
            Self::Waypoints(waypoints) => waypoints.fields(py),
        }
    }
}

/// Values of fields, by `$body`.
macro_rules! as_objects {
    ($($settings:ty, $it:ident, $py:ident => $body:expr;)*) => {$(
        impl<'py> IntoPyObject<'py> for &$settings {
            type Target = PyAny;
            type Output = Bound<'py, PyAny>;
            type Error = PyErr;

            fn into_pyobject(self, $py: Python<'py>) -> PyResult<Self::Output> {
                let $it = self;
                $body
            }
        }
    )*};
}

as_objects! {
    PerJoint, it, py => match it {
        PerJoint::All(value) => value.into_bound_py_any(py),
        PerJoint::Each(values) => values.into_bound_py_any(py),
    };
    Numbers, it, py => match it {
        Numbers::Same(values) => values.into_bound_py_any(py),
        Numbers::Rows(rows) => rows.into_bound_py_any(py),
    };
    MethodName, it, py => it.name().into_bound_py_any(py);
    ShapeName, it, py => it.name().into_bound_py_any(py);
    Rules, it, py => it.name().into_bound_py_any(py);
    InputSettings, it, py => {
        let dict = PyDict::new(py);
        it.0.iter().try_for_each(|(name, scale)| dict.set_item(name, scale))?;
        Ok(dict.into_any())
    };
}
