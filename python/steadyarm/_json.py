"""``--json``: one object on standard output, or in a file, for other programs."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import _files
from ._options import check_files
from ._streams import say, tell

STDOUT = Path("-")
"""Where the object goes without a FILE."""

ENDING = ".json"


def add_json(add: Any) -> None:
    """Add the option, through the ``add_argument`` of a parser or a group."""
    add(
        "--json",
        metavar="FILE",
        type=Path,
        nargs="?",
        const=STDOUT,
        help="one JSON object in place of the words, for a pipe; or in a FILE beside them",
    )


def settle(arguments: argparse.Namespace) -> None:
    """Tell a FILE of ``--json`` from a SOURCE behind it, and see whether it can be written."""
    if not hasattr(arguments, "json"):
        return
    file, given = arguments.json, arguments.source
    if file not in (None, STDOUT) and given is None and file.suffix.lower() != ENDING:
        arguments.json, arguments.source = STDOUT, str(file)
    if arguments.json != STDOUT:
        check_files(arguments.json)


def emit(arguments: argparse.Namespace, words: str, value: Any) -> None:
    """Say what was found in words, or as JSON; ``value``: what `plain` takes, or JSON itself."""
    text = value if isinstance(value, str) else dumped(value)
    if arguments.json == STDOUT:
        say(text)
        arguments.answered = True
        return
    say(words)
    if arguments.json is not None:
        _files.text(arguments.json, text + "\n")
        written(arguments, arguments.json)


def unanswered(arguments: argparse.Namespace, error: BaseException) -> None:
    """Answer a pipe with the reason, where the command ends before it has answered."""
    if getattr(arguments, "json", None) == STDOUT and not hasattr(arguments, "answered"):
        kind = "interrupted" if isinstance(error, KeyboardInterrupt) else "refused"
        say(dumped({"status": kind, "reason": str(error)}))


def written(arguments: argparse.Namespace, path: Path, kind: str = "written") -> None:
    """Say that a file is written, where it is not among JSON."""
    if arguments.json == STDOUT:
        tell(f"{kind} {path}")
    else:
        say(f"{kind:12}{path}")


def dumped(value: Any) -> str:
    """JSON of what `plain` takes."""
    return json.dumps(plain(value), allow_nan=False)


def plain(value: Any) -> Any:
    """A value in what JSON has: lists for arrays, null for what is not finite."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)
