"""What can be learnt along a path, of an arm, its joints' friction and a payload."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._documented import documented
from ._html import Entry, by_joint, joined, listed
from ._joints import lengths, numbered
from ._scene import joint_names
from .centers import Outside, coverage
from .paths import Course, Path, sample

Array = NDArray[np.float64]

FAST = 0.05
"""Friction at lower speeds [rad/s] is of another kind: presliding, Stribeck's, or of a joint at
rest, which friction of any size may hold."""

MOVED = 1e-6
"""Joints move that do by more than this [rad]."""

PERIOD = 0.02
"""Of the torques that are learnt from [s]: closer ones say the same once more, for they pass
through a filter of some Hz."""

ROWS = 500
"""Points of the path at which the equations are written out, at most."""

KNOWN = 0.1
"""What is known to this part of its size is learnt."""

REACH = 0.15
"""Lever of a link's mass [m], which the size of its moments follows from."""

UNSEEN = 1e-9
"""A direction with less than this part of the strongest one's singular value is none."""

UNKNOWN = 1e3
"""A standard deviation of so many times the size says nothing: it is infinite."""


@documented
@dataclass(frozen=True, eq=False)
class Learnable:
    """What one path teaches, at best: with an arm that is right but for what is to be learnt."""

    duration: float
    """Length of the path [s]."""
    speeds: Array
    """The largest speed of each joint backwards and forwards [rad/s], (2, n)."""
    friction: tuple[str, ...]
    """What is learnt of each joint's friction: "both ways", "one way", "slow" or "nothing"."""
    directions: int
    """Combinations of masses, first moments and moments of inertia that the path shows …"""
    all_directions: int
    """… of those that any motion can show."""
    payload: float
    """Mass [kg] that the words compare with."""
    payload_mass: float
    """Standard deviation of a payload's mass [kg]; infinite where the path does not show it."""
    payload_com: Array
    """That of its centre of mass in the tip's frame, for a payload of ``payload`` [m], (3,)."""
    payload_inertia: Array
    """That of its moments about the tip, xx, xy, yy, xz, yz, zz [kg·m²], (6,)."""
    coverage: float | None = None
    """Share of the path's time in which every input of the rules is in one of its sets by half or
    more; None without a compensator."""
    outside: tuple[Outside, ...] = ()
    """The inputs that leave their sets."""
    joint_names: tuple[str, ...] = ()
    """Names of the joints; () or their numbers, from 1, where they have none."""
    units: tuple[str, ...] = ()
    """"rad" of each joint, "m" of a prismatic one."""

    @property
    def sentences(self) -> tuple[str, ...]:
        """All of that in words."""
        return (*self._of_friction(), *self._of_directions(), *self._of_payload(), *self._of_sets())

    def __str__(self) -> str:
        return "\n".join(f"  - {sentence}" for sentence in self.sentences)

    def _repr_html_(self) -> str:
        """A table of the joints for a notebook, and below it what the path teaches."""
        back, forth = self.speeds
        figures = [
            Entry("fastest backwards", "rad/s", back),
            Entry("fastest forwards", "rad/s", forth),
            Entry("its friction is shown", "", self.friction),
        ]
        names = self.joint_names or numbered(len(self.friction))
        return joined(
            [
                by_joint("What the path shows of each joint.", names, figures, self.units),
                listed("What this path can teach:", self.sentences),
            ]
        )

    def _of_friction(self) -> list[str]:
        lines = []
        for kind, (one, many, then) in FRICTION_WORDS.items():
            joints = [n for n, what in enumerate(self.friction) if what == kind]
            if joints:
                verb, possessive = (one, "its") if len(joints) == 1 else (many, "their")
                lines.append(f"{_joints(joints)} {verb}: {possessive} friction {then}")
        return lines

    def _of_directions(self) -> list[str]:
        seen, every = self.directions, self.all_directions
        of = f"{seen} of the {every}" if seen < every else f"all {every}"
        line = f"{of} combinations of masses and moments that matter can be learnt"
        rest = ": a model that is fitted here is not right on every other path"
        return [line + (rest if seen < every else "")]

    def _of_payload(self) -> list[str]:
        mass = self.payload
        stds = (self.payload_mass, *self.payload_com, *self.payload_inertia)
        sizes = (mass, *[REACH] * 3, *[mass * REACH**2] * 6)
        scales = (100.0 / mass, *[1e3] * 3, *[1.0] * 6)
        known, rest = [], []
        for (name, unit), std, size, scale in zip(BODY, stds, sizes, scales, strict=True):
            if std <= KNOWN * size:
                known.append(f"{name} to {scale * std:.2g} {unit}")
            else:
                rest.append(name)
        after = f"a payload of {mass:g} kg after {self.duration:.3g} s"
        lines = [f"{after}, known: {', '.join(known)}"] if known else []
        return lines + ([f"{after}, not known: {', '.join(rest)}"] if rest else [])

    def _of_sets(self) -> list[str]:
        if self.coverage is None:
            return []
        lines = [f"the sets cover {100.0 * self.coverage:.3g} % of the path's time"]
        for signal, joint, by in self.outside:
            unit = UNITS[signal.removesuffix("_d").count("d")]
            lines.append(f"{signal} of joint {joint + 1} leaves its sets by {by:.2g} {unit}")
        return lines


