"""Every name of the cheat sheet is there, with the unit and the shape that it says."""

import inspect
import re

import numpy as np
import pytest
import steadyarm as sa
from steadyarm.metrics import UNITS
from test_docs import DOCS
from test_docs_compare import rows, ticked

PAGE = DOCS / "cheat_sheet.md"


@pytest.fixture(scope="module")
def run() -> sa.Run:
    """One that has every signal: a compensator, and effects."""
    basis = sa.FuzzyBasis("shared", (-0.5, 0.0, 0.5), 0.3)
    compensator = sa.FuzzyCompensator(basis)
    tracker = sa.ComputedTorque(sa.paper.nominal(), 8, 5.5, compensator=compensator)
    plant, path = sa.paper.simulation(2).plant, sa.paper.reference()
    loop = {"control_period": 1e-3, "effects": sa.Effects(encoder_bits=16)}
    return sa.simulate(plant, tracker, path, 0.1, **loop)


def shape(words: str, joints: int, samples: int = 0) -> tuple[int, ...]:
    """(T, n), (n, 10n) and the like in numbers."""
    sizes = {"T": samples, "n": joints, "10n": 10 * joints}
    cells = words.strip("()").rstrip(",").split(", ")
    return tuple(sizes[cell] if cell in sizes else int(cell) for cell in cells)


def test_every_signal_of_a_run_is_told_with_its_unit_and_shape(run) -> None:
    told = {}
    for first in ("symbol | name | unit | shape", "what | name | unit | shape"):
        for *_, name, unit, form in (split(row) for row in rows(PAGE, first)):
            told[name.strip("`")] = (unit, shape(form, 2, len(run.t)))
    channels = run.channels.values()
    assert told == {it.name: (it.unit, (len(run.t), *it.shape)) for it in channels}
    assert all(getattr(run, name).shape == form for name, (_, form) in told.items())


def split(row: list[str]) -> list[str]:
    """The last three cells: a norm has bars in its symbol."""
    return row[-3:]


def test_every_figure_is_told_with_its_unit(run) -> None:
    told = {name.strip("`"): unit for name, unit, *_ in rows(PAGE, "name | unit | what")}
    assert told == UNITS
    assert all(getattr(run.metrics(), name).shape == (2,) for name in told)


def test_what_an_arm_gives_has_the_shape_that_is_told() -> None:
    arm = sa.Serial.shipped("panda")
    values = {name: np.zeros(arm.joints) for name in ("q", "dq", "ddq", "tau")}
    told = rows(PAGE, "equation | call")
    assert len(told) == 10
    for _, call, _, form in told:
        assert eval(call.strip("`"), {"arm": arm, **values}).shape == shape(form, arm.joints), call


def test_every_number_is_an_argument_of_what_it_is_told_to_be_of() -> None:
    for _, names, units, of in rows(PAGE, "symbol | name | unit | of"):
        assert len(units.split(", ")) in (1, len(ticked(names))), names
        known = inspect.signature(getattr(sa, of.strip("`").removeprefix("sa."))).parameters
        assert set(ticked(names)) <= set(known), names


def test_equations_have_the_numbers_of_the_theory() -> None:
    theory = (DOCS / "theory.md").read_text(encoding="utf-8")
    tags = set(re.findall(r"\d+", " ".join(re.findall(r"\\tag\{(.+?)\}", theory))))
    told = " ".join(number for number, _ in rows(PAGE, "number | equation"))
    assert tags <= set(re.findall(r"\d+", told))


def test_there_are_ten_calls() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert re.findall(r"# (\d+):", text) == [str(number) for number in range(1, 11)]
