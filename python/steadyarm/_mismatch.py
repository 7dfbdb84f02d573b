"""The torque that a nominal model lacks at the rows of a run, split by cause.

The plant, with τ_a what arrives at its joints, and its model M₀ q̈ + H₀, H₀ = C₀ q̇ + G₀ + f₀:

    M q̈ + C q̇ + G + f + s + τ_d + τ_cog = τ_a

A law asks A(q, q̇, q_d, q̇_d, q̈_d) of the state at that instant. A₀ is the same without an error,
A(q, q̇, q, q̇, q̈_d), which is M₀ q̈_d + H₀ in computed torque; A - A₀ is its feedback. With
ë = q̈ - q̈_d, the whole is what keeps the error from obeying M₀ ë = A - A₀:

    whole = (A - A₀) - M₀ ë
          = (M - M₀) q̈ + (C - C₀) q̇ + (G - G₀) + (f - f₀) + s + τ_d    the arm; of M, C, G what the
                                                                         load makes stands apart
          + (M₀ q̈_d + H₀ - A₀)                                    the law leaves out of the model
          + (A - A′)                  A′: the same of the reference as the hand-over has it
          + (A′ - A′ of the sample)   the torque is held
          + (A′ of the sample - m)    m: of what the law saw, the recorded ``tau_model``
          - c                         what the controller cancels, ``tau_compensation``
          + (m + c - τ_told)          limits of effort and rate
          + (τ_told - τ_acting)       torques that come late
          + (τ_acting - τ_a + τ_cog)  drives and gears

The second form is the first with the plant's equation put in; each term is computed by itself. What
rounding leaves between both is the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._line import Line
from ._load import without_load
from ._pushed import disturbance_torque

if TYPE_CHECKING:
    from ._scene import Scene
    from .run import Run

Array = NDArray[np.float64]

BARE: dict[str, Any] = {
    "effort_limit": None,
    "effort_rate_limit": None,
    "hand_over": None,
    "velocity_filter": None,
    "bumpless": None,
}
"""Arguments of a tracker without what stands before and behind its law."""

STEP = 1e-3
"""Any period [s]: a law without a memory does not depend on it."""

INSIDE = ("hand_over", "sampling", "measurement", "delay", "saturation")
"""Causes that a controller makes or cannot know of: it cancels none of them."""

LOOKED_AT = 500
"""Rows in which the gains of a law are looked at, at the most."""

TINY = 1e-6
"""Width of an error that is always zero [rad, rad/s]."""


@dataclass(frozen=True)
class Asked:
    """What a law asks for at every row."""

    asked: Array
    """A [N·m], (T, n)."""
    unled: Array
    """A₀ [N·m], (T, n)."""
    handed: Array
    """A′ [N·m], (T, n)."""
    offset: tuple[Array, ...] | None
    """q_d′ - q_d, q̇_d′ - q̇_d and q̈_d′ - q̈_d, (T, n) each; None without a hand-over."""
    gains: tuple[Array, Array] | None
    """-∂A/∂e [N·m/rad] and -∂A/∂ė [N·m·s/rad], (T, n, n) each; None where they are not known."""
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Mismatch:
    """What a model lacks, at every row."""

    parts: dict[str, Array]
    """Torque by cause [N·m], (T, n) each."""
    whole: Array
    """Their sum [N·m], (T, n)."""
    law: Asked
    mass: Array
    """M₀ [kg·m²], (T, n, n)."""
    kinds: tuple[str, ...]
    """How the joints move."""
    notes: tuple[str, ...]


def mismatch(
    run: Run, scene: Scene, disturbance: Any = None, unloaded: _core.Arm | None = None
) -> Mismatch:
    """What the model of a run's tracker lacks."""
    plant, options = scene.plant(disturbance), scene.options
    ((_, said),) = scene.parts["tracker"].items()
    nominal = scene.believed
    line = Line(run, plant, options)
    pushed = disturbance_torque(plant, run, options)
    parts, ddq = _of_arm(run, plant, nominal, line.arrived - line.cogging - pushed, unloaded)
    parts["disturbance"] = pushed
    mass = np.array([nominal.mass_matrix(q) for q in run.q])
    bias = _rows(nominal.bias, run.q, run.dq)
    forward = _times(mass, run.ddq_d) + bias
    law = _of_law(run, scene, said, forward)
    parts["feedforward"] = forward - law.unled
    parts["hand_over"] = law.asked - law.handed
    held = line.at_samples(law.handed)
    parts["sampling"] = law.handed - held
    parts["measurement"] = held - run.tau_model
    parts["saturation"] = run.tau_model + run.tau_compensation - line.told
    parts["delay"] = line.told - line.acting
    parts["actuators"] = line.acting - line.arrived + line.cogging
    parts["cancelled"] = -run.tau_compensation
    whole = (law.asked - law.unled) - _times(mass, ddq - run.ddq_d)
    parts["rest"] = whole - sum(parts.values())
    notes = (*law.notes, *line.notes)
    return Mismatch(parts, whole, law, mass, nominal.joint_kinds, notes)


