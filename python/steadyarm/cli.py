"""The command ``steadyarm``.

A command is one function ``_add_…(commands)`` that adds its parser and sets ``run``, a function from
the parsed arguments to the exit code; `COMMANDS` lists them in the order of the help.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import __version__, _files, paper, reproduction

if TYPE_CHECKING:
    from .run import Run

    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

FAILED, USAGE, STOPPED = 1, 2, 130
"""Exit codes: something went wrong; the arguments make no sense; Ctrl-C."""

DESCRIPTION = """\
Tracking control of robot arms whose dynamics nobody knows exactly: a model-based controller
(computed torque), plus a fuzzy compensator that learns, while the arm moves, what the model leaves
out. This command runs the scenes of the paper, a two-joint arm; for your own arm use the Python or
Rust package.
"""

EPILOG = """\
try:
  steadyarm reproduce                                 the paper's three simulations, with a verdict
  steadyarm simulate --preset claimed --plot run.png  one run, drawn
  steadyarm approximate --out approximation.png       how well rules can learn a function

symptoms, and the run that shows each:
  My model-based controller still has a tracking error.
      steadyarm simulate --simulation 2        the arm is twice as heavy as the controller thinks
      steadyarm simulate --preset claimed      the same arm; the compensator makes up for it
  I added the compensator and nothing changed.
      steadyarm simulate --preset printed      the gain is too low for these rules
      steadyarm simulate --gain 700            five rules with normalised strengths want this much
  It works in continuous time and blows up on the real controller.
      steadyarm simulate --form concat --raw --gain 70 --control-period 0.04
                                               it learns too fast for 25 samples a second
  The torque jumps.
      add --plot run.png to any run: it draws the model's and the compensator's part of the torque;
      "torque variation" puts a number on it

