"""Ten arms with dry friction, and what they do: for `test_friction` and ``benches``.

A plant whose masses are up to 20 % off, with Coulomb friction in each joint of a share of its
largest torque; a controller that knows the friction, or does not; sines, or a held set-point.
"""

from __future__ import annotations

import csv
import functools
import importlib.metadata
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import steadyarm as sa

FILES = Path(__file__).parents[1] / "std" / "robot" / "files"
ROBOTS = "cmeel.prefix/share/example-robot-data/robots"

SHARES = (0.01, 0.03, 0.10)
DAMPINGS = (0.0, 5.0)
MOTIONS = ("sines", "hold")
PERIODS = {"continuous": None, "sampled": 1e-3}

DURATION = 3.0
SMOOTHING = 0.01
KP, KV = 400.0, 40.0
SEED = 10
AWAY = 0.02
"""How far from its set-point a held arm starts [rad]."""

UNKNOWN_EFFORT = 100.0
"""The largest torque of joints whose file states none (the Puma's) [N·m]."""


@dataclass(frozen=True)
class Source:
    """Where an arm comes from, and a pose with room around it [rad]."""

    pose: tuple[float, ...]
    path: str = ""
    base: str | None = None
    tip: str | None = None


ARMS = {
    "panda": Source((0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)),
    "ur5e": Source((0.0, -1.57, 1.57, -1.57, -1.57, 0.0)),
    "puma560": Source((0.0, 0.785, 3.14, 0.0, 0.785, 0.0)),
    "xarm7": Source(
        (0.0, -0.3, 0.0, 1.0, 0.0, 1.2, 0.0), "xarm_description/urdf/xarm7.urdf", tip="link7"
    ),
    "z1": Source((0.0, 1.4, -1.3, 0.0, 0.0, 0.0), "z1_description/urdf/z1.urdf", tip="link06"),
    "jaco": Source(
        (0.0, 2.9, 1.3, 4.2, 1.4, 0.0),
        "kinova_description/robots/kinova.urdf",
        "j2s6s200_link_base",
        "j2s6s200_end_effector",
    ),
    "ur10": Source(
        (0.0, -1.57, 1.57, -1.57, -1.57, 0.0),
        "ur_description/urdf/ur10_robot.urdf",
        "base_link",
        "tool0",
    ),
    "panda_hand": Source(
        (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785),
        "panda_description/urdf/panda.urdf",
        "panda_link0",
        "panda_link8",
    ),
    "iiwa14": Source((0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0), "iiwa14.urdf"),
    "lite6": Source((0.0, 0.2, 1.0, 0.0, 0.8, 0.0), "lite6.urdf"),
}
"""Shipped arms, those of ``example-robot-data``, and two vendors' numbers in ``tests``."""


@functools.cache
def arm(name: str) -> sa.Serial:
    """The arm as its file states it."""
    source = ARMS[name]
    if not source.path:
        return sa.Serial.shipped(name)
    if "/" not in source.path:
        return sa.Serial.from_urdf(FILES / source.path)
    package = importlib.metadata.distribution("example-robot-data")
    path = package.locate_file(f"{ROBOTS}/{source.path}")
    return sa.Serial.from_urdf(str(path), base=source.base, tip=source.tip, unphysical="note")


@dataclass(frozen=True)
class Scene:
    """One of the runs; ``share`` of the largest torque is dry friction."""

    arm: str
    share: float
    damping: float
    motion: str
    control: str
    knows: bool

    def __str__(self) -> str:
        knows = "knows" if self.knows else "does not know"
        friction = f"{100 * self.share:g} % of effort, {self.damping:g} N·m·s/rad"
        return f"{self.arm}, {friction}, {self.motion}, {self.control}, {knows}"

    def friction(self) -> dict[str, Any]:
        """What `Serial.with_friction` is given."""
        effort = arm(self.arm).limits["effort"]
        effort = np.where(np.isfinite(effort), effort, UNKNOWN_EFFORT)
        coulomb = self.share * effort
        return {"viscous": self.damping, "coulomb": coulomb, "smoothing": SMOOTHING}

    def plant(self) -> sa.Plant:
        """The arm that is there."""
        there = arm(self.arm).perturb(seed=SEED, mass=0.2, friction=0.0)
        return sa.Plant(there.with_friction(**self.friction()))

    def nominal(self) -> sa.Serial:
        """What the controller believes."""
        believed = arm(self.arm)
        return (
            believed.with_friction(**self.friction()) if self.knows else believed.without_friction()
        )

    def reference(self) -> sa.Sines:
        """Each joint has its own frequency, 2 rad/s and more; a held set-point has none."""
        pose = np.array(ARMS[self.arm].pose)
        if self.motion == "hold":
            return sa.Sines(1.0, sin=0.0 * pose, offset=pose)
        frequency = 2.0 + 0.35 * np.arange(len(pose))
        return sa.Sines(frequency, sin=0.3 * np.eye(len(pose)), offset=pose)

    def start(self) -> np.ndarray:
        """Where it starts, at rest [rad]."""
        return np.array(ARMS[self.arm].pose) + (AWAY if self.motion == "hold" else 0.0)

    def run(self, dt: float = 1e-3, **options: Any) -> sa.Run:
        """The run, with a row a millisecond of the motion alone."""
        settings: dict[str, Any] = {
            "duration": DURATION,
            "control_period": PERIODS[self.control],
            "q0": self.start(),
            "record_every": round(1e-3 / dt),
            "record": "motion",
        }
        tracker = sa.ComputedTorque(self.nominal(), kp=KP, kv=KV)
        return sa.simulate(self.plant(), tracker, self.reference(), dt=dt, **settings | options)


