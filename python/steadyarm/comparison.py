"""One table of controllers: what each did in each scenario, over all seeds.

>>> scene = sa.paper.simulation(2)
>>> rows = [Row.of(scene.run(), controller="computed torque", scenario="paper 2")]
>>> print(Comparison(rows))
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from operator import index
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsIndex

from . import _figures
from ._curves import Curves
from ._documented import documented
from ._figures import FIGURES, Value, Window

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped, import-not-found, unused-ignore]
    from numpy.typing import ArrayLike

    from .run import Run

STATUSES = ("finished", "interrupted", "refused", "unresolved", "diverged", "raised")
"""How a run can end, from the best to the worst.

A run that is "refused" never began: a condition said no when the controller was built. One that
"raised" ended with an exception of the controller. See `Status` for the others.
"""

SORT = "steady_rms_e"
"""The figure that tables are sorted by, unless another is asked for."""


@dataclass(frozen=True)
class Row:
    """What one controller did in one scenario with one seed.

    A figure is None where it does not apply: of a run that did not reach its duration there is
    none, for what a controller did in a part of its time is no match for what others did in all of
    it. ``FIGURES`` of this module has the unit and meaning of each; m and N stand for rad and N·m
    of a prismatic joint. Equal rows have equal figures; ``step_time`` and ``curves`` are not
    compared.
    """

    controller: str
    """What the controller is called."""
    scenario: str = ""
    """What the scenario is called."""
    seed: int = 0
    """Seed of all that is random in it."""
    status: str = "finished"
    """One of ``STATUSES``."""
    reason: str = ""
    """Why the run ended, in words; empty if it just finished."""
    rms_e: Value = None
    max_abs_e: Value = None
    steady_rms_e: Value = None
    settling_time: Value = None
    itae: Value = None
    max_abs_tau: Value = None
    rms_tau: Value = None
    torque_variation: Value = None
    saturated: Value = None
    recovery: Value = None
    frozen_rms_e: Value = None
    transfer_rms_e: Value = None
    step_time: Value = field(default=None, compare=False)
    by_joint: Mapping[str, tuple[Value, ...]] = field(default_factory=dict, hash=False)
    """The figures of each joint, by name."""
    curves: Curves | None = field(default=None, compare=False, repr=False)
    """Error, torque and position over time, thinned for pictures."""

    def __post_init__(self) -> None:
        for name in ("controller", "scenario", "reason"):
            _check_text(name, getattr(self, name))
        if not self.controller:
            raise ValueError("controller: got '', wants a name")
        if isinstance(self.seed, bool) or not isinstance(self.seed, SupportsIndex):
            raise TypeError(f"seed: got {self.seed!r}, wants an int")
        object.__setattr__(self, "seed", index(self.seed))
        if self.status not in STATUSES:
            raise ValueError(f"status: got {self.status!r}, wants one of {', '.join(STATUSES)}")
        for name in FIGURES:
            object.__setattr__(self, name, _figures.number(name, getattr(self, name)))
        object.__setattr__(self, "by_joint", _figures.joints_of(self.by_joint))

    @classmethod
    def of(
        cls,
        run: Run,
        *,
        controller: str,
        scenario: str = "",
        seed: int = 0,
        window: Window | None = None,
        band: float = 0.01,
        effort_limit: ArrayLike | None = None,
        events: Iterable[float] = (),
        step_time: float | None = None,
        frozen: Run | None = None,
        transfer: Run | None = None,
        transfer_window: Window | None = None,
        curves: bool = True,
    ) -> Row:
        """Compute the figures of a run.

        Parameters
        ----------
        run: what `simulate` returned.
        controller, scenario, seed: what the row is called.
        window: (from, to) [s] of the steady figures; the second half of the run by default.
        band: an error within it counts as settled, and as recovered [rad].
        effort_limit: largest torque, a number or one a joint [N·m]; without it no figure tells of
            saturation.
        events: times at which something happened, such as a payload picked up or a push [s].
        step_time: time of the processor for one step [s].
        frozen: the same run with learning stopped; None for a controller that does not learn.
        transfer: a run with learning stopped along another motion, with its ``transfer_window``.
        curves: whether to keep thinned curves for the page.

        Raises
        ------
        ValueError
            For a window without a sample, a limit that is not positive or of another number of
            joints, and for text that no file can hold.
        """
        kind, reason = run.status.kind, run.status.reason
        if kind in ("diverged", "interrupted"):
            reason = f"at t = {run.status.t:.6g} s because {reason}"
        joints = {}
        if kind in ("finished", "unresolved"):
            joints = _figures.figures(run, window, band, effort_limit, events)
            others = {
                "frozen_rms_e": (frozen, window),
                "transfer_rms_e": (transfer, transfer_window),
            }
            for name, (other, its_window) in others.items():
                left = None if other is None else _figures.survives(other, its_window)
                joints |= {} if left is None else {name: left}
        joints = {name: figure for name, figure in joints.items() if len(figure)}
        overall: dict[str, Any] = {
            name: _figures.over_all(name, figure, run, effort_limit)
            for name, figure in joints.items()
        }
        return cls(
            controller,
            scenario,
            seed,
            kind,
            reason,
            **overall,
            step_time=step_time,
            by_joint={name: tuple(figure.tolist()) for name, figure in joints.items()},
            curves=Curves.of(run) if curves and len(run.t) else None,
        )

    @property
    def finished(self) -> bool:
        """Whether the run reached its duration, in steps that followed the motion."""
        return self.status == "finished"

    def figures(self) -> dict[str, Value]:
        """All figures by name; that of joint 2 has the name "rms_e_2"."""
        named: dict[str, Value] = {}
        for name in FIGURES:
            named[name] = getattr(self, name)
            joints = enumerate(self.by_joint.get(name, ()), start=1)
            named |= {f"{name}_{joint}": value for joint, value in joints}
        return named


documented(
    Row, {name: f"{it.doc[0].upper()}{it.doc[1:]} [{it.unit}]." for name, it in FIGURES.items()}
)


@documented
@dataclass(frozen=True)
class Line:
    """A line of the table: one controller in one scenario, over all seeds."""

    controller: str
    """What the controller is called."""
    scenario: str
    """What the scenario is called."""
    runs: int
    """Number of seeds."""
    finished: int
    """How many of them finished."""
    status: str
    """The worst that happened, the last of them in ``STATUSES``."""
    reason: str
    """Its reason, of the first seed that it happened to."""
    median: Mapping[str, Value]
    """Median over the seeds that have the figure, by the names of `Row.figures`."""
    worst: Mapping[str, Value]
    """The largest of them."""
    shown: Row
    """The row whose curves stand for the line: that of the median steady error."""

    @classmethod
    def of(cls, rows: Sequence[Row]) -> Line:
        """Aggregate the rows of one controller in one scenario."""
        last = max(rows, key=lambda row: STATUSES.index(row.status))
        figures = [row.figures() for row in rows]
        values = {
            name: [value for figure in figures if (value := figure.get(name)) is not None]
            for name in _names(rows)
        }
        median = {name: _figures.median(known) for name, known in values.items()}
        return cls(
            controller=rows[0].controller,
            scenario=rows[0].scenario,
            runs=len(rows),
            finished=sum(row.finished for row in rows),
            status=last.status,
            reason=last.reason,
            median=median,
            worst={name: max(known, default=None) for name, known in values.items()},
            shown=min(rows, key=lambda row: _distance(row, median[SORT])),
        )


@documented
@dataclass(frozen=True)
class Comparison:
    """Rows of controllers, and the tables, files and the page made of them.

    Printed, it is a table for a terminal; in a notebook, one of HTML. Rows that did not finish stay
    in it, with their reason. The same rows give the same bytes. Numbers have three digits where
    people read them, and all in files.
    """

    rows: Sequence[Row]
    """What each controller did in each scenario with each seed."""
    scenario: str = ""
    """What was compared: a title, or the text of the scenario file."""
    notes: Sequence[str] = ()
    """What a reader must know, a sentence each."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", tuple(self.rows))
        for place, row in enumerate(self.rows):
            if not isinstance(row, Row):
                raise TypeError(f"rows[{place}]: got {type(row).__name__}, wants a Row")
        if isinstance(self.notes, str):
            raise TypeError(f"notes: got {self.notes!r}, wants a list of sentences")
        object.__setattr__(self, "notes", tuple(self.notes))
        for name, text in (("scenario", self.scenario), *(("notes", note) for note in self.notes)):
            _check_text(name, text)

    def table(self, sort: str | None = SORT) -> list[Line]:
        """Aggregate the rows per controller and scenario: median and worst over the seeds.

        Scenarios keep their order. In each, controllers that always finished come first, then those
        that did at times, then the others; among them the least median of ``sort`` first: a name of
        `Row.figures`, or "controller" for the alphabet. None keeps the order of the rows. Raises
        ValueError for another name.
        """
        if sort not in (None, "controller", *FIGURES, *_names(self.rows)):
            wants = f"controller, None, or one of {', '.join(FIGURES)}"
            raise ValueError(f"sort: got {sort!r}, wants {wants}")
        groups: dict[str, dict[str, list[Row]]] = {}
        for row in self.rows:
            groups.setdefault(row.scenario, {}).setdefault(row.controller, []).append(row)
        lines: list[Line] = []
        for group in groups.values():
            part = [Line.of(rows) for rows in group.values()]
            lines += part if sort is None else sorted(part, key=lambda line: _rank(line, sort))
        return lines

    def to_csv(self, path: str | Path) -> None:
        """Write the rows, one a line, all figures in full; None is an empty cell.

        Curves, scenario and notes are not in it: `to_json` keeps them.
        """
        from . import _comparison_files

        _comparison_files.to_csv(self, path)

    @classmethod
    def from_csv(cls, path: str | Path) -> Comparison:
        """Read what `to_csv` wrote. Raises ValueError that names the line and the column."""
        from . import _comparison_files

        return cls(_comparison_files.from_csv(path))

    def to_json(self, path: str | Path) -> None:
        """Write all that there is: rows, curves, scenario and notes, units and a version."""
        from . import _comparison_files

        _comparison_files.to_json(self, path)

    @classmethod
    def from_json(cls, path: str | Path) -> Comparison:
        """Read what `to_json` wrote. Raises ValueError that names the key."""
        from . import _comparison_files

        return cls(**_comparison_files.from_json(path))

    def to_markdown(self, sort: str | None = SORT) -> str:
        """The table in Markdown: the median, and in brackets the worst where it is another."""
        from . import _comparison_words

        return _comparison_words.markdown(self, sort)

    def to_html(self, path: str | Path, *, arm: Any = None, sort: str | None = SORT) -> None:
        """Write a page of one file that needs no network: table, curves, error against torque.

        With an ``arm``, a `TwoLink` or a `Serial`, two controllers move it side by side.
        """
        from . import _comparison_page, _files

        _files.content(path, _comparison_page.page(self, arm, sort).encode())

    def to_pandas(self) -> pandas.DataFrame:
        """A table with a row for every row, columns as those of `to_csv`. Needs pandas."""
        from ._extras import imported

        names, lines = self.columns()
        frame = imported("pandas", "to_pandas").DataFrame(lines, columns=names)
        frame.attrs = {"units": {name: figure.unit for name, figure in FIGURES.items()}}
        return frame

    def columns(self) -> tuple[list[str], list[list[Any]]]:
        """Names of the columns, and the cells of every row: texts, an int, numbers and None."""
        names = _names(self.rows)
        lines = []
        for row in self.rows:
            figures = row.figures()
            head = [row.controller, row.scenario, row.seed, row.status, row.reason]
            lines.append([*head, *map(figures.get, names)])
        return ["controller", "scenario", "seed", "status", "reason", *names], lines

    def __str__(self) -> str:
        from . import _comparison_words

        return _comparison_words.text(self, SORT)

    def _repr_html_(self) -> str:
        from . import _comparison_page

        return _comparison_page.fragment(self, SORT)


