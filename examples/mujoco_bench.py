"""Which controller? Every one on robots in MuJoCo, with the sensors and the loop of a machine.

    python examples/mujoco_bench.py [--robot NAME …] [--case NAME …] [--only CONTROLLER …]
                                    [--full] [--seeds N] [--jobs N] [--out DIR] [--page DIR]

A robot carries a payload and rubs, and no controller knows of it. By default that is the Panda
under `Conditions()` with all controllers: 16-bit encoders, velocities by difference, torques one
sample late, 1 kHz. Two motions are tracked, a sine in every joint and point to point and back.
Then whatever learns is frozen, and goes on along the same motion and along the other one.

``--full`` runs the controllers of `CHOSEN` in all `CASES` on the Panda, and on the other robots
with rotors known, nowhere, and unstated. With ``--out`` the tables are written as Markdown and
JSON, with two pictures. ``--page`` runs what the page "Which controller?" of the manual shows, and
writes its tables and pictures. Needs ``pip install mujoco pin example-robot-data matplotlib``.
"""

import argparse
import json
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path

import mujoco_page as page
import mujoco_payload as example
import numpy as np
from mujoco_arms import ROBOTS, controllers, machine
from mujoco_machine import Conditions
from mujoco_report import errors, pareto, scene, tables

PERIOD, PERIODS = example.PERIOD, example.PERIODS

MOTIONS = {"sine": example.sine, "point to point": example.point_to_point}

CASES = {
    "base": Conditions(),
    "ideal": Conditions(encoder_bits=None, delay=0),
    "jitter": Conditions(jitter=0.2),
    "drop": Conditions(drop=0.02),
    "gain": Conditions(gain=0.1),
    "noise": Conditions(noise=1e-4),
    "12 bits": Conditions(encoder_bits=12),
    "19 bits": Conditions(encoder_bits=19),
    "250 Hz": Conditions(rate=250.0),
    "4 kHz": Conditions(rate=4000.0),
    "push": Conditions(push=1.0),
    "pick-up": Conditions(pick_up=PERIOD * PERIODS / 2),
    "offset": Conditions(offset=0.05),
    "lag 2 ms": Conditions(lag=0.002),
    "lag 5 ms": Conditions(lag=0.005),
    "gears": Conditions(twist=0.01, rotors="matched"),
    "gears, light rotors": Conditions(twist=0.01, rotors="known"),
    "rotors": Conditions(rotors="known"),
    "no rotors": Conditions(rotors="none"),
    "unstated": Conditions(rotors="unstated"),
}

CHOSEN = [
    "recommended",
    "computed_torque",
    "example_fuzzy",
    "momentum_observer",
    "momentum_observer_fast",
    "pid",
    "slotine_li",
    "super_twisting",
]
"""Controllers of the full bench."""

LOW = 2e-3
"""The error that a controller comes below after the start, or after the pick-up [rad]."""


@dataclass(frozen=True)
class Job:
    """One run."""

    robot: str
    case: str
    motion: str
    controller: str
    seed: int = 0


@dataclass
class Row:
    """What a run gave. Errors are of the links, torques as commanded."""

    job: Job
    note: str = ""
    """Why there is no run, or why it ended early."""
    joints: list[float] = field(default_factory=list)
    """RMS of every joint over the last period [rad]."""
    rms: float | None = None
    """RMS of |e| over the last period [rad]; |e| is the norm over the joints."""
    worst: float | None = None
    """Largest |e| of the last period, or since the pick-up [rad]."""
    variation: float | None = None
    """Torque variation of the second half: sum over the joints of |Δτ|, by time [N·m/s]."""
    peak: float | None = None
    """Largest torque of the run [N·m]."""
    low_after: float | None = None
    """Time from the start, or from the pick-up, until |e| stays below `LOW` [s]."""
    frozen: float | None = None
    """RMS of |e| over the period after learning stopped [rad]."""
    other: float | None = None
    """And along the other motion, after one period of it [rad]."""
    curve: list[tuple[float, float]] = field(default_factory=list)
    """Time [s] and largest error of any joint [rad], of every tenth of a second."""


def run(job):
    """Run a controller; return its row."""
    robot, conditions = ROBOTS[job.robot], CASES[job.case]
    arm, effort, made = machine(robot, conditions, job.seed)
    middle = np.array(robot.middle)
    motions = {name: motion(middle) for name, motion in MOTIONS.items()}
    own = motions.pop(job.motion)
    (other,) = motions.values()
    row = Row(job)
    try:
        tracker = controllers(robot, arm, effort, conditions, own)[job.controller]()
    except ValueError as error:
        row.note = f"refused: {error}"
        return row
    record = made.run(tracker, own, PERIOD * PERIODS)
    measure(row, record, conditions.pick_up)
    if not record.note and getattr(tracker, "learns", False):
        tracker.freeze()
        row.frozen = total(made.run(tracker, own, PERIOD))
        tracker.start_hand_over()
        row.other = total(made.run(tracker, other, 2 * PERIOD))
    return row


