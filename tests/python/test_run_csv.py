"""The CSV of a run: the same numbers to the bit, under names that say signal and joint."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from scenes import run, tracker

RECORD = run(tracker(), duration=0.05)


def read(path: Path) -> tuple[list[str], np.ndarray]:
    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = list(csv.reader(file))
    return head, np.array(rows, dtype=float)


def test_all_signals_come_back_to_the_bit(tmp_path: Path) -> None:
    RECORD.to_csv(tmp_path / "run.csv")
    head, rows = read(tmp_path / "run.csv")
    assert head[:3] == ["t", "q_1", "q_2"] and len(set(head)) == len(head)
    columns = dict(zip(head, rows.T, strict=True))
    for name, array in RECORD.to_dict().items():
        parts = [(name, array)]
        if array.ndim == 2:
            parts = [(f"{name}_{joint + 1}", array[:, joint]) for joint in range(2)]
        for column, true in parts:
            assert np.array_equal(columns.pop(column), true), column
    assert not columns


def test_chosen_signals_come_in_their_order_after_the_time(tmp_path: Path) -> None:
    RECORD.to_csv(tmp_path / "run.csv", ["tau", "V", "q_d"])
    head, rows = read(tmp_path / "run.csv")
    assert head == ["t", "tau_1", "tau_2", "V", "q_d_1", "q_d_2"]
    assert rows.shape == (len(RECORD.t), 6) and np.array_equal(rows[:, 3], RECORD.V)


def test_a_run_without_torques_has_no_columns_of_them(tmp_path: Path) -> None:
    run(tracker(), duration=0.01, record="motion").to_csv(tmp_path / "run.csv")
    head, _ = read(tmp_path / "run.csv")
    assert "e_2" in head and not [name for name in head if name.startswith("tau")]


def test_what_is_not_there_is_named_and_the_old_file_stays(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("old")
    with pytest.raises(ValueError, match=r"^names: got 'torque', wants some of t, q, "):
        RECORD.to_csv(path, ["torque"])
    with pytest.raises(TypeError, match=r"^names: got the text 'tau', wants a list of signals"):
        RECORD.to_csv(path, "tau")
    assert path.read_text() == "old"