def _names(rows: Iterable[Row]) -> list[str]:
    """Names of the figures that rows have, in the order of `FIGURES`, each before its joints."""
    return sorted({*FIGURES, *(name for row in rows for name in row.figures())}, key=_order)


def _order(name: str) -> tuple[int, int]:
    """Place of a figure's name among others."""
    figures = list(FIGURES)
    if name in FIGURES:
        return figures.index(name), 0
    figure, joint = name.rsplit("_", 1)
    return figures.index(figure), int(joint)


def _rank(line: Line, sort: str) -> tuple[int, bool, Any]:
    """What lines are sorted by."""
    share = 0 if line.finished == line.runs else 1 if line.finished else 2
    if sort == "controller":
        return 0, False, line.controller
    value = line.median.get(sort)
    return share, value is None, 0.0 if value is None else value


def _distance(row: Row, median: Value) -> float:
    """How far the steady error of a row is from the median; of rows without curves, the most."""
    value = row.steady_rms_e
    if row.curves is None:
        return float("inf")
    if value is None or median is None:
        return 1e300
    return 0.0 if value == median else min(abs(value - median), 1e299)


def _check_text(name: str, text: object) -> None:
    if not isinstance(text, str):
        raise TypeError(f"{name}: got {text!r}, wants text")
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise ValueError(f"{name}: got {text!r}, wants text that UTF-8 can hold") from error