FRICTION_WORDS = {
    "both ways": (
        f"moves both ways, faster than {FAST:g} rad/s",
        f"move both ways, faster than {FAST:g} rad/s",
        "can be learnt",
    ),
    "one way": ("moves one way only", "move one way only", "can be learnt for that way alone"),
    "slow": (
        f"is never faster than {FAST:g} rad/s",
        f"are never faster than {FAST:g} rad/s",
        "cannot be learnt",
    ),
    "nothing": ("never moves", "never move", "cannot be learnt"),
}

BODY = (
    ("mass", "%"),
    *((f"{axis} of its centre of mass", "mm") for axis in "xyz"),
    *((f"moment {axes}", "kg·m²") for axes in ("xx", "xy", "yy", "xz", "yz", "zz")),
)
"""The numbers of a payload, and what their standard deviations are told in."""

UNITS = ("rad", "rad/s", "rad/s²")
"""By the number of derivatives."""


def learnable(
    robot: _core.Arm | _core.Controller,
    path: Path,
    duration: float | None = None,
    *,
    noise: ArrayLike = 0.01,
    payload: float = 1.0,
) -> Learnable:
    """Tell what a path can teach, whatever learns: ``print(sa.learnable(arm, path))``.

    Torques are linear in masses, first moments and moments of inertia, in Coulomb and viscous
    friction, and in the ten numbers of a payload at the tip. A torque with this ``noise`` every
    20 ms, without any error of the model, leaves the standard deviations of least squares,
    √diag((ΦᵀΦ)⁻¹) noise: no method that has to find out the same does better, and real arms do
    worse. Of a payload, the arm is taken to be known but for the friction of its joints.

    A combination of masses and moments counts as shown where it gets known to a tenth of the size
    that the links have: m, m 0.15 m, m (0.15 m)². For a prismatic joint read m for rad.

    Parameters
    ----------
    robot: the arm; or a controller, of its nominal arm. A `ComputedTorque` with a compensator also
        tells how its sets cover the path.
    path: a reference; (t, q) or (t, q, dq, ddq) as a `Table` takes them; or positions (T, n),
        evenly spaced over ``duration``.
    duration: how long it is followed [s]; None: `Table`, `Quintic`, `Waypoints` to their ends,
        `Sines` over a period of the slowest; a callable needs it.
    noise: standard deviation of the torques [N·m], scalar or (n,), > 0.
    payload: mass [kg] that the words compare with, > 0.

    Raises
    ------
    ValueError, TypeError
        Naming the argument.
    """
    compensator = getattr(robot, "compensator", None)
    arm = robot.arm if isinstance(robot, _core.Controller) else robot
    if not isinstance(arm, _core.Arm):
        raise TypeError(f"robot: got {type(arm).__name__}, wants an Arm or a Controller")
    sigma = _positive("noise", noise, arm.joints)
    mass = float(_positive("payload", payload, 1)[0])
    course = sample(path, duration, arm)
    chain = _chain(arm)
    rows, friction = _equations(chain, course, sigma)
    deviations = _payload_deviations(chain, rows, friction, mass)
    covered = (None, ()) if compensator is None else coverage(compensator.basis, course)
    speeds = np.array([-course.dq.min(axis=0), course.dq.max(axis=0)]).clip(min=0.0)
    return Learnable(
        duration=float(course.t[-1]),
        speeds=speeds,
        friction=tuple(map(_friction, np.ptp(course.q, axis=0), *speeds)),
        directions=_shown(chain, rows, friction),
        all_directions=_matter(chain),
        payload=mass,
        payload_mass=float(deviations[0]),
        payload_com=deviations[1:4] / mass,
        payload_inertia=deviations[4:],
        coverage=covered[0],
        outside=covered[1],
        joint_names=joint_names(arm, arm.joints),
        units=lengths(arm.joint_kinds),
    )


