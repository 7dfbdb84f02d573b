//! Base of the classes that are nothing but their arguments: equality, hash, repr, pickling and a
//! copy with changes, once for all of them.

use core::any::Any as Type;
use core::fmt::Debug;
use core::hash::{BuildHasher, BuildHasherDefault};
use std::hash::DefaultHasher;
use std::sync::Arc;

use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple, PyType};

use crate::scenario::{
    BasisSettings, CompensatorSettings, ControllerSettings, InputSettings, MethodName,
    MotionSettings, Numbers, PerJoint, QuinticSettings, Rules, RunSettings, Scenario,
    SinesSettings, TableSettings, TwoLinkSettings,
};

/// Lists with more entries are shown by their first and last.
const LONGEST_SHOWN: usize = 12;

/// Settings of any kind, as the arguments of their class.
pub(super) trait Form: Send + Sync {
    /// The arguments by name, in the order of the constructor.
    fn arguments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>>;

    /// Whether both are of one kind and the same.
    fn same(&self, other: &dyn Form) -> bool;

    /// Equal for what is the same.
    fn hash(&self) -> u64;

    fn as_any(&self) -> &dyn Type;
}

impl<T: Debug + PartialEq + Send + Sync + 'static> Form for T
where
    for<'a, 'py> &'a T: IntoPyObject<'py>,
{
    fn arguments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        Ok(self.into_bound_py_any(py)?.cast_into()?)
    }

    fn same(&self, other: &dyn Form) -> bool {
        other.as_any().downcast_ref::<T>().is_some_and(|other| self == other)
    }

    fn hash(&self) -> u64 {
        // Zero has two signs, which are equal.
        let words = format!("{self:?}").replace("-0.0", "0.0");
        BuildHasherDefault::<DefaultHasher>::default().hash_one(words)
    }

    fn as_any(&self) -> &dyn Type {
        self
    }
}

/// What is nothing but its arguments: two are equal, with one hash, when these are.
///
/// ``copy.replace(it, argument=value)``, or before Python 3.13 ``it.__replace__(argument=value)``,
/// is a copy with other arguments. It can be pickled; its repr shows every argument, long lists by
/// their first and last entry.
#[pyclass(name = "Settings", module = "steadyarm", subclass, frozen)]
pub(super) struct PyForm(Arc<dyn Form>);

impl PyForm {
    /// A class, above its settings.
    pub fn under<T>(settings: &Arc<impl Form + 'static>, class: T) -> PyClassInitializer<T>
    where
        T: pyo3::PyClass<BaseType = Self>,
    {
        PyClassInitializer::from(Self(settings.clone())).add_subclass(class)
    }
}

#[pymethods]
impl PyForm {
    fn __eq__(&self, other: &Bound<'_, Self>) -> bool {
        self.0.same(&*other.get().0)
    }

    fn __hash__(&self) -> u64 {
        self.0.hash()
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let mut shown = Vec::new();
        for (name, value) in arguments(slf)? {
            shown.push(format!("{name}={}", short(&value)?));
        }
        Ok(format!("{}({})", slf.get_type().name()?, shown.join(", ")))
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyType>, Bound<'py, PyTuple>)> {
        Ok((slf.get_type(), arguments(slf)?.values().to_tuple()))
    }

    /// A copy with other values of these arguments.
    #[pyo3(signature = (**changes))]
    fn __replace__<'py>(
        slf: &Bound<'py, Self>,
        changes: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let arguments = arguments(slf)?;
        if let Some(changes) = changes {
            arguments.update(changes.as_mapping())?;
        }
        slf.get_type().call((), Some(&arguments))
    }
}

/// The arguments by name; what is an object of its own as this object.
fn arguments<'py>(slf: &Bound<'py, PyForm>) -> PyResult<Bound<'py, PyDict>> {
    let arguments = slf.get().0.arguments(slf.py())?;
    if arguments.contains("basis")? {
        arguments.set_item("basis", slf.getattr("basis")?)?;
    }
    Ok(arguments)
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

/// Settings as dicts of their fields, in the order of the constructor. A field that is missing here
/// does not compile.
macro_rules! as_dicts {
    ($($settings:ident { $($name:ident),* $(,)? })*) => {$(
        impl<'py> IntoPyObject<'py> for &$settings {
            type Target = PyDict;
            type Output = Bound<'py, PyDict>;
            type Error = PyErr;

            fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
                let $settings { $($name),* } = self;
                let dict = PyDict::new(py);
                $(dict.set_item(stringify!($name), $name)?;)*
                Ok(dict)
            }
        }
    )*};
}

as_dicts! {
    BasisSettings { form, centers, width, normalized, inputs, joints }
    CompensatorSettings {
        basis, q, gain, gamma, leak_rate, error_modification, projection_radius, dead_zone,
        normalization, dictionary, merge_tolerance,
    }
    ControllerSettings { kp, kv, effort_limit, effort_rate_limit }
    QuinticSettings { start, goal, duration, start_time }
    RunSettings { duration, dt, method, control_period, q0, dq0, rtol, atol }
    Scenario { two_link, plant, controller, compensator, reference, disturbance, run }
    SinesSettings { frequency, sin, cos, offset }
    TableSettings { t, q, dq, ddq }
    TwoLinkSettings { mass, length, inertia, gravity, viscous, coulomb, smoothing }
}

/// What is no struct, by `$body`.
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
    Rules, it, py => it.name().into_bound_py_any(py);
    InputSettings, it, py => {
        let dict = PyDict::new(py);
        it.0.iter().try_for_each(|(name, scale)| dict.set_item(name, scale))?;
        Ok(dict.into_any())
    };
    MotionSettings, it, py => match it {
        MotionSettings::Sines(sines) => sines.into_bound_py_any(py),
        MotionSettings::Quintic(quintic) => quintic.into_bound_py_any(py),
        MotionSettings::Table(table) => table.into_bound_py_any(py),
    };
}
