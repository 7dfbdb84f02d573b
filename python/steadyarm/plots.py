"""Pictures of runs: everything at once, the paper's layout, errors side by side, approximation.

Every function returns a figure that shows itself in a notebook, opens a window with ``.show()`` and
writes a file with ``.savefig("run.png")``. No display is needed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator
from numpy.typing import NDArray

from . import _files
from .record import CHANNELS
from .run import Run

BLUE, ORANGE, GREEN, PURPLE, SKY = "#0072B2", "#D55E00", "#009E73", "#AA4499", "#56B4E9"
INK, GRAY, PALE, FAINT = "#222222", "#767676", "#B8B8B8", "#E6E6E6"
"""Colours that colour-blind readers can tell apart (Okabe and Ito)."""

CYCLE = ((BLUE, "-"), (ORANGE, "-"), (INK, (0, (3, 3))), (GREEN, "-"), (PURPLE, "-"), (SKY, "-"))
"""Colour and line of the runs that are compared; one is dashed, to be seen on top of another."""

DPI = 150
"""Dots per inch of pictures in files."""

Array = NDArray[np.float64]


class Picture(Figure):
    """A matplotlib figure that needs no pyplot, and still shows itself in a notebook."""

    def __init__(self, width: float, height: float) -> None:
        super().__init__(figsize=(width, height), dpi=DPI, layout="constrained")
        self.get_layout_engine().set(w_pad=0.08, h_pad=0.06)  # type: ignore[union-attr, call-arg]

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write the picture, as any matplotlib figure does; a file is replaced as a whole."""
        if not isinstance(fname, str | PathLike):
            super().savefig(fname, **options)
            return
        path = Path(fname)
        form = options.pop("format", None) or path.suffix[1:].lower()
        if not form:
            form = matplotlib.rcParams["savefig.format"]
            path = path.with_name(f"{path.name}.{form}")
        drawn = BytesIO()
        super().savefig(drawn, format=form, **options)
        _files.content(path, drawn.getvalue())

    def _repr_png_(self) -> bytes:
        """The picture, for notebooks."""
        png = BytesIO()
        self.savefig(png, format="png", dpi=100)
        return png.getvalue()

    def show(self, warn: bool = True) -> None:
        """Open a window and wait until it is closed (matplotlib 3.11 or newer, with a display)."""
        from matplotlib import pyplot

        if self.canvas.manager is None:
            if not hasattr(matplotlib, "__version_info__") or matplotlib.__version_info__ < (3, 11):
                raise RuntimeError(
                    f"show: matplotlib is {matplotlib.__version__}, a window wants 3.11 or newer; "
                    'use .savefig("run.png")'
                )
            pyplot.figure(self)
        pyplot.show()


def overview(run: Run) -> Picture:
    """Draw a whole run, one column a joint.

    From the top: position, error, torque with its two parts (if it was recorded); with a
    compensator also what the model leaves out (ρ) against its estimate (ρ̂), the size of the weights
    and the Lyapunov function V, and what the compensator adds. Of a run that blew up the axes show
    the part that can be read, and the title says what happened.
    """
    adaptive = run.weights_norm is not None and run.V is not None
    rows = (4 if adaptive else 3) if len(run.tau) else 2
    own = [channel.name for channel in run.own]
    below = adaptive + len(own)
    width = max(5.2 * min(run.joints, 2), 2.9 * run.joints, 7.0)
    picture = Picture(width=width, height=2.2 * (rows + below) + 0.3)
    grid = picture.add_gridspec(rows + below, 2 * run.joints)
    words = {"q": "position", "e": "error", "tau": "torque", "rho": "model error"}
    names = [f"{word} [{CHANNELS[name][0]}]" for name, word in words.items()]
    narrow = run.joints > 2
    keys: dict[str, Artist] = {}
    for joint in range(run.joints):
        column = [picture.add_subplot(grid[row, 2 * joint : 2 * joint + 2]) for row in range(rows)]
        _position(column[0], run, joint)
        _line(column[1], run.t, run.e[:, joint], ORANGE)
        column[1].axhline(0.0, color=GRAY, linewidth=0.7, zorder=1)
        if len(run.tau):
            _torque(column[2], run, joint, adaptive)
        if adaptive:
            _model_error(column[3], run, joint)
        for axes, name in zip(column, names, strict=False):
            _dress(axes, run, name if joint == 0 else "", legend=joint == 0 and not narrow)
            handles, labels = axes.get_legend_handles_labels()
            keys |= dict(zip(labels, handles, strict=True))
        column[0].set_title(f"joint {joint + 1}", loc="right", fontsize=11, fontweight="bold")
        column[-1].set_xlabel("time [s]")
    if run.weights_norm is not None and run.V is not None:
        parts = (("weights_norm", PURPLE, "weights, |W|"), ("V", BLUE, "Lyapunov function V"))
        for side, (name, colour, word) in enumerate(parts):
            half = slice(side * run.joints, (side + 1) * run.joints)
            axes = picture.add_subplot(grid[rows, half])
            _line(axes, run.t, getattr(run, name), colour)
            _dress(axes, run, f"{word} [{CHANNELS[name][0]}]")
            axes.set_xlabel("time [s]")
    for row, name in enumerate(own, start=rows + adaptive):
        _signal(picture.add_subplot(grid[row, :]), run, name)
    if narrow:
        picture.legend(
            keys.values(), keys.keys(), loc="outside lower center", ncols=len(keys), frameon=False,
            fontsize=10,
        )  # fmt: skip
    if not run.status.finished:
        picture.suptitle(str(run.status), color=ORANGE, fontsize=11, fontweight="bold")
    return picture


