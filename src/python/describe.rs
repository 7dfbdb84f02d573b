//! What a compensator says of itself, for Python.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::controller::PyController;
use super::convert::array1;
use super::dispatch::each;
use super::tracked::Trackers;

/// Return a controller's gains and what it has learnt, at the end of the latest period: arrays by
/// name.
///
/// Of the recommended controller: ``bandwidth`` [rad/s], ``braking`` [rad/s²], ``cut_off`` [Hz],
/// ``learning`` [Hz], ``acceleration_share``, ``quickness``, ``quickest`` [rad/s²], ``condition``,
/// ``friction_widths`` [rad/s], ``of_links`` (how many of the parameters are those of links),
/// ``weight`` [kg·m²], ``unit`` [N·m], ``parameters`` (m,), ``covariance`` (m, m) as a flat array,
/// ``prior`` (m,). Empty for others.
#[pyfunction]
pub(super) fn describe<'py>(
    py: Python<'py>,
    controller: &PyController,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, numbers) in each!(&controller.trackers, Trackers, it => it.described()) {
        dict.set_item(name, array1(py, &numbers))?;
    }
    Ok(dict)
}
