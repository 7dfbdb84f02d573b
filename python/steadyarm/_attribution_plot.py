"""The picture of an `Attribution`: torque by cause over time, and shares of the error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray

from ._joints import title
from ._look import DASHED, SMALL, TITLE, Look
from ._picture import TYPES, Picture, literal
from .attribution import WORDS, Attribution, percent

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

OTHER = "other causes"
"""What all that is small is drawn as."""

ROUNDING = 1e-9
"""Causes that are smaller, relative to all of them, are not drawn."""

WIDTH = 600
"""Points of a curve at the most: each is the mean of the rows around it."""

SHOWN, BARS, FRACTION = 0.02, 4, 0.005
"""From which share on a cause is drawn, how many bars a joint has, and what part of the rows may
stick out of the axes."""

BESIDE = 5.0
"""From this width on the shares stand beside the torque, in a narrower picture below it [in]."""

HIGH, LOW, FEW = 1.6, 1.15, 3
"""Height of a panel [in]: where a picture has a few of them, and where it has more."""

Filling = tuple[str, str]
"""Colour and hatch."""


def attribution(
    found: Attribution, joints: Sequence[int], width: float | None, style: str
) -> Picture:
    """Draw these joints, one below the other, with the shares of the error."""
    picture = Picture(width, style=style)
    beside = picture.wide >= BESIDE
    rows = len(joints) * (1 if beside else 2)
    picture.set_figheight((HIGH if rows <= FEW else LOW) * rows + 0.4)
    grid = picture.add_gridspec(rows, 2 if beside else 1, width_ratios=(2.0, 1.0)[: 1 + beside])
    areas = _areas(found, joints, picture.look)
    keys: dict[str, Artist] = {}
    for place, joint in enumerate(joints):
        cells = [(place, 0), (place, 1)] if beside else [(2 * place, 0), (2 * place + 1, 0)]
        over_time, bars = (picture.add_subplot(grid[cell]) for cell in cells)
        last = place == len(joints) - 1
        with rc_context(TYPES):  # type: ignore[arg-type]
            _stacked(picture, over_time, found, joint, areas)
            _bars(picture, bars, found, joint, areas)
        handles, labels = over_time.get_legend_handles_labels()
        keys |= dict(zip(labels, handles, strict=True))
        over_time.tick_params(labelbottom=last or not beside)
        over_time.set_xlabel("time [s]" if last else "")
        bars.set_xlabel("estimated share of the error [%]" if last else "")
    order = sorted(keys, key=[*(WORDS[name] for name in areas), *keys].index)
    picture.explain({word: keys[word] for word in order})
    return picture


def _areas(found: Attribution, joints: Sequence[int], look: Look) -> dict[str, Filling]:
    """The causes that matter at these joints, the largest first, and how they are filled."""
    sizes: dict[str, float] = {}
    for shares in (_absolute_shares(found), found.error_shares):
        for name, share in shares.items():
            size = float(np.nan_to_num(np.abs(share[list(joints)])).max())
            sizes[name] = max(sizes.get(name, 0.0), min(size, 1.0))
    apart = ("rest", "start", "cancelled")  # of these there are no torques to be stacked
    named = [name for name in sizes if sizes[name] >= SHOWN and name not in apart]
    named.sort(key=lambda name: -sizes[name])
    return dict(zip(named, look.areas, strict=False))


def _absolute_shares(found: Attribution) -> dict[str, Array]:
    """RMS of each cause as a share of all these, (n,)."""
    sizes = {name: size for name, size in found.rms_torque.items() if name != "cancelled"}
    total = np.sum(list(sizes.values()), axis=0)
    return {name: size / np.where(total > 0.0, total, 1.0) for name, size in sizes.items()}


def _stacked(
    picture: Picture, axes: Axes, found: Attribution, joint: int, areas: Mapping[str, Filling]
) -> None:
    """The causes on one another, those below zero downwards; lines for their sum and its answer."""
    rows, look = found.rows, picture.look
    t = _thinned(found.t[rows])
    ends = np.zeros((2, len(t)))
    for word, (colour, hatch), part in _layers(found, joint, areas, look):
        for side, half in enumerate((np.minimum(part, 0.0), np.maximum(part, 0.0))):
            axes.fill_between(
                t, ends[side], ends[side] + half, facecolor=colour, hatch=hatch,
                edgecolor=look.paper, linewidth=0.0, label=word if side else "",
            )  # fmt: skip
            ends[side] += half
    whole = _thinned(found.mismatch[rows, joint])
    axes.plot(t, whole, color=look.ink, linewidth=0.8, label="all causes")
    answer = -_thinned(found.torque["cancelled"][rows, joint])
    if answer.any():
        axes.plot(
            t, answer, color=look.ink, linewidth=1.0, linestyle=DASHED,
            label="what the controller cancels",
        )  # fmt: skip
    picture.frame(axes)
    name = title(found.joint_names[joint])
    axes.set_title(
        literal(name), loc="right", fontsize=TITLE, fontweight="bold", color=look.ink, pad=2.0
    )
    axes.set_ylabel("torque [N·m]" if found.units[joint] == "rad" else "force [N]")
    axes.set_xlim(float(t[0]), max(float(t[-1]), float(t[0]) + 1e-9))
    low = float(np.quantile(np.minimum(ends[0], answer), FRACTION))
    high = float(np.quantile(np.maximum(ends[1], answer), 1.0 - FRACTION))
    room = 0.08 * (high - low) or 1.0
    axes.set_ylim(low - room, high + room)


def _layers(
    found: Attribution, joint: int, areas: Mapping[str, Filling], look: Look
) -> list[tuple[str, Filling, Array]]:
    """Words, filling and torque of what is stacked: causes that matter, and all others as one."""
    rows = found.rows
    parts = {
        name: _thinned(part[rows, joint])
        for name, part in found.torque.items()
        if name != "cancelled"
    }
    drawn = {name: parts.pop(name) for name in areas if name in parts}
    layers = [(WORDS[name], areas[name], part) for name, part in drawn.items()]
    if not parts:
        return layers
    others: Array = np.sum(list(parts.values()), axis=0)
    if np.abs(others).max() > ROUNDING * np.abs(found.mismatch[rows, joint]).max():
        layers.append((OTHER, (look.pale, ""), others))
    return layers


def _bars(
    picture: Picture, axes: Axes, found: Attribution, joint: int, areas: Mapping[str, Filling]
) -> None:
    """The largest shares of the error, the largest on top."""
    look, rms = picture.look, 1e3 * found.rms_of_error[joint]
    axes.set_title(
        f"error, RMS {rms:.3g} m{found.units[joint]}", loc="left", fontsize=TITLE, color=look.ink,
        pad=2.0,
    )  # fmt: skip
    shares = {name: float(share[joint]) for name, share in found.error_shares.items()}
    if not np.isfinite(list(shares.values())).all():
        words = "no linear loop\nexplains it"
        axes.text(0.5, 0.5, words, ha="center", va="center", fontsize=SMALL, color=look.ink)
        axes.set_axis_off()
        return
    named = sorted(shares, key=lambda name: -abs(shares[name]))
    named = [name for name in named if abs(shares[name]) >= SHOWN][:BARS] or named[:1]
    values = [100.0 * shares[name] for name in named]
    low, high = min(*values, 0.0), max(*values, 100.0)
    for place, (name, value) in enumerate(zip(named, values, strict=True)):
        colour, hatch = areas.get(name, (look.gray, ""))
        axes.barh(place, value, color=colour, hatch=hatch, edgecolor=look.paper, linewidth=0.0)
        axes.text(
            max(value, 0.0) + 0.03 * (high - low), place, f"{percent(value / 100)}  {WORDS[name]}",
            va="center", fontsize=SMALL, color=look.ink,
        )  # fmt: skip
    axes.axvline(0.0, color=look.gray, linewidth=0.6)
    picture.frame(axes)
    axes.grid(visible=False)
    axes.set_yticks([])
    axes.set_ylim(BARS - 0.4, -0.6)
    axes.set_xticks([tick for tick in (-100, -50, 0, 50, 100) if low <= tick <= high])
    axes.set_xlim(low - 0.03 * (high - low), low + 2.7 * (high - low))


def _thinned(values: Array) -> Array:
    """Means of neighbouring rows, so many that a picture can show them."""
    edges = np.unique(np.linspace(0, len(values), WIDTH + 1).astype(int))
    sums = np.add.reduceat(values, edges[:-1])
    means: Array = sums / np.diff(edges)
    return means
