"""Files that are written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = (".png", ".svg", ".pdf")
"""Endings of the pictures that can be written."""


def replace(path: Path, write: Callable[[Path], object]) -> None:
    """Call ``write`` with a temporary path beside ``path``, then rename.

    A full disk leaves no half file; what stood at ``path`` before stays until the new file is
    complete. Devices and pipes are written directly. Raises OSError that names ``path``.
    """
    path = Path(os.path.realpath(path))
    if path.exists() and not path.is_file():
        write(path)
        return
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        write(part)
        with part.open("rb") as file:
            os.fsync(file.fileno())
        part.replace(path)
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error
    finally:
        part.unlink(missing_ok=True)


def text(path: Path, content: str) -> None:
    """Write a UTF-8 text file."""
    replace(path, lambda part: part.write_text(content, encoding="utf-8"))


def picture(path: Path, figure: Figure) -> None:
    """Write a figure in the format of the path's ending."""
    form = path.suffix[1:].lower()
    replace(path, lambda part: figure.savefig(part, format=form))
