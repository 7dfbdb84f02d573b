"""What the controllers of `laws` have in common: arguments, and how one is made of its settings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from . import _core


class Common(TypedDict, total=False):
    """Arguments of `Controller` beside its arm and law."""

    effort_limit: ArrayLike | None
    effort_rate_limit: ArrayLike | None
    last_tau: ArrayLike | None
    hand_over: float | None
    velocity_filter: float | None
    bumpless: float | None
    delay: int | None
    control_period: float | None


def compensator_settings(compensator: _core.FuzzyCompensator) -> dict[str, Any]:
    """The arguments of a compensator by name, with those of its basis, as a scenario has them."""
    from ._scene import arguments

    settings = arguments(compensator)
    basis = arguments(compensator.basis)
    settings["basis"] = {name: value for name, value in basis.items() if value is not None}
    return {name: value for name, value in settings.items() if value is not None}


def made(name: str, arm: _core.Arm, common: Common, **settings: Any) -> _core.Controller:
    """The controller of that law, with the settings that were given."""
    given = {key: _plain(value) for key, value in settings.items() if value is not None}
    return _core.Controller(arm, {"law": name, **given}, **common)


def _plain(value: Any) -> Any:
    """An array as a list."""
    if isinstance(value, str | Mapping):
        return value
    return np.asarray(value, dtype=float).tolist()
