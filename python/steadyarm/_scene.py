"""What a run was made with, as plain values: what `Run.save` keeps of it, and what `replay` builds.

An object is ``{"name of its class": {argument: value}}``, a serial arm ``{"Serial": its TOML}``. A
callable is ``{"callable": its name}``: no file keeps it.
"""

from __future__ import annotations

import copy
import inspect
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from typing import Any

import numpy as np

from . import _core
from ._joints import numbered

VERSION = version("steadyarm")
"""Of the package; looked up once, as that takes longer than a short run."""

CLASSES: dict[str, Any] = {
    made.__name__: made
    for made in (
        _core.ComputedTorque,
        _core.Controller,
        _core.Effects,
        _core.FuzzyBasis,
        _core.FuzzyCompensator,
        _core.Noise,
        _core.Plant,
        _core.Pulses,
        _core.Quintic,
        _core.Sines,
        _core.Table,
        _core.TwoLink,
        _core.Waypoints,
        _core.Wrench,
    )
}
"""Classes that are built from their arguments, beside `Serial`, which is built from its TOML."""

PARAMETERS = {name: list(inspect.signature(made).parameters) for name, made in CLASSES.items()}
"""Their arguments, in their order: those of `__reduce__` too."""

OPTIONS = (
    "duration", "dt", "method", "control_period", "q0", "dq0", "rtol", "atol", "record_every",
    "record", "effects",
)  # fmt: skip
"""Arguments of `simulate` beside plant, tracker and reference."""

KEYS = ("steadyarm", "joint_names", "plant", "tracker", "reference", "options")
"""What a scene says: version of the package, names of the joints, and what `simulate` was given."""


@dataclass(frozen=True)
class Scene:
    """What a run was made with, objects or plain values, and the state that its tracker was in."""

    parts: Mapping[str, Any]
    start: bytes

    @classmethod
    def of(
        cls,
        plant: _core.Plant,
        tracker: tuple[type[_core.Controller], tuple[Any, ...]],
        start: bytes,
        reference: Any,
        options: Mapping[str, Any],
        own: Any = None,
    ) -> Scene:
        """Of the arguments of a simulation, the tracker by its own.

        ``own``: a controller of one's own as it was before the simulation.
        """
        kind, values = tracker[0].__name__, tracker[1]
        arguments = dict(zip(PARAMETERS[kind], values, strict=True))
        if own is not None:
            arguments["law"] = own
        parts = {
            "steadyarm": VERSION,
            "joint_names": joint_names(plant.arm, plant.arm.joints),
            "plant": plant,
            "tracker": {kind: arguments},
            "reference": reference,
            "options": {name: _option(name, value) for name, value in options.items()},
        }
        return cls(parts, start)

    @property
    def plain(self) -> dict[str, Any]:
        """All of it in plain values."""
        return {key: _plain(self.parts[key]) for key in KEYS}

    def build(
        self, reference: Any, disturbance: Any, law: Any = None
    ) -> tuple[_core.Plant, _core.Controller, Any, dict[str, Any]]:
        """Plant, tracker at the start of the run, reference and options.

        What is given takes the place of what the scene has. Raises ValueError for a callable that
        must be given, and for values that a class refuses.
        """
        try:
            return self._built(reference, disturbance, law)
        except (TypeError, RecursionError) as error:
            raise ValueError(f"scene: got one that cannot be built ({error})") from error

    def _built(
        self, reference: Any, disturbance: Any, law: Any
    ) -> tuple[_core.Plant, _core.Controller, Any, dict[str, Any]]:
        plant = self.plant(disturbance)
        tracker = self.tracker(**({} if law is None else {"law": law}))
        tracker.__setstate__(self.start)
        if reference is None:
            reference = _built(self.parts["reference"], "reference")
        if not callable(reference):
            raise ValueError(f"reference: got {reference!r:.80}, wants one that can be called")
        return plant, tracker, reference, self.options

    def plant(self, disturbance: Any = None) -> _core.Plant:
        """The plant, with this disturbance in the place of its own if one is given."""
        plant = self.parts["plant"]
        if disturbance is not None:
            arguments = _plain(plant)["Plant"] | {"disturbance": disturbance}
            plant = {"Plant": arguments}
        made: _core.Plant = _object(plant, "plant", _core.Plant)
        return made

    @property
    def believed(self) -> _core.Arm:
        """The arm that the controller believes in."""
        ((_, said),) = self.parts["tracker"].items()
        arm: _core.Arm = _object(said["arm"], "tracker.arm", _core.Arm)
        return arm

    def tracker(self, **changes: Any) -> _core.Controller:
        """A new tracker, with these of its arguments changed."""
        ((kind, arguments),) = self.parts["tracker"].items()
        made: _core.Controller = _object(
            {kind: {**arguments, **changes}}, "tracker", _core.Controller
        )
        return made

    @cached_property
    def joint_kinds(self) -> tuple[str, ...]:
        """How the plant's joints move; () where a file says what cannot be built."""
        plant = self.parts["plant"]
        try:
            arm = plant.arm if isinstance(plant, _core.Plant) else plant["Plant"]["arm"]
            made: _core.Arm = _object(arm, "arm", _core.Arm)
        except (ValueError, TypeError, KeyError, RecursionError):
            return ()
        return made.joint_kinds

    @property
    def options(self) -> dict[str, Any]:
        """What `simulate` was given beside plant, tracker and reference."""
        return {name: _built(value, name) for name, value in self.parts["options"].items()}