def _positive(name: str, value: ArrayLike, joints: int) -> Array:
    try:
        numbers = np.broadcast_to(np.asarray(value, float), (joints,))
    except (TypeError, ValueError):
        raise TypeError(f"{name}: got {value!r}, wants a number, or ({joints},) of them") from None
    if not (np.isfinite(numbers) & (numbers > 0.0)).all():
        raise ValueError(f"{name}: got {value!r}, wants numbers > 0")
    return numbers


def _friction(moved: float, back: float, forth: float) -> str:
    """What a joint that moves so far, and so fast either way, tells of its friction."""
    if moved <= MOVED:
        return "nothing"
    if max(back, forth) <= FAST:
        return "slow"
    return "both ways" if min(back, forth) > FAST else "one way"


def _chain(arm: _core.Arm) -> _core.Serial:
    """The same arm as a chain, which has a regressor."""
    if isinstance(arm, _core.Serial):
        return arm
    mass, length, inertia, gravity, *_ = arm.parameters  # type: ignore[attr-defined]
    return _core.Serial.from_dh(
        a=length, alpha=[0.0, 0.0], d=[0.0, 0.0], mass=mass, gravity=(0.0, -gravity, 0.0),
        com=[[-0.5 * x, 0.0, 0.0] for x in length], inertia=[[x, x, x] for x in inertia],
    )  # fmt: skip


def _equations(arm: _core.Serial, course: Course, sigma: Array) -> tuple[Array, Array]:
    """Rows of the regressor, and of Coulomb and viscous friction, in standard deviations.

    As many as ROWS points have, with the weight of one every PERIOD.
    """
    n, joints = arm.joints, np.arange(arm.joints)
    at = np.unique(np.linspace(0, len(course.t) - 1, ROWS).astype(int))
    points = zip(course.q[at], course.dq[at], course.ddq[at], strict=True)
    rows = np.array([arm.regressor(*point) for point in points])
    friction = np.zeros((len(at), n, 2, n))
    friction[:, joints, 0, joints] = np.tanh(course.dq[at] / FAST)
    friction[:, joints, 1, joints] = course.dq[at]
    weight = np.tile(np.sqrt(course.t[-1] / PERIOD / len(at)) / sigma, len(at))[:, None]
    return rows.reshape(-1, 10 * n) * weight, friction.reshape(-1, 2 * n) * weight


