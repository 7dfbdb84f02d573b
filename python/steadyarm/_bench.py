"""The commands ``steadyarm run`` and ``steadyarm compare``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._options import (
    FAILED,
    STOPPED,
    Refused,
    check_files,
    command,
    names,
    number,
    numbers,
    picture,
    record,
)
from ._sections import load_robot
from ._streams import say
from .attribution import attribution
from .bench import Scenario, compare, scenario_names
from .comparison import Comparison, Row
from .run import Run

if TYPE_CHECKING:
    from ._options import Commands

ROBOTS = (".urdf", ".xml")
"""Endings of files that are robots, and no scenarios."""


def add_run(commands: Commands) -> None:
    """Add the command ``run``."""
    parser = command(
        commands,
        "run",
        "one controller of a scenario: how it ended, the error, the torque",
        "Run one controller of a scenario, a TOML file or one that comes with the package:\n"
        f"{_listed()}",
        _run,
    )
    add_source(parser)
    add = parser.add_argument
    add("--controller", metavar="NAME", help="which one (default: the first by name)")
    add("--seed", metavar="N", type=int, help="seed of noise, jitter, lost samples")
    add("--plot", metavar="FILE", type=picture, help="draw the run (.png, .svg or .pdf)")
    add("--save", metavar="FILE.npz", type=record, help="keep the run")
    add("--why", action="store_true", help="why the error is what it is, by cause")
    add("--why-plot", metavar="FILE", type=picture, help="the same, drawn")


def add_compare(commands: Commands) -> None:
    """Add the command ``compare``."""
    parser = command(
        commands,
        "compare",
        "every controller of a scenario, or on your robot, in one table",
        "Run all controllers of a scenario and print one table, sorted by the steady error.\n"
        "A scenario is a TOML file, or one that comes with the package:\n"
        f"{_listed()}\n\n"
        "A robot, a URDF file or the name of a shipped one (panda, ur5e, puma560), is compared\n"
        "with sensors, friction and --payload that no controller knows of.",
        _compare,
    )
    add_source(parser)
    add = parser.add_argument
    add("--only", metavar="NAME,…", type=names, help="these controllers alone")
    add("--seeds", metavar="N", type=int, default=1, help="number of seeds (default: 1)")
    add("--workers", metavar="N", type=int, help="threads (default: one a core)")
    add("--csv", metavar="FILE", type=Path, help="write all rows as CSV")
    add("--json", metavar="FILE", type=Path, help="write all rows as JSON")
    add("--markdown", action="store_true", help="print the table in Markdown")
    add("--html", metavar="FILE", type=Path, help="write one page: table, curves, Pareto plot")


def add_source(parser: argparse.ArgumentParser, **count: Any) -> None:
    """Add the scenario and what makes one of a robot; ``count``: how often, as argparse has it."""
    add = parser.add_argument
    words = "a TOML file, a name that comes with the package, or a robot"
    add("source", metavar="SCENARIO", help=words, **count)
    add("--payload", metavar="KG", type=number, help="of a robot (default: 2)")
    add(
        "--bandwidth",
        metavar="P",
        type=number,
        help="of all controllers on a robot [rad/s] (default: 15)",
    )
    add(
        "--armature",
        metavar="J",
        type=numbers,
        help="rotors of a robot that the controllers know of [kg·m²], one or one a joint "
        "(default: as the file says)",
    )
    add("--tip", metavar="LINK", help="the end of a robot's chain, where a file has several")


def _listed() -> str:
    return "\n".join(f"  {name}" for name in scenario_names())


def scene_of(arguments: argparse.Namespace) -> Scenario:
    """The scenario that was asked for; one is made for a robot."""
    source = arguments.source
    try:
        shipped = source not in scenario_names() and Path(source).suffix == ""
        if Path(source).suffix.lower() in ROBOTS or (shipped and not Path(source).exists()):
            arm = load_robot(source, arguments.tip)
            name = Path(source).stem
            return Scenario.of_robot(
                arm,
                name=name,
                **{"payload": 2.0, **_given(arguments)},
            )
        given = [*_given(arguments), *(["tip"] if arguments.tip else [])]
        if given:
            raise Refused(f"--{given[0]}: for a robot alone; a scenario says it in its file")
        return Scenario.read(source)
    except OSError as error:
        raise Refused(f"scenario: cannot read {source}: {error.strerror or error}") from error
    except (ValueError, TypeError) as error:
        if str(error).startswith("shipped arm: "):
            names = ", ".join(scenario_names())
            raise Refused(f"scenario: got {source!r}, wants one of {names}; or {error}") from error
        raise Refused(error) from error


def _given(arguments: argparse.Namespace) -> dict[str, Any]:
    """What was said of a robot."""
    of_robot = {name: getattr(arguments, name) for name in ("payload", "bandwidth", "armature")}
    return {name: value for name, value in of_robot.items() if value is not None}


def _run(arguments: argparse.Namespace) -> int:
    check_files(arguments.plot, arguments.save, arguments.why_plot)
    scene = scene_of(arguments)
    name = arguments.controller or next(iter(scene.controllers))
    if name not in scene.controllers:
        raise Refused(f"--controller: got {name!r}, wants one of {', '.join(scene.controllers)}")
    try:
        run = scene.simulate(name, seed=arguments.seed)
    except (ValueError, TypeError) as error:
        raise Refused(f"{name}: {error}") from error
    say(f"scenario    {scene.title}\ncontroller  {name}\nstatus      {run.status}")
    limit = scene.plant.effort_limit
    row = Row.of(
        run,
        controller=name,
        scenario=scene.name,
        window=scene.window,
        band=scene.band,
        events=scene.events,
        effort_limit=limit if np.isfinite(limit).any() else None,
        curves=False,
    )
    say(str(Comparison([row], scene.title)))
    for kind, path in (("picture", arguments.plot), ("record", arguments.save)):
        if path is not None:
            run.plot().savefig(path) if kind == "picture" else run.save(path)
            say(f"{kind:12}{path}")
    if arguments.why or arguments.why_plot is not None:
        _say_why(run, scene.window, arguments.why_plot)
    return {"finished": 0, "interrupted": STOPPED}.get(run.status.kind, FAILED)


def _say_why(run: Run, window: tuple[float, float] | None, path: Path | None) -> None:
    """Why the error is what it is in the window of the steady figures."""
    window = (0.5 * run.t[-1], run.t[-1]) if window is None else window
    try:
        found = attribution(run, window=window)
    except ValueError as error:  # of a run that ended early
        say(f"why         {error}")
        return
    say(f"\n{found}")
    if path is not None:
        found.plot().savefig(path)
        say(f"{'picture':12}{path}")


def _compare(arguments: argparse.Namespace) -> int:
    check_files(arguments.csv, arguments.json, arguments.html)
    scene = scene_of(arguments)
    only = [arguments.only] if isinstance(arguments.only, str) else arguments.only
    try:
        table = compare(scene, only=only, seeds=arguments.seeds, workers=arguments.workers)
    except (ValueError, TypeError) as error:
        raise Refused(error) from error
    say(table.to_markdown() if arguments.markdown else f"{scene.title}\n\n{table}")
    writers: list[tuple[Path | None, Any]] = [
        (arguments.csv, table.to_csv),
        (arguments.json, table.to_json),
        (arguments.html, lambda path: table.to_html(path, arm=scene.nominal)),
    ]
    for path, write in writers:
        if path is not None:
            write(path)
            say(f"written     {path}")
    statuses = {row.status for row in table.rows}
    if "interrupted" in statuses:
        return STOPPED
    return 0 if "finished" in statuses else FAILED
