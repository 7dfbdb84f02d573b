"""Files of runs, taken apart and put together again: what tests break."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from scenes import run, tracker

ROWS = 11
RECORD = run(tracker(), duration=0.01)

Members = list[tuple[str, bytes]]


def npy(array: Any) -> bytes:
    """A member as numpy writes it."""
    file = io.BytesIO()
    np.lib.format.write_array(file, np.asanyarray(array))
    return file.getvalue()


def headed(header: str, data: bytes = b"") -> bytes:
    """A member with any header."""
    text = header.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + data


def members(path: Path, record: sa.Run = RECORD) -> dict[str, bytes]:
    """The members of the file of a run, each of which a test then breaks."""
    record.save(path)
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def pack(path: Path, parts: Members, method: int = zipfile.ZIP_DEFLATED) -> None:
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, content in parts:
            archive.writestr(name, content)


def refused(path: Path, why: str) -> None:
    with pytest.raises(ValueError, match=rf"^path: got .*, wants a file from Run\.save \({why}"):
        sa.Run.load(path)
