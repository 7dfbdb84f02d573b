"""The options of the paper's scene, or of another of such an arm, and what they make."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from . import paper, reproduction
from ._options import Refused, names, number, numbers
from .scenario import Scene


def add_scenario(group: argparse._ArgumentGroup) -> None:
    """Add the options that choose the scene: a file, or a reading of the paper."""
    chosen = group.add_mutually_exclusive_group()
    chosen.add_argument(
        "--scenario",
        metavar="FILE.toml",
        type=Path,
        help="a scene of a two-joint arm whose settings the options below change; "
        "`steadyarm scenario` writes one to start from",
    )
    chosen.add_argument(
        "--preset",
        choices=(*paper.PRESETS, "recommended"),
        help="how the paper is read: printed is inert, claimed works; recommended: what we would "
        "take instead (default: printed)",
    )


def add_feedback(group: argparse._ArgumentGroup) -> None:
    """Add the gains of computed torque."""
    words = {"kp": "position [1/s²]", "kv": "velocity [1/s]"}
    for name, of in words.items():
        usual = paper.FEEDBACK[name]
        words_of = f"feedback on {of} (default: {usual:g})"
        group.add_argument(f"--{name}", metavar="K", type=numbers, help=words_of)


def add_compensator(group: argparse._ArgumentGroup) -> None:
    """Add the options of the compensator."""
    add = group.add_argument
    add(
        "--form",
        choices=reproduction.FORMS,
        help="how fuzzy sets combine to rules: grid has every combination (5^inputs), shared one "
        "rule a set (5), concat one a set and input (20), per_joint a grid a joint (25 each)",
    )
    _add_strengths(group)
    add(
        "--gain",
        metavar="G",
        type=numbers,
        help="how fast it learns; the inverse of the paper's Γ: too low changes nothing, too high "
        "shakes a sampled controller",
    )
    add(
        "--inputs",
        metavar="NAME",
        type=names,
        help="what the rules see: error (the paper), state, reference, trajectory, or a list of "
        "e, de, q, dq, q_d, dq_d, ddq_d",
    )
    add(
        "--leak-rate",
        metavar="R",
        type=number,
        help="how fast it forgets [1/s]; keeps weights from drifting away (default: 0)",
    )
    add(
        "--gamma",
        metavar="G",
        type=number,
        help="level of disturbance that the proof allows for, γ (default: 1)",
    )


def _add_strengths(group: argparse._ArgumentGroup) -> None:
    strengths = group.add_mutually_exclusive_group()
    strengths.add_argument(
        "--normalized",
        action="store_true",
        default=None,
        help="divide the firing strengths by their sum",
    )
    strengths.add_argument(
        "--raw",
        action="store_false",
        dest="normalized",
        default=None,
        help="use the firing strengths as they are",
    )


SHARED = ("kp", "kv", "form", "normalized", "gain", "inputs", "leak_rate", "gamma")
"""Options of the controller that change the scene if they are given."""


def preset(arguments: argparse.Namespace) -> Literal["printed", "claimed", "recommended"]:
    """How the paper is read."""
    chosen: Literal["printed", "claimed", "recommended"] = arguments.preset or "printed"
    return chosen


def paper_scene(
    arguments: argparse.Namespace, number: Literal[1, 2, 3], overrides: Sequence[str]
) -> Scene:
    """The scene that was chosen, with those of the options of these names that were given."""
    chosen = {name: getattr(arguments, name) for name in overrides}
    chosen = {name: value for name, value in chosen.items() if value is not None}
    if arguments.scenario is None:
        return paper.simulation(number, preset(arguments), **chosen)
    try:
        return Scene.read(arguments.scenario, **chosen)
    except OSError as error:
        why = error.strerror or error
        raise Refused(f"--scenario: cannot read {arguments.scenario}: {why}") from error
