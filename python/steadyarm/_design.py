"""The command ``steadyarm design``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from . import paper
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


def add_design(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "design",
        "before you run it: will it help, will it be stable, how fast must the loop be?",
        "Report what a controller with a compensator will do, from its gains, Q, gamma, basis and\n"
        "gain, the control period and the delay of the loop. What you do not give is the paper's.\n"
        "The verdict is in words; the exit code is 1 if it says not to run this.",
        _design,
    )
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
        default=1e-3,
        help="period of the loop [s] (default: 0.001)",
    )
    loop(
        "--delay",
        metavar="N",
        type=int,
        default=0,
        help="samples from measurement to torque, 0 to 8 (default: 0)",
    )
    loop(
        "--disturbance",
        metavar="A@W,…",
        type=harmonics,
        default=((1.0, 1.0),),
        help="what the model leaves out along the motion: amplitude [rad/s²] @ frequency [rad/s] "
        "of each harmonic (default: 1@1)",
    )
    loop(
        "--inertia-ratio",
        metavar="R",
        type=number,
        default=1.0,
        help="believed over true inertia; 0.5 for an arm twice as heavy (default: 1)",
    )


OVERRIDES = ("kp", "kv", "q", "form", "normalized", "gain", "inputs", "leak_rate", "gamma")
"""Options that change the scene if they are given."""


def _design(arguments: argparse.Namespace) -> int:
    try:
        scene = scene_of(arguments, 3, OVERRIDES)
        report = design(
            scene.tracker,
            control_period=arguments.control_period,
            delay=arguments.delay,
            disturbance=arguments.disturbance,
            inertia_ratio=arguments.inertia_ratio,
            path=None if arguments.inputs is None else scene.reference,
        )
    except (ValueError, TypeError, OverflowError) as error:
        raise Refused(error) from error
    say(str(report))
    return 0 if report.sound else FAILED
