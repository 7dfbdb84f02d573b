"""Packages that not everybody needs: which extra of the wheel brings them, and what to say without.

``numpy`` is the only one that every installation has.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

EXTRAS = {
    "matplotlib": "plot",
    "PIL": "plot",
    "viser": "view",
    "yourdfpy": "view",
    "pandas": "data",
    "xarray": "data",
    "pyarrow": "data",
    "scipy": "data",
    "mujoco": "mujoco",
    "distributed": "cluster",
    "ray": "cluster",
    "shtab": "completion",
}
"""The extra that brings a package."""


class Missing(ImportError):
    """A package is not installed; the message says which extra brings it."""


def imported(package: str, what: str) -> Any:
    """Import a package that ``what`` needs. Raises `Missing` where it is not installed."""
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        raise missing(error, what) from error


def missing(error: ModuleNotFoundError, what: str) -> ImportError:
    """The error that says what brings the module that was not found."""
    package = (error.name or "").partition(".")[0]
    extra = EXTRAS.get(package)
    if extra is None:
        return error
    words = f'{what}: needs {package}; pip install "steadyarm[{extra}]"'
    return Missing(words, name=package)
