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
from results import write

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
    scene, rows, short = sa.Scenario.read("paper_sensors"), [], False
    for name in scene.controllers:
        seconds = median(time.process_time, lambda name=name: scene.simulate(name))
        rows.append((f"{name}: 40 s with sensors", seconds, MOST["law"]))
    for name in ("paper_sensors", "panda_payload"):
        seconds = median(time.perf_counter, lambda name=name: sa.compare(name, progress=False))
        rows.append((f"{name}: comparison", seconds, MOST[name]))
    for figure, seconds, most in rows:
        short |= seconds > most
        verdict = "holds" if seconds <= most else "falls short"
        print(f"{figure:45} {seconds:8.3f} s, wanted {most:g} s: {verdict}")
    kept = [(figure, 1e9 * seconds, None, None, None) for figure, seconds, _ in rows]
    print(f"see {write('rivals', kept)}")
    return int(short)


if __name__ == "__main__":
    sys.exit(main())