def last(record):
    """Return the errors of the last period."""
    return record.e[record.t > record.t[-1] - PERIOD]


def total(record):
    """Return the RMS of |e| over the last period; None if the run did not last."""
    return None if record.note else float(np.linalg.norm(rms(last(record))))


def rms(e):
    """Return the RMS of every joint."""
    return np.sqrt(np.mean(e**2, axis=0))


def measure(row, record, event):
    """Put the figures of a run into its row; ``event`` is the time of the pick-up [s]."""
    row.note, row.curve = record.note, curve(record)
    row.peak = float(np.abs(record.tau).max())
    if record.note:
        return
    size, since, end = np.linalg.norm(record.e, axis=1), record.t - event, record.t[-1]
    row.joints = rms(last(record)).tolist()
    row.rms = total(record)
    row.worst = float(size[record.t > (end - PERIOD if event == 0.0 else event)].max())
    late = record.tau[record.t > end / 2]
    row.variation = float(np.abs(np.diff(late, axis=0)).sum() / (end / 2))
    high = max(since[size > LOW], default=0.0)
    row.low_after = None if high > since[-1] - 0.1 else max(float(high), 0.0)


def curve(record):
    """Return the largest error of any joint of every tenth of a second."""
    tenth = np.floor(record.t / 0.1 + 1e-6).astype(int)
    worst = np.abs(record.e).max(axis=1)
    largest = [worst[tenth == k].max() for k in np.unique(tenth)]
    return [(round(0.1 * k, 1), float(f"{e:.4g}")) for k, e in enumerate(largest)]


def jobs(options):
    """Return the runs that are asked for."""
    panda, base = ROBOTS["panda"], CASES["base"]
    arm, effort, _ = machine(panda, base)
    known = list(controllers(panda, arm, effort, base, example.sine(np.array(panda.middle))))
    wanted = options.only or (CHOSEN if options.full else known)
    if unknown := set(wanted) - set(known):
        raise SystemExit(f"--only {', '.join(sorted(unknown))}: wants some of {', '.join(known)}")
    if options.page:
        return [
            Job(robot, case, motion, name, 0)
            for robot, case, names in page.wanted(CASES, ROBOTS)
            for name in names or known
            for motion in MOTIONS
        ]
    pairs = [(robot, case) for robot in options.robot for case in options.case]
    if options.full:
        others = [robot for robot in ROBOTS if robot != "panda"]
        pairs = [("panda", case) for case in CASES]
        pairs += [(robot, case) for robot in others for case in ("rotors", "no rotors", "unstated")]
    return [
        Job(robot, case, motion, name, seed)
        for robot, case in pairs
        for name in wanted
        for motion in MOTIONS
        for seed in range(options.seeds)
    ]


def brief(row):
    """Return a line that says how a run ended."""
    job = row.job
    told = row.note or f"{1e3 * row.rms:.3g} mrad"
    return f"{job.robot}, {job.case}, {job.motion}, {job.controller}: {told}"


def main():
    """Run what is asked for, print the tables, and write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", nargs="+", choices=ROBOTS, default=["panda"])
    parser.add_argument("--case", nargs="+", choices=CASES, default=["base"])
    parser.add_argument("--only", nargs="+", metavar="CONTROLLER", help="(all)")
    parser.add_argument("--full", action="store_true", help="all robots and cases")
    parser.add_argument("--seeds", type=int, default=1, help="runs of everything (1)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at the same time")
    parser.add_argument("--out", type=Path, help="folder of the tables and pictures")
    parser.add_argument("--page", type=Path, help="folder of the manual's tables and pictures")
    options = parser.parse_args()
    rows, todo = [], jobs(options)
    with ProcessPoolExecutor(options.jobs) as pool:
        for row in pool.map(run, todo):
            rows.append(row)
            print(f"{len(rows)} of {len(todo)}: {brief(row)}", file=sys.stderr)
    if options.page:
        page.write(rows, options.page)
        return
    text = tables(rows)
    print(text)
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / "controllers.md").write_text(text + "\n", encoding="utf-8")
        said = ",\n".join(json.dumps(asdict(row)) for row in rows)
        (options.out / "controllers.json").write_text(f"[\n{said}\n]\n", encoding="utf-8")
        first = [row for row in rows if scene(row) == scene(rows[0])]
        errors(first, options.out / "controllers_errors.png")
        pareto(first, options.out / "controllers_pareto.png")


if __name__ == "__main__":
    main()
