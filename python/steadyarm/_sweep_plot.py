"""Pictures of a sweep: bands over one input, a map over two."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from ._look import SMALL, TEXT, Look
from ._pareto import brief
from ._picture import Picture, literal
from ._sweep_tables import told

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .sweep import Sweep

Array = NDArray[Any]

SHARE = 0.55
"""Height of a picture, as a part of its width."""

DECADES = 20.0
"""Figures are on a logarithmic scale where the largest is so many times the smallest."""

ENDS = (0.1, 0.5, 0.9)
"""Quantiles that are drawn: the ends of a band, and its middle."""

CROWD = 3
"""A value of an input has so many rows on average, or they are drawn one by one."""

SPARSE = 3.0
"""A map has at most so many cells a point, or its points are drawn one by one."""

MARKS = 40
"""An axis of words or of a map has at most so many marks."""


def drawn(
    sweep: Sweep, x: str | None, y: str | None, value: str, width: float | None, style: str
) -> Picture:
    """The picture that `Sweep.plot` returns."""
    columns = sweep.table()
    x, y = _chosen(sweep, columns, x, y)
    if not value:
        ended = ", ".join(f"{status}: {count}" for status, count in sweep.counts().items())
        raise ValueError(f"value: no row has a figure ({ended or 'there are no rows'})")
    words, unit, scale = told(value, sweep.units)
    picture = Picture(width, style=style)
    picture.set_figheight(SHARE * picture.wide)
    axes = picture.add_subplot()
    picture.frame(axes)
    named = literal(f"{words} [{unit}]" if unit else words)
    figures, failed = scale * columns[value], columns["status"] != "finished"
    figures = np.where(failed | ~np.isfinite(figures), np.nan, figures)
    if y is None:
        _bands(picture, axes, columns[x], figures, failed, _series(sweep, columns, x, picture.look))
        axes.set_ylabel(named)
    else:
        _map(picture, axes, (columns[x], columns[y]), figures, failed, named)
        axes.set_ylabel(literal(y))
    axes.set_xlabel(literal(x))
    if failed.any():
        count = f"{failed.sum()} of {len(failed)} rows did not finish"
        picture.head(f"{count}; × marks where", alarm=True)
    return picture


def _chosen(
    sweep: Sweep, columns: dict[str, Array], x: str | None, y: str | None
) -> tuple[str, str | None]:
    """The inputs that are drawn: the first two by default, the second only if it has numbers."""
    inputs = [name for name in sweep.inputs if name != "seed"] or list(sweep.inputs)
    for name, given in (("x", x), ("y", y)):
        if given is not None and given not in sweep.inputs:
            raise ValueError(f"{name}: got {given!r:.80}, wants one of {', '.join(sweep.inputs)}")
    if x is not None:
        return x, y
    first = next(name for name in inputs if name != y)
    numeric = [name for name in inputs if name != first and columns[name].dtype.kind in "fiu"]
    return first, y or next(iter(numeric), None)


def _series(sweep: Sweep, columns: dict[str, Array], x: str, look: Look) -> list[tuple[str, Array]]:
    """The rows of each value of an input in words that is not drawn: they are not one crowd."""
    for name in sweep.inputs:
        words = columns[name]
        values = np.unique(words)
        if name != x and words.dtype.kind in "Ub" and 1 < len(values) <= len(look.cycle):
            return [(f"{name} {value}", words == value) for value in values]
    return [("", np.ones(len(columns[x]), dtype=bool))]


def _bands(
    picture: Picture,
    axes: Axes,
    x: Array,
    figures: Array,
    failed: Array,
    series: list[tuple[str, Array]],
) -> None:
    """The middle of the rows of each value, and the band that 80 % of them are in."""
    look, values = picture.look, np.unique(x)
    places = _axis(axes.xaxis, values)
    at = places[np.searchsorted(values, x)]
    words, known = values.dtype.kind in "Ub", ~np.isnan(figures)
    sparse = len(x) < CROWD * len(values) * len(series)
    for (label, rows), (colour, _) in zip(series, look.cycle, strict=False):
        if sparse:
            axes.plot(at[rows], figures[rows], "o", markersize=3, color=colour, label=label)
            continue
        groups = [figures[(at == place) & known & rows] for place in places]
        kept = np.array([len(group) > 0 for group in groups])
        some = [np.quantile(it, ENDS) for it in groups if len(it)]
        low, middle, high = np.reshape(some, (-1, len(ENDS))).T
        label = label and f"{label}, "
        if words:
            axes.errorbar(
                places[kept], middle, (middle - low, high - middle), fmt="o", markersize=4,
                capsize=3, linewidth=1.0, color=colour, label=f"{label}median, 10 to 90 %",
            )  # fmt: skip
        else:
            axes.fill_between(
                places[kept], low, high, color=colour, alpha=0.25, linewidth=0,
                label="10 to 90 %" if rows is series[0][1] else None,
            )  # fmt: skip
            axes.plot(places[kept], middle, color=colour, linewidth=1.4, label=f"{label}median")
    handles, labels = axes.get_legend_handles_labels()
    if any(labels):
        picture.explain(dict(zip(labels, handles, strict=True)))
    if _decades(figures[known]):
        axes.set_yscale("log")
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(FuncFormatter(lambda it, _: brief(it)))
    if words:
        axes.set_xlim(-0.5, len(values) - 0.5)
    bottom = np.unique(at[failed])
    axes.plot(
        bottom, np.zeros(len(bottom)), "x", color=look.orange, transform=axes.get_xaxis_transform(),
        clip_on=False, markersize=5,
    )  # fmt: skip


def _map(
    picture: Picture,
    axes: Axes,
    inputs: tuple[Array, Array],
    figures: Array,
    failed: Array,
    named: str,
) -> None:
    """A map of the medians, or points in the colours of one."""
    values = [np.unique(it) for it in inputs]
    cells = len(values[0]) * len(values[1])
    look = picture.look
    if cells > SPARSE * len(figures):
        x, y = inputs
        axes.plot(x[failed], y[failed], "x", color=look.orange, markersize=4)
        shown: Any = axes.scatter(x, y, c=figures, s=12, cmap="viridis", norm=_norm(figures))
    else:
        drawn_on = zip((axes.xaxis, axes.yaxis), values, strict=True)
        places = [_axis(axis, it) for axis, it in drawn_on]
        row, column = (np.searchsorted(it, at) for it, at in zip(values, inputs, strict=True))
        medians = np.full((len(values[1]), len(values[0])), np.nan)
        for cell, rows in _cells(column * len(values[0]) + row):
            some = figures[rows][~np.isnan(figures[rows])]
            medians.flat[cell] = np.median(some) if len(some) else np.nan
        edges = [_edges(it) for it in places]
        shown = axes.pcolormesh(*edges, medians, cmap="viridis", norm=_norm(medians))
        axes.grid(False)
        bad = np.unique(np.stack([row[failed], column[failed]]), axis=1)
        axes.plot(places[0][bad[0]], places[1][bad[1]], "x", color=look.orange, markersize=4)
        axes.margins(0)
    bar = picture.colorbar(shown, ax=axes, pad=0.02)
    bar.set_label(named, color=look.ink, fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL, labelcolor=look.ink, color=look.gray)
    bar.outline.set_visible(False)
    if isinstance(shown.norm, LogNorm):
        bar.ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda it, _: brief(it)))
        bar.ax.yaxis.set_minor_locator(NullLocator())


def _cells(numbers: Array) -> Iterator[tuple[int, Array]]:
    """The rows of each cell, by its number."""
    order = np.argsort(numbers, kind="stable")
    found, starts = np.unique(numbers[order], return_index=True)
    yield from zip(found.tolist(), np.split(order, starts[1:]), strict=True)


def _axis(axis: Any, values: Array) -> Array:
    """Where values stand on an axis; words and truths one after the other, with their names."""
    if values.dtype.kind not in "Ub":
        return np.asarray(values, dtype=float)
    axis.set_ticks(np.arange(len(values))[:MARKS], [literal(str(it)) for it in values[:MARKS]])
    return np.arange(len(values), dtype=float)


def _edges(places: Array) -> Array:
    """The edges of cells around their middles."""
    if len(places) == 1:
        return np.concatenate([places - 0.5, places + 0.5])
    between = (places[1:] + places[:-1]) / 2
    ends = 2 * places[[0, -1]] - between[[0, -1]]
    return np.concatenate([ends[:1], between, ends[1:]])


def _decades(figures: Array) -> bool:
    some = figures[~np.isnan(figures)]
    return bool(len(some) and some.min() > 0 and some.max() > DECADES * some.min())


def _norm(figures: Array) -> Normalize:
    some = figures[~np.isnan(figures)]
    ends = (float(some.min()), float(some.max())) if len(some) else (0.0, 1.0)
    return LogNorm(*ends) if _decades(figures) else Normalize(*ends)
