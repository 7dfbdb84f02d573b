"""The command ``steadyarm sweep``."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _sweep_tables, _toml
from ._extras import imported
from ._json import add_json, emit, written
from ._options import FAILED, STOPPED, Refused, check_files, command, picture, whole
from ._scenario_file import sections_of
from ._source import (
    ENDS,
    OF_ROBOT,
    add_robot,
    add_source,
    kind_of,
    names_help,
    refuse_given,
    refusing,
    scene_of,
)
from ._streams import tell
from ._sweep_folder import PLAN, RAISED
from ._sweep_plan import Plan, plan_of
from ._sweep_source import FileSource, source_of
from ._sweep_work import Source
from .sweep import Sweep, Worst, one_row, swept

if TYPE_CHECKING:
    from ._options import Commands

SHOWN = 5
"""Worst rows that are listed."""

OF_PLAN = ("over", "seeds", "executor", "retry")
"""Options that a folder has no use for."""


def add_sweep(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "sweep",
        "a scenario or your robot over loads, gains, noise, seeds: kept in a folder, and resumed",
        "Run a controller of a scenario for all combinations of the values that --over gives, and\n"
        "keep a row of figures of each in a folder, as Parquet. The same command again computes\n"
        "what is missing. A robot (a URDF, a TOML, or a name) is made a scenario as compare does.\n"
        "--over names keys of the scenario's file: payload, bandwidth, friction, noise, delay,\n"
        "actual.inertia_scale, controllers.pid.kp, …, and controller. With the folder of a sweep\n"
        "as SOURCE: its figures, its worst rows, and with --only one of them once more.\n\n"
        f"{names_help()}",
        _sweep,
        examples="  steadyarm sweep ur5e_payload --over controller=pid,rise --over payload=0:3:7\n"
        "  steadyarm sweep mine.toml --over noise=0,1e-5,1e-4 --seeds 20 --plot noise.png\n"
        "  steadyarm sweep robot.urdf --over payload=0:3:50 --executor dask://10.0.0.1:8786\n"
        "  steadyarm sweep results --plot map.png\n"
        "  steadyarm sweep results --only 123",
    )
    # None but for what `settle` does with `--json SOURCE`.
    add_source(parser, "a robot, a scenario, or the folder of a sweep", "?")
    add_robot(parser)
    _add_plan(parser.add_argument_group("what is swept"))
    _add_output(parser.add_argument_group("what is written"))


def _add_plan(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--over",
        metavar="NAME=VALUES",
        type=_values,
        action="append",
        help="values of one input: 0:3:50 is 50 values from 0 to 3, or a list a,b,c; give it once "
        "for each input, the last one runs fastest",
    )
    add("--seeds", metavar="N", type=int, help="each with so many seeds of noise, jitter, losses")
    add(
        "--executor",
        metavar="WHO",
        help="processes, dask, dask://host:port or ray (default: the threads of this process)",
    )
    add(
        "--retry",
        action="store_const",
        const=True,
        help="compute rows that raised again too",
    )
    add("--only", metavar="INDEX", type=whole, help="compute this row alone, and write nothing")


def _add_output(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--out",
        metavar="DIR",
        type=Path,
        help="the folder, made if it is not there (default: results)",
    )
    add("--by", metavar="FIGURE", help="what is drawn, and what worst means (default: the first)")
    drawn = "draw it over the inputs: bands over one, a map over two (.png, .svg or .pdf)"
    add("--plot", metavar="FILE", type=picture, help=drawn)
    add_json(add)


def _values(text: str) -> tuple[str, Any]:
    """An input and its values, as in payload=0:3:50 or controller=pid,robust."""
    name, equals, said = text.partition("=")
    found = re.fullmatch(r"([^:,]+):([^:,]+):(\d+)", said)
    if found is not None and int(found[3]) == 0:
        raise argparse.ArgumentTypeError(f"got {text!r}, wants at least one value, as in 0:3:1")
    try:
        if found is not None:
            return name, np.linspace(float(found[1]), float(found[2]), int(found[3]))
    except ValueError:
        found = None
    if not name or not equals or not said or (found is None and ":" in said):
        raise argparse.ArgumentTypeError(f"got {text!r}, wants name=0:3:50 or name=a,b,c")
    parts = [part.strip() for part in said.split(",")]
    for kind in (int, float):
        try:
            return name, [kind(part) for part in parts]
        except ValueError:
            continue
    truths = {"true": True, "false": False}
    return name, [truths[part] for part in parts] if set(parts) <= set(truths) else parts


def _sweep(arguments: argparse.Namespace) -> int:
    if arguments.source is None:
        raise Refused("SOURCE: is missing, wants a robot, a scenario, or the folder of a sweep")
    check_files(arguments.plot)
    imported("pyarrow", "a sweep")
    folder = Path(arguments.source)
    if (folder / PLAN).is_file():
        why = "wants a robot or a scenario as SOURCE; this is the folder of a sweep"
        refuse_given(arguments, (*OF_PLAN, *OF_ROBOT, *ENDS, "out"), why)
        with refusing("scenario", arguments.source):
            found = Sweep.read(folder)
            if arguments.only is not None:
                return _told(arguments, *found.repeated(arguments.only))
            return _shown(arguments, found)
    with refusing("scenario", arguments.source):
        kind_of(arguments.source)  # refuses what is nothing
        plan = _plan(arguments)
        source = _source(arguments, plan)
        if arguments.only is not None:
            if arguments.only >= plan.rows:
                raise Refused(f"--only: got {arguments.only}, wants one of {plan.rows}, from 0")
            point = plan.points(np.array([arguments.only]))[0]
            row = {"index": arguments.only, **point, **one_row(source, point)}
            return _told(arguments, row, None)
    try:
        out = arguments.out or Path("results")
        found = swept(source, plan, arguments.executor, out, retry=bool(arguments.retry))
    except (ValueError, TypeError) as error:
        raise Refused(error) from error
    except RuntimeError as error:
        return tell(str(error), FAILED)
    return _shown(arguments, found)


def _plan(arguments: argparse.Namespace) -> Plan:
    given = arguments.over or []
    over = dict(given)
    if len(over) < len(given):
        names = [name for name, _ in given]
        twice = next(name for name in names if names.count(name) > 1)
        raise Refused(f"--over: got an input twice, {twice}, wants each once")
    if not over and arguments.seeds is None:
        raise Refused("--over: is missing, wants an input and its values, such as payload=0:3:50")
    return plan_of(over, arguments.seeds)


def _source(arguments: argparse.Namespace, plan: Plan) -> Source:
    """The scenario's file; one is made of a robot."""
    if kind_of(arguments.source) != "robot":
        scene_of(arguments)  # refuses what is wrong with it, and options that are for a robot
        return source_of(arguments.source, plan.inputs, plan.seeded)
    if arguments.base is not None:
        raise Refused("--base: a scenario's file does not say it; steadyarm export makes a TOML")
    text = "\n".join(_toml.lines(sections_of(scene_of(arguments), arguments)))
    names = [name for name in plan.inputs if name != "seed"]
    return FileSource(text, Path(arguments.source).stem, names, plan.seeded)


