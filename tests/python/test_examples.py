"""The examples print what is written beside them, as their twins in Rust do."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
NUMBERED = sorted(EXAMPLES.glob("[0-9][0-9]_*.py"))

MOST_LINES = 40
"""An example is read in one go."""


@pytest.mark.parametrize("example", NUMBERED, ids=lambda path: path.stem)
def test_example_prints_what_is_written_beside_it(example, capsys):
    runpy.run_path(str(example), run_name="__main__")
    assert capsys.readouterr().out == example.with_suffix(".txt").read_text(encoding="utf-8")


def test_every_example_has_its_twin_and_is_short():
    assert [path.stem[:2] for path in NUMBERED] == ["01", "02", "03", "04", "05", "06"]
    assert [path.with_suffix("") for path in sorted(EXAMPLES.glob("[0-9][0-9]_*.rs"))] == [
        path.with_suffix("") for path in NUMBERED
    ]
    for path in EXAMPLES.glob("[0-9][0-9]_*.[pr]*"):
        assert len(path.read_text(encoding="utf-8").splitlines()) <= MOST_LINES, path.name
