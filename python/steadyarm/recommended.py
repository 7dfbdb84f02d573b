"""The controller that we recommend, for any arm, with all its gains from a rule."""

from __future__ import annotations

from typing import Any, Literal, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from .centers import centers_for
from .paths import Course, Path
from .paths import sample as sampled

HAND_OVER = 3.0
"""Rate at which the arm is led from where it is to the path [1/s]."""

FILTER = 100.0
"""Cut-off of the velocity filter [Hz]: the velocity is the difference of positions through it."""

CENTERS = (-1.5, -0.5, 0.0, 0.5, 1.5)
"""Of the residual's sets where no path is given, those of the paper [rad, rad/s, rad/s²]."""

MARGIN = 0.3
"""Beyond a path, where the rule looks at the arm too [rad]."""

SETS = 5
"""Sets of an input of the residual."""


class Others(TypedDict, total=False):
    """Arguments of `Controller` beside those that are said here."""

    effort_rate_limit: ArrayLike | None
    last_tau: ArrayLike | None
    bumpless: float | None


def recommended(
    arm: _core.Arm,
    *,
    loop_rate: float = 1000.0,
    encoder_bits: ArrayLike = 16,
    delay: int = 1,
    effort_limit: ArrayLike | None = None,
    payload: float | None = None,
    inertia_range: tuple[float, float] | None = None,
    noise: ArrayLike = 0.0,
    path: Path | None = None,
    duration: float | None = None,
    learns: Literal["links", "payload"] = "links",
    residual: bool | None = None,
    light_joints: bool = False,
    hand_over: float | None = HAND_OVER,
    velocity_filter: float | None = FILTER,
    **others: Unpack[Others],
) -> _core.Controller:
    """Return the controller that we recommend: it learns what torque your arm really needs.

    ``τ = ID₀ + Φθ + Dv`` on the desired motion: the model's torque, what was learnt, and feedback
    with an observer. The torque that acted is explained by the links' masses and by friction, and
    what was learnt is fed forward. No gain is tuned: all follow from the loop, the encoder and the
    largest load. It needs positions alone; pass ``np.zeros(n)`` for ``dq`` if you have no velocity.
    Sampled only: `simulate` wants a ``control_period``.

    Parameters
    ----------
    arm: what you believe of the arm, with the inertia of its rotors.
    loop_rate: of your loop [Hz].
    encoder_bits: of a turn, scalar or (n,).
    delay: samples between a torque and the period in which it acts, 0 to 4.
    effort_limit: largest torque [N·m], scalar or (n,). None: that of the arm, where it has one.
    payload: the heaviest load at the tip that you expect [kg]. None: a sixth of the arm's mass.
    inertia_range: how far the arm's inertia may be off, as multiples of what you believe, such as
        ``(1, 4)``. None: it is about right.
    noise: standard deviation of a measured position beside its rounding [rad], scalar or (n,).
    path: where the arm will go. The rule then looks at the poses there, and 0.3 rad around, not at
        all that the arm has; the torque that the path needs is compared with ``effort_limit``; and
        the sets of the residual lie along it. ``duration`` [s]: its length, None for its own.
    learns: "links", or "payload" for a load at the tip and friction alone: the load is known
        better, where the arm itself is known well.
    residual: learn what no parameter describes too, by places along the path. It holds on this path
        alone. None: for a two-link arm only.
    light_joints: a joint that looks too light for its torque is meant so, and has no rotor.
    hand_over, velocity_filter, others: as of `Controller`.

    Raises
    ------
    ValueError
        In words: where a rotor is missing, no gains keep such a loop stable, or the path needs more
        than the largest torque.
    """
    if learns not in ("links", "payload"):
        raise ValueError(f'learns: got {learns!r}, wants "links" or "payload"')
    if learns == "payload" and isinstance(arm, _core.TwoLink):
        raise ValueError(f'learns: got {learns!r}, wants "links" of a TwoLink: it has no bodies')
    for name, flag in (("light_joints", light_joints), ("residual", residual)):
        if not isinstance(flag, bool | None):
            raise TypeError(f"{name}: got {flag!r}, wants True or False")
    period = _period(loop_rate)
    settings: dict[str, Any] = {
        "law": "recommended",
        "encoder_bits": _numbers("encoder_bits", encoder_bits, arm.joints),
        "noise": _numbers("noise", noise, arm.joints),
        "payload": None if payload is None else _numbers("payload", payload, 0),
        "inertia_range": None if inertia_range is None else _bounds(inertia_range),
        "payload_only": learns == "payload",
        "light_joints": bool(light_joints),
    }
    if path is not None:
        course = sampled(path, duration, arm)
        _within_effort(arm, course, effort_limit)
        settings["range"] = np.transpose(
            [course.q.min(axis=0) - MARGIN, course.q.max(axis=0) + MARGIN]
        ).tolist()
    if isinstance(arm, _core.TwoLink) if residual is None else residual:
        settings["residual"] = _residual(path, duration)
    given = {name: value for name, value in settings.items() if value is not None}
    return _core.Controller(
        arm,
        given,
        effort_limit=_effort(arm, effort_limit),
        delay=delay,
        hand_over=hand_over,
        velocity_filter=velocity_filter,
        control_period=period,
        **others,
    )


