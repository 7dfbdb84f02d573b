"""Sweeps: a function or a scenario over many points, on all cores or a cluster, and kept."""

from __future__ import annotations

import shlex
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _sweep_folder, _sweep_tables
from ._documented import documented
from ._extras import imported
from ._look import Style
from ._scene import VERSION
from ._sweep_folder import Folder
from ._sweep_plan import LatinHypercube, Over, Plan, plan_of
from ._sweep_source import FileSource, source_of
from ._sweep_work import Chunk, Source, computed
from .bench import Scenario

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import pandas  # type: ignore[import-untyped, import-not-found, unused-ignore]

    from ._picture import Picture

__all__ = ["LatinHypercube", "Sweep", "Worst", "sweep"]


@documented
@dataclass(frozen=True)
class Worst:
    """A row of a sweep that went badly, and what computes it again, to the bit."""

    index: int
    """Its number."""
    inputs: Mapping[str, Any]
    """Its inputs, and its seed if it has one."""
    value: float
    """The figure that it was chosen by; NaN if it has none."""
    status: str
    """How it ended."""
    reason: str
    """Why, in words; empty if it just finished."""
    again: str
    """A command of the shell for a scenario's file, or else a line of Python."""


class Sweep:
    """The rows of a sweep in a folder, as far as they are computed: what `sweep` returns.

    ``len(sweep)`` is how many rows are there. Printed as a table.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._said = _sweep_folder.read_plan(self.path)

    @classmethod
    def read(cls, path: str | Path) -> Sweep:
        """Read the sweep in the folder at ``path``; one that is not finished too.

        Needs pyarrow. Raises OSError, and ValueError for a folder that no sweep is in.
        """
        return cls(path)

    @cached_property
    def _read(self) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
        return _sweep_folder.table(self.path)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs; "seed" is the last of them if there are seeds."""
        return tuple(self._said["inputs"])

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the columns that are figures: numbers that came out."""
        columns, _ = self._read
        others = {"index", "t_end", *self.inputs}
        return tuple(n for n, it in columns.items() if n not in others and it.dtype.kind == "f")

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that have one, by name."""
        return dict(self._read[1])

    @property
    def missing(self) -> int:
        """How many rows are not computed yet."""
        return int(self._said["rows"]) - len(self)

    def __len__(self) -> int:
        return len(self._read[0]["index"])

    def table(self) -> dict[str, NDArray[Any]]:
        """All rows that are there as columns (rows,) by name, sorted by "index".

        "index" is the number of the row in the plan, then the inputs, "status", "reason", figures,
        and "version" of the package that computed the row. A figure that a row has not is NaN.
        """
        return dict(self._read[0])

    def to_pandas(self) -> pandas.DataFrame:
        """The same as a table of pandas, by "index"; ``frame.attrs`` has "units". Needs pandas."""
        frame = imported("pandas", "to_pandas").DataFrame(self.table()).set_index("index")
        frame.attrs = {"units": self.units}
        return frame

    def worst(self, count: int = 10, by: str | None = None) -> list[Worst]:
        """The rows that went worst: those that did not finish, then by a figure, largest first.

        ``by``: the name of a figure; the first one by default. Raises ValueError for another name.
        """
        columns, name = self._read[0], self._figure(by, "by")
        if not len(self):
            return []
        values = columns[name] if name else np.full(len(self), np.nan)
        finished = columns["status"] == "finished"
        order = np.lexsort((np.where(np.isnan(values), -np.inf, -values), finished))[:count]
        return [self._worst(int(row), float(values[row])) for row in order]

    def _worst(self, row: int, value: float) -> Worst:
        columns = self._read[0]
        index = int(columns["index"][row])
        inputs = {name: columns[name][row].item() for name in self.inputs}
        status, reason = (str(columns[name][row]) for name in ("status", "reason"))
        return Worst(index, inputs, value, status, reason, self._again(index, inputs))

    def _again(self, index: int, inputs: Mapping[str, Any]) -> str:
        """What computes a row again."""
        if self._said["repeat"] is not None:
            return f"steadyarm sweep {shlex.quote(str(self.path))} --only {index}"
        given = dict(inputs)
        function = self._said["source"].get("function")
        if function is not None:
            return f"{function}({', '.join(f'{name}={it!r}' for name, it in given.items())})"
        seeds = f", seeds=[{given.pop('seed')}]" if "seed" in given else ""
        return f"sa.sweep(scene, [{given!r}]{seeds}, out='again')"

    def repeated(self, index: int) -> tuple[dict[str, Any], bool]:
        """Compute a row of a scenario's file again; whether its bits are those that are there.

        Raises ValueError for a row that is not there, and for a sweep of something else.
        """
        columns = self._read[0]
        place = np.flatnonzero(columns["index"] == index)
        if not len(place):
            rows = f", from {columns['index'].min()} to {columns['index'].max()}" * bool(len(self))
            raise ValueError(f"index: got {index}, wants a row that is there{rows}")
        if self._said["repeat"] is None:
            again = self._worst(int(place[0]), float("nan")).again
            raise ValueError(f"index: this is no sweep of a scenario's file; run {again} in Python")
        there = {name: values[place[0]].item() for name, values in columns.items()}
        point = {name: there[name] for name in self.inputs}
        row = one_row(FileSource.kept(self._said["repeat"]), point)
        return {"index": index, **point, **row}, all(_alike(row[it], there[it]) for it in row)

    def _figure(self, name: str | None, argument: str) -> str:
        """The name of a figure that is there, the first by default; "" where there is none."""
        figures = self.figures
        if name is not None and name not in figures:
            wants = ", ".join(figures) or "none"
            raise ValueError(f"{argument}: got {name!r:.80}, wants one of {wants}")
        return name or next(iter(figures), "")

    def plot(
        self,
        x: str | None = None,
        y: str | None = None,
        value: str | None = None,
        *,
        width: float | None = None,
        style: Style = "light",
    ) -> Picture:
        """Draw a figure over one input, or over two.

        Over one (``x``): the median of all rows of each value, and the band from 10 to 90 % of
        them; rows differ by seed and by the inputs that are not drawn, but an input in words, such
        as a controller, has a band for each of its values, up to six. Over two (``x`` and ``y``): a
        map of the medians. Where the points are no grid, every row is drawn by itself. Rows that
        did not finish are marked. Needs matplotlib.

        Parameters
        ----------
        x, y: names of inputs. By default the first one, and the second if it has numbers too.
        value: the name of a figure; the first one by default.
        width: as it will be printed [in], 7.16 by default, and ``style`` "light" or "dark": see
            `steadyarm.plots`.
        """
        from ._sweep_plot import drawn

        if not len(self):
            raise ValueError("plot: no row is there yet")
        return drawn(self, x, y, self._figure(value, "value"), width, style)

    def counts(self) -> dict[str, int]:
        """How many rows ended in each way, by status."""
        status = self._read[0].get("status", np.empty(0, dtype=str))
        return dict(Counter(status.tolist()).most_common())

    def __str__(self) -> str:
        return _sweep_tables.text(self)

    def __repr__(self) -> str:
        return f"Sweep({_sweep_tables.counted(self)})"

    def _repr_html_(self) -> str:
        return _sweep_tables.html(self)