def _shown(arguments: argparse.Namespace, found: Sweep) -> int:
    """Say what came out, and draw it."""
    try:
        cases = found.worst(SHOWN, arguments.by)
    except ValueError as error:
        raise Refused(f"--{error}") from error
    by = arguments.by or next(iter(found.figures), "status")
    words = f"{found}\n\n{_sweep_tables.worst(cases, by)}"
    emit(arguments, words, _plain(found, cases))
    if arguments.plot is not None and len(found):
        found.plot(value=arguments.by).savefig(arguments.plot)
        written(arguments, arguments.plot, "picture")
    if found.missing:
        return STOPPED
    counts = found.counts()
    return 0 if counts.get("finished") and not counts.get(RAISED) else FAILED


def _plain(found: Sweep, cases: list[Worst]) -> dict[str, Any]:
    return {
        "out": str(found.path),
        "rows": len(found),
        "missing": found.missing,
        "status": found.counts(),
        "figures": _sweep_tables.figures(found),
        "worst": [vars(case) for case in cases],
    }


def _told(arguments: argparse.Namespace, row: dict[str, Any], same: bool | None) -> int:
    """Say one row, and whether it is the one that was there."""
    lines = [f"{name:22} {value}" for name, value in row.items() if value != ""]
    if same is not None:
        lines.append("the same bits as before" if same else "NOT the bits of before")
    emit(arguments, "\n".join(lines), row if same is None else {**row, "same_bits": same})
    return FAILED if same is False else 0
