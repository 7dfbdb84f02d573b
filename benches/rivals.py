"""Time every law through real sensors, and the comparisons: ``benches/results/<processor>.csv``.

Usage: python benches/rivals.py

40 s of each law of `paper_sensors` at 1 kHz, processor time of the run alone (wanted: 0.1 s); the
whole comparison of all laws, clock time on the cores that there are (wanted on two: 1.5 s for
`paper_sensors`, 15 s for `panda_payload`), each the median of five. Ends with 1 where a figure
falls short.
"""

import statistics
import sys
import time

import steadyarm as sa
from claims import report, within

TURNS = 5
MOST = {"law": 0.1, "paper_sensors": 1.5, "panda_payload": 15.0}
"""Seconds at the most."""


def median(clock, work):
    """Median time of some turns [s]."""
    times = []
    for _ in range(TURNS):
        begun = clock()
        work()
        times.append(clock() - begun)
    return statistics.median(times)


def main():
    """Time them, keep the figures, and say which fall short."""
    scene, rows = sa.Scenario.read("paper_sensors"), []
    for name in scene.controllers:
        seconds = median(time.process_time, lambda name=name: scene.simulate(name))
        figure = f"{name}: 40 s with sensors"
        rows.append(within(figure, 1e9 * seconds, 1e9 * MOST["law"], of="cpu"))
    for name in ("paper_sensors", "panda_payload"):
        seconds = median(time.perf_counter, lambda name=name: sa.compare(name, progress=False))
        rows.append(within(f"{name}: comparison", 1e9 * seconds, 1e9 * MOST[name]))
    return report("rivals", rows)


if __name__ == "__main__":
    sys.exit(main())
