"""An estimate of the error that each cause makes, through the linear loop of the run.

The error obeys M₀ ë = A - A₀ - whole exactly (see `_mismatch`). The estimate puts a linear feedback
in the place of A - A₀ and of what the controller cancels, c,

    ë + V ė + P e + k_i ∫e = -M₀⁻¹ Σ causes.

P = -M₀⁻¹ ∂A/∂e and V = -M₀⁻¹ ∂A/∂ė are the law's own at every row; in computed torque they are K_p
and K_v. Of c one form is taken, that which fits the run best, joint by joint and by least squares,
with d all causes but those `INSIDE` the loop:

    M₀⁻¹ c ≈ -(k_i ∫e + k_p e + k_v ė)     an integral, which becomes a part of the loop
    c ≈ l ∫(d - c)                         an observer of rate l, which follows every cause
    c ≈ y ∫ M₀⁻¹ (d - c)                   another one
    c ≈ α d                                what was learnt takes a share off every cause

What of c has not that form stays a cause of its own. Causes go straight from row to row, and a row
is one step of the implicit midpoint rule. What all that leaves of the error is its rest: a feedback
that is not linear, and what happens between rows.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._mismatch import INSIDE

if TYPE_CHECKING:
    from ._mismatch import Mismatch
    from .run import Run

Array = NDArray[np.float64]

FAR = 1e3
"""Responses that are so many times as large as the error do not explain it."""


@dataclass(frozen=True)
class Memory:
    """How what the controller cancels depends on the error and on the causes."""

    gains: Array
    """k_i [1/s³], k_p [1/s²] and k_v [1/s], (3, n)."""
    rates: Array | None
    """l or y M₀⁻¹ [1/s], (T, n, n)."""
    learnt: Array
    """α, (n,)."""

    @classmethod
    def of(
        cls, joints: int, gains: Array | None = None, rates: Array | None = None, learnt: Any = 0.0
    ) -> Memory:
        """One of its forms; none at all of none."""
        gains = np.zeros((3, joints)) if gains is None else gains
        return cls(gains, rates, np.broadcast_to(learnt, joints))


def responses(run: Run, lacks: Mismatch) -> dict[str, Array]:
    """The error by cause [rad], (T, n) each, with "start" and "rest"; NaN where no loop fits."""
    law = _law_gains(run, lacks)
    seen, shift = _seen(run, lacks)
    cancels = lacks.parts["cancelled"].any()
    memories = [_memory(run, lacks, seen, law)] if cancels else []
    for memory in (*memories, Memory.of(run.joints)):
        gains = memory.gains[:, None]
        inputs = _left(run, lacks, memory)
        if "hand_over" in inputs:
            inputs["hand_over"] += (gains * shift).sum(axis=0)
        if cancels:
            known = sum(inputs.values(), np.zeros_like(run.e))
            pushed = _accelerations(lacks.mass, -lacks.whole)
            inputs["cancelled"] = pushed + (gains * (seen + shift)).sum(axis=0) - known
        with np.errstate(over="ignore", invalid="ignore"):
            errors = _through(run, law, memory, inputs)
        if all(np.abs(it).max() <= FAR * np.abs(run.e).max() for it in errors.values()):
            return errors
    return {name: np.full_like(run.e, np.nan) for name in errors}


def _left(run: Run, lacks: Mismatch, memory: Memory) -> dict[str, Array]:
    """What the memory leaves of each cause, as an acceleration [rad/s²]."""
    parts = {name: part for name, part in lacks.parts.items() if part.any()}
    parts.pop("cancelled", None)
    outside = [name for name in parts if name not in INSIDE]
    if memory.rates is not None and outside:
        causes = np.stack([parts[name] for name in outside], axis=2)
        followed = _followed(run.t, causes, memory.rates)
        parts |= {name: parts[name] - followed[:, :, k] for k, name in enumerate(outside)}
    shares = {name: 1.0 - memory.learnt for name in outside}
    return {
        name: _accelerations(lacks.mass, -shares.get(name, 1.0) * part)
        for name, part in parts.items()
    }


def _law_gains(run: Run, lacks: Mismatch) -> tuple[Array, Array]:
    """P and V; of a law that tells none, those that fit its feedback, joint by joint."""
    if lacks.law.gains is not None:
        stiffness, damping = (_inverse(lacks.mass) @ it for it in lacks.law.gains)
        return stiffness, damping
    feedback = _accelerations(lacks.mass, lacks.law.asked - lacks.law.unled)
    fits, _ = _fitted(-np.stack([run.e, run.de], axis=2), feedback)
    of_all = (len(run.t), run.joints, run.joints)
    kp, kv = fits.T
    return np.broadcast_to(np.diag(kp), of_all), np.broadcast_to(np.diag(kv), of_all)


def _seen(run: Run, lacks: Mismatch) -> tuple[Array, Array]:
    """(∫e, e, ė) as the controller saw them after its hand-over, (3, T, n), and what that took."""
    shift = np.zeros((3, *run.e.shape))
    if lacks.law.offset is not None:
        offset, rate, _ = lacks.law.offset
        shift = np.stack([_integral(run.t, offset), offset, rate])
    return np.stack([_integral(run.t, run.e), run.e, run.de]) - shift, shift


def _memory(run: Run, lacks: Mismatch, seen: Array, law: tuple[Array, Array]) -> Memory:
    """The form that fits what the controller cancels best, in the median of all joints."""
    outside = [part for name, part in lacks.parts.items() if name not in (*INSIDE, "cancelled")]
    total, cancelled = np.sum(outside, axis=0), -lacks.parts["cancelled"]
    forms = []
    gains, off = _fitted(-seen.transpose(1, 2, 0), _accelerations(lacks.mass, cancelled))
    if _is_stable(law, gains):
        forms.append((off, Memory.of(run.joints, gains=gains.T)))
    one = np.broadcast_to(np.eye(run.joints), lacks.mass.shape)
    for weight in (one, _inverse(lacks.mass)):
        left = _integral(run.t, (weight @ (total - cancelled)[:, :, None])[:, :, 0])
        rates, off = _fitted(left[:, :, None], cancelled)
        if (rates > 0.0).all():
            forms.append((off, Memory.of(run.joints, rates=rates * weight)))
    learnt, off = _fitted(total[:, :, None], cancelled)
    forms.append((off, Memory.of(run.joints, learnt=np.clip(learnt[:, 0], 0.0, 1.0))))
    return min(forms, key=lambda form: form[0])[1]


def _is_stable(law: tuple[Array, Array], gains: Array) -> bool:
    """Whether each joint by itself is stable with these gains (n, 3) beside the law's."""
    kp, kv = (np.einsum("tii->i", it) / len(it) for it in law)
    polynomials = np.column_stack(
        [np.ones(len(kp)), kv + gains[:, 2], kp + gains[:, 1], gains[:, 0]]
    )
    return all(np.roots(row).real.max() < 0.0 for row in polynomials)


