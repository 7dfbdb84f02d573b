"""What the sections of a scenario say: the arm that the controllers believe in, what stands before
them, and the controllers that are usual where a scenario names none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import _core
from ._scene import arguments

ARMS = Path(__file__).parent / "arms"
"""The arms that come with the package, in TOML."""


def arm_names() -> list[str]:
    """The names of the arms that come with the package."""
    return sorted(path.stem for path in ARMS.glob("*.toml"))


def usual_controllers(
    arm: _core.Arm, bandwidth: float, light_joints: bool = False
) -> dict[str, Any]:
    """The recommended one, and rivals with this bandwidth [rad/s] and an uncertainty of a half."""
    plain = (
        "pd_gravity", "computed_torque", "pid", "h_infinity", "slotine_li",
        "adaptive_computed_torque", "time_delay", "disturbance_observer", "momentum_observer",
    )  # fmt: skip
    unsure = ("sliding_mode", "robust", "super_twisting", "rise")
    uncertainty = {"inertia": 0.5, "acceleration": 5.0, "disturbance": 2.0}
    light = {"light_joints": True} if light_joints else {}
    laws: dict[str, Any] = {"recommended": {"law": "recommended", **light}}
    laws |= {name: {"law": name, "bandwidth": bandwidth} for name in plain}
    if isinstance(arm, _core.Serial):
        laws["natural_slotine_li"] = {"law": "natural_slotine_li", "bandwidth": bandwidth}
    for name in unsure:
        laws[name] = {"law": name, "bandwidth": bandwidth, "uncertainty": uncertainty}
    laws["rbf_network"] = {
        "law": "rbf_network",
        "bandwidth": bandwidth,
        "centers": [-1.5, -0.5, 0.0, 0.5, 1.5],
        "width": 1.0,
    }
    return laws


def check(
    sections: Mapping[str, Any],
    plant: _core.Plant,
    front: Mapping[str, Any],
    options: Mapping[str, Any],
) -> None:
    """Refuses what no controller could run with, by the path of its key."""
    joints = plant.arm.joints
    counts = {f"run.{name}": options[name] for name in ("q0", "dq0")}
    effects = sections["effects"]
    if effects is not None:
        counts |= {f"effects.{name}": value for name, value in arguments(effects).items()}
    for name in ("reference", "transfer"):
        if sections[name] is not None:
            found = sections[name](0.0)[0]
            counts[name] = found if len(found) > 1 else None
    for path, value in counts.items():
        if np.ndim(value) and len(value) != joints:
            raise ValueError(f"{path}: got {len(value)} entries, wants {joints}")
    sampled = {"effects": effects is not None, "front": bool(front), "actual": bool(plant.changes)}
    if options["control_period"] is None and any(sampled.values()):
        what = next(name for name, given in sampled.items() if given)
        raise ValueError(f"run.control_period: is missing, wants a period: [{what}] needs one")
    start = (sections["metrics"] or {}).get("from") or 0.0
    if start > options["duration"]:
        end = options["duration"]
        raise ValueError(f"metrics.from: got {start:g}, wants a time in the run, up to {end:g}")


def nominal_arm(sections: Mapping[str, Any]) -> _core.Arm:
    """The arm that the controllers believe in."""
    robot, two_link = sections["robot"], sections["two_link"]
    if (robot is None) == (two_link is None):
        raise ValueError("two_link: wants a section [two_link] or a section [robot], one of them")
    if robot is None:
        arm: _core.Arm = two_link
        return arm
    try:
        chain = load_robot(robot["file"], robot.get("tip"))
    except (ValueError, OSError) as error:
        raise ValueError(f"robot.file: {error}") from error
    armature = robot.get("armature")
    try:
        return chain if armature is None else chain.with_armature(armature)
    except ValueError as error:
        raise ValueError(f"robot.{error}") from error


def load_robot(source: str | Path, tip: str | None = None, base: str | None = None) -> _core.Serial:
    """A robot by the name of a shipped one, or from a URDF or TOML file."""
    path = Path(source)
    if str(source) in arm_names() or (path.suffix == "" and not path.is_file()):
        return _core.Serial.shipped(str(source))
    if path.suffix == ".toml":
        return _core.Serial.from_toml(path)
    return _core.Serial.from_urdf(path, base=base, tip=tip)


def own_controller(
    sections: Mapping[str, Any], nominal: _core.Arm, plant: _core.Plant, front: Mapping[str, Any]
) -> dict[str, Any]:
    """The controller of the sections [controller] and [compensator], as the only one."""
    if sections["controller"] is None:
        raise ValueError("controllers: is missing, wants a section such as [controllers.pid]")
    feedback = dict(sections["controller"])
    if feedback["effort_limit"] is None and np.isfinite(plant.effort_limit).all():
        feedback["effort_limit"] = plant.effort_limit
    compensator = sections["compensator"]
    tracker = _core.ComputedTorque(nominal, compensator=compensator, **feedback, **front)
    return {"controller": tracker}


def front_of(front: Mapping[str, Any] | None, effects: _core.Effects | None) -> dict[str, Any]:
    """What stands before every law: the delay is that of the effects, unless it is said."""
    front = {name: value for name, value in (front or {}).items() if value is not None}
    if effects is not None:
        front.setdefault("delay", effects.delay)
    return front


def sweep(arm: _core.Arm) -> _core.Sines:
    """A motion of all joints within a third of their limits."""
    middle, reach, speed = np.zeros(arm.joints), np.full(arm.joints, 0.5), np.full(arm.joints, 1.0)
    if isinstance(arm, _core.Serial):
        limits = arm.limits
        ranged = np.isfinite(limits["lower"]) & np.isfinite(limits["upper"])
        lower, upper = (
            np.where(ranged, limits["lower"], -1.0),
            np.where(ranged, limits["upper"], 1.0),
        )
        middle, reach = (lower + upper) / 2, np.minimum(0.5, (upper - lower) / 6)
        fast = np.where(np.isfinite(limits["velocity"]), limits["velocity"], 3.0)
        speed = np.minimum(1.0, fast / 3)
    frequency = speed / np.maximum(reach, 1e-3)
    frequency = np.minimum(frequency, 2.0) * (1 + 0.1 * np.arange(arm.joints) / arm.joints)
    return _core.Sines(frequency, sin=np.diag(reach), offset=middle)
