"""Notebooks that a reader can run: each page of docs/notebooks as .ipynb, beside its page."""

from __future__ import annotations

import re
from pathlib import Path

import nbformat
from myst_nb.core.read import read_myst_markdown_notebook

PAGES = "https://steadyarm.github.io/steadyarm/"


def offer(app, page, text):
    """Write the link below the title."""
    if page.startswith("notebooks/"):
        name = f"{page.removeprefix('notebooks/')}.ipynb"
        link = f'<p><a href="{name}" download>Download as a notebook</a></p>'
        text[0] = re.sub(r"(?m)^(# .+)$", rf"\1\n\n{link}", text[0], count=1)


def written(text: str) -> nbformat.NotebookNode:
    """The notebook of a page, without what a reader of the page does not see."""
    notebook = read_myst_markdown_notebook(
        re.sub(r"\]\(\.\./([\w/]+)\.md", rf"]({PAGES}\1.html", text)
    )
    shown = (it for it in notebook.cells if "remove-cell" not in it.metadata.get("tags", []))
    notebook.cells = list(shown)
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number}"
    return notebook


def write(app, error):
    """Write the notebooks beside their pages."""
    if error or app.builder.format != "html":
        return
    for page in sorted(Path(app.srcdir).glob("notebooks/*.md")):
        notebook = written(page.read_text(encoding="utf-8"))
        nbformat.write(notebook, Path(app.outdir) / "notebooks" / f"{page.stem}.ipynb")


def setup(app):
    """Connect it to Sphinx."""
    app.add_css_file("notebooks.css")
    app.connect("source-read", offer)
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
