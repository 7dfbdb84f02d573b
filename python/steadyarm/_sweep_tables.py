"""A sweep as text, and for a notebook."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ._figures import FIGURES
from ._html import head, joined, listed, table
from ._html import text as escaped
from ._joints import in_length
from .metrics import NAMES

if TYPE_CHECKING:
    from .sweep import Sweep, Worst


def told(name: str, units: dict[str, str]) -> tuple[str, str, float]:
    """What a figure is called for people, its unit, and how many of them are one of its column."""
    base, joint = _joint_of(name)
    if base not in NAMES or name not in units:
        return name, units.get(name, ""), 1.0
    figure = FIGURES[base]
    unit = in_length(figure.shown, "rad" if units[name] == figure.unit else "m")
    return figure.head + (f", joint {joint}" if joint else ""), unit, figure.scale


def _joint_of(name: str) -> tuple[str, str]:
    """The figure and the number of the joint, "" of all of them."""
    found = re.fullmatch(r"(.+)_(\d+)", name)
    return (found[1], found[2]) if found else (name, "")


def counted(sweep: Sweep) -> str:
    """How many rows there are, and how they ended."""
    ended = ", ".join(f"{count} {status}" for status, count in sweep.counts().items())
    whole = len(sweep) + sweep.missing
    share = f"{len(sweep)} of {whole} rows" if sweep.missing else f"{whole} rows"
    return f"{share}: {ended or 'none yet'}"


def text(sweep: Sweep) -> str:
    """The table of ``print``."""
    lines = [f"{counted(sweep)}; inputs {', '.join(sweep.inputs) or 'none'}; in {sweep.path}"]
    if sweep.missing:
        lines.append(f"{sweep.missing} rows are missing: call again, it computes them alone")
    lines += [f"{'':34} {'median':>12} {'90 %':>12} {'worst':>12}"] * bool(sweep.figures)
    for name, values in _spread(sweep):
        unit = sweep.units.get(name)
        cells = " ".join(f"{value:12.6g}" for value in values)
        lines.append(f"{name:>22} {f'[{unit}]' if unit else '':11} {cells}")
    return "\n".join(lines)


def html(sweep: Sweep) -> str:
    """The table of a notebook."""
    rows = []
    for name, values in _spread(sweep):
        words, unit, scale = told(name, sweep.units)
        cells = "".join(
            f'<td style="text-align:right" title="{value:.6g}">{scale * value:.4g}</td>'
            for value in values
        )
        rows.append(f"<tr>{head(words, unit)}{cells}</tr>")
    heads = map(head, ("figure", "median", "90 %", "worst"))
    bad = [f"{case(it)}: {it.again}" for it in sweep.worst(3)]
    whole = table(f"{counted(sweep)}.", heads, rows)
    return joined([whole, listed("Worst", bad), f"<p>{escaped(f'In {sweep.path}.')}</p>"])


def figures(sweep: Sweep) -> dict[str, dict[str, float]]:
    """Median, 90 % and worst of each figure, by name."""
    names = ("median", "90 %", "worst")
    return {name: dict(zip(names, values, strict=True)) for name, values in _spread(sweep)}


def worst(cases: list[Worst], by: str) -> str:
    """The worst rows, each with what repeats it."""
    return "\n".join([f"worst by {by}:", *(f"  {case(it)}\n    {it.again}" for it in cases)])


def case(it: Worst) -> str:
    """A row in words."""
    inputs = ", ".join(f"{name} {_short(value)}" for name, value in it.inputs.items())
    found = "" if np.isnan(it.value) else f"{it.value:.6g}"
    status = "" if it.status == "finished" else f"{it.status}: {it.reason}".rstrip(": ")
    return ", ".join(part for part in (f"row {it.index}", inputs, found, status) if part)


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _spread(sweep: Sweep) -> Iterator[tuple[str, list[float]]]:
    """Median, 90 % and the largest of each figure that some row has.

    Not those of single joints where there is one of all of them.
    """
    columns = sweep.table()
    for name in sweep.figures:
        base, joint = _joint_of(name)
        if joint and base in columns:
            continue
        values = columns[name][~np.isnan(columns[name])]
        if len(values):
            ends = np.quantile(values, (0.5, 0.9, 1.0), method="inverted_cdf")
            yield name, ends.tolist()
