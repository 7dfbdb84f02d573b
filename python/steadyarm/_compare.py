"""The command ``steadyarm compare``."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _comparison_files
from ._json import STDOUT, add_json, emit, written
from ._options import FAILED, STOPPED, Refused, check_files, command, names
from ._source import add_robot, add_source, names_help, scene_of
from .bench import compare

if TYPE_CHECKING:
    from ._options import Commands


def add_compare(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "compare",
        "every controller on your robot, or of a scenario, in one table",
        "Run all controllers of a scenario and print one table, sorted by the steady error.\n"
        "A scenario is a TOML file, or a name. A robot (a URDF, a TOML, or a name) is compared\n"
        "with sensors, friction and a --payload that no controller knows of.\n\n"
        f"{names_help()}",
        _compare,
        examples="  steadyarm compare robot.urdf --payload 2 --html page.html\n"
        "  steadyarm compare robot.urdf --only recommended,pid --seeds 5\n"
        "  steadyarm compare paper_sensors --csv table.csv\n"
        "  steadyarm compare panda --json | jq '.rows[] | [.controller, .steady_rms_e]'",
    )
    # None but for what `settle` does with `--json SOURCE`.
    add_source(parser, "a robot or a scenario", "?")
    add_robot(parser)
    group = parser.add_argument_group("what runs, and what is written")
    add = group.add_argument
    add("--only", metavar="NAME,…", type=names, help="these controllers alone")
    add("--seeds", metavar="N", type=int, default=1, help="number of seeds (default: 1)")
    add("--workers", metavar="N", type=int, help="threads (default: one a core)")
    add("--csv", metavar="FILE", type=Path, help="write all rows as CSV")
    add_json(add)
    add("--markdown", action="store_true", help="print the table in Markdown")
    add("--html", metavar="FILE", type=Path, help="write one page: table, curves, Pareto plot")


def _compare(arguments: argparse.Namespace) -> int:
    if arguments.source is None:
        raise Refused("SOURCE: is missing, wants a robot or a scenario")
    if arguments.markdown and arguments.json == STDOUT:
        raise Refused("--markdown: wants no --json beside it, which prints too")
    check_files(arguments.csv, arguments.html)
    scene = scene_of(arguments)
    only = [arguments.only] if isinstance(arguments.only, str) else arguments.only
    try:
        table = compare(scene, only=only, seeds=arguments.seeds, workers=arguments.workers)
    except (ValueError, TypeError) as error:
        raise Refused(error) from error
    words = table.to_markdown() if arguments.markdown else f"{scene.title}\n\n{table}"
    emit(arguments, words, _comparison_files.json_of(table))
    writers: list[tuple[Path | None, Callable[[Path], Any]]] = [
        (arguments.csv, table.to_csv),
        (arguments.html, lambda path: table.to_html(path, arm=scene.nominal)),
    ]
    for path, write in writers:
        if path is not None:
            write(path)
            written(arguments, path)
    statuses = {row.status for row in table.rows}
    if "interrupted" in statuses:
        return STOPPED
    return 0 if "finished" in statuses else FAILED
