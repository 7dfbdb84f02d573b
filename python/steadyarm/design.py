"""The design report: what a controller will do, before it runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._documented import documented
from ._html import Entry, by_joint, joined, listed, text
from ._joints import chosen_one, lengths, numbered
from ._scene import arguments, joint_names
from .learnable import Learnable, learnable
from .paths import Path, reference_of

Array = NDArray[np.float64]


class LinearModel(NamedTuple):
    """The closed loop of a joint, ẋ = A x + B ρ and e = C x + D ρ, from ρ [rad/s²] to e [rad].

    x is [e, ė, ρ̂]; [e, ė] without a compensator. Through a velocity filter the velocity that the
    law has comes last. What the model leaves out is ρ, positive as in
    `Run.rho`. ``control.ss(*model)`` and ``scipy.signal.StateSpace(*model)`` take it.
    """

    A: Array
    B: Array
    C: Array
    D: Array


@documented
@dataclass(frozen=True, eq=False)
class DesignReport:
    """Figures of a design, joint by joint (arrays of shape (n,)), with findings and a verdict.

    NaN stands for what cannot be known without a path, and for what only a compensator has.
    """

    p11: Array
    """Entry of P (19): position with position."""
    p12: Array
    """Position with velocity."""
    p22: Array
    """Velocity with velocity."""
    min_eigenvalue: Array
    """Smallest eigenvalue of P."""
    max_real: Array
    """Largest real part of A + γ⁻²BBᵀP [1/s]; negative."""
    gamma_opt: Array
    """γ must be larger than this for (19) to have a solution."""
    max_scale: Array
    """Q may be multiplied by less than this."""
    k_i: Array
    """Integral action of the compensator, gain |ξ|² / (1 + ν |ξ|²); along a path the largest."""
    rms_without: Array
    """Predicted steady RMS error without the compensator [rad]."""
    rms: Array
    """Predicted steady RMS error with it [rad]."""
    sampled_radius: Array
    """Spectral radius of the sampled loop, stable below 1. Along a path the growth per sample of
    the loop of all joints, the smallest at any size of its motion: at 1 and above it is unstable on
    the path, shaking, and where the error is wide."""
    max_period: Array
    """Longest period at which the sampled loop is stable [s], 0 if it never is. Along a path that
    of the loop of all joints: on the path, where the error is as wide as computed torque alone has
    it, and without the compensator, if it is stable then at any period."""
    stiffness: Array
    """kp M₀ⱼⱼ, what holds a joint against a slow push [N·m/rad]: the smallest along the path, or of
    32 poses spread over the joints' ranges."""
    damping: Array
    """kv M₀ⱼⱼ [N·m·s/rad], likewise."""
    poles: NDArray[np.complex128]
    """Poles of the linear model [1/s], (n, 3), and (n, 4) through a velocity filter; the one of the
    integrator is 0 without a compensator."""
    kp: Array
    """Feedback on position [1/s²]."""
    kv: Array
    """Feedback on velocity [1/s]."""
    leak_rate: float | None
    """Of the compensator [1/s]; None without one."""
    inertia_ratio: Array
    """Believed over true inertia; along a path the mean."""
    delay: int
    """Samples from measurement to torque."""
    velocity_filter: float | None
    """Cut-off of the filter that makes velocities of positions [Hz]; None: they are measured."""
    findings: tuple[str, ...]
    """What to know before going ahead, in words."""
    sound: bool
    """Whether nothing speaks against going ahead, and all that may is known."""
    known: bool
    """Whether the loop could be judged; it could not where the rules see where the arm is, and no
    path was given, or where the error is too wide for a linear model."""
    verdict: Literal[
        "go ahead",
        "do not run this",
        "cannot tell without a path",
        "cannot tell from a linear model",
    ]
    """What to do."""
    left_out: tuple[str, ...]
    """What acts in a run and is not in these figures."""
    rules: float | None = None
    """Rules of each joint; None without a path."""
    rules_excited: tuple[int, ...] | None = None
    """Rules that fire along the path with 5 % of the strongest; None with a dictionary too."""
    directions: tuple[int, ...] | None = None
    """Independent directions that ξ takes along the path: 1 is an integrator."""
    survives: Array | None = None
    """Share of what the model leaves out that is still compensated when learning stops, at best: 1
    is learnt, 0 only integrated. None without a path and a plant."""
    learnable: Learnable | None = None
    """What the path teaches, whatever learns, and how it is covered by sets; see
    `steadyarm.learnable`. None without a path."""
    joint_names: tuple[str, ...] = ()
    """Names of the joints; () or their numbers, from 1, where they have none."""
    units: tuple[str, ...] = ()
    """"rad" of each joint, "m" of a prismatic one."""

    def linear_model(self, joint: int | str) -> LinearModel:
        """The closed loop of a joint by itself, whose ``poles`` the report has, in continuous time.

        ``joint``: its number, from 1, or its name. ``control.ss(*report.linear_model(1))`` is a
        system of python-control; ``rms`` without a path, or with a ``disturbance``, is its answer
        to that. Along a path k_I is the largest and the inertia ratio the mean along it. Raises
        ValueError for a joint that is not there, and where the loop cannot be known without a path.
        """
        n = chosen_one(joint, self.joint_names or numbered(len(self.p11)))
        kp, kv = self.kp[n], self.kv[n]
        if np.isnan(self.poles[n]).any():
            raise ValueError(
                f"joint: the loop of {joint!r} is not known without a path; give path="
            )
        ratio, A, rate = float(self.inertia_ratio[n]), np.zeros((4, 4)), 1
        if self.velocity_filter is not None:
            cut_off, rate = 2.0 * np.pi * self.velocity_filter, 3
            A[3, [1, 3]] = cut_off, -cut_off
        A[0, 1] = 1.0
        A[1, [0, rate, 2]] = -ratio * kp, -ratio * kv, -ratio
        if self.leak_rate is not None:
            drive = self.k_i[n] * np.array([self.p12[n], self.p22[n]])
            A[2, [0, rate, 2]] = *drive, -self.leak_rate
        kept = np.flatnonzero([True, True, self.leak_rate is not None, rate == 3])
        B, C = np.array([[0.0], [ratio], [0.0], [0.0]]), np.array([[1.0, 0.0, 0.0, 0.0]])
        return LinearModel(A[np.ix_(kept, kept)], B[kept], C[:, kept], np.zeros((1, 1)))

    def __str__(self) -> str:
        head = " " * 35 + "".join(f"{f'joint {n + 1}':>13}" for n in range(len(self.p11)))
        lines = [head]
        for name, row in self._rows().items():
            if not np.isnan(row).all():
                lines.append(f"{name:<35}" + "".join(f"{x:13.6g}" for x in row))
        for n, poles in enumerate(self.poles):
            known = poles[~np.isnan(poles)]
            if len(known):
                lines.append(f"poles of joint {n + 1} [1/s]: " + ", ".join(map(_pole, known)))
        if self.learnable is not None:
            lines += ["", "What this path can teach:", str(self.learnable)]
        if self.left_out:
            lines += ["", "Not in these figures: " + "; ".join(self.left_out) + "."]
        lines += ["", self._judged(), *(f"  - {finding}" for finding in self.findings)]
        return "\n".join(lines)

    def _judged(self) -> str:
        """The verdict, as what leads to the findings."""
        link = "." if not self.findings else ", but know that" if self.sound else ":"
        return f"Verdict: {self.verdict}{link}"

    def _repr_html_(self) -> str:
        """The report for a notebook: its table, and below it the verdict with the findings."""
        figures = []
        for name, row in self._rows().items():
            words, _, unit = name.removesuffix("]").partition(" [")
            # Three digits do not tell a radius from 1.
            values = [f"{x:.6g}" for x in row] if row is self.sampled_radius else row
            if not np.isnan(row).all():
                figures.append(Entry(words, unit, values))
        poles = [", ".join(map(_pole, row[~np.isnan(row)])) for row in self.poles]
        if any(poles):
            figures.append(Entry("poles", "1/s", poles))
        names = self.joint_names or numbered(len(self.p11))
        teaches = () if self.learnable is None else self.learnable.sentences
        verdict = f"<p><strong>{text(self._judged())}</strong></p>"
        return joined(
            [
                by_joint("What the controller will do.", names, figures, self.units),
                listed(self._judged(), self.findings) or verdict,
                listed("What this path can teach:", teaches),
                listed("Not in these figures:", self.left_out),
            ]
        )

    def _rows(self) -> dict[str, Array]:
        rows = {
            "P: p11": self.p11,
            "p12": self.p12,
            "p22": self.p22,
            "smallest eigenvalue": self.min_eigenvalue,
            "A + BB'P, largest real part [1/s]": self.max_real,
            "gamma must be larger than": self.gamma_opt,
            "Q may be multiplied by less than": self.max_scale,
            "integral action k_I": self.k_i,
            "predicted RMS error without [rad]": self.rms_without,
            "predicted RMS error with it [rad]": self.rms,
            "spectral radius when sampled": self.sampled_radius,
            "longest stable period [ms]": 1e3 * self.max_period,
            "stiffness [N·m/rad]": self.stiffness,
            "damping [N·m·s/rad]": self.damping,
        }
        if self.directions is not None:
            rows["directions that the rules take"] = np.array(self.directions, float)
        if self.rules_excited is not None:
            rows[f"rules excited, of {self.rules:g}"] = np.array(self.rules_excited, float)
        if self.survives is not None:
            rows["learnt: survives a freeze [%]"] = 100 * self.survives
        return rows