def scenes() -> list[Scene]:
    """All of them, arm after arm."""
    return [
        Scene(name, share, damping, motion, control, knows)
        for name in ARMS
        for share in SHARES
        for damping in DAMPINGS
        for motion in MOTIONS
        for control in PERIODS
        for knows in (False, True)
    ]


def radau(scene: Scene, times: np.ndarray) -> np.ndarray:
    """The positions of a continuous run, by SciPy's Radau and the law in NumPy."""
    from scipy.integrate import solve_ivp

    there, believed, reference = scene.plant().arm, scene.nominal(), scene.reference()
    n = there.joints

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        q, dq = y[:n], y[n:]
        q_d, dq_d, ddq_d = reference(t)
        v = ddq_d - KV * (dq - dq_d) - KP * (q - q_d)
        tau = believed.mass_matrix(q) @ v + believed.bias(q, dq)
        return np.concatenate([dq, there.forward_dynamics(q, dq, tau)])

    start = np.concatenate([scene.start(), np.zeros(n)])
    solution = solve_ivp(
        rate, (0.0, times[-1]), start, method="Radau", t_eval=times, rtol=1e-9, atol=1e-11
    )
    return solution.y[:n].T


ORACLE = Path(__file__).with_name("friction_oracle.csv")
ORACLE_TIMES = np.arange(0.25, DURATION + 0.1, 0.25)

TESTED = [
    Scene("panda", 0.01, 0.0, "sines", "continuous", False),
    Scene("ur5e", 0.03, 5.0, "sines", "continuous", False),
    Scene("puma560", 0.10, 0.0, "hold", "continuous", False),
    Scene("z1", 0.10, 5.0, "sines", "continuous", True),
    Scene("jaco", 0.03, 0.0, "hold", "continuous", False),
    Scene("ur10", 0.01, 5.0, "sines", "continuous", False),
    Scene("iiwa14", 0.10, 0.0, "sines", "continuous", False),
    Scene("lite6", 0.10, 0.0, "sines", "continuous", False),
    Scene("xarm7", 0.10, 0.0, "sines", "sampled", False),
    Scene("panda_hand", 0.03, 0.0, "sines", "sampled", False),
    Scene("iiwa14", 0.10, 5.0, "hold", "sampled", False),
    Scene("lite6", 0.03, 5.0, "sines", "sampled", False),
]
"""Those that `test_friction` runs: the continuous ones against Radau."""


def oracle(scene: Scene) -> np.ndarray:
    """Positions at `ORACLE_TIMES`: by Radau; sampled ones by 50 µs, if 100 µs agree."""
    if scene.control == "continuous":
        return radau(scene, ORACLE_TIMES)
    fine, coarse = scene.run(5e-5), scene.run(1e-4)
    apart = np.abs(fine.q - coarse.q).max()
    if apart > 1e-5:
        raise ValueError(f"{scene}: steps of 50 and 100 µs are {apart:.1e} rad apart")
    return fine.q[np.rint(ORACLE_TIMES * 1e3).astype(int)]


def write_oracle(positions: list[np.ndarray]) -> None:
    """Write the positions of the scenes that are tested."""
    with ORACLE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        for number, q in enumerate(positions):
            for t, row in zip(ORACLE_TIMES, q, strict=True):
                writer.writerow([number, f"{t:g}", *(f"{x:.10f}" for x in row)])


def read_oracle() -> list[np.ndarray]:
    """What `write_oracle` wrote."""
    with ORACLE.open(newline="") as file:
        rows = list(csv.reader(file))
    return [
        np.array([row[2:] for row in rows if row[0] == str(number)], dtype=float)
        for number in range(len(TESTED))
    ]
