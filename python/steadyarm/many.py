"""Many runs at a time: figures of each, and the records if they are wanted."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from operator import index
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _many_tables, _many_threads, _stopping
from ._documented import documented
from ._joints import lengths, numbered
from ._many_given import Given, given
from ._progress import Progress
from ._scene import OPTIONS, joint_names
from .compare_runner import BEFORE, threads_of
from .metrics import NAMES, Metrics
from .record import Status
from .run import Run
from .simulation import Reference, recorded

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped, import-not-found, unused-ignore]

Array = NDArray[np.float64]

UNBEGUN = ("interrupted", 0.0, BEFORE)
"""How a run ended that was not begun."""


@documented
@dataclass(frozen=True, eq=False, repr=False)
class Runs:
    """What `simulate_many` returns: the figures of M runs of n joints, and how each ended.

    ``len(runs)`` is M. With records, ``runs[i]`` is the `Run` of `simulate`, its notes with it, and
    ``for run in runs`` goes through them. Figures are NaN of a run that was interrupted, that
    raised, or that has no row in the window. Printed as a table. For a prismatic joint m and N
    stand for rad and N·m.
    """

    rms_e: Array
    """Root mean square of the error (M, n) [rad]."""
    max_abs_e: Array
    """Largest error (M, n) [rad]."""
    itae: Array
    """∫ t |e| dt, t from the start of the window (M, n) [rad·s²]."""
    settling_time: Array
    """Time after which the error stays within the band (M, n) [s]; inf if it does not."""
    rms_tau: Array
    """Root mean square of the torque (M, n) [N·m]."""
    max_abs_tau: Array
    """Largest torque (M, n) [N·m]."""
    torque_variation: Array
    """How much the torque moves, Σ|Δτ| per second (M, n) [N·m/s]."""
    status: tuple[Status, ...]
    """How each run ended, and why."""
    # Names of the joints and what each moves in, of all runs or of each.
    _named: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]
    _records: tuple[Run | None, ...] | None

    @property
    def finished(self) -> NDArray[np.bool_]:
        """Which runs have the status "finished" (M,)."""
        return np.array([status.finished for status in self.status])

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return int(self.rms_e.shape[1])

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The names of the plants' joints; their numbers, from 1, where names differ."""
        names = {names for names, _ in self._named}
        return names.pop() if len(names) == 1 else numbered(self.joints)

    def __len__(self) -> int:
        return len(self.status)

    def __getitem__(self, run: int) -> Run:
        if self._records is None:
            raise ValueError(
                "record: got None, and no run was kept; wants record='motion' or 'all'"
            )
        run = self._place(run)
        kept = self._records[run]
        if kept is None:
            raise ValueError(f"run {run}: got no record of it, for {self.status[run].reason}")
        return kept

    def __iter__(self) -> Iterator[Run]:
        return (self[run] for run in range(len(self)))

    def metrics(self, run: int) -> Metrics:
        """The figures of one run, by its number from 0; raises IndexError if there is none."""
        run = self._place(run)
        names, moves = self._named[run if len(self._named) > 1 else 0]
        figures = {name: getattr(self, name)[run] for name in NAMES}
        return Metrics(**figures, joint_names=names, units=moves)

    def _place(self, run: int) -> int:
        if not hasattr(run, "__index__"):
            raise TypeError(f"run: got {run!r:.80}, wants a whole number")
        place = index(run)
        if not -len(self) <= place < len(self):
            raise IndexError(f"run: got {place}, wants 0 to {len(self) - 1}")
        return place % len(self)

    def table(self) -> dict[str, NDArray[Any]]:
        """All of it in columns (M,) by name: "status", "t_end" [s], "reason", then the figures.

        Those of joint 1 are "rms_e_1" and so on.
        """
        return _many_tables.table(self)

    def to_pandas(self) -> pandas.DataFrame:
        """The same as a table with a row a run; ``frame.attrs`` has "units". Needs pandas."""
        return _many_tables.to_pandas(self)

    def __str__(self) -> str:
        return _many_tables.text(self)

    def __repr__(self) -> str:
        return f"Runs({_many_tables.counted(self)})"

    def _repr_html_(self) -> str:
        return _many_tables.html(self)


