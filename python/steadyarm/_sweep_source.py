"""What a sweep computes: a function of one's own, or a scenario with other parameters."""

from __future__ import annotations

import functools
import hashlib
import inspect
import json
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import _core, _many_given, _toml
from ._figures import Window
from ._sections import nominal_arm
from ._sweep_work import Refused, Row, Source
from .bench import BEYOND, LIBRARY, Scenario, scenario_names

CONTROLLER = "controller"
"""The input that says which controller of a scenario runs."""

PAYLOAD = ("actual", "payload", "mass")

SHORT = {"payload": PAYLOAD, "friction": ("actual", "friction_share")}
"""Names of inputs that stand for a key of a scenario's file, beside the keys themselves."""

SEARCHED = ("actual", "effects", "front", "run", "metrics")
"""Sections of a scenario's file whose keys need no section before them."""

Keys = tuple[str, ...]


def source_of(what: Any, names: Iterable[str], seeded: bool) -> Source:
    """The source of what `sweep` is given: a scenario, its file or its name, or a function."""
    names = [name for name in names if name != "seed"]
    if isinstance(what, Scenario):
        return SceneSource(what, names, seeded)
    if isinstance(what, str | Path):
        path = Path(what)
        if path.suffix != ".toml" and str(what) in scenario_names():
            path = LIBRARY / f"{what}.toml"
        return FileSource(path.read_text(encoding="utf-8"), path.stem, names, seeded)
    if callable(what):
        return FunctionSource(what)
    raise TypeError(
        f"sweep: got {what!r:.80}, wants a function, a Scenario, or a scenario's file or name"
    )


