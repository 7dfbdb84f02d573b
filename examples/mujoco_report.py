"""Tables and pictures of mujoco_bench.py."""

from itertools import groupby
from statistics import median

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
        text = "–" if found is None else f"{scale * found:.3g}"
        if figure == "joint" and found is not None:
            text = f"{worst_joint(runs[0])}: {text}"
        if figure == "rms" and len(runs) > 1 and found is not None:
            text += f" (≤ {scale * max(run.rms for run in runs):.3g})"
        shown.append(text)
    return "" if set(shown) == {"–"} else " / ".join(shown)


def value(runs, figure):
    """Return the median over the seeds; None if a run has none."""
    found = [max(run.joints, default=None) if figure == "joint" else getattr(run, figure) for run in runs]
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
    panels = figure.subplots(1, columns, sharey=True, squeeze=False)[0]
    for axes in panels:
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color="#E6E6E6", which="both", linewidth=0.6)
        axes.set(yscale="log")
    return figure, panels


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
    for axes, (motion, runs) in zip(panels, motions.items(), strict=True):
        for row in sorted(runs, key=lambda row: row.job.controller in COLOURS):
            if not row.curve:
                continue
            t, e = zip(*row.curve, strict=True)
            colour = COLOURS.get(row.job.controller)
            axes.plot(
                t,
                [max(1e3 * x, 1e-3) for x in e],
                color=colour or "#C8C8C8",
                linewidth=1.4 if colour else 0.8,
                label=name(row) if colour else None,
            )
        axes.set(title=motion, xlabel="time [s]", xlim=(0, None), ylim=(0.05, 2000))
    panels[0].set_ylabel("error of the worst joint [mrad]")
    figure.legend(*panels[0].get_legend_handles_labels(), frameon=False, ncols=6, loc="outside upper center")
    figure.savefig(path)


def pareto(rows, path):
    """Draw error against torque variation of all controllers, a panel a motion."""
    motions = by_motion(rows)
    figure, panels = canvas(len(motions), 6.0)
    for axes, (motion, runs) in zip(panels, motions.items(), strict=True):
        runs = [row for row in runs if row.rms is not None]
        axes.set(title=motion, xscale="log", xlabel="torque variation [N·m/s]")
        for row in runs:
            colour = COLOURS.get(row.job.controller, "#767676")
            axes.plot(row.variation, 1e3 * row.rms, "o", color=colour, markersize=5)
            axes.annotate(
                name(row),
                (row.variation, 1e3 * row.rms),
                xytext=(6, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
                color=colour,
            )
    panels[0].set_ylabel("RMS of |e| over the last period [mrad]")
    figure.savefig(path)