def _of_arm(
    run: Run, plant: _core.Plant, nominal: _core.Arm, net: Array, unloaded: _core.Arm | None
) -> tuple[dict[str, Array], Array]:
    """What of the mismatch is the arm's, under the torque ``net``; and q̈ [rad/s²], (T, n)."""
    arms = [nominal, plant.arm, *(arm for _, arm in plant.changes or ())]
    names = ("inertia", "coriolis", "gravity")
    loads = tuple(f"payload_{name}" for name in names)
    parts = {name: np.zeros_like(run.q) for name in (*names, *loads, "friction", "contact")}
    ddq = np.zeros_like(run.q)
    for rows, arm in segments(plant, run.t):
        q, dq = run.q[rows], run.dq[rows]
        ddq[rows] = _rows(arm.forward_dynamics, q, dq, net[rows])
        bare = without_load(arm, arms) if unloaded is None else unloaded
        motion = (q, dq, ddq[rows])
        whole, empty, model = (_terms(it, *motion) for it in (arm, bare, nominal))
        for name, load, *terms in zip(names, loads, whole, empty, model, strict=True):
            parts[name][rows] = terms[1] - terms[2]
            parts[load][rows] = terms[0] - terms[1]
        contact = _rows(arm.stops, q, dq)
        # Where a joint stands still, friction is what holds it.
        holding = net[rows] - sum(whole) - contact
        friction = np.where(dq == 0.0, holding, _rows(arm.friction, dq))
        parts["friction"][rows] = friction - _rows(nominal.friction, dq)
        parts["contact"][rows] = contact
    return parts, ddq


def segments(plant: _core.Plant, t: Array) -> Iterator[tuple[slice, _core.Arm]]:
    """The arms that are there, with the rows of their times."""
    changes = plant.changes or ()
    edges = [0, *np.searchsorted(t, [at for at, _ in changes]), len(t)]
    arms = [plant.arm, *(arm for _, arm in changes)]
    for first, last, arm in zip(edges, edges[1:], arms, strict=False):
        if last > first:
            yield slice(first, last), arm


def _terms(arm: _core.Arm, q: Array, dq: Array, ddq: Array) -> tuple[Array, Array, Array]:
    """M q̈, C q̇ and G [N·m], (T, n) each."""
    inertia = _times(np.array([arm.mass_matrix(at) for at in q]), ddq)
    coriolis = _times(np.array([arm.coriolis(*at) for at in zip(q, dq, strict=True)]), dq)
    return inertia, coriolis, _rows(arm.gravity, q)


def _of_law(run: Run, scene: Scene, said: Mapping[str, Any], forward: Array) -> Asked:
    """What the law of a run asks for at every row."""
    if _is_own(said):
        note = (
            "the law is your own: all that it asks for counts as its feedback, and nothing as "
            "sampling, measurement or cancelled"
        )
        return Asked(run.tau_model, forward, run.tau_model, None, None, (note,))
    law = scene.tracker(**_bare(said))
    motion, desired = (run.q, run.dq), (run.q_d, run.dq_d, run.ddq_d)
    asked = _asked(law, *motion, *desired)
    unled = _asked(law, *motion, *motion, run.ddq_d)
    handed, offset = asked, None
    tracker = scene.tracker()
    tracker.__setstate__(scene.start)
    if said["hand_over"] is not None and not tracker.steps:
        offset = _hand_over(said["hand_over"], run)
        handed = _asked(law, *motion, *(a + b for a, b in zip(desired, offset, strict=True)))
    if said["bumpless"] is not None and not tracker.steps:
        fading = np.exp(-said["bumpless"] * run.t)[:, None]
        handed = handed + (run.tau_model[0] - handed[0]) * fading
    gains = _gains(law, run, motion, desired)
    return Asked(asked, unled, handed, offset, gains, ())


