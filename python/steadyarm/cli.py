"""The command ``steadyarm``.

A command is one function that adds its parser through `command`, which binds it to a function from
parsed arguments to exit code; `COMMANDS` lists them in the order of the help.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from . import __version__, _files, _streams, paper, reproduction
from ._compare import add_compare
from ._completion import add_completion
from ._design import add_design
from ._export import add_export
from ._extras import Missing
from ._json import settle, unanswered
from ._options import (
    FAILED,
    STOPPED,
    USAGE,
    Parser,
    Refused,
    check_apart,
    check_files,
    command,
    picture,
)
from ._play import add_play
from ._progress import Progress
from ._robots import add_robots
from ._scenario_file import add_scenario
from ._simulate import add_simulate
from ._streams import say, tell
from ._sweep import add_sweep

if TYPE_CHECKING:
    from ._options import Commands
    from .comparison import Comparison
    from .run import Run

DESCRIPTION = """\
Tracking control of robot arms whose dynamics nobody knows exactly: a model-based controller
(computed torque), plus a compensator that learns, while the arm moves, what the model leaves out.
This command says which controller your robot and your loop want, runs it on that robot with a
payload and friction that it does not know, and compares it with all others.
"""

EPILOG = """\
your robot, from its URDF:
  steadyarm robots robot.urdf                         what the file says, and what it lacks
  steadyarm design robot.urdf                         which controller, how fast must the loop be?
  steadyarm simulate robot.urdf --payload 2 --why     one run, and why the error is what it is
  steadyarm compare robot.urdf --payload 2            every controller, in one table
  steadyarm sweep robot.urdf --over payload=0:3:7     one controller, over loads, gains, noise
  steadyarm play robot.urdf --payload 2               the run as a page in the browser

a robot or a scene that comes with it, and the paper:
  steadyarm robots                                    their names
  steadyarm simulate panda --armature 0.1 --plot run.png
  steadyarm compare paper_sensors                     every rival on the paper's arm
  steadyarm scenario panda > mine.toml                a file to edit, for all of these commands
  steadyarm simulate --preset claimed --plot run.png  a run of the paper, drawn
  steadyarm reproduce                                 the paper and its rivals, with a verdict

symptoms, and the run that shows each:
  My model-based controller still has a tracking error.
      steadyarm simulate --simulation 2        the arm is twice as heavy as the controller thinks
      steadyarm simulate --preset claimed      the same arm; the compensator makes up for it
      steadyarm simulate panda_payload --controller pid --why
                                               why the error is what it is, cause by cause
  I added the compensator and nothing changed.
      steadyarm simulate --preset printed      the gain is too low for these rules
      steadyarm design --preset printed        says so beforehand, and which gain would do
      steadyarm simulate --gain 700            five rules with normalised strengths want this much
  It works in continuous time and blows up on the real controller.
      steadyarm design panda --armature 0.1 --control-period 0.01
                                               which controllers such a loop is too slow for
      steadyarm simulate --form concat --raw --gain 70 --control-period 0.04
                                               it learns too fast for 25 samples a second
      steadyarm design --form concat --raw --gain 70 --control-period 0.04
                                               refuses it, and says how fast the loop must be
  The torque jumps.
      add --plot run.png to any run: it draws the model's and the compensator's part of the torque;
      "variation" puts a number on it

"steadyarm <command> --help" explains the options, with examples. Exit code: 0 done, 1 failed (also
a run that blew up), 2 arguments that make no sense, 130 stopped with Ctrl-C.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    _streams.prepare()
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _warned
            code = _run(argv)
        _streams.finish()
    except OSError as error:
        file = error.filename or "the output"
        return tell(f"cannot write {file}: {error.strerror or error}", FAILED)
    except Refused as error:
        return tell(str(error), USAGE)
    except Missing as error:
        return tell(str(error), FAILED)
    except KeyboardInterrupt as error:
        return tell(f"stopped; {str(error) or 'nothing was written'}", STOPPED)
    return code


def _warned(message: Warning | str, *_: object, **__: object) -> None:
    """Say a warning without the place in the code that it comes from."""
    tell(f"note: {message}")


def _run(argv: Sequence[str] | None) -> int:
    parser = _parser()
    try:
        arguments, unknown = parser.parse_known_args(argv)
        if unknown:
            arguments.parser.unknown(unknown)
    except SystemExit as stop:  # after a help, or what is wrong with the arguments
        return int(stop.code or 0)
    if arguments.run is None:
        parser.print_help()
        return USAGE
    try:
        settle(arguments)
        check_apart(arguments)
        code: int = arguments.run(arguments)
    except (Refused, Missing, KeyboardInterrupt) as error:
        unanswered(arguments, error)
        raise
    return code


