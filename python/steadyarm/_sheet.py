"""A page of panels: blocks below one another, a signal each, with a panel for every joint in it.

The panels of a block stand side by side as long as they can be read, and then in further rows. All
have one time axis, and those of a block one scale.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ._curves import outline
from ._joints import Joints, Window, chosen, lengths_of, rows_in, title
from ._look import SMALL, TEXT, TITLE
from ._picture import LETTER, Picture, literal
from .record import Status
from .run import Run

Array = NDArray[np.float64]

MOST, NARROW = 4, 1.1
"""Panels side by side, and the least width of one [in]."""

LOWEST, HIGHEST, SHARE = 0.62, 1.15, 0.42
"""Height of a panel [in], and as a share of the width of the narrowest."""

ABOVE, AROUND, TICK = 0.17, 0.34, 0.42
"""Room for a title, for the time axis, and of a number on it [in]."""

DOTS = 300.0
"""Stretches of a curve an inch: of each its smallest and its largest value are drawn."""

WIDER = 1.17
"""The name of an axis has letters so much wider than a legend."""

ENLARGED = (5, 10, 20, 50, 100, 200, 500, 1000)
"""How many times a panel may be larger than the others of its block."""

ROOM = 0.08
"""Above and below the curves, as a part of their range."""

FLAT = 3.0
"""Panels of one axis are told apart if none has less than this part of it."""

BEFORE = 0.85
"""The part of a run that blew up that can be read."""


@dataclass(frozen=True, eq=False)
class Part:
    """The part of a run that is drawn."""

    run: Run
    rows: slice
    joints: list[int]

    @classmethod
    def of(cls, run: Run, joints: Joints, window: Window) -> Part:
        """Of the arguments of a picture."""
        return cls(run, rows_in(run.t, window), chosen(joints, run.joint_names))

    @property
    def t(self) -> Array:
        """Time [s]."""
        return self.run.t[self.rows]

    @property
    def titles(self) -> list[str]:
        """What the joints are called."""
        return [title(self.run.joint_names[joint]) for joint in self.joints]

    @property
    def lengths(self) -> list[str]:
        """What each of them moves in, "rad" or "m"."""
        return [lengths_of(self.run)[joint] for joint in self.joints]

    @property
    def wild(self) -> bool:
        """Whether it blows up."""
        return self.run.status.kind == "diverged"

    def of_joint(self, name: str, joint: int) -> Array:
        """A signal of one joint."""
        values: Array = getattr(self.run, name)[self.rows, joint]
        return values


class Sheet:
    """A picture that is filled block by block, from the top."""

    def __init__(self, t: Array, plan: Sequence[int], *, width: float | None, style: str) -> None:
        """``plan``: how many panels each block has."""
        self.picture = Picture(width, style=style)
        self.look = self.picture.look
        self._columns = [_columns(panels, self.picture.wide) for panels in plan]
        self._plan, self._block, self._row = plan, 0, 0
        self._drawn: dict[Axes, list[tuple[Array, bool]]] = {}
        self._units: dict[Axes, str] = {}
        self._span = (float(t[0]), max(float(t[-1]), float(t[0]) + 1e-9))
        self._titled = self._enlarged = False
        least = SHARE * self.picture.wide / max(self._columns)
        height = max(LOWEST, min(HIGHEST, least)) + ABOVE
        rows = sum(-(-panels // across) for panels, across in zip(plan, self._columns, strict=True))
        self.picture.set_figheight(rows * height + AROUND)
        self._height = height - ABOVE
        self._grid = self.picture.add_gridspec(rows, math.lcm(*self._columns))

    def block(
        self, names: Sequence[str], units: Sequence[str], titles: Sequence[str] = ()
    ) -> list[Axes]:
        """The panels of the next block, with unit and title each; one name is that of all."""
        panels, columns = self._plan[self._block], self._columns[self._block]
        each = self._grid.ncols // columns
        last = self._block + 1 == len(self._plan) or self._columns[self._block + 1] != columns
        titled = titles and (panels > columns or not self._titled)
        self._titled |= bool(titles)
        made = []
        for k in range(panels):
            row, column = self._row + k // columns, k % columns
            axes = self.picture.add_subplot(self._grid[row, each * column : each * (column + 1)])
            self._dress(axes, last and k + columns >= panels, columns)
            axes.set_xlabel("time [s]" if last and k // columns == (panels - 1) // columns else "")
            named = f"{names[k % len(names)]} [{units[k]}]"
            if len(names) > 1:
                self._title(axes, named)
            elif column == 0:
                self._label(axes, named)
            if titles:
                other = f"[{units[k]}]" if units[k] != units[0] else ""
                self._title(axes, f"{literal(titles[k]) if titled else ''} {other}".strip())
            self._units[axes], self._drawn[axes] = units[k], []
            made.append(axes)
        self._row += -(-panels // columns)
        self._block += 1
        return made

    def line(self, axes: Axes, t: Array, values: Array, wild: bool = False, **style: Any) -> None:
        """Draw a curve; one that is ``wild`` blows up."""
        dots = 2 * int(DOTS * self.picture.wide * _share_of(axes))
        axes.plot(*outline(t, values, dots), **({"linewidth": 1.0} | style))
        self._drawn[axes].append((values, wild))

    def share(self, panels: Sequence[Axes], about_zero: bool) -> None:
        """Give the panels one scale, those of another unit another.

        About zero, a joint with far less than the others is enlarged, and told. Otherwise each
        panel may have its own middle, where all would be flat on one axis.
        """
        for unit in dict.fromkeys(self._units[axes] for axes in panels):
            group = [axes for axes in panels if self._units[axes] == unit]
            reaches = [_reach(self._drawn[axes], about_zero) for axes in group]
            low, high = min(low for low, _ in reaches), max(high for _, high in reaches)
            self._scale(group, reaches, (low, high), about_zero)
        for axes in panels:
            axes.yaxis.set_major_locator(MaxNLocator(nbins=4, min_n_ticks=3))
            if about_zero:
                axes.axhline(0.0, color=self.look.gray, linewidth=0.6, zorder=1)
        self._number(panels)

    def finish(self, status: Status | None = None, heading: str = "") -> Picture:
        """The picture, with its legend, and above all what happened to a run."""
        keys: dict[str, Artist] = {}
        for axes in self.picture.axes:
            handles, labels = axes.get_legend_handles_labels()
            keys |= {
                label: handle
                for label, handle in zip(labels, handles, strict=True)
                if label not in keys
            }
        if self._enlarged:
            keys["×n: enlarged n times"] = Line2D([], [], linestyle="none")
        self.picture.explain(keys)
        bad = status is not None and not status.finished
        told = "\n".join(text for text in (heading, str(status) if bad else "") if text)
        if told:
            self.picture.head(told, alarm=bad)
        return self.picture

    def _dress(self, axes: Axes, numbered: bool, columns: int) -> None:
        self.picture.frame(axes)
        axes.set_xlim(self._span)
        ticks = max(2, int(self.picture.wide / columns / TICK))
        axes.xaxis.set_major_locator(MaxNLocator(nbins=ticks, steps=[1, 2, 5, 10]))
        axes.tick_params(labelbottom=numbered)

    def _title(self, axes: Axes, words: str) -> None:
        ink = self.look.ink
        axes.set_title(words, loc="right", fontsize=TITLE, fontweight="bold", color=ink, pad=2.0)

    def _label(self, axes: Axes, words: str) -> None:
        """Name an axis, in two lines where one is longer than the panel is high."""
        if WIDER * LETTER * len(words) > self._height:
            words = words.replace(" [", "\n[")
        axes.set_ylabel(words, fontsize=TEXT)

    def _scale(
        self,
        group: Sequence[Axes],
        reaches: Sequence[tuple[float, float]],
        whole: tuple[float, float],
        about_zero: bool,
    ) -> None:
        """Set the limits of the panels of one unit."""
        low, high = whole
        room = ROOM * (high - low) or 1.0
        own = [end - start for start, end in reaches]
        apart = not about_zero and min(own) * FLAT < high - low
        for axes, (start, end), size in zip(group, reaches, own, strict=True):
            factor = _factor(high - low, size) if about_zero else 1
            if factor == 1 and not apart:
                axes.set_ylim(low - room, high + room)
                continue
            span = (high - low if about_zero else max(own)) / factor
            middle, half = 0.5 * (start + end), (0.5 + ROOM) * span or 1.0
            axes.set_ylim(middle - half, middle + half)
            if factor > 1:
                self._enlarged = True
                box = {"facecolor": self.look.paper, "edgecolor": "none", "alpha": 0.8, "pad": 1}
                axes.text(
                    0.99, 0.98, f"×{factor}", transform=axes.transAxes, ha="right", va="top",
                    fontsize=SMALL, fontweight="bold", color=self.look.ink, bbox=box,
                )  # fmt: skip

    def _number(self, panels: Sequence[Axes]) -> None:
        """Write an axis' numbers once a row, at its first panel."""
        seen = set()
        for axes in panels:
            place = axes.get_subplotspec()
            key = (0 if place is None else place.rowspan.start, axes.get_ylim())
            axes.tick_params(labelleft=key not in seen)
            seen.add(key)


