"""Standard output and error of the command: who stops listening stops no work."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import TextIO


def prepare() -> None:
    """Give a stream that was closed before the start to nobody; write ? for what it cannot show."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")


def say(text: str) -> None:
    """Print a text at once."""
    _print(text, sys.stdout)


def tell(message: str, code: int = 0) -> int:
    """Print a message to standard error, if it can be; return the exit code."""
    with suppress(OSError):
        _print(f"steadyarm: {message}", sys.stderr)
    return code


def finish() -> None:
    """Write what is left. Raises OSError if it cannot be, unless nobody listens any more."""
    _print("", sys.stdout, end="")


def _print(text: str, stream: TextIO, end: str = "\n") -> None:
    try:
        print(text, file=stream, end=end, flush=True)
    except OSError as error:
        # What is still in the stream goes to nobody, or Python would try again when it exits.
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        if not isinstance(error, BrokenPipeError):
            raise
