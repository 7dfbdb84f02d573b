"""The script that counts the house counts right."""

import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
sys.path.insert(0, str(TESTS))

from circles import Uses  # noqa: E402
from house import exposed, functions  # noqa: E402

FILES = {
    "lib.rs": "pub mod a; mod b; mod c; mod room; pub use error::Error;",
    "a.rs": "use crate::b::{self, Y}; // use crate::c::Z;",
    "b.rs": 'use crate::room::Inner; const X: &str = "crate::c::Z";',
    "c.rs": "use crate::a::X;\n#[cfg(test)]\nmod tests { use crate::c::Z; }",
    "room/mod.rs": "mod inner; mod other; pub use inner::Inner; pub struct Own;",
    "room/inner.rs": "use super::Own; use std::fmt;",
    "room/other.rs": "fn f() { crate::a::g() }",
}


def circles(src: Path, **changed: str) -> list[list[str]]:
    for name, text in (FILES | {f"{name}.rs": text for name, text in changed.items()}).items():
        (src / name).parent.mkdir(exist_ok=True)
        (src / name).write_text(text)
    return Uses(src).circles()


def test_no_circle_where_none_is(tmp_path: Path) -> None:
    assert circles(tmp_path) == []


def test_a_circle_goes_through_reexports_and_inline_paths(tmp_path: Path) -> None:
    inner = "use super::other::O;"  # a → b → room/inner → room/other → a
    assert circles(tmp_path, **{"room/inner": inner}) == [["a", "b", "room/inner", "room/other"]]


def test_a_folder_that_uses_its_file_is_a_circle_only_upward(tmp_path: Path) -> None:
    room = FILES["room/mod.rs"] + " use inner::Hidden;"
    assert circles(tmp_path, **{"room/mod": room}) == [["room", "room/inner"]]
    assert Uses(tmp_path).circles(upward=False) == []


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
