"""A record's signals by name: attributes, units, tables, pictures; and what a compensator adds."""

from __future__ import annotations

import ast
import inspect
import pickle
import sys
from dataclasses import fields, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from run_files import RECORD, ROWS
from scenes import nominal, run, tracker

COMMON = ["t", "q", "dq", "q_d", "dq_d", "ddq_d", "e", "de", "tau", "tau_model", "tau_compensation"]
COMMON += ["rho", "rho_hat", "weights_norm", "V"]


def kernel_run(**options: Any) -> sa.Run:
    """A dictionary so small that it merges."""
    basis = sa.FuzzyBasis("grid", [-1.0, 0.0, 1.0], 0.5)
    kernel = sa.FuzzyCompensator(basis, gain=7.0, dictionary=4)
    return run(sa.ComputedTorque(nominal(), 8, 5.5, kernel), **{"duration": 0.2} | options)


KERNEL = kernel_run(q0=(0.5, -0.5))


def test_every_signal_has_its_unit_its_shape_and_its_words() -> None:
    assert list(RECORD.channels) == COMMON
    for name, channel in RECORD.channels.items():
        array = getattr(RECORD, name)
        assert (channel.name, (ROWS, *channel.shape)) == (name, array.shape)
        assert channel.unit and channel.doc and name in dir(RECORD)
        assert f"\n{name}\n    {channel.doc} [{channel.unit}]." in (sa.Run.__doc__ or "")
    units = {name: RECORD.channels[name].unit for name in ("t", "e", "ddq_d", "tau", "V")}
    assert units == {"t": "s", "e": "rad", "ddq_d": "rad/s²", "tau": "N·m", "V": "1"}


def test_a_record_has_the_channels_that_it_has_rows_of() -> None:
    plain = run(sa.ComputedTorque(nominal(), 8, 5.5), duration=0.01)
    assert list(plain.channels) == COMMON[:-2]
    motion = run(tracker(), duration=0.01, record="motion")
    assert list(motion.channels) == COMMON[:8]
    assert list(motion.to_dict()) == COMMON[:8]


def test_a_compensator_adds_its_own() -> None:
    """The last row is the dictionary that the run ends with."""
    assert list(KERNEL.channels) == [*COMMON, "atoms", "error_bound"]
    assert KERNEL.dictionary is not None
    assert KERNEL.atoms[-1] == KERNEL.dictionary["atoms"]
    assert np.array_equal(KERNEL.error_bound[-1], KERNEL.dictionary["error_bound"])
    assert KERNEL.error_bound.shape == KERNEL.q.shape and KERNEL.error_bound[-1].min() > 0
    assert KERNEL.channels["atoms"] == sa.Channel("atoms", "1", (), "Atoms in the dictionary")
    assert list(KERNEL.own) == [KERNEL.channels["atoms"], KERNEL.channels["error_bound"]]
    for copy in (pickle.loads(pickle.dumps(KERNEL)), replace(KERNEL, status=KERNEL.status)):
        assert np.array_equal(copy.atoms, KERNEL.atoms) and copy.channels == KERNEL.channels
    assert not kernel_run(record="motion").own
    with pytest.raises(AttributeError, match="'Run' object has no attribute 'atom'"):
        _ = KERNEL.atom  # type: ignore[attr-defined]


def test_attributes_that_editors_know_are_signals() -> None:
    """The list that type checkers read may lack a signal, but has none that there is not."""
    source = ast.parse(inspect.getsource(sys.modules[sa.Run.__module__]))
    classes = [node for node in ast.walk(source) if isinstance(node, ast.ClassDef)]
    (columns,) = [node for node in classes if node.name == "_Columns"]
    names = [ast.unparse(n.target) for n in columns.body if isinstance(n, ast.AnnAssign)]
    assert len(names) > 10
    assert set(names) <= {field.name for field in fields(sa.Run)} & set(COMMON)


def test_signals_are_drawn_by_name() -> None:
    picture = KERNEL.plot("atoms", "error_bound", "tau")
    labels = [axes.get_ylabel().replace("\n", " ") for axes in picture.axes]
    assert labels == ["atoms [1]", "error_bound [rad/s²]", "", "tau [N·m]", ""]
    assert np.array_equal(picture.axes[0].get_lines()[0].get_ydata(), KERNEL.atoms)
    with pytest.raises(ValueError, match=r"^names: got 'atom', wants some of t, q, .*, atoms"):
        KERNEL.plot("tau", "atom")