def _period(loop_rate: float) -> float:
    """The period of a loop [s]."""
    rate: float = _numbers("loop_rate", loop_rate, 0)
    if not 1.0 <= rate <= 1e9:
        raise ValueError(f"loop_rate: got {loop_rate!r}, wants 1 to 1e9 Hz")
    return 1.0 / rate


def _numbers(name: str, value: Any, joints: int) -> Any:
    """A number, or one for each joint where there are some, as a list."""
    wants = "a number" if joints == 0 else f"a number, or {joints} of them"
    array = np.asarray(value)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name}: got {value!r}, wants {wants}")
    if array.shape not in ((), (joints,)):
        raise ValueError(f"{name}: got shape {array.shape}, wants {wants}")
    return array.astype(float).tolist()


def _bounds(inertia_range: Any) -> list[float]:
    """Two numbers."""
    array = np.asarray(inertia_range)
    if array.shape != (2,) or array.dtype.kind not in "iuf":
        raise ValueError(f"inertia_range: got {inertia_range!r}, wants (low, high)")
    return [float(x) for x in array]


def _effort(arm: _core.Arm, effort_limit: ArrayLike | None) -> ArrayLike | None:
    """The limit that was given, or that of the arm, where it has one."""
    if effort_limit is not None or not isinstance(arm, _core.Serial):
        return effort_limit
    effort = np.asarray(arm.limits["effort"])
    return effort if np.isfinite(effort).any() else None


def _within_effort(arm: _core.Arm, course: Course, effort_limit: ArrayLike | None) -> None:
    """Refuse a path that the believed arm cannot follow with its largest torques."""
    effort = _effort(arm, effort_limit)
    if effort is None:
        return
    motion = zip(course.q, course.dq, course.ddq, strict=True)
    needed = np.abs([arm.inverse_dynamics(*point) for point in motion]).max(axis=0)
    limit = np.broadcast_to(np.asarray(effort, dtype=float), needed.shape)
    if (needed > limit).any():
        joint = int(np.argmax(needed / limit))
        raise ValueError(
            f"path: joint {joint + 1} needs up to {needed[joint]:.4g} N·m without any load, wants "
            f"at most its effort_limit, {limit[joint]:.4g} N·m: move slower"
        )


def _residual(path: Path | None, duration: float | None) -> dict[str, Any]:
    """The basis of what no parameter describes, over the desired motion."""
    basis: dict[str, Any] = {"form": "concat", "normalized": False, "inputs": "trajectory"}
    if path is None:
        return basis | {"centers": list(CENTERS), "width": 2.0**-0.5}
    sets = centers_for(path, "trajectory", sets=SETS, duration=duration)
    centers, width = sets["centers"], sets["width"]
    return basis | {
        "centers": [np.asarray(row).tolist() for row in centers],
        "width": [np.asarray(row).tolist() for row in width],
    }
