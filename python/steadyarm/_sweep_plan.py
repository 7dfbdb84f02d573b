"""What a sweep computes: rows by number, each with its inputs, none of them stored.

An input is a list of values that repeats along the rows,

    value of row k = values[(k // stride) mod len(values)].

In a grid the last input runs fastest; in a hypercube or a list every input has a value a point; the
seeds, where there are any, run fastest of all.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._documented import documented
from ._extras import imported
from .bench import seeds_of

MOST = 10**9
"""Rows of a sweep at the most: a byte of memory each says which are there."""

LARGEST_EXACT = 2**53
"""Whole numbers up to this are floats, too."""

SHOWN = 4
"""Values of an input that a message lists."""

TAKEN = ("index", "seed", "status", "reason", "t_end", "version")
"""Columns that every table has: no input may have their names."""

KINDS = {"f": np.float64, "i": np.int64, "u": np.int64, "b": np.bool_, "U": np.str_}
"""What values may be, by numpy's letter for it."""

Values = NDArray[Any]


@documented
@dataclass(frozen=True)
class LatinHypercube:
    """Points spread over ranges.

    Each range is cut into as many parts as there are points, and every part has one point in it.
    For three inputs or more it says more than a grid of as many points.

    >>> sa.LatinHypercube(200, {"payload": (0.0, 3.0), "friction": (0.0, 0.02)}, seed=1)

    ``scipy.stats.qmc`` draws them. Raises ValueError for a number of points below 1 and a range
    that is none.
    """

    points: int
    """How many."""
    ranges: Mapping[str, tuple[float, float]]
    """From and to of each input, by name."""
    seed: int = 0
    """Of the drawing; the same points come of the same seed."""

    def __post_init__(self) -> None:
        counted = isinstance(self.points, int | np.integer) and not isinstance(self.points, bool)
        if not counted or self.points < 1:
            raise ValueError(f"points: got {self.points!r:.80}, wants a whole number >= 1")
        if not isinstance(self.ranges, Mapping) or not self.ranges:
            raise ValueError(f"ranges: got {self.ranges!r:.80}, wants (from, to) by name")
        for name, ends in self.ranges.items():
            try:
                pair = np.ravel(np.asarray(ends, dtype=float))
            except (ValueError, TypeError):
                pair = np.empty(0)
            if len(pair) != 2 or not np.isfinite(pair).all() or not pair[0] < pair[1]:
                raise ValueError(f"ranges[{name!r}]: got {ends!r:.80}, wants (from, to), from < to")

    def _columns(self) -> dict[str, Values]:
        qmc = imported("scipy.stats", "sa.LatinHypercube").qmc
        low, high = np.array(list(self.ranges.values()), dtype=float).T
        unit = qmc.LatinHypercube(len(self.ranges), rng=self.seed).random(self.points)
        return dict(zip(self.ranges, (low + unit * (high - low)).T, strict=True))