def signals(run: Run, names: Sequence[str]) -> Picture:
    """Draw signals of a run one below the other, by their names in `Run.channels`.

    A signal of several joints has a curve a joint. Raises ValueError for one that the run has not.
    """
    unknown = [name for name in names if name not in run.channels]
    if unknown or not names:
        got = repr(unknown[0]) if unknown else "none"
        raise ValueError(f"names: got {got}, wants some of {', '.join(run.channels)}")
    picture = Picture(width=8.0, height=2.2 * len(names) + 0.3)
    for row, name in enumerate(names):
        _signal(picture.add_subplot(len(names), 1, row + 1), run, name)
    if not run.status.finished:
        picture.suptitle(str(run.status), color=ORANGE, fontsize=11, fontweight="bold")
    return picture


def paper_figure(run: Run, title: str) -> Picture:
    """Draw a run as the paper does: joint 1 left, joint 2 right; desired dotted, actual solid."""
    picture = Picture(width=max(5.0 * run.joints, 5.5), height=3.5)
    for joint in range(run.joints):
        axes = picture.add_subplot(1, run.joints, joint + 1)
        _position(axes, run, joint)
        _dress(axes, run, "position [rad]" if joint == 0 else "", legend=joint == 0)
        axes.set_title(f"joint {joint + 1}", loc="right", fontsize=11, fontweight="bold")
        axes.set_xlabel("time [s]")
    status = "" if run.status.finished else f"\n{run.status}"
    picture.suptitle(title + status, fontsize=12)
    return picture


def errors(runs: Mapping[str, Run]) -> Picture:
    """Compare the errors of several runs, joint by joint; the legend gives their RMS [rad].

    The RMS is over the second half of each run, when the start is forgotten.
    """
    if not runs:
        raise ValueError("runs: got none, wants at least one")
    joints = next(iter(runs.values())).joints
    picture = Picture(width=10.0, height=(2.7 + 0.12 * len(runs)) * joints)
    for joint in range(joints):
        axes = picture.add_subplot(joints, 1, joint + 1)
        axes.axhline(0.0, color=GRAY, linewidth=0.7, zorder=1)
        for index, (name, run) in enumerate(runs.items()):
            colour, line = CYCLE[index % len(CYCLE)]
            label = f"{name}: {_late_rms(run, joint)}"
            _line(axes, run.t, run.e[:, joint], colour, linestyle=line, label=label)
        longest = max(runs.values(), key=lambda run: float(run.t[-1]))
        _dress(axes, longest, f"joint {joint + 1}, error [rad]")
        if any(run.status.kind == "diverged" for run in runs.values()):
            sane = [run.e[:, joint] for run in runs.values() if run.status.kind != "diverged"]
            _limit(axes, sane, margin=1.0)
        axes.legend(
            loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=9,
            title="RMS error of the second half", title_fontsize=9, alignment="left",
        )  # fmt: skip
        if joint == joints - 1:
            axes.set_xlabel("time [s]")
    return picture