def _asked(law: _core.Controller, *samples: Array) -> Array:
    """What a law without a memory asks for at every row, (T, n)."""
    torques = np.empty_like(samples[0])
    for row, (q, dq, q_d, dq_d, ddq_d) in enumerate(zip(*samples, strict=True)):
        law.reset()
        law.step(q, dq, q_d, dq_d, ddq_d, STEP)
        torques[row] = law.tau_model
    return torques


def _gains(
    law: _core.Controller, run: Run, motion: tuple[Array, Array], desired: tuple[Array, ...]
) -> tuple[Array, Array]:
    """-∂A/∂e [N·m/rad] and -∂A/∂ė [N·m·s/rad], (T, n, n) each, over the width of the errors.

    They are looked at in some rows, and go straight between these.
    """
    rows = np.unique(np.linspace(0, len(run.t) - 1, LOOKED_AT).round().astype(int))
    samples = [column[rows] for column in (*motion, *desired)]
    found = []
    for place, error in enumerate((run.e, run.de), start=len(motion)):
        gains = np.empty((len(rows), run.joints, run.joints))
        for joint, width in enumerate(np.median(np.abs(error), axis=0) + TINY):
            # With the set-point lower the error is larger.
            lower, upper = list(samples), list(samples)
            lower[place] = samples[place] - width * np.eye(run.joints)[joint]
            upper[place] = samples[place] + width * np.eye(run.joints)[joint]
            gains[:, :, joint] = (_asked(law, *upper) - _asked(law, *lower)) / (2.0 * width)
        found.append(_between(run.t, run.t[rows], gains))
    return found[0], found[1]


def _between(t: Array, known_at: Array, values: Array) -> Array:
    """Values (K, n, n) at the times ``t``, straight between those at which they are known."""
    after = np.clip(np.searchsorted(known_at, t), 1, max(len(known_at) - 1, 1))
    if len(known_at) == 1:
        return values
    share = (t - known_at[after - 1]) / (known_at[after] - known_at[after - 1])
    joined: Array = values[after - 1] + share[:, None, None] * (values[after] - values[after - 1])
    return joined


def _hand_over(rate: float, run: Run) -> tuple[Array, Array, Array]:
    """By how much q_d′, q̇_d′ and q̈_d′ differ from the reference, (T, n) each; see `Controller`."""
    start, slope = run.e[0], run.de[0] + rate * run.e[0]
    t = run.t[:, None]
    along, fading = start + slope * t, np.exp(-rate * t)
    speed = (slope - rate * along) * fading
    return along * fading, speed, -rate * (speed + slope * fading)


def _bare(said: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of a tracker that is nothing but its law."""
    changes: dict[str, Any] = dict(BARE)
    if "compensator" in said:
        changes["compensator"] = None
    elif said["law"]["law"] == "computed_torque":
        changes["law"] = {
            name: value for name, value in said["law"].items() if name != "compensator"
        }
    elif said["law"]["law"] == "recommended":
        # Its gains follow from the filter, and from the limit.
        changes.pop("velocity_filter")
        if said["effort_limit"] is not None:
            changes["law"] = said["law"] | {"effort": said["effort_limit"]}
    return changes


def _is_own(said: Mapping[str, Any]) -> bool:
    """Whether a law is a controller of one's own."""
    law = said.get("law", {})
    return not isinstance(law, Mapping) or ("law" not in law and "law" in said)


def _rows(function: Callable[..., Array], *columns: Array) -> Array:
    """A function of a row of each, at every row."""
    return np.array([function(*row) for row in zip(*columns, strict=True)])


def _times(matrices: Array, vectors: Array) -> Array:
    """Matrix times vector, row by row."""
    product: Array = np.einsum("tij,tj->ti", matrices, vectors)
    return product
