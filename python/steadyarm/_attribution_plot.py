"""The picture of an `Attribution`: torque by cause over time, and shares of the error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from . import plots
from .attribution import WORDS, Attribution, percent

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

COLOURS = (
    plots.BLUE, plots.ORANGE, plots.GREEN, "#E69F00", plots.PURPLE, plots.SKY, "#8C564B", "#B2A100",
)  # fmt: skip
"""Of the causes that are drawn, the largest first."""

OTHER = "other causes"
"""What all that is small is drawn as."""

ROUNDING = 1e-9
"""Causes that are smaller, relative to all of them, are not drawn."""

WIDTH = 600
"""Points of a curve at the most: each is the mean of the rows around it."""

SHOWN, BARS, FRACTION = 0.02, 4, 0.005
"""From which share on a cause is drawn, how many bars a joint has, and what part of the rows may
stick out of the axes."""


def attribution(found: Attribution, joints: Sequence[int]) -> plots.Picture:
    """Draw these joints, one below the other, the shares of the error at the right."""
    height = 2.6 if len(joints) < 4 else 1.75
    picture = plots.Picture(width=11.0, height=height * len(joints) + 1.0)
    grid = picture.add_gridspec(len(joints), 2, width_ratios=(2.2, 1.0))
    colours = _colours(found, joints)
    keys: dict[str, Artist] = {}
    for row, joint in enumerate(joints):
        over_time, bars = (picture.add_subplot(grid[row, column]) for column in range(2))
        _stacked(over_time, found, joint, colours)
        _bars(bars, {name: float(it[joint]) for name, it in found.error_shares.items()}, colours)
        over_time.set_title(f"joint {joint + 1}", loc="right", fontsize=11, fontweight="bold")
        unit, rms = found.units[joint], 1e3 * found.rms_of_error[joint]
        bars.set_title(f"error, RMS {rms:.3g} m{unit}", loc="left", fontsize=9, color=plots.INK)
        over_time.set_ylabel("torque [N·m]" if unit == "rad" else "force [N]")
        handles, labels = over_time.get_legend_handles_labels()
        keys |= dict(zip(labels, handles, strict=True))
        over_time.tick_params(labelbottom=row == len(joints) - 1)
        if row == len(joints) - 1:
            over_time.set_xlabel("time [s]")
            bars.set_xlabel("estimated share of the error [%]")
    order = sorted(keys, key=[*(WORDS[name] for name in colours), *keys].index)
    picture.legend(
        [keys[word] for word in order], order, loc="outside lower center", ncols=min(len(order), 5),
        frameon=False, fontsize=9,
    )  # fmt: skip
    return picture


def _colours(found: Attribution, joints: Sequence[int]) -> dict[str, str]:
    """The causes that matter at these joints, the largest first, with their colours."""
    sizes: dict[str, float] = {}
    for shares in (_absolute_shares(found), found.error_shares):
        for name, share in shares.items():
            size = float(np.nan_to_num(np.abs(share[list(joints)])).max())
            sizes[name] = max(sizes.get(name, 0.0), min(size, 1.0))
    apart = ("rest", "start", "cancelled")  # of these there are no torques to be stacked
    named = [name for name in sizes if sizes[name] >= SHOWN and name not in apart]
    named.sort(key=lambda name: -sizes[name])
    return dict(zip(named, COLOURS, strict=False))


def _absolute_shares(found: Attribution) -> dict[str, Array]:
    """RMS of each cause as a share of all these, (n,)."""
    sizes = {name: size for name, size in found.rms_torque.items() if name != "cancelled"}
    total = np.sum(list(sizes.values()), axis=0)
    return {name: size / np.where(total > 0.0, total, 1.0) for name, size in sizes.items()}


def _stacked(axes: Axes, found: Attribution, joint: int, colours: Mapping[str, str]) -> None:
    """The causes on one another, those below zero downwards; lines for their sum and its answer."""
    rows = found.rows
    t = _thinned(found.t[rows])
    parts = {
        name: _thinned(part[rows, joint])
        for name, part in found.torque.items()
        if name != "cancelled"
    }
    drawn = {name: parts.pop(name) for name in colours if name in parts}
    layers = [(WORDS[name], colours[name], part) for name, part in drawn.items()]
    others = np.sum([np.zeros(len(t)), *parts.values()], axis=0)
    if np.abs(others).max() > ROUNDING * np.abs(found.mismatch[rows, joint]).max():
        layers.append((OTHER, plots.PALE, others))
    ends = np.zeros((2, len(t)))
    for word, colour, part in layers:
        for side, half in enumerate((np.minimum(part, 0.0), np.maximum(part, 0.0))):
            axes.fill_between(
                t, ends[side], ends[side] + half, color=colour, linewidth=0.0, alpha=0.85,
                label=word if side else "",
            )  # fmt: skip
            ends[side] += half
    whole = _thinned(found.mismatch[rows, joint])
    axes.plot(t, whole, color=plots.INK, linewidth=1.0, label="all causes")
    answer = -_thinned(found.torque["cancelled"][rows, joint])
    if answer.any():
        axes.plot(
            t, answer, color=plots.INK, linewidth=1.2, linestyle=(0, (3, 2)),
            label="what the controller cancels",
        )  # fmt: skip
    plots.frame(axes)
    axes.set_xlim(float(t[0]), max(float(t[-1]), float(t[0]) + 1e-9))
    low = float(np.quantile(np.minimum(ends[0], answer), FRACTION))
    high = float(np.quantile(np.maximum(ends[1], answer), 1.0 - FRACTION))
    room = 0.08 * (high - low) or 1.0
    axes.set_ylim(low - room, high + room)


def _bars(axes: Axes, shares: Mapping[str, float], colours: Mapping[str, str]) -> None:
    """The largest shares of the error, the largest on top."""
    if not np.isfinite(list(shares.values())).all():
        axes.text(0.5, 0.5, "no linear loop\nexplains it", ha="center", va="center", fontsize=9)
        axes.set_axis_off()
        return
    named = sorted(shares, key=lambda name: -abs(shares[name]))
    named = [name for name in named if abs(shares[name]) >= SHOWN][:BARS] or named[:1]
    values = [100.0 * shares[name] for name in named]
    shown = [colours.get(name, plots.GRAY) for name in named]
    axes.barh(range(len(named)), values, color=shown, height=0.7, alpha=0.85)
    axes.axvline(0.0, color=plots.GRAY, linewidth=0.7)
    low, high = min(*values, 0.0), max(*values, 100.0)
    for place, (name, value) in enumerate(zip(named, values, strict=True)):
        axes.text(
            max(value, 0.0) + 0.03 * (high - low), place, f"{percent(value / 100)}  {WORDS[name]}",
            va="center", fontsize=8.5, color=plots.INK,
        )  # fmt: skip
    plots.frame(axes)
    axes.grid(visible=False)
    axes.set_yticks([])
    axes.set_ylim(BARS - 0.4, -0.6)
    axes.set_xticks([tick for tick in (-100, -50, 0, 50, 100) if low <= tick <= high])
    axes.set_xlim(low - 0.03 * (high - low), low + 2.5 * (high - low))


def _thinned(values: Array) -> Array:
    """Means of neighbouring rows, so many that a picture can show them."""
    edges = np.unique(np.linspace(0, len(values), WIDTH + 1).astype(int))
    sums = np.add.reduceat(values, edges[:-1])
    means: Array = sums / np.diff(edges)
    return means