class FunctionSource:
    """A function of the inputs, by name."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function

    def check(self, points: Iterable[Row]) -> None:
        """Refuse inputs of other names than the function's; of values it says itself what is wrong.

        Its rows are "raised" then.
        """
        try:
            signature = inspect.signature(self.function)
        except (TypeError, ValueError):  # of what Python cannot see into
            return
        point = next(iter(points))
        try:
            signature.bind(**point)
        except TypeError as error:
            inputs = ", ".join(point) or "none"
            wants = f"the inputs of {named(self.function)}{signature} ({error})"
            raise TypeError(f"over: got {inputs}, wants {wants}") from None

    def made(self, point: Row) -> Any:
        """What the function returns."""
        return self.function(**point)

    def said(self) -> dict[str, Any]:
        """Its name, module first."""
        return {"function": named(self.function)}


def named(function: Any) -> str:
    """The name of a function, its module first; what a partial one is given comes after it."""
    if isinstance(function, functools.partial):
        given = [*map(repr, function.args)]
        given += [f"{name}={value!r}" for name, value in sorted(function.keywords.items())]
        inner = named(function.func)
        return re.sub(r" at 0x[0-9a-f]+", "", f"functools.partial({', '.join([inner, *given])})")
    module = getattr(function, "__module__", None) or type(function).__module__
    if module == "__main__":
        module = Path(getattr(sys.modules["__main__"], "__file__", None) or module).stem
    name = getattr(function, "__qualname__", None) or type(function).__qualname__
    return f"{module}.{name}{_told_apart(function) if '<lambda>' in name else ''}"


def _told_apart(function: Any) -> str:
    """What tells functions without a name apart: what they do, and what they hold."""
    function = inspect.unwrap(function)
    code = getattr(function, "__code__", None)
    if code is None:
        return ""
    held = [cell.cell_contents for cell in function.__closure__ or ()]
    given = function.__defaults__, function.__kwdefaults__, held
    content = repr((code.co_code, code.co_names, code.co_consts, given))
    return f"-{_digest(re.sub(r' at 0x[0-9a-f]+', '', content))}"


class _OfScenario:
    """What scenarios share, from a file or not: a controller runs, with a seed of its effects."""

    names: list[str]
    seeded: bool
    _last: tuple[Row, dict[str, Any]] | None = None

    def scene(self, point: Row) -> Scenario:
        """The scenario of a point."""
        raise NotImplementedError

    def made(self, point: Row) -> Mapping[str, Any]:
        """Arguments of `simulate`; points that differ by their seed alone share them."""
        inputs = {name: point[name] for name in self.names}
        if self._last is None or self._last[0] != inputs:
            self._last = (inputs, self._made(inputs))
        made = self._last[1]
        if "seed" not in point:
            return made
        return {**made, "effects": made["effects"].__replace__(seed=point["seed"])}

    def _made(self, inputs: Row) -> dict[str, Any]:
        try:
            scene = self.scene(inputs)
            name = inputs.get(CONTROLLER) or usual(scene)
            tracker = scene.controller(scene.controllers[name])
        except (ValueError, TypeError) as error:
            raise Refused(str(error)) from error
        given = {"plant": scene.plant, "tracker": tracker, "reference": scene.reference}
        steady = {"window": window_of(scene), "band": scene.band, "effects": scene.effects}
        return {**given, **scene.options, **steady}

    def check(self, points: Iterable[Row]) -> None:
        """Refuse names that no scenario has. ``points``: the two ends of the plan."""
        refused = []
        for point in points:
            inputs = {name: point[name] for name in self.names}
            try:
                scene = self.scene(inputs)
            except (ValueError, TypeError) as error:
                refused.append(error)
                continue
            name = inputs.get(CONTROLLER, usual(scene))
            if name not in scene.controllers:
                wants = ", ".join(scene.controllers)
                raise ValueError(f"over['{CONTROLLER}']: got {name!r}, wants some of {wants}")
            if CONTROLLER not in inputs:
                self.check_law(name)
            if self.seeded and scene.effects is None:
                raise ValueError("seeds: wants effects in the scenario, whose seeds they are")
        if len(refused) == 2:
            raise ValueError(f"over: {refused[0]}") from refused[0]

    def check_law(self, name: str) -> None:
        """Refuse inputs that say nothing to the one controller that runs."""

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_last"}


class SceneSource(_OfScenario):
    """A scenario as an object. An input is a field of it, dotted: ``effects.noise``."""

    def __init__(self, scene: Scenario, names: list[str], seeded: bool) -> None:
        self.names, self.seeded, self._scene = names, seeded, scene
        for name in names:
            if name != CONTROLLER:
                _check_field(scene, name)

    def scene(self, point: Row) -> Scenario:
        """The scenario with the fields of a point."""
        below = [(name.split("."), it) for name, it in point.items() if name != CONTROLLER]
        made: Scenario = _many_given._with(self._scene, below, "scenario", 0)
        return made

    def said(self) -> dict[str, Any]:
        """Its name and what it is made of, in a digest."""
        fields = {name: value for name, value in vars(self._scene).items()}
        parts = [f"{name}: {_content(fields[name])}" for name in sorted(fields)]
        return {"scenario": self._scene.name, "content": _digest("\n".join(parts))}


def _check_field(scene: Scenario, name: str) -> None:
    """Refuse a dotted name that leads nowhere."""
    value: Any = scene
    words = name.split(".")
    for depth, word in enumerate(words):
        if isinstance(value, Mapping) and depth == len(words) - 1:
            return  # what reads it says what it knows
        has = _many_given._arguments(value)
        if word not in has:
            where = ".".join(words[:depth]) or "the scenario"
            there = f"has {', '.join(has)}" if has else f"is {value!r:.40}"
            more = "; give the scenario's file or name for the keys of its file" * (depth == 0)
            raise ValueError(f"over[{name!r}]: {where} {there}{more}")
        value = has[word]


def _content(value: Any) -> str:
    """What an object is made of, the same in every process."""
    if isinstance(value, Mapping):
        return "; ".join(f"{key}={_content(value[key])}" for key in sorted(value))
    if isinstance(value, _core.Serial):
        return value.to_toml()
    made_of = _many_given._arguments(value)
    if made_of:
        return f"{type(value).__name__}({_content(made_of)})"
    if isinstance(value, list | tuple | np.ndarray):
        return f"[{', '.join(map(_content, value))}]"
    return named(value) if callable(value) else repr(value)


class FileSource(_OfScenario):
    """A scenario's file. An input is a key of it, dotted: ``actual.payload.mass``.

    The section can be left out where one section alone has the key, ``payload`` is that mass, 5 cm
    beyond the tip if the file does not say, and ``bandwidth`` that of every controller.
    """

    def __init__(
        self, text: str, name: str, names: list[str], seeded: bool, robot: str | None = None
    ) -> None:
        self.names, self.seeded, self.name, self.text = names, seeded, name, text
        try:
            sections = _core.read_scenario(text)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error
        self.keys = {it: list(_keys(it, sections)) for it in names if it != CONTROLLER}
        # The robot's file is read here: workers on other machines may not have it.
        swept = any(key[0] == "robot" for keys in self.keys.values() for key in keys)
        if robot is not None:
            self.arm: _core.Arm | None = _core.Serial.from_toml(robot)
        else:
            self.arm = None if sections["robot"] is None or swept else nominal_arm(sections)

    def check_law(self, name: str) -> None:
        """Refuse gains of other controllers than the one that runs."""
        for given, keys in self.keys.items():
            if all(key[0] == "controllers" and key[1] != name for key in keys):
                others = ", ".join(key[1] for key in keys)
                raise ValueError(
                    f"over[{given!r}]: the controller that runs, {name}, has none; choose others "
                    f"with {CONTROLLER!r}: {others}"
                )

    @classmethod
    def kept(cls, said: Mapping[str, Any]) -> FileSource:
        """The source whose `keeps` is in a file."""
        return cls(said["text"], said["name"], said["names"], said["seeded"], said["robot"])

    def keeps(self) -> dict[str, Any]:
        """All that it takes to compute a point again."""
        robot = self.arm.to_toml() if isinstance(self.arm, _core.Serial) else None
        names = {"name": self.name, "names": self.names, "seeded": self.seeded}
        return {"text": self.text, "robot": robot, **names}

    def scene(self, point: Row) -> Scenario:
        """The scenario of the file with the keys of a point."""
        said = tomllib.loads(self.text)
        for name, value in point.items():
            for key in self.keys.get(name, ()):
                _put(said, key, value)
        if self.arm is not None:
            del said["robot"]
        sections = _core.read_scenario("\n".join(_toml.lines({"": said})))
        if self.arm is not None:
            sections["two_link"] = self.arm
        return Scenario.of(sections, self.name)

    def said(self) -> dict[str, Any]:
        """Its name, its content and the robot's in a digest."""
        robot = "" if self.arm is None else _content(self.arm)
        content = json.dumps(tomllib.loads(self.text), sort_keys=True, default=str)
        return {"scenario": self.name, "content": _digest(content + robot)}


