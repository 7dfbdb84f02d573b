"""What the commands share: how one is added, and what values its options take."""

from __future__ import annotations

import argparse
import difflib
import errno
import os
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from ._extras import imported
from ._files import check

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction["Parser"]

FAILED, USAGE, STOPPED = 1, 2, 130
"""Exit codes: something went wrong; the arguments make no sense; Ctrl-C."""

PICTURES = (".png", ".svg", ".pdf")
"""Endings of the pictures that can be written."""


class Refused(Exception):
    """Arguments that the library refuses."""


class Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in its last line, and not under the list of all options."""

    def error(self, message: str) -> NoReturn:
        """End with one line, after one on where to find more."""
        self.exit(USAGE, f"{self.prog} --help explains the options\nsteadyarm: {message}\n")

    def unknown(self, arguments: list[str]) -> NoReturn:
        """End with what is no option, and the option that is nearest to it."""
        name = arguments[0].partition("=")[0]
        near = difflib.get_close_matches(name, self._option_string_actions, 1)
        hint = f"; near: {near[0]}" if near else ""
        self.error(f"unrecognized arguments: {' '.join(arguments)}{hint}")


def check_files(*paths: Path | None) -> None:
    """Raise OSError if one of the files cannot be written, before the work is done."""
    for path in paths:
        if path is not None:
            if not path.parent.is_dir():
                raise FileNotFoundError(errno.ENOENT, "no such directory", str(path.parent))
            check(path)


INPUTS, OUTPUTS = ("source", "scenario", "against"), (
    "plot", "why_plot", "save", "csv", "html", "json", "out",
)  # fmt: skip
"""Options of a command that name a file to read, and one to write."""


def check_apart(arguments: argparse.Namespace) -> None:
    """Refuse an output that would write over what is read, or over another output."""
    taken: dict[str, str] = {}
    for name in (*INPUTS, *OUTPUTS):
        path = getattr(arguments, name, None)
        if path is None or (not os.path.lexists(path) and name in INPUTS):
            continue
        place, option = os.path.realpath(path), f"--{name.replace('_', '-')}"
        device = os.path.exists(place) and not os.path.isfile(place)
        if name in OUTPUTS and place in taken and not device:
            raise Refused(f"{option}: got {path}, which is {taken[place]} too; wants another file")
        taken[place] = "the SOURCE" if name == "source" else option


def command(
    commands: Commands,
    name: str,
    summary: str,
    details: str,
    run: Callable[[Any], int],
    *,
    examples: str,
    aliases: tuple[str, ...] = (),
) -> Parser:
    """Add a command: ``summary`` for the list of commands, ``details`` for its own help.

    ``run`` takes the parsed arguments and returns the exit code. ``examples``: lines of the shell.
    """
    parser = commands.add_parser(
        name,
        aliases=aliases,
        help=summary,
        description=details,
        epilog=f"examples:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(run=run, parser=parser)
    return parser


def number(text: str) -> float:
    """A number or a fraction."""
    try:
        return float(Fraction(text)) if "/" in text else float(text)
    except (ValueError, ZeroDivisionError):
        raise argparse.ArgumentTypeError(f"got {text!r}, wants a number") from None


def positive(text: str) -> float:
    """A number above 0."""
    value = number(text)
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f"got {text!r}, wants a number > 0")
    return value


def numbers(text: str) -> float | list[float]:
    """One number for all joints, or one a joint."""
    values = [number(part) for part in text.split(",")]
    return values[0] if len(values) == 1 else values


def whole(text: str) -> int:
    """A whole number from 0 on."""
    if not (text.isascii() and text.isdecimal()):
        raise argparse.ArgumentTypeError(f"got {text!r}, wants a whole number from 0 on")
    return int(text)


def harmonics(text: str) -> list[tuple[float, float]]:
    """Amplitudes and frequencies, as in 2@1,0.5@3."""
    pairs = [part.partition("@") for part in text.split(",")]
    if not all(at for _, at, _ in pairs):
        raise argparse.ArgumentTypeError(
            f"got {text!r}, wants amplitude@frequency, as in 2@1,0.5@3"
        )
    return [(number(amplitude), number(frequency)) for amplitude, _, frequency in pairs]


def names(text: str) -> str | list[str]:
    """One name, or several."""
    names = [name.strip() for name in text.split(",")]
    return names[0] if len(names) == 1 else names


def picture(text: str) -> Path:
    """A picture file."""
    path = file_of(text, PICTURES)
    imported("matplotlib", "pictures")
    return path


def record(text: str) -> Path:
    """A file for `Run.save`."""
    return file_of(text, (".npz",))


def file_of(text: str, endings: tuple[str, ...]) -> Path:
    """A file whose name has one of these endings."""
    path = Path(text)
    if path.suffix.lower() not in endings:
        wanted = " or ".join(endings)
        raise argparse.ArgumentTypeError(f"got {text!r}, wants a name that ends in {wanted}")
    return path
