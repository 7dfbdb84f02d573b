"""The script that counts the house counts right."""

import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
sys.path.insert(0, str(TESTS))

from house import exposed, functions  # noqa: E402


@pytest.mark.parametrize("braces", ["", '"{"', "'{'", "// {", "b'{'", 'r#"{"#'])
def test_functions_have_the_lines_from_name_to_brace(
    braces: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("house.ROOT", tmp_path)
    file = tmp_path / "x.rs"
    file.write_text(
        f"fn a(x: [u8; 3]) -> u8\n{{\n    {braces}\n}}\nfn b() {{}}\ntrait T {{ fn c(); }}"
    )
    assert [(lines, name.split()[1]) for lines, name in functions(file)] == [(4, "a"), (1, "b")]


def test_exposed_names_are_public_and_counted_once() -> None:
    names = exposed()
    assert len(names) == len(set(names))
    assert {"Serial", "Serial.from_urdf", "ComputedTorque.weights", "care"} <= set(names)
    assert not [name for name in names if "._" in f".{name}"]


def test_it_prints_every_count_once() -> None:
    done = subprocess.run([sys.executable, TESTS / "house.py"], capture_output=True, check=True)
    lines = [line for line in done.stdout.decode().splitlines() if not line.startswith("    ")]
    counts = dict(line.rsplit(maxsplit=1) for line in lines)
    assert len(counts) == len(lines)
    assert float(counts["lines per exposed name"]) > 0 and int(counts["test binaries"]) > 0
