"""Sphinx configuration of the manual."""

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


def setup(app):
    """Let docstrings write a norm as |W|, which reStructuredText takes for a substitution."""

    def escape(app, what, name, thing, options, lines):
        lines[:] = [line.replace("|", r"\|") for line in lines]

    app.connect("autodoc-process-docstring", escape, priority=100)
