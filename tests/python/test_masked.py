"""A masked entry is no number: a masked array is refused by name, wherever an array is taken."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from scenes import ZERO, basis, nominal, tracker
from test_refusals import EACH_MATRIX, EACH_SCALAR, EACH_VECTOR, SHAPES, refused, step


def masked(*shape: int) -> np.ma.MaskedArray:
    array = np.ma.array(np.ones(shape), mask=np.zeros(shape, dtype=bool))
    array[(-1,) * len(shape)] = np.ma.masked
    return array


@pytest.mark.parametrize(("call", "name", "wanted"), EACH_VECTOR)
def test_a_masked_vector_is_refused(call: Any, name: str, wanted: str) -> None:
    message = rf"{name}: got a masked array with 1 of 2 entries masked, wants a number in each"
    refused(ValueError, message, lambda: call(**{name: masked(2)}))
    refused(ValueError, f"{name}: got a masked array", lambda: call(**{name: masked(4)[1::2]}))
    refused(ValueError, f"{name}: got a masked array", lambda: call(**{name: [1.0, np.ma.masked]}))


@pytest.mark.parametrize(("call", "name"), EACH_SCALAR)
def test_a_masked_scalar_is_refused(call: Any, name: str) -> None:
    message = f"{name}: got a masked array with 1 of 1 entries masked"
    refused(ValueError, message, lambda: call(**{name: np.ma.masked}))
    refused(ValueError, message, lambda: call(**{name: np.ma.array(1.0, mask=True)}))


@pytest.mark.parametrize(("call", "name"), EACH_MATRIX)
def test_a_masked_matrix_is_refused(call: Any, name: str) -> None:
    rows = masked(*SHAPES[name])
    for value in (rows, list(rows), tuple(list(rows))):
        refused(ValueError, rf"{name}: got a masked array", lambda v=value: call(**{name: v}))


def test_masked_centers_times_and_results_of_callables_are_refused() -> None:
    refused(ValueError, "centers: got a masked", lambda: sa.FuzzyBasis("grid", masked(3), 1.0))
    refused(ValueError, "centers: got a masked", lambda: sa.FuzzyBasis("grid", masked(4, 3), 1.0))
    refused(ValueError, "width: got a masked", lambda: sa.FuzzyBasis("grid", [0, 1], masked(2)))
    refused(ValueError, "t: got a masked", lambda: sa.Table(masked(2), np.zeros((2, 2))))
    plant = sa.Plant(nominal(), lambda q, dq, t: masked(2))
    refused(
        ValueError, "disturbance: got a masked", lambda: plant.step(ZERO, ZERO, ZERO, 0.0, 1e-3)
    )
    refused(ValueError, "q: got a masked", lambda: nominal().gravity(masked(2)))
    refused(ValueError, "x: got a masked", lambda: basis().evaluate(masked(3, 4)))


def test_a_masked_sample_leaves_the_state_alone() -> None:
    controller = tracker("shared")
    controller.step(*[ZERO] * 5, 1e-3)
    before = controller.__getstate__()
    with pytest.raises(ValueError, match=re.escape("dq: got a masked array")):
        controller.step(ZERO, masked(2), ZERO, ZERO, ZERO, 1e-3)
    assert controller.__getstate__() == before


def test_an_array_without_masked_entries_is_an_array() -> None:
    """So is one of another class made of numpy's."""
    plain = step(q=np.array([0.1, 0.2]))
    for same in (
        np.ma.array([0.1, 0.2]),
        np.ma.array([0.1, 0.2], mask=[False, False]),
        [np.ma.array(0.1), 0.2],
        np.array([0.1, 0.2]).view(np.recarray),
    ):
        assert step(q=same).tobytes() == plain.tobytes()


CENTERS = (-1.0, 0.0, 1.0)


def lists(count: int) -> sa.FuzzyBasis:
    return sa.FuzzyBasis("per_joint", [CENTERS] * count, 1.0)


def test_a_wrong_number_of_centers_is_told_as_one() -> None:
    """Six lists, one a joint: the inputs (e, de) of six joints want twelve."""
    six = r"centers: got 6 lists, one for each input of 3 joints, wants one list, or 12 for the 6"
    for change, of in (
        ({"q": np.ones(12)}, "q"),
        ({"q": np.eye(12)}, "q"),
        ({"gain": np.ones(6)}, "gain"),
    ):
        refused(
            ValueError,
            f"{six} joints of {of}",
            lambda c=change: sa.FuzzyCompensator(lists(6), **c),
        )
    arm = sa.Serial.shipped("ur5e")
    message = f"compensator: got one of 3 joints, wants one of 6; {six} joints of the arm"
    refused(
        ValueError,
        message,
        lambda: sa.ComputedTorque(arm, 8, 5.5, sa.FuzzyCompensator(lists(6))),
    )
    sa.ComputedTorque(arm, 8, 5.5, sa.FuzzyCompensator(lists(12), q=np.ones(12), gain=np.ones(6)))
    refused(
        ValueError, r"q: got shape \(3,\), wants", lambda: sa.FuzzyCompensator(lists(6), q=[1] * 3)
    )
