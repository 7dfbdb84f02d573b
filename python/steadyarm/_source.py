"""SOURCE, what a command works on: a robot, a scenario, or the file of a run, told by content."""

from __future__ import annotations

import argparse
import difflib
import re
import textwrap
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import ceil
from pathlib import Path
from typing import Any, Literal

from . import _core
from ._options import Refused, number, numbers
from ._sections import arm_names, load_robot
from .bench import Scenario, scenario_names

Kind = Literal["robot", "scenario", "run"]

OF_ROBOT = ("payload", "bandwidth", "armature", "effort_limit", "light_joints")
"""Options of a robot that `Scenario.of_robot` takes."""

ENDS = ("base", "tip")
"""Options of a robot that say which chain of a file it is."""

HEAVIEST, SHARE = 2.0, 1 / 6
"""The payload where none is said [kg], and the share of the arm's mass that it is at most."""

HEAD = 1 << 16
"""So much of a file is looked at to tell what it is [bytes]."""

ROBOT_TABLE = re.compile(rb"^\s*\[\[\s*joint\s*\]\]", re.MULTILINE)
"""What a robot in TOML has, and no scenario."""

MACRO = re.compile(rb"<xacro:|\$\{")
"""What a URDF has before its macros are expanded."""

SOURCE_TOO = "what its to_toml() returns is a SOURCE too"

HINTS = (
    (
        "rotor's inertia is missing",
        "--armature J (gear² · rotor inertia [kg·m²], one or one a joint), or --light-joints if "
        "there are no rotors",
        "armature in [robot]",
    ),
    (
        "wants the largest torque of the joint",
        "--effort-limit TAU (the largest torques [N·m], one or one a joint)",
        "effort_limit in [actual]",
    ),
    (
        "loop_rate: got",
        "a shorter --control-period (steadyarm design says how short)",
        "a shorter control_period in [run]",
    ),
    (
        "or a shorter period",
        "a lower --bandwidth, or a shorter --control-period",
        "a lower bandwidth, or a shorter control_period in [run]",
    ),
    ("record_every: got", "simulate with a larger --record-every", "simulate with --record-every"),
    ("mass: got", "--payload with a number of kg, 0 for none", "payload in [actual]"),
    ("choose one of", "--tip with one of these, such as --tip {first}", "tip in [robot]"),
    (
        "got no <inertial>",
        f"masses in the file, or from_urdf(…, masses={{{{link: kg}}}}) in Python; {SOURCE_TOO}",
        None,
    ),
    (
        'unphysical = "note"',
        f'a mended file, or from_urdf(…, unphysical="nearest") in Python; {SOURCE_TOO}',
        None,
    ),
)
"""Part of an error to what to give next: to a robot's command, and in a scenario's file."""


def add_source(parser: argparse.ArgumentParser, what: str, nargs: str | None = None) -> None:
    """Add the positional SOURCE; ``what`` it is for this command."""
    given: dict[str, Any] = {} if nargs is None else {"nargs": nargs}
    parser.add_argument("source", metavar="SOURCE", help=what, **given)


def add_chain(group: argparse._ArgumentGroup) -> None:
    """Add the options that say which chain of a file a robot is."""
    group.add_argument("--base", metavar="LINK", help="the start of its chain (default: the root)")
    group.add_argument("--tip", metavar="LINK", help="the end of its chain, where a file has more")


