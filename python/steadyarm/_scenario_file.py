"""The command ``steadyarm scenario``: a scenario as TOML, of one's own robot too."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core, _toml, paper
from ._options import Refused, command
from ._scene import arguments as arguments_of
from ._source import (
    ENDS,
    OF_ROBOT,
    add_robot,
    add_source,
    kind_of,
    names_help,
    payload_for,
    refuse_given,
    scene_of,
)
from ._streams import say
from .bench import BEYOND, FRICTION_SHARE, LIBRARY, Scenario, scenario_names

if TYPE_CHECKING:
    from ._options import Commands


def add_scenario(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "scenario",
        "a scenario as TOML, to be edited: of your robot, of one that comes with it, of the paper",
        "Print a scenario as TOML: what simulate and compare make of a robot, one that comes with\n"
        "the package, or one of the paper's simulations. Edit its motion, sensors, loads and\n"
        "controllers, and give it to compare, simulate or design.\n\n"
        f"{names_help()}\n\n"
        "Editors that know TOML (Even Better TOML, taplo) complete and check the keys of such a\n"
        "file, with the schema beside it.",
        _scenario,
        examples="  steadyarm scenario robot.urdf --payload 2 > mine.toml\n"
        "  steadyarm compare mine.toml\n"
        "  steadyarm scenario paper_sensors > mine.toml\n"
        "  steadyarm scenario --schema > schema.json\n"
        "  steadyarm scenario --preset claimed > mine.toml\n"
        "  steadyarm simulate --scenario mine.toml --gain 70",
    )
    add_source(parser, "a robot or a scenario's name (default: the paper's)", "?")
    add_robot(parser)
    group = parser.add_argument_group("the paper, and the keys of a file")
    group.add_argument("--simulation", type=int, choices=(1, 2, 3), help="default: 3")
    group.add_argument("--preset", choices=tuple(paper.PRESETS), help="default: printed")
    group.add_argument("--schema", action="store_true", help="the JSON Schema of such a file")


def _scenario(arguments: argparse.Namespace) -> int:
    source = arguments.source
    if arguments.schema and source is not None:
        raise Refused("--schema: is one for all scenarios, wants no SOURCE beside it")
    if arguments.schema or source is not None:
        refuse_given(arguments, ("simulation", "preset"), "is for the paper's scenes alone")
    if source is None or source in scenario_names():
        refuse_given(arguments, (*OF_ROBOT, *ENDS), "for a robot alone; edit the file")
    if arguments.schema:
        text = (LIBRARY / "schema.json").read_text(encoding="utf-8")
    elif source is None:
        text = paper.scenario(arguments.simulation or 3, arguments.preset or "printed")
    elif source in scenario_names():
        text = (LIBRARY / f"{source}.toml").read_text(encoding="utf-8")
    elif kind_of(source) == "robot":
        text = _of_robot(arguments)
    else:
        raise Refused(f"{source}: wants a robot, or one of {', '.join(scenario_names())}")
    say(text.rstrip())
    return 0


def _of_robot(arguments: argparse.Namespace) -> str:
    """The scene that is made of a robot, as a file."""
    if arguments.base is not None:
        raise Refused("--base: a scenario's file does not say it; steadyarm export makes a TOML")
    scene = scene_of(arguments)
    head = f"# What steadyarm makes of {arguments.source}: edit it, and run it as any scenario."
    return "\n".join([head, *_toml.lines(sections_of(scene, arguments))])


def sections_of(scene: Scenario, arguments: argparse.Namespace) -> dict[str, Any]:
    """What a file says of a robot's scene, by section."""
    arm = scene.nominal
    assert isinstance(arm, _core.Serial) and scene.effects is not None
    load = payload_for(arm) if arguments.payload is None else arguments.payload
    usual = arguments_of(_core.Effects())
    effects = {
        name: value
        for name, value in arguments_of(scene.effects).items()
        if not np.array_equal(value, usual[name])
    }
    motion = arguments_of(scene.reference)
    return {
        "": {"title": scene.title},
        "robot": {"file": arguments.source, "tip": arguments.tip, "armature": arguments.armature},
        "actual": {
            "friction_share": FRICTION_SHARE,
            "effort_limit": _each(arguments.effort_limit, arm),
        },
        "actual.payload": {"mass": load, "com": BEYOND} if load else {},
        "reference.sines": {name: motion[name] for name in ("frequency", "sin", "offset")},
        "effects": effects,
        "front": {name: scene.front[name] for name in ("hand_over", "velocity_filter")},
        "run": {name: scene.options[name] for name in ("duration", "control_period", "q0")},
        **{f"controllers.{name}": law for name, law in scene.controllers.items()},
    }


def _each(limit: Any, arm: _core.Arm) -> Any:
    return limit if limit is None or np.ndim(limit) else [limit] * arm.joints
