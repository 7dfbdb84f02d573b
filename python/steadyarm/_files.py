"""The one writer of files: whole or not at all, for records, state, pictures, films and tables."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

LONGEST_SUFFIX = 8
"""So much of a name's ending is kept for the writers that go by it [characters]."""


def replace(path: str | os.PathLike[str], write: Callable[[Path], object]) -> None:
    """Make the file at ``path``: ``write`` fills a new one beside it, which then takes its place.

    Whoever reads ``path`` sees the old file or the new one, each whole, whoever else writes it
    and however this ends; the new one is on the disk when this returns. A link stays and what it
    points at is replaced, owner and mode stay (a new file has those of the umask); another hard
    link keeps the old content. Pipes and devices are written to. Raises OSError that names
    ``path``.
    """
    path = Path(path)
    with _naming(path):
        old = _status(path)
        if old is not None and not stat.S_ISREG(old.st_mode):
            _write_through(path, write)
            return
        target = Path(os.path.realpath(path))
        with _part(target, old) as part:
            write(part)
            _sync(part, os.O_RDWR)
            if old is not None:
                _keep_owner_and_mode(part, old)
            part.replace(target)
        if os.name == "posix":
            with suppress(OSError):  # some file systems cannot, and the file is there
                _sync(target.parent, os.O_RDONLY)


def check(path: str | os.PathLike[str]) -> None:
    """Raise the OSError that `replace` would, before the work is done."""
    path = Path(path)
    with _naming(path):
        old = _status(path)
        if old is None or stat.S_ISREG(old.st_mode):
            with _part(Path(os.path.realpath(path)), old):
                pass


def content(path: str | os.PathLike[str], content: bytes) -> None:
    """Write bytes."""
    replace(path, lambda part: part.write_bytes(content))


def text(path: str | os.PathLike[str], content: str | Iterable[str]) -> None:
    """Write a UTF-8 text file, whole or part by part."""

    def write(part: Path) -> None:
        with part.open("w", encoding="utf-8") as file:
            file.writelines([content] if isinstance(content, str) else content)

    replace(path, write)


def read(path: str | os.PathLike[str], limit: int) -> bytes:
    """Read a file of at most ``limit`` bytes; ValueError if it has more."""
    with Path(path).open("rb") as file:
        content = file.read(limit + 1)
    if len(content) > limit:
        raise ValueError(f"path: got {path}, wants a file of at most {limit} bytes")
    return content


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Let errors name the file that the caller asked for."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error


def _status(path: Path) -> os.stat_result | None:
    """What is at ``path``, if it may be written; None for nothing."""
    try:
        old = path.stat()
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(old.st_mode):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not os.access(path, os.W_OK, effective_ids=os.access in os.supports_effective_ids):
        raise OSError(errno.EACCES, os.strerror(errno.EACCES))
    return old


@contextmanager
def _part(target: Path, old: os.stat_result | None) -> Iterator[Path]:
    """A new file beside ``target``, gone in the end. Its name is drawn: nobody else has it."""
    mode = 0o666 if old is None else stat.S_IMODE(old.st_mode) | stat.S_IRUSR | stat.S_IWUSR
    part = target.with_name(f".{secrets.token_hex(16)}{target.suffix[:LONGEST_SUFFIX]}")
    try:
        os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode))
        yield part
    finally:
        part.unlink(missing_ok=True)


def _keep_owner_and_mode(part: Path, old: os.stat_result) -> None:
    if os.name == "posix":
        with suppress(PermissionError):  # who may write a file may not give one away
            os.chown(part, old.st_uid, old.st_gid)
    part.chmod(stat.S_IMODE(old.st_mode))


def _write_through(path: Path, write: Callable[[Path], object]) -> None:
    """Write to a pipe or a device, once all is there: some writers go back in their file."""
    with tempfile.TemporaryDirectory() as folder:
        part = Path(folder, f"part{path.suffix[:LONGEST_SUFFIX]}")
        write(part)
        with part.open("rb") as source, open(os.open(path, os.O_WRONLY), "wb") as sink:
            shutil.copyfileobj(source, sink)


def _sync(path: Path, flags: int) -> None:
    file = os.open(path, flags)
    try:
        os.fsync(file)
    finally:
        os.close(file)
