"""How far runs of 1 ms are from the truth where joints have dry friction: 480 runs of ten arms.

Usage: python benches/friction_accuracy.py [--arms NAME ...] [--oracle]

Ten arms with 1, 3 and 10 % of each joint's largest torque as dry friction, with and without
5 N·m·s/rad of damping; sines, or a held set-point; a controller in continuous time, or sampled
every millisecond; one that knows the friction, or does not: ``tests/python/friction_scenes.py``.

The oracle of every run is the same run with steps of 50 µs; those of 100 µs say how far it can be
believed (`gap`). Two continuous runs of each arm are compared with SciPy's Radau too, which shares
nothing with it but the dynamics. The Lite 6 runs under error control besides ("dp54").

Prints a table and the worst figures, and writes ``benches/results/friction_accuracy.csv``.
``--oracle`` writes the positions that ``tests/python/test_friction.py`` compares with, and no more.
"""

import argparse
import csv
import os
import re
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests" / "python"))

import friction_scenes as scenes  # noqa: E402
from friction_scenes import Scene  # noqa: E402

RESULTS = HERE / "results" / "friction_accuracy.csv"
WANTED = 5e-4
"""Positions are to be right to this [rad]."""
AGREED = 1e-5
"""Steps of 50 and 100 µs are to agree to this [rad]."""
WANTED_SECONDS = 0.1
"""Processor time of 3 s of the Lite 6 with "dp54"."""

SUM = re.compile(r"estimated (\S+) rad in sum")
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()

BY_RADAU = [
    Scene(name, share, damping, motion, "continuous", knows)
    for number, name in enumerate(scenes.ARMS)
    for share, damping, motion, knows in (
        (0.10, 0.0, "sines", False),
        ((0.01, 5.0, "sines", False), (0.03, 0.0, "hold", False), (0.10, 5.0, "sines", True))[
            number % 3
        ],
    )
]


def judged(scene, **options):
    """Return the row of a run: how it ended, and how far from its oracle."""
    fine, coarse = scene.run(5e-5), scene.run(1e-4)
    run = scene.run(**options)
    found = SUM.search(run.status.reason)
    return {
        **vars(scene),
        "method": options.get("method", "rk4"),
        "status": run.status.kind,
        "error": distance(run.q, fine.q),
        "gap": distance(coarse.q, fine.q),
        "oracle_status": fine.status.kind,
        "estimated_sum": float(found[1]) if found else None,
        "reason": run.status.reason,
        "radau": None,
        "seconds": shortest(lambda: scene.run(**options)) if options else None,
    }


def shortest(work, times=5):
    """Return the least processor time that this took [s]."""
    seconds = []
    for _ in range(times):
        begun = time.thread_time()
        work()
        seconds.append(time.thread_time() - begun)
    return min(seconds)


def distance(q, oracle):
    """Return max |q - oracle| [rad] over a run; infinite if either ended early."""
    return float(np.abs(q - oracle).max()) if len(q) == len(oracle) else float("inf")


def by_radau(scene):
    """Return how far a run is from SciPy's Radau [rad], and how far that is from the oracle."""
    run, fine = scene.run(), scene.run(5e-5)
    truth = scenes.radau(scene, run.t)
    return distance(run.q, truth), distance(fine.q, truth)


def table(rows):
    """Print the worst runs of each arm, controller and loop."""
    kinds = [(control, knows) for control in scenes.PERIODS for knows in (False, True)]
    heads = [f"{control}{', knows' if knows else ''}" for control, knows in kinds]
    print(
        f"worst |q - oracle| [rad] (gap of the oracle){'':4}" + "".join(f"{h:>26}" for h in heads)
    )
    for name in dict.fromkeys(row["arm"] for row in rows):
        for share in scenes.SHARES:
            cells = []
            for control, knows in kinds:
                wanted = (name, share, control, knows)
                of = [r for r in rows if wanted == tuple(r[k] for k in KEYS)]
                doubts = sum(r["status"] != "finished" for r in of)
                worst, gap = (max(r[key] for r in of) for key in ("error", "gap"))
                cells.append(f"{f'{doubts} told  ' if doubts else ''}{worst:.1e} ({gap:.0e})")
            print(
                f"{name:12}{100 * share:4g} % of effort{'':19}" + "".join(f"{c:>26}" for c in cells)
            )


