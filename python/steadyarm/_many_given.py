"""What `simulate_many` is given: one for all runs or one a run, and what is other in each."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import index
from typing import Any

import numpy as np

from . import _core, _scene
from .simulation import in_controller

PARTS = ("plant", "tracker", "reference", "effects", "q0", "dq0")
"""What may be another in each run."""


@dataclass(frozen=True)
class Given:
    """The parts of all runs: lists with one entry for all, or one a run."""

    count: int
    parts: dict[str, list[Any]]

    def part(self, name: str, run: int) -> Any:
        """What a run has."""
        values = self.parts[name]
        return values[0] if len(values) == 1 else values[run]


def given(
    parts: Mapping[str, Any],
    changes: Sequence[Mapping[str, Any]] | None,
    seeds: Sequence[int] | None,
    control_period: float | None,
) -> Given:
    """Tell the runs apart. Raises ValueError and TypeError that name the argument."""
    lists = {name: _several(name, value) for name, value in parts.items()}
    lists |= {"changes": _one_a_run("changes", changes), "seeds": _one_a_run("seeds", seeds)}
    count = _count({name: values for name, values in lists.items() if values is not None})
    every = {name: lists[name] or [value] for name, value in parts.items()}
    changed = lists["changes"] or []
    every |= _changed(every, changed)
    if lists["seeds"] is not None:
        every["effects"] = _seeded(Given(count, every), changed, lists["seeds"])
    _check_plants(every["plant"])
    every["tracker"] = _in_controllers(Given(count, every), control_period)
    return Given(count, every)


def _several(name: str, value: Any) -> list[Any] | None:
    """A list if there is one a run; None if it is for all."""
    if name not in ("q0", "dq0"):
        return list(value) if isinstance(value, list | tuple) else None
    try:
        array = np.asarray(value)
    except Exception:  # the core says what is wrong with it
        return None
    if array.ndim > 2:
        raise ValueError(f"{name}: got shape {array.shape}, wants (n,) or (M, n)")
    return list(array) if array.ndim == 2 else None


def _one_a_run(name: str, value: Any) -> list[Any] | None:
    if value is None:
        return None
    listed = isinstance(value, Sequence | np.ndarray) and not isinstance(value, str | bytes)
    if not listed or getattr(value, "ndim", 1) == 0:
        raise TypeError(f"{name}: got {value!r:.80}, wants a list with one a run")
    return list(value)


def _count(lists: Mapping[str, list[Any]]) -> int:
    """The one length of all lists."""
    if not lists:
        return 1
    first, *others = lists
    count = len(lists[first])
    for name in others:
        if len(lists[name]) != count:
            raise ValueError(f"{name}: got {len(lists[name])} runs, wants {count}, as {first} has")
    if count == 0:
        raise ValueError(f"{first}: got no runs, wants at least 1")
    return count


def _changed(
    every: Mapping[str, list[Any]], changes: list[Mapping[str, Any]]
) -> dict[str, list[Any]]:
    """The parts that ``changes`` name, one a run."""
    for run, change in enumerate(changes):
        if not isinstance(change, Mapping):
            raise TypeError(f"changes: got {change!r:.80} for run {run}, wants a dict")
    trees = [_tree(change, run) for run, change in enumerate(changes)]
    touched = [name for name in PARTS if any(name in tree for tree in trees)]
    changed: dict[str, list[Any]] = {}
    for name in touched:
        values = every[name]
        before = values * len(trees) if len(values) == 1 else values
        changed[name] = [
            _with(value, tree.get(name, []), name, run)
            for run, (value, tree) in enumerate(zip(before, trees, strict=True))
        ]
    return changed


Below = list[tuple[list[str], Any]]
"""Changes of an object: the words below it, none for all of it, and what comes there."""


def _tree(change: Mapping[str, Any], run: int) -> dict[str, Below]:
    """Changes by the part that they are of."""
    tree: dict[str, Below] = {}
    for path, value in change.items():
        first, *words = path.split(".") if isinstance(path, str) else [path]
        if first not in PARTS:
            wants = f"one of {', '.join(PARTS)}, or what is in them, such as 'plant.arm'"
            raise ValueError(f"changes: got {path!r:.80} for run {run}, wants {wants}")
        tree.setdefault(first, []).append((words, value))
    return tree


def _with(value: Any, below: Below, path: str, run: int) -> Any:
    """An object with changes: what takes its place first, then what is other in it."""
    inner: dict[str, Below] = {}
    for words, new in below:
        if words:
            inner.setdefault(words[0], []).append((words[1:], new))
        else:
            value = new
    if not inner:
        return value
    has = _arguments(value)
    for name in inner:
        # A law has arguments that it does not name; it says itself which ones.
        if name not in has and not isinstance(value, Mapping):
            what = "None" if value is None else f"a {type(value).__name__}"
            there = f"{what}, wants all of it, by the name '{path}'"
            if has:
                there = f"{what}, which has {', '.join(has)}"
                if isinstance(has.get("law"), Mapping):
                    there += f"; an argument of its law is '{path}.law.{name}'"
            raise ValueError(f"changes: got '{path}.{name}' for run {run}; {path} is {there}")
    new = {name: _with(has.get(name), it, f"{path}.{name}", run) for name, it in inner.items()}
    try:
        if isinstance(value, Mapping):
            return {**value, **new}
        if hasattr(value, "__replace__"):
            return value.__replace__(**new)
        return dataclasses.replace(value, **new)
    except (TypeError, ValueError) as error:
        error.add_note(f"steadyarm: for run {run}, changes of {path}: {', '.join(new)}")
        raise


def _arguments(value: Any) -> dict[str, Any]:
    """What an object is made of, by name; nothing for one that cannot be made anew."""
    if isinstance(value, Mapping):
        return dict(value)
    if _scene.CLASSES.get(type(value).__name__) is type(value):
        return _scene.arguments(value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = dataclasses.fields(value)
        return {it.name: getattr(value, it.name) for it in fields if it.init}
    return {}


def _seeded(runs: Given, changes: list[Any], seeds: list[Any]) -> list[Any]:
    """The effects of each run, with its seed."""
    if any("effects.seed" in change for change in changes):
        raise ValueError("seeds: got changes of 'effects.seed' beside them, wants one of the two")
    seeded = []
    for run, seed in enumerate(seeds):
        effects = runs.part("effects", run)
        if not isinstance(effects, _core.Effects):
            raise ValueError(f"seeds: got effects={effects!r:.80}, wants Effects to have them")
        try:
            seeded.append(effects.__replace__(seed=index(seed)))
        except (TypeError, ValueError):
            wants = "whole numbers from 0 to 2**64 - 1"
            raise ValueError(f"seeds: got {seed!r:.80} for run {run}, wants {wants}") from None
    return seeded


def _check_plants(plants: list[Any]) -> None:
    """All are plants, of as many joints."""
    for run, plant in enumerate(plants):
        if not isinstance(plant, _core.Plant):
            raise TypeError(f"plant: got {type(plant).__name__} for run {run}, wants a Plant")
    first, *others = [plant.arm.joints for plant in plants]
    for run, joints in enumerate(others, 1):
        if joints != first:
            raise ValueError(
                f"plant: got one of {joints} joints for run {run}, wants {first}, as run 0 has"
            )


def _in_controllers(runs: Given, control_period: float | None) -> list[Any]:
    """The trackers; those of one's own each in a controller for the plant's arm."""
    trackers, plants = runs.parts["tracker"], runs.parts["plant"]
    own = [it for it in trackers if not isinstance(it, _core.Controller | _core.Guard)]
    if not own:
        return trackers
    for run, tracker in enumerate(trackers):
        known = isinstance(tracker, _core.Controller | _core.Guard)
        if not known and not hasattr(tracker, "step"):
            of = f" for run {run}" if len(trackers) > 1 else ""
            wants = "a Controller, such as a ComputedTorque, or a Guard"
            raise TypeError(f"tracker: got {type(tracker).__name__}{of}, wants {wants}")
    return [
        in_controller(runs.part("plant", run), runs.part("tracker", run), control_period)
        for run in range(max(len(trackers), len(plants)))
    ]
