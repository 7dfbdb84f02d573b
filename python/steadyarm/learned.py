"""What the recommended controller has learnt, in the units of a robot: load, friction, and how far
each figure may be off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._documented import documented
from ._html import Entry, by_joint, joined, listed
from ._joints import lengths, numbered
from ._scene import joint_names

Array = NDArray[np.float64]

LOAD = 10
"""Inertial parameters of a body."""

SLOW, FAST = 0.1, 1.0
"""Velocities at which friction is shown [rad/s]."""

SURE, DOUBTFUL = 0.5, 0.7
"""Of the condition: from here on it is said, and from there on the argument for it ends."""


@documented
@dataclass(frozen=True, eq=False)
class Learned:
    """What a recommended controller is made of and has learnt, of n joints.

    Deviations are standard deviations, of what was learnt so far: before the first step they are
    those of the prior. They take the features for complete; what no feature describes is not in
    them.
    """

    bandwidth: Array
    """p of each joint [rad/s], (n,): three poles."""
    cut_off: Array
    """Of the second velocity filter [Hz], (n,)."""
    condition: float
    """How near learning is to not converging, at the worst pose; the argument ends at 0.7."""
    quickness: Array
    """What the largest torque gives each joint at most [rad/s²], (n,)."""
    quickest: float
    """From here on a joint seems to lack its rotor [rad/s²]."""
    payload: float | None
    """Mass at the last link beyond what is believed [kg]; None for an arm of lumped parameters."""
    payload_deviation: float | None
    """Of it [kg]."""
    payload_com: Array | None
    """Its centre of mass in the frame of the last joint [m], (3,); None where the mass is not
    known to be other than 0."""
    parameters: Array
    """θ, (m,), in the order of the features."""
    covariance: Array
    """P, (m, m)."""
    own: int
    """Columns of each joint of its own, the last of all parameters."""
    widths: Array
    """Of the steps of friction [rad/s]."""
    joint_names: tuple[str, ...] = ()
    """Names of the joints; () or their numbers, from 1, where they have none."""
    units: tuple[str, ...] = ()
    """"rad" of each joint, "m" of a prismatic one."""

    def friction(self, velocity: ArrayLike) -> tuple[Array, Array]:
        """The friction that was learnt at a velocity [rad/s], scalar or (n,), beyond what is
        believed, and its deviation, both (n,) [N·m]."""
        joints = len(self.bandwidth)
        speeds = np.broadcast_to(np.asarray(velocity, dtype=float), (joints,))
        torque, deviation = np.empty((2, joints))
        for n, v in enumerate(speeds):
            row = np.array([*(np.tanh(v / width) for width in self.widths), v])
            first = len(self.parameters) - (joints - n) * self.own
            at = slice(first, first + len(row))
            torque[n] = row @ self.parameters[at]
            deviation[n] = np.sqrt(max(row @ self.covariance[at, at] @ row, 0.0))
        return torque, deviation

    def sentences(self) -> list[str]:
        """What there is to say, a sentence an entry."""
        p = ", ".join(f"{x:.3g}" for x in self.bandwidth)
        said = [f"bandwidth {p} rad/s", *self._of_the_arm()]
        for velocity in (SLOW, FAST):
            said.append(f"friction at {velocity:g} rad/s: {', '.join(self._rubs(velocity))} N·m")
        return said

    def _of_the_arm(self) -> list[str]:
        """What is not of each joint."""
        said = []
        if self.condition > SURE:
            doubt = (
                "the proof says nothing" if self.condition > DOUBTFUL else "it is near the limit"
            )
            said.append(
                f"learning: condition {self.condition:.2g}, {doubt}; declare a narrower load"
            )
        for joint in np.flatnonzero(self.quickness > self.quickest):
            said.append(
                f"joint {joint + 1} is light for its torque ({self.quickness[joint]:.2g} rad/s²): "
                "the arm will shake if it has a rotor that the model lacks"
            )
        if self.payload is not None:
            said.append(f"load at the tip: {self.payload:.4g} ± {self.payload_deviation:.2g} kg")
        if self.payload_com is not None:
            com = ", ".join(f"{1e3 * x:.0f}" for x in self.payload_com)
            said.append(f"its centre of mass, from the last joint: ({com}) mm")
        return said

    def _rubs(self, velocity: float) -> list[str]:
        """Friction of each joint at a velocity, with its deviation, in words."""
        pairs = zip(*self.friction(velocity), strict=True)
        return [f"{torque:.3g} ± {deviation:.2g}" for torque, deviation in pairs]

    def _repr_html_(self) -> str:
        """A table of the joints for a notebook, and below it what was learnt of the arm."""
        figures = [
            Entry("bandwidth", "rad/s", self.bandwidth),
            Entry("second velocity filter", "Hz", self.cut_off),
            Entry("quickest it can be", "rad/s²", self.quickness),
            *(
                Entry(f"friction at {velocity:g} rad/s", "N·m", self._rubs(velocity))
                for velocity in (SLOW, FAST)
            ),
        ]
        names = self.joint_names or numbered(len(self.bandwidth))
        return joined(
            [
                by_joint("What was learnt, beyond what is believed.", names, figures, self.units),
                listed("Of the whole arm:", self._of_the_arm()),
            ]
        )

    def __str__(self) -> str:
        return "\n".join(self.sentences())


def learned(controller: _core.Controller) -> Learned:
    """Return what a controller of `recommended` has learnt so far, to the latest period's end.

    The load is read from the last link: what of all that was learnt a load there, with friction,
    explains best, with the weight of what was seen. Raises TypeError for another controller.
    """
    told = _core.describe(controller) if isinstance(controller, _core.Controller) else {}
    if "covariance" not in told:
        raise TypeError("controller: got one that learns no parameters, wants one of recommended()")
    theta = told["parameters"]
    covariance = told["covariance"].reshape(len(theta), len(theta))
    joints = len(told["bandwidth"])
    of_links = int(told["of_links"][0])
    own = (len(theta) - of_links) // joints
    mass = deviation = com = None
    if of_links:
        load, spread = _load(theta, covariance, told["prior"], of_links)
        mass, deviation = float(load[0]), float(np.sqrt(max(spread[0, 0], 0.0)))
        if abs(mass) > 3.0 * deviation:
            com = load[1:4] / mass
    return Learned(
        bandwidth=told["bandwidth"],
        cut_off=told["cut_off"],
        condition=float(told["condition"][0]),
        quickness=told["quickness"],
        quickest=float(told["quickest"][0]),
        payload=mass,
        payload_deviation=deviation,
        payload_com=com,
        parameters=theta,
        covariance=covariance,
        own=own,
        widths=told["friction_widths"],
        joint_names=joint_names(controller.arm, joints),
        units=lengths(controller.arm.joint_kinds),
    )


def _load(theta: Array, covariance: Array, prior: Array, inertial: int) -> tuple[Array, Array]:
    """The ten parameters of a load on the last link that explains θ best, and their covariance.

    With Λ = P⁻¹ − P₀⁻¹, what was seen: min (θ − Sx)ᵀΛ(θ − Sx) + x' P₀⁻¹ x, S the columns of the
    last link and of friction.
    """
    live = prior > 0.0
    scale = np.sqrt(np.where(live, prior, 1.0))
    whole = covariance / np.outer(scale, scale) + np.diag(np.where(live, 0.0, 1.0))
    seen = np.linalg.inv(whole) - np.eye(len(theta))
    seen[~live, :] = seen[:, ~live] = 0.0
    chosen = np.r_[inertial - LOAD : inertial, inertial : len(theta)]
    # A load may be far heavier than the last link, whose size the prior is.
    loose = np.where(chosen < inertial, 1e-4, 1.0)
    gram = seen[np.ix_(chosen, chosen)] + np.diag(loose)
    spread = np.linalg.inv(gram)
    estimate = spread @ (seen[chosen] @ (theta / scale))
    back = scale[chosen][:LOAD]
    return estimate[:LOAD] * back, spread[:LOAD, :LOAD] * np.outer(back, back)
