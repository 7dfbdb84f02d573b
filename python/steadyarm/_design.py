"""The command ``steadyarm design``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _bench, _core, paper
from ._options import (
    FAILED,
    Refused,
    add_scenario,
    command,
    harmonics,
    number,
    numbers,
    scene_of,
)
from ._simulate import add_compensator
from ._streams import say
from .design import design

if TYPE_CHECKING:
    from ._options import Commands
    from .bench import Scenario


def add_design(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "design",
        "before you run it: will it help, will it be stable, how fast must the loop be?",
        "Report what a controller with a compensator will do, from its gains, Q, gamma, basis and\n"
        "gain, the control period and the delay of the loop. What you do not give is the paper's.\n"
        "The verdict is in words; the exit code is 1 if it says not to run this.\n\n"
        "With a SCENARIO, as compare takes it: which of its controllers are accepted at its\n"
        "period and delay, and why the others are not; for computed torque with a compensator\n"
        "this report too, along the scenario's path. The exit code is 1 if any is refused.",
        _design,
    )
    _bench.add_source(parser, nargs="?")
    add_scenario(parser.add_argument_group("scene"))
    feedback = parser.add_argument_group("controller").add_argument
    feedback(
        "--kp",
        metavar="K",
        type=numbers,
        help=f"feedback on position [1/s²] (default: {paper.FEEDBACK['kp']:g})",
    )
    feedback(
        "--kv",
        metavar="K",
        type=numbers,
        help=f"feedback on velocity [1/s] (default: {paper.FEEDBACK['kv']:g})",
    )
    feedback("--q", metavar="Q", type=number, help="Q is this times the identity (default: 10)")
    add_compensator(parser.add_argument_group("compensator"))
    loop = parser.add_argument_group("loop and arm").add_argument
    loop(
        "--control-period",
        metavar="S",
        type=number,
        help="period of the loop [s] (default: that of the SCENARIO, or 0.001)",
    )
    loop(
        "--delay",
        metavar="N",
        type=int,
        help="samples from measurement to torque, 0 to 8 (default: that of the SCENARIO, or 0)",
    )
    loop(
        "--disturbance",
        metavar="A@W,…",
        type=harmonics,
        help="what the model leaves out along the motion: amplitude [rad/s²] @ frequency [rad/s] "
        "of each harmonic (default: 1@1)",
    )
    loop(
        "--inertia-ratio",
        metavar="R",
        type=number,
        help="believed over true inertia; 0.5 for an arm twice as heavy (default: 1)",
    )


OVERRIDES = ("kp", "kv", "q", "form", "normalized", "gain", "inputs", "leak_rate", "gamma")
"""Options that change the scene if they are given."""


ALONE = ("scenario", *OVERRIDES, "disturbance", "inertia_ratio")
"""Options that say what a SCENARIO says."""

PERIOD = 1e-3
"""Of a loop that says none [s]."""


def _design(arguments: argparse.Namespace) -> int:
    if arguments.source is not None:
        return _judge_all(arguments)
    try:
        scene = scene_of(arguments, 3, OVERRIDES)
        tracker = scene.tracker
        if not isinstance(tracker, _core.ComputedTorque):
            raise Refused("--preset: got recommended, which has no gain to judge: see sa.learned")
        report = design(
            tracker,
            control_period=_or(arguments.control_period, PERIOD),
            delay=_or(arguments.delay, 0),
            disturbance=arguments.disturbance,
            inertia_ratio=arguments.inertia_ratio,
            path=None if arguments.inputs is None else scene.reference,
        )
    except (ValueError, TypeError, OverflowError) as error:
        raise Refused(error) from error
    say(str(report))
    return 0 if report.sound else FAILED


def _or(value: Any, default: Any) -> Any:
    return default if value is None else value


def _judge_all(arguments: argparse.Namespace) -> int:
    """Judge every controller of a scenario: accepted or not, and a report where there is one."""
    for name in ALONE:
        if getattr(arguments, name) is not None:
            option = name.replace("_", "-")
            raise Refused(f"--{option}: wants no SCENARIO beside it, which says that itself")
    scene = _in_loop(_bench.scene_of(arguments), arguments.control_period, arguments.delay)
    period, delay = scene.options.get("control_period"), scene.front.get("delay", 0)
    late = f"{delay} sample" + "s" * (delay != 1)
    loop = "continuous" if period is None else f"{1e3 * period:g} ms, torques {late} late"
    say(f"scenario    {scene.title}\nloop        {loop}\n")
    code, accepted = 0, []
    for name, law in scene.controllers.items():
        try:
            scene.controller(law)
        except (ValueError, TypeError) as error:
            say(f"{name:28}refused: {error}")
            code = FAILED
        else:
            say(f"{name:28}accepted")
            accepted.append(name)
    for name, tracker in _learning(scene, accepted):
        report = design(
            tracker, _or(period, PERIOD), delay, path=scene.reference, plant=scene.plant
        )
        say(f"\n{name}, along the path of the scenario, without hand-over and filters\n{report}")
        code = code if report.sound else FAILED
    return code


def _in_loop(scene: Scenario, period: float | None, delay: int | None) -> Scenario:
    """The scene with another period and delay of its loop, where they are given."""
    options = scene.options if period is None else {**scene.options, "control_period": period}
    front = scene.front if delay is None else {**scene.front, "delay": delay}
    return replace(scene, options=options, front=front)


def _learning(scene: Scenario, accepted: list[str]) -> Iterator[tuple[str, _core.ComputedTorque]]:
    """Those of the controllers that are computed torque with a fuzzy compensator, as such."""
    for name in accepted:
        law = scene.controllers[name]
        if isinstance(law, Mapping) and law["law"] == "computed_torque":
            given = {key: value for key, value in law.items() if value is not None}
            if "compensator" in given:
                yield name, _tracker(scene.nominal, given)


def _tracker(arm: _core.Arm, law: Mapping[str, Any]) -> _core.ComputedTorque:
    """Computed torque of the settings of a law."""
    settings = dict(law["compensator"])
    basis = _core.FuzzyBasis(**settings.pop("basis"))
    compensator = _core.FuzzyCompensator(basis, **settings)
    if "bandwidth" not in law:
        return _core.ComputedTorque(arm, law["kp"], law["kv"], compensator)
    bandwidth = np.asarray(law["bandwidth"], dtype=float)
    return _core.ComputedTorque(arm, bandwidth**2, 2.0 * bandwidth, compensator)
