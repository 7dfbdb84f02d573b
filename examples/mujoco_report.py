"""Tables and pictures of mujoco_bench.py."""

from itertools import groupby
from statistics import median

import numpy as np

HEADS = (
    "controller",
    "RMS of abs(e) [mrad]",
    "largest [mrad]",
    "joint with the largest RMS [mrad]",
    "torque variation [N·m/s]",
    "largest torque [N·m]",
    "frozen [mrad]",
    "frozen, the other motion [mrad]",
    "below 2 mrad after [s]",
)

COLOURS = {
    "recommended": "#D55E00",
    "computed_torque": "#000000",
    "example_fuzzy": "#0072B2",
    "momentum_observer_fast": "#009E73",
    "super_twisting": "#E69F00",
    "slotine_li": "#CC79A7",
    "pid": "#56B4E9",
}
"""Of the controllers that the picture of errors names; all others are grey."""


def scene(row):
    """Return robot and case of a row."""
    return row.job.robot, row.job.case


def tables(rows):
    """Return a table in Markdown for every robot and case; sine / point to point in each cell."""
    parts = []
    for (robot, case), group in groupby(rows, scene):
        group = list(group)
        lines = sorted(table_lines(group), key=lambda line: line[0])
        body = "\n".join(f"| {' | '.join(cells)} |" for _, cells in lines)
        head = f"| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}"
        parts.append(f"## {robot}, {case}: sine / point to point\n\n{head}\n{body}")
        notes = dict.fromkeys(
            f"- {name(row)}, {row.job.motion}: {row.note}" for row in group if row.note
        )
        parts += ["\n".join(notes)] if notes else []
    return "\n\n".join(parts)


def table_lines(rows):
    """Yield how large its error is and the cells of every controller."""
    by_controller = {}
    for row in rows:
        by_controller.setdefault(name(row), {}).setdefault(row.job.motion, []).append(row)
    for controller, motions in by_controller.items():
        errors = [value(runs, "rms") for runs in motions.values()]
        order = max(float("inf") if error is None else error for error in errors)
        cells = [cell(motions, figure, scale) for figure, scale in FIGURES]
        yield order, [controller, *cells]


FIGURES = (
    ("rms", 1e3),
    ("worst", 1e3),
    ("joint", 1e3),
    ("variation", 1.0),
    ("peak", 1.0),
    ("frozen", 1e3),
    ("other", 1e3),
    ("low_after", 1.0),
)
"""Attributes of a row, and what they are shown in."""


def cell(motions, figure, scale):
    """Return the figure of both motions; nothing where no run has one."""
    shown = []
    for runs in motions.values():
        found = value(runs, figure)
        text = "–" if found is None else brief(scale * found)
        if figure == "joint" and found is not None:
            text = f"{worst_joint(runs[0])}: {text}"
        if figure == "rms" and len(runs) > 1 and found is not None:
            text += f" (≤ {brief(scale * max(run.rms for run in runs))})"
        shown.append(text)
    return "" if set(shown) == {"–"} else " / ".join(shown)


def brief(number):
    """Return a number to three digits, without an exponent."""
    return f"{float(f'{number:.3g}'):g}"


def value(runs, figure):
    """Return the median over the seeds; None if a run has none."""
    found = [
        max(run.joints, default=None) if figure == "joint" else getattr(run, figure) for run in runs
    ]
    return None if None in found else median(found)


def worst_joint(row):
    """Return the number of the joint with the largest RMS, from 1."""
    return 1 + row.joints.index(max(row.joints))


def name(row):
    """Return the name of the controller in words."""
    return row.job.controller.replace("_", " ")


