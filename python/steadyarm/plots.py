"""Pictures: a run as a whole, the paper's layout, errors of several runs, error against effort.

Every function returns a figure that shows itself in a notebook, opens a window with ``.show()`` and
writes a file with ``.savefig("run.png")``; .pdf and .svg have curves, and letters as text. No
display is needed. What they share:

- ``joints``: some of the joints, by number from 1 or by name; ``window``: (from, to) [s].
- ``width`` [in] as it will be printed: 7.16 (the default) for two columns of a journal, 3.5 for
  one. Letters have 7 and 8 pt there; do not scale the picture.
- ``style``: "light" for paper, "dark" for dark slides.

The panels of a signal have one scale. One of a joint with far smaller numbers is enlarged: it says
×10, and its axis has its own numbers. Errors are in mrad, in mm of a prismatic joint.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from ._joints import Joints, Window, in_length
from ._look import DASH_DOT, DASHED, DOTTED, SMALL, Style
from ._pareto import EFFORT, ERROR, Axis, beats, brief, has_both, meet, value_of
from ._picture import LETTER, Picture, literal
from ._sheet import Part, Sheet
from .run import Run

if TYPE_CHECKING:
    from .comparison import Comparison, Line

WORDS = {"q": "position", "e": "error", "tau": "torque", "rho": "model error"}
"""What the signals of `overview` are called …"""

WHOLES = {"weights_norm": "weights, |W|", "V": "Lyapunov function V"}
"""… and those of one number."""

OF_EFFECTS = (
    "q_measured", "dq_measured", "tau_commanded", "q_motor", "tau_cogging", "sample_age",
)  # fmt: skip
"""Signals of sensors and drives, which are nearly those of the arm: drawn by name alone."""

CROWD = 24
"""Of more controllers than these only the best have their names in a picture."""


def overview(
    run: Run,
    *,
    joints: Joints = None,
    window: Window = None,
    width: float | None = None,
    style: Style = "light",
) -> Picture:
    """Draw a whole run, a block a signal, a panel a joint.

    From the top: position, error, torque with its two parts (if it was recorded); with a
    compensator also what the model leaves out (ρ) against its estimate (ρ̂), the size of the weights
    and the Lyapunov function V, and what the compensator adds: torques beside the others. What
    sensors and drives add is left to `signals`. Of a run that blew up the axes show the part that
    can be read, and the title says what happened. Arguments: see `steadyarm.plots`.
    """
    part = Part.of(run, joints, window)
    adaptive = run.weights_norm is not None and run.V is not None
    names = ["q", "e", *["tau"] * bool(len(run.tau)), *["rho"] * adaptive]
    own = [name for name in _own(run) if name not in _own_torques(run)]
    plan = [
        *[len(part.joints)] * len(names), *[len(WHOLES)] * adaptive,
        *(_panels(part, name) for name in own),
    ]  # fmt: skip
    sheet = Sheet(part.t, plan, width=width, style=style)
    for name in names:
        _block(sheet, part, name, WORDS[name], DRAWN[name])
    if adaptive:
        _wholes(sheet, part, WHOLES)
    for name in own:
        _block(sheet, part, name)
    return sheet.finish(run.status)


def signals(
    run: Run,
    names: Sequence[str],
    *,
    joints: Joints = None,
    window: Window = None,
    width: float | None = None,
    style: Style = "light",
) -> Picture:
    """Draw signals of a run one below the other, by their names in `Run.channels`.

    A signal of several joints has a panel a joint. Raises ValueError for one that the run has not.
    Arguments: see `steadyarm.plots`.
    """
    unknown = [name for name in names if name not in run.channels]
    if unknown or not names:
        got = repr(unknown[0]) if unknown else "none"
        raise ValueError(f"names: got {got}, wants some of {', '.join(run.channels)}")
    part = Part.of(run, joints, window)
    sheet = Sheet(part.t, [_panels(part, name) for name in names], width=width, style=style)
    for name in names:
        _block(sheet, part, name)
    return sheet.finish(run.status)


def paper_figure(
    run: Run,
    title: str,
    *,
    joints: Joints = None,
    window: Window = None,
    width: float | None = None,
    style: Style = "light",
) -> Picture:
    """Draw a run as the paper does: joints side by side; desired dotted, actual solid.

    Arguments: see `steadyarm.plots`.
    """
    part = Part.of(run, joints, window)
    sheet = Sheet(part.t, [len(part.joints)], width=width, style=style)
    _block(sheet, part, "q", WORDS["q"], _position)
    return sheet.finish(run.status, title)


def errors(
    runs: Mapping[str, Run],
    *,
    joints: Joints = None,
    window: Window = None,
    width: float | None = None,
    style: Style = "light",
) -> Picture:
    """Compare the errors of several runs, joint by joint; the legend gives the RMS of each.

    That is of the length of the error of the joints that are shown, in the window or else over the
    second half of each run, when the start is forgotten. Arguments: see `steadyarm.plots`.
    """
    parts = _parts(runs, joints, window)
    longest = max(parts.values(), key=lambda part: float(part.t[-1]))
    sheet = Sheet(longest.t, [len(longest.joints)], width=width, style=style)
    panels = sheet.block([WORDS["e"]], [f"m{it}" for it in longest.lengths], longest.titles)
    for index, (name, part) in enumerate(parts.items()):
        colour, line = sheet.look.cycle[index % len(sheet.look.cycle)]
        style_of = {"color": colour, "linestyle": line}
        label = literal(f"{name}: {_late_rms(part, window)}")
        for axes, joint in zip(panels, part.joints, strict=True):
            values = 1e3 * part.of_joint("e", joint)
            sheet.line(axes, part.t, values, wild=part.wild, label=label, **style_of)
    sheet.share(panels, about_zero=True)
    return sheet.finish()


def pareto(
    comparison: Comparison, *, width: float | None = None, style: Style = "light"
) -> Picture:
    """Draw the steady error of controllers against their torque variation, both logarithmic.

    A line joins those that no other beats in both. They have their names, and of up to 24 the
    others too, as far as there is room. Controllers without both figures are left out. ``width``
    and ``style``: see `steadyarm.plots`. Raises ValueError for rows of several scenarios.
    """
    lines = [line for line in comparison.table() if has_both(line)]
    scenarios = list(dict.fromkeys(line.scenario for line in lines))
    if len(scenarios) != 1:
        got = f"the scenarios {', '.join(map(repr, scenarios))}" if lines else "none"
        raise ValueError(f"comparison: got {got}, wants rows with both figures of one scenario")
    picture = Picture(width, style=style)
    picture.set_figheight(0.62 * picture.wide)
    axes, look = picture.add_subplot(), picture.look
    named = {line.controller: _place(line) for line in lines}
    best = {
        line.controller: _place(line)
        for line in lines
        if not any(beats(other, line) for other in lines)
    }
    axes.loglog(*zip(*named.values(), strict=True), "o", markersize=4, color=look.gray, mfc="none")
    axes.plot(
        *zip(*sorted(best.values()), strict=True), color=look.blue, marker="o", markersize=5,
        linestyle=DASHED, linewidth=0.8,
    )  # fmt: skip
    picture.frame(axes)
    x, y = zip(*named.values(), strict=True)
    for axis, limit, values in ((axes.xaxis, axes.set_xlim, x), (axes.yaxis, axes.set_ylim, y)):
        scale = Axis(values, 0.0, 1.0)
        axis.set_major_locator(FixedLocator(scale.ticks()))
        axis.set_major_formatter(FuncFormatter(lambda value, _: brief(value)))
        axis.set_minor_locator(NullLocator())
        limit(10.0**scale.low, 10.0**scale.high)
    axes.set_xlabel(f"torque variation [{EFFORT.shown}]")
    axes.set_ylabel(f"{ERROR.head} of the error [{ERROR.shown}]")
    _write_names(picture, axes, named, [*best, *named] if len(named) <= CROWD else best)
    return picture


def approximation(
    rows: Sequence[tuple[int, float]], *, width: float | None = None, style: Style = "light"
) -> Picture:
    """Draw the largest error of fuzzy fits against their number of rules, both logarithmic.

    ``rows`` holds (rules, sup |g - f|). The universal approximation statement (5) says that the
    curve comes below any ε. ``width`` and ``style``: see `steadyarm.plots`.
    """
    if not rows:
        raise ValueError("rows: got none, wants at least one")
    rules, error = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
    picture = Picture(width, style=style)
    picture.set_figheight(0.6 * picture.wide)
    axes = picture.add_subplot()
    axes.loglog(rules, error, color=picture.look.blue, linewidth=1.2, marker="o", markersize=4)
    picture.frame(axes)
    axes.set_xticks(rules, labels=[str(count) for count in rules])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlabel("number of rules [1]")
    axes.set_ylabel("largest error, sup |g − f| [unit of g]")
    picture.head("A fuzzy system comes as close as you like, given enough rules")
    return picture


def _place(line: Line) -> tuple[float, float]:
    """Where a controller stands in the picture of `pareto`."""
    return value_of(line, EFFORT.name), value_of(line, ERROR.name) * ERROR.scale


def _write_names(
    picture: Picture,
    axes: Axes,
    points: Mapping[str, tuple[float, float]],
    named: Iterable[str],
) -> None:
    """Write names beside their points, where they meet no point and no other name."""
    picture.draw_without_rendering()
    inch = picture.dpi
    places = {name: axes.transData.transform(point) / inch for name, point in points.items()}
    taken = [(x - 0.04, y - 0.05, x + 0.04, y + 0.05) for x, y in places.values()]
    first, last = float(axes.bbox.x0) / inch, float(axes.bbox.x1) / inch
    for name in dict.fromkeys(named):
        (x, y), wide = places[name], 0.07 + LETTER * len(name)
        for side in (1, -1):
            start, end = sorted((x + 0.06 * side, x + wide * side))
            box = (start, y - 0.06, end, y + 0.06)
            if first < start and end < last and not any(meet(box, other) for other in taken):
                taken.append(box)
                axes.annotate(
                    literal(name), points[name], (6 * side, 0), textcoords="offset points",
                    fontsize=SMALL, color=picture.look.ink, va="center",
                    ha="left" if side > 0 else "right",
                )  # fmt: skip
                break


Draw = Callable[[Sheet, Part, Axes, int], None]
"""Draws what belongs to a joint into its panel."""


def _block(sheet: Sheet, part: Part, name: str, word: str = "", draw: Draw | None = None) -> None:
    """One signal: a panel a joint, or one alone."""
    if _panels(part, name) == 1 and np.ndim(getattr(part.run, name)) == 1:
        _wholes(sheet, part, {name: name})
        return
    unit = part.run.channels[name].unit
    units = [_of_errors(name) + in_length(unit, length) for length in part.lengths]
    force = name == "tau" and part.lengths[0] == "m"
    panels = sheet.block(["force" if word and force else word or name], units, part.titles)
    for axes, joint in zip(panels, part.joints, strict=True):
        if draw is None:
            _plain(sheet, part, axes, joint, name)
        else:
            draw(sheet, part, axes, joint)
    sheet.share(panels, about_zero=name not in ("q", "q_d"))


def _panels(part: Part, name: str) -> int:
    return 1 if np.ndim(getattr(part.run, name)) == 1 else len(part.joints)


def _wholes(sheet: Sheet, part: Part, words: Mapping[str, str]) -> None:
    """Signals of one number, side by side."""
    units = [part.run.channels[name].unit for name in words]
    panels = sheet.block(list(words.values()), units)
    for axes, name in zip(panels, words, strict=True):
        values = np.asarray(getattr(part.run, name), dtype=float)[part.rows]
        sheet.line(axes, part.t, values, wild=part.wild, color=sheet.look.purple)
        sheet.share([axes], about_zero=False)


def _plain(sheet: Sheet, part: Part, axes: Axes, joint: int, name: str) -> None:
    values = (1e3 if _of_errors(name) else 1.0) * part.of_joint(name, joint)
    sheet.line(axes, part.t, values, wild=part.wild, color=sheet.look.blue)


def _of_errors(name: str) -> str:
    """What errors are thousands of: they are in mrad, and mm."""
    return "m" if name == "e" else ""


def _position(sheet: Sheet, part: Part, axes: Axes, joint: int) -> None:
    look = sheet.look
    lines: dict[str, tuple[str, dict[str, Any]]] = {
        "q": ("actual", {"color": look.blue}),
        "q_d": ("desired", {"color": look.ink, "linestyle": DOTTED, "linewidth": 1.2}),
    }
    _lines(sheet, part, axes, joint, lines)


def _error(sheet: Sheet, part: Part, axes: Axes, joint: int) -> None:
    values = 1e3 * part.of_joint("e", joint)
    sheet.line(axes, part.t, values, wild=part.wild, color=sheet.look.orange)


def _torque(sheet: Sheet, part: Part, axes: Axes, joint: int) -> None:
    look = sheet.look
    parts = {name: name.removeprefix("tau_") for name in _own_torques(part.run)}
    if part.run.weights_norm is not None:
        parts = {
            "tau_model": "from the model",
            "tau_compensation": "from the compensator",
            **parts,
        }
    applied = {"color": look.ink, "linewidth": 1.5 if parts else 1.0}
    lines: dict[str, tuple[str, dict[str, Any]]] = {"tau": ("applied" if parts else "", applied)}
    fillings = zip((look.sky, look.green, look.orange), (DASHED, DASH_DOT, DOTTED), strict=True)
    for (name, label), (colour, line) in zip(parts.items(), cycle(fillings), strict=False):
        lines[name] = (label, {"color": colour, "linestyle": line})
    _lines(sheet, part, axes, joint, lines)


def _own(run: Run) -> list[str]:
    """Signals that the compensator adds."""
    return [channel.name for channel in run.own if channel.name not in OF_EFFECTS]


def _own_torques(run: Run) -> list[str]:
    """Those which are torques of the joints."""
    torques = [name for name in _own(run) if run.channels[name].unit == "N·m"]
    return [name for name in torques if run.channels[name].shape]


def _model_error(sheet: Sheet, part: Part, axes: Axes, joint: int) -> None:
    look = sheet.look
    estimate = {"color": look.green, "linestyle": DASH_DOT}
    lines: dict[str, tuple[str, dict[str, Any]]] = {
        "rho": ("ρ, left out by the model", {"color": look.pale, "linewidth": 2.2}),
        "rho_hat": ("ρ̂, its estimate", estimate),
    }
    _lines(sheet, part, axes, joint, lines)


def _lines(
    sheet: Sheet,
    part: Part,
    axes: Axes,
    joint: int,
    lines: Mapping[str, tuple[str, Mapping[str, Any]]],
) -> None:
    """Curves of one panel: signal to label and style."""
    for name, (label, style) in lines.items():
        values = part.of_joint(name, joint)
        sheet.line(axes, part.t, values, wild=part.wild, label=label, **style)


DRAWN: Mapping[str, Draw] = {
    "q": _position, "e": _error, "tau": _torque, "rho": _model_error,
}  # fmt: skip
"""How `overview` draws a signal."""


def _parts(runs: Mapping[str, Run], joints: Joints, window: Window) -> dict[str, Part]:
    """The parts of several runs, of the same joints."""
    if not runs:
        raise ValueError("runs: got none, wants at least one")
    first = next(iter(runs.values()))
    for name, run in runs.items():
        if run.joints != first.joints:
            raise ValueError(f"runs: got {name!r} of {run.joints} joints, wants {first.joints}")
    return {name: Part.of(run, joints, window) for name, run in runs.items()}


def _late_rms(part: Part, window: Window) -> str:
    """RMS over the second half or the window; why there is none, if the run did not finish."""
    status, t = part.run.status, part.t
    if status.kind == "unresolved":
        return status.kind
    if not status.finished:
        return f"{status.kind} at {status.t:.4g} s"
    late = np.ones(len(t), bool) if window is not None else t >= 0.5 * (t[0] + t[-1])
    squares: dict[str, float] = {}
    for joint, length in zip(part.joints, part.lengths, strict=True):
        mean = float(np.mean(part.of_joint("e", joint)[late] ** 2))
        squares[length] = squares.get(length, 0.0) + mean
    return ", ".join(f"{1e3 * square**0.5:.3g} m{it}" for it, square in squares.items())
