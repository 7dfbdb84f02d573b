"""One thing wrong at a time: the message names the argument, what it got, what it wants."""

from __future__ import annotations

import re
import subprocess
import sys
import traceback
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CENTERS, ZERO, actual, basis, nominal, plant, run, tracker

NAN, INF = float("nan"), float("inf")
A = np.block([[np.zeros((2, 2)), np.eye(2)], [-8 * np.eye(2), -5.5 * np.eye(2)]])
B = np.vstack([np.zeros((2, 2)), np.eye(2)])
Q = 10 * np.eye(4)


class Deaf:
    def __array__(self, *_: object, **__: object) -> np.ndarray:
        raise RuntimeError("no array here")


def with_entry(matrix: np.ndarray, row: int, column: int, value: float) -> np.ndarray:
    changed = np.array(matrix, dtype=float)
    changed[row, column] = value
    return changed


def refused(kind: type[Exception], message: str, call: Callable[[], object]) -> None:
    with pytest.raises(kind) as caught:
        call()
    assert type(caught.value) is kind
    assert re.search(f"^{message}", str(caught.value)), str(caught.value)


def arm(**change: Any) -> sa.TwoLink:
    return sa.TwoLink(**({"mass": (4, 4), "length": (0.5, 0.5), "inertia": (0.2, 0.2)} | change))


def sets(**change: Any) -> sa.FuzzyBasis:
    return sa.FuzzyBasis(**({"form": "grid", "centers": CENTERS, "width": 1.0} | change))


def compensator(**change: Any) -> sa.FuzzyCompensator:
    return sa.FuzzyCompensator(**({"basis": basis("shared")} | change))


def computed_torque(**change: Any) -> sa.ComputedTorque:
    return sa.ComputedTorque(**({"arm": nominal(), "kp": 8, "kv": 5.5} | change))


def step(**change: Any) -> np.ndarray:
    names = ("q", "dq", "q_d", "dq_d", "ddq_d")
    return tracker("shared").step(**(dict.fromkeys(names, ZERO) | {"dt": 1e-3} | change))


def simulate(**change: Any) -> sa.Run:
    pieces = {"plant": plant(), "tracker": tracker("shared"), "reference": sa.paper.reference()}
    return sa.simulate(**(pieces | {"duration": 0.01} | change))


def move(**change: Any) -> object:
    return plant().step(**({"q": ZERO, "dq": ZERO, "tau": ZERO, "t": 0.0, "dt": 1e-3} | change))


def riccati(**change: Any) -> sa.RiccatiSolution:
    return sa.bounded_real_riccati(**({"A": A, "B": B, "Q": Q} | change))


def lqr(**change: Any) -> sa.RiccatiSolution:
    return sa.care(**({"A": A, "B": B, "Q": Q, "R": np.eye(2)} | change))


def sines(**change: Any) -> sa.Sines:
    return sa.Sines(**({"frequency": (1, 3)} | change))


def quintic(**change: Any) -> sa.Quintic:
    return sa.Quintic(**({"start": 0, "goal": 1, "duration": 1} | change))


def table(**change: Any) -> sa.Table:
    return sa.Table(**({"t": (0, 1), "q": np.zeros((2, 2))} | change))


def scene_plant(**change: Any) -> sa.Plant:
    return sa.Plant(**({"arm": actual()} | change))


def fit(**change: Any) -> sa.FuzzyApproximator:
    data = {"basis": basis("shared"), "x": np.zeros((5, 4)), "y": np.zeros((5, 1))}
    return sa.FuzzyApproximator.fit(**(data | change))


def design(**change: Any) -> object:
    return sa.design(**({"tracker": tracker()} | change))


def weights(**change: Any) -> None:
    tracker("shared").weights = change["weights"]


def warm_start(**change: Any) -> None:
    tracker("shared").warm_start(**change)


VECTORS = [
    (arm, ("mass", "length", "inertia", "viscous", "coulomb", "smoothing"), "a scalar or "),
    (compensator, ("gain",), "a scalar or "),
    (computed_torque, ("kp", "kv", "effort_limit", "effort_rate_limit"), "a scalar or "),
    (scene_plant, ("effort_limit",), "a scalar or "),
    (simulate, ("q0", "dq0"), "a scalar or "),
    (quintic, ("start", "goal"), "a scalar or "),
    (sines, ("offset",), "a scalar or "),
    (step, ("q", "dq", "q_d", "dq_d", "ddq_d"), ""),
    (move, ("q", "dq", "tau"), ""),
]
OF_ANY_ARM = (compensator, quintic, sines)
"""What is built without an arm, and may be for one of other joints."""

EACH_VECTOR = [
    pytest.param(call, name, wanted, id=f"{call.__name__}-{name}")
    for call, names, wanted in VECTORS
    for name in names
]
POSITIVE = {"mass", "length", "inertia", "gain", "kp", "kv"}
LIMITS = {"effort_limit", "effort_rate_limit"}

