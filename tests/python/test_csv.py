"""Motions in CSV: what `Table.from_csv` reads, and what it says of a file that is none."""

from pathlib import Path

import numpy as np
import pytest
import steadyarm as sa

T = np.linspace(0.0, 2.0, 21)
PATH = sa.Quintic((0.0, 1.0), goal=(1.0, -0.5), duration=2.0)


def written(file: Path, **signals: np.ndarray) -> Path:
    """A file of these signals, all digits, with columns as `Run.to_csv` names them."""
    names = ["t"] + [f"{name}_{joint + 1}" for name in signals for joint in range(2)]
    rows = np.column_stack([T, *signals.values()]).tolist()
    lines = [",".join(names), *(",".join(map(repr, row)) for row in rows)]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def test_reads_positions_alone(tmp_path: Path) -> None:
    q, _, _ = PATH(T)
    assert sa.Table.from_csv(written(tmp_path / "a.csv", q=q)) == sa.Table(T, q)


def test_reads_velocities_where_there_are_accelerations_too(tmp_path: Path) -> None:
    q, dq, ddq = PATH(T)
    whole = sa.Table.from_csv(written(tmp_path / "a.csv", q=q, dq=dq, ddq=ddq))
    assert whole == sa.Table(T, q, dq, ddq)
    assert sa.Table.from_csv(written(tmp_path / "b.csv", q=q, dq=dq)) == sa.Table(T, q)


def test_reads_what_was_desired_when_asked_to(tmp_path: Path) -> None:
    q, dq, ddq = PATH(T)
    file = written(tmp_path / "a.csv", q=q + 0.1, q_d=q, dq_d=dq, ddq_d=ddq, tau=q)
    made = sa.Table.from_csv(file, desired=True, start_time=1.0)
    assert made == sa.Table(T, q, dq, ddq, start_time=1.0)
    assert sa.Table.from_csv(str(file)) == sa.Table(T, q + 0.1)


def test_reads_what_spreadsheets_write(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_bytes("\ufefft, q_1,note\r\n0,1.0,begin\r\n\r\n1,2.0,\r\n".encode())
    assert sa.Table.from_csv(file) == sa.Table([0, 1], [[1.0], [2.0]])


WRONG = {
    "": "got nothing, wants a CSV file with a line of names",
    "time,q_1\n0,1\n": r"got the columns time, q_1; wants one named t \[s\]",
    "t,q_2\n0,1\n": "got the columns q_2; wants q_1 to q_1, a column a joint",
    "t,q_1,q_3\n0,1,2\n1,1,2\n": "got the columns q_1, q_3; wants q_1 to q_2",
    "t,q_0,q_1\n0,1,5\n1,2,6\n": "got the columns q_0, q_1; wants q_1 to q_2",
    "t,q_1,q_2,dq_1\n0,1,2,3\n1,1,2,3\n": "got the columns dq_1; wants dq_1 to dq_2",
    "t;q_1\n0;1\n": "got columns parted by ';', wants commas",
    "t,q_d_1\n0,1\n1,2\n": "wants q_1 and so on; desired=True reads q_d_1",
    "t,q_1,q_1\n0,1,1\n": "got two columns 'q_1'",
    "t,q_1\n0,1\n1,x\n": "row 2: q_1: got 'x', wants a finite number",
    "t,q_1\n0,1\n1\n": "row 2: got 1 cells, wants 2",
    "t,q_1\n0,1\n1,\n": "row 2: q_1: got '', wants a finite number",
    "t,q_1\n0,1\n0,2\n": r"t\[1\]: got 0, wants a later time",
}


@pytest.mark.parametrize("text", WRONG)
def test_a_file_that_is_none_is_refused_in_words(text: str, tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=WRONG[text]):
        sa.Table.from_csv(file)


def test_bytes_that_are_no_text_are_refused_with_the_file(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"t,q_1\n0,\xff\n")
    with pytest.raises(ValueError, match=r"a\.csv: got .* wants a CSV file in UTF-8"):
        sa.Table.from_csv(tmp_path / "a.csv")


def test_a_file_that_is_not_there_is_an_error_of_the_system(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"a\.csv"):
        sa.Table.from_csv(tmp_path / "a.csv")
