"""A scene: a plant, a controller and a reference, ready to run, from a scenario in TOML."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import _core
from ._documented import documented
from ._scene import PARAMETERS
from .run import Run
from .simulation import simulate


@documented
@dataclass(frozen=True)
class Scene:
    """A plant, a controller and a reference, ready to run."""

    plant: _core.Plant
    """What is really there."""
    tracker: _core.Controller
    """The controller."""
    reference: _core.Curve
    """The motion that is wanted."""
    duration: float = 40.0
    """Length of the run [s]."""
    dt: float = 1e-3
    """Step of the integrator and spacing of the record [s]."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """Further arguments of `simulate`."""

    @classmethod
    def read(cls, path: str | Path, **overrides: Any) -> Scene:
        """Read a scenario in TOML; see `read_scenario` for its sections.

        ``two_link``, ``controller`` and ``reference`` are needed. Without ``plant``, the arm is as
        the controller believes. ``overrides`` change single settings: ``kp``, ``kv``,
        ``effort_limit``, ``effort_rate_limit`` of the controller; arguments of the basis and of the
        compensator; ``duration``, ``dt``, ``control_period``, ``method``, ``q0``, ``dq0``,
        ``rtol``, ``atol`` of the run. Raises OSError, and ValueError naming what is wrong.
        """
        text = Path(path).read_text(encoding="utf-8")
        try:
            return cls.of(_core.read_scenario(text), **overrides)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    @classmethod
    def of(cls, sections: Mapping[str, Any], name: str = "this scene", **overrides: Any) -> Scene:
        """Build the sections that `read_scenario` gives; ``overrides`` as for `read`.

        Raises ValueError for a section that is missing, and for a setting that ``name`` has not.
        """
        for needed in ("two_link", "controller", "reference"):
            if sections[needed] is None:
                raise ValueError(f"{needed}: wants a section [{needed}]")
        feedback = _changed(sections["controller"], overrides)
        run = _changed(sections["run"] or RUN, overrides)
        compensator = sections["compensator"]
        if compensator is not None:
            basis = compensator.basis.__replace__(**_taken(BASIS, overrides))
            compensator = compensator.__replace__(basis=basis, **_taken(COMPENSATOR, overrides))
        if overrides:
            raise ValueError(f"{next(iter(overrides))}: {name} has no such setting")
        arm = sections["two_link"]
        plant = _core.Plant(sections["plant"] or arm, sections["disturbance"])
        tracker = _core.ComputedTorque(arm, compensator=compensator, **feedback)
        length = {name: run.pop(name) for name in ("duration", "dt")}
        return cls(plant, tracker, sections["reference"], **length, options=run)

    def run(self, **options: Any) -> Run:
        """Simulate; ``options`` are those of `simulate`."""
        options = {"duration": self.duration, "dt": self.dt, **self.options} | options
        return simulate(self.plant, self.tracker, self.reference, **options)


RUN: dict[str, Any] = _core.read_scenario("[run]")["run"]
"""What a run is by default."""

BASIS = [name for name in PARAMETERS["FuzzyBasis"] if name != "joints"]
"""Arguments of a basis that an override may change."""

COMPENSATOR = [name for name in PARAMETERS["FuzzyCompensator"] if name != "basis"]
"""Arguments of a compensator that an override may change."""


def _changed(settings: Mapping[str, Any], overrides: dict[str, Any]) -> dict[str, Any]:
    """Settings with what is taken out of ``overrides``."""
    return {**settings, **_taken(settings, overrides)}


def _taken(names: Iterable[str], overrides: dict[str, Any]) -> dict[str, Any]:
    """What is taken out of ``overrides``."""
    return {name: overrides.pop(name) for name in names if name in overrides}
