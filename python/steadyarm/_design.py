"""The command ``steadyarm design``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from . import _core
from ._design_scene import PERIOD, Judgement, report_plain
from ._json import add_json, emit
from ._options import FAILED, Refused, command, harmonics, number, positive
from ._paper_scene import SHARED, add_compensator, add_feedback, add_scenario, paper_scene
from ._source import (
    ENDS,
    OF_ROBOT,
    add_robot,
    add_source,
    in_loop,
    kind_of,
    names_help,
    refuse_given,
    scene_of,
)
from .design import design

if TYPE_CHECKING:
    from ._options import Commands


def add_design(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "design",
        "before you run it: which controller, which gains, how fast must the loop be?",
        "With a robot: the recommended controller's gains, their margins, which other controllers\n"
        "are accepted at this period and delay, how slow the loop may be for each, and what the\n"
        "motion can teach. The exit code is 1 if the recommended controller is refused.\n\n"
        "With a scenario: the same of its controllers; for computed torque with a compensator a\n"
        "report along the scenario's path. The exit code is 1 if any is refused.\n\n"
        "Without a SOURCE: what a controller with a compensator will do on the paper's arm, from\n"
        "its gains, Q, gamma, basis and gain, the control period and the delay of the loop. What\n"
        "you do not give is the paper's. The exit code is 1 if the verdict says not to run it.\n\n"
        f"{names_help()}",
        _design,
        examples="  steadyarm design robot.urdf --armature 0.1\n"
        "  steadyarm design robot.urdf --control-period 0.004 --delay 2\n"
        "  steadyarm design paper_sensors\n"
        "  steadyarm design --preset claimed --control-period 0.002",
    )
    add_source(parser, "a robot or a scenario (default: the paper's arm)", "?")
    add_robot(parser)
    loop = parser.add_argument_group("loop").add_argument
    loop(
        "--control-period",
        metavar="S",
        type=positive,
        help="period of the loop [s] (default: that of a scenario, or 0.001)",
    )
    loop(
        "--delay",
        metavar="N",
        type=int,
        help="samples from measurement to torque, 0 to 8 (default: that of a scenario, 1 of a "
        "robot, or 0)",
    )
    add_json(loop)
    _add_paper(parser)


def _add_paper(parser: argparse.ArgumentParser) -> None:
    scene = parser.add_argument_group("the paper's arm, or another of two joints")
    add_scenario(scene)
    add_feedback(scene)
    add = scene.add_argument
    add("--q", metavar="Q", type=number, help="Q is this times the identity (default: 10)")
    add(
        "--disturbance",
        metavar="A@W,…",
        type=harmonics,
        help="what the model leaves out along the motion: amplitude [rad/s²] @ frequency [rad/s] "
        "of each harmonic (default: 1@1)",
    )
    add(
        "--inertia-ratio",
        metavar="R",
        type=number,
        help="believed over true inertia; 0.5 for an arm twice as heavy (default: 1)",
    )
    add_compensator(parser.add_argument_group("its compensator"))


OVERRIDES = ("q", *SHARED)
"""Options that change the paper's scene if they are given."""

ALONE = ("scenario", "preset", *OVERRIDES, "disturbance", "inertia_ratio")
"""Options that say what a SOURCE says."""


def _design(arguments: argparse.Namespace) -> int:
    if arguments.source is not None:
        return _judge(arguments)
    refuse_given(arguments, (*OF_ROBOT, *ENDS), "for a robot: give one as SOURCE")
    try:
        scene = paper_scene(arguments, 3, OVERRIDES)
        tracker = scene.tracker
        if not isinstance(tracker, _core.ComputedTorque):
            raise Refused("--preset: got recommended, which has no gain to judge: see sa.learned")
        report = design(
            tracker,
            PERIOD if arguments.control_period is None else arguments.control_period,
            arguments.delay or 0,
            disturbance=arguments.disturbance,
            inertia_ratio=arguments.inertia_ratio,
            path=None if arguments.inputs is None else scene.reference,
        )
    except (ValueError, TypeError, OverflowError) as error:
        raise Refused(error) from error
    emit(arguments, str(report), report_plain(report))
    return 0 if report.sound else FAILED


def _judge(arguments: argparse.Namespace) -> int:
    """Judge every controller of a robot or a scenario."""
    refuse_given(arguments, ALONE, "wants no SOURCE beside it, which says that itself")
    scene = in_loop(scene_of(arguments), arguments.control_period, arguments.delay)
    judgement = Judgement(scene, kind_of(arguments.source))
    emit(arguments, judgement.words(), judgement.plain())
    return 0 if judgement.sound else FAILED