SCALARS = [
    (arm, ("gravity",)),
    (compensator, ("gamma", "leak_rate", "error_modification", "projection_radius")),
    (compensator, ("dead_zone", "normalization")),
    (step, ("dt",)),
    (move, ("t", "dt")),
    (simulate, ("duration", "dt", "control_period", "rtol", "atol")),
    (riccati, ("gamma",)),
    (quintic, ("duration", "start_time")),
    (fit, ("ridge",)),
    (design, ("control_period", "inertia_ratio")),
]
EACH_SCALAR = [
    pytest.param(call, name, id=f"{call.__name__}-{name}")
    for call, names in SCALARS
    for name in names
]

MATRICES = [
    (riccati, ("A", "B", "Q")),
    (lqr, ("A", "B", "Q", "R")),
    (fit, ("x", "y")),
    (weights, ("weights",)),
    (warm_start, ("weights",)),
    (table, ("q",)),
    (sines, ("sin", "cos")),
]
EACH_MATRIX = [
    pytest.param(call, name, id=f"{call.__name__}-{name}")
    for call, names in MATRICES
    for name in names
]
SHAPES = {"A": (4, 4), "B": (4, 2), "Q": (4, 4), "R": (2, 2), "x": (5, 4), "y": (5, 1)}
SHAPES |= {"weights": (2, 5), "q": (2, 2), "sin": (2, 2), "cos": (2, 2)}


@pytest.mark.parametrize(("call", "name", "wanted"), EACH_VECTOR)
def test_vector_of_wrong_shape_is_refused(call: Any, name: str, wanted: str) -> None:
    shapes: list[tuple[int, ...]] = [(1,), (3,), (0,), (2, 1), (1, 2), (2, 2)]
    joints = r"\(2,\)"
    if call in OF_ANY_ARM:
        shapes, joints = [*shapes[2:], (13,)], r"\(n,\) with n from 1 to 12"
    for shape in shapes:
        got = re.escape(f"{name}: got shape {shape}")
        refused(
            ValueError, f"{got}, wants {wanted}{joints}", lambda s=shape: call(**{name: np.ones(s)})
        )


@pytest.mark.parametrize(("call", "name", "wanted"), EACH_VECTOR)
def test_vector_of_wrong_type_is_refused(call: Any, name: str, wanted: str) -> None:
    for value, got in [
        ("x", "str"),
        (b"x", "bytes"),
        ({}, "dict"),
        (object(), "object"),
        (1j, "complex"),
        (Deaf(), "Deaf"),
        ((1j, 0), "an array of dtype complex128"),
        (("1", "2"), "an array of dtype <U1"),
        ((1, None), "an array of dtype object"),
        (np.array([1.0, 2.0], dtype=object), "an array of dtype object"),
        (np.array(["2020-01-01"] * 2, dtype="M8[D]"), "an array of dtype datetime64"),
        ([[1, 2], [3]], "list"),
    ]:
        message = rf"{name}: got {re.escape(got)}.*, wants real numbers"
        refused(TypeError, message, lambda v=value: call(**{name: v}))


@pytest.mark.parametrize(("call", "name", "wanted"), EACH_VECTOR)
def test_entry_of_a_vector_that_is_not_finite_is_refused(call: Any, name: str, wanted: str) -> None:
    for entry in (0, 1):
        for value, got in [(NAN, "NaN"), (INF, "inf"), (-INF, "-inf")]:
            if name in LIMITS and value == INF:
                continue
            vector = np.ones(2)
            vector[entry] = value
            wants = "a limit > 0" if name in LIMITS else "a finite number"
            message = rf"(friction\.)?{name}\[{entry}\]: got {got}, wants {wants}"
            refused(ValueError, message, lambda v=vector: call(**{name: v}))


@pytest.mark.parametrize(("call", "name", "wanted"), EACH_VECTOR)
def test_zero_and_negative_entries_are_refused_where_positive_ones_are_due(
    call: Any, name: str, wanted: str
) -> None:
    if name in POSITIVE | LIMITS:
        for value in (0.0, -0.0, -1.0, -1e-300):
            message = rf"{name}\[1\]: got -?[0-9e.-]+, wants a (number|limit) > 0"
            refused(ValueError, message, lambda v=value: call(**{name: (1.0, v)}))
    elif name in ("viscous", "coulomb", "smoothing"):
        refused(
            ValueError, rf"{name}\[0\]: got -1, wants a number >= 0", lambda: call(**{name: -1})
        )
    else:
        call(**{name: (-1.0, 0.0)})


@pytest.mark.parametrize(("call", "name"), EACH_SCALAR)
def test_scalar_that_is_none_is_refused(call: Any, name: str) -> None:
    for value, got in [("1", "str"), (1j, "complex"), ({}, "dict"), (object(), "object")]:
        message = f"{name}: got {got}, wants real numbers"
        refused(TypeError, message, lambda v=value: call(**{name: v}))
    for value in ([1.0, 2.0], np.ones(1), np.ones((1, 1)), []):
        message = rf"{name}: got shape \(.*\), wants a scalar"
        refused(ValueError, message, lambda v=value: call(**{name: v}))


