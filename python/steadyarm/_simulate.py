"""The command ``steadyarm simulate``: one run, of a robot, of a scenario, or of the paper."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._design_scene import loop_words
from ._json import add_json, emit, written
from ._options import (
    FAILED,
    STOPPED,
    Refused,
    check_files,
    command,
    file_of,
    number,
    picture,
    positive,
    record,
    whole,
)
from ._paper_scene import (
    SHARED,
    add_compensator,
    add_feedback,
    add_scenario,
    paper_scene,
    preset,
)
from ._report import Report, finite, why
from ._source import (
    ENDS,
    OF_ROBOT,
    add_robot,
    add_source,
    in_loop,
    kind_of,
    names_help,
    refuse_given,
    refusing,
    scene_of,
)
from ._streams import tell

if TYPE_CHECKING:
    from ._options import Commands
    from .bench import Scenario
    from .run import Run


def add_simulate(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "simulate",
        "one run, of your robot too: how it ended, the error, the torque, and why",
        "Run one controller once. SOURCE is a robot (a URDF, a TOML, or a name) or a scenario (a\n"
        "TOML, or a name). A robot gets a payload, friction, 16-bit encoders and torques a sample\n"
        "late, of which no controller knows; without a SOURCE it is the paper's arm.\n"
        'A value for each joint is written "7,70"; fractions like 1/7 are understood.\n\n'
        f"{names_help()}",
        _simulate,
        examples="  steadyarm simulate robot.urdf --payload 2 --tip tool0\n"
        "  steadyarm simulate robot.urdf --armature 0.1 --plot run.png --why\n"
        "  steadyarm simulate panda_payload --controller pid --why\n"
        "  steadyarm simulate panda --json | jq .steady_rms_e\n"
        "  steadyarm simulate --preset claimed --plot run.png",
        aliases=("run",),
    )
    add_source(parser, "a robot or a scenario (default: the paper's arm)", "?")
    add_robot(parser)
    _add_loop(parser.add_argument_group("controller and loop"))
    _add_output(parser.add_argument_group("output"))
    _add_scene(parser.add_argument_group("the paper's arm, or another of two joints"))
    add_compensator(parser.add_argument_group("its compensator (simulation 3)"))


def add_law(group: argparse._ArgumentGroup | argparse.ArgumentParser) -> None:
    """Add which controller of a SOURCE runs."""
    group.add_argument(
        "--controller",
        metavar="NAME",
        help="which one of a SOURCE (default: recommended, or else the first by name)",
    )
    seed = "of noise, jitter, lost samples of a SOURCE (default: the scenario's)"
    group.add_argument("--seed", metavar="N", type=whole, help=seed)


def _add_loop(group: argparse._ArgumentGroup) -> None:
    add_law(group)
    add = group.add_argument
    add(
        "--control-period",
        metavar="S",
        type=positive,
        help="the controller steps once every so many seconds and holds its torque, as on a real "
        "machine (default: 0.001 for a robot, continuous for the paper's arm)",
    )
    usual = "length [s] (default: 12 for a robot, 40 for the paper's arm)"
    add("--duration", metavar="S", type=number, help=usual)


def _add_scene(group: argparse._ArgumentGroup) -> None:
    add_scenario(group)
    add = group.add_argument
    add(
        "--simulation",
        type=int,
        choices=(1, 2, 3),
        help="1: the model is exact. 2: the arm is twice as heavy as the model, with a "
        "disturbance. 3: the same, with the compensator (default)",
    )
    add_feedback(group)
    add("--dt", metavar="S", type=number, help="step and spacing of the record (default: 0.001 s)")
    add(
        "--method",
        choices=("rk4", "dp54"),
        help="rk4: fixed step. dp54: error control (default: rk4)",
    )


def _add_output(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    every = "keep every so many steps only (default: 1)"
    add("--record-every", metavar="N", type=int, default=1, help=every)
    add("--why", action="store_true", help="why the error is what it is, by cause")
    add("--why-plot", metavar="FILE", type=picture, help="the same, drawn")
    add("--plot", metavar="FILE", type=picture, help="draw the run (.png, .svg or .pdf)")
    add(
        "--save",
        metavar="FILE.npz",
        type=record,
        help="keep the run, for steadyarm play and export, and steadyarm.Run.load",
    )
    add("--csv", metavar="FILE", type=Path, help="write all signals over time")
    add("--html", metavar="FILE", type=_page, help="write a page to look at the run in a browser")
    add_json(add)


def _page(text: str) -> Path:
    return file_of(text, (".html",))


OVERRIDES = (*SHARED, "duration", "dt", "method", "control_period")
"""Options that change the paper's scene if they are given."""

OF_PAPER = ("scenario", "preset", "simulation", *SHARED, "dt", "method")
"""Options that a SOURCE has no use for."""

OF_SOURCE = (*OF_ROBOT, *ENDS, "controller", "seed")
"""Options that wants a SOURCE."""

FILES: tuple[tuple[str, str, Callable[[Any, Path], Any]], ...] = (
    ("plot", "picture", lambda run, path: run.plot().savefig(path)),
    ("save", "record", lambda run, path: run.save(path)),
    ("csv", "table", lambda run, path: run.to_csv(path)),
    ("html", "page", lambda run, path: run.to_html(path)),
)
"""What is written of a run, in this order: the option, what it is called, and how."""

