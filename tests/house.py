"""Counts the house: how large its rooms are, and what is tangled.

    python tests/house.py [WHEEL]

Run it before and after a change of structure. The limits are in tests/core/layers/mod.rs.
Without an argument the newest wheel under target/ is weighed. Standard library only.
"""

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from zipfile import ZipFile

ROOT = Path(__file__).resolve().parents[1]
SRC = ROOT / "src"
TREES = ("src", "python", "tests", "benches", "examples")
LONG_FILE, LONG_FUNCTION, WIDE = 300, 40, 100

ASIDE = re.compile(
    r"//[^\n]*|/\*.*?\*/|b?r(#*)\".*?\"\1|b?\"(?:\\.|[^\"\\])*\"|b?'(?:\\.|[^'\\\n])'", re.DOTALL
)
"""Comments, strings and characters of Rust."""


def code(path: Path) -> str:
    """Return Rust without comments and strings; lines stay where they are."""
    text = path.read_text(encoding="utf-8")
    return ASIDE.sub(lambda aside: "\n" * aside[0].count("\n"), text)


def files(*trees: str, kinds: str = ".rs .py .pyi") -> list[Path]:
    """Return the source files of these folders, without what was built."""
    found = (path for tree in trees for path in sorted((ROOT / tree).rglob("*.*")))
    return [path for path in found if path.suffix in kinds.split() and "target" not in path.parts]


def closing(text: str, start: int) -> int:
    """Return the place of the bracket that closes the one at ``start``."""
    depth = 0
    for sign in re.compile(r"[{}()\[\]]").finditer(text, start):
        depth += 1 if sign[0] in "{([" else -1
        if depth == 0:
            return sign.start()
    return len(text)


def functions(path: Path) -> Iterator[tuple[int, str]]:
    """Yield lines and name of every function, from its first line to its last."""
    if path.suffix != ".rs":
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and node.end_lineno:
                yield node.end_lineno - node.lineno + 1, f"{path.relative_to(ROOT)} {node.name}"
        return
    text = code(path)
    for found in re.finditer(r"\bfn\s+(\w+)", text):
        place = found.end()
        while place < len(text) and text[place] not in "{;":
            place = closing(text, place) + 1 if text[place] in "([" else place + 1
        if text[place : place + 1] == "{":
            lines = text.count("\n", found.start(), closing(text, place)) + 1
            yield lines, f"{path.relative_to(ROOT)} {found[1]}"


def exposed() -> list[str]:
    """Return what Rust gives Python, after the stub: classes, functions, methods, attributes."""
    names = []

    def visit(body: list[ast.stmt], owner: str) -> None:
        for node in body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                name = node.name
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                name = node.target.id
            else:
                continue
            if not name.startswith("_") and owner + name not in names:
                names.append(owner + name)
                if isinstance(node, ast.ClassDef):
                    visit(node.body, f"{name}.")

    visit(ast.parse((ROOT / "python/steadyarm/_core.pyi").read_text(encoding="utf-8")).body, "")
    return names


def test_binaries() -> int:
    """Return how many programs `cargo test` links for tests/."""
    manifest = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))
    named = {test["name"] for test in manifest.get("test", ())}
    if manifest["package"].get("autotests", True):
        named |= {path.stem for path in (ROOT / "tests").glob("*.rs")}
        named |= {path.parent.name for path in (ROOT / "tests").glob("*/main.rs")}
    return len(named)


def known_circles() -> int:
    """Return how many circles tests/core/layers/circles.rs lists, which finds no other."""
    text = (ROOT / "tests/core/layers/circles.rs").read_text(encoding="utf-8")
    return int(re.findall(r"const KNOWN: \[&\[&str\]; (\d+)\]", text)[0])


def say(what: str, count: object, details: list[str] | None = None) -> None:
    """Print one count, and what it is made of."""
    print(f"{what:<44}{count!s:>8}")
    for detail in details or ():
        print(f"    {detail}")


def main() -> None:
    """Print all counts."""
    lines = {path: path.read_text(encoding="utf-8").splitlines() for path in files(*TREES)}
    own = [path for path in lines if path.is_relative_to(SRC)]
    binding = sum(len(lines[path]) for path in own if path.is_relative_to(SRC / "python"))
    names = exposed()
    say("names that Rust exposes to Python", len(names))
    say("lines of src/python", binding)
    say("lines per exposed name", f"{binding / len(names):.1f}")
    say("lines of a file of src, median", f"{median(len(lines[path]) for path in own):g}")
    long = [(len(text), path.relative_to(ROOT)) for path, text in lines.items()]
    long = [f"{count} {path}" for count, path in long if count > LONG_FILE]
    in_src = [entry for entry in long if " src/" in entry]
    say(f"files over {LONG_FILE} lines, src", len(in_src), in_src)
    say(f"files over {LONG_FILE} lines, all", len(long))
    for tree in ("src", "python"):
        found = [f for p in files(tree, kinds=".rs .py") for f in functions(p)]
        long = [f"{n} {name}" for n, name in sorted(found, reverse=True) if n > LONG_FUNCTION]
        say(f"functions over {LONG_FUNCTION} lines, {tree}", len(long), long)
    say("circles of use between files", known_circles())
    for tree in TREES:
        wide = sum(len(line) > WIDE for path in files(tree) for line in lines[path])
        say(f"lines over {WIDE} columns, {tree}", wide)
    say("test binaries", test_binaries())
    built = sorted((ROOT / "target").glob("**/*.whl"), key=lambda path: path.stat().st_mtime)
    for wheel in [Path(arg) for arg in sys.argv[1:]] or built[-1:]:
        library = max(ZipFile(wheel).infolist(), key=lambda member: member.file_size)
        say(f"wheel [bytes], {wheel.parent.name}", wheel.stat().st_size)
        say("    its library, unpacked [bytes]", library.file_size)


if __name__ == "__main__":
    main()