@pytest.mark.parametrize(("call", "name"), EACH_SCALAR)
def test_scalar_that_is_not_a_number_is_refused(call: Any, name: str) -> None:
    if name in ("rtol", "atol"):
        refused(ValueError, f"{name}: got NaN", lambda: call(method="dp54", **{name: NAN}))
    else:
        refused(ValueError, f"{name}: got NaN, wants", lambda: call(**{name: NAN}))
    if name not in ("gamma", "rtol", "atol", "projection_radius"):
        refused(ValueError, f"{name}: got inf, wants", lambda: call(**{name: INF}))


@pytest.mark.parametrize(("call", "name"), EACH_MATRIX)
def test_matrix_of_wrong_shape_or_type_is_refused(call: Any, name: str) -> None:
    rows, columns = SHAPES[name]
    for shape in [(rows + 1, columns), (rows,), (rows, columns, 1), ()]:
        if name == "x" and len(shape) == 2:
            continue
        message = rf"{name}: got shape {re.escape(str(shape))}, wants "
        refused(ValueError, message, lambda s=shape: call(**{name: np.zeros(s)}))
    for value, got in [
        ("x", "str"),
        (np.full((rows, columns), 1j), "an array of dtype complex128"),
        (np.full((rows, columns), None), "an array of dtype object"),
        ([[1.0], [1.0, 2.0]], "list"),
    ]:
        refused(TypeError, f"{name}: got {got}", lambda v=value: call(**{name: v}))


@pytest.mark.parametrize(("call", "name"), EACH_MATRIX)
def test_entry_of_a_matrix_that_is_not_finite_is_refused(call: Any, name: str) -> None:
    rows, columns = SHAPES[name]
    for value, got in [(NAN, "NaN"), (INF, "inf"), (-INF, "-inf")]:
        place = rf"{name}\[{rows - 1}, {columns - 1}\]"
        matrix = with_entry(np.zeros((rows, columns)), rows - 1, columns - 1, value)
        refused(ValueError, rf"{place}: got {got}, wants", lambda m=matrix: call(**{name: m}))


