"""What a run did, for the command line: in words, and as JSON."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _figures
from ._figures import FIGURES, JOINTED
from ._joints import title
from .attribution import Attribution, attribution
from .learned import learned

if TYPE_CHECKING:
    from .run import Run

COLUMNS = ("rms_e", "max_abs_e", "rms_tau", "max_abs_tau", "torque_variation")
"""Metrics of a joint that a table has."""

LATE = ("rms_e", "rms_tau", "torque_variation")
"""Metrics over the window; the others are over the whole run."""

OF_ONE_RUN = JOINTED[: JOINTED.index("frozen_rms_e")]
"""Figures that one run has, joint by joint."""

MUCH = 0.05
"""Share of the time at the largest torque that is said."""

WIDTH, PAGE = 14, 98
"""Characters of a column, and of a line of words."""


@dataclass(frozen=True)
class Report:
    """A run, and what the figures need to know of its scene."""

    run: Run
    head: Mapping[str, str]
    """Lines before the figures: what, and its words."""
    asked: Mapping[str, Any]
    """The same for programs."""
    window: tuple[float, float] | None = None
    """Of the steady figures [s]; None: the second half."""
    band: float = 0.01
    effort_limit: Any = None
    events: Sequence[float] = ()
    tail: Sequence[str] = ()
    """Lines behind the figures."""
    arm: Any = None
    """The arm that is there."""

    @property
    def steady(self) -> tuple[float, float]:
        """The window of the steady figures [s]."""
        return _figures.steady_window(self.run, self.window)

    def words(self) -> str:
        """What happened, in lines."""
        head = {**self.head, "status": str(self.run.status)}
        lines = [f"{what:12}{line}" for what, text in head.items() for line in text.splitlines()]
        if not len(self.run.t):
            return "\n".join(lines)
        return "\n".join([*lines, "", *self._table(), "", *self._more()]).rstrip()

    def _table(self) -> list[str]:
        """The metrics, a joint a line."""
        begin, end = self.steady
        late, whole = self.run.metrics(self.steady), self.run.metrics()
        columns = [
            (it.head, it.shown, it.scale * getattr(late if name in LATE else whole, name), ".4g")
            for name in COLUMNS
            if (it := FIGURES[name])
        ]
        if self.effort_limit is not None:
            share = whole.max_abs_tau / np.broadcast_to(self.effort_limit, (self.run.joints,))
            columns.append(("of its limit", "%", 100.0 * share, ".3g"))
        names = [title(name) for name in self.run.joint_names]
        wide = max(map(len, names)) + 2
        rows = [
            [head for head, *_ in columns],
            [f"[{unit}]" for _, unit, *_ in columns],
            *([f"{values[n]:{form}}" for *_, values, form in columns] for n in range(len(names))),
        ]
        lines = [
            f"{name:{wide}}" + "".join(f"{cell:>{WIDTH}}" for cell in row)
            for name, row in zip(["", "", *names], rows, strict=True)
        ]
        lines.append(
            f"RMS and variation over {begin:.4g} to {end:.4g} s, maxima over the whole run, with "
            "its start."
        )
        if self.arm is not None and "prismatic" in self.arm.joint_kinds:
            lines.append("For a prismatic joint read mm for mrad, and N for N·m.")
        return lines

    def _more(self) -> list[str]:
        """What there is to say beyond the figures."""
        return [*self._limited(), *self._learnt(), *self.tail]

    def _limited(self) -> list[str]:
        """Where the largest torque does not do."""
        share = _figures.figures(self.run, self.window, self.band, self.effort_limit, ())
        joints = np.flatnonzero(share.get("saturated", np.zeros(1)) > MUCH)
        if not len(joints):
            return []
        named = ", ".join(self.run.joint_names[joint] for joint in joints)
        return [
            f"limit       {named}: at the largest torque in over {100 * MUCH:g} % of the time",
            "            no controller does more there; a lighter load or a slower motion might",
        ]

    def _learnt(self) -> list[str]:
        """The load that a recommended controller found."""
        said = self._learned()
        if said is None or said["payload"] is None:
            return []
        load = f"{said['payload']:.3g} ± {said['payload_deviation']:.2g} kg"
        return [f"learnt      a load of {load} at the tip, beyond what the model says"]

    def _learned(self) -> dict[str, Any] | None:
        """What `learned` says of the tracker, as far as it is of use; None for another law."""
        tracker = self.run.tracker
        try:
            it = learned(tracker)  # type: ignore[arg-type]
        except TypeError:
            return None
        names = ("bandwidth", "cut_off", "condition", "payload", "payload_deviation", "payload_com")
        return {name: getattr(it, name) for name in names}

    def plain(self) -> dict[str, Any]:
        """All of it by the names of the Python API, in SI units; null where there is none."""
        run = self.run
        ended = {"status": run.status.kind, "t": run.status.t, "reason": run.status.reason}
        whole = run.status.kind in ("finished", "unresolved") and len(run.t) > 0
        found = (
            _figures.figures(run, self.window, self.band, self.effort_limit, self.events)
            if whole
            else {}
        )
        return {
            **self.asked,
            **ended,
            "joint_names": run.joint_names,
            "window": self.steady if len(run.t) else None,
            **{name: found.get(name) for name in OF_ONE_RUN},
            "units": {name: FIGURES[name].unit for name in OF_ONE_RUN},
            "learned": self._learned() if whole else None,
            "certificate": None if run.certificate is None else asdict(run.certificate),
            "notes": list(run.notes),
        }


def why(report: Report, picture: Path | None) -> tuple[str, dict[str, Any]]:
    """Why the error is what it is in the window of the steady figures: in words, and as JSON."""
    try:
        found = attribution(report.run, window=report.steady)
    except ValueError as error:  # of a run that ended early
        return f"why         {error}", {"why": None, "why_reason": str(error)}
    if picture is not None:
        found.plot().savefig(picture)
    return f"\n{found}", {"why": _shares(found)}


def _shares(found: Attribution) -> dict[str, Any]:
    parts = ("rms_of_error", "error_shares", "rms_error", "torque_shares", "rms_torque")
    shares: dict[str, Any] = {name: getattr(found, name) for name in (*parts, "cancelled")}
    return {**shares, "window": found.window, "notes": list(found.notes)}


def itemized(sentences: Iterable[str]) -> list[str]:
    """Sentences as items, within the width of a page."""
    form: dict[str, Any] = {"initial_indent": "  - ", "subsequent_indent": "    "}
    whole: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    return [line for it in sentences for line in textwrap.wrap(it, PAGE, **form, **whole)]


def finite(limit: Any) -> Any:
    """An effort limit that some joint has; None for none."""
    return limit if any(map(math.isfinite, np.ravel(limit))) else None