PATIENCE = 60.0
"""Runs longer than this show a progress bar on a terminal [s]."""


def _simulate(arguments: argparse.Namespace) -> int:
    check_files(arguments.why_plot, *(getattr(arguments, option) for option, *_ in FILES))
    report = _of_paper(arguments) if arguments.source is None else _of_source(arguments)
    run, words, found = report.run, report.words(), report.plain()
    asked = arguments.why or arguments.why_plot is not None
    if asked and len(run.t) and run.status.kind != "interrupted":  # who stops it wants no more
        more, because = why(report, arguments.why_plot)
        words, found = f"{words}\n{more}", found | because
    emit(arguments, words, found)
    if not len(run.t):
        return tell("nothing was recorded, and nothing is written", FAILED)
    if arguments.why_plot is not None and found.get("why") is not None:
        written(arguments, arguments.why_plot, "picture")
    _write(run, arguments)
    return {"finished": 0, "interrupted": STOPPED}.get(run.status.kind, FAILED)


def patient(duration: float) -> bool:
    """Whether a run of this length [s] shows how far it is."""
    return sys.stderr.isatty() and duration > PATIENCE


def simulated(arguments: argparse.Namespace, **options: Any) -> tuple[Scenario, str, Run]:
    """Run one controller of a SOURCE; return its scene, the controller's name and the run."""
    scene = scene_of(arguments)
    scene = in_loop(
        scene,
        getattr(arguments, "control_period", None),
        duration=getattr(arguments, "duration", None),
    )
    usual = "recommended" if "recommended" in scene.controllers else next(iter(scene.controllers))
    name = arguments.controller or usual
    if name not in scene.controllers:
        raise Refused(f"--controller: got {name!r}, wants one of {', '.join(scene.controllers)}")
    options["progress"] = patient(scene.options["duration"])
    with refusing(kind_of(arguments.source), arguments.source, name):
        return scene, name, scene.simulate(name, seed=arguments.seed, **options)


def _of_source(arguments: argparse.Namespace) -> Report:
    """The run of a robot or a scenario."""
    refuse_given(arguments, OF_PAPER, "wants no SOURCE beside it, which says that itself")
    scene, name, run = simulated(arguments, record_every=arguments.record_every)
    period, delay = scene.options.get("control_period"), scene.front.get("delay", 0)
    asked = {
        "scenario": scene.name,
        "title": scene.title,
        "controller": name,
        "seed": arguments.seed,
        "control_period": period,
        "delay": delay,
        "duration": scene.options["duration"],
    }
    return Report(
        run,
        {"scenario": scene.title, "controller": name, "loop": loop_words(period, delay)},
        asked,
        scene.window,
        scene.band,
        finite(scene.plant.effort_limit),
        scene.events,
        arm=scene.plant.arm,
    )


def _of_paper(arguments: argparse.Namespace) -> Report:
    """The run of the paper's arm, or of a file of such an arm."""
    refuse_given(arguments, OF_SOURCE, "wants a SOURCE: a robot, or a scenario with controllers")
    arguments.simulation = arguments.simulation or 3
    try:
        scene = paper_scene(arguments, arguments.simulation, OVERRIDES)
        run = scene.run(record_every=arguments.record_every, progress=patient(scene.duration))
    except (ValueError, TypeError) as error:
        raise Refused(error) from error
    head = {"scene": _scene(arguments)}
    if run.status.kind == "diverged" and "dt = " not in run.status.reason:
        head["advice"] = _advice(arguments)
    asked = {
        "scenario": head["scene"],
        "controller": "recommended" if preset(arguments) == "recommended" else "computed_torque",
        "control_period": scene.options.get("control_period"),
        "duration": scene.duration,
    }
    tail = [*_learnt(run), *_certified(run, arguments)] if len(run.t) else []
    return Report(run, head, asked, tail=tail)


def _write(run: Run, arguments: argparse.Namespace) -> None:
    done: list[str] = []
    for option, kind, write in FILES:
        path = getattr(arguments, option)
        if path is None:
            continue
        try:
            write(run, path)
        except KeyboardInterrupt:
            kept = f"; kept: {', '.join(done)}" if done else ""
            raise KeyboardInterrupt(f"{path} was not written{kept}") from None
        done.append(str(path))
        written(arguments, path, kind)


def _scene(arguments: argparse.Namespace) -> str:
    """The scene, with what was changed in it."""
    if arguments.scenario is not None:
        words = [str(arguments.scenario)]
    else:
        words = [f"simulation {arguments.simulation}"]
        words += [f"preset {preset(arguments)}"] * (arguments.simulation == 3)
    for name in OVERRIDES:
        value = getattr(arguments, name)
        if name == "normalized" and value is not None:
            words.append("normalized" if value else "raw")
        elif value is not None:
            shown = f"{value:g}" if isinstance(value, float) else str(value)
            words.append(f"{name.replace('_', ' ')} {shown}")
    return ", ".join(words)


def _advice(arguments: argparse.Namespace) -> str:
    if arguments.control_period is not None:
        return "shorten --control-period or lower --gain: it learns too fast for its sampling"
    return "lower --gain or shorten --dt"


def _learnt(run: Run) -> list[str]:
    """How much of what the model leaves out the compensator makes up for, in the second half."""
    if run.weights is None or not run.status.finished:
        return []
    late = run.t >= run.t[-1] / 2
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