KEYS = ("arm", "share", "control", "knows")


def verdict(rows, title):
    """Print what these runs come to."""
    worst = max(rows, key=lambda row: row["error"])
    missed = [row for row in rows if row["error"] > WANTED]
    told = [row for row in rows if row["status"] == "unresolved"]
    false = [row for row in told if row["error"] <= WANTED]
    silent = [row for row in missed if row["status"] == "finished"]
    apart = sum(row["gap"] > AGREED for row in rows)
    sums = [row["estimated_sum"] for row in false if row["estimated_sum"] is not None]
    print(
        f"{title}: {len(rows)} runs, worst {worst['error']:.2e} rad "
        f"({name_of(worst)}), {len(missed)} beyond {WANTED:g}; "
        f"{sum(row['status'] == 'diverged' for row in rows)} diverged; unresolved {len(told)}, "
        f"of them {len(false)} within {WANTED:g} (largest estimate {max(sums, default=0):.1e}); "
        f"finished and beyond: {len(silent)}; oracle apart by more than {AGREED:g} in {apart}, "
        f"at most {max(row['gap'] for row in rows):.1e}"
    )
    for row in missed:
        print(f"  {row['error']:.2e} (oracle ±{row['gap']:.0e}, {row['status']}): {name_of(row)}")


def name_of(row):
    return str(Scene(*(row[name] for name in Scene.__dataclass_fields__)))


def write(rows):
    """Write the rows as CSV."""
    with RESULTS.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            short = {k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()}
            writer.writerow(short)


def measure(names):
    """Run everything; return the rows."""
    todo = [scene for scene in scenes.scenes() if scene.arm in names]
    exact = [scene for scene in BY_RADAU if scene.arm in names]
    # Radau holds the interpreter's lock: it has processes of its own, before there are threads.
    with ProcessPoolExecutor(CORES) as pool:
        truths = dict(zip(exact, pool.map(by_radau, exact), strict=True))
    with ThreadPoolExecutor(CORES) as pool:
        rows = list(pool.map(judged, todo))
    for scene, row in zip(todo, rows, strict=True):
        row["radau"] = truths.get(scene, (None,))[0]
    table(rows)
    clean = [row for row in rows if not (row["knows"] and row["control"] == "sampled")]
    noisy = [row for row in rows if row["knows"] and row["control"] == "sampled"]
    print(f"against Radau (rtol 1e-9), {len(truths)} continuous runs: ours at 1 ms, at 50 µs")
    for scene, (ours, fine) in truths.items():
        print(f"  {ours:.2e} {fine:.2e}  {scene}")
    verdict(noisy, "sampled, with friction reckoned from the sampled velocity")
    return rows, clean, truths


def under_error_control():
    """Return the rows of the Lite 6 with 10 % friction under error control."""
    todo = [
        Scene("lite6", 0.10, damping, "sines", "continuous", False) for damping in scenes.DAMPINGS
    ]
    rows = [judged(scene, method="dp54") for scene in todo]
    for row in rows:
        print(
            f"dp54: {row['seconds']:.3f} s of processor time (wanted {WANTED_SECONDS}), error "
            f"{row['error']:.1e} rad, {row['status']}: {name_of(row)}"
        )
    return rows


def main():
    parser = argparse.ArgumentParser(description="Accuracy of friction at 1 ms.")
    parser.add_argument("--arms", nargs="+", choices=scenes.ARMS, default=list(scenes.ARMS))
    parser.add_argument("--oracle", action="store_true", help="write the oracle of the tests only")
    arguments = parser.parse_args()
    if arguments.oracle:
        with ProcessPoolExecutor(CORES) as pool:
            scenes.write_oracle(list(pool.map(scenes.oracle, scenes.TESTED)))
        return
    begun = time.perf_counter()
    rows, clean, truths = measure(arguments.arms)
    adaptive = under_error_control()
    if arguments.arms == list(scenes.ARMS):
        RESULTS.parent.mkdir(exist_ok=True)
        write(rows + adaptive)
    print(f"{time.perf_counter() - begun:.0f} s on {CORES} cores")
    ours = max((ours for ours, _ in truths.values()), default=0.0)
    verdict(clean, f"worst against Radau {ours:.2e} rad; all others")


if __name__ == "__main__":
    main()