def _share_of(axes: Axes) -> float:
    """The share of the picture's width that a panel has."""
    place = axes.get_subplotspec()
    return 1.0 if place is None else len(place.colspan) / place.get_gridspec().ncols


def _columns(panels: int, width: float) -> int:
    """How many panels stand side by side: rows of equal length, as far as that goes."""
    most = max(1, min(MOST, int(width / NARROW)))
    rows = -(-panels // most)
    return -(-panels // rows)


def _factor(whole: float, own: float) -> int:
    """How many times a panel is enlarged."""
    fitting = [factor for factor in ENLARGED if own * factor <= whole]
    return max(fitting, default=1) if own * ENLARGED[-1] >= 0.1 * whole else 1


def _reach(drawn: Sequence[tuple[Array, bool]], about_zero: bool) -> tuple[float, float]:
    """The range of the curves of a panel, of wild ones only where there are no others.

    Of a wild one, what it does before it blows up.
    """
    sane = [values for values, wild in drawn if not wild]
    heads = [values[: max(1, round(BEFORE * len(values)))] for values, _ in drawn]
    shown = np.concatenate(sane or heads)
    shown = shown[np.isfinite(shown)]
    low, high = (float(shown.min()), float(shown.max())) if len(shown) else (0.0, 0.0)
    if sane and len(sane) < len(drawn):
        low, high = low - (high - low), high + (high - low)
    return (min(low, 0.0), max(high, 0.0)) if about_zero else (low, high)
