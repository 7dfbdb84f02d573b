"""The folder of a sweep: ``_plan.json`` says what is swept, ``rows-….parquet`` have the rows.

A file of rows is written whole or not at all, under the number of its first row, and is never added
to: however a sweep ends, what is there is right, and what is missing can be told.
"""

from __future__ import annotations

import json
import re
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _files
from ._extras import imported
from ._sweep_plan import Plan

PLAN, LOCK = "_plan.json", ".lock"
"""Readers of Parquet take a folder without the files whose names begin so."""

COMPARED, KEPT = ("steadyarm", "source", "plan"), ("inputs", "rows", "repeat")
"""What the plan says to be compared with another's, and to be read."""

UNIT = "unit"
"""Of a column, in what its field says beside its type."""

ROWS = "rows-*.parquet"

RAISED = "raised"
"""The status of a row whose function raised."""

LEFT = re.compile(r"\.[0-9a-f]{32}\.parquet")
"""What a client that was killed leaves of a file."""

_HERE: set[Path] = set()
"""Folders that this process writes to: its locks do not stop its own threads."""

_HERE_LOCK = threading.Lock()

WHAT = "a sweep"

Flags = NDArray[np.bool_]


class Folder:
    """A folder that rows are written to, by one sweep at a time."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    @contextmanager
    def opened(cls, path: str | Path, said: Mapping[str, Any]) -> Iterator[Folder]:
        """The folder at ``path``, made if it is not there, for the sweep that ``said`` tells of.

        Raises ValueError where another sweep is in it, and RuntimeError where one writes now.
        """
        if not isinstance(path, str | Path) or not str(path):
            raise TypeError(f"out: got {path!r:.80}, wants the path of a folder")
        folder = cls(Path(path))
        if folder.path.exists() and not folder.path.is_dir():
            raise FileExistsError(f"out: {path} is a file, wants a folder")
        folder.path.mkdir(parents=True, exist_ok=True)
        with _locked(folder.path / LOCK):
            plan = folder.path / PLAN
            if plan.exists():
                _compare(folder.path, said, read_plan(folder.path))
            elif any(folder.path.glob(ROWS)):
                raise ValueError(f"out: {path} has rows without a {PLAN}, wants another folder")
            else:
                _files.text(plan, json.dumps(said, indent=2, ensure_ascii=False) + "\n")
            for left in folder.path.glob(".*.parquet"):
                if LEFT.fullmatch(left.name):
                    left.unlink(missing_ok=True)
            yield folder

    def done(self, plan: Plan) -> Flags:
        """Which rows are there."""
        done = np.zeros(plan.rows, dtype=bool)
        done[numbers(self.path)] = True
        return done

    def forget_raised(self) -> None:
        """Take out the rows that raised."""
        compute = imported("pyarrow.compute", WHAT)
        parquet = imported("pyarrow.parquet", WHAT)
        for file in sorted(self.path.glob(ROWS)):
            with _naming(file):
                rows = parquet.read_table(file)
                kept = rows.filter(compute.not_equal(rows["status"], RAISED))
            if not len(kept):
                file.unlink()
            elif len(kept) < len(rows):
                _files.replace(file, partial(parquet.write_table, kept))

    def write(self, columns: Mapping[str, Any], units: Mapping[str, str]) -> None:
        """Add rows; their numbers are the column "index"."""
        arrow = imported("pyarrow", WHAT)
        parquet = imported("pyarrow.parquet", WHAT)
        arrays = [arrow.array(values) for values in columns.values()]
        fields = [
            arrow.field(name, array.type, metadata={UNIT: units[name]} if name in units else None)
            for name, array in zip(columns, arrays, strict=True)
        ]
        table = arrow.table(arrays, schema=arrow.schema(fields))
        _files.replace(
            self._unused(int(columns["index"][0])), lambda part: parquet.write_table(table, part)
        )

    def _unused(self, row: int) -> Path:
        """A file for rows from this one on. There may be one that had it, and has others."""
        names = (f"{row:010}{f'-{again}' * bool(again)}" for again in count())
        files = (self.path / ROWS.replace("*", name) for name in names)
        return next(file for file in files if not file.exists())


def read_plan(path: Path) -> dict[str, Any]:
    """What a folder says is swept. Raises OSError, and ValueError where it is no sweep's."""
    try:
        said: dict[str, Any] = json.loads((path / PLAN).read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise FileNotFoundError(error.errno, "no sweep is in it", str(path)) from None
    except ValueError as error:
        raise ValueError(f"{path / PLAN}: {error}") from error
    if not isinstance(said, dict) or not {*COMPARED, *KEPT} <= said.keys():
        raise ValueError(f"{path / PLAN}: wants {', '.join((*COMPARED, *KEPT))}")
    return said


def numbers(path: Path) -> NDArray[np.int64]:
    """The numbers of the rows that a folder has, in the order of its files."""
    parquet = imported("pyarrow.parquet", WHAT)
    found = [np.empty(0, dtype=np.int64)]
    for file in sorted(path.glob(ROWS)):
        with _naming(file):
            found.append(parquet.read_table(file, columns=["index"])["index"].to_numpy())
    return np.concatenate(found)


def table(path: Path) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
    """All rows by column, in the order of their numbers, and the units of the columns.

    What a row does not have is NaN, or "".
    """
    arrow = imported("pyarrow", WHAT)
    parquet = imported("pyarrow.parquet", WHAT)
    parts = []
    for file in sorted(path.glob(ROWS)):
        with _naming(file):
            parts.append(parquet.read_table(file))
    if not parts:
        return {"index": np.empty(0, dtype=np.int64)}, {}
    units = {
        field.name: field.metadata[UNIT.encode()].decode()
        for part in reversed(parts)
        for field in part.schema
        if field.metadata
    }
    words = {
        field.name for part in parts for field in part.schema if arrow.types.is_string(field.type)
    }
    alike = [_as_words(it, words) for it in parts]
    whole = arrow.concat_tables(alike, promote_options="default").sort_by("index")
    return {name: _values(whole[name], name in words) for name in whole.column_names}, units


def _as_words(part: Any, words: set[str]) -> Any:
    """A table in which figures that are words elsewhere are words too, and no field has a unit."""
    arrow = imported("pyarrow", WHAT)
    part = part.cast(arrow.schema([field.remove_metadata() for field in part.schema]))
    for place, field in enumerate(part.schema):
        if field.name in words and not arrow.types.is_string(field.type):
            said = [repr(value) for value in part[field.name].to_pylist()]
            part = part.set_column(place, field.name, arrow.array(said))
    return part


def _values(column: Any, words: bool) -> NDArray[Any]:
    if words:
        return np.array(column.fill_null("").to_pylist(), dtype=str)
    found: NDArray[Any] = column.to_numpy()
    return found


def _compare(path: Path, said: Mapping[str, Any], there: Mapping[str, Any]) -> None:
    """Refuse a folder that another sweep is in, and say what differs."""
    new, old = (_flat({name: it[name] for name in COMPARED}) for it in (said, there))
    for name in [*new, *(name for name in old if name not in new)]:
        if new.get(name) != old.get(name):
            raise ValueError(
                f"out: {path} has another sweep; {name}: there {old.get(name, 'none')}, "
                f"here {new.get(name, 'none')}; wants another folder"
            )


def _flat(said: Mapping[str, Any]) -> dict[str, str]:
    """Nested words, each by the last of its names."""
    found: dict[str, str] = {}
    for name, value in said.items():
        found |= _flat(value) if isinstance(value, Mapping) else {name: str(value)}
    return found


@contextmanager
def _naming(file: Path) -> Iterator[None]:
    """Let errors say which file cannot be read."""
    arrow = imported("pyarrow", WHAT)
    try:
        yield
    except (arrow.ArrowException, KeyError) as error:
        raise ValueError(
            f"{file}: is no table of rows ({error}); delete it, and sweep on"
        ) from error


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Keep the folder for this process, until it ends however it does.

    Not where a system has no such locks (Windows), or a disk.
    """
    whole = path.resolve()
    taken = RuntimeError(
        f"out: another sweep writes to {path.parent} now; wait for it, or take another folder"
    )
    with _HERE_LOCK:
        if whole in _HERE:
            raise taken
        _HERE.add(whole)
    try:
        with _locked_for_others(path, taken):
            yield
    finally:
        with _HERE_LOCK:
            _HERE.remove(whole)


@contextmanager
def _locked_for_others(path: Path, taken: RuntimeError) -> Iterator[None]:
    """The same against other processes."""
    with path.open("a") as file:
        with suppress(ImportError):
            import fcntl

            try:
                fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise taken from None
            except OSError:
                pass
        yield