def approximation(rows: Sequence[tuple[int, float]]) -> Picture:
    """Draw the largest error of fuzzy fits against their number of rules, both logarithmic.

    ``rows`` holds (rules, sup |g - f|). The universal approximation statement (5) says that the
    curve comes below any ε.
    """
    if not rows:
        raise ValueError("rows: got none, wants at least one")
    rules, error = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
    picture = Picture(width=7.0, height=4.6)
    axes = picture.add_subplot()
    axes.loglog(rules, error, color=BLUE, linewidth=1.6, marker="o", markersize=5)
    frame(axes)
    axes.set_xticks(rules, labels=[str(count) for count in rules])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlabel("number of rules [1]")
    axes.set_ylabel("largest error, sup |g − f| [unit of g]")
    axes.set_title("A fuzzy system comes as close as you like, given enough rules", fontsize=12)
    return picture


def _signal(axes: Axes, run: Run, name: str) -> None:
    """One signal over time, a curve a joint."""
    array = np.asarray(getattr(run, name))
    labels = [""] if array.ndim == 1 else [f"joint {joint + 1}" for joint in range(run.joints)]
    for index, (curve, label) in enumerate(
        zip(array.reshape(len(run.t), -1).T, labels, strict=True)
    ):
        colour, line = CYCLE[index % len(CYCLE)]
        _line(axes, run.t, curve, colour, linestyle=line, label=label)
    _dress(axes, run, f"{name} [{run.channels[name].unit}]")
    axes.set_xlabel("time [s]")


def _position(axes: Axes, run: Run, joint: int) -> None:
    _line(axes, run.t, run.q[:, joint], BLUE, label="actual")
    dotted = (0, (1, 1.6))
    _line(axes, run.t, run.q_d[:, joint], INK, linestyle=dotted, linewidth=1.6, label="desired")


def _torque(axes: Axes, run: Run, joint: int, adaptive: bool) -> None:
    width, label = (2.4, "applied") if adaptive else (1.3, "")
    _line(axes, run.t, run.tau[:, joint], INK, linewidth=width, label=label)
    if adaptive:
        _line(axes, run.t, run.tau_model[:, joint], SKY, label="from the model")
        _line(axes, run.t, run.tau_compensation[:, joint], GREEN, label="from the compensator")


def _model_error(axes: Axes, run: Run, joint: int) -> None:
    _line(axes, run.t, run.rho[:, joint], PALE, linewidth=2.6, label="ρ, left out by the model")
    dashed, label = (0, (3, 1.2)), "ρ̂, compensator's estimate"
    _line(axes, run.t, run.rho_hat[:, joint], GREEN, linestyle=dashed, label=label)


def _line(axes: Axes, t: Array, values: Array, colour: str, **style: Any) -> None:
    axes.plot(t, values, color=colour, **({"linewidth": 1.3} | style))


def _dress(axes: Axes, run: Run, name: str, legend: bool = True) -> None:
    """Axes of one signal over the run: limits, name with unit, legend above the curves."""
    frame(axes)
    axes.set_ylabel(name)
    axes.set_xlim(float(run.t[0]), max(float(run.t[-1]), float(run.t[0]) + 1e-9))
    if run.status.kind == "diverged":
        _limit(axes)
    _, labels = axes.get_legend_handles_labels()
    if legend and labels:
        axes.legend(
            loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=len(labels), frameon=False,
            fontsize=9, borderaxespad=0.2, handlelength=1.6, columnspacing=1.2,
        )  # fmt: skip


def _limit(axes: Axes, sane: Sequence[Array] = (), margin: float = 0.15) -> None:
    """Show the ``sane`` curves; if there are none, what the others do before they blow up.

    That is the first 85 % of their samples. The margin is a part of the range.
    """
    curves = [np.asarray(line.get_ydata(), dtype=float) for line in axes.get_lines()]
    heads = [curve[: max(1, round(0.85 * len(curve)))] for curve in curves]
    shown = np.concatenate(sane or heads)
    low, high = float(shown.min()), float(shown.max())
    room = margin * (high - low) or 1.0
    axes.set_ylim(low - room, high + room)


def frame(axes: Axes) -> None:
    """Draw a frame as all pictures have it."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(GRAY)
    axes.grid(color=FAINT, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK, labelsize=9, color=GRAY)
    axes.margins(y=0.08)


def _late_rms(run: Run, joint: int) -> str:
    """RMS of the error over the second half; why there is none, if the run did not finish."""
    if run.status.kind == "unresolved":
        return run.status.kind
    if not run.status.finished:
        return f"{run.status.kind} at {run.status.t:.4g} s"
    late = run.e[run.t >= 0.5 * (run.t[0] + run.t[-1]), joint]
    return f"{float(np.sqrt(np.mean(late**2))):.3g} rad"