def _parser() -> Parser:
    parser = Parser(
        prog="steadyarm",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"steadyarm {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="<command>")
    parser.set_defaults(run=None, parser=parser)
    for add in COMMANDS:
        add(commands)
    return parser


# reproduce


def _add_reproduce(commands: Commands) -> None:
    parser = command(
        commands,
        "reproduce",
        "the paper's three simulations and its rivals: pictures, numbers and what they show",
        "Run the paper's simulations 1 to 3, 40 s each from rest, and every reading of the third:\n"
        "which rules, normalised or raw firing strengths, gain 1/7, 7 or 70. Then every rival on\n"
        "the paper's plant, with ideal sensors and with those of a real machine.\n\n"
        "Writes figure1.png to figure3.png in the paper's layout (figure3.png as printed),\n"
        "figure3_claimed.png, errors.png and results.json, and of the rivals compare.md,\n"
        "compare.csv and compare.html, a page; prints both tables and what they show.\n"
        "RMS errors are over 20 to 40 s, maxima over the whole run.",
        _reproduce,
        examples="  steadyarm reproduce --out results",
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("reproduce"),
        help="directory for the files, made if it is not there (default: reproduce)",
    )


FIGURES = {
    "simulation 1": ("figure1.png", "1. The model is exact: computed torque tracks"),
    "simulation 2": (
        "figure2.png",
        "2. Mass and inertia are twice the model's, with a disturbance: computed torque alone",
    ),
    "simulation 3, printed": (
        "figure3.png",
        "3. The same arm with the compensator as printed: 5 rules, normalised, gain 1/7",
    ),
    "simulation 3, claimed": (
        "figure3_claimed.png",
        "3. The same arm with the compensator as claimed: 625 rules, raw strengths, gain 7",
    ),
}
"""Files and titles of the figures in the paper's layout."""


def _reproduce(arguments: argparse.Namespace) -> int:
    from . import _rivals, plots

    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    check_files(out / "results.json")
    rows: list[reproduction.Row] = []
    drawn: dict[str, Run] = {}
    written: list[str] = []
    try:
        for case in _progress(list(reproduction.cases())):
            run = case.run()
            if run.status.kind == "interrupted":
                raise KeyboardInterrupt
            rows.append(case.row(run))
            if case.name in FIGURES:
                name, title = FIGURES[case.name]
                plots.paper_figure(run, title).savefig(out / name)
                written.append(name)
                drawn[case.name] = run
        drawn = {name: drawn[name] for name in FIGURES}
        plots.errors(drawn).savefig(out / "errors.png")
        written.append("errors.png")
        _files.text(out / "results.json", json.dumps(rows, indent=2, allow_nan=False) + "\n")
        written.append("results.json")
        rivals = _rivals.rivals()
        if any(row.status == "interrupted" for row in rivals.rows):
            raise KeyboardInterrupt
        written += _write_comparison(rivals, out)
    except KeyboardInterrupt:
        if not written:
            raise
        kept = f"kept in {out}: {', '.join(sorted(written))}"
        left = [name for name in ("results.json", *COMPARISON) if name not in written]
        missing = f"; {left[0]} was not written" if left else ""
        raise KeyboardInterrupt(kept + missing) from None
    say(reproduction.table(rows))
    say(f"\n{reproduction.verdict(rows)}")
    say(f"\n{rivals}")
    say(f"\nPictures and numbers are in {out}: {', '.join(sorted(written))}")
    return 0


COMPARISON = ("compare.md", "compare.csv", "compare.html")
"""Files of the comparison."""


def _write_comparison(rivals: Comparison, out: Path) -> list[str]:
    """Write its files; return their names."""
    _files.text(out / "compare.md", rivals.to_markdown())
    rivals.to_csv(out / "compare.csv")
    rivals.to_html(out / "compare.html", arm=paper.simulation(2).plant.arm)
    return list(COMPARISON)


def _progress(cases: list[reproduction.Case]) -> Iterator[reproduction.Case]:
    """The cases, with a progress bar on a terminal."""
    if not sys.stderr.isatty():
        tell(f"running {len(cases)} simulations of 40 s")
        yield from cases
        return
    with Progress(len(cases), "runs") as bar:
        for number, case in enumerate(cases):
            bar.to(number)
            yield case
        bar.to(len(cases))


# approximate


def _add_approximate(commands: Commands) -> None:
    parser = command(
        commands,
        "approximate",
        "how the largest error of a fuzzy fit falls with the number of rules",
        "Fit fuzzy systems of 4 to 576 rules to g(x, y) = sin(2x + cos y) exp(-y²/4) on [-2, 2]²\n"
        "and print the largest error on a fine grid of other points: the paper's statement (5),\n"
        "that enough rules come as close as you like to any continuous function.",
        _approximate,
        examples="  steadyarm approximate --out approximation.png",
    )
    parser.add_argument("--out", metavar="FILE", type=picture, help="draw it (.png, .svg or .pdf)")


def _approximate(arguments: argparse.Namespace) -> int:
    check_files(arguments.out)
    rows = []
    say("  rules   largest error")
    for rules, error in reproduction.approximation():
        say(f"{rules:7}   {error:13.3g}")
        rows.append((rules, error))
    first, last = rows[0], rows[-1]
    say(
        f"\n{last[0] / first[0]:.0f} times the rules, {first[1] / last[1]:.0f} times less error "
        "(g reaches from -1 to 1, its unit is 1)."
    )
    if arguments.out is not None:
        from . import plots

        plots.approximation(rows).savefig(arguments.out)
        say(f"The picture is {arguments.out}")
    return 0


def _add_completion(commands: Commands) -> None:
    add_completion(commands, _parser)


COMMANDS: tuple[Callable[[Commands], None], ...] = (
    add_robots,
    add_design,
    add_simulate,
    add_compare,
    add_sweep,
    add_play,
    add_export,
    add_scenario,
    _add_reproduce,
    _add_approximate,
    _add_completion,
)
"""The commands, in the order of the help."""

if __name__ == "__main__":
    sys.exit(main())