def _followed(t: Array, causes: Array, rates: Array) -> Array:
    """What follows causes (T, n, K) at such rates, ẇ = R (cause - w), from zero on."""
    half = 0.25 * np.diff(t)[:, None, None] * (rates[1:] + rates[:-1])
    one = np.eye(rates.shape[1])
    answer = _inverse(one + half)
    keeps, pushes = answer @ (one - half), answer @ half @ (causes[1:] + causes[:-1])
    followed = np.zeros_like(causes)
    for row, keep in enumerate(keeps):
        followed[row + 1] = keep @ followed[row] + pushes[row]
    return followed


def _through(
    run: Run, law: tuple[Array, Array], memory: Memory, inputs: Mapping[str, Array]
) -> dict[str, Array]:
    """What each input [rad/s²] does to the error [rad], with "start" and "rest"."""
    pushes = np.stack([*inputs.values(), np.zeros_like(run.e)], axis=2)
    between = 0.5 * (pushes[1:] + pushes[:-1])
    steps = np.diff(run.t)[:, None, None]
    ki, kp, kv = (np.diag(gains) for gains in memory.gains)
    stiffness, damping = (
        0.5 * (it[1:] + it[:-1]) + own for it, own in zip(law, (kp, kv), strict=True)
    )
    answer = np.eye(run.joints) + 0.5 * steps * damping
    answer += 0.25 * steps**2 * stiffness + 0.125 * steps**3 * ki
    answer = _inverse(answer)
    errors, rate, integral = np.zeros_like(pushes), *np.zeros((2, *pushes.shape[1:]))
    errors[0, :, -1], rate[:, -1] = run.e[0], run.de[0]
    for row, h in enumerate(np.diff(run.t)):
        e = errors[row]
        middle = e + 0.5 * h * rate
        area = integral + 0.5 * h * (e + 0.5 * h * rate)
        left = between[row] - stiffness[row] @ middle - damping[row] @ rate - ki @ area
        acceleration = answer[row] @ left
        after = e + h * (rate + 0.5 * h * acceleration)
        rate = rate + h * acceleration
        integral = integral + 0.5 * h * (e + after)
        errors[row + 1] = after
    found = {name: errors[:, :, k] for k, name in enumerate((*inputs, "start"))}
    found["rest"] = run.e - errors.sum(axis=2) + found.get("rest", 0.0)
    return found


def _fitted(columns: Array, values: Array) -> tuple[Array, float]:
    """Factors (n, m) of the columns (T, n, m) that give the values (T, n) by least squares.

    And how much they are off, as a share of the values: the median of all joints.
    """
    scale = np.sqrt((columns**2).mean(axis=0))
    scale[scale == 0.0] = 1.0
    scaled = (columns / scale).transpose(1, 0, 2)
    solved = [
        np.linalg.lstsq(own, it, rcond=None)[0] for own, it in zip(scaled, values.T, strict=True)
    ]
    factors = np.asarray(solved, dtype=float) / scale
    left = np.linalg.norm(np.einsum("tnm,nm->tn", columns, factors) - values, axis=0)
    size = np.linalg.norm(values, axis=0)
    off = left[size > 0.0] / size[size > 0.0]
    return factors, float(np.median(off)) if len(off) else 0.0


def _inverse(matrices: Array) -> Array:
    """The inverse of each, (T, n, n)."""
    return np.asarray(np.linalg.inv(matrices), dtype=float)


def _accelerations(mass: Array, torque: Array) -> Array:
    """M₀⁻¹ τ [rad/s²], row by row, (T, n)."""
    return np.asarray(np.linalg.solve(mass, torque[:, :, None])[:, :, 0], dtype=float)


def _integral(t: Array, values: Array) -> Array:
    """∫ over time from the first row on, (T, n)."""
    areas = 0.5 * np.diff(t)[:, None] * (values[1:] + values[:-1])
    return np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(areas, axis=0)])
