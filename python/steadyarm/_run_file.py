"""The files of `Run.save`: an .npz of float64 arrays, and JSON for the rest.

Format 3 has beside format 2: the compensator's own signals, each in a member ``own.NAME``, and the
scene that the run was made with, as JSON in bytes, with the state that its tracker started in. A
signal that the core has learnt to record since a file was written is as if it was not recorded.

A file is hostile until it is known: its members, their sizes and headers are looked at before one
of them is read, and nothing is believed that no simulation could have recorded.
"""

from __future__ import annotations

import json
import math
import os
import stat
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from . import _core, _files, _run_meta, _scene
from .record import (
    CHANNELS,
    DESIRED,
    MOTION,
    TORQUES,
)
from .run import Run

Array = NDArray[np.float64]

ARRAYS = (*CHANNELS, "weights")
REQUIRED = (*MOTION, *DESIRED, *TORQUES)
"""Arrays of every run by name, and those of them that every file has."""

SCENE = ("scene", "start")
"""Members of bytes: what the run was made with, and the state of its tracker."""

OWN = "own."
"""What the members of the compensator's own signals begin with."""

META_BYTES = 1 << 20
"""The JSON is smaller [bytes]."""

WEIGHTS_BYTES = (3 << 25) + (1 << 10)
"""No weights are more: 2^20 rules for twelve joints, and a header [bytes]."""

SCENE_BYTES = 1 << 26
"""A scene of more is left out [bytes]: that of a table of 100 000 rows for seven joints is less."""

START_BYTES = (3 << 26) + (1 << 20)
"""No state is larger: two matrices of weights, and a header [bytes]."""

LIMITS = {
    "meta": META_BYTES, "weights": WEIGHTS_BYTES, "scene": SCENE_BYTES, "start": START_BYTES,
}  # fmt: skip

MAX_BYTES = 4 * _core.MAX_RECORD_BYTES + sum(LIMITS.values())
"""No run is larger [bytes]: of the motion alone, set-points and errors make 3.5 times as much."""

DEFLATE_RATIO = 1040
"""Deflate makes nothing smaller than by 1032, so a member that claims more lies."""


@dataclass
class _Content:
    """What a file holds, member by member."""

    meta: dict[str, Any]
    arrays: dict[str, Array]
    own: dict[str, Array]
    scene: bytes | None
    start: bytes | None

    def members(self) -> dict[str, Any]:
        """The members by name."""
        own = {OWN + name: array for name, array in self.own.items()}
        scene = {
            name: np.frombuffer(content, np.uint8)
            for name, content in zip(SCENE, (self.scene, self.start), strict=True)
            if content is not None
        }
        return {"meta": np.array(json.dumps(self.meta)), **self.arrays, **own, **scene}


def save(run: Run, path: str | Path) -> None:
    """Write ``run``. Raises ValueError for one that `load` would refuse."""
    content = _content(run)
    try:
        _check_shapes({n: (a.dtype, a.shape) for n, a in (content.arrays | _own(content)).items()})
        for name, array in (content.arrays | _own(content)).items():
            _check_values(name, array)
        _run(_Content(**vars(content) | {"meta": _run_meta.parsed(json.dumps(content.meta))}))
    except ValueError as error:
        raise ValueError(f"run: got one that no simulation records ({error})") from error

    def write(part: Path) -> None:
        with part.open("wb") as file:
            np.savez_compressed(file, **content.members())

    _files.replace(path, write)


def _own(content: _Content) -> dict[str, Array]:
    return {OWN + name: array for name, array in content.own.items()}


def _content(run: Run) -> _Content:
    """What the file of a run holds."""
    arrays = {name: array for name in ARRAYS if (array := getattr(run, name)) is not None}
    dictionary, made = run.dictionary, run._made
    meta = {
        "format": _run_meta.FORMAT,
        "arrays": sorted(arrays),
        "own": {
            channel.name: {"unit": channel.unit, "shape": channel.shape, "doc": channel.doc}
            for channel in run.own
        },
        "status": asdict(run.status),
        "certificate": None if run.certificate is None else asdict(run.certificate),
        "notes": list(run.notes),
        "guard": None
        if run.guard is None
        else {"events": dict(run.guard.events), "stopped": run.guard.stopped},
        "dictionary": dictionary
        and dictionary | {"error_bound": dictionary["error_bound"].tolist()},
    }
    own = {channel.name: array for channel, array in run.own.items()}
    content = _Content(meta, arrays, own, None, None)
    if made is not None and len(scene := json.dumps(made.plain).encode()) <= SCENE_BYTES:
        content.scene, content.start = scene, made.start
    return content


