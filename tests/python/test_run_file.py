"""Files of `Run.save`: nothing is read before it is known to be one, no wrong array is believed."""

from __future__ import annotations

import io
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from run_files import RECORD, ROWS, headed, members, npy, pack, refused


@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/zero")
@pytest.mark.parametrize("name", ["/dev/zero", "/dev/null", "/dev/full"])
def test_device_is_refused(name: str) -> None:
    refused(Path(name), "it is a pipe or a device")


def test_members_as_they_are_make_the_run(tmp_path: Path) -> None:
    """What the tests below break is whole before, packed or not."""
    path = tmp_path / "run.npz"
    for method in (zipfile.ZIP_DEFLATED, zipfile.ZIP_STORED):
        pack(path, list(members(path).items()), method)
        assert np.array_equal(sa.Run.load(path).q, RECORD.q)


def column(value: float, at: int = 5) -> np.ndarray:
    q = RECORD.q.copy()
    q[at, 1] = value
    return q


def times(*changes: tuple[int, float]) -> np.ndarray:
    t = RECORD.t.copy()
    for at, value in changes:
        t[at] = value
    return t


BROKEN: list[tuple[str, dict[str, Any], str]] = [
    ("NaN", {"q": column(np.nan)}, r"q\[5, 1\]: got nan, wants a finite number"),
    ("infinity", {"tau": column(-np.inf)}, r"tau\[5, 1\]: got -inf"),
    ("NaN in a flat array", {"V": times((3, np.nan))}, r"V\[3\]: got nan"),
    ("NaN weight", {"weights": np.full((2, 625), np.nan)}, r"weights\[0, 0\]: got nan"),
    ("NaN time", {"t": times((3, np.nan))}, r"t\[3\]: got nan"),
    ("time backwards", {"t": times((4, 0.0015))}, r"t\[4\]: got 0.0015 after 0.003"),
    ("time all backwards", {"t": RECORD.t[::-1]}, r"t\[1\]: got 0\.009"),
    ("time that stands", {"t": times((4, 0.003))}, r"t\[4\]: got 0\.003 after 0\.003"),
    ("a row less", {"q": RECORD.q[:-1]}, r"q: got shape \(10, 2\), wants \(11, 2\)"),
    ("a joint more", {"dq": np.zeros((ROWS, 3))}, r"dq: got shape \(11, 3\), wants \(11, 2\)"),
    ("turned", {"q_d": RECORD.q.T}, r"q_d: got shape \(2, 11\), wants \(11, 2\)"),
    ("part of the torques", {"rho": np.zeros((0, 2))}, r"rho: got shape \(0, 2\)"),
    ("no joint", {"q": np.zeros((ROWS, 0))}, "q: got 0 joints"),
    ("flat q", {"q": np.zeros(ROWS)}, r"q: got float64 \(11,\)"),
    ("scalar", {"q": np.float64(3.0)}, r"q: got float64 \(\)"),
    ("cube", {"q": np.zeros((ROWS, 2, 1))}, r"q: got float64 \(11, 2, 1\)"),
    ("weights of others", {"weights": np.zeros((3, 625))}, r"weights: got shape \(3, 625\)"),
    ("single", {"e": RECORD.e.astype(np.float32)}, "e: got float32"),
    ("whole numbers", {"e": np.zeros((ROWS, 2), int)}, "e: got int64"),
    ("other order", {"e": RECORD.e.astype(">f8")}, "e: got >f8"),
    ("texts", {"e": np.full((ROWS, 2), "1.0")}, "e: got <U3"),
    ("fields", {"e": np.zeros((ROWS, 2), [("x", float)])}, r"e: got \[\('x', '<f8'\)\]"),
    ("objects", {"e": np.full((ROWS, 2), None)}, r"e\.npy: got \d+ bytes for object"),
    ("one more array", {"surplus": np.zeros(3)}, r"member: got 'surplus\.npy', which no run has"),
]


@pytest.mark.parametrize(("change", "why"), [row[1:] for row in BROKEN], ids=[r[0] for r in BROKEN])
def test_wrong_array_is_refused(change: dict[str, Any], why: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path) | {f"{name}.npy": npy(array) for name, array in change.items()}
    pack(path, list(parts.items()))
    refused(path, why)


HEADERS = {
    "more rows than there are": (
        "{'descr': '<f8', 'fortran_order': False, 'shape': (10**9, 2)}",
        "",
    ),
    "all of memory": (
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 2), }",
        "for float64",
    ),
    "more than an integer": (
        "{'descr': '<f8', 'fortran_order': False, 'shape': (4611686018427387904, 4), }",
        "for float64",
    ),
    "less than nothing": ("{'descr': '<f8', 'fortran_order': False, 'shape': (-1, -22), }", ""),
    "no tuple": ("{'descr': '<f8', 'fortran_order': False, 'shape': 22, }", ""),
    "an object": ("{'descr': '|O', 'fortran_order': False, 'shape': (11, 2), }", ""),
    "a record": ("{'descr': [('a', '|O')], 'fortran_order': False, 'shape': (11, 2), }", ""),
    "a huge text": ("{'descr': '<U500000000', 'fortran_order': False, 'shape': (11, 2), }", ""),
    "no type": ("{'descr': 'x', 'fortran_order': False, 'shape': (11, 2), }", ""),
    "a call": ("{'descr': '<f8', 'fortran_order': False, 'shape': print(), }", ""),
    "nothing": ("", ""),
    "brackets": ("(" * 100, ""),
}


