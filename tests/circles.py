"""Circles of `use` between the files of src: a uses b, and b by some way a."""

import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SRC = ROOT / "src"

Module = tuple[str, ...]
"""The path of a module in the crate, which is that of its file in src."""

ASIDE = re.compile(
    r"//[^\n]*|/\*.*?\*/|b?r(#*)\".*?\"\1|b?\"(?:\\.|[^\"\\])*\"|b?'(?:\\.|[^'\\\n])'", re.DOTALL
)
"""Comments, strings and characters of Rust."""


def code(path: Path) -> str:
    """Return Rust without comments and strings; lines stay where they are."""
    text = path.read_text(encoding="utf-8")
    return ASIDE.sub(lambda aside: "\n" * aside[0].count("\n"), text)


def leaves(tree: str) -> Iterator[Module]:
    """Yield the paths of ``a::{b::C, d as e, self}``, with the name at their end that is taken."""
    head, brace, group = tree.partition("{")
    start = tuple(part.strip() for part in head.split("::") if part.strip())
    if not brace:
        yield (*start[:-1], start[-1].split(" as ")[0])
        return
    for item in re.findall(r"(?:[^{},]|\{(?:[^{}]|\{[^{}]*\})*\})+", group.rsplit("}", 1)[0]):
        yield from ((*start, *leaf) for leaf in leaves(item) if leaf) if item.strip() else ()


class Uses:
    """Which file of src uses what stands in which other; re-exports count for what they name."""

    def __init__(self, src: Path = SRC) -> None:
        self.modules: dict[Module, str] = {}
        for path in sorted(src.rglob("*.rs")):
            parts = path.relative_to(src).with_suffix("").parts
            module = parts[:-1] if parts[-1] in ("mod", "lib") else parts
            self.modules[module] = re.split(r"#\[cfg\(test\)\]\s*mod", code(path))[0]
        self.public: dict[tuple[Module, str], Module] = {}
        self.wanted: dict[Module, set[Module]] = {m: set() for m in self.modules}
        for module, text in self.modules.items():
            for public, tree in re.findall(r"(pub(?:\([^)]*\))?\s+)?\buse\s+([^;]+);", text):
                for leaf in leaves(tree):
                    path = self.absolute(module, leaf)
                    if public:
                        self.public[module, path[-1]] = path
                    else:
                        self.wanted[module].add(path)
            body = re.sub(r"\buse\s[^;]+;|\bpub\(in [^)]*\)", "", text)
            for inline in re.findall(r"\b(?:crate|super|self)(?:::\w+)+|\b[a-z_]\w*::\w+", body):
                self.wanted[module].add(self.absolute(module, tuple(inline.split("::"))))

    def absolute(self, module: Module, path: Module) -> Module:
        """Return a path from the root of the crate."""
        if path[0] == "crate":
            return path[1:]
        own = path[0] in ("self", "super") or (*module, path[0]) in self.modules
        while path and path[0] in ("self", "super"):
            module = module if path[0] == "self" else module[:-1]
            path = path[1:]
        return (*module, *path) if own else path

    def home(self, path: Module, depth: int = 0) -> Module | None:
        """Return the module in whose file stands what a path names; None for other crates."""
        module: Module = ()
        for place, part in enumerate(path):
            if (*module, part) in self.modules:
                module = (*module, part)
            elif (module, part) in self.public and depth < 9:
                return self.home((*self.public[module, part], *path[place + 1 :]), depth + 1)
            else:
                return module if place or part in ("Error", "Result") else None
        return module

    def circles(self, upward: bool = True) -> list[list[str]]:
        """Return the groups of files that use each other, directly or by way of others.

        Without ``upward``, what a file uses of the mod.rs above it does not count.
        """
        edges = {m: {self.home(path) for path in paths} - {m} for m, paths in self.wanted.items()}
        if not upward:
            above = {m: {m[:depth] for depth in range(len(m))} for m in edges}
            edges = {m: near - above[m] for m, near in edges.items()}
        reach = {module: set(near) & set(self.modules) for module, near in edges.items()}
        for middle in reach:
            for module, far in reach.items():
                if middle in far:
                    reach[module] = far | reach[middle]
        groups = {frozenset(b for b in reach[a] if a in reach[b]) for a in reach if a in reach[a]}
        return sorted(sorted("/".join(module) or "lib" for module in group) for group in groups)
