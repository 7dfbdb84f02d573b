"""What a file of `Run.save` says beside its arrays: as a run would, or the file is refused."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from run_files import RECORD, members, npy, pack, refused
from scenes import plant, run, tracker


def meta_of(parts: dict[str, bytes]) -> dict[str, Any]:
    text: dict[str, Any] = json.loads(str(np.load(io.BytesIO(parts["meta.npy"]))))
    return text


META: list[tuple[str, dict[str, Any], str]] = [
    ("another format", {"format": 99}, "format: got 99, wants 2"),
    ("a text as format", {"format": "2"}, "format: got '2'"),
    ("an unknown status", {"status": {"kind": "tired", "t": 1.0, "reason": ""}}, "status: got 'ti"),
    ("no status", {"status": None}, "status: got None"),
    (
        "a status too many",
        {"status": {"kind": "finished", "t": 1.0, "reason": "", "x": 1}},
        "status",
    ),
    ("a status too few", {"status": {"kind": "finished", "t": 1.0}}, "status: got"),
    ("a list as status", {"status": ["finished", 0.01, ""]}, "status: got"),
    ("a kind that is no text", {"status": {"kind": [], "t": 1.0, "reason": ""}}, "status: got"),
    (
        "a time that is no number",
        {"status": {"kind": "finished", "t": "x", "reason": ""}},
        "status",
    ),
    ("true as time", {"status": {"kind": "finished", "t": True, "reason": ""}}, "status.t"),
    (
        "an infinite time",
        {"status": {"kind": "finished", "t": 1e999, "reason": ""}},
        "meta: got Inf",
    ),
    (
        "a reason that is none",
        {"status": {"kind": "finished", "t": 1.0, "reason": 3}},
        "reason: got 3",
    ),
    (
        "a time before the run",
        {"status": {"kind": "diverged", "t": -1.0, "reason": "q"}},
        "status.t: got -1.0, wants a time >= 0",
    ),
    (
        "a reason that moves the cursor",
        {"status": {"kind": "diverged", "t": 0.01, "reason": "\x1b[2J"}},
        r"reason: got '.x1b\[2J', wants a line of text",
    ),
    ("no certificate's keys", {"certificate": {}}, "certificate: got"),
    ("a text as certificate", {"certificate": "good"}, "certificate: got"),
    ("a list of arrays", {"arrays": ["q"]}, "arrays: got"),
    ("no list of arrays", {"arrays": 3}, "arrays: got"),
    ("a key more", {"surplus": 1}, "meta: got"),
    ("a dictionary without figures", {"dictionary": {}}, "dictionary: got"),
    (
        "a dictionary of parts",
        {"dictionary": dict(atoms=1.5, capacity=2, merged=0, dropped=0, error_bound=[0.0, 0.0])},
        "atoms: got 1.5",
    ),
    (
        "a bound of another arm",
        {"dictionary": dict(atoms=1, capacity=2, merged=0, dropped=0, error_bound=[0.0])},
        "error_bound: got",
    ),
]


@pytest.mark.parametrize(("change", "why"), [row[1:] for row in META], ids=[r[0] for r in META])
def test_wrong_description_is_refused(change: dict[str, Any], why: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path)
    parts["meta.npy"] = npy(json.dumps(meta_of(parts) | change))
    pack(path, list(parts.items()))
    refused(path, why)


@pytest.mark.parametrize("figure", ["residual", "v_start", "uncertainty"])
@pytest.mark.parametrize("value", ["NaN", "1e999", "null", "true", '"1"', "[1]"])
def test_certificate_without_a_number_is_refused(figure: str, value: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path)
    meta = meta_of(parts)
    meta["certificate"][figure] = "HERE"
    parts["meta.npy"] = npy(json.dumps(meta).replace('"HERE"', value))
    pack(path, list(parts.items()))
    refused(path, rf"({figure}|meta): got")


@pytest.mark.parametrize(
    "text",
    ["", "[]", "3", "null", "{", "[" * 100_000, '{"format": 2, "format": 2}', '"' + "x" * 300_000],
)
def test_other_json_is_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path) | {"meta.npy": npy(text)}
    pack(path, list(parts.items()))
    refused(path, "")


def test_key_that_is_there_twice_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path)
    text = json.dumps(meta_of(parts)).replace('"kind"', '"t": 1.0, "kind"')
    pack(path, list((parts | {"meta.npy": npy(text)}).items()))
    refused(path, "meta: got a key twice")


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"q": np.where(RECORD.q == RECORD.q[5], np.nan, RECORD.q)}, r"q\[5, 0\]: got nan"),
        ({"t": RECORD.t[::-1]}, r"t\[1\]: got 0\.009"),
        ({"tau": RECORD.tau[:3]}, "tau: got 3 rows"),
        ({"e": RECORD.e.astype(np.float32)}, "e: got float32"),
        ({"status": sa.Status("tired", 1.0)}, "status: got 'tired'"),
        ({"status": sa.Status("finished", float("nan"))}, "meta: got NaN"),
    ],
)
def test_what_could_not_be_loaded_is_not_saved(
    change: dict[str, Any], why: str, tmp_path: Path
) -> None:
    path = tmp_path / "run.npz"
    RECORD.save(path)
    with pytest.raises(ValueError, match=rf"^run: got one that no simulation records \({why}"):
        replace(RECORD, **change).save(path)
    assert np.array_equal(sa.Run.load(path).q, RECORD.q)


def test_runs_of_every_kind_come_back(tmp_path: Path) -> None:
    basis = sa.FuzzyBasis("grid", [-1.0, 0.0, 1.0], 0.5)
    kernel = sa.FuzzyCompensator(basis, gain=7.0, dictionary=16)
    runs = {
        "motion": run(tracker(), record="motion"),
        "thinned": run(tracker(), record_every=7),
        "error control": run(tracker(), method="dp54", dt=1e-2),
        "kernel": run(sa.ComputedTorque(sa.paper.nominal(), 8, 5.5, kernel)),
        "at rest": sa.simulate(
            plant(), tracker(), lambda t: (np.zeros(2),) * 3, 20.0, record_every=1
        ),
        "other order": replace(RECORD, q=np.asfortranarray(RECORD.q)),
    }
    for name, record in runs.items():
        path = tmp_path / name
        record.save(path)
        loaded = sa.Run.load(path)
        for array in ("t", "q", "tau", "weights", "V", "q_d"):
            assert np.array_equal(getattr(loaded, array), getattr(record, array)), (name, array)
        assert (loaded.status, loaded.certificate) == (record.status, record.certificate)
        if record.dictionary is not None:
            assert loaded.dictionary is not None
            assert str(loaded.dictionary) == str(record.dictionary)