def read(text: bytes, joints: int) -> dict[str, Any]:
    """The parts of a scene from its JSON. Raises ValueError where they are not those of one."""
    parts = json.loads(text, object_pairs_hook=_unique, parse_constant=_infinity)
    if not isinstance(parts, dict) or sorted(parts) != sorted(KEYS):
        raise ValueError(f"scene: got {parts!r:.80}, wants {', '.join(KEYS)}")
    names = parts["joint_names"]
    if not isinstance(names, list) or len(names) != joints:
        raise ValueError(f"joint_names: got {names!r:.80}, wants {joints}")
    for text_of in (parts["steadyarm"], *names):
        if not isinstance(text_of, str) or not text_of.isprintable():
            raise ValueError(f"scene: got {text_of!r:.80}, wants a line of text")
    for key in ("plant", "tracker", "reference", "options"):
        if not isinstance(parts[key], dict):
            raise ValueError(f"{key}: got {parts[key]!r:.80}, wants an object")
    # Runs of older versions have no effects.
    parts["options"].setdefault("effects", None)
    if sorted(parts["options"]) != sorted(OPTIONS):
        raise ValueError(f"options: got {parts['options']!r:.80}, wants {', '.join(OPTIONS)}")
    return parts


def joint_names(arm: Any, joints: int) -> tuple[str, ...]:
    """The names of an arm's joints, or else their numbers."""
    return tuple(arm.joint_names) if isinstance(arm, _core.Serial) else numbered(joints)


def arguments(value: Any) -> dict[str, Any]:
    """The arguments of one of `CLASSES` by name."""
    return dict(zip(PARAMETERS[type(value).__name__], value.__reduce__()[1], strict=True))


def own_law(tracker: Any) -> Any:
    """A copy of the controller of one's own that steps in a tracker; None for any other."""
    law = tracker.law if type(tracker) is _core.Controller else None
    return None if isinstance(law, Mapping) else copy.deepcopy(law)


def _option(name: str, value: Any) -> Any:
    """An option in plain values: what is done to an array later changes no run."""
    if value is None or isinstance(value, str | _core.Effects):
        return value
    return int(value) if name == "record_every" else np.asarray(value, dtype=float).tolist()


def _plain(value: Any) -> Any:
    """A value without objects."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, Mapping):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, _core.Serial):
        return {"Serial": value.to_toml()}
    name = type(value).__name__
    if CLASSES.get(name) is type(value):
        return {name: _plain(arguments(value))}
    return {"callable": getattr(value, "__qualname__", name)}


def _object(value: Any, name: str, wanted: type) -> Any:
    """The object that a plain value stands for; ``name``: the argument it is for."""
    made = _built(value, name)
    if not isinstance(made, wanted):
        raise ValueError(f"{name}: got {made!r:.80}, wants a {wanted.__name__}")
    return made


def _built(value: Any, name: str) -> Any:
    if isinstance(value, list):
        return [_built(item, name) for item in value]
    if not isinstance(value, Mapping):
        return value
    if len(value) != 1:
        return {key: _built(item, key) for key, item in value.items()}
    ((kind, arguments),) = value.items()
    if kind == "callable":
        was = f"it was a callable, {arguments!s:.80}, which no file keeps"
        raise ValueError(f"{name}: {was}; give {name}=")
    if kind == "Serial":
        return _serial(arguments)
    if kind not in CLASSES or not isinstance(arguments, Mapping):
        return value
    values = {key: _built(item, key) for key, item in arguments.items()}
    if isinstance(values.get("changes"), list):
        # Files have no tuples, and a plant wants its changes as pairs.
        values["changes"] = [tuple(pair) for pair in values["changes"]]
    return CLASSES[kind](**values)


def _serial(toml: Any) -> _core.Serial:
    """A serial arm from its TOML, which no name of a file may stand for."""
    if not isinstance(toml, str) or "\n" not in toml:
        raise ValueError(f"Serial: got {toml!r:.80}, wants TOML")
    return _core.Serial.from_toml(toml)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    if len(values) != len(pairs):
        raise ValueError(f"scene: got a key twice in {[key for key, _ in pairs]!r:.200}")
    return values


def _infinity(text: str) -> float:
    """A limit that is none."""
    if text == "NaN":
        raise ValueError("scene: got NaN, wants a number")
    return float(text)