def canvas(columns, height):
    """Return a figure and its panels side by side."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.6 * columns, height), dpi=130, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, columns, sharex=True, sharey=True, squeeze=False)[0]
    for axes in panels:
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color="#E6E6E6", linewidth=0.6)
        logarithmic(axes, "y")
    return figure, panels


def logarithmic(axes, which):
    """Make an axis logarithmic, with ticks at 1, 2 and 5."""
    from matplotlib.ticker import LogLocator, NullLocator

    axes.set(**{f"{which}scale": "log"})
    axis = getattr(axes, f"{which}axis")
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter("{x:g}")


def by_motion(rows):
    """Return the rows of every motion, of the first seed."""
    motions = {}
    for row in rows:
        if row.job.seed == 0:
            motions.setdefault(row.job.motion, []).append(row)
    return motions


def errors(rows, path):
    """Draw the error of the worst joint over time, a panel a motion."""
    motions = by_motion(rows)
    figure, panels = canvas(len(motions), 4.6)
    order = list(COLOURS)[::-1]
    for axes, (motion, runs) in zip(panels, motions.items(), strict=True):
        runs = [row for row in runs if row.curve]
        named = [row for controller in order for row in runs if row.job.controller == controller]
        for row in [row for row in runs if row not in named] + named:
            t, e = np.array(row.curve).T
            colour = COLOURS.get(row.job.controller)
            style = {"color": colour, "label": name(row)} if colour else {"color": "#D0D0D0"}
            axes.plot(t, 1e3 * e, linewidth=1.4 if colour else 0.8, **style)
        axes.set(title=motion, xlabel="time [s]", xlim=(0, None), ylim=(0.05, 1000))
    panels[0].set_ylabel("error of the worst joint [mrad]")
    lines, words = panels[0].get_legend_handles_labels()
    figure.legend(lines[::-1], words[::-1], frameon=False, ncols=7, loc="outside upper center")
    figure.savefig(path)


def pareto(rows, path):
    """Draw error against torque variation of all controllers, a panel a motion."""
    motions = by_motion(rows)
    figure, panels = canvas(len(motions), 6.4)
    for axes, (motion, runs) in zip(panels, motions.items(), strict=True):
        axes.set(title=motion, xlabel="torque variation [N·m/s]")
        logarithmic(axes, "x")
        axes.margins(x=0.2)
        for row in finished(runs):
            colour = COLOURS.get(row.job.controller, "#767676")
            axes.plot(row.variation, 1e3 * row.rms, "o", color=colour, markersize=5)
    panels[0].set_ylabel("RMS of |e| over the last period [mrad]")
    figure.draw_without_rendering()
    for axes, runs in zip(panels, motions.values(), strict=True):
        label(axes, finished(runs))
    figure.savefig(path)


def finished(rows):
    """Return the rows that have an error, the smallest first."""
    return sorted((row for row in rows if row.rms is not None), key=lambda row: row.rms)


LETTER, LINE = 8.4, 17.0
"""Width of a letter of a label, and height of a line [pixels]."""


def label(axes, rows):
    """Write the names beside their points, each at the first place that is free."""
    points = {name(row): (row.variation, 1e3 * row.rms) for row in rows}
    places = {word: axes.transData.transform(point) for word, point in points.items()}
    taken = [(x - 6, y - 6, x + 6, y + 6) for x, y in places.values()]
    for row in rows:
        word = name(row)
        (x, y), width = places[word], LETTER * len(word)
        choices = [(left, LINE * k) for k in (0, 1, -1, 2, -2, 3, -3) for left in (False, True)]
        for left, up in choices:
            start = x - 12 - width if left else x + 12
            box = (start, y + up - LINE / 2, start + width, y + up + LINE / 2)
            inside = axes.bbox.x0 <= box[0] and box[2] <= axes.bbox.x1
            if inside and not any(meet(box, other) for other in taken):
                break
        taken.append(box)
        axes.annotate(
            word,
            points[word],
            xytext=((start - x) * 72 / axes.figure.dpi, up * 72 / axes.figure.dpi),
            textcoords="offset points",
            va="center",
            fontsize=8,
            color=COLOURS.get(row.job.controller, "#606060"),
            arrowprops={"arrowstyle": "-", "color": "#B0B0B0", "linewidth": 0.6} if up else None,
        )


def meet(one, other):
    """Return whether two boxes overlap."""
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