"steadyarm <command> --help" explains the options. Exit code: 0 done, 1 failed (also a run that
blew up), 2 arguments that make no sense, 130 stopped with Ctrl-C.
"""


class _Refused(Exception):
    """Arguments that the library refuses."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    arguments = _parser().parse_args(argv)
    try:
        code: int = arguments.run(arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except OSError as error:
        file = f"{error.filename}: " if error.filename else ""
        return _complain(f"cannot write {file}{error.strerror or error}", FAILED)
    except _Refused as error:
        return _complain(str(error), USAGE)
    except KeyboardInterrupt as error:
        return _complain(f"stopped; {error or 'nothing was written'}", STOPPED)
    return code


def _complain(message: str, code: int) -> int:
    print(f"steadyarm: {message}", file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="steadyarm",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"steadyarm {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="<command>", required=True)
    for add in COMMANDS:
        add(commands)
    return parser


def _command(
    commands: Commands, name: str, summary: str, details: str, run: Callable[[Any], int]
) -> argparse.ArgumentParser:
    """Add a command: ``summary`` for the list of commands, ``details`` for its own help."""
    parser = commands.add_parser(
        name,
        help=summary,
        description=details,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    return parser


# reproduce


def _add_reproduce(commands: Commands) -> None:
    parser = _command(
        commands,
        "reproduce",
        "the paper's three simulations: pictures, numbers and what they show",
        "Run the paper's simulations 1 to 3 (40 s each, from rest) and every reading of the third:\n"
        "which rules, normalised or raw firing strengths, gain 1/7, 7 or 70. Takes some seconds.\n\n"
        "Writes figure1.png to figure3.png in the paper's layout (figure3.png as printed),\n"
        "figure3_claimed.png, errors.png and results.json; prints the table and a verdict.\n"
        "RMS errors are over 20 to 40 s, maxima over the whole run.",
        _reproduce,
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
    from . import plots

    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
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
                _files.picture(out / name, plots.paper_figure(run, title))
                written.append(name)
                drawn[case.name] = run
        drawn = {name: drawn[name] for name in FIGURES}
        _files.picture(out / "errors.png", plots.errors(drawn))
        written.append("errors.png")
        _files.text(out / "results.json", json.dumps(rows, indent=2, allow_nan=False) + "\n")
        written.append("results.json")
    except KeyboardInterrupt:
        kept = f"kept in {out}: {', '.join(sorted(written))}" if written else "nothing was written"
        missing = "" if "results.json" in written else "; results.json was not written"
        raise KeyboardInterrupt(kept + missing) from None
    print(reproduction.table(rows))
    print(f"\n{reproduction.verdict(rows)}")
    print(f"\nPictures and numbers are in {out}: {', '.join(sorted(written))}")
    return 0


def _progress(cases: list[reproduction.Case]) -> Iterator[reproduction.Case]:
    """The cases, with a progress bar on a terminal."""
    if not sys.stderr.isatty():
        print(f"running {len(cases)} simulations of 40 s", file=sys.stderr)
        yield from cases
        return
    from tqdm import tqdm

    bar: Iterable[reproduction.Case] = tqdm(cases, unit="run", leave=False, file=sys.stderr)
    yield from bar


# simulate


def _add_simulate(commands: Commands) -> None:
    parser = _command(
        commands,
        "simulate",
        "one run: how it ended, the error, the torque, the certificate",
        "Run one scene of the paper. What you do not give is the paper's. A value for each joint is\n"
        'written "7,70"; fractions like 1/7 are understood.',
        _simulate,
    )
    add = parser.add_argument
    scene = parser.add_argument_group("scene")
    add = scene.add_argument
    add(
        "--simulation",
        type=int,
        choices=(1, 2, 3),
        default=3,
        help="1: the model is exact. 2: the arm is twice as heavy as the model, with a disturbance. "
        "3: the same, with the compensator (default)",
    )
    add("--duration", metavar="S", type=_number, help="length [s] (default: 40)")
    controller = parser.add_argument_group("controller")
    add = controller.add_argument
    add("--kp", metavar="K", type=_numbers, help="feedback on position [1/s²] (default: 8)")
    add("--kv", metavar="K", type=_numbers, help="feedback on velocity [1/s] (default: 5.5)")
    add(
        "--control-period",
        metavar="S",
        type=_number,
        help="the controller steps once every so many seconds and holds its torque, as on a real "
        "machine (default: continuous, as in the paper)",
    )
    compensator = parser.add_argument_group("compensator (simulation 3)")
    add = compensator.add_argument
    add(
        "--preset",
        choices=tuple(paper.PRESETS),
        default="printed",
        help="how the paper is read: printed is inert, claimed works (default: printed)",
    )
    add(
        "--form",
        choices=reproduction.FORMS,
        help="how fuzzy sets combine to rules: grid has every combination (5^inputs), shared one rule "
        "a set (5), concat one a set and input (20), per_joint a grid for each joint (25 each)",
    )
    strengths = compensator.add_mutually_exclusive_group()
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
        type=_numbers,
        help="how fast it learns; the inverse of the paper's Γ: too low changes nothing, too high "
        "shakes a sampled controller",
    )
    add(
        "--inputs",
        metavar="NAME",
        type=_names,
        help="what the rules see: error (the paper), state, reference, trajectory, or a list of "
        "e, de, q, dq, q_d, dq_d, ddq_d",
    )
    add(
        "--leak-rate",
        metavar="R",
        type=_number,
        help="how fast it forgets [1/s]; keeps weights from drifting away (default: 0)",
    )
    add(
        "--gamma",
        metavar="G",
        type=_number,
        help="level of disturbance that the proof allows for, γ (default: 1)",
    )
    numerics = parser.add_argument_group("numerics")
    add = numerics.add_argument
    add(
        "--dt",
        metavar="S",
        type=_number,
        help="step and spacing of the record [s] (default: 0.001)",
    )
    add(
        "--method",
        choices=("rk4", "dp54"),
        default="rk4",
        help="rk4: fixed step. dp54: error control (default: rk4)",
    )
    output = parser.add_argument_group("output")
    add = output.add_argument
    add("--plot", metavar="FILE", type=_picture, help="draw the run (.png, .svg or .pdf)")
    add(
        "--save",
        metavar="FILE.npz",
        type=_record,
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
)
"""Options of ``simulate`` that go to `paper.simulation` if they are given."""


def _simulate(arguments: argparse.Namespace) -> int:
    for file in (arguments.plot, arguments.save):
        if file is not None and not file.parent.is_dir():
            raise FileNotFoundError(2, "no such directory", str(file.parent))
    chosen = {name: getattr(arguments, name) for name in OVERRIDES}
    chosen = {name: value for name, value in chosen.items() if value is not None}
    try:
        scene = paper.simulation(arguments.simulation, arguments.preset, **chosen)
        run = scene.run(
            method=arguments.method,
            control_period=arguments.control_period,
            progress=sys.stderr.isatty() and scene.duration > PATIENCE,
        )
    except (ValueError, TypeError) as error:
        raise _Refused(error) from error
    print(_report(run, arguments))
    if arguments.plot is not None:
        _files.picture(arguments.plot, run.plot())
        print(f"picture     {arguments.plot}")
    if arguments.save is not None:
        _files.replace(arguments.save, run.save)
        print(f"record      {arguments.save}")
    return {"finished": 0, "diverged": FAILED, "interrupted": STOPPED}[run.status.kind]


PATIENCE = 200.0
"""Runs longer than this show a progress bar on a terminal [s]."""

METRICS = {
    "rms_e": "RMS error [rad]",
    "max_abs_e": "max |error| [rad]",
    "settling_time": "time to |error| < 0.01 rad [s]",
    "rms_tau": "RMS torque [N·m]",
    "max_abs_tau": "max |torque| [N·m]",
    "torque_variation": "torque variation [N·m/s]",
}
"""Names and units of the metrics."""


def _report(run: Run, arguments: argparse.Namespace) -> str:
    """What happened, in lines."""
    preset = f", {arguments.preset}" if arguments.simulation == 3 else ""
    lines = [f"scene       simulation {arguments.simulation}{preset}", f"status      {run.status}"]
    if run.status.kind == "diverged":
        lines += [f"            {_why(arguments)}"]
    end = float(run.t[-1])
    late, whole = run.metrics((end / 2, end)), run.metrics()
    joints = "".join(f"{f'joint {joint + 1}':>13}" for joint in range(run.joints))
    lines += ["", f"{'':46}{joints}"]
    for name, label in METRICS.items():
        second_half = name in ("rms_e", "rms_tau", "torque_variation")
        values = getattr(late if second_half else whole, name)
        when = f"{end / 2:g} to {end:g} s" if second_half else "whole run"
        figures = "".join(f"{value:13.6g}" for value in values)
        lines.append(f"{label:31}{when:>15}{figures}")
    return "\n".join([*lines, "", *_learnt(run, end), *_certified(run, arguments)])


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
        why = "sampled control" if arguments.control_period is not None else "no compensator"
        return [f"certificate none: {why}"]
    gamma = 1.0 if arguments.gamma is None else float(arguments.gamma)
    bound = certificate.v_start + gamma**2 * certificate.uncertainty
    sign = "<=" if certificate.state_cost <= bound else ">, which must not be:"
    return [
        f"certificate Lyapunov identity kept to {certificate.residual:.1e} (relative)",
        f"            ∫x'Qx dt = {certificate.state_cost:.4g} {sign} V(0) + γ²∫|ρ|² dt = {bound:.4g}",
    ]


# approximate


def _add_approximate(commands: Commands) -> None:
    parser = _command(
        commands,
        "approximate",
        "how the largest error of a fuzzy fit falls with the number of rules",
        "Fit fuzzy systems of 4 to 576 rules to g(x, y) = sin(2x + cos y) exp(-y²/4) on [-2, 2]²\n"
        "and print the largest error on a fine grid of other points: the paper's statement (5),\n"
        "that enough rules come as close as you like to any continuous function.",
        _approximate,
    )
    parser.add_argument("--out", metavar="FILE", type=_picture, help="draw it (.png, .svg or .pdf)")


def _approximate(arguments: argparse.Namespace) -> int:
    rows = []
    print("  rules   largest error")
    for rules, error in reproduction.approximation():
        print(f"{rules:7}   {error:13.3g}", flush=True)
        rows.append((rules, error))
    first, last = rows[0], rows[-1]
    print(
        f"\n{last[0] / first[0]:.0f} times the rules, {first[1] / last[1]:.0f} times less error "
        "(g reaches from -1 to 1, its unit is 1)."
    )
    if arguments.out is not None:
        from . import plots

        _files.picture(arguments.out, plots.approximation(rows))
        print(f"The picture is {arguments.out}")
    return 0


# what options may be


def _number(text: str) -> float:
    try:
        return float(Fraction(text)) if "/" in text else float(text)
    except (ValueError, ZeroDivisionError):
        raise argparse.ArgumentTypeError(f"got {text!r}, wants a number") from None


def _numbers(text: str) -> float | list[float]:
    values = [_number(part) for part in text.split(",")]
    return values[0] if len(values) == 1 else values


def _names(text: str) -> str | list[str]:
    names = [name.strip() for name in text.split(",")]
    return names[0] if len(names) == 1 else names


def _picture(text: str) -> Path:
    return _file(text, _files.PICTURES)


def _record(text: str) -> Path:
    return _file(text, (".npz",))


def _file(text: str, endings: tuple[str, ...]) -> Path:
    path = Path(text)
    if path.suffix.lower() not in endings:
        raise argparse.ArgumentTypeError(f"got {text!r}, wants a name in {', '.join(endings)}")
    return path


COMMANDS: tuple[Callable[[Commands], None], ...] = (
    _add_reproduce,
    _add_simulate,
    _add_approximate,
)
"""The commands, in the order of the help."""

if __name__ == "__main__":
    sys.exit(main())
