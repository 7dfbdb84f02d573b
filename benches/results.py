"""Keep the figures of the benches, a table for each processor: ``benches/results/<processor>.csv``.

Usage: python benches/results.py (after cargo bench; takes the medians that criterion left)

A row is a figure of a program: our time [ns], and where there is a peer its time [ns] and the
ratios theirs : ours of the clock and of processor time. A program replaces its own rows alone.
"""

import csv
import json
import platform
import re
from pathlib import Path

HERE = Path(__file__).parent
CRITERION = HERE.parent / "target" / "criterion"
COLUMNS = ("program", "figure", "ours_ns", "theirs_ns", "clock_ratio", "cpu_ratio")


def processor():
    """Return the name of this processor in small letters and hyphens."""
    name = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        found = re.search(r"^model name\s*:\s*(.+)$", cpuinfo.read_text(), re.MULTILINE)
        name = found.group(1) if found else name
    return re.sub(r"[^a-z0-9]+", "-", re.sub(r"\(\w+\)", "", name.lower())).strip("-")


def write(program, rows, folder=HERE / "results"):
    """Replace a program's rows, (figure, ours, theirs, clock, cpu) each; return the file.

    Times in ns; theirs and the ratios may be None.
    """
    path = folder / f"{processor()}.csv"
    kept = []
    if path.exists():
        with path.open(newline="", encoding="utf-8") as file:
            kept = [row for row in list(csv.reader(file))[1:] if row[0] != program]
    new = [
        [program, figure, *("" if x is None else f"{x:.2f}" for x in numbers)]
        for figure, *numbers in rows
    ]
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *sorted(kept + new)])
    return path


def criterion():
    """Return {(group, benchmark): median [ns]} of what criterion measured last."""
    found = {}
    for path in sorted(CRITERION.glob("**/new/estimates.json")):
        names = json.loads(path.with_name("benchmark.json").read_text())
        median = json.loads(path.read_text())["median"]["point_estimate"]
        found[names["group_id"], names["function_id"] or names["value_str"]] = median
    return found


def main():
    rows = [
        (f"{group}: {name}", median, None, None, None)
        for (group, name), median in criterion().items()
    ]
    if not rows:
        raise SystemExit(f"{CRITERION}: no results; run cargo bench")
    print(f"see {write('criterion', rows)}")


if __name__ == "__main__":
    main()
