"""What the JSON in a file of `Run.save` says beside the arrays, read with distrust."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import fields
from typing import Any, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from . import _core
from .record import Certificate, Channel, GuardReport, Status
from .run import Run

Array = NDArray[np.float64]

FORMAT, OLDEST = 3, 2
"""Version of the files that are written, and the oldest that is read."""

KINDS = get_args(get_type_hints(Status)["kind"])
"""Why a run may have ended."""

KEYS = ("arrays", "own", "status", "certificate", "dictionary", "notes", "guard")
"""What the JSON has, beside the version."""


def parsed(text: str) -> dict[str, Any]:
    """JSON with the keys that it must have, each once, and finite numbers."""
    meta = json.loads(text, object_pairs_hook=_unique, parse_constant=_not_finite)
    version = meta.get("format") if isinstance(meta, dict) else None
    if type(version) is not int or not OLDEST <= version <= FORMAT:
        raise ValueError(f"format: got {version!r:.80}, wants {OLDEST} to {FORMAT}")
    meta.setdefault("dictionary", None)
    meta.setdefault("notes", [])
    meta.setdefault("guard", None)
    if version == OLDEST:
        meta.setdefault("own", {})
    meta = _only(meta, "meta", (*KEYS, "format"))
    if not isinstance(meta["own"], dict):
        raise ValueError(f"own: got {meta['own']!r:.80}, wants an object")
    return meta


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    if len(values) != len(pairs):
        raise ValueError(f"meta: got a key twice in {[key for key, _ in pairs]}")
    return values


def _not_finite(text: str) -> float:
    raise ValueError(f"meta: got {text}, wants a finite number")


def _only(values: Any, name: str, keys: Iterable[str]) -> dict[str, Any]:
    if not isinstance(values, dict) or sorted(values) != sorted(keys):
        raise ValueError(f"{name}: got {values!r:.200}, wants {', '.join(keys)}")
    return values


def notes(values: Any) -> tuple[str, ...]:
    """Lines of text."""
    if not isinstance(values, list) or not all(isinstance(v, str) for v in values):
        raise ValueError(f"notes: got {values!r:.80}, wants lines of text")
    return tuple(values)


def guard(values: Any) -> GuardReport | None:
    """What a guard did."""
    if values is None:
        return None
    values = _only(values, "guard", ("events", "stopped"))
    events, stopped = values["events"], values["stopped"]
    counts = isinstance(events, dict) and all(
        name.isidentifier() and type(count) is int and count >= 0 for name, count in events.items()
    )
    if not counts or not isinstance(stopped, str | None):
        raise ValueError(f"guard: got {values!r:.80}, wants counts of events, and a text or null")
    return GuardReport(events, stopped)


def channel(name: str, values: Any, array: Array) -> Channel:
    """A signal of the compensator's own, with its name one that a run has no other use for."""
    values = _only(values, f"own.{name}", ("unit", "shape", "doc"))
    taken = {*dir(Run), *(field.name for field in fields(Run))}
    if not name.isidentifier() or name.startswith("_") or name in taken:
        raise ValueError(f"own: got the name {name!r:.80}, wants one of its own")
    for key in ("unit", "doc"):
        if not isinstance(values[key], str) or not values[key].isprintable():
            raise ValueError(f"{key}: got {values[key]!r:.80}, wants a line of text")
    if list(values["shape"]) != list(array.shape[1:]):
        raise ValueError(f"shape: got {values['shape']!r:.80}, wants {array.shape[1:]}")
    return Channel(name, values["unit"], array.shape[1:], values["doc"])


def _number(value: Any, name: str) -> float:
    if type(value) not in (int, float) or not math.isfinite(value):
        raise ValueError(f"{name}: got {value!r:.80}, wants a finite number")
    return float(value)


def status(values: Any) -> Status:
    values = _only(values, "status", [field.name for field in fields(Status)])
    kind, reason = values["kind"], values["reason"]
    if kind not in KINDS:
        raise ValueError(f"status: got {kind!r:.80}, wants one of {', '.join(KINDS)}")
    if not isinstance(reason, str) or not reason.isprintable():
        raise ValueError(f"reason: got {reason!r:.80}, wants a line of text")
    t = _number(values["t"], "status.t")
    if t < 0.0:
        raise ValueError(f"status.t: got {t}, wants a time >= 0")
    return Status(kind, t, reason)


def certificate(values: Any) -> Certificate:
    names = [field.name for field in fields(Certificate)]
    values = _only(values, "certificate", names)
    return Certificate(*(_number(values[name], name) for name in names))


def dictionary(values: Any, joints: int) -> _core._Dictionary | None:
    """The figures of a dictionary."""
    if values is None:
        return None
    counts = ("atoms", "capacity", "merged", "dropped")
    values = _only(values, "dictionary", (*counts, "error_bound"))
    for name in counts:
        if type(values[name]) is not int or values[name] < 0:
            raise ValueError(f"{name}: got {values[name]!r:.80}, wants a whole number >= 0")
    bound = values["error_bound"]
    if not isinstance(bound, list) or len(bound) != joints:
        raise ValueError(f"error_bound: got {bound!r:.80}, wants {joints} numbers")
    return {
        "atoms": values["atoms"],
        "capacity": values["capacity"],
        "merged": values["merged"],
        "dropped": values["dropped"],
        "error_bound": np.array([_number(value, "error_bound") for value in bound]),
    }