def _keys(name: str, sections: Mapping[str, Any]) -> Iterator[Keys]:
    """The keys of a file that an input stands for."""
    if "." in name:
        yield tuple(name.split("."))
    elif name in SHORT:
        yield SHORT[name]
    elif name == "bandwidth":
        laws = sections["controllers"]
        found = [law for law, said in laws.items() if "bandwidth" in said]
        if not found:
            raise ValueError(f"over[{name!r}]: no controller of the scenario has a bandwidth")
        yield from (("controllers", law, name) for law in found)
    else:
        known = _known()
        found = [section for section in SEARCHED if name in known[section]]
        if len(found) != 1:
            dotted = [f"{section}.{name}" for section in found]
            wants = " or ".join(dotted) or (
                f"{', '.join([CONTROLLER, 'bandwidth', *SHORT])}, or a key of the file such as "
                "effects.noise"
            )
            raise ValueError(f"over[{name!r}]: wants {wants}")
        yield (found[0], name)


@functools.cache
def _known() -> dict[str, set[str]]:
    """The keys of each section, from the schema of the files."""
    schema = json.loads((LIBRARY / "schema.json").read_text(encoding="utf-8"))
    found = {}
    for section in SEARCHED:
        part = schema["properties"][section]
        while "$ref" in part:
            part = schema["definitions"][part["$ref"].rpartition("/")[2]]
        found[section] = set(part["properties"])
    return found


def _put(said: dict[str, Any], key: Keys, value: Any) -> None:
    """Put a value into a file; a payload of nothing is none."""
    *tables, last = key
    if key == PAYLOAD and value == 0:
        said.get("actual", {}).pop("payload", None)
        return
    for depth, word in enumerate(tables):
        said = said.setdefault(word, {})
        if not isinstance(said, dict):
            where = ".".join(key[: depth + 1])
            raise ValueError(f"{'.'.join(key)}: {where} is no section")
    if key == PAYLOAD:
        said.setdefault("com", list(BEYOND))
    said[last] = value


def usual(scene: Scenario) -> str:
    """The controller that runs where none is said: recommended, or else the first by name."""
    return "recommended" if "recommended" in scene.controllers else next(iter(scene.controllers))


def window_of(scene: Scenario) -> Window:
    """From when to when its figures are: the second half, if it does not say [s]."""
    if scene.window is not None:
        return scene.window
    end = float(scene.options["duration"])
    return (end / 2, end)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
