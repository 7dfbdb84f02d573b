"""The arm that is really there, from what is different about it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from . import _core


def actual_plant(
    nominal: _core.Arm,
    plant: _core.Arm | None,
    actual: Mapping[str, Any] | None,
    disturbance: Any,
) -> tuple[_core.Plant, tuple[float, ...]]:
    """The plant, and the times at which something happens in it [s].

    ``plant`` is another arm whole, ``actual`` the section of that name.
    """
    given = {name: value for name, value in (actual or {}).items() if value is not None}
    if plant is not None and "two_link" in given:
        raise ValueError("actual.two_link: wants none beside a section [plant]")
    arm = given.pop("two_link", plant if plant is not None else nominal)
    _check_counts(given, arm.joints)
    arm = _scaled(arm, given.pop("inertia_scale", None))
    arm = _rubbing(arm, given)
    limit = given.pop("effort_limit", None)
    if limit is None and isinstance(nominal, _core.Serial):
        own = nominal.limits["effort"]
        limit = own if np.isfinite(own).any() else None
    payload, friction = given.pop("payload", None), given.pop("changes", None) or []
    times = {change["at"] for change in friction}
    if payload is not None:
        times |= {at for at in (payload.get("from"), payload.get("until")) if at is not None}
    changes = [(at, _at(arm, payload, friction, at)) for at in sorted(times)]
    made = _core.Plant(_at(arm, payload, friction, 0.0), disturbance, limit, changes or None)
    return made, tuple(at for at, _ in changes)


def _check_counts(given: Mapping[str, Any], joints: int) -> None:
    """Refuses lists of another length than one a joint, by the path of the key."""
    names = ("inertia_scale", "viscous", "coulomb", "effort_limit")
    lists = {f"actual.{name}": given.get(name) for name in names}
    for place, change in enumerate(given.get("changes") or []):
        path = f"actual.changes[{place}]"
        lists |= {f"{path}.{name}": change[name] for name in ("viscous", "coulomb")}
    for path, value in lists.items():
        if isinstance(value, list) and len(value) != joints:
            raise ValueError(f"{path}: got {len(value)} entries, wants {joints}")


def _at(
    arm: _core.Arm, payload: Mapping[str, Any] | None, friction: list[dict[str, Any]], t: float
) -> _core.Arm:
    """The arm at time ``t`` [s], with what it carries and how it rubs then."""
    begun = [change for change in friction if change["at"] <= t]
    if begun:
        arm = _rubbing(arm, {name: begun[-1][name] for name in ("viscous", "coulomb")})
    if payload is not None:
        end = np.inf if payload.get("until") is None else payload["until"]
        if (payload.get("from") or 0.0) <= t < end:
            arm = _loaded(arm, payload)
    return arm


def _scaled(arm: _core.Arm, scale: Any) -> _core.Arm:
    """The arm with masses and inertias so many times as large."""
    if scale is None:
        return arm
    scale = np.broadcast_to(np.asarray(scale, dtype=float), (arm.joints,))
    if isinstance(arm, _core.TwoLink):
        mass, _, inertia, *_ = arm.parameters
        return arm.__replace__(mass=scale * mass, inertia=scale * inertia)
    assert isinstance(arm, _core.Serial)
    return arm.with_parameters(np.repeat(scale, 10) * arm.inertial_parameters())


def _rubbing(arm: _core.Arm, given: dict[str, Any]) -> _core.Arm:
    """The arm with this friction; none of it is said: with its own."""
    viscous, coulomb = given.pop("viscous", None), given.pop("coulomb", None)
    share = given.pop("friction_share", None)
    if share is not None:
        if viscous is not None or coulomb is not None:
            raise ValueError("actual.friction_share: wants no viscous and no coulomb beside it")
        limits = arm.limits if isinstance(arm, _core.Serial) else None
        effort = np.full(arm.joints, 10.0) if limits is None else limits["effort"]
        speed = np.full(arm.joints, 3.0) if limits is None else limits["velocity"]
        effort = np.where(np.isfinite(effort), effort, 10.0)
        speed = np.where(np.isfinite(speed), speed, 3.0)
        coulomb, viscous = share * effort / 2, share * effort / 2 / speed
    if viscous is None and coulomb is None:
        return arm
    assert isinstance(arm, _core.TwoLink | _core.Serial)
    none = np.zeros(arm.joints)
    return arm.with_friction(
        viscous=none if viscous is None else viscous, coulomb=none if coulomb is None else coulomb
    )


def _loaded(arm: _core.Arm, payload: Mapping[str, Any]) -> _core.Arm:
    """The arm with a payload at its tip."""
    if not isinstance(arm, _core.Serial):
        raise ValueError("actual.payload: wants a robot; a two-link arm has no tip to carry one")
    return arm.with_payload(payload["mass"], payload["com"])
