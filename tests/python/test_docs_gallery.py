"""The programs of the gallery are short, say what to see, and draw in both styles."""

import ast
import importlib.util
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from steadyarm import plots

ROOT = Path(__file__).parents[2]
PROGRAMS = sorted((ROOT / "docs/gallery").glob("*.py"))

CHEAP = ("approximation", "tip", "torque_parts")
"""All are drawn by `make docs`."""


def loaded(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / f"docs/gallery/{name}.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", CHEAP)
def test_program_draws_in_both_styles(name: str) -> None:
    picture = loaded(name).picture
    for style, look in (
        ("light", plots.Picture(style="light")),
        ("dark", plots.Picture(style="dark")),
    ):
        drawn = picture(style)
        assert drawn.get_facecolor() == look.get_facecolor()
        assert drawn.axes


def test_program_runs_alone(tmp_path: Path) -> None:
    program = ROOT / "docs/gallery/approximation.py"
    subprocess.run([sys.executable, program], cwd=tmp_path, check=True, timeout=120)
    assert (tmp_path / "approximation.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_program_has_a_title_what_to_see_and_25_lines(program: Path) -> None:
    text = program.read_text(encoding="utf-8")
    tree = ast.parse(text)
    title, _, words = (ast.get_docstring(tree) or "").partition("\n\n")
    assert title
    assert "\n" not in title
    assert words.endswith(".")
    assert len(text.splitlines()[tree.body[0].end_lineno :]) <= 25 + 1  # a blank one before them
    assert f'picture().savefig("{program.stem}.png")' in text


def test_page_has_every_program_once() -> None:
    text = (ROOT / "docs/gallery.md").read_text(encoding="utf-8")
    (listed,) = re.findall(r"(?s)```\{gallery\}\n(.*?)```", text)
    assert sorted(listed.split()) == [program.stem for program in PROGRAMS]
