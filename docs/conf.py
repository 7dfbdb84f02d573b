"""Sphinx configuration of the manual."""

import sys
from importlib.metadata import version as installed
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "steadyarm"
author = "The steadyarm developers"
copyright = f"2026, {author}"
release = version = installed("steadyarm")

# myst_nb brings myst_parser.
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "commands",
    "mathml",
    "api",
    "gallery",
    "notebooks",
]
source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb"}
exclude_patterns = ["_build", "_ext"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
myst_html_meta = {
    "description": "steadyarm: tracking control of robot arms whose dynamics nobody knows exactly",
}
html_math_renderer = "mathml"
# Notebooks run anew with every build, and a cell that fails fails the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True
html_theme = "furo"
html_static_path = ["_static"]
html_favicon = "_static/favicon.svg"
html_css_files = ["manual.css"]
html_title = f"steadyarm {version}"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
# Names in single backticks of docstrings lead to the reference.
default_role = "py:obj"
add_module_names = False
python_maximum_signature_line_length = 80
toc_object_entries_show_parents = "hide"
# One name may belong to several classes: `rules`, `P`.
suppress_warnings = ["ref.python"]
