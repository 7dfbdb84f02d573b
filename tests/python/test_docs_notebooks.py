"""The notebooks of the manual: their code runs, and gives the figures of their text."""

import re
from pathlib import Path
from typing import Any

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs/notebooks").glob("*.md"))


def cells(page: Path) -> list[tuple[str, str]]:
    """Options and code of every cell of code."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"(?s)```\{code-cell\} ipython3\n(.*?)```", text)
    form = r"(?s)((?:---\n.*?\n---\n)|(?::\w+:[^\n]*\n)*)(.*)"
    return [re.fullmatch(form, block).groups() for block in blocks]  # type: ignore[union-attr]


def test_code_of_a_notebook_runs_and_gives_the_figures_of_its_text() -> None:
    """Of the one that takes least time; `make docs` runs all."""
    names: dict[str, Any] = {}
    for _, code in cells(next(page for page in NOTEBOOKS if page.stem == "tracking_error")):
        exec(compile(code, "tracking_error.md", "exec"), names)


@pytest.mark.parametrize("page", NOTEBOOKS, ids=lambda page: page.stem)
def test_last_cell_checks_the_figures_of_the_text_and_is_not_shown(page: Path) -> None:
    options, code = cells(page)[-1]
    assert "remove-cell" in options
    assert code.count("assert ") > 2


@pytest.mark.parametrize("page", NOTEBOOKS, ids=lambda page: page.stem)
def test_every_picture_has_words_for_who_does_not_see_it(page: Path) -> None:
    drawing = [options for options, code in cells(page) if re.search(r"\bplots?[.(]", code)]
    assert len(drawing) > 1
    assert all("alt: " in options for options in drawing)
