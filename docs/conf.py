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
html_theme = "furo"
html_title = f"steadyarm {version}"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