def add_load(group: argparse._ArgumentGroup, payload: str) -> None:
    """Add what a robot carries, in words, and its rotors."""
    add = group.add_argument
    add("--payload", metavar="KG", type=number, help=payload)
    add(
        "--armature",
        metavar="J",
        type=numbers,
        help="rotors that a model needs, gear² · rotor inertia [kg·m²], one or one a "
        "joint (default: as the file says)",
    )


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Add all options of a robot."""
    group = parser.add_argument_group("robot")
    add_chain(group)
    add_load(
        group,
        "5 cm beyond its tip, which no controller knows of (default: 2, or a sixth of the arm's "
        "mass if that is less)",
    )
    add = group.add_argument
    add(
        "--effort-limit",
        metavar="TAU",
        type=numbers,
        help="largest torques [N·m], one or one a joint (default: as the file says)",
    )
    add(
        "--light-joints",
        action="store_true",
        default=None,
        help="joints that look too light for their torque have no rotor, as on direct drives",
    )
    add(
        "--bandwidth",
        metavar="P",
        type=number,
        help="of all controllers but the recommended one [rad/s] (default: 15)",
    )


def names_help() -> str:
    """The names that come with the package, for a help."""
    lists = {"robots": arm_names(), "scenarios": scenario_names()}
    lines = (f"{kind}: {', '.join(names)}" for kind, names in lists.items())
    return "\n".join(textwrap.fill(line, 96, subsequent_indent="  ") for line in lines)


def kind_of(source: str) -> Kind:
    """What a source is: by its name if it comes with the package, or else by its content."""
    if source in scenario_names():
        return "scenario"
    if source in arm_names():
        return "robot"
    head = _head(source)
    if head.startswith(b"PK"):
        return "run"
    if head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<") or _ends(source, ".urdf", ".xacro"):
        return "robot"
    if ROBOT_TABLE.search(head):
        return "robot"
    if b"\0" in head or not (_ends(source, ".toml") or _is_toml(head)):
        raise Refused(f"{source}: wants a robot (URDF, TOML), a scenario (TOML) or a run (.npz)")
    return "scenario"


def _is_toml(text: bytes) -> bool:
    try:
        return bool(tomllib.loads(text.decode()))
    except ValueError:
        return False


def _head(source: str) -> bytes:
    """The beginning of a file."""
    path = Path(source)
    try:
        with path.open("rb") as file:
            return file.read(HEAD)
    except FileNotFoundError:
        if path.suffix or len(path.parts) > 1:
            raise Refused(f"cannot read {source}: no such file") from None
        every = [*arm_names(), *scenario_names()]
        near = difflib.get_close_matches(source, every, 1)
        robots, scenarios = ", ".join(arm_names()), ", ".join(scenario_names())
        wants = f"a robot ({robots}) or a scenario ({scenarios})"
        if near:
            wants = f"{near[0]}, or another name that steadyarm simulate --help lists"
        raise Refused(f"SOURCE: got {source!r}, wants a file, {wants}") from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise Refused(f"cannot read {source}: {why}") from error


def _ends(source: str, *endings: str) -> bool:
    return Path(source).suffix.lower() in endings


@contextmanager
def refusing(kind: Kind, source: str, name: str = "") -> Iterator[None]:
    """Let what is wrong with a source or its controller say what to do next."""
    before = f"{name}: " if name else ""
    try:
        yield
    except OSError as error:
        why = error.strerror or error
        raise Refused(f"cannot read {error.filename or source}: {why}") from error
    except (ValueError, TypeError) as error:
        raise Refused(f"{before}{error}{hint(str(error), kind)}") from error


def hint(said: str, kind: Kind) -> str:
    """What to do about an error, to stand behind it; nothing where it says so itself."""
    for part, of_robot, of_scenario in HINTS:
        if part in said:
            first = (re.findall(r'"([^"]+)" \(\d', said) or [""])[0]
            words = of_robot if kind == "robot" or of_scenario is None else of_scenario
            return f"; next: {words.format(first=first)}"
    return ""


def refuse_given(arguments: argparse.Namespace, names: tuple[str, ...], why: str) -> None:
    """Refuse options that were given where they say nothing."""
    for name in names:
        if getattr(arguments, name, None) is not None:
            raise Refused(f"--{name.replace('_', '-')}: {why}")


def arm_of(arguments: argparse.Namespace) -> _core.Serial:
    """The robot that was asked for, as its file says it."""
    source = arguments.source
    if source in arm_names() or _ends(source, ".toml"):
        refuse_given(arguments, ENDS, "for a URDF alone; this robot is one chain")
    with refusing("robot", source):
        try:
            return load_robot(source, arguments.tip, arguments.base)
        except ValueError as error:
            expanded = "choose one of" in str(error)
            if expanded or source in arm_names() or not MACRO.search(_head(source)):
                raise
            expand = f"pip install xacrodoc, then xacrodoc {source} -o robot.urdf"
            raise ValueError(f"{error}; it has macros, expand them first: {expand}") from error


def scene_of(arguments: argparse.Namespace) -> Scenario:
    """The scenario that was asked for; one is made for a robot."""
    source, kind = arguments.source, kind_of(arguments.source)
    if kind == "run":
        raise Refused(f"{source}: is the file of a run, which steadyarm play and export take")
    if kind == "robot":
        arm = arm_of(arguments)
        given = {name: getattr(arguments, name) for name in OF_ROBOT}
        given = {name: value for name, value in given.items() if value is not None}
        with refusing(kind, source):
            name = Path(source).stem
            return Scenario.of_robot(arm, name=name, **{"payload": payload_for(arm), **given})
    why = "for a robot alone; a scenario says it in its file"
    refuse_given(arguments, (*OF_ROBOT, *ENDS), why)
    with refusing(kind, source):
        return Scenario.read(source)


def payload_for(arm: _core.Serial) -> float:
    """What a robot carries where nobody says it [kg]."""
    return min(HEAVIEST, float(f"{SHARE * mass_of(arm):.2g}"))


def mass_of(arm: _core.Serial) -> float:
    """The mass of all links that move [kg]."""
    return float(arm.inertial_parameters()[::10].sum())


def in_loop(
    scene: Scenario,
    period: float | None = None,
    delay: int | None = None,
    duration: float | None = None,
) -> Scenario:
    """The scene with another period and delay of its loop, or another length, where given.

    The step is then a part of the period, the length a whole number of steps, and the steady
    figures of another length are those of its second half.
    """
    options = dict(scene.options)
    if duration is not None:
        options["duration"] = duration
    if period is not None:
        options["control_period"] = period
        options["dt"] = period / ceil(period / options["dt"] * (1.0 - 1e-9))
        steps = ceil(options["duration"] / options["dt"] * (1.0 - 1e-9))
        options["duration"] = steps * options["dt"]
    return replace(
        scene,
        options=options,
        front=scene.front if delay is None else {**scene.front, "delay": delay},
        window=scene.window if duration is None else None,
    )