def test_the_picture_of_a_run_has_what_the_compensator_adds() -> None:
    labels = [axes.get_ylabel().replace("\n", " ") for axes in KERNEL.plot().axes]
    assert labels[-3:] == ["atoms [1]", "error_bound [rad/s²]", ""]
    assert labels[0] == "position [rad]"


class Frame:
    """What `to_pandas` asks of a table."""

    def __init__(self, data: dict[int, Any], index: Any) -> None:
        self.data, self.index = data, index
        self.columns: Any = None
        self.attrs: dict[str, Any] = {}


def test_pandas_gets_a_column_a_joint_with_units(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the calls of pandas' public interface, which need not be installed."""
    pandas: Any = ModuleType("pandas")
    pandas.DataFrame, pandas.Index = Frame, lambda values, name: (name, values)

    class MultiIndex:
        @staticmethod
        def from_tuples(tuples: list[Any], names: tuple[str, str]) -> list[Any]:
            assert names == ("signal", "joint")
            return tuples

    pandas.MultiIndex = MultiIndex
    monkeypatch.setitem(sys.modules, "pandas", pandas)
    frame: Any = KERNEL.to_pandas()
    pairs = [("q", "1"), ("q", "2"), ("V", ""), ("error_bound", "2")]
    for name, joint in pairs:
        column = frame.data[frame.columns.index((name, joint))]
        array = getattr(KERNEL, name)
        assert np.array_equal(column, array if not joint else array[:, int(joint) - 1])
    assert len(frame.columns) == 13 * 2 + 3 == len(frame.data) and frame.index[1] is KERNEL.t
    assert frame.attrs["units"]["tau"] == "N·m" and frame.attrs["docs"]["t"] == "Time"


def test_frames_and_datasets_hold_the_signals() -> None:
    pandas = pytest.importorskip("pandas")
    frame = KERNEL.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and np.array_equal(frame["q"], KERNEL.q)
    assert np.array_equal(frame["V"].to_numpy().ravel(), KERNEL.V)
    pytest.importorskip("xarray")
    dataset = KERNEL.to_xarray()
    assert dataset["tau"].attrs["units"] == "N·m" and dataset["t"].attrs["units"] == "s"
    assert dataset["error_bound"].dims == ("t", "joint") and dataset["atoms"].dims == ("t",)
    assert np.array_equal(dataset["q"].sel(joint="2"), KERNEL.q[:, 1])


@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_a_missing_package_is_named(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, package, None)  # as if it was not installed
    with pytest.raises(
        ImportError, match=f"to_{package}: needs {package}; pip install .steadyarm.data"
    ):
        getattr(RECORD, f"to_{package}")()


FORMAT_2 = Path(__file__).parent / "files"


@pytest.mark.parametrize("name", ["dense", "kernel"])
def test_a_file_of_format_2_loads(name: str) -> None:
    """Written by the version before channels, and the same run today."""
    options = {"basis": sa.FuzzyBasis("shared", [-1.0, 0.0, 1.0], 0.5), "dictionary": None}
    if name == "kernel":
        options = {"basis": sa.FuzzyBasis("grid", [-1.0, 0.0, 1.0], 0.5), "dictionary": 4}
    controller = sa.ComputedTorque(nominal(), 8, 5.5, sa.FuzzyCompensator(gain=7.0, **options))
    today = run(controller, duration=0.01, q0=(0.5, -0.5))
    loaded = sa.Run.load(FORMAT_2 / f"format_2_{name}.npz")
    assert list(loaded.channels) == COMMON and (loaded.scene, loaded.own) == (None, {})
    for signal in COMMON:
        array = getattr(today, signal)
        np.testing.assert_allclose(getattr(loaded, signal), array, rtol=1e-9, atol=1e-12)
    if name == "dense":
        np.testing.assert_allclose(loaded.weights, today.weights, rtol=1e-9)
    else:
        assert loaded.dictionary is not None and today.dictionary is not None
        assert loaded.dictionary["merged"] == today.dictionary["merged"] == 38
    assert loaded.certificate is not None and today.certificate is not None
    assert loaded.certificate.v_end == pytest.approx(today.certificate.v_end, rel=1e-9)
    with pytest.raises(ValueError, match=r"^run: got one without its scene"):
        loaded.replay()
