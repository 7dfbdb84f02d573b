"""The paper's three simulations (section 4), ready to run.

``CENTERS`` and ``WIDTH`` are the five fuzzy sets of an input, ``FEEDBACK`` has K_p [1/s²] and
K_v [1/s], and ``PRESETS`` says how simulation 3 is read. "printed": Γ = diag(7, 7) is a gain of
1/7; the paper does not say how sets combine to rules, five are assumed. "claimed": Γ taken for the
gain, 625 rules, raw firing strengths: a reading that does what the paper claims. Beside them stands
"recommended", the controller that we recommend.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

from . import _core
from ._scene import arguments
from .recommended import recommended
from .scenario import RUN, Scene

PERIOD = 1e-3
"""Of the recommended controller's loop, of which the paper says nothing [s]."""

LARGEST = 25.0
"""Its largest torque, of which the paper says nothing [N·m]."""

_SETTINGS = {
    name: _core.read_scenario(_core.paper_scenario(3, name)) for name in ("printed", "claimed")
}
"""Of the third simulation in each reading, by section; typed once, in the core."""

_COMMON = _SETTINGS["printed"]

_PARTS = {
    name: arguments(settings["compensator"]) | arguments(settings["compensator"].basis)
    for name, settings in _SETTINGS.items()
}
"""Arguments of its compensators and bases."""

CENTERS: tuple[float, ...] = tuple(_PARTS["printed"]["centers"])
"""Centres of the five fuzzy sets."""

WIDTH: float = _PARTS["printed"]["width"]
"""Their width: exp(-(x - c)²) is a Gaussian of σ = 1/√2."""

FEEDBACK: dict[str, float] = {name: _COMMON["controller"][name] for name in ("kp", "kv")}
"""K_p [1/s²] and K_v [1/s]."""

PRESETS: dict[str, dict[str, Any]] = {
    name: {key: parts[key] for key in ("form", "normalized", "gain")}
    for name, parts in _PARTS.items()
}
"""How simulation 3 is read, by the name of the preset."""


def nominal() -> _core.TwoLink:
    """What the controller believes: 4 kg, 0.5 m, 0.2 kg·m² each link."""
    arm: _core.TwoLink = _COMMON["two_link"]
    return arm


def actual() -> _core.TwoLink:
    """What is there in simulations 2 and 3: twice the mass and inertia."""
    arm: _core.TwoLink = _COMMON["plant"]
    return arm


def reference() -> _core.Sines:
    """q_d = [0.5 cos t + 0.2 sin 3t, -0.2 sin t - 0.5 cos t]."""
    sines: _core.Sines = _COMMON["reference"]
    return sines


def disturbance() -> _core.Sines:
    """τ_d = [sin t, cos t], in simulations 2 and 3."""
    sines: _core.Sines = _COMMON["disturbance"]
    return sines


def scenario(number: Literal[1, 2, 3], preset: Literal["printed", "claimed"] = "printed") -> str:
    """Simulation 1, 2 or 3 as TOML, to be edited and read by `Scene.read` or the command line.

    Raises ValueError for a number or preset that does not exist.
    """
    if isinstance(number, bool) or number not in (1, 2, 3):
        raise ValueError(f"number: got {number!r}, wants 1, 2 or 3")
    if preset not in tuple(PRESETS):
        raise ValueError(f"preset: got {preset!r}, wants one of {', '.join(PRESETS)}")
    return _core.paper_scenario(number, preset)


def simulation(
    number: Literal[1, 2, 3],
    preset: Literal["printed", "claimed", "recommended"] = "printed",
    **overrides: Any,
) -> Scene:
    """Simulation 1, 2 or 3 of the paper, from rest in the origin, 40 s.

    ``preset`` says how simulation 3 is read, see `PRESETS`. ``overrides`` change single settings:
    ``kp``, ``kv`` of the controller; ``form``, ``normalized``, ``inputs``, ``centers``, ``width``
    of the basis; ``gain``, ``gamma``, ``q``, ``leak_rate``, … of the compensator; ``duration``,
    ``dt`` of the run. With "recommended" `recommended` stands in place of computed torque and
    compensator, in a loop of 1 kHz with at most 25 N·m, and only settings of the run can be
    changed. Raises ValueError for a number, preset or override that does not exist.
    """
    if preset != "recommended":
        sections = _core.read_scenario(scenario(number, preset))
        return Scene.of(sections, f"simulation {number}", **overrides)
    for name in overrides:
        if name not in RUN:
            raise ValueError(f"{name}: preset recommended has no such setting, its rule chooses")
    sections = _core.read_scenario(scenario(number, "printed")) | {"compensator": None}
    scene = Scene.of(sections, **{"control_period": PERIOD, **overrides})
    period = scene.options["control_period"]
    tracker = recommended(nominal(), loop_rate=1.0 / period, delay=0, effort_limit=LARGEST)
    return replace(scene, tracker=tracker)
