"""What the README shows, runs."""

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[2] / "README.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("code", blocks("python"))
def test_python_examples_run(code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # some write a picture
    names: dict[str, object] = {}
    exec(compile(code, str(README), "exec"), names)


def test_python_example_has_12_statements_at_most_and_tracks() -> None:
    names: dict[str, object] = {}
    first = blocks("python")[0]
    exec(compile(first, str(README), "exec"), names)
    lines = [line for line in first.splitlines() if line.strip()]
    assert len(lines) <= 12
    run = names["run"]
    assert run.status.finished  # type: ignore[attr-defined]
    assert (run.metrics(window=(5, 10)).rms_e < 0.03).all()  # type: ignore[attr-defined]


def test_rust_example_is_whole_as_it_is_read() -> None:
    """What rustdoc hides, a reader does not have; that it compiles is tested as a doctest."""
    for code in blocks("rust"):
        assert "fn main()" in code
        assert not re.search(r"^\s*#(\s|$)", code, re.MULTILINE)


def test_every_file_that_is_linked_exists() -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", README.read_text(encoding="utf-8"))
    assert links
    assert not [link for link in links if not (README.parent / link).exists()]