def load(path: str | Path) -> Run:
    """Read what `save` wrote. Raises ValueError for any other file, or a damaged one."""
    with Path(path).open("rb") as file:
        try:
            return _load(file)
        except Exception as error:
            message = f"path: got {path}, wants a file from Run.save ({error})"
            raise ValueError(message) from error


def _load(file: BinaryIO) -> Run:
    status = os.fstat(file.fileno())
    if not stat.S_ISREG(status.st_mode):
        raise ValueError("it is a pipe or a device")  # which may never end
    with ZipFile(file) as archive:
        members = _members(archive, status.st_size)
        meta = _meta(archive, members.pop("meta"))
        scene, start = (_bytes(archive, members.pop(name, None)) for name in SCENE)
        own = {name for name in members if name.startswith(OWN)}
        if sorted(set(members) - own) != meta["arrays"]:
            raise ValueError(f"arrays: got {sorted(members)}, wants {meta['arrays']}")
        if own != {OWN + name for name in meta["own"]}:
            raise ValueError(f"own: got {sorted(own)}, wants {sorted(meta['own'])}")
        _check_shapes({name: _header(archive, member) for name, member in members.items()})
        # The times come first: zeros pack well, times that rise do not.
        arrays: dict[str, Array] = {}
        for name in sorted(members, key=lambda name: name != "t"):
            arrays[name] = _read(archive, members[name])
            _check_values(name, arrays[name])
    own_arrays = {name.removeprefix(OWN): arrays.pop(name) for name in sorted(own)}
    return _run(_Content(meta, arrays, own_arrays, scene, start))


def _run(content: _Content) -> Run:
    meta, arrays = content.meta, content.arrays
    certificate, joints = meta["certificate"], arrays["q"].shape[1]
    columns: dict[str, Any] = {"weights": None}
    for name, (_, per_joint, _) in CHANNELS.items():
        columns[name] = np.empty((0, joints)) if per_joint else None
    run = Run(
        **columns | arrays,
        status=_run_meta.status(meta["status"]),
        certificate=None if certificate is None else _run_meta.certificate(certificate),
        dictionary=_run_meta.dictionary(meta["dictionary"], joints),
        notes=_run_meta.notes(meta["notes"]),
        guard=_run_meta.guard(meta["guard"]),
        own={
            _run_meta.channel(name, meta["own"][name], array): array
            for name, array in content.own.items()
        },
    )
    if (content.scene is None) != (content.start is None):
        raise ValueError("scene: got one of scene and start, wants both or none")
    if content.scene is not None and content.start is not None:
        parts = _scene.read(content.scene, joints)
        vars(run)["_scene"] = _scene.Scene(parts, content.start)
    return run


def _bytes(archive: ZipFile, member: ZipInfo | None) -> bytes | None:
    """A member of bytes."""
    if member is None:
        return None
    dtype, shape = _header(archive, member)
    if dtype != np.uint8 or len(shape) != 1:
        raise ValueError(f"{member.filename}: got {dtype} {shape}, wants bytes")
    return bytes(_read(archive, member))