CASES: list[tuple[type[Exception], str, Callable[[], object]]] = [
    # arms
    (ValueError, r"mass_matrix\.det: got inf, wants", lambda: arm(mass=1e200)),
    (ValueError, r"mass_matrix\.det: got 0, wants", lambda: arm(mass=1e-200, inertia=1e-200)),
    (TypeError, r"TwoLink.*unexpected keyword argument 'weight'", lambda: arm(weight=1)),
    (TypeError, r"TwoLink.*missing 1 required .*'inertia'", lambda: sa.TwoLink(1, 1)),
    (ValueError, r"q\[0\]: got NaN", lambda: nominal().mass_matrix((NAN, 0))),
    (ValueError, r"dq\[1\]: got inf", lambda: nominal().bias(ZERO, (0, INF))),
    (ValueError, r"tau\[0\]: got -inf", lambda: nominal().forward_dynamics(ZERO, ZERO, (-INF, 0))),
    (ValueError, r"q: got shape \(\), wants \(2,\)", lambda: nominal().gravity(0)),
    # bases
    (ValueError, r'form: got "gird", wants "grid" or "shared"', lambda: sets(form="gird")),
    (TypeError, r'form: got int, wants "grid"', lambda: sets(form=3)),
    (TypeError, r"normalized: got int, wants True or False", lambda: sets(normalized=1)),
    (ValueError, r"centers: got 0 entries, wants 1", lambda: sets(centers=())),
    (TypeError, r"centers: got str, wants real numbers", lambda: sets(centers="x")),
    (TypeError, r"centers: got an array of dtype complex128", lambda: sets(centers=(1j,))),
    (ValueError, r"centers: got shape \(\), wants \(sets,\)", lambda: sets(centers=1.0)),
    (ValueError, r"centers\[1\]: got NaN, wants a finite number", lambda: sets(centers=(0, NAN))),
    (
        ValueError,
        r"centers: got 3 lists, wants one list, or one",
        lambda: compensator(basis=sets(centers=[[1], [2], [3]]), gain=(1, 1)),
    ),
    (ValueError, r"sets: got 513, wants at most 512", lambda: sets(centers=range(513))),
    (ValueError, r"width: got 0, wants widths > 0", lambda: sets(width=0)),
    (ValueError, r"width: got -1, wants widths > 0", lambda: sets(width=-1)),
    (ValueError, r"width: got NaN, wants a finite number", lambda: sets(width=NAN)),
    (ValueError, r"width: got 1e-10, wants widths > 0, between", lambda: sets(width=1e-10)),
    (ValueError, r"width: got 2 entries, wants 5", lambda: sets(width=(1, 2))),
    (TypeError, r"width: got str, wants real numbers", lambda: sets(width="x")),
    (ValueError, r'inputs: got "err", wants one of e, de,', lambda: sets(inputs="err")),
    (TypeError, r"inputs: got int, wants a name, a list", lambda: sets(inputs=3)),
    (TypeError, r"inputs: got list, wants a name, a list", lambda: sets(inputs=["e", 3])),
    (TypeError, r"inputs: got int, wants names", lambda: sets(inputs={3: 1.0})),
    (ValueError, r"inputs: got no signal, wants at least one", lambda: sets(inputs=[])),
    (ValueError, r'inputs: got "e" twice', lambda: sets(inputs=["e", "e"])),
    (ValueError, r'inputs\["e"\]: got 0, wants a finite scale', lambda: sets(inputs={"e": 0})),
    (ValueError, r'inputs\["e"\]: got NaN, wants a finite', lambda: sets(inputs={"e": NAN})),
    (TypeError, r'inputs\["e"\]: got str, wants real', lambda: sets(inputs={"e": "x"})),
    (
        ValueError,
        r"x: got shape \(4,\), wants \(samples, inputs\)",
        lambda: basis().evaluate(ZERO.repeat(2)),
    ),
    (ValueError, r"x: got shape \(3, 0\), wants", lambda: basis().evaluate(np.zeros((3, 0)))),
    (ValueError, r"x\[0, 3\]: got NaN", lambda: basis().evaluate([[0, 0, 0, NAN]])),
    # compensators
    (TypeError, r"basis: got int, wants a FuzzyBasis", lambda: compensator(basis=3)),
    (ValueError, r"q\[0\]: got -1, wants a number >= 0", lambda: compensator(q=-1)),
    (ValueError, r"q\[3\]: got NaN, wants a finite number", lambda: compensator(q=(1, 1, 1, NAN))),
    (
        ValueError,
        r"q: got shape \(2,\), wants a scalar, \(4,\)",
        lambda: compensator(q=(1, 2), gain=(1, 1)),
    ),
    (
        ValueError,
        r"q\[0, 1\]: got 1, wants 0: .*diagonal Q",
        lambda: compensator(q=np.ones((4, 4))),
    ),
    (ValueError, r"gamma: got 0, wants a number > 0", lambda: compensator(gamma=0)),
    (ValueError, r"gamma: got -1, wants a number > 0", lambda: compensator(gamma=-1)),
    (ValueError, r"leak_rate: got -1, wants a number >= 0", lambda: compensator(leak_rate=-1)),
    (ValueError, r"error_modification: got -1", lambda: compensator(error_modification=-1)),
    (
        ValueError,
        r"projection_radius: got 0, wants a radius",
        lambda: compensator(projection_radius=0),
    ),
    (ValueError, r"dead_zone: got -1, wants a number >= 0", lambda: compensator(dead_zone=-1)),
    (ValueError, r"normalization: got -1", lambda: compensator(normalization=-1)),
    # controllers
    (TypeError, r"arm: got str, wants a TwoLink", lambda: computed_torque(arm="arm")),
    (
        TypeError,
        r"compensator: got FuzzyBasis, wants a Fuzzy",
        lambda: computed_torque(compensator=basis()),
    ),
    (TypeError, r"compensator: .*has none", lambda: computed_torque().freeze()),
    (TypeError, r"compensator: .*has none", lambda: computed_torque().warm_start(ZERO)),
    (
        ValueError,
        r"weights\[0\]: got 1e200, wants weights",
        lambda: weights(weights=np.full((2, 5), 1e200)),
    ),
    (ValueError, r"q\[1\]: got 20000000000, wants a value an arm", lambda: step(q=(0, 2e10))),
    (ValueError, r"ddq_d\[0\]: got 1e300, wants a value an arm", lambda: step(ddq_d=(1e300, 0))),
    (ValueError, r"dt: got 0, wants a period between 1e-9 and 1 s", lambda: step(dt=0)),
    (ValueError, r"dt: got -0.001, wants a period", lambda: step(dt=-1e-3)),
    (ValueError, r"dt: got 1e-300, wants a period", lambda: step(dt=1e-300)),
    (ValueError, r"dt: got 1000, wants a period", lambda: step(dt=1e3)),
    # plants
    (TypeError, r"arm: got NoneType, wants a TwoLink", lambda: scene_plant(arm=None)),
    (
        TypeError,
        r"disturbance: got int, wants Sines, .* or a callable",
        lambda: scene_plant(disturbance=3),
    ),
    (ValueError, r"dt: got 0, wants a number > 0", lambda: move(dt=0)),
    (ValueError, r"dt: got -1, wants a number > 0", lambda: move(dt=-1)),
    # simulations
    (TypeError, r"plant: got TwoLink, wants a Plant", lambda: simulate(plant=actual())),
    (
        TypeError,
        r"tracker: got NoneType, wants a Controller, .*, or a Guard",
        lambda: simulate(tracker=None),
    ),
    (
        TypeError,
        r"reference: got tuple, wants Sines, .* callable",
        lambda: simulate(reference=(0, 0, 0)),
    ),
    (ValueError, r"duration: got 0, wants a number > 0", lambda: simulate(duration=0)),
    (ValueError, r"duration: got -1, wants a number > 0", lambda: simulate(duration=-1)),
    (
        ValueError,
        r"duration: got 0.0015, wants a whole number of dt",
        lambda: simulate(duration=1.5e-3),
    ),
    (ValueError, r"duration / dt: got 1000000000, wants at most", lambda: simulate(duration=1e6)),
    (ValueError, r"duration / dt: got .*, wants at most", lambda: simulate(dt=1e-300)),
    (ValueError, r"dt: got 0, wants a number > 0", lambda: simulate(dt=0)),
    (ValueError, r"dt: got -0.001, wants a number > 0", lambda: simulate(dt=-1e-3)),
    (ValueError, r'method: got "euler", wants "rk4" or "dp54"', lambda: simulate(method="euler")),
    (TypeError, r'method: got int, wants "rk4" or "dp54"', lambda: simulate(method=4)),
    (ValueError, r"control_period: got 0, wants a period", lambda: simulate(control_period=0)),
    (ValueError, r"control_period: got 2, wants a period", lambda: simulate(control_period=2)),
    (
        ValueError,
        r"control_period: got 0.0015, wants a whole",
        lambda: simulate(control_period=1.5e-3),
    ),
    (
        ValueError,
        r"record_every: got 0, wants a whole number >= 1",
        lambda: simulate(record_every=0),
    ),
    (
        ValueError,
        r'record: got "torque", wants "all" or "motion"',
        lambda: simulate(record="torque"),
    ),
    (ValueError, r"record_every: got -1, wants a whole number", lambda: simulate(record_every=-1)),
    (
        ValueError,
        r"record_every: got 1000000000000000000000000, ",
        lambda: simulate(record_every=10**24),
    ),
    (
        TypeError,
        r"record_every: got float, wants a whole number",
        lambda: simulate(record_every=1.5),
    ),
    (ValueError, r"rtol: got 0, wants between", lambda: simulate(rtol=0, method="dp54")),
    (ValueError, r"atol: got 1, wants between", lambda: simulate(atol=1, method="dp54")),
    (
        ValueError,
        r"effort_rate_limit\[0\]: got 10, wants no rate limit in continuous time; set",
        lambda: simulate(tracker=computed_torque(effort_rate_limit=10)),
    ),
    # references
    (ValueError, r"frequency\[1\]: got NaN", lambda: sines(frequency=(1, NAN))),
    (
        ValueError,
        r"frequency: got shape \(1, 1\), wants a scalar or \(K,\)",
        lambda: sines(frequency=[[1]]),
    ),
    (ValueError, r"acceleration\[0\]: got inf", lambda: sines(frequency=1e200, sin=1)),
    (ValueError, r"t: got NaN, wants a finite number", lambda: sines()(NAN)),
    (TypeError, r"t: got str, wants real numbers", lambda: quintic()("x")),
    (ValueError, r"duration: got 0, wants a number > 0", lambda: quintic(duration=0)),
    (ValueError, r"duration: got 1e-200, wants a time in which", lambda: quintic(duration=1e-200)),
    (ValueError, r"t: got shape \(1, 2\), wants \(T,\)", lambda: table(t=[[0, 1]])),
    (ValueError, r"t: got 1, wants at least 2 samples", lambda: table(t=(0,), q=np.zeros((1, 2)))),
    (ValueError, r"t\[1\]: got 0, wants a later time", lambda: table(t=(0, 0))),
    (ValueError, r"t\[1\]: got NaN, wants a finite number", lambda: table(t=(0, NAN))),
    (
        TypeError,
        r"dq, ddq: got one of them, wants both or neither",
        lambda: table(dq=np.zeros((2, 2))),
    ),
    # Riccati
    (ValueError, r"A: got shape \(3, 4\), wants a square matrix", lambda: riccati(A=A[:3])),
    (ValueError, r"A: got 513 states, wants 1 to 512", lambda: riccati(A=-np.eye(513))),
    (ValueError, r"A: got 0 states, wants 1 to 512", lambda: riccati(A=np.zeros((0, 0)))),
    (ValueError, r"A: got an eigenvalue with real part 2.75e0 1/s", lambda: riccati(A=-A)),
    (ValueError, r"A: got an eigenvalue with real part 0e0 1/s", lambda: riccati(A=0 * A)),
    (
        ValueError,
        r"B: got shape \(4, 5\), wants \(4, m\) with m",
        lambda: riccati(B=np.ones((4, 5))),
    ),
    (
        ValueError,
        r"B: got shape \(4, 0\), wants \(4, m\) with m",
        lambda: riccati(B=np.ones((4, 0))),
    ),
    (
        ValueError,
        r"Q: got Q\[0, 1\] and Q\[1, 0\] 1e0 apart",
        lambda: riccati(Q=with_entry(Q, 0, 1, 1)),
    ),
    (
        ValueError,
        r"Q: got smallest eigenvalue -1e0, wants",
        lambda: riccati(Q=np.diag([1, 1, 1, -1])),
    ),
    (ValueError, r"gamma: got 0, wants a number > 0", lambda: riccati(gamma=0)),
    (ValueError, r"R: got smallest eigenvalue 0e0, wants", lambda: lqr(R=np.zeros((2, 2)))),
    (ValueError, r"R: got smallest eigenvalue -1e0, wants", lambda: lqr(R=-np.eye(2))),
    (ValueError, r"R: got R\[0, 1\] and R\[1, 0\]", lambda: lqr(R=[[1, 0.5], [0, 1]])),
    (
        ValueError,
        r"B: got an input that does not reach",
        lambda: lqr(A=np.eye(4), B=np.zeros((4, 2))),
    ),
    # approximators
    (TypeError, r"basis: got int, wants a FuzzyBasis", lambda: fit(basis=3)),
    (
        ValueError,
        r"x: got shape \(0, 4\), wants",
        lambda: fit(x=np.zeros((0, 4)), y=np.zeros((0, 1))),
    ),
    (ValueError, r"ridge: got -1, wants a number >= 0", lambda: fit(ridge=-1)),
    (ValueError, r"ridge: got smallest eigenvalue 0e0", lambda: fit(ridge=0)),
    (ValueError, r"x: got shape \(2, 3\), wants \(samples, 4\)", lambda: fit()(np.zeros((2, 3)))),
    # the design report
    (TypeError, r"tracker: got int, wants a Controller, such as", lambda: design(tracker=3)),
    (ValueError, r"delay: got -1, wants a whole number >= 0", lambda: design(delay=-1)),
    (TypeError, r"delay: got float, wants a whole number >= 0", lambda: design(delay=1.5)),
    (
        ValueError,
        r"disturbance: got shape \(2,\), wants \(K, 2\)",
        lambda: design(disturbance=(1, 1)),
    ),
    (TypeError, r"disturbance: got str, wants real numbers", lambda: design(disturbance="x")),
    # the paper's scenes
    (ValueError, r"number: got 4, wants 1, 2 or 3", lambda: sa.paper.simulation(4)),
    (ValueError, r"number: got True, wants 1, 2 or 3", lambda: sa.paper.simulation(True)),
    (
        ValueError,
        r"preset: got 'best', wants one of",
        lambda: sa.paper.simulation(3, preset="best"),
    ),
    (
        ValueError,
        r"preset: got \['printed'\], wants",
        lambda: sa.paper.simulation(3, preset=["printed"]),
    ),
    (ValueError, r"frob: simulation 3 has no such setting", lambda: sa.paper.simulation(3, frob=1)),
    (ValueError, r"gain: simulation 2 has no such setting", lambda: sa.paper.simulation(2, gain=1)),
]


