"""The command ``steadyarm robots``: the arms that come with the package, and what a file says."""

from __future__ import annotations

import argparse
import textwrap
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from ._json import add_json, emit
from ._options import Refused, command
from ._report import PAGE, itemized
from ._sections import ARMS, arm_names
from ._source import ENDS, add_chain, add_source, arm_of, kind_of, mass_of, refuse_given

if TYPE_CHECKING:
    from ._options import Commands

UNITS = {"revolute": "rad", "continuous": "rad", "prismatic": "m"}
"""Of a joint's position, by its kind."""


def add_robots(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "robots",
        "the robots that come with it; the joints of one, or of your own file, and what it lacks",
        "Without a SOURCE: the robots that come with the package, with their joints, masses,\n"
        "largest torques, and where the figures are from. Payloads stand in none of these files.\n"
        "With one, your own too: its joints, ranges and limits, the masses of its links, and what\n"
        "in the file was not used or looks odd.",
        _robots,
        examples="  steadyarm robots\n"
        "  steadyarm robots panda\n"
        "  steadyarm robots robot.urdf --tip tool0\n"
        "  steadyarm robots --json | jq '.robots[].name'",
    )
    add_source(parser, "a robot: a URDF, a TOML, or a name (default: all that come with it)", "?")
    add_chain(parser.add_argument_group("robot"))
    add_json(parser.add_argument)


def _robots(arguments: argparse.Namespace) -> int:
    if arguments.source is None:
        refuse_given(arguments, ENDS, "for a robot: give one as SOURCE")
        robots = [_shipped(name) for name in arm_names()]
        emit(arguments, _listed(robots), {"robots": robots})
        return 0
    if kind_of(arguments.source) != "robot":
        raise Refused(f"{arguments.source}: wants a robot, such as a URDF, or none for the list")
    found = described(arm_of(arguments))
    emit(arguments, _told(found), found)
    return 0


def described(arm: _core.Serial) -> dict[str, Any]:
    """What a robot's description says, by the names of the Python API and of its TOML."""
    rows = tomllib.loads(arm.to_toml())["joint"]
    limits: dict[str, Any] = {**arm.limits}
    joints = [
        {
            "name": row["name"],
            "link": row["link"],
            "kind": row["kind"],
            **{name: float(limits[name][n]) for name in ("lower", "upper", "velocity", "effort")},
            "mass": float(row["mass"]),
            "armature": float(row["armature"]),
        }
        for n, row in enumerate(rows)
    ]
    return {"title": arm.name, "mass": mass_of(arm), "joints": joints, "notes": list(arm.notes)}


def _shipped(name: str) -> dict[str, Any]:
    """What one of the package's robots is, with its sources."""
    said = described(_core.Serial.shipped(name))
    return {"name": name, **said, "sources": _sources(ARMS / f"{name}.toml")}


def _sources(path: Path) -> str:
    """What the head of a file says under "Sources"."""
    head = path.read_text(encoding="utf-8").partition("# Sources\n")[2].splitlines()
    lines = []
    for line in head:
        if not line.startswith("#   "):
            break
        lines.append(line[4:].strip())
    return " ".join(lines)


def _listed(robots: list[dict[str, Any]]) -> str:
    lines = []
    for robot in robots:
        joints = robot["joints"]
        effort = [joint["effort"] for joint in joints]
        limits = _span(effort, "N·m") if np.isfinite(effort).any() else "no largest torques"
        rotors = "rotors" if any(joint["armature"] for joint in joints) else "no rotors"
        figures = f"{len(joints)} joints, {robot['mass']:.3g} kg, {limits}, {rotors} in its file"
        lines += [f"{robot['name']:12}{robot['title']}: {figures}"]
        indent = " " * 12
        form: dict[str, Any] = {"initial_indent": indent, "subsequent_indent": indent}
        lines += [*textwrap.wrap(robot["sources"], PAGE, **form), ""]
    lines.append(
        "steadyarm robots NAME lists its joints. Each command takes a URDF of your own too."
    )
    return "\n".join(lines)


def _span(values: list[float], unit: str) -> str:
    low, high = min(values), max(values)
    return f"{low:g} {unit}" if low == high else f"{low:g} to {high:g} {unit}"


HEADS = ("kind", "range", "speed", "effort", "mass", "rotor")
"""Columns of the table of joints."""


def _told(found: dict[str, Any]) -> str:
    joints = found["joints"]
    wide = max(len(joint["name"]) for joint in joints) + 2
    widths = (12, 22, 14, 14, 12, 14)
    rows = [_cells(joint) for joint in joints]
    lines = [f"{found['title']}, {len(joints)} joints, {found['mass']:.3g} kg", ""]
    for name, cells in (("joint", HEADS), *zip([j["name"] for j in joints], rows, strict=True)):
        row = "".join(f"{cell:{width}}" for cell, width in zip(cells, widths, strict=True))
        lines.append(f"{name:{wide}}{row}".rstrip())
    lines += ["", "mass: of the link that it moves; rotor: its inertia, seen through the gear"]
    if found["notes"]:
        lines += ["", "What the file says that was not used, or looks odd:"]
        lines += itemized(found["notes"])
    return "\n".join(lines)


def _cells(joint: dict[str, Any]) -> tuple[str, ...]:
    unit = UNITS[joint["kind"]]
    force = "N" if unit == "m" else "N·m"
    bounds = [joint["lower"], joint["upper"]]
    inertia = "kg" if unit == "m" else "kg·m²"
    return (
        joint["kind"],
        f"{bounds[0]:.4g} to {bounds[1]:.4g} {unit}" if np.isfinite(bounds).all() else "no limit",
        _limit(joint["velocity"], f"{unit}/s"),
        _limit(joint["effort"], force),
        f"{joint['mass']:.4g} kg",
        f"{joint['armature']:.3g} {inertia}" if joint["armature"] else "none",
    )


def _limit(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}" if np.isfinite(value) else "no limit"
