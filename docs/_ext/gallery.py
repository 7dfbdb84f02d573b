"""The gallery: runs every program of docs/gallery, and shows what it draws with its code.

A program says in its first lines what it is called and what to see, and has a function ``picture``
of the style, "light" or "dark". Pictures are made by the build, in its own folder.
"""

from __future__ import annotations

import ast
import importlib.util
import re
from html import escape
from pathlib import Path

import steadyarm
from sphinx.util.display import status_iterator

HOME = Path(__file__).parents[1] / "gallery"
PROGRAMS = sorted(HOME.glob("*.py"))
STYLES = ("light", "dark")
FOLDER = "_images/gallery"


def drawn(program: Path, folder: Path) -> list[Path]:
    """Run a program, and write its picture in both styles; return the files."""
    spec = importlib.util.spec_from_file_location(f"gallery_{program.stem}", program)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    files = [folder / f"{program.stem}-{style}.png" for style in STYLES]
    for style, file in zip(STYLES, files, strict=True):
        module.picture(style).savefig(file)
    return files


def draw(app):
    """Draw what is missing, or older than its program or the package."""
    if app.builder.format != "html":
        return
    folder = Path(app.outdir) / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    package = [*Path(steadyarm.__file__).parent.rglob("*.py"), Path(steadyarm._core.__file__)]
    newest = max(path.stat().st_mtime for path in package)
    stale = []
    for program in PROGRAMS:
        files = [folder / f"{program.stem}-{style}.png" for style in STYLES]
        since = max(newest, program.stat().st_mtime)
        if not all(file.exists() and file.stat().st_mtime > since for file in files):
            stale.append(program)
    for program in status_iterator(stale, "drawing... ", "darkgreen", len(stale)):
        drawn(program, folder)


def section(program: Path) -> str:
    """The section of a program: what to see, the picture, the code."""
    tree = ast.parse(program.read_text(encoding="utf-8"))
    title, _, words = ast.get_docstring(tree).partition("\n\n")
    first = tree.body[0].end_lineno + 2
    images = [
        f'<img class="only-{style}" loading="lazy" alt="{escape(title)}" '
        f'src="{FOLDER}/{program.stem}-{style}.png" style="width: 100%">'
        for style in STYLES
    ]
    code = f"```{{literalinclude}} gallery/{program.name}\n:language: python\n:lines: {first}-\n```"
    load = f"{{download}}`{program.name} <gallery/{program.name}>`"
    return "\n".join([f"## {title}\n", f"{words}\n", *images, "", f"{code}\n", f"{load}\n"])


def show(app, page, text):
    """Put the sections in the place of the list of programs."""

    def sections(match: re.Match[str]) -> str:
        return "\n".join(section(HOME / f"{name}.py") for name in match[1].split())

    if page == "gallery":
        text[0] = re.sub(r"(?s)```\{gallery\}\n(.*?)```\n", sections, text[0])


def redraw(app, env, added, changed, removed):
    """A page whose programs changed is read anew."""
    return ["gallery"]


def setup(app):
    """Connect it to Sphinx."""
    app.connect("builder-inited", draw)
    app.connect("source-read", show)
    app.connect("env-get-outdated", redraw)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
