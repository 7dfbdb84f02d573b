"""The command ``steadyarm export``: a robot or a scenario as TOML, a run as a table."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from . import _core, _csv, _files
from ._extras import imported
from ._options import Refused, check_files, command
from ._play import loaded
from ._source import (
    ENDS,
    Kind,
    add_chain,
    add_load,
    add_source,
    arm_of,
    kind_of,
    names_help,
    refuse_given,
    refusing,
)
from ._streams import say
from .bench import BEYOND, LIBRARY, Scenario, scenario_names

if TYPE_CHECKING:
    from ._options import Commands
    from .run import Run

ENDINGS: dict[Kind, tuple[str, ...]] = {
    "robot": (".toml",),
    "scenario": (".toml",),
    "run": (".csv", ".parquet"),
}
"""What can be written of a kind of source."""

LOADS = ("payload", "armature")
"""Options of a robot that are written into its file."""


def add_export(commands: Commands) -> None:
    """Add the command."""
    parser = command(
        commands,
        "export",
        "a robot or a scenario as TOML, a run as CSV or Parquet",
        "Write a SOURCE in another form: a robot, from a URDF too, as TOML, with a payload and\n"
        "rotors if you say so; a scenario as TOML with every default written out; the file of a\n"
        "run as a table over time, .csv or .parquet.\n\n"
        f"{names_help()}",
        _export,
        examples="  steadyarm export robot.urdf --tip tool0 --armature 0.1 --out robot.toml\n"
        "  steadyarm export paper_sensors --out mine.toml\n"
        "  steadyarm export run.npz --out run.csv",
    )
    add_source(parser, "a robot, a scenario, or the file of a run (.npz)")
    add = parser.add_argument
    add("--out", metavar="FILE", type=Path, required=True, help=".toml; of a run .csv or .parquet")
    group = parser.add_argument_group("robot")
    add_chain(group)
    add_load(group, "5 cm beyond its tip, a part of the arm in the file (default: none)")


def _export(arguments: argparse.Namespace) -> int:
    source, out = arguments.source, arguments.out
    kind = kind_of(source)
    if out.suffix.lower() not in ENDINGS[kind]:
        wanted = " or ".join(ENDINGS[kind])
        raise Refused(f"--out: got {out}, wants a name that ends in {wanted}, for a {kind}")
    if kind != "robot":
        refuse_given(arguments, (*ENDS, *LOADS), "is for a robot alone")
    check_files(out)
    if kind == "robot":
        _files.text(out, _robot(arguments).to_toml())
    elif kind == "scenario":
        _files.text(out, _scenario(source))
    elif out.suffix.lower() == ".csv":
        loaded(source).to_csv(out)
    else:
        _parquet(loaded(source), out)
    say(f"{kind:12}{out}")
    return 0


def _robot(arguments: argparse.Namespace) -> _core.Serial:
    """The robot with what it carries."""
    arm = arm_of(arguments)
    with refusing("robot", arguments.source):
        if arguments.armature is not None:
            arm = arm.with_armature(arguments.armature)
        return arm if arguments.payload is None else arm.with_payload(arguments.payload, BEYOND)


def _scenario(source: str) -> str:
    """A scenario with every default, once it is seen that it can be built."""
    path = LIBRARY / f"{source}.toml" if source in scenario_names() else Path(source)
    with refusing("scenario", source):
        Scenario.read(path)
        return _core.canonical_scenario(path.read_text(encoding="utf-8"))


def _parquet(run: Run, path: Path) -> None:
    """All signals over time, with the columns of the CSV."""
    pandas = imported("pandas", "tables")
    imported("pyarrow", "Parquet")
    frame = pandas.DataFrame(_csv.table(run))
    _files.replace(path, lambda part: frame.to_parquet(part, index=False))