Over = Mapping[str, Iterable[Any]] | LatinHypercube | Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Input:
    """The values of one input, and for how many rows each stays."""

    values: Values
    stride: int

    def at(self, rows: NDArray[np.int64]) -> Values:
        """The values of these rows."""
        found: Values = self.values[(rows // self.stride) % len(self.values)]
        return found

    def said(self) -> str:
        """The values in words, with a digest of all of them where they are many."""
        count, listed = len(self.values), self.values.tolist()
        if count <= SHOWN:
            return ", ".join(map(repr, listed))
        text = self.values.dtype.kind == "U"
        content = "\0".join(listed).encode() if text else self.values.tobytes()
        digest = hashlib.sha256(content).hexdigest()[:16]
        return f"{count} values, {listed[0]} … {listed[-1]} ({digest})"


@dataclass(frozen=True)
class Plan:
    """All rows of a sweep, by number from 0."""

    inputs: Mapping[str, Input]
    rows: int

    @property
    def seeded(self) -> bool:
        """Whether rows have a seed."""
        return "seed" in self.inputs

    def columns(self, rows: NDArray[np.int64]) -> dict[str, Values]:
        """The inputs of these rows, by name."""
        return {name: it.at(rows) for name, it in self.inputs.items()}

    def points(self, rows: NDArray[np.int64]) -> list[dict[str, Any]]:
        """The same, row by row."""
        columns = {name: values.tolist() for name, values in self.columns(rows).items()}
        if not columns:
            return [{} for _ in rows]
        return [
            dict(zip(columns, values, strict=True))
            for values in zip(*columns.values(), strict=True)
        ]

    def said(self) -> dict[str, str]:
        """What there is to tell two plans apart, in words."""
        strides = {name: it.stride for name, it in self.inputs.items()}
        order = ", ".join(sorted(strides, key=lambda name: -strides[name]))
        found = {f"over[{name!r}]": it.said() for name, it in self.inputs.items()}
        return {"rows": str(self.rows), **found, "order, the slowest first": order}


def plan_of(over: Over, seeds: int | Iterable[int] | None) -> Plan:
    """The plan of what `sweep` is given. Raises ValueError and TypeError naming ``over``."""
    if isinstance(over, Mapping):
        columns = {name: _values(name, values) for name, values in over.items()}
        points, strides = 1, {}
        for name in reversed(columns):
            strides[name] = points
            points *= len(columns[name])
    else:
        columns = over._columns() if isinstance(over, LatinHypercube) else _of_list(over)
        points = len(next(iter(columns.values())))
        strides = dict.fromkeys(columns, 1)
    for name in columns:
        if not isinstance(name, str) or name in TAKEN or not name:
            raise ValueError(
                f"over: got the name {name!r:.80}, wants another than {', '.join(TAKEN)}"
            )
    runs = [] if seeds is None else seeds_of(seeds)
    each = max(1, len(runs))
    if points * each > MOST:
        raise ValueError(f"over: got {points * each} rows, wants at most {MOST}")
    inputs = {name: Input(columns[name], strides[name] * each) for name in columns}
    if runs:
        inputs["seed"] = Input(np.array(runs, dtype=_whole(max(runs))), 1)
    return Plan(inputs, points * each)


def _of_list(over: Any) -> dict[str, Values]:
    """The columns of a list of points."""
    wants = "over: wants lists of values by name, a LatinHypercube, or a list of points"
    if isinstance(over, str) or not isinstance(over, Sequence) or not over:
        raise TypeError(f"{wants}; got {over!r:.80}")
    first = over[0]
    for place, point in enumerate(over):
        if not isinstance(point, Mapping) or not point:
            raise TypeError(f"over[{place}]: got {point!r:.80}, wants values by name")
        if point.keys() != first.keys():
            raise ValueError(
                f"over[{place}]: got {', '.join(map(str, point))}, "
                f"wants {', '.join(map(str, first))} as the first"
            )
    return {name: _values(name, [point[name] for point in over]) for name in first}


def _values(name: str, given: Any) -> Values:
    """The values of an input: numbers, whole numbers, words, or yes and no."""
    where = f"over[{name!r}]"
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise TypeError(f"{where}: got {given!r:.80}, wants a list of values")
    values = given if isinstance(given, np.ndarray) else list(given)
    if not isinstance(values, np.ndarray):
        kinds = {str if isinstance(it, str) else type(it) for it in values}
        if len(kinds) > 1 and kinds & {str, bool, np.bool_}:
            names = " and ".join(sorted(kind.__name__ for kind in kinds))
            raise TypeError(f"{where}: got {names}, wants values of one kind")
        whole = (it for it in values if isinstance(it, int | np.integer))
        if len(kinds) > 1 and any(abs(int(it)) > LARGEST_EXACT for it in whole):
            raise ValueError(
                f"{where}: got a whole number beyond 2^53 beside others, wants one kind"
            )
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{where}: got {values!r:.80}, wants numbers or words") from error
    if array.ndim != 1 or not len(array) or array.dtype.kind not in KINDS:
        raise ValueError(f"{where}: got {values!r:.80}, wants numbers or words, at least one")
    kind = array.dtype.kind
    if kind == "f" and np.isnan(array).any():
        raise ValueError(f"{where}: got NaN, wants numbers")
    if kind == "U":
        for word in array.tolist():
            if not is_text(word):
                raise ValueError(f"{where}: got {word!r:.80}, wants words that UTF-8 has")
        return array
    return array.astype(_whole(int(array.max())) if kind in "iu" else KINDS[kind])


def is_text(word: str) -> bool:
    """Whether a file can have these words."""
    try:
        word.encode()
    except UnicodeEncodeError:
        return False
    return True


def _whole(largest: int) -> type[np.int64] | type[np.uint64]:
    """What holds whole numbers up to this one."""
    return np.int64 if largest < 2**63 else np.uint64