@pytest.mark.parametrize(("header", "why"), HEADERS.values(), ids=HEADERS)
@pytest.mark.parametrize("name", ["t", "q", "weights", "meta"])
def test_absurd_header_is_refused(name: str, header: str, why: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path) | {f"{name}.npy": headed(header, bytes(ROWS * 2 * 8))}
    pack(path, list(parts.items()))
    refused(path, f".*{why}")


@pytest.mark.parametrize("content", [b"", b"\x93NUMPY", b"\x93NUMPY\x03\x00", bytes(1000), b"x"])
def test_member_that_is_no_array_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    for name in ("t", "q", "meta"):
        pack(path, list((members(path) | {f"{name}.npy": content}).items()))
        refused(path, "")


@pytest.mark.parametrize("name", ["t", "q", "V", "meta"])
def test_member_that_is_there_twice_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path)
    with pytest.warns(UserWarning, match="Duplicate name"):
        pack(path, [*parts.items(), (f"{name}.npy", parts[f"{name}.npy"])])
    refused(path, rf"member: got '{name}\.npy' twice")


@pytest.mark.parametrize("name", ["../q.npy", "q", "Q.npy", "sub/q.npy", "q.npy.npy", "q/"])
def test_member_of_another_name_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    pack(path, [*members(path).items(), (name, npy(RECORD.q))])
    refused(path, "member: got ")


@pytest.mark.parametrize("name", ["t", "q", "tau", "meta"])
def test_member_that_is_missing_is_told(name: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path)
    del parts[f"{name}.npy"]
    pack(path, list(parts.items()))
    refused(path, f"members: got none of the name {name}")


def test_member_that_went_missing_is_missed(tmp_path: Path) -> None:
    """A run can be without weights: that the file once had them is in its list."""
    path = tmp_path / "run.npz"
    for name in ("weights", "V", "weights_norm"):
        parts = members(path)
        del parts[f"{name}.npy"]
        pack(path, list(parts.items()))
        refused(path, "arrays: got ")


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_other_compression_is_refused(method: int, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    pack(path, list(members(path).items()), method)
    refused(path, ".*: got compression")


BOMBS = """
import io, resource, sys, zipfile
import numpy as np, steadyarm as sa
def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
folder = sys.argv[1]
before = peak()
for name in sys.argv[2:]:
    try:
        sa.Run.load(f"{folder}/{name}")
    except ValueError as error:
        print(name, peak() - before < 40.0)
"""


def zeros(shape: tuple[int, ...]) -> np.ndarray:
    """An array that takes no memory before it is written."""
    return np.broadcast_to(np.float64(0.0), shape)


@pytest.mark.skipif(sys.platform != "linux", reason="reads the peak of memory as Linux counts it")
def test_file_that_unpacks_to_a_thousand_times_its_size_is_not_unpacked(tmp_path: Path) -> None:
    """Some 0.1 MB each that unpack to 100 MB and more: loading them takes less than 40 MB."""
    intact = members(tmp_path / "intact.npz")
    rows = 7_000_000
    bombs: dict[str, dict[str, bytes]] = {
        "unknown": {"surplus.npy": npy(zeros((2 * rows,)))},
        "one": {"q.npy": npy(zeros((rows, 2)))},
        "weights": {"weights.npy": npy(zeros((2, rows)))},
        "meta": {"meta.npy": npy("x" * 4 * rows)},
        "no array": {"q.npy": bytes(16 * rows)},
    }
    shapes = {name: np.load(io.BytesIO(part)).shape for name, part in intact.items()}
    bombs["all"] = {
        name: npy(zeros((rows // 27, *shape[1:])))
        for name, shape in shapes.items()
        if name not in ("meta.npy", "weights.npy")
    }
    for name, bomb in bombs.items():
        pack(tmp_path / name, list((intact | bomb).items()))
        assert (tmp_path / name).stat().st_size < 400_000
    command = [sys.executable, "-c", BOMBS, str(tmp_path), *bombs]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [f"{name} True" for name in bombs]


def test_size_that_lies_is_refused(tmp_path: Path) -> None:
    """The list of a zip file may name any size: no member can be a million times what it takes."""
    path = tmp_path / "run.npz"
    members(path)
    content = bytearray(path.read_bytes())
    entry = content.rindex(b"PK\x01\x02")
    content[entry + 24 : entry + 28] = (0xFFFFFFF0).to_bytes(4, "little")
    path.write_bytes(content)
    refused(path, r".*: got \d+ bytes for 4294967280")


def test_members_that_share_their_bytes_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    pack(path, list(members(path).items()), zipfile.ZIP_STORED)
    content = bytearray(path.read_bytes())
    at = content.index(b"PK\x01\x02")
    for _ in range(3):
        content[at + 20 : at + 28] = 2 * (len(content) - 100).to_bytes(4, "little")
        at = content.index(b"PK\x01\x02", at + 4)
    path.write_bytes(content)
    refused(path, "members: they overlap")