def _sizes(arm: _core.Serial) -> Array:
    """The size of each inertial parameter, (10n,): of each link m, m REACH, m REACH²."""
    masses = arm.inertial_parameters()[::10]
    masses = np.maximum(masses, 0.01 * masses.sum())
    return np.outer(masses, [1.0, *[REACH] * 3, *[REACH**2] * 6]).ravel()


def _shown(arm: _core.Serial, rows: Array, friction: Array) -> int:
    """Directions of the inertial parameters that get known, with the friction unknown too."""
    friction = friction[:, friction.any(axis=0)]
    triangle = _triangle(np.hstack([friction, rows * _sizes(arm)]))
    free = triangle[friction.shape[1] :, friction.shape[1] :]
    return int((np.linalg.svd(free, compute_uv=False) >= 1.0 / KNOWN).sum())


def _matter(arm: _core.Serial) -> int:
    """Directions of the inertial parameters that any motion can show: the rank of Y."""
    random = np.random.default_rng(0)
    motions = random.uniform(-3.0, 3.0, (20 * arm.joints, 3, arm.joints))
    rows = np.vstack([arm.regressor(*motion) for motion in motions]) * _sizes(arm)
    seen = np.linalg.svd(_triangle(rows), compute_uv=False)
    return int((seen > UNSEEN * seen[0]).sum())


def _payload_deviations(arm: _core.Serial, rows: Array, friction: Array, mass: float) -> Array:
    """Standard deviations of a payload's mass, first moments and moments about the tip, (10,)."""
    sizes = mass * np.array([1.0, *[REACH] * 3, *[REACH**2] * 6])
    columns = np.hstack([rows[:, -10:] @ _carried(arm) * sizes, friction])
    triangle = _triangle(columns)
    norms = np.linalg.norm(triangle, axis=0)
    seen = norms > 1.0 / UNKNOWN
    _, size, axes = np.linalg.svd(triangle[:, seen] / norms[seen], full_matrices=False)
    size = np.maximum(size, UNSEEN * size.max(initial=0.0))
    deviations = np.full(columns.shape[1], np.inf)
    deviations[seen] = np.linalg.norm(axes.T / size, axis=1) / norms[seen]
    return sizes * np.where(deviations[:10] > UNKNOWN, np.inf, deviations[:10])


def _triangle(rows: Array) -> Array:
    """R of QR: it has the singular values of the rows, and far fewer rows."""
    return np.asarray(np.linalg.qr(rows, mode="r"), dtype=float)


def _carried(arm: _core.Serial) -> Array:
    """The parameters that a body at the tip adds to the last link: (10, 10) times its own.

    The pseudo-inertia [Σ, m c; (m c)ᵀ, m] with Σ = ½ tr(I) 1 - I is carried as T J Tᵀ by the pose
    T of the tip in the last joint's frame (Wensing, Kim, Slotine 2018).
    """
    q = np.zeros(arm.joints)
    pose = np.linalg.inv(arm.link_poses(q)[-1]) @ arm.pose(q)
    units = (_pseudo_inertia(unit) for unit in np.eye(10))
    return np.array([_parameters(pose @ unit @ pose.T) for unit in units]).T


def _pseudo_inertia(body: Array) -> Array:
    xx, xy, yy, xz, yz, zz = body[4:]
    moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    whole = np.empty((4, 4))
    whole[:3, :3] = 0.5 * np.trace(moments) * np.eye(3) - moments
    whole[3, :3] = whole[:3, 3] = body[1:4]
    whole[3, 3] = body[0]
    return whole


def _parameters(whole: Array) -> Array:
    second = whole[:3, :3]
    moments = np.trace(second) * np.eye(3) - second
    places = ([0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2])
    return np.array([whole[3, 3], *whole[:3, 3], *moments[places]])


def _joints(joints: list[int]) -> str:
    *most, last = [str(joint + 1) for joint in joints]
    return f"joints {', '.join(most)} and {last}" if most else f"joint {last}"