def simulate_many(
    plant: _core.Plant | Sequence[_core.Plant],
    tracker: _core.Controller | _core.Guard | Sequence[_core.Controller | _core.Guard],
    reference: Reference | Sequence[Reference],
    duration: float = 40.0,
    dt: float = 1e-3,
    method: Literal["rk4", "dp54"] = "rk4",
    *,
    changes: Sequence[Mapping[str, Any]] | None = None,
    control_period: float | None = None,
    q0: ArrayLike | None = None,
    dq0: ArrayLike | None = None,
    rtol: float = 1e-8,
    atol: float = 1e-10,
    effects: _core.Effects | Sequence[_core.Effects | None] | None = None,
    seeds: Sequence[int] | None = None,
    window: tuple[float, float] | None = None,
    band: float = 0.01,
    record: Literal["motion", "all"] | None = None,
    record_every: int = 1,
    threads: int | None = None,
    progress: bool | None = None,
) -> Runs:
    """Simulate M runs on all cores, and return the figures of each.

    ``plant``, ``tracker``, ``reference`` and ``effects`` are one for all runs, or a list with one a
    run. What is a list, ``q0`` and ``dq0`` of two dimensions, ``changes`` and ``seeds`` all have
    the same length M. Every run is that of `simulate`, to the bit, whatever their number, their
    order, and ``threads``.

    A run that diverges, or whose callable raises, ends alone: `Runs.status` says why. Ctrl-C keeps
    the runs that are finished; the others are "interrupted". Nothing is warned of: with records,
    ``runs[i].notes`` has what `simulate` would say.

    Parameters
    ----------
    plant, tracker, reference, duration, dt, method, control_period, rtol, atol, record_every:
        as in `simulate`. All plants have the same number of joints.
    changes: what is other in each run, by dotted name: ``{"plant.arm.mass": (5, 4),
        "tracker.compensator.gain": 50.0, "effects.noise": 1e-4, "q0": (0.1, 0)}``. The first word
        alone (plant, tracker, reference, effects, q0, dq0) takes the place of the whole; further
        words are arguments of the objects on the way. A tracker that is made anew so has learnt
        nothing yet.
    q0, dq0: initial position [rad] and velocity [rad/s]: (n,) for all runs, or (M, n); zero by
        default.
    effects: sensors, timing and actuators; see `Effects`.
    seeds: seed of the ``effects`` of each run, whole numbers >= 0.
    window: (from, to) [s] of the figures, the whole run by default, as in `Run.metrics`.
    band: what counts as settled [rad].
    record: None for the figures alone; "motion" or "all" keeps every `Run`, as in `simulate`.
    threads: how many; as many as the process has cores by default.
    progress: whether to show a bar; by default on a terminal.

    Returns
    -------
    Runs

    Raises
    ------
    ValueError, TypeError
        For an argument that makes no sense, or a name in ``changes`` that is not there, before
        anything runs; the message names it.
    """
    _check(duration, window, band, record)
    same = {
        "duration": duration, "dt": dt, "method": method, "control_period": control_period,
        "rtol": rtol, "atol": atol, "record": record, "record_every": record_every,
    }  # fmt: skip
    parts = {"plant": plant, "tracker": tracker, "reference": reference, "effects": effects}
    runs = given(parts | {"q0": q0, "dq0": dq0}, changes, seeds, control_period)
    asked = {"window": (0.0, math.inf) if window is None else window, "band": band}
    found = _computed(runs, same | asked, threads_of("threads", threads), progress)
    return _runs(found, runs, same)


def _computed(
    runs: Given, same: Mapping[str, Any], threads: int, progress: bool | None
) -> dict[str, Any]:
    """What the core says of the runs, whose bar is shown meanwhile."""
    names = {"plant": "plants", "tracker": "trackers", "reference": "references"}
    lists: dict[str, Any] = {names.get(name, name): it for name, it in runs.parts.items()}
    for name in ("q0", "dq0"):
        lists[name] = [0.0 if it is None else it for it in lists[name]]
    shown = sys.stderr.isatty() if progress is None else progress
    stop = _stopping.poll()
    with Progress(runs.count, "runs", shown=shown) as bar:

        def tell(done: int) -> None:
            bar.to(done)
            if stop is not None:
                stop(done)

        if same["record"] is None:
            figures_of = {name: it for name, it in same.items() if name != "record"}
            found = _core.simulate_many(
                runs.count, **lists, **figures_of, threads=threads, progress=tell
            )
            if found is not None:
                figures, ended = found
                return {"figures": figures, "status": [it or UNBEGUN for it in ended]}
        return _many_threads.simulate_many(
            runs.count, **lists, **same, threads=threads, progress=tell
        )


def _runs(found: Mapping[str, Any], runs: Given, same: Mapping[str, Any]) -> Runs:
    kinds = {ended: Status(*ended) for ended in set(found["status"])}
    status = tuple(kinds[ended] for ended in found["status"])
    records = None
    if same["record"] is not None:
        kept = zip(found["records"], status, strict=True)
        records = tuple(_run(it, ended, runs, n, same) for n, (it, ended) in enumerate(kept))
    arms = [plant.arm for plant in runs.parts["plant"]]
    named = [(joint_names(arm, arm.joints), lengths(arm.joint_kinds)) for arm in arms]
    return Runs(**found["figures"], status=status, _named=tuple(named), _records=records)


def _run(
    record: dict[str, Any] | None, ended: Status, runs: Given, run: int, same: Mapping[str, Any]
) -> Run | None:
    """The run of a record; None for one that never began."""
    if record is None:
        return None
    options = {name: same[name] if name in same else runs.part(name, run) for name in OPTIONS}
    plant, tracker, reference = (runs.part(name, run) for name in ("plant", "tracker", "reference"))
    made = recorded(record, plant, tracker, reference, options)
    vars(made)["status"] = ended
    return made


def _check(
    duration: float, window: tuple[float, float] | None, band: float, record: str | None
) -> None:
    """Refuse what the core would take for runs without figures."""
    if window is not None and isinstance(duration, Real):
        wants = f"(from, to) within 0 to {duration:g} s"
        try:
            start, end = map(float, window)
        except (TypeError, ValueError):
            raise TypeError(f"window: got {window!r:.80}, wants {wants}") from None
        if not (start <= end and start <= duration and end >= 0):
            raise ValueError(f"window: got {window!r:.80}, wants {wants}")
    if isinstance(band, Real) and not 0 < band < math.inf:
        raise ValueError(f"band: got {band}, wants a number > 0")
    if record not in (None, "motion", "all"):
        raise ValueError(f"record: got {record!r:.80}, wants 'motion', 'all' or None")
