"""The paper's simulations and every way to read the third one, as rows of numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from . import _core, paper
from .run import Array, Run

WINDOW = (20.0, 40.0)
"""The steady part of a run, over which the RMS error is taken [s]."""

FORMS = ("grid", "shared", "concat", "per_joint")
GAINS = (1 / 7, 7.0, 70.0)

INERT, WORKS = 0.05, 5.0
"""A compensator that takes less than 5 % off the error is inert; one that divides it by 5 works."""

Row = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """One simulation of the paper; the third with the way it is read."""

    simulation: Literal[1, 2, 3]
    form: str | None = None
    normalized: bool | None = None
    gain: float | None = None
    inputs: str | None = None

    @property
    def preset(self) -> str | None:
        """Name of the preset of simulation 3 that this is."""
        if self.inputs != "error":
            return None
        reading = {"form": self.form, "normalized": self.normalized, "gain": self.gain}
        return next((name for name, preset in paper.PRESETS.items() if preset == reading), None)

    @property
    def name(self) -> str:
        """Like "simulation 3, claimed"."""
        return f"simulation {self.simulation}" + (f", {self.preset}" if self.preset else "")

    def run(self) -> Run:
        """Simulate."""
        reading: dict[str, Any] = {
            "form": self.form,
            "normalized": self.normalized,
            "gain": self.gain,
            "inputs": self.inputs,
        }
        given = {name: value for name, value in reading.items() if value is not None}
        return paper.simulation(self.simulation, **given).run()

    def row(self, run: Run) -> Row:
        """Plain numbers, joint by joint: RMS over `WINDOW`, maxima over the whole run.

        The figures of a run that did not finish are None.
        """
        row: Row = {
            "simulation": self.simulation,
            "form": self.form,
            "normalized": self.normalized,
            "gain": self.gain,
            "inputs": self.inputs,
            "rms_e": None,
            "max_abs_e": None,
            "max_abs_tau": None,
            "preset": self.preset,
            "status": str(run.status),
        }
        if run.status.finished:
            whole = run.metrics()
            row["rms_e"] = run.metrics(WINDOW).rms_e.tolist()
            row["max_abs_e"] = whole.max_abs_e.tolist()
            row["max_abs_tau"] = whole.max_abs_tau.tolist()
        return row


def cases() -> Iterator[Case]:
    """Simulations 1 and 2, then 3 for every form, normalised or raw, and three gains.

    Both presets are among them, and one compensator that sees the state instead of the error.
    """
    yield Case(1)
    yield Case(2)
    for form in FORMS:
        for normalized in (True, False):
            for gain in GAINS:
                yield Case(3, form, normalized, gain, "error")
    yield Case(3, "grid", True, 7.0, "state")


def approximation() -> Iterator[tuple[int, float]]:
    """Rules and largest error of fuzzy systems fitted to a smooth function on [-2, 2]².

    Grids of 2 to 24 sets an input, each as wide as the spacing of their centres, fitted by least
    squares on three points a set and input; the error is taken on 201 x 201 points.
    """
    fine = _square(201)
    wanted = _smooth(fine)
    for sets in (2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24):
        centers = np.linspace(-2.0, 2.0, sets)
        basis = _core.FuzzyBasis("grid", centers, float(centers[1] - centers[0]))
        samples = _square(3 * sets)
        fit = _core.FuzzyApproximator.fit(basis, samples, _smooth(samples))
        yield sets**2, float(np.abs(fit(fine) - wanted).max())


def _square(points: int) -> Array:
    """A grid on [-2, 2]², one point a row."""
    axis = np.linspace(-2.0, 2.0, points)
    return np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)


def _smooth(x: Array) -> Array:
    """g(x, y) = sin(2x + cos y) exp(-y²/4), as a column."""
    value = np.sin(2 * x[:, 0] + np.cos(x[:, 1])) * np.exp(-(x[:, 1] ** 2) / 4)
    return np.asarray(value)[:, None]


def table(rows: Sequence[Row]) -> str:
    """Align the rows under a header with units."""
    head = (
        f"{'':3} {'':9} {'':10} {'':>4} {'':6} {'':8} |  RMS error [rad]  "
        "| max |error| [rad] | max |torque| [N·m]\n"
        f"{'sim':3} {'form':9} {'strengths':10} {'gain':>4} {'inputs':6} {'preset':8} "
        + "|  joint 1  joint 2 " * 2
        + "|  joint 1  joint 2"
    )
    rule = "-" * max(len(line) for line in head.splitlines())
    return "\n".join([head, rule, *(_line(row) for row in rows)])


def verdict(rows: Sequence[Row]) -> str:
    """Say in two sentences what the numbers show about the paper's claim."""
    without = next(row for row in rows if row["simulation"] == 2)
    printed = next(row for row in rows if row["preset"] == "printed")
    claimed = next(row for row in rows if row["preset"] == "claimed")
    return (
        "As printed (Γ = diag(7, 7), so a gain of 1/7) the compensator "
        f"{_effect(printed, without)}:\nRMS error {_pair(printed)} rad, "
        f"against {_pair(without)} rad without it.\n"
        "Read with Γ as the gain and with raw firing strengths it "
        f"{_effect(claimed, without)}:\nRMS error {_pair(claimed)} rad{_factors(claimed, without)}."
    )


def _line(row: Row) -> str:
    strengths = {None: "", True: "normalised", False: "raw"}[row["normalized"]]
    gain = "" if row["gain"] is None else str(Fraction(row["gain"]).limit_denominator(1000))
    words = f"{row['form'] or '':9} {strengths:10} {gain:>4} {row['inputs'] or '':6}"
    line = f"{row['simulation']:3} {words} {row['preset'] or '':8} "
    if row["rms_e"] is None:
        return line + f"| {row['status']}"
    errors = (f"| {a:8.3g} {b:8.3g} " for a, b in (row["rms_e"], row["max_abs_e"]))
    one, two = row["max_abs_tau"]
    return line + "".join(errors) + f"| {one:8.2f} {two:8.2f}"


def _effect(row: Row, without: Row) -> str:
    """What the compensator does to the error: the joint that gains least decides."""
    if row["rms_e"] is None or without["rms_e"] is None:
        return "cannot be judged, a run did not finish"
    left = [a / b for a, b in zip(row["rms_e"], without["rms_e"], strict=True)]
    if max(left) > 1 + INERT:
        return "makes the error larger"
    if max(left) > 1 - INERT:
        return "is inert"
    if max(left) > 1 / WORKS:
        return "helps, but does not take the error away"
    return "does what the paper claims"


def _factors(row: Row, without: Row) -> str:
    """By how much the error is smaller."""
    if row["rms_e"] is None or without["rms_e"] is None:
        return ""
    factors = [b / a for a, b in zip(row["rms_e"], without["rms_e"], strict=True)]
    return ", " + " / ".join(f"{factor:.3g}" for factor in factors) + " times less than without it"


def _pair(row: Row) -> str:
    if row["rms_e"] is None:
        return "(none)"
    return " / ".join(f"{value:.3f}" for value in row["rms_e"])
