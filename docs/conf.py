"""Sphinx configuration of the manual."""

import re
from importlib.metadata import version as installed

project = "steadyarm"
author = "The steadyarm developers"
copyright = f"2026, {author}"
release = version = installed("steadyarm")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"steadyarm {version}"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
# One name may belong to several classes: `rules`, `P`.
suppress_warnings = ["ref.python"]


SECTIONS = {"Parameters", "Attributes"}


def spread(lines):
    """Write ``name: text`` of a section as napoleon wants it, which would take text for a type."""
    within = False
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if below.startswith("---"):
            within = line in SECTIONS
        field = re.match(r"([\w, ]+): (.+)", line) if within else None
        yield from [field[1], "    " + field[2]] if field else [line]


def setup(app):
    """Prepare docstrings: |W| is a norm, which reStructuredText takes for a substitution."""

    def prepare(app, what, name, thing, options, lines):
        lines[:] = [line.replace("|", r"\|") for line in spread(lines)]

    app.connect("autodoc-process-docstring", prepare, priority=100)
