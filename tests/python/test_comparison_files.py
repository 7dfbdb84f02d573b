"""Files of comparisons give back what was written, and say what is broken."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from comparisons import HOSTILE, VALUES, row, rows
from hypothesis import given
from hypothesis import strategies as st
from steadyarm.comparison import FIGURES, STATUSES, Comparison, Row

INF = math.inf

NUMBERS = st.none() | st.floats(allow_nan=False) | st.sampled_from(VALUES)
TEXTS = st.text(st.characters(exclude_categories=("Cs",)), max_size=20) | st.sampled_from(HOSTILE)
ROWS = st.builds(
    Row,
    controller=TEXTS.filter(bool),
    scenario=TEXTS,
    seed=st.integers(-(2**63), 2**64),
    status=st.sampled_from(STATUSES),
    reason=TEXTS,
    **dict.fromkeys(FIGURES, NUMBERS),
    by_joint=st.dictionaries(
        st.sampled_from([name for name in FIGURES if name != "step_time"]),
        st.lists(NUMBERS, max_size=3),
        max_size=3,
    ),
)


@given(st.lists(ROWS, max_size=4), TEXTS, st.lists(TEXTS, max_size=2))
def test_files_give_back_what_was_written(
    tmp_path_factory: pytest.TempPathFactory, made: list[Row], scenario: str, notes: list[str]
) -> None:
    file = tmp_path_factory.mktemp("files") / "table"
    comparison = Comparison(made, scenario=scenario, notes=notes)
    comparison.to_json(file)
    again = Comparison.from_json(file)
    assert again == comparison
    assert [each.step_time for each in again.rows] == [each.step_time for each in made]
    comparison.to_csv(file)
    again = Comparison.from_csv(file)
    assert again == Comparison(made)
    assert [each.step_time for each in again.rows] == [each.step_time for each in made]


def test_json_keeps_curves_to_the_last_digit(tmp_path: Path) -> None:
    comparison = Comparison([row(), Row("x", "s", 0, "refused", "no")])
    comparison.to_json(tmp_path / "table.json")
    curves, none = (each.curves for each in Comparison.from_json(tmp_path / "table.json").rows)
    kept = comparison.rows[0].curves
    assert none is None and curves is not None and kept is not None
    for name in ("t", "e", "tau", "q"):
        assert (getattr(curves, name) == getattr(kept, name)).all()


def test_json_is_json_with_a_version(tmp_path: Path) -> None:
    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    Comparison([Row("x", itae=INF, by_joint={"itae": (INF,)})]).to_json(tmp_path / "a")
    plain = json.loads((tmp_path / "a").read_text(), parse_constant=refuse)
    assert plain["format"] == "steadyarm comparison" and plain["version"] == 1
    assert plain["units"]["itae"] == "rad·s²" and plain["rows"][0]["itae"] == "inf"


BROKEN_JSON = {
    "": "wants a JSON file",
    "[" * 100_000: "wants a JSON file",
    "{}": "wants a file with the format 'steadyarm comparison'",
    '{"format": "steadyarm comparison", "version": 2}': "version: got 2, wants 1",
    '{"format": "steadyarm comparison", "version": 1}': "rows: got None, wants a list",
}


@pytest.mark.parametrize("content", BROKEN_JSON, ids=range(len(BROKEN_JSON)))
def test_another_file_is_refused(content: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(content)
    with pytest.raises(ValueError, match=r"a\.json: ") as caught:
        Comparison.from_json(tmp_path / "a.json")
    assert BROKEN_JSON[content] in str(caught.value)


BROKEN_ROWS = {
    "controller": (None, "controller: got None, wants text"),
    "seed": (1.5, "seed: got 1.5, wants an int"),
    "status": ("fine", "status: got 'fine', wants one of finished"),
    "rms_e": ("many", "rms_e: got 'many', wants a number"),
    "itae": (True, "itae: got True, wants a number"),
    "saturated": ([], r"saturated: got \[\], wants a number"),
    "by_joint": ({"itae": 1}, "by_joint: wants an object of lists"),
    "curves": ({"t": [0, 1], "e": [[1]], "tau": [[1]], "q": [[1]]}, r"curves\.e: got the shape"),
    "surprise": (1, "got a key 'surprise', wants some of"),
}


@pytest.mark.parametrize("key", BROKEN_ROWS)
def test_a_broken_row_is_named(key: str, tmp_path: Path) -> None:
    Comparison([row(), row()]).to_json(tmp_path / "a")
    plain = json.loads((tmp_path / "a").read_text())
    value, message = BROKEN_ROWS[key]
    plain["rows"][1][key] = value
    (tmp_path / "a").write_text(json.dumps(plain))
    with pytest.raises(ValueError, match=rf"rows\[1\]: {message}"):
        Comparison.from_json(tmp_path / "a")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"seed"', '"sead"', "wants a column 'seed'"),
        ('"rms_e"', '"rms_f"', "row 2: got a column 'rms_f', wants one of"),
        (",0,", ",zero,", "row 2: seed: got 'zero', wants a whole number"),
        ('"finished"', '"fine"', "row 2: status: got 'fine'"),
        ('"finished"', '"finished", "more"', "row 2: got .* cells, wants"),
        ('"finished"', '"finished', "wants a CSV file|cells, wants"),
    ],
)
def test_a_broken_line_is_named(old: str, new: str, message: str, tmp_path: Path) -> None:
    Comparison([row()]).to_csv(tmp_path / "a.csv")
    text = (tmp_path / "a.csv").read_text()
    (tmp_path / "a.csv").write_text(text.replace(old, new, 1))
    with pytest.raises(ValueError, match=message):
        Comparison.from_csv(tmp_path / "a.csv")


def test_the_same_rows_give_the_same_bytes(tmp_path: Path) -> None:
    def written(name: str) -> list[bytes]:
        comparison = Comparison([row(), *rows(2)], scenario="twice", notes=["a note"])
        comparison.to_csv(tmp_path / name)
        csv = (tmp_path / name).read_bytes()
        comparison.to_json(tmp_path / name)
        json = (tmp_path / name).read_bytes()
        return [csv, json, str(comparison).encode(), comparison.to_markdown().encode()]

    assert written("first") == written("second")
