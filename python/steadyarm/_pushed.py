"""What a disturbance of a `Plant` was at the rows of a run.

What depends on the time alone is asked of the core: under it, joints that are decoupled and known
exactly record it as their model error, ρ = -τ_d for M = 1 kg·m².
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._scene import arguments

if TYPE_CHECKING:
    from .run import Run

Array = NDArray[np.float64]


def disturbance_torque(plant: _core.Plant, run: Run, options: Mapping[str, Any]) -> Array:
    """τ_d at every row [N·m], (T, n); ``options`` are those of the run."""
    given = plant.disturbance
    several = isinstance(given, list | tuple)
    pushes: Any = given if several else [] if given is None else [given]
    total = np.zeros_like(run.q)
    for push in pushes:
        if isinstance(push, _core.Wrench):
            total += _wrench(push, plant.arm, run, options)
        elif isinstance(push, _core.Curve | _core.Disturbance):
            total += _over_time(push, run.joints, run, options)
        else:
            total += [push(*row) for row in zip(run.q, run.dq, run.t, strict=True)]
    return total


def _over_time(push: Any, columns: int, run: Run, options: Mapping[str, Any]) -> Array:
    """What depends on the time alone, (T, columns)."""
    arm = _core.Serial.from_dh(np.zeros(columns), 0.0, 0.0, armature=1.0, gravity=np.zeros(3))
    still = _core.Quintic(np.zeros(columns), np.zeros(columns), 1.0)
    record, _ = _core.simulate(
        _core.Plant(arm, push),
        _core.ComputedTorque(arm, 1.0, 2.0),
        still,
        duration=options["duration"],
        dt=options["dt"],
        method="rk4",
        control_period=None,
        q0=None,
        dq0=None,
        rtol=1e-8,
        atol=1e-10,
        record_every=options["record_every"],
        record="all",
        effects=None,
        progress=None,
    )
    rows = np.searchsorted(record["columns"]["t"], run.t)
    pushed: Array = -record["columns"]["rho"][rows]
    return pushed


def _wrench(wrench: _core.Wrench, arm: _core.Arm, run: Run, options: Mapping[str, Any]) -> Array:
    """-Jᵀ (F, m), (T, n)."""
    said = arguments(wrench)
    if said["curve"] is not None:
        push = _over_time(said["curve"], 6, run, options)
    else:
        constant = [
            np.zeros(3) if said[name] is None else said[name] for name in ("force", "moment")
        ]
        push = np.broadcast_to(np.concatenate(constant), (len(run.t), 6))
    jacobians = np.array([_jacobian(arm, q) for q in run.q])
    torque: Array = -np.einsum("tij,ti->tj", jacobians, push)
    return torque


def _jacobian(arm: _core.Arm, q: Array) -> Array:
    """The Jacobian of the tip in the axes of the base, (6, n)."""
    if isinstance(arm, _core.Serial):
        return arm.jacobian(q)
    poses, tip = arm.link_poses(q), arm.pose(q)[:3, 3]
    axes = poses[:, :3, 2]
    return np.concatenate([np.cross(axes, tip - poses[:, :3, 3]), axes], axis=1).T
