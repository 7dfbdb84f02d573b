"""The command ``steadyarm play``: a run as a page in the browser, or as a film."""

from __future__ import annotations

import argparse
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._extras import imported
from ._options import FAILED, Refused, check_files, command, file_of, number, positive, record
from ._simulate import OF_SOURCE, add_law, simulated
from ._source import add_robot, add_source, kind_of, names_help, refuse_given
from ._streams import say, tell
from .run import Run

if TYPE_CHECKING:
    from ._options import Commands

PAGE, FILMS = ".html", (".gif", ".mp4")
"""Endings of what can be written."""


def add_play(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "play",
        "a run as a page in the browser, the arm in motion; of your robot too",
        "Write the page of a run, or its film, and open it. SOURCE is the file of a run, as\n"
        "simulate --save writes it, or a robot or a scenario, which is run first.\n\n"
        f"{names_help()}",
        _play,
        examples="  steadyarm play robot.urdf --payload 2 --tip tool0\n"
        "  steadyarm play run.npz --against other.npz\n"
        "  steadyarm play panda_payload --controller pid --out pid.gif --no-open",
    )
    add_source(parser, "the file of a run (.npz), a robot, or a scenario")
    add = parser.add_argument
    add(
        "--against", metavar="FILE.npz", type=record, help="another run, on the same page beside it"
    )
    add(
        "--out",
        metavar="FILE",
        type=_shown,
        help="where to: .html, .gif or .mp4 (default: the SOURCE's name with .html, here)",
    )
    add("--speed", metavar="X", type=number, help="of a film: seconds of the run in a second of it")
    add("--no-open", action="store_true", help="write it, and open no browser")
    add_robot(parser)
    loop = parser.add_argument_group("controller and loop")
    add_law(loop)
    words = {"--control-period": "period of the loop [s]", "--duration": "length [s]"}
    for name, said in words.items():
        loop.add_argument(name, metavar="S", type=positive, help=f"{said} (default: the SOURCE's)")


def _shown(text: str) -> Path:
    path = file_of(text, (PAGE, *FILMS))
    if path.suffix.lower() in FILMS:
        imported("matplotlib", "films")
    return path


def _play(arguments: argparse.Namespace) -> int:
    source: str = arguments.source
    out: Path = arguments.out or Path(f"{Path(source).stem}{PAGE}")
    film = out.suffix.lower() in FILMS
    if film and arguments.against is not None:
        raise Refused("--against: wants a page, such as --out run.html, for a film has one run")
    if arguments.speed is not None and not film:
        raise Refused("--speed: wants a film, such as --out run.gif; a page has a knob for it")
    check_files(out)
    other = None if arguments.against is None else loaded(str(arguments.against))
    run, arm = _run_of(arguments)
    if film and arm is None:
        raise Refused(f"{source}: does not say which arm it is of, as a film wants; simulate it")
    if not len(run.t):
        return tell(f"nothing was recorded, and {out} is not written", FAILED)
    try:
        if film:
            run.animate(arm, out, speed=1.0 if arguments.speed is None else arguments.speed)
        else:
            run.to_html(out, against=other)
    except (ValueError, TypeError, RuntimeError) as error:
        raise Refused(error) from error
    say(f"{'film' if film else 'page':12}{out}")
    if not arguments.no_open and not webbrowser.open(out.resolve().as_uri()):
        tell(f"no browser was found; open {out} in one")
    return 0


def _run_of(arguments: argparse.Namespace) -> tuple[Run, Any]:
    """The run that is shown, and its arm; None: it is not known."""
    if kind_of(arguments.source) != "run":
        scene, _, run = simulated(arguments)
        if run.status.kind == "interrupted":
            raise KeyboardInterrupt
        return run, scene.plant.arm
    alone = (*OF_SOURCE, "control_period", "duration")
    refuse_given(arguments, alone, "is for a robot or a scenario; a run is what it is")
    run = loaded(arguments.source)
    return run, None if run._made is None else run._made.plant().arm


def loaded(source: str) -> Run:
    """The run in a file."""
    try:
        return Run.load(source)
    except OSError as error:
        raise Refused(f"cannot read {source}: {error.strerror or error}") from error
    except ValueError as error:
        raise Refused(f"{source}: {error}") from error