def _pole(z: complex) -> str:
    return f"{z.real:.4g}" if z.imag == 0.0 else f"{z:.4g}"


def design(
    tracker: _core.ComputedTorque,
    control_period: float = 1e-3,
    delay: int | None = None,
    disturbance: Sequence[tuple[float, float]] | None = None,
    inertia_ratio: float | None = None,
    *,
    path: Path | None = None,
    plant: _core.Plant | None = None,
    duration: float | None = None,
    effects: _core.Effects | None = None,
) -> DesignReport:
    """Report what a controller will do, with a compensator or without.

    The figures are those of a linear model, with the leak, the normalisation, the delay and the
    velocity filter in it; ``left_out`` says what is not. Along a ``path`` it is the sampled loop of
    all joints, with the arms linearised at 64 points of it and the rules as they fire there;
    otherwise each joint by itself, with the rules at the error 0. Where the rules see where the arm
    is (inputs "state", "reference", "trajectory"), a path is needed: without one there is no
    verdict. With a path the report says too what it can teach, as `learnable` does, and how the
    sets cover it; `centers_for` makes sets that do.

    A control period above three quarters of the longest stable one is refused, one above a third of
    it is warned of.

    Parameters
    ----------
    tracker: a `ComputedTorque`.
    control_period: of the control loop [s].
    delay: samples from measurement to torque, at most 8. None: that of ``effects``, or else what
        the tracker knows of.
    disturbance: harmonics of ρ along the reference, (amplitude [rad/s²], frequency [rad/s]) each;
        None: what ``plant`` has along ``path``, or else 1 rad/s² at 1 rad/s.
    inertia_ratio: believed over true inertia: 1 if right, 0.5 if the arm is twice as heavy. None:
        that of ``plant``, or else 1.
    path: what will be tracked: a reference; (t, q) or (t, q, dq, ddq) as a `Table` takes them; or
        positions (T, n), evenly spaced over ``duration``.
    plant: what is really there; it needs a path.
    duration: length of the path [s]. None: `Table`, `Quintic`, `Waypoints` to their ends, `Sines`
        over a period of the slowest; a callable needs it.
    effects: of the loop, as `simulate` takes them. Their delay counts, and where the tracker has
        no ``velocity_filter``, that of velocities made by "difference".

    Raises
    ------
    ValueError, TypeError
        For an argument that makes no sense; the message names it.
    """
    if plant is not None and path is None:
        raise ValueError("path: got None, wants the motion at which the plant is looked at")
    if plant is not None and inertia_ratio is not None:
        raise ValueError(f"inertia_ratio: got {inertia_ratio}, wants None beside a plant")
    if path is not None:
        path, duration = reference_of(path, duration)
    ratio = 1.0 if inertia_ratio is None else inertia_ratio
    # Another is refused below.
    known = isinstance(tracker, _core.Controller)
    own = arguments(tracker)["velocity_filter"] if known else None
    sensor, left_out = (None, []) if effects is None else _sensed(effects, own)
    if delay is None and effects is not None:
        delay = effects.delay
    figures: dict[str, Any] = _core.design(
        tracker, control_period, delay, sensor, disturbance, ratio, path, plant, duration
    )
    figures["left_out"] += left_out
    poles = np.array([[complex(*pole) for pole in joint] for joint in figures.pop("poles")])
    for name in ("findings", "left_out", "rules_excited", "directions"):
        if figures.get(name) is not None:
            figures[name] = tuple(figures[name])
    compensator = tracker.compensator
    teaches = None if path is None else learnable(tracker, path, duration)
    return DesignReport(
        poles=poles,
        kp=tracker.kp,
        kv=tracker.kv,
        leak_rate=None if compensator is None else arguments(compensator)["leak_rate"],
        delay=tracker.delay if delay is None else delay,
        velocity_filter=sensor if own is None else own,
        **figures,
        learnable=teaches,
        joint_names=joint_names(tracker.arm, len(poles)),
        units=lengths(tracker.arm.joint_kinds),
    )


SHARP = 1e6
"""A cut-off far above the rate of any loop: a higher one is the same [Hz]."""


def _sensed(effects: _core.Effects, own: float | None) -> tuple[float | None, list[str]]:
    """The cut-off of the loop's velocities where the tracker makes none of its ``own`` [Hz], and
    what of the effects is left out."""
    if not isinstance(effects, _core.Effects):
        raise TypeError(f"effects: got {type(effects).__name__}, wants an Effects")
    given = arguments(effects)
    left_out = ["effects, but for delay and velocities by difference"]
    made = None if own is not None else given["velocity"]
    if made in ("tracking", "kalman"):
        left_out.append(f"what velocities by {made} lag")
    if made != "difference":
        return None, left_out
    left_out.append("what the velocity lags behind dq_d (a velocity_filter sends both through it)")
    return min(given["velocity_cutoff"], SHARP), left_out