@pytest.mark.parametrize(
    ("kind", "message", "call"),
    [
        pytest.param(*case, id=f"{i}-{re.split('[^a-zA-Z_]', case[1])[0]}")
        for i, case in enumerate(CASES)
    ],
)
def test_message_names_argument_value_and_wish(kind: Any, message: str, call: Any) -> None:
    refused(kind, message, call)


@pytest.mark.parametrize(
    ("window", "band", "message"),
    [
        ((5, 6), 0.01, r"window: got \(5, 6\), wants at least one sample .*from 0 to 1 s"),
        ((0.5, 0.4), 0.01, r"window: got \(0.5, 0.4\), wants at least one sample"),
        ((NAN, 1), 0.01, r"window: got \(NaN, 1\), wants"),
        ((0, 1, 2), 0.01, r"window: got shape \(3,\), wants \(from, to\)"),
        ((0, 1), 0.0, r"band: got 0, wants a number > 0"),
        ((0, 1), NAN, r"band: got NaN, wants a finite number"),
    ],
)
def test_metrics_refuse_windows_and_bands(window: Any, band: float, message: str) -> None:
    refused(ValueError, message, lambda: run(tracker("shared")).metrics(window, band))


def test_equation_without_a_solution_tells_what_would_have_one() -> None:
    for call in (lambda: computed_torque(compensator=compensator(q=30)), lambda: riccati(Q=3 * Q)):
        with pytest.raises(
            sa.NoStabilizingSolution, match=r"^gamma: got 1, wants more than 1\.064"
        ) as caught:
            call()
        assert caught.value.max_scale == pytest.approx(26.4978068488 / 30, rel=1e-9)
        assert caught.value.gamma_opt == pytest.approx(0.6143205381 * 3**0.5, rel=1e-9)
    riccati(Q=3 * Q * caught.value.max_scale * (1 - 1e-9))
    riccati(Q=3 * Q, gamma=caught.value.gamma_opt * (1 + 1e-9))