def sweep(
    scenario_or_function: Callable[..., Mapping[str, Any]] | Scenario | str | Path,
    over: Over,
    *,
    seeds: int | Iterable[int] | None = None,
    executor: Executor | str | Any | None = None,
    out: str | Path = "results",
    chunk_seconds: float = 1.0,
    retry: bool = False,
    progress: bool | None = None,
) -> Sweep:
    """Compute all points of a plan, and keep every row in a folder while it goes.

    A second call with the same arguments computes only what is missing: after Ctrl-C, a client that
    was killed, a machine that was switched off. Lost workers lose no row that was written, and what
    they were at is computed again. The rows are the same, to the bit, whoever computes them, in
    whatever order.

    Parameters
    ----------
    scenario_or_function: a function of the inputs by name, ``function(payload=…, seed=…)``, that
        returns figures by name (numbers and words), or the arguments of `simulate` by name
        ("plant", "tracker", "reference", "duration", …, and "window" and "band" of the figures):
        those of a chunk run together in `simulate_many`, and the row has their figures, "rms_e_1"
        and so on.
        Or a scenario: its file or its name, whose inputs are keys of the file ("payload",
        "bandwidth", "friction", "noise", "actual.inertia_scale", "controllers.pid.kp"), or a
        `Scenario`, whose inputs are its fields ("effects.noise", "options.control_period");
        "controller" chooses one of its controllers. The figures are over the scenario's window, by
        default the second half.
    over: values by name, for all combinations of them, the last name fastest; or a
        `LatinHypercube`; or a list of points, each a mapping of values by name. Values are numbers,
        words, or booleans.
    seeds: a number of seeds, counted from 0, or the seeds: every point runs with each. A function
        gets it as ``seed``, a scenario as that of its effects. None: points run once.
    executor: who computes. None: this process, on all cores. "processes": one process a core, for
        functions that hold Python's lock. An executor of ``concurrent.futures``. A client of Dask,
        or "dask" for a cluster on this machine, or "dask://host:port". "ray". With processes of
        any kind, a script has its calls below ``if __name__ == "__main__":``.
    out: the folder, made if it is not there.
    chunk_seconds: rows are computed and written in chunks that take about so long [s].
    retry: whether rows that raised are computed again too, as after a mistake in the function. They
        are taken out first: where this call is stopped they are missing, until the next one.
    progress: whether to show a bar with an estimate; by default on a terminal.

    Returns
    -------
    Sweep
        Its rows have the inputs, "seed", the figures, "status", "reason" and "version". A point at
        which the function raises has the status "raised", one that a condition of its controller
        refuses "refused", and runs of `simulate` end as they do there. Ctrl-C returns the rows that
        there are; `Sweep.missing` tells how many are not.

    Raises
    ------
    ValueError, TypeError
        For arguments that make no sense, and a folder with another sweep; the message says what
        differs.
    RuntimeError
        Where another call writes to the folder, an executor is broken, or the workers of some rows
        were lost again and again. What was written stays, and another call goes on.
    ImportError
        Without pyarrow, and dask or ray if they are asked for.
    """
    plan = plan_of(over, seeds)
    source = source_of(scenario_or_function, plan.inputs, plan.seeded)
    return swept(source, plan, executor, out, chunk_seconds, retry, progress)


