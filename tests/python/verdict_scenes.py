"""Random designs, judged and then run: for `test_verdicts` and ``benches/verdicts.py``.

A design is an arm of 1 to 7 joints with a nominal model that is right, up to 30 % off, or half as
heavy; a path of sines; gains; a compensator of any form, inputs and modifications, or none; a delay
of 0 to 2 samples; in some a velocity filter; and a control period drawn log-uniformly from 0.05 to
2 times the longest stable one that its report gives. The run is the sampled loop on the moving arm.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import steadyarm as sa

RANGE = (0.05, 2.0)
"""Control periods, over the longest stable one."""

FINE = 1.0 / 20.0
"""Control period of the run that others are held against, over the longest stable one."""

LAPS = 4
"""Laps of the path in a run; the last one counts. More, where growth by `GROWTH` takes longer."""

GROWTH = 1e5
MOST_SAMPLES = 40_000
STEP = 2e-3
"""Step of the plant at the most [s]."""

LOST = 1.0
"""A loop has diverged whose error passes `LOST` late in the run [rad] and is more than `WELL` times
what it is in fine steps, or passes `SEEN` [rad] and is more than `WORSE` times that."""
WORSE, SEEN = 10.0, 0.2

WELL, NEAR = 2.0, 0.01
"""A loop runs well with at most so many times the error in fine steps, plus so much [rad]."""


@dataclass
class Design:
    """A random design, before its control period is known."""

    seed: int
    tracker: sa.ComputedTorque
    plant: sa.Plant
    path: sa.Sines
    delay: int
    words: str

    def report(self, control_period: float) -> sa.DesignReport:
        return sa.design(self.tracker, control_period, self.delay, path=self.path, plant=self.plant)


def arm(rng: np.random.Generator, joints: int) -> sa.Serial:
    """A random chain whose links are rods, hanging or standing as it comes."""
    length = rng.uniform(0.2, 0.5, joints)
    mass = rng.uniform(1.0, 6.0, joints) * 0.75 ** np.arange(joints)
    moment = mass * length**2 / 12.0
    along = np.column_stack([0.1 * moment, moment, moment]) + 0.005
    return sa.Serial.from_dh(
        a=length,
        alpha=rng.choice([0.0, math.pi / 2, -math.pi / 2], joints),
        d=rng.uniform(-0.1, 0.1, joints),
        mass=mass,
        com=np.column_stack([-0.5 * length, np.zeros(joints), np.zeros(joints)]),
        inertia=along,
        viscous=rng.uniform(0.0, 0.5, joints),
        armature=rng.uniform(0.02, 0.3, joints),
    )


def path(rng: np.random.Generator, joints: int) -> sa.Sines:
    base = rng.uniform(0.5, 1.5)
    amplitude = rng.uniform(0.0, 0.4, (2, joints))
    phase = rng.uniform(0.0, 2.0 * math.pi, (2, joints))
    return sa.Sines(
        np.array([1.0, 2.0]) * base,
        amplitude * np.sin(phase),
        amplitude * np.cos(phase),
        rng.uniform(-1.5, 1.5, joints),
    )


def compensator(
    rng: np.random.Generator, joints: int, along: sa.Sines, period: float
) -> tuple[sa.FuzzyCompensator, str]:
    inputs = str(rng.choice(["error", "state", "reference", "trajectory"]))
    kernel = bool(rng.random() < 0.2)
    forms = ["shared", "concat", "per_joint"] + (["grid"] if joints == 1 else [])
    form = "grid" if kernel else str(rng.choice(forms))
    normalized = bool(rng.random() < 0.6)
    signals = {"error": 2, "state": 2, "reference": 2, "trajectory": 3}[inputs]
    rows = np.array([np.concatenate(along(t)) for t in np.linspace(0.0, period, 50)])
    reach = np.zeros((2, signals * joints))
    if inputs == "error":
        reach += np.array([[-0.5], [0.5]])
    else:
        seen = rows[:, : signals * joints]
        reach += np.array([seen.min(axis=0) - 0.1, seen.max(axis=0) + 0.1])
    sets = int(rng.integers(3, 6))
    centers = [list(np.linspace(low, high, sets)) for low, high in reach.T]
    width = [
        [float(rng.uniform(0.4, 1.2) * (high - low) / (sets - 1))] * sets for low, high in reach.T
    ]
    basis = sa.FuzzyBasis(form, centers, width, normalized, inputs, joints=joints)
    chosen: dict[str, Any] = {}
    for name, value in (
        ("leak_rate", 10.0 ** rng.uniform(-2.0, 1.0)),
        ("normalization", 10.0 ** rng.uniform(-1.0, 1.0)),
        ("dead_zone", 10.0 ** rng.uniform(-3.0, -1.0)),
        ("error_modification", 10.0 ** rng.uniform(-3.0, -1.0)),
        ("projection_radius", 10.0 ** rng.uniform(1.0, 3.0)),
    ):
        if rng.random() < 0.25:
            chosen[name] = float(value)
    if kernel:
        chosen |= {"dictionary": 64}
    gain = 10.0 ** rng.uniform(0.0, 4.0)
    q = 10.0 ** rng.uniform(-0.5, 0.5)
    words = f"{form}{' kernel' if kernel else ''} {'normalized' if normalized else 'raw'} {inputs}"
    words += "".join(f" {name}={value:.3g}" for name, value in chosen.items())
    return sa.FuzzyCompensator(basis, q=q, gain=gain, **chosen), f"{words} gain={gain:.3g}"


def design(seed: int, filtered: bool = False) -> Design:
    """The design of a seed; ``filtered``: with a velocity filter of its own."""
    rng = np.random.default_rng(seed)
    joints = int(rng.integers(1, 8))
    there = arm(rng, joints)
    believed, kind = there, str(rng.choice(["right", "off", "light"]))
    if kind == "off":
        believed = there.perturb(seed, mass=0.3, inertia=0.3)
    elif kind == "light":
        believed = there.with_parameters(0.5 * there.inertial_parameters())
    along = path(rng, joints)
    lap = _lap(along)
    omega = 10.0 ** rng.uniform(0.5, 1.3)
    kp, kv = omega**2, 2.0 * omega * rng.uniform(0.6, 1.5)
    words = f"{joints} joints, {kind} model, kp={kp:.3g} kv={kv:.3g}"
    chosen = None
    if rng.random() < 0.85:
        chosen, more = compensator(rng, joints, along, lap)
        words += f", {more}"
    delay = int(rng.choice([0, 0, 1, 2]))
    push = sa.Sines(1.3, rng.uniform(-1.0, 1.0, joints))
    try:
        tracker = sa.ComputedTorque(believed, kp, kv, chosen)
    except sa.NoStabilizingSolution:  # Q too large for these gains: take what they allow
        chosen = _admissible(chosen, believed, kp, kv)
        tracker = sa.ComputedTorque(believed, kp, kv, chosen)
    words = f"{words}, delay {delay}"
    if filtered:
        own = np.random.default_rng([seed, 2])
        cut_off = omega / (2.0 * math.pi) * 10.0 ** own.uniform(0.0, 1.2)
        tracker = tracker.__replace__(velocity_filter=cut_off)
        words += f", velocity_filter={cut_off:.3g}"
    return Design(seed, tracker, sa.Plant(there, push), along, delay, words)


def _admissible(given: Any, believed: sa.Serial, kp: float, kv: float) -> sa.FuzzyCompensator:
    changed = given
    for _ in range(60):
        changed = changed.__replace__(q=0.5 * np.asarray(changed.q))
        try:
            sa.ComputedTorque(believed, kp, kv, changed)
        except sa.NoStabilizingSolution:
            continue
        break
    return changed


def _lap(along: sa.Sines) -> float:
    return 2.0 * math.pi / float(np.min(along.__reduce__()[1][0]))


SOUND = ("sound", "sound, warned of")
CALLED = (*SOUND, "cannot tell", "refused: no margin", "refused: unstable")
"""What a design may be called."""


@dataclass
class Outcome:
    """What a design was called, and what it did."""

    design: Design
    report: sa.DesignReport
    longest: float
    control_period: float
    rms: float
    rms_fine: float
    late: float
    finished: bool

    @property
    def share(self) -> float | None:
        """The control period, over the longest stable one; None if there is none."""
        return self.control_period / self.longest if self.longest > 0.0 else None

    @property
    def diverged(self) -> bool:
        far = self.late > LOST and self.rms > WELL * self.rms_fine
        far |= self.late > SEEN and self.rms > WORSE * self.rms_fine
        return not self.finished or far

    @property
    def well(self) -> bool:
        return self.finished and self.rms <= WELL * self.rms_fine + NEAR

    @property
    def called(self) -> str:
        if self.report.verdict == "cannot tell from a linear model":
            return "cannot tell"
        if "it will be unstable" in " ".join(self.report.findings):
            return "refused: unstable"
        if not self.report.sound:
            return "refused: no margin"
        return "sound, warned of" if self.control_period > self.longest / 3.0 else "sound"

    def row(self) -> dict[str, Any]:
        """It as a row of a table."""
        return {
            "seed": self.design.seed,
            "design": self.design.words,
            "called": self.called,
            "control_period": f"{self.control_period:.6g}",
            "longest": f"{self.longest:.6g}",
            "radius": f"{self.report.sampled_radius.max():.9g}",
            "rms": f"{self.rms:.4g}",
            "rms_fine": f"{self.rms_fine:.4g}",
            "rms_predicted": f"{np.sqrt((self.report.rms**2).mean()):.4g}",
            "late": f"{self.late:.4g}",
            "diverged": int(self.diverged),
            "well": int(self.well),
        }


def judged(seed: int, filtered: bool = False) -> Outcome | None:
    """Judge a design and run it; None if its longest stable period is beyond 1 s, or below 10 µs.

    One that is stable at no period runs at 1 ms, and in fine steps of 0.2 ms.
    """
    chosen = design(seed, filtered)
    first = chosen.report(1e-3)
    longest = float(first.max_period.min())
    if longest == 0.0:
        (rms, late, finished), (rms_fine, _, _) = (run(chosen, h, 1.0) for h in (1e-3, 2e-4))
        return Outcome(chosen, first, 0.0, 1e-3, rms, rms_fine, late, finished)
    if not 1e-5 < longest < 1.0:
        return None
    rng = np.random.default_rng([seed, 1])
    h = min(longest * math.exp(rng.uniform(*np.log(RANGE))), 1.0)
    report = chosen.report(h)
    radius = float(report.sampled_radius.max())
    rms, late, finished = run(chosen, h, radius)
    rms_fine, _, _ = run(chosen, FINE * longest, 1.0)
    return Outcome(chosen, report, longest, h, rms, rms_fine, late, finished)


def run(chosen: Design, h: float, radius: float) -> tuple[float, float, bool]:
    """Run it; RMS and largest |e| over the last lap, and whether it reached its end."""
    lap = max(round(_lap(chosen.path) / h), 1)
    samples = LAPS * lap
    if radius > 1.0:
        samples = max(samples, math.ceil(math.log(GROWTH) / math.log(radius)))
    samples = max(min(samples, MOST_SAMPLES), min(2 * lap, 2 * MOST_SAMPLES))
    parts = math.ceil(h / STEP)
    q0, dq0, _ = chosen.path(0.0)
    q, dq = np.array(q0) + 0.02, np.array(dq0)
    if chosen.delay == 0:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            done = sa.simulate(
                chosen.plant, chosen.tracker, chosen.path, duration=samples * parts * (h / parts),
                dt=h / parts, control_period=h, q0=q, dq0=dq, record="motion", record_every=parts,
            )  # fmt: skip
        error = done.e[-lap:]
        finished = done.status.finished or done.status.kind == "unresolved"
    else:
        error, finished = _delayed(chosen, h, parts, samples, q, dq)
        error = error[-lap:]
    return float(np.sqrt((error**2).mean())), float(np.abs(error).max()), finished


def _delayed(
    chosen: Design, h: float, parts: int, samples: int, q: Any, dq: Any
) -> tuple[Any, bool]:
    """The loop with its torque some samples late, as one would write it."""
    tracker = sa.ComputedTorque(*chosen.tracker.__reduce__()[1])
    under_way = [np.asarray(chosen.tracker.arm.gravity(q))] * chosen.delay
    errors = []
    for k in range(samples):
        q_d, dq_d, ddq_d = chosen.path(k * h)
        errors.append(q - q_d)
        try:
            under_way.append(tracker.step(q, dq, q_d, dq_d, ddq_d, h))
        except ValueError:
            return np.array(errors), False
        tau = under_way.pop(0)
        try:
            for part in range(parts):
                q, dq = chosen.plant.step(q, dq, tau, k * h + part * h / parts, h / parts)
        except ValueError:  # it is not finite any more
            return np.array(errors), False
    return np.array(errors), True