def test_too_many_rules_are_refused_before_memory_is_taken() -> None:
    code = """
import resource, numpy as np, steadyarm as sa
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 2**26, used + 2**26))
centers = np.linspace(-1, 1, 57)
def refused(call):
    try:
        call()
    except ValueError as error:
        print(error)
many = sa.FuzzyBasis("grid", centers, 1.0)
refused(lambda: many.evaluate(np.zeros((1, 4))))
signals = ["e", "de", "q", "dq"]
refused(lambda: sa.FuzzyCompensator(sa.FuzzyBasis("grid", [centers] * 8, 1.0, inputs=signals)))
refused(lambda: sa.FuzzyBasis("per_joint", [centers] * 8, 1.0, inputs=signals))
basis = sa.FuzzyBasis("grid", np.linspace(-1, 1, 32), 1.0)
refused(lambda: basis.evaluate(np.zeros((300, 4))))
scene = sa.paper.simulation(1)
refused(lambda: scene.run(duration=5e3))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    way = "use dictionary=256, the kernel form of FuzzyCompensator"
    assert done.stdout.splitlines() == [
        f"rules: got 10556001, wants at most 1048576; {way}",
        f"rules: got 111429157112001, wants at most 1048576; {way}",
        "rules: got 21112002, wants at most 1048576",
        "x: got 300 samples, wants at most 256 for so many rules",
        "record_every: got 1, which makes a record of 1.08 GB (5000001 rows of 216 bytes), wants "
        "at most 2.15 GB and what fits memory; take a larger number, or "
        'record="motion", the motion alone',
    ]


BAD_SAMPLES = [
    {"q": (NAN, 0)},
    {"dq": (0, INF)},
    {"q_d": (1e11, 0)},
    {"dq_d": (0, "x")},
    {"ddq_d": (1, 2, 3)},
    {"dt": 0.0},
    {"dt": NAN},
    {"dt": "x"},
    {"q": None},
    {"dq": (1e5, -1e5), "dt": 1.0},
]


@pytest.mark.parametrize("change", BAD_SAMPLES, ids=repr)
def test_refused_step_leaves_the_state_bit_for_bit(change: dict[str, Any]) -> None:
    controller = tracker("grid", False, gain=1e150)
    good = {"q": (0.1, 0), "dq": (0, 0.1), "q_d": ZERO, "dq_d": ZERO, "ddq_d": ZERO, "dt": 1e-9}
    controller.step(**good)
    before, tau_model = controller.__getstate__(), controller.tau_model
    with pytest.raises((ValueError, TypeError)):
        controller.step(**(good | change))
    assert controller.__getstate__() == before
    assert controller.steps == 1
    assert np.array_equal(controller.tau_model, tau_model)
    twin = tracker("grid", False, gain=1e150)
    twin.step(**good)
    assert np.array_equal(controller.step(**good), twin.step(**good))


@settings(deadline=None)
@given(
    st.sampled_from(["q", "dq", "q_d", "dq_d", "ddq_d"]),
    st.sampled_from([0, 1]),
    st.sampled_from([NAN, INF, -INF, 1.1e10, -1e308]),
    st.integers(0, 20),
)
def test_bad_entry_at_any_step_changes_nothing(name: str, entry: int, bad: float, at: int) -> None:
    controller, twin = tracker("concat", gain=70), tracker("concat", gain=70)
    random = np.random.default_rng(at)
    for k in range(22):
        sample = dict(
            zip(("q", "dq", "q_d", "dq_d", "ddq_d"), random.normal(size=(5, 2)), strict=True)
        )
        if k == at:
            broken = sample[name].copy()
            broken[entry] = bad
            with pytest.raises(ValueError, match=rf"^{name}\[{entry}\]: got"):
                controller.step(**(sample | {name: broken}), dt=1e-3)
        assert np.array_equal(controller.step(**sample, dt=1e-3), twin.step(**sample, dt=1e-3))


class Trouble(Exception):
    pass


def failing(t: float) -> Any:
    if t > 0.05:
        raise Trouble("at the planned time")
    return ZERO, ZERO, ZERO


@pytest.mark.parametrize("options", [{}, {"method": "dp54"}, {"control_period": 1e-3}], ids=repr)
def test_reference_that_raises_keeps_its_traceback_and_gives_the_run_so_far(options: Any) -> None:
    controller = tracker()
    with pytest.raises(Trouble, match="planned") as caught:
        simulate(reference=failing, tracker=controller, duration=0.1, **options)
    frames = [frame.name for frame in traceback.extract_tb(caught.value.__traceback__)]
    assert frames[-1] == "failing"
    (note,) = caught.value.__notes__
    so_far = caught.value.run  # type: ignore[attr-defined]
    assert re.fullmatch(r"steadyarm: raised by a callable at t = [0-9.]+ s, step [0-9]+", note)
    assert isinstance(so_far, sa.Run)
    if "method" not in options:
        assert note.endswith("t = 0.051 s, step 51") or note.endswith("t = 0.05 s, step 50")
        assert len(so_far.t) == 51
    assert np.isfinite(so_far.q).all()
    assert not so_far.status.finished
    assert controller.steps == 0
    assert np.isfinite(controller.step(ZERO, ZERO, ZERO, ZERO, ZERO, 1e-3)).all()
    assert simulate(tracker=controller).status.finished


def test_disturbance_that_raises_keeps_its_traceback() -> None:
    def disturbance(q: np.ndarray, dq: np.ndarray, t: float) -> np.ndarray:
        return np.zeros(2) if t < 0.05 else np.zeros(2)[int(1e3 * t)]

    for options in ({}, {"method": "dp54"}, {"control_period": 1e-3}):
        with pytest.raises(IndexError) as caught:
            simulate(plant=sa.Plant(actual(), disturbance), duration=0.1, **options)
        assert traceback.extract_tb(caught.value.__traceback__)[-1].name == "disturbance"
        assert np.isfinite(caught.value.run.tau).all()  # type: ignore[attr-defined]


def test_callback_is_not_called_again_after_it_raised() -> None:
    calls = 0

    def disturbance(q: np.ndarray, dq: np.ndarray, t: float) -> np.ndarray:
        nonlocal calls
        calls += 1
        raise Trouble

    with pytest.raises(Trouble):
        simulate(plant=sa.Plant(actual(), disturbance))
    assert calls == 1
    broken = sa.Plant(actual(), disturbance)
    for expected in (2, 3):
        with pytest.raises(Trouble):
            broken.step(ZERO, ZERO, ZERO, 0, 1e-3)
        assert calls == expected


@pytest.mark.parametrize(
    ("value", "kind", "message"),
    [
        (None, TypeError, r"reference: wants \(q_d, dq_d, ddq_d\), got NoneType from the callable"),
        (3.0, TypeError, r"reference: wants \(q_d, dq_d, ddq_d\), got float from the callable"),
        ((ZERO, ZERO), TypeError, r"reference: wants .*, got 2 entries from the callable"),
        ("abc", TypeError, r"reference: q_d: got str, wants real numbers"),
        ((ZERO, ZERO, "x"), TypeError, r"reference: ddq_d: got str, wants real numbers"),
        ((ZERO, None, ZERO), TypeError, r"reference: dq_d: got NoneType, wants real numbers"),
        (
            (ZERO, ZERO, np.zeros(3)),
            ValueError,
            r"reference: ddq_d: got shape \(3,\), wants \(2,\)",
        ),
        ((0, 0, 0), ValueError, r"reference: q_d: got shape \(\), wants \(2,\)"),
    ],
)
def test_reference_that_returns_something_else_is_refused(
    value: Any, kind: Any, message: str
) -> None:
    for options in ({}, {"method": "dp54"}, {"control_period": 1e-3}):
        refused(kind, message, lambda o=options: simulate(reference=lambda t: value, **o))


@pytest.mark.parametrize(
    ("value", "kind", "message"),
    [
        (None, TypeError, r"disturbance: got NoneType, wants real numbers"),
        ("x", TypeError, r"disturbance: got str, wants real numbers"),
        ((1j, 0), TypeError, r"disturbance: got an array of dtype complex128"),
        (3.0, ValueError, r"disturbance: got shape \(\), wants \(2,\)"),
        (np.zeros((2, 1)), ValueError, r"disturbance: got shape \(2, 1\), wants \(2,\)"),
    ],
)
def test_disturbance_that_returns_something_else_is_refused(
    value: Any, kind: Any, message: str
) -> None:
    broken = sa.Plant(actual(), lambda q, dq, t: value)
    refused(kind, message, lambda: simulate(plant=broken))
    refused(kind, message, lambda: broken.step(ZERO, ZERO, ZERO, 0, 1e-3))


@pytest.mark.parametrize("bad", [NAN, INF, -INF])
def test_callback_without_a_number_ends_the_run_with_what_there_is(bad: float) -> None:
    def reference(t: float) -> Any:
        return ZERO, ZERO, (bad if t > 0.005 else 0.0, 0.0)

    def disturbance(q: np.ndarray, dq: np.ndarray, t: float) -> Any:
        return (bad if t > 0.005 else 0.0, 0.0)

    for change in ({"reference": reference}, {"plant": sa.Plant(actual(), disturbance)}):
        for options in ({}, {"method": "dp54"}, {"control_period": 1e-3}):
            ended = simulate(**change, **options)
            assert ended.status.kind == "diverged"
            assert ended.status.reason
            assert "finite" in ended.status.reason or "steps too short" in ended.status.reason
            for name in (
                "q",
                "dq",
                "tau",
                "rho",
                "rho_hat",
                "ddq_d",
                "V",
                "weights",
                "weights_norm",
            ):
                array = getattr(ended, name)
                assert array is None or np.isfinite(array).all(), name
    refused(
        ValueError,
        r"disturbance",
        lambda: sa.Plant(actual(), disturbance).step(ZERO, ZERO, ZERO, 1, 1e-3),
    )


def test_divergence_ends_the_run_with_time_and_cause() -> None:
    ended = simulate(q0=1e7)
    assert ended.status.kind == "diverged"
    assert ended.status.t == 0
    assert len(ended.t) == 0
    assert "passed 1e6" in str(ended.status)
    wild = run(tracker("concat", False, gain=7000), duration=5.0, control_period=0.1)
    assert wild.status.kind == "diverged"
    assert 0 < wild.status.t < 5
    assert wild.t[-1] <= wild.status.t
    assert all(
        np.isfinite(getattr(wild, name)).all() for name in ("q", "dq", "tau", "weights", "V")
    )


def test_argument_that_uses_the_tracker_is_refused() -> None:
    controller = tracker()

    class Meddler:
        def __init__(self, act: Callable[[], object]) -> None:
            self.act = act

        def __array__(self, *_: object, **__: object) -> np.ndarray:
            self.act()
            return ZERO

    for act in (controller.reset, lambda: run(controller)):
        with pytest.raises(TypeError, match=r"^q: got Meddler, wants real numbers \(RuntimeError"):
            controller.step(Meddler(act), ZERO, ZERO, ZERO, ZERO, 1e-3)
    assert controller.steps == 0
