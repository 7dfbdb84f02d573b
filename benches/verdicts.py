"""Whether the verdicts of `design` are right: random designs, judged and then run.

Usage: python benches/verdicts.py [--designs N] [--first SEED] [--processes N] [--keep FILE]

Designs and runs are those of ``tests/python/verdict_scenes.py``, a seed each: arms of 1 to 7
joints, all bases, inputs and modifications, models that are off, delays, and control periods from
0.05 to 2 times the longest stable one. Prints the counts and writes a row a design to
``benches/results/verdicts.csv`` (``--keep``: another file). Exits 1 if a loop that is called sound
diverges, or more than 2 % of those refused as unstable run well.
"""

import argparse
import csv
import itertools
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests" / "python"))

import verdict_scenes as scenes  # noqa: E402

RESULTS = HERE / "results" / "verdicts.csv"
RUN_WELL = 0.02
"""Share of those refused as unstable that may run well."""


def row(seed):
    """The row of a design; None if it has no longest stable period."""
    outcome = scenes.judged(seed)
    return None if outcome is None else outcome.row()


def counted(rows):
    """Designs in each class: called what, and did what."""
    counts = {}
    for each in rows:
        did = "diverged" if each["diverged"] else "ran well" if each["well"] else "ran badly"
        counts[each["called"], did] = counts.get((each["called"], did), 0) + 1
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--designs", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    rows, seeds = [], itertools.count(arguments.first)
    with ProcessPoolExecutor(arguments.processes) as pool:
        while len(rows) < arguments.designs:
            batch = list(itertools.islice(seeds, 8 * arguments.processes))
            rows += [each for each in pool.map(row, batch) if each is not None]
            print(f"\r{len(rows)} of {arguments.designs}", end="", file=sys.stderr, flush=True)
    rows = rows[: arguments.designs]
    with arguments.keep.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    counts = counted(rows)
    kinds = ("ran well", "ran badly", "diverged")
    print(f"\n{'called':<24}" + "".join(f"{kind:>12}" for kind in kinds))
    for called in scenes.CALLED:
        print(f"{called:<24}" + "".join(f"{counts.get((called, kind), 0):12}" for kind in kinds))
    lost = sum(counts.get((called, "diverged"), 0) for called in scenes.SOUND)
    refused = [each for each in rows if each["called"] == "refused: unstable"]
    well = sum(each["well"] for each in refused)
    share = well / max(len(refused), 1)
    print(f"sound and diverged: {lost}; refused as unstable and well: {well}, {100 * share:.1f} %")
    refused = [each for each in rows if each["called"].startswith("refused")]
    refused = [each for each in refused if float(each["radius"]) >= 1.0]
    well = sum(each["well"] for each in refused)
    print(f"of all {len(refused)} refused with a radius >= 1, for whatever reason: {well} well")
    return int(lost > 0 or share > RUN_WELL)


if __name__ == "__main__":
    sys.exit(main())
