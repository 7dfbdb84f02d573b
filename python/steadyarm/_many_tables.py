"""Many runs as a table: in columns, for pandas, in text and for a notebook."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._extras import imported
from ._figures import FIGURES
from ._html import Entry, by_joint, listed
from .metrics import NAMES, UNITS

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped, import-not-found, unused-ignore]

    from .many import Runs

Array = NDArray[np.float64]


def table(runs: Runs) -> dict[str, NDArray[Any]]:
    """The columns of `Runs.table`."""
    columns: dict[str, NDArray[Any]] = {
        "status": np.array([status.kind for status in runs.status]),
        "t_end": np.array([status.t for status in runs.status]),
        "reason": np.array([status.reason for status in runs.status]),
    }
    for name in NAMES:
        values = getattr(runs, name)
        columns |= {f"{name}_{n + 1}": values[:, n].copy() for n in range(runs.joints)}
    return columns


def to_pandas(runs: Runs) -> pandas.DataFrame:
    """Make the table of `Runs.to_pandas`."""
    pandas = imported("pandas", "to_pandas")
    frame = pandas.DataFrame(table(runs), index=pandas.RangeIndex(len(runs), name="run"))
    units = {f"{name}_{n + 1}": UNITS[name] for name in NAMES for n in range(runs.joints)}
    frame.attrs = {"units": {"t_end": "s"} | units}
    return frame


def counted(runs: Runs) -> str:
    """How many runs there are, and how they ended."""
    kinds = Counter(status.kind for status in runs.status)
    ended = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    return f"{len(runs)} runs of {runs.joints} joints: {ended}"


def text(runs: Runs) -> str:
    """The table of ``print``."""
    heads = " ".join(f"{f'joint {n + 1}':>12}" for n in range(runs.joints))
    lines = [counted(runs)]
    if runs.finished.any():
        lines += ["Of those that finished, of each joint:", f"{'':34} {heads}"]
        for name in NAMES:
            for said, values in _spread(runs, name):
                cells = " ".join(f"{value:12.6g}" for value in values)
                lines.append(f"{name:>16} {f'[{UNITS[name]}]':9} {said:7} {cells}")
    return "\n".join(lines)


def html(runs: Runs) -> str:
    """The table of a notebook."""
    rows = []
    if runs.finished.any():
        for name in NAMES:
            told = FIGURES[name]
            for said, values in _spread(runs, name):
                rows.append(Entry(f"{told.head}, {said}", told.shown, told.scale * values))
    moves = {moves for _, moves in runs._named}
    lengths = moves.pop() if len(moves) == 1 else ()
    whole = by_joint(f"{counted(runs)}.", runs.joint_names, rows, lengths)
    return f"{whole}\n{listed('Not finished', _reasons(runs))}".rstrip()


def _spread(runs: Runs, name: str) -> list[tuple[str, Array]]:
    """Median and worst of a figure over the runs that finished, one a joint."""
    values = getattr(runs, name)[runs.finished]
    return [("median", np.median(values, axis=0)), ("worst", values.max(axis=0))]


REASONS = 5
"""A table tells so many reasons, the most frequent ones."""


def _reasons(runs: Runs) -> list[str]:
    """Why runs did not finish."""
    whys = Counter(f"{it.kind}: {it.reason}" for it in runs.status if not it.finished)
    return [f"{count} × {why}" for why, count in whys.most_common(REASONS)]
