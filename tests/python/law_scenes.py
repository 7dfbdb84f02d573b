"""What the tests of the laws share: every law on a two-link arm and on a chain."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import steadyarm as sa
from steadyarm import laws

H = 1e-3
UNSURE = {"inertia": 0.5, "acceleration": 5.0, "disturbance": 2.0}
CENTERS = (-1.5, -0.5, 0.0, 0.5, 1.5)

TWO, CHAIN = "TwoLink", "UR5e"
EVERY = [
    (name, arm)
    for name in laws.__all__
    for arm in (TWO, CHAIN)
    if (name, arm) != ("natural_slotine_li", TWO)
]
"""Every law on every arm that it is for."""

SAMPLED_ONLY = ("adaptive_computed_torque", "time_delay")
UNCERTAIN = ("sliding_mode", "robust", "super_twisting", "rise")
LEARNING = (
    "slotine_li", "natural_slotine_li", "passive_fuzzy", "rbf_network", "adaptive_computed_torque",
)  # fmt: skip
OBSERVING = (
    "pid",
    "super_twisting",
    "rise",
    "time_delay",
    "disturbance_observer",
    "momentum_observer",
)

GAINS: dict[str, dict[str, Any]] = {
    "computed_torque": {"kp": 64.0, "kv": 16.0},
    "pd_gravity": {"stiffness": 100.0, "damping": 30.0},
    "pid": {"kp": 48.0, "kv": 12.0, "ki": 64.0},
    "sliding_mode": {"slope": 3.0, "gain": 20.0, "layer": 0.5, "linear": 2.0},
    "robust": {"kp": 8.0, "kv": 5.5, "q": 10.0, "bound": 20.0, "layer": 0.5},
    "h_infinity": {"kp": 8.0, "kv": 5.5, "q": 10.0, "gamma": 0.1, "r": 0.02},
    "super_twisting": {"slope": 3.0, "k1": 8.0, "k2": 25.0},
    "rise": {"alpha1": 3.0, "alpha2": 3.0, "ks": 10.0, "beta": 10.0},
    "slotine_li": {"slope": 5.0, "damping": 20.0, "gain": 1.0},
    "natural_slotine_li": {"slope": 5.0, "damping": 20.0, "gain": 0.1},
    "passive_fuzzy": {"slope": 5.0, "damping": 20.0},
    "rbf_network": {"kp": 9.0, "kv": 6.0, "q": 50.0, "gain": 20.0},
    "adaptive_computed_torque": {"kp": 8.0, "kv": 5.5, "q": 10.0, "gain": 0.5, "cutoff": 100.0},
    "time_delay": {"kp": 8.0, "kv": 5.5, "share": 1.0},
    "disturbance_observer": {"kp": 64.0, "kv": 16.0, "gain": 20.0},
    "momentum_observer": {"kp": 64.0, "kv": 16.0, "pole": 20.0},
}
"""Gains of every law."""


@functools.cache
def nominal(arm: str) -> sa.TwoLink | sa.Serial:
    """What the controllers believe in."""
    if arm == TWO:
        return sa.TwoLink(mass=(4, 4), length=(0.5, 0.5), inertia=(0.2, 0.2), gravity=9.81)
    return sa.Serial.shipped("ur5e").with_armature(0.1)


@functools.cache
def plant(arm: str) -> sa.Plant:
    """What is really there: heavier, and with friction."""
    known = nominal(arm)
    if isinstance(known, sa.TwoLink):
        heavier = known.__replace__(mass=(5, 6), inertia=(0.3, 0.25))
    else:
        heavier = known.with_payload(2.0, (0.0, 0.0, 0.05))
    return sa.Plant(heavier.with_friction(viscous=0.5, coulomb=0.3))


@functools.cache
def reference(arm: str) -> sa.Sines:
    n = nominal(arm).joints
    return sa.Sines(np.linspace(2.0, 3.0, n), sin=np.diag(np.full(n, 0.3)), offset=0.2)


def extras(name: str, joints: int) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Arguments that a law needs whatever its gains: by place, by name."""
    if name == "passive_fuzzy":
        basis = sa.FuzzyBasis("concat", CENTERS, 0.7, False, "trajectory", joints=joints)
        return (sa.FuzzyCompensator(basis, gain=5.0),), {}
    if name == "rbf_network":
        return (), {"centers": [-1.0, 0.0, 1.0], "width": 1.0}
    return (), {}


def made(name: str, arm: str, **options: Any) -> sa.Controller:
    """The law with a bandwidth, of a loop of 1 kHz."""
    place, named = extras(name, nominal(arm).joints)
    if name in UNCERTAIN:
        named = named | {"uncertainty": UNSURE}
    settings = {"bandwidth": 10.0, "control_period": H} | named | options
    return getattr(laws, name)(nominal(arm), *place, **settings)


def by_gains(name: str, arm: str, **options: Any) -> sa.Controller:
    """The law with each gain."""
    place, named = extras(name, nominal(arm).joints)
    return getattr(laws, name)(nominal(arm), *place, **(GAINS[name] | named | options))


def start(arm: str) -> dict[str, Any]:
    """Where the arm is when the loop begins: a little off, and in motion."""
    q, dq, _ = reference(arm)(0.0)
    return {"q0": q + 0.05, "dq0": dq - 0.1}


def simulated(controller: Any, arm: str, steps: int = 60, **options: Any) -> sa.Run:
    options = {"control_period": H} | start(arm) | options
    return sa.simulate(plant(arm), controller, reference(arm), steps * H, H, **options)


def rows(arm: str, count: int, seed: int = 0) -> list[list[np.ndarray]]:
    """Samples (q, dq, q_d, dq_d, ddq_d) near the reference, with noise."""
    random, found = np.random.default_rng(seed), []
    for k in range(count):
        q_d, dq_d, ddq_d = reference(arm)(k * H)
        off = random.normal(size=(2, len(q_d)))
        found.append([q_d + 0.02 * off[0], dq_d + 0.2 * off[1], q_d, dq_d, ddq_d])
    return found


def driven(controller: sa.Controller, samples: list[list[np.ndarray]]) -> np.ndarray:
    """The torques for samples."""
    return np.array([controller.step(*sample, H) for sample in samples])
