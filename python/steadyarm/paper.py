"""The paper's three simulations (section 4), ready to run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

from . import _core
from ._scene import PARAMETERS
from .run import Run
from .simulation import simulate

_SETTINGS = _core.paper_settings()
"""Of the third simulation in each reading, by section; typed once, in the core."""

_COMMON = _SETTINGS["printed"]

CENTERS: tuple[float, ...] = tuple(_COMMON["compensator"].basis.centers)
"""Centres of the five fuzzy sets."""

WIDTH: float = _COMMON["compensator"].basis.width
"""Their width: exp(-(x - c)²) is a Gaussian of σ = 1/√2."""

FEEDBACK: dict[str, float] = {name: _COMMON["controller"][name] for name in ("kp", "kv")}
"""K_p [1/s²] and K_v [1/s]."""

PRESETS: dict[str, dict[str, Any]] = {
    name: {
        "form": settings["compensator"].basis.form,
        "normalized": settings["compensator"].basis.normalized,
        "gain": float(settings["compensator"].gain[0]),
    }
    for name, settings in _SETTINGS.items()
}
"""How simulation 3 is read.

"printed": Γ = diag(7, 7) is a gain of 1/7; the paper does not say how sets combine to rules, five
are assumed. "claimed": Γ taken for the gain, 625 rules, raw firing strengths: a reading that does
what the paper claims.
"""


@dataclass(frozen=True)
class Scene:
    """A plant, a controller and a reference, with duration [s] and step [s] of the run."""

    plant: _core.Plant
    tracker: _core.ComputedTorque
    reference: _core.Sines
    duration: float = 40.0
    dt: float = 1e-3

    def run(self, **options: Any) -> Run:
        """Simulate; ``options`` are those of `simulate`."""
        options = {"duration": self.duration, "dt": self.dt} | options
        return simulate(self.plant, self.tracker, self.reference, **options)


def nominal() -> _core.TwoLink:
    """What the controller believes: 4 kg, 0.5 m, 0.2 kg·m² each link."""
    return _COMMON["two_link"]


def actual() -> _core.TwoLink:
    """What is there in simulations 2 and 3: twice the mass and inertia."""
    return _COMMON["plant"]


def reference() -> _core.Sines:
    """q_d = [0.5 cos t + 0.2 sin 3t, -0.2 sin t - 0.5 cos t]."""
    return _COMMON["reference"]


def disturbance() -> _core.Sines:
    """τ_d = [sin t, cos t], in simulations 2 and 3."""
    return _COMMON["disturbance"]


def simulation(
    number: Literal[1, 2, 3],
    preset: Literal["printed", "claimed"] = "printed",
    **overrides: Any,
) -> Scene:
    """Simulation 1, 2 or 3 of the paper, from rest in the origin, 40 s.

    ``preset`` says how simulation 3 is read, see `PRESETS`. ``overrides`` change single settings:
    ``kp``, ``kv`` of the controller; ``form``, ``normalized``, ``inputs``, ``centers``, ``width``
    of the basis; ``gain``, ``gamma``, ``q``, ``leak_rate``, … of the compensator; ``duration``,
    ``dt`` of the run. Raises ValueError for a number, preset or override that does not exist.
    """
    if isinstance(number, bool) or number not in (1, 2, 3):
        raise ValueError(f"number: got {number!r}, wants 1, 2 or 3")
    if preset not in tuple(PRESETS):
        raise ValueError(f"preset: got {preset!r}, wants one of {', '.join(PRESETS)}")
    feedback = {name: overrides.pop(name, value) for name, value in FEEDBACK.items()}
    length = {name: overrides.pop(name) for name in ("duration", "dt") if name in overrides}
    compensator = _compensator(_SETTINGS[preset]["compensator"], overrides) if number == 3 else None
    if overrides:
        raise ValueError(f"{next(iter(overrides))}: simulation {number} has no such setting")
    plant = _core.Plant(nominal()) if number == 1 else _core.Plant(actual(), disturbance())
    tracker = _core.ComputedTorque(nominal(), **feedback, compensator=compensator)
    return replace(Scene(plant, tracker, reference()), **length)


def _compensator(
    preset: _core.FuzzyCompensator, overrides: dict[str, Any]
) -> _core.FuzzyCompensator:
    """Take the settings of basis and compensator out of ``overrides``."""
    own = {"basis", "joints", "dictionary", "merge_tolerance"}
    basis, law = (
        {name: overrides.pop(name) for name in PARAMETERS[kind] if name in {*overrides} - own}
        for kind in ("FuzzyBasis", "FuzzyCompensator")
    )
    return preset.__replace__(basis=preset.basis.__replace__(**basis), **law)
