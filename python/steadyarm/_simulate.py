"""The command ``steadyarm simulate``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from . import paper, reproduction
from ._options import (
    FAILED,
    STOPPED,
    Refused,
    add_scenario,
    check_files,
    command,
    names,
    number,
    numbers,
    picture,
    record,
    scene_of,
)
from ._streams import say, tell
from .run import Run

if TYPE_CHECKING:
    from ._options import Commands


def add_simulate(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "simulate",
        "one run: how it ended, the error, the torque, the certificate",
        "Run one scene, of the paper or of a file. What you do not give is as it says.\n"
        'A value for each joint is written "7,70"; fractions like 1/7 are understood.',
        _simulate,
    )
    _add_scene(parser.add_argument_group("scene"))
    _add_controller(parser.add_argument_group("controller"))
    add_compensator(parser.add_argument_group("compensator (simulation 3)"))
    _add_numerics(parser.add_argument_group("numerics"))
    _add_output(parser.add_argument_group("output"))


def _add_scene(group: argparse._ArgumentGroup) -> None:
    add_scenario(group)
    add = group.add_argument
    add(
        "--simulation",
        type=int,
        choices=(1, 2, 3),
        default=3,
        help="1: the model is exact. 2: the arm is twice as heavy as the model, with a "
        "disturbance. 3: the same, with the compensator (default)",
    )
    add("--duration", metavar="S", type=number, help="length [s] (default: 40)")


def _add_controller(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--kp",
        metavar="K",
        type=numbers,
        help=f"feedback on position [1/s²] (default: {paper.FEEDBACK['kp']:g})",
    )
    add(
        "--kv",
        metavar="K",
        type=numbers,
        help=f"feedback on velocity [1/s] (default: {paper.FEEDBACK['kv']:g})",
    )
    add(
        "--control-period",
        metavar="S",
        type=number,
        help="the controller steps once every so many seconds and holds its torque, as on a real "
        "machine (default: continuous, as in the paper)",
    )


def add_compensator(group: argparse._ArgumentGroup) -> None:
    """Add the options of the compensator."""
    add = group.add_argument
    add(
        "--form",
        choices=reproduction.FORMS,
        help="how fuzzy sets combine to rules: grid has every combination (5^inputs), shared one "
        "rule a set (5), concat one a set and input (20), per_joint a grid a joint (25 each)",
    )
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


def _add_numerics(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--dt",
        metavar="S",
        type=number,
        help="step and spacing of the record [s] (default: 0.001)",
    )
    add(
        "--method",
        choices=("rk4", "dp54"),
        help="rk4: fixed step. dp54: error control (default: rk4)",
    )


def _add_output(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--record-every",
        metavar="N",
        type=int,
        default=1,
        help="keep every so many steps only (default: 1)",
    )
    add("--plot", metavar="FILE", type=picture, help="draw the run (.png, .svg or .pdf)")
    add(
        "--save",
        metavar="FILE.npz",
        type=record,
        help="keep the run; steadyarm.Run.load reads it back",
    )


OVERRIDES = (
    "kp",
    "kv",
    "form",
    "normalized",
    "gain",
    "inputs",
    "leak_rate",
    "gamma",
    "duration",
    "dt",
    "method",
    "control_period",
)
"""Options of ``simulate`` that change the scene if they are given."""


def _simulate(arguments: argparse.Namespace) -> int:
    check_files(arguments.plot, arguments.save)
    try:
        scene = scene_of(arguments, arguments.simulation, OVERRIDES)
        run = scene.run(
            record_every=arguments.record_every,
            progress=sys.stderr.isatty() and scene.duration > PATIENCE,
        )
    except (ValueError, TypeError) as error:
        raise Refused(error) from error
    say(_report(run, arguments))
    if not len(run.t):
        return tell("nothing was recorded, and nothing is written", FAILED)
    _write(run, {"picture": arguments.plot, "record": arguments.save})
    return {"finished": 0, "interrupted": STOPPED}.get(run.status.kind, FAILED)


def _write(run: Run, files: dict[str, Path | None]) -> None:
    written: list[str] = []
    for kind, path in files.items():
        if path is None:
            continue
        try:
            if kind == "picture":
                run.plot().savefig(path)
            else:
                run.save(path)
        except KeyboardInterrupt:
            kept = f"; kept: {', '.join(written)}" if written else ""
            raise KeyboardInterrupt(f"{path} was not written{kept}") from None
        written.append(str(path))
        say(f"{kind:12}{path}")


PATIENCE = 200.0
"""Runs longer than this show a progress bar on a terminal [s]."""

METRICS = {
    "rms_e": "RMS error [rad]",
    "max_abs_e": "max |error| [rad]",
    "rms_tau": "RMS torque [N·m]",
    "max_abs_tau": "max |torque| [N·m]",
    "torque_variation": "torque variation [N·m/s]",
}
"""Names and units of the metrics."""


def _report(run: Run, arguments: argparse.Namespace) -> str:
    """What happened, in lines."""
    lines = [f"scene       {_scene(arguments)}", f"status      {run.status}"]
    if run.status.kind == "diverged" and "dt = " not in run.status.reason:
        lines += [f"            {_why(arguments)}"]
    if not len(run.t):
        return "\n".join(lines)
    end = float(run.t[-1])
    late, whole = run.metrics((end / 2, end)), run.metrics()
    joints = "".join(f"{f'joint {joint + 1}':>13}" for joint in range(run.joints))
    lines += ["", f"{'':46}{joints}"]
    for name, label in METRICS.items():
        second_half = name in ("rms_e", "rms_tau", "torque_variation")
        values = getattr(late if second_half else whole, name)
        when = f"{end / 2:.4g} to {end:.4g} s" if second_half else "whole run"
        figures = "".join(f"{value:13.6g}" for value in values)
        lines.append(f"{label:31}{when:>15}{figures}")
    return "\n".join([*lines, "", *_learnt(run, end), *_certified(run, arguments)])


def _scene(arguments: argparse.Namespace) -> str:
    """The scene, with what was changed in it."""
    if arguments.scenario is not None:
        words = [str(arguments.scenario)]
    else:
        words = [f"simulation {arguments.simulation}"]
        words += [f"preset {arguments.preset}"] * (arguments.simulation == 3)
    for name in OVERRIDES:
        value = getattr(arguments, name)
        if name == "normalized" and value is not None:
            words.append("normalized" if value else "raw")
        elif value is not None:
            shown = f"{value:g}" if isinstance(value, float) else str(value)
            words.append(f"{name.replace('_', ' ')} {shown}")
    return ", ".join(words)


def _why(arguments: argparse.Namespace) -> str:
    if arguments.control_period is not None:
        return "shorten --control-period or lower --gain: it learns too fast for its sampling"
    return "lower --gain or shorten --dt"


def _learnt(run: Run, end: float) -> list[str]:
    """How much of what the model leaves out the compensator makes up for, in the second half."""
    if run.weights is None or not run.status.finished:
        return []
    late = run.t >= end / 2
    left = ((run.rho - run.rho_hat)[late] ** 2).sum(axis=0)
    share = 1 - (left / (run.rho[late] ** 2).sum(axis=0)) ** 0.5
    figures = ", ".join(f"joint {n + 1} {100 * value:.1f} %" for n, value in enumerate(share))
    return [f"learnt      of what the model leaves out: {figures} (RMS of ρ)"]


def _certified(run: Run, arguments: argparse.Namespace) -> list[str]:
    """The dissipation identity in words."""
    certificate = run.certificate
    if certificate is None:
        sampled = arguments.control_period is not None
        why = "sampled control; ask steadyarm design" if sampled else "no compensator"
        return [f"certificate none: {why}"]
    gamma = 1.0 if arguments.gamma is None else float(arguments.gamma)
    bound = certificate.v_start + gamma**2 * certificate.uncertainty
    sign = "<=" if certificate.state_cost <= bound else ">, which must not be:"
    cost = f"∫x'Qx dt = {certificate.state_cost:.4g}"
    return [
        f"certificate Lyapunov identity kept to {certificate.residual:.1e} (relative)",
        f"            {cost} {sign} V(0) + γ²∫|ρ|² dt = {bound:.4g}",
    ]
