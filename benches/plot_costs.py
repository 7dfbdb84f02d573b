"""Draw the cost of the dynamics against the number of joints, and that of the kernel form.

Usage: cargo bench --bench dynamics --bench kernel; python benches/plot_costs.py [--out costs.png]
"""

import argparse
from pathlib import Path

from matplotlib.figure import Figure
from results import CRITERION, criterion


def groups():
    """Return {group: {number: median [ns]}} of every benchmark that begins with a number."""
    found = {}
    for (group, number), median in criterion().items():
        if number.isdigit():
            found.setdefault(group, {})[int(number)] = median
    return {group: dict(sorted(rows.items())) for group, rows in sorted(found.items())}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("costs.png"))
    out = parser.parse_args().out
    found = {group: rows for group, rows in groups().items() if len(rows) > 2}
    if not found:
        raise SystemExit(
            f"{CRITERION}: no results; run cargo bench --bench dynamics --bench kernel"
        )
    joints = {group: rows for group, rows in found.items() if max(rows) <= 8}
    sizes = {group: rows for group, rows in found.items() if max(rows) > 8}
    figure = Figure(figsize=(11, 4.8), dpi=130, layout="constrained")
    panels = figure.subplots(1, 2)
    for axes, curves, name in zip(
        panels, (joints, sizes), ("joints", "states in the dictionary"), strict=True
    ):
        for group, rows in curves.items():
            axes.loglog(rows.keys(), rows.values(), marker="o", markersize=4, label=group)
        axes.set(xlabel=f"number of {name}", ylabel="time of a call [ns]")
        axes.grid(which="both", color="#E6E6E6")
        if curves:
            axes.set_xticks(sorted(set().union(*curves.values())), minor=False)
            axes.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
            axes.xaxis.set_minor_formatter(lambda *_: "")
            below = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14), "ncols": 2}
            axes.legend(frameon=False, fontsize=9, **below)
    figure.savefig(out)
    print(f"see {out}")


if __name__ == "__main__":
    main()