def _members(archive: ZipFile, file_bytes: int) -> dict[str, ZipInfo]:
    """The members by name without .npy, if their names and sizes may be those of a run."""
    members: dict[str, ZipInfo] = {}
    for member in archive.infolist():
        name = member.filename.removesuffix(".npy")
        if not _is_known(name) or name == member.filename:
            raise ValueError(f"member: got {member.filename!r:.80}, which no run has")
        if name in members:
            raise ValueError(f"member: got {member.filename!r} twice")
        if member.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
            raise ValueError(f"{name}: got compression {member.compress_type}, wants deflate")
        if member.file_size > DEFLATE_RATIO * member.compress_size:
            raise ValueError(f"{name}: got {member.compress_size} bytes for {member.file_size}")
        members[name] = member
    missing = {"meta", *REQUIRED} - set(members)
    if missing:
        raise ValueError(f"members: got none of the name {', '.join(sorted(missing))}")
    if sum(member.compress_size for member in members.values()) > file_bytes:
        raise ValueError("members: they overlap")
    sizes = {name: member.file_size for name, member in members.items()}
    for name, limit in LIMITS.items():
        if sizes.get(name, 0) > limit:
            raise ValueError(f"{name}: got {sizes[name]} bytes, wants at most {limit}")
    if sum(sizes.values()) > MAX_BYTES:
        raise ValueError(f"members: got {sum(sizes.values())} bytes, wants at most {MAX_BYTES}")
    return members


def _is_known(name: str) -> bool:
    own = name.startswith(OWN) and name.removeprefix(OWN).isidentifier()
    return own or name in ("meta", *SCENE, *ARRAYS)


def _header(archive: ZipFile, member: ZipInfo) -> tuple[np.dtype[Any], tuple[int, ...]]:
    """Type and shape of a member, whose size is what they say."""
    with archive.open(member) as stream:
        if np.lib.format.read_magic(stream) != (1, 0):
            raise ValueError(f"{member.filename}: wants version 1.0 of the format")
        shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
        expected = stream.tell() + dtype.itemsize * math.prod(shape)
    if min(shape, default=0) < 0 or expected != member.file_size:
        raise ValueError(f"{member.filename}: got {member.file_size} bytes for {dtype} {shape}")
    return dtype, shape


def _read(archive: ZipFile, member: ZipInfo) -> Any:
    with archive.open(member) as stream:
        array = np.lib.format.read_array(stream, allow_pickle=False)
        stream.read(1)  # the checksum is looked at where the member ends
    return array


def _check_shapes(headers: Mapping[str, tuple[np.dtype[Any], tuple[int, ...]]]) -> None:
    """Refuse arrays whose type or shape no simulation could have given."""
    for name, (dtype, shape) in headers.items():
        own = name.startswith(OWN)
        per_joint = name == "weights" or (not own and CHANNELS[name][1])
        dimensions = (1, 2) if own else (2,) if per_joint else (1,)
        if dtype != np.float64 or len(shape) not in dimensions:
            raise ValueError(f"{name}: got {dtype} {shape}, wants float64 of one row a time")
    shapes = {name: shape for name, (_, shape) in headers.items()}
    (rows,), joints = shapes["t"], shapes["q"][1]
    recorded = shapes["tau"][0]
    if joints < 1:
        raise ValueError(f"q: got {joints} joints, wants at least one")
    if recorded not in (0, rows):
        raise ValueError(f"tau: got {recorded} rows, wants {rows}, or none")
    for name, shape in shapes.items():
        length = rows if name in (*MOTION, *DESIRED) or len(shape) == 1 else recorded
        wanted = (length,) if len(shape) == 1 else (length, joints)
        if name == "weights":
            wanted = (joints, shape[1])
        if shape != wanted:
            raise ValueError(f"{name}: got shape {shape}, wants {wanted}")


def _check_values(name: str, array: Array) -> None:
    """Refuse numbers that no simulation records."""
    if not np.isfinite(array).all():
        place = tuple(np.argwhere(~np.isfinite(array))[0])
        index = ", ".join(map(str, place))
        raise ValueError(f"{name}[{index}]: got {array[place]}, wants a finite number")
    if name == "t" and not (rises := np.diff(array) > 0).all():
        k = int(np.argmin(rises)) + 1
        raise ValueError(f"t[{k}]: got {array[k]} after {array[k - 1]}, wants times that rise")


def _meta(archive: ZipFile, member: ZipInfo) -> dict[str, Any]:
    """The JSON of a file."""
    dtype, shape = _header(archive, member)
    if dtype.kind != "U" or shape != ():
        raise ValueError(f"meta: got {dtype} {shape}, wants a text")
    return _run_meta.parsed(str(_read(archive, member)))