def swept(
    source: Source,
    plan: Plan,
    executor: Any,
    out: str | Path,
    chunk_seconds: float = 1.0,
    retry: bool = False,
    progress: bool | None = None,
) -> Sweep:
    """Compute what is missing of a plan; see `sweep`."""
    from ._sweep_loop import Loop
    from ._sweep_pools import workers_of  # what has processes takes a while to import

    if not isinstance(chunk_seconds, Real) or not 0.0 < chunk_seconds < float("inf"):
        raise ValueError(f"chunk_seconds: got {chunk_seconds!r:.80}, wants a number > 0 [s]")
    source.check(plan.points(np.array([0, plan.rows - 1])))
    start = workers_of(executor, source)
    said = {
        "steadyarm": VERSION,
        "source": source.said(),
        "plan": plan.said(),
        "inputs": list(plan.inputs),
        "rows": plan.rows,
        "repeat": source.keeps() if isinstance(source, FileSource) else None,
    }
    with Folder.opened(out, said) as folder:
        if retry:
            folder.forget_raised()
        loop = Loop(source, plan, folder, chunk_seconds)
        if len(loop.left):
            with closing(start()) as workers:
                loop.run(workers, sys.stderr.isatty() if progress is None else progress)
    return Sweep.read(out)


def one_row(source: Source, point: dict[str, Any]) -> dict[str, Any]:
    """Compute one row, and write it nowhere."""
    chunk: Chunk = computed(source, [point], None)
    return {name: values[0] for name, values in chunk.columns.items()}


def _alike(one: Any, other: Any) -> bool:
    """Whether two values are the same, NaN too."""
    return bool(one == other or (one != one and other != other))
