"""The compiled core; `steadyarm` has all but the functions that its own are made of.

Equation numbers are those of the paper. Arrays may be lists, tuples, or numpy arrays of any
real type, order and stride. They are copied, and what comes back is always a new float64 array.

Arms have n joints, 1 to 12. Where a scalar stands for a vector it counts for all joints. What
was given scalars only fits any arm; where there is no arm, it is taken for one of two joints.

Errors name the argument, what it got and what it wants: ``TypeError`` for a wrong type,
``ValueError`` for a wrong shape or value (NaN and infinity included).
"""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, Protocol, Self, TypedDict, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import disjoint_base

__all__ = [
    "MAX_RECORD_BYTES",
    "Arm",
    "ComputedTorque",
    "Controller",
    "Curve",
    "Disturbance",
    "Effects",
    "Excess",
    "FuzzyApproximator",
    "FuzzyBasis",
    "FuzzyCompensator",
    "Guard",
    "NoStabilizingSolution",
    "Noise",
    "Plant",
    "Pulses",
    "Quintic",
    "RiccatiSolution",
    "Serial",
    "Settings",
    "Sines",
    "Table",
    "TwoLink",
    "Waypoints",
    "Wrench",
    "bounded_real_riccati",
    "canonical_scenario",
    "care",
    "channels",
    "choices",
    "describe",
    "design",
    "desired_motion",
    "metrics",
    "paper_scenario",
    "read_scenario",
    "simulate",
    "simulate_many",
]

MAX_RECORD_BYTES: int
"""`simulate` refuses a larger record [bytes]."""

_Array = NDArray[np.float64]
_Triple = tuple[_Array, _Array, _Array]
_JointKind = Literal["revolute", "continuous", "prismatic"]
_Signal = Literal["e", "de", "q", "dq", "q_d", "dq_d", "ddq_d"]

class _Stepping(Protocol):
    def step(
        self, q: _Array, dq: _Array, q_d: _Array, dq_d: _Array, ddq_d: _Array, dt: float, /
    ) -> ArrayLike: ...

_Inputs = (
    Literal["error", "state", "reference", "trajectory"]
    | _Signal
    | list[_Signal]
    | tuple[_Signal, ...]
    | dict[_Signal, float]
)
_ReferenceCallable = Callable[[float], tuple[ArrayLike, ArrayLike, ArrayLike]]
_DisturbanceCallable = Callable[[_Array, _Array, float], ArrayLike]

class _CertificateRecord(TypedDict):
    residual: float
    v_start: float
    v_end: float
    supplied: float
    state_cost: float
    uncertainty: float

class _Dictionary(TypedDict):
    """A dictionary in figures."""

    atoms: int
    capacity: int
    merged: int
    dropped: int
    error_bound: _Array

class _MetricsRecord(TypedDict):
    rms_e: _Array
    max_abs_e: _Array
    itae: _Array
    settling_time: _Array
    rms_tau: _Array
    max_abs_tau: _Array
    torque_variation: _Array

class _Limits(TypedDict):
    lower: _Array
    upper: _Array
    velocity: _Array
    effort: _Array

class NoStabilizingSolution(ValueError):
    """The Riccati equation (19) has no stabilising solution.

    There is one exactly when ``gamma > gamma_opt``, or, at this gamma, for Q times less than
    ``max_scale``.

    Attributes
    ----------
    gamma: γ that was asked for.
    gamma_opt: the smallest γ with a solution for this Q; γ must be larger.
    max_scale: at this γ, Q times anything smaller than this has a solution.
    """

    gamma: float
    gamma_opt: float
    max_scale: float

@disjoint_base
class Settings:
    """What is nothing but its arguments: two are equal, with one hash, when these are.

    ``copy.replace(it, argument=value)``, or before Python 3.13 ``it.__replace__(argument=value)``,
    is a copy with other arguments. It can be pickled; its repr shows every argument, long lists by
    their first and last entry.
    """

    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __replace__(self, /, **changes: Any) -> Self: ...
    def __reduce__(self) -> tuple[type[Self], tuple[Any, ...]]: ...

@disjoint_base
class Arm(Settings):
    """An arm of n joints, 1 to 12: the base class of `TwoLink` and `Serial`.

    ``M(q) ddq + H(q, dq) + s(q, dq) = tau`` with ``H = C dq + G + f`` (6).

    ``q`` [rad], ``dq`` [rad/s], ``ddq`` [rad/s²], ``tau`` [N·m]: (n,), finite; float64 arrays are
    fastest. ``out``: a float64 array (n,) that is written to and returned. For a prismatic joint,
    read m for rad and N for N·m.
    """

    @property
    def joints(self) -> int:
        """Number of joints n."""
    @property
    def joint_kinds(self) -> tuple[_JointKind, ...]:
        """How the joints move, from the base on: "revolute", "continuous" or "prismatic".

        A continuous joint turns without an end, and positions a turn apart are the same. A tracker
        with this nominal arm takes its error around the circle, -π <= e < π.
        """
    def mass_matrix(self, q: ArrayLike) -> _Array:
        """M(q) [kg·m²], (n, n), symmetric positive definite."""
    def coriolis(self, q: ArrayLike, dq: ArrayLike) -> _Array:
        """C(q, dq) [N·m·s], (n, n), by Christoffel symbols: dM/dt - 2C is skew-symmetric."""
    def gravity(self, q: ArrayLike) -> _Array:
        """G(q) [N·m], (n,)."""
    def friction(self, dq: ArrayLike) -> _Array:
        """f(dq) [N·m], (n,): viscous, Coulomb and Stribeck friction."""
    def stops(self, q: ArrayLike, dq: ArrayLike) -> _Array:
        """s(q, dq) [N·m], (n,): what drives the joints on into the stops of `with_stops`."""
    def bias(self, q: ArrayLike, dq: ArrayLike) -> _Array:
        """H(q, dq) = C dq + G + f [N·m], (n,), without stops; eq. (6)."""
    def inverse_dynamics(
        self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, out: _Array | None = None
    ) -> _Array:
        """tau = M(q) ddq + H(q, dq) + s(q, dq) [N·m], (n,), written to ``out`` if it is given."""
    def forward_dynamics(
        self, q: ArrayLike, dq: ArrayLike, tau: ArrayLike, out: _Array | None = None
    ) -> _Array:
        """ddq = M(q)⁻¹ (tau - H(q, dq) - s(q, dq)) [rad/s²], (n,), written to ``out`` if given."""
    def kinetic_energy(self, q: ArrayLike, dq: ArrayLike) -> float:
        """dq' M(q) dq / 2 [J]."""
    def potential_energy(self, q: ArrayLike) -> float:
        """U(q) [J]; its gradient is G(q)."""
    def pose(self, q: ArrayLike) -> _Array:
        """Pose of the tip in the base, (4, 4)."""
    def link_poses(self, q: ArrayLike) -> _Array:
        """Poses of the joints' frames in the base, (n, 4, 4); x is along the link in a TwoLink."""

@final
class TwoLink(Arm):
    """The paper's planar arm of two links, in closed form (section 4).

    ``M(q) ddq + H(q, dq) = tau`` with ``H = C dq + G + f`` (6). q₁ is measured from the horizontal
    axis, q₂ from the first link. Centres of mass are at mid-link.

    Parameters
    ----------
    mass: m of each link [kg], > 0; scalar or (2,), as all that follow but ``gravity``.
    length: l of each link [m], > 0.
    inertia: I of each link about its centre of mass [kg·m²], > 0.
    gravity: g [m/s²], downwards; 0 by default, an arm that lies flat as the paper's.
    viscous: viscous friction of each joint [N·m·s/rad], >= 0; 0 by default.
    coulomb: Coulomb friction [N·m], >= 0; 0 by default.
    smoothing: the speed at which Coulomb friction reaches 76 % [rad/s], ≥ 0; 0.01 by
        default, 0 for dry friction that sticks.

    Raises
    ------
    ValueError, TypeError
        Naming the parameter. It is ``mass_matrix.det`` or ``gravity_torque`` if numbers that are
        valid one by one overflow or underflow together.
    """

    def __new__(
        cls,
        mass: ArrayLike,
        length: ArrayLike,
        inertia: ArrayLike,
        gravity: float | None = None,
        viscous: ArrayLike | None = None,
        coulomb: ArrayLike | None = None,
        smoothing: ArrayLike | None = None,
    ) -> TwoLink: ...
    @property
    def parameters(
        self,
    ) -> tuple[list[float], list[float], list[float], float, list[float], list[float], list[float]]:
        """(mass, length, inertia, gravity, viscous, coulomb, smoothing), as they were given."""
    def with_friction(
        self, viscous: ArrayLike = 0.0, coulomb: ArrayLike = 0.0, smoothing: ArrayLike = 0.01
    ) -> TwoLink:
        """Return the same arm with this friction in place of its own; scalars or (2,)."""
    def with_gravity(self, gravity: float) -> TwoLink:
        """Return the same arm under another ``gravity`` [m/s²]; 0 for one that lies flat."""

@final
class Serial(Arm):
    """A serial arm of 1 to 12 revolute and prismatic joints on a fixed base.

    Made by `from_urdf`, `from_dh`, `from_toml` or `shipped`. Pickles by its TOML, bit for bit, and
    two are equal when all that it says is. `with_payload` and the like are copies with changes.

    Raises
    ------
    ValueError, TypeError
        Naming the argument; for a description with the line, what it got and what it wants.
    OSError
        For a file that cannot be opened.
    """

    @staticmethod
    def from_urdf(
        path_or_text: str | PathLike[str],
        base: str | None = None,
        tip: str | None = None,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        *,
        masses: Mapping[str, float] | None = None,
        inertials: Mapping[str, tuple[float, ArrayLike, ArrayLike]] | None = None,
        unphysical: Literal["refuse", "note", "nearest"] = "refuse",
    ) -> Serial:
        """Read the chain from link ``base`` (default: the root) to link ``tip`` (the only end).

        A string that starts with ``<`` is the text itself. Fixed joints are merged; other joints
        are held at 0. ``gravity`` [m/s²] is in the axes of the file's root, even if ``base`` is
        turned against it. Faults outside the chain do not matter. What was not used, or looks odd,
        stands in `notes`. Expand a file with macros first: ``pip install xacrodoc`` and
        ``xacrodoc robot.urdf.xacro -o robot.urdf``.

        ``masses``: {link: kg}, in place of those that the file states. Centres of mass stay, and
        moments are scaled with the mass. Where the file states no mass, the body is uniform in the
        shape of ``<collision>``, or else of ``<visual>``, if that is of boxes, cylinders and balls.
        Meshes are not opened.

        ``inertials``: {link: (mass [kg], com [m], moments [kg·m²])} in the link's frame, in place
        of what the file states, if it states any. com is (3,); moments are about it: a scalar for
        all axes, a diagonal (3,), or (3, 3). Links that are fixed to others may be named too, here
        and in ``masses``.

        ``unphysical``: what is done about a link that no rigid body can be, with all that is fixed
        to it (negative mass or moments, a broken triangle inequality). "refuse": raise ValueError.
        "note": take it as it stands, as Pinocchio does. "nearest": take the nearest body with the
        same mass and centre of mass; what is negative of ½ tr(I) 1 - I is left out. `notes` say how
        far off the link is. M must be positive definite in any case. The arm and its TOML keep the
        policy.
        """
    @staticmethod
    def from_dh(
        a: ArrayLike,
        alpha: ArrayLike,
        d: ArrayLike,
        theta_offset: ArrayLike = 0.0,
        *,
        convention: Literal["standard", "modified"] = "standard",
        kind: _JointKind | Sequence[_JointKind] = "revolute",
        mass: ArrayLike = 0.0,
        com: ArrayLike = 0.0,
        inertia: ArrayLike = 0.0,
        viscous: ArrayLike = 0.0,
        coulomb: ArrayLike = 0.0,
        armature: ArrayLike = 0.0,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        name: str = "arm",
        unphysical: Literal["refuse", "note", "nearest"] = "refuse",
    ) -> Serial:
        """Build from a Denavit-Hartenberg table: ``a``, ``d`` [m]; ``alpha``, ``theta_offset``.

        Each column is a scalar for all joints or (n,); angles [rad]. ``mass`` [kg]; ``com`` [m],
        (n, 3), in the table's frame i; ``inertia`` [kg·m²] about it: (n, 3) for a
        diagonal, or (n, 3, 3). ``viscous`` [N·m·s/rad], ``coulomb`` [N·m], ``armature`` [kg·m²].
        ``unphysical``: as in `from_urdf`.
        """
    @staticmethod
    def from_toml(
        path_or_text: str | PathLike[str],
        *,
        unphysical: Literal["refuse", "note", "nearest"] | None = None,
    ) -> Serial:
        """Read what `to_toml` wrote. A string of several lines is the text itself.

        ``unphysical``: as in `from_urdf`; by default what the file says, "refuse" if nothing.
        """
    @staticmethod
    def shipped(name: str) -> Serial:
        """Take one of the arms that come with the wheel: "panda", "puma560", "ur5e"."""
    def to_toml(self) -> str:
        """Return the arm as TOML; `from_toml` gives it back, bit for bit."""
    def without_friction(self) -> Serial:
        """Return the same arm with no friction in any joint."""
    def with_friction(
        self,
        viscous: ArrayLike = 0.0,
        coulomb: ArrayLike = 0.0,
        stribeck: ArrayLike = 0.0,
        stribeck_speed: ArrayLike = 0.1,
        smoothing: ArrayLike = 0.01,
    ) -> Serial:
        """Return the same arm with this friction in place of its own; scalars or (n,).

        ``viscous`` [N·m·s/rad], ``coulomb`` [N·m], ``stribeck``: by how much breaking away takes
        more [N·m], ``stribeck_speed``: where that has fallen to 1/e [rad/s], ``smoothing``: where
        Coulomb friction reaches 76 % [rad/s]; 0 for dry friction that sticks.
        """
    def with_armature(self, armature: ArrayLike) -> Serial:
        """Return the same arm with rotors of this inertia in place of its own; scalar or (n,).

        Seen through the gears: gear² · rotor inertia [kg·m²].
        """
    def with_gravity(self, gravity: ArrayLike) -> Serial:
        """Return the same arm under another ``gravity`` (3,) [m/s²], in the axes of the base."""
    def with_parameters(self, parameters: ArrayLike) -> Serial:
        """Return the same arm with inertial parameters π, (10n,), as `inertial_parameters` gives.

        There and back is the same to rounding. `unphysical` says what is done about a link that no
        rigid body can be. Raises ValueError for first moments m c without a mass m.
        """
    def with_stops(self, stiffness: ArrayLike, dissipation: ArrayLike = 1.0) -> Serial:
        """Return the same arm with stops at the ends of its joints' ranges, if they have ends.

        A joint that is δ beyond an end is pushed back with
        max(0, ``stiffness`` δ (1 + ``dissipation`` dδ/dt)), after Hunt and Crossley. Stiffness is
        in N·m/rad, or N/m for a prismatic joint, 0 for none; dissipation in s/rad or s/m. Both are
        scalars or (n,). Stops are part of inverse and forward dynamics, so of a `Plant`. They are
        not part of `bias`: a `ComputedTorque` of this arm does not count on them.

        A joint rests in a stop of any stiffness. A bounce is followed while
        ``dt`` < 1 / √(stiffness (M⁻¹)ⱼⱼ). Here 1/(M⁻¹)ⱼⱼ is the inertia that the stop meets, often
        far less than Mⱼⱼ. A shorter bounce is lost, and `Run.status` is "unresolved". "dp54" finds
        its own step. Raises ValueError for an arm whose joints have no ends.
        """
    def with_payload(
        self, mass: float, com: ArrayLike = (0.0, 0.0, 0.0), inertia: ArrayLike = 0.0
    ) -> Serial:
        """Return the same arm with a body fixed to its tip.

        ``mass`` [kg], ``com`` (3,) [m] in the tip's frame, ``inertia`` [kg·m²] about it: a scalar
        for all axes, a diagonal (3,), or (3, 3). It must be one that a rigid body can have,
        whatever `unphysical` says.
        """
    def perturb(
        self,
        seed: int,
        mass: float = 0.2,
        com: float = 0.01,
        inertia: float = 0.2,
        friction: float = 0.2,
    ) -> Serial:
        """Return a neighbour, physically valid, and the same for the same seed on any machine.

        Masses, moments and friction are off by shares up to ±``mass``, ±``inertia`` and
        ±``friction``, centres of mass by up to ±``com`` [m] along each axis.
        """
    @property
    def name(self) -> str:
        """What the robot is called."""
    @property
    def joint_names(self) -> list[str]:
        """Names of the joints, from the base on."""
    @property
    def link_names(self) -> list[str]:
        """Names of the links that they move."""
    @property
    def notes(self) -> list[str]:
        """What the description says that was not used, or not taken as it stands."""
    @property
    def unphysical(self) -> Literal["refuse", "note", "nearest"]:
        """What is done about links that no rigid body can be; see `from_urdf`."""
    @property
    def limits(self) -> _Limits:
        """Limits by name, (n,) each, infinite for none.

        "lower" and "upper" [rad], "velocity" [rad/s], "effort" [N·m].
        """
    def check(
        self,
        reference: Curve | _ReferenceCallable,
        duration: float,
        dt: float = 0.001,
    ) -> list[Excess]:
        """Return what ``reference`` exceeds of `limits`, before it runs: an empty list if nothing.

        Every ``dt`` from 0 to ``duration`` [s], at most 1e7 times, this looks at position,
        velocity, and the torque that the motion takes, M(q_d) ddq_d + H(q_d, dq_d). The list has
        the worst of each, joint by joint: ``for excess in arm.check(path, 2.0): print(excess)``.
        """
    def slotine_li(self, q: ArrayLike, dq: ArrayLike, dq_r: ArrayLike, ddq_r: ArrayLike) -> _Array:
        """M ddq_r + C(q, dq) dq_r + G [N·m], (n,), without friction and stops."""
    def regressor(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> _Array:
        """Y(q, dq, ddq), (n, 10n): ``Y @ inertial_parameters()`` = M ddq + C dq + G.

        Without friction, stops and armature.
        """
    def inertial_parameters(self) -> _Array:
        """π, (10n,), of each link: m, m c, moments xx, xy, yy, xz, yz, zz about its origin."""
    def jacobian(self, q: ArrayLike) -> _Array:
        """Jacobian of the tip in the axes of the base, (6, n).

        ``J @ dq`` is the velocity of the tip [m/s] (rows 0 to 2) and its angular velocity [rad/s]
        (rows 3 to 5).
        """
    def __reduce__(self) -> tuple[Any, tuple[str]]: ...

@final
class Excess(Settings):
    """A limit of a joint that a reference exceeds, where it does so most; of `Serial.check`."""

    def __new__(
        cls,
        joint: int,
        name: str,
        bound: Literal["position", "velocity", "effort"],
        limit: float,
        value: float,
        by: float,
        time: float,
        first: float,
        message: str,
    ) -> Excess: ...
    @property
    def joint(self) -> int:
        """Joint, from 0."""
    @property
    def name(self) -> str:
        """Name of the joint."""
    @property
    def bound(self) -> Literal["position", "velocity", "effort"]:
        """Which of its limits: "position", "velocity" or "effort"."""
    @property
    def limit(self) -> float:
        """The limit [rad, rad/s or N·m; m, m/s or N for a prismatic joint]."""
    @property
    def value(self) -> float:
        """What the reference asks for."""
    @property
    def by(self) -> float:
        """By how much that is too much, > 0."""
    @property
    def time(self) -> float:
        """When it asks for that [s]."""
    @property
    def first(self) -> float:
        """When the limit is first exceeded [s]."""
    @property
    def message(self) -> str:
        """All of that in words, as ``str`` gives it."""

@final
class FuzzyBasis(Settings):
    """Gaussian fuzzy sets, how they combine to rules, and the signals they see: ξ(x) of (1)-(4).

    The paper gives the sets but not the rules; all four readings are here. Inputs come joint after
    joint within a signal: [e₁ … eₙ, de₁ … deₙ] for "error". ξ is finite however far x is from the
    centres.

    Parameters
    ----------
    form: "grid": a rule for every combination of one set per input (5⁴ = 625 for the paper's
        sets); "shared": rule j uses set j on every input (5); "concat": a rule for every set of
        every input, normalised input by input (20); "per_joint": a grid for each joint over its
        own inputs (25 each).
    centers: centres of the sets, (sets,) for all inputs, or a list of such lists, one an input.
    width: σ of exp(-((x - c)/σ)²/2), 1e-9 to 1e9: a scalar, one a set, or (with ``centers`` an
        input) one an input or one list an input. The paper's exp(-(x - c)²) is σ = 1/√2.
    normalized: fuzzy basis functions (4), or raw firing strengths.
    inputs: "error" (e, de), the paper's; "state" (q, dq); "reference" (q_d, dq_d); "trajectory"
        (q_d, dq_d, ddq_d); one signal, a list of signals, or a dict signal -> scale that
        multiplies it. ``e`` of a continuous joint lies in [-π, π); ``q`` and ``q_d`` are as they
        are measured and given, turns included.
    joints: of the arm; by default those that the lists of ``centers`` are for, or any. A controller
        builds the rules for its own arm.

    Raises
    ------
    ValueError, TypeError
        Naming the parameter. At most 64 inputs, 512 sets, 1 048 576 rules: nothing is allocated
        before that is known. A "grid" may have any number of rules: it is refused only where they
        would be written out, so not by a `FuzzyCompensator` with a ``dictionary``.
    """

    def __new__(
        cls,
        form: Literal["grid", "shared", "concat", "per_joint"],
        centers: ArrayLike,
        width: ArrayLike,
        normalized: bool = True,
        inputs: _Inputs = "error",
        joints: int | None = None,
    ) -> FuzzyBasis: ...
    @property
    def form(self) -> Literal["grid", "shared", "concat", "per_joint"]:
        """How the sets combine to rules."""
    @property
    def centers(self) -> list[Any]:
        """Centres of the sets: a list for all inputs, or a list of lists, one an input."""
    @property
    def width(self) -> Any:
        """σ of the sets, as it was given."""
    @property
    def normalized(self) -> bool:
        """Whether ξ is normalised (4)."""
    @property
    def inputs(self) -> list[tuple[_Signal, float]]:
        """The signals with their scales, in order."""
    @property
    def joints(self) -> int | None:
        """Joints of the arm that it is for; None: any."""
    @property
    def rules(self) -> int:
        """Number of rules for the arm's inputs (per_joint: of all joints together)."""
    def evaluate(self, x: ArrayLike) -> _Array:
        """ξ at every row of ``x``: (T, inputs) -> (T, rules).

        The number of inputs follows from ``x``; per_joint takes input k for joint k mod n. Raises
        ValueError for a wrong shape, NaN, infinity, too many rules, or more than 2²⁸ entries.
        """

@final
class FuzzyApproximator:
    """A fuzzy system as a function approximator, y(x) = W ξ(x) (3), (5), fitted by `fit`.

    Call it with ``x`` (T, inputs): it gives y at every row, (T, outputs).
    """

    @staticmethod
    def fit(
        basis: FuzzyBasis, x: ArrayLike, y: ArrayLike, ridge: float = 1e-10
    ) -> FuzzyApproximator:
        """Fit W to T samples: min Σ |W ξ(xₖ) - yₖ|² + ridge T |W|².

        ``x`` (T, inputs), ``y`` (T, outputs), ``ridge`` >= 0; at most 4096 rules. Raises ValueError
        naming the argument; ``ridge`` if it is too small for the samples to determine W.
        """
    @staticmethod
    def from_weights(basis: FuzzyBasis, inputs: int, weights: ArrayLike) -> FuzzyApproximator:
        """Use known weights (outputs, rules) over this many inputs.

        Raises ValueError for a wrong shape, or weights that are not finite.
        """
    @property
    def weights(self) -> _Array:
        """W, (outputs, rules)."""
    @property
    def rules(self) -> int:
        """Number of rules."""
    def __call__(self, x: ArrayLike) -> _Array: ...
    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]: ...

@final
class FuzzyCompensator(Settings):
    """The fuzzy compensator ρ̂ = W ξ (12)-(13) with the adaptive law (18); P comes from (19).

    ``dW/dt = gain BᵀP x ξᵀ`` with ``gain = Γ⁻¹``: the paper's Γ = diag(7, 7) is a gain of 1/7.

    Parameters
    ----------
    basis: ξ and the signals it sees.
    q: Q of (19): a scalar for all entries, its diagonal (2n,) for [e₁ … eₙ, de₁ … deₙ], or a
        diagonal matrix (2n, 2n); >= 0. The paper's is 10.
    gain: Γ⁻¹, scalar or (n,), > 0.
    gamma: attenuation level γ of (19), > 0 or infinity; the paper's is 1.
    leak_rate: σ-modification as a rate [1/s]: the weights return to their prior like
        exp(-leak_rate t).
    error_modification: e-modification κ: a leak at the rate gain κ |BᵀPx|.
    projection_radius: radius of the ball that |W - W₀| stays in, the paper's Ω_f; None or inf for
        none.
    dead_zone: d₀: the gain is scaled by max(0, 1 - d₀/|BᵀPx|).
    normalization: ν: the gain is divided by 1 + ν |ξ|².
    dictionary: None: every rule has its weight. A number, 1 to 4096: the kernel form of a "grid" of
        any number of rules. At most so many states are remembered, and W = Σ cₖ ξ(xₖ)ᵀ is made of
        them. It is the same to rounding until a state is merged or dropped. The `dictionary` of a
        `ComputedTorque` counts both, and bounds what they lost. 256 is a good number; memory grows
        with its square. |ξ|² is a product over the inputs: over many inputs, sets that overlap
        widely learn next to nothing. Make them narrow (σ of 0.3 spacings) and the gain large.
    merge_tolerance: a new state is merged into its nearest where that loses less than this part of
        it, 0 <= part < 1 (0 merges nothing); 0.05 with a dictionary, refused without.

    Raises
    ------
    ValueError, TypeError
        Naming the parameter. Whether (19) has a solution shows when a `ComputedTorque` with its
        gains is built: it raises `NoStabilizingSolution`.
    """

    def __new__(
        cls,
        basis: FuzzyBasis,
        q: ArrayLike = 10.0,
        gain: ArrayLike = 1.0,
        gamma: float = 1.0,
        leak_rate: float = 0.0,
        error_modification: float = 0.0,
        projection_radius: float | None = None,
        dead_zone: float = 0.0,
        normalization: float = 0.0,
        dictionary: int | None = None,
        merge_tolerance: float = 0.05,
    ) -> FuzzyCompensator: ...
    @property
    def basis(self) -> FuzzyBasis:
        """The basis ξ."""
    @property
    def q(self) -> _Array:
        """Diagonal of Q, (2n,): [e₁ … eₙ, de₁ … deₙ]."""
    @property
    def gain(self) -> _Array:
        """Γ⁻¹ of each joint, (n,)."""
    @property
    def gamma(self) -> float:
        """γ of (19)."""
    @property
    def dictionary(self) -> int | None:
        """States of the kernel form at the most; None without a dictionary."""
    @property
    def merge_tolerance(self) -> float | None:
        """The part of a state that a merge may lose; None without a dictionary."""

@disjoint_base
class Controller:
    """A controller with a law, and all that it remembers. `laws` makes them by name.

    It remembers what it learnt, its last torque, the number of its steps, and the period that is
    going on. Pickled or saved and restored, its next torques are the same to the bit. What
    remembers is equal to itself alone; ``copy.replace(controller, delay=1)`` is another, before its
    first step.

    Parameters
    ----------
    arm: what the controller believes of the arm, with n joints.
    law: a dict of its name, ``{"law": "super_twisting", ...}``, and its parameters, as the
        functions of `laws` make it and a scenario file has it; or a controller of your own: an
        object with a method ``step(q, dq, q_d, dq_d, ddq_d, dt) -> tau``.
    effort_limit: largest torque of each joint [N·m], scalar or (n,), > 0; None or inf for none.
    effort_rate_limit: largest change of each torque [N·m/s], likewise; for `step` and sampled
        simulations only. It counts from the torque commanded last.
    last_tau: the torque that is on the robot when the controller takes over [N·m], scalar or (n,),
        at most 1e10. None: what holds ``arm`` at rest there.
    hand_over: rate a [1/s] at which the reference is taken over from where the arm is:
        ``q_d' = q_d + (δ + (δ̇ + aδ)t) exp(-at)``, δ the error at the first sample. None: at once.
    velocity_filter: cut-off [Hz] of a velocity that is made of positions, by the difference of the
        error through a first-order filter; the measured one is not used then. None: it is.
    bumpless: rate [1/s] at which the torque goes from ``last_tau`` to the law's. None: at once.
    delay: samples, 0 to 4, between a torque and the period in which it acts.
    control_period: the period of the loop [s], for laws whose gains or conditions depend on it; a
        law that it does not suit is refused. None: not known.

    Raises
    ------
    ValueError, TypeError
        Naming the parameter, or the condition of the law that does not hold.
    """

    def __new__(
        cls,
        arm: Arm,
        law: Mapping[str, Any] | _Stepping,
        effort_limit: ArrayLike | None = None,
        effort_rate_limit: ArrayLike | None = None,
        last_tau: ArrayLike | None = None,
        hand_over: float | None = None,
        velocity_filter: float | None = None,
        bumpless: float | None = None,
        delay: int | None = None,
        control_period: float | None = None,
    ) -> Self: ...
    @property
    def law(self) -> Any:
        """The law: a dict of its name and parameters, or the object that was given."""
    @property
    def delay(self) -> int:
        """Samples between a torque and the period in which it acts."""
    def start_hand_over(self) -> None:
        """Hand over anew at the next sample, to another reference."""
    def step(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        q_d: ArrayLike,
        dq_d: ArrayLike,
        ddq_d: ArrayLike,
        dt: float,
        applied: ArrayLike | None = None,
        elapsed: float | None = None,
    ) -> _Array:
        """One sample: the torque [N·m], (n,), to hold for ``dt`` [s]; adapts the weights meanwhile.

        ``q``, ``q_d`` [rad]: (n,), at most 1e5, of a joint that has turned farther without whole
        turns; ``dq``, ``dq_d`` [rad/s], ``ddq_d`` [rad/s²]: (n,), at most 1e10. ``dt`` is 1e-9 to
        1 s. The torque is finite and inside the limits.

        A step first ends the period of the one before, and learns from it, then decides.
        ``applied`` [N·m], (n,), finite: the torque that acted in that period, where the drive
        let through another one than `step` gave, ``applied=np.clip(tau, -drive, drive)``. Nothing
        is learnt from a period in which it differs from what the law asked for, by whatever
        little: what a sensor measured is not wanted here. None: what `step` gave. Before the first
        step it says nothing. ``elapsed`` [s]: the time since the last step, as it was measured,
        where the loop jitters; None: the ``dt`` of that step.

        Raises ValueError or TypeError naming what does not fit; nothing has changed then, bit for
        bit. For ``tau``, a torque that would be infinite, the period before has ended.
        """
    def reset(self, last_tau: ArrayLike | None = None) -> None:
        """Forget everything: weights, prior, last torque, count of steps.

        The tracker is then as a new one, to the bit, and not frozen. ``last_tau``: the torque that
        is on the robot now [N·m], scalar or (n,); None: as it was built. A controller of your own
        is reset by its method ``reset()``; TypeError if it has none.
        """
    @property
    def tau_model(self) -> _Array | None:
        """M₀v + H₀ of the latest step [N·m], (n,); None before it, and after a load."""
    @property
    def tau_compensation(self) -> _Array | None:
        """-M₀ρ̂ of the latest step [N·m], (n,); None before it, and after a load."""
    @property
    def rho_hat(self) -> _Array | None:
        """ρ̂ of the latest step [rad/s²], (n,); None before it, and after a load."""
    @property
    def limited(self) -> bool:
        """Whether a limit cut the latest torque; nothing is learnt from its period then.

        False before a step, and after a load.
        """

    @property
    def steps(self) -> int:
        """Number of samples accepted."""
    @property
    def arm(self) -> Arm:
        """The nominal arm."""
    def freeze(self, applied: ArrayLike | None = None) -> None:
        """Stop adapting; the weights stay in use.

        The latest period ends, and is still learnt from: ``applied`` [N·m], (n,), is the torque
        that acted in it, as in `step`; None: what `step` gave, or a guard sent. Raises TypeError
        without a compensator.
        """

    def unfreeze(self) -> None:
        """Adapt again. Raises TypeError without a compensator."""
    @property
    def learns(self) -> bool:
        """Whether it learns something that stays right when learning stops; an observer does
        not.
        """
    @property
    def frozen(self) -> bool:
        """Whether adaptation is stopped."""
    def save(self, path: str | PathLike[str]) -> None:
        """Write what the controller remembers (weights, last torque, latest period) to a file.

        The file is replaced as a whole; a pipe or device is written to. Raises OSError if that
        fails; what was there stays then. Other threads may use the controller meanwhile.
        """
    def load(self, path: str | PathLike[str], other: bool = False) -> None:
        """Read what `save` wrote; the next torques are then the same to the bit.

        Raises ValueError for a damaged file, or one of a controller with another nominal arm, other
        gains, another compensator or other sets, which it names, and OSError if the file cannot be
        read; nothing has changed then. ``other=True`` takes the state of another controller of the
        same size all the same: you know that its weights are right here. A file of version 1 does
        not say whose it is, and is taken with a UserWarning.
        """
    def __getstate__(self) -> bytes: ...
    def __setstate__(self, bytes: bytes) -> None: ...
    def __replace__(self, /, **changes: Any) -> Self: ...
    def __reduce__(self) -> tuple[type[Self], tuple[Any, ...], bytes]: ...

@final
class ComputedTorque(Controller):
    """Computed torque for the nominal arm with a compensator (7), (11), (12), and its state.

    ``tau = M₀ (v - ρ̂) + H₀`` with ``v = ddq_d - K_v de - K_p e``, ``e = q - q_d``. Where a joint of
    ``arm`` is continuous, e is taken around the circle, -π <= e < π.

    The object remembers its weights, its last torque, the number of its steps, and the period that
    is going on. Pickled or saved and restored, its next torques are the same to the bit. What
    remembers is equal to itself alone; ``copy.replace(tracker, kp=9.0)`` is another, before its
    first step.

    Parameters
    ----------
    arm: what the controller believes of the arm, with n joints.
    kp: K_p [1/s²], scalar or (n,), > 0.
    kv: K_v [1/s], scalar or (n,), > 0.
    compensator: produces ρ̂; None for plain computed torque.
    effort_limit: largest torque of each joint [N·m], scalar or (n,), > 0; None or inf for none.
    effort_rate_limit: largest change of each torque [N·m/s], likewise; for `step` and sampled
        simulations only. It counts from the torque commanded last.
    last_tau: the torque that is on the robot when the controller takes over [N·m], scalar or (n,),
        at most 1e10: what the rate limit of the first sample counts from. None: what holds ``arm``
        at rest there.
    hand_over, velocity_filter, bumpless, delay: what stands before the law; see `Controller`.

    Raises
    ------
    NoStabilizingSolution
        If (19) has no solution for these gains and the compensator's Q and γ.
    ValueError, TypeError
        Naming the parameter.
    """

    def __new__(
        cls,
        arm: Arm,
        kp: ArrayLike,
        kv: ArrayLike,
        compensator: FuzzyCompensator | None = None,
        effort_limit: ArrayLike | None = None,
        effort_rate_limit: ArrayLike | None = None,
        last_tau: ArrayLike | None = None,
        hand_over: float | None = None,
        velocity_filter: float | None = None,
        bumpless: float | None = None,
        delay: int | None = None,
    ) -> ComputedTorque: ...
    @property
    def kp(self) -> _Array:
        """K_p [1/s²], (n,)."""
    @property
    def kv(self) -> _Array:
        """K_v [1/s], (n,)."""
    @property
    def compensator(self) -> FuzzyCompensator | None:
        """The compensator, or None."""
    @property
    def P(self) -> _Array | None:
        """P of (19), (2n, 2n); None without a compensator."""
    @property
    def weights(self) -> _Array | None:
        """W, (n, rules) (per_joint: the rules of one joint), a copy; None without a compensator.

        What the latest period taught is in it, as if the torque of `step` acted; the next step may
        still tell another one. Assign to set it: adaptation goes on from there, without a prior W₀.
        Raises ValueError for a wrong shape, entries that are not finite or beyond 1e150, or weights
        beyond the ``projection_radius``; TypeError without a compensator. With a ``dictionary``
        there is no such matrix: reading and setting raise TypeError.
        """
    @weights.setter
    def weights(self, weights: ArrayLike) -> None: ...
    @property
    def dictionary(self) -> _Dictionary | None:
        """The kernel form in figures; None for a compensator without a dictionary.

        ``atoms`` of ``capacity`` states are in it. ``merged`` terms went into a state that was
        there; ``dropped`` states made room when it was full. ``error_bound`` (n,) bounds what all
        that lost, |W - W_exact| of each joint, and fades as W does. The error of ρ̂ [rad/s²] is at
        most |ξ| times that, with |ξ| <= 1 for a normalised basis.
        """
    def warm_start(self, weights: ArrayLike) -> None:
        """Set W, and make it the W₀ that leak, e-modification and projection pull to."""

@final
class Guard:
    """A guard around a tracker: an answer to every sample, good, bad or missing.

    The torque that it gives can be sent, whatever came: it is finite, at most ``effort_limit``, and
    changes by at most ``effort_rate_limit`` from the one before. A sample that cannot be true is
    not used, and nothing is learnt from it. The last torque is then held, decays to the one that
    carries the arm, and after ``hold`` + ``decay`` periods the guard stops: it brakes the arm, and
    stays stopped until `rearm`. It has no clock: tell it the time since the last call.

    Parameters
    ----------
    tracker: the controller; the guard steps it.
    control_period: nominal period of the loop [s], 1e-9 to 1.
    position_limits: (n, 2) [rad]; outside, the guard stops. None: the nominal arm's.
    velocity_limit: [rad/s], scalar or (n,). Faster, the guard stops; a position that moved farther
        than that since the last sample is not used. None: the nominal arm's.
    effort_limit: [N·m], scalar or (n,). None: the nominal arm's.
    effort_rate_limit: [N·m/s], scalar or (n,); None for no limit.
    power_limit: of τ·q̇ that a joint gives to the arm [W], scalar or (n,); None for no limit.
    envelope: of the tracking error [rad], scalar or (n,); outside, the guard stops. None: no limit.
    slack: what a position may change beyond its speed limit [rad], such as an encoder's step.
    hold, decay: periods without a good sample in which the torque is held, and in which it decays.
    bandwidth: p of the brake [rad/s], scalar or (n,), at most 0.25 / control_period: the nominal
        arm comes to rest with a double pole at -p. None: min(0.1 / control_period, 20).
    deceleration: of the brake [rad/s²], scalar or (n,); None: 10.
    last_tau: the torque that is on the robot at take-over [N·m], scalar or (n,). None: what the
        tracker commanded last, or was made with; else the one that carries the arm at the first
        good sample, and zero until then.

    Raises
    ------
    ValueError, TypeError
        Naming the parameter.
    """

    def __new__(
        cls,
        tracker: ComputedTorque,
        control_period: float,
        *,
        position_limits: ArrayLike | None = None,
        velocity_limit: ArrayLike | None = None,
        effort_limit: ArrayLike | None = None,
        effort_rate_limit: ArrayLike | None = None,
        power_limit: ArrayLike | None = None,
        envelope: ArrayLike | None = None,
        slack: ArrayLike | None = None,
        hold: int | None = None,
        decay: int | None = None,
        bandwidth: ArrayLike | None = None,
        deceleration: ArrayLike | None = None,
        last_tau: ArrayLike | None = None,
    ) -> Self: ...
    def step(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        q_d: ArrayLike,
        dq_d: ArrayLike,
        ddq_d: ArrayLike,
        elapsed: float | None = None,
        applied: ArrayLike | None = None,
    ) -> _Array:
        """One sample: the torque to send [N·m], (n,).

        ``q``, ``q_d`` [rad], ``dq``, ``dq_d`` [rad/s], ``ddq_d`` [rad/s²]: (n,), whatever is in
        them. ``elapsed``: the time since the last call [s], as it was measured; None: a period.
        ``applied``: the torque that the drive let through since then [N·m], (n,), if it says so;
        where it is not finite nothing is learnt from that period, and ``not_finite`` is counted.
        Raises ValueError or TypeError for what is no such array alone; nothing has changed then.
        """

    def missed(self) -> _Array:
        """A period in which no sample came: the torque to send [N·m], (n,)."""

    def stop(self) -> None:
        """Stop: from the next sample on the arm is braked, until `rearm`."""

    def rearm(self) -> None:
        """Let a guard that has stopped run again from the next sample on.

        That sample may be anywhere; the set-point should be near it.
        """

    def reset(self, last_tau: ArrayLike | None = None) -> None:
        """Forget everything, the tracker's weights too: both are then as new ones, to the bit.

        ``last_tau``: the torque that is on the robot now [N·m], scalar or (n,); None: as it was
        built.
        """

    @property
    def stopped(self) -> str | None:
        """Why the guard has stopped, such as "position of joint 2"; None while it runs."""

    @property
    def latest(self) -> list[str]:
        """What the guard did in the latest call, by name; empty if there was nothing to do."""

    @property
    def events(self) -> dict[str, int]:
        """In how many calls each event happened, by name; of ``missed``, how many periods.

        Not used: ``not_finite``, ``jump``, ``early``, ``missed``, ``clock``. Used: ``late``. The
        ``controller`` refused. Cut: ``effort``, ``effort_rate``, ``power``. Stopped: ``position``,
        ``velocity``, ``envelope``, ``stop``.
        """

    @property
    def lost(self) -> int:
        """Periods in a row without a good sample."""

    @property
    def last_tau(self) -> _Array | None:
        """The torque sent last [N·m], (n,); None before the first."""

    @property
    def tracker(self) -> ComputedTorque:
        """The controller that it guards."""

    @property
    def control_period(self) -> float:
        """Nominal period of the loop [s]."""

@final
class Plant(Settings):
    """What is really there: ``M(q) ddq + H(q, dq) + s(q, dq) + τ_d = τ``, τ limited by actuators.

    That is (6) with the `Serial.stops` of the arm, if it has any. Two are equal when arm, limits
    and disturbance are; a callable is as Python says, mostly to itself alone.

    Parameters
    ----------
    arm: the true arm.
    disturbance: τ_d [N·m], which opposes τ: `Pulses`, `Noise`, `Wrench`; `Sines`, `Quintic`,
        `Table` or `Waypoints` (their position is the torque); a callable ``(q, dq, t) -> (n,)``; or
        a list of these, which add up; None for none.
    effort_limit: what each actuator can give [N·m], scalar or (n,), > 0; None or inf for no limit.
    changes: pairs (time [s], arm), times increasing: from then on another arm in the place of the
        one before, such as one with a payload that is picked up, or with other friction. Position
        and velocity go on. For sampled simulations only.
    """

    def __new__(
        cls,
        arm: Arm,
        disturbance: _Push | list[_Push] | None = None,
        effort_limit: ArrayLike | None = None,
        changes: Sequence[tuple[float, Arm]] | None = None,
    ) -> Plant: ...
    @property
    def arm(self) -> Arm:
        """The true arm."""
    @property
    def disturbance(self) -> _Push | list[_Push] | None:
        """τ_d as it was given."""
    @property
    def changes(self) -> tuple[tuple[float, Arm], ...] | None:
        """Pairs (time [s], arm) of what changes, or None."""
    @property
    def effort_limit(self) -> _Array:
        """Largest torque of each actuator [N·m], (n,); inf without a limit."""
    def step(
        self, q: ArrayLike, dq: ArrayLike, tau: ArrayLike, t: float, dt: float
    ) -> tuple[_Array, _Array]:
        """Move on by ``dt`` [s] from time ``t`` [s] under the held torque ``tau`` [N·m].

        As a sampled simulation does: one step of RK4, with friction and stops solved for where RK4
        would be unstable. Returns q [rad] and dq [rad/s] at t + dt.
        Raises ValueError naming what is not finite, and whatever a callable disturbance raises.
        """

@final
class Effects(Settings):
    """Sensors, timing and actuators of a real machine, seeded: all of them are off by default.

    For `simulate` with a ``control_period``. What was measured and sent is recorded:
    ``run.q_measured``, ``run.dq_measured``, ``run.tau_commanded``, ``run.q_motor``,
    ``run.tau_cogging``, ``run.sample_age``. The same
    seed gives the same bits.

    Parameters
    ----------
    encoder_bits: bits of each encoder in a turn of its joint, scalar or (n,); None: exact.
    noise: standard deviation of positions, before the encoder [rad], scalar or (n,).
    velocity: where velocities come from: "measured" (the joint's own, with ``velocity_noise``
        [rad/s]), "difference" of positions through a first-order filter of ``velocity_cutoff``
        [Hz], a "tracking" differentiator of ``velocity_bandwidth`` [rad/s], or a "kalman" filter in
        its steady state that counts with accelerations of ``velocity_acceleration`` [rad/s²].
    velocity_noise, velocity_cutoff, velocity_bandwidth, velocity_acceleration: as above.
    delay: samples, 0 to 4, between a torque and the period in which it acts.
    jitter: by how much a period may differ from its length, as a share of it, 0 to 0.9.
    drop: probability that a sample is lost, 0 to 0.9; the torque before it is held on.
    effort_rate_limit: largest change of each torque that a drive follows [N·m/s], scalar or (n,).
    gain: what arrives of a torque, as a share, scalar or (n,).
    lag: time constant of each drive [s], scalar or (n,).
    cogging: largest cogging torque [N·m], scalar or (n,), ``cogging_per_turn`` times in a turn.
    cogging_per_turn: as above. With joints that give, cogging acts on the link.
    joint_stiffness: of gears that give [N·m/rad], scalar or (n,); None: links follow their motors.
        Needs a ``rotor_inertia``. The plant's own rotors are to be left out: ``with_armature(0)``.
    joint_damping: of the gears [N·m·s/rad], scalar or (n,).
    rotor_inertia: of each motor, on the link's side of its gear [kg·m²], scalar or (n,).
    backlash: play of the gears from end to end [rad], scalar or (n,).
    encoder_side: "motor" (as in most robots) or "link", where the encoders are.
    seed: of all that is random, a whole number >= 0.
    """

    def __new__(
        cls,
        encoder_bits: ArrayLike | None = None,
        noise: ArrayLike | None = None,
        velocity: Literal["measured", "difference", "tracking", "kalman"] | None = None,
        velocity_noise: ArrayLike | None = None,
        velocity_cutoff: float | None = None,
        velocity_bandwidth: float | None = None,
        velocity_acceleration: float | None = None,
        delay: int | None = None,
        jitter: float | None = None,
        drop: float | None = None,
        effort_rate_limit: ArrayLike | None = None,
        gain: ArrayLike | None = None,
        lag: ArrayLike | None = None,
        cogging: ArrayLike | None = None,
        cogging_per_turn: float | None = None,
        joint_stiffness: ArrayLike | None = None,
        joint_damping: ArrayLike | None = None,
        rotor_inertia: ArrayLike | None = None,
        backlash: ArrayLike | None = None,
        encoder_side: Literal["motor", "link"] | None = None,
        seed: int | None = None,
    ) -> Effects: ...
    @property
    def delay(self) -> int:
        """Samples between a torque and the period in which it acts."""
    @property
    def seed(self) -> int:
        """Seed of all that is random."""

@disjoint_base
class Curve(Settings):
    """A desired motion, or a disturbance: `Sines`, `Quintic`, `Table` or `Waypoints`.

    Call it with ``t`` [s]: it gives (q_d, dq_d, ddq_d), each (n,). With times of shape (T,) each is
    (T, n).
    """

    def __call__(self, t: ArrayLike) -> _Triple: ...

@final
class Sines(Curve):
    """``offset + Σ sin_k sin(ω_k t) + cos_k cos(ω_k t)`` with its exact derivatives.

    A reference in rad, or a disturbance in N·m. Call it with ``t`` [s], (T,) or a scalar: it gives
    (q_d, dq_d, ddq_d), each (T, n) or (n,).

    Parameters
    ----------
    frequency: ω [rad/s], (K,) or a scalar.
    sin, cos: amplitudes, (K, n), or scalar or (n,) if ``frequency`` is a scalar; 0 by default.
    offset: scalar or (n,); 0 by default.
    start_time: when it starts [s], with t - start_time for t; None: it is there at all times.
        Before, a reference stands still where it will begin, and a disturbance is zero.
    """

    def __new__(
        cls,
        frequency: ArrayLike,
        sin: ArrayLike | None = None,
        cos: ArrayLike | None = None,
        offset: ArrayLike | None = None,
        start_time: float | None = None,
    ) -> Sines: ...

@final
class Quintic(Curve):
    """From ``start`` to ``goal`` [rad] along the quintic of least jerk; at rest before and after.

    ``start``, ``goal``: scalar or (n,). ``duration`` [s] > 0, ``start_time`` [s], 0 by default.
    Call it with ``t`` [s], (T,) or a scalar: it gives (q_d, dq_d, ddq_d), each (T, n) or (n,).
    """

    def __new__(
        cls,
        start: ArrayLike,
        goal: ArrayLike,
        duration: float,
        start_time: float | None = None,
    ) -> Quintic: ...

@final
class Table(Curve):
    """A sampled motion, interpolated with continuous acceleration; at rest before and after.

    Call it with ``t`` [s], (T,) or a scalar: it gives (q_d, dq_d, ddq_d), each (T, n) or (n,).

    Parameters
    ----------
    t: times [s], (T,), increasing, at least two.
    q: positions [rad], (T, n).
    dq, ddq: velocities [rad/s] and accelerations [rad/s²], (T, n); both, or neither: they then come
        from ``q``.
    start_time: when it is at the first sample [s]; None: at t[0].
    """

    def __new__(
        cls,
        t: ArrayLike,
        q: ArrayLike,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        start_time: float | None = None,
    ) -> Table: ...
    @staticmethod
    def from_csv(
        path: str | PathLike[str], desired: bool = False, start_time: float | None = None
    ) -> Table:
        """Read a motion from a CSV file, such as `Run.to_csv` writes or a robot recorded.

        Its first line names the columns: t [s], q_1, q_2 … [rad] and, where there are both,
        dq_1 … [rad/s] and ddq_1 … [rad/s²]; ``desired`` reads q_d_1, dq_d_1, ddq_d_1 instead. Other
        columns are passed over. Raises OSError, and ValueError that names the line or the column.
        """

@final
class Waypoints(Curve):
    """From pose to pose as fast as velocity, acceleration and jerk may be, with pauses.

    The joints start and arrive together, on a straight line from pose to pose, and come to rest at
    every pose, for no longer than an instant without a pause; before and after they stand still. At
    every moment of a move one joint is at one of its limits. Velocity and acceleration are
    continuous. Call it with ``t`` [s], (T,) or a scalar: it gives (q_d, dq_d, ddq_d), each
    (T, n) or (n,).

    Parameters
    ----------
    poses: positions [rad], (K, n), at least two.
    velocity, acceleration, jerk: limits [rad/s], [rad/s²], [rad/s³], scalar or (n,), > 0.
    pause: how long it rests at the poses between the first and the last [s], scalar or (K - 2,).
    start_time: when it leaves the first pose [s].
    """

    def __new__(
        cls,
        poses: ArrayLike,
        velocity: ArrayLike,
        acceleration: ArrayLike,
        jerk: ArrayLike,
        pause: ArrayLike = 0.0,
        start_time: float = 0.0,
    ) -> Waypoints: ...
    @property
    def duration(self) -> float:
        """How long it takes from the first pose to the last, with its pauses [s]."""

    @property
    def arrivals(self) -> _Array:
        """When it arrives at each pose [s], (K,); at the first one that is ``start_time``."""

@disjoint_base
class Disturbance(Settings):
    """A disturbance that is no curve: `Pulses`, `Noise` or `Wrench`."""

@final
class Pulses(Disturbance):
    """Steps and impulses: each torque from its time on, for as long as it lasts. A disturbance.

    Parameters
    ----------
    time: when they begin [s], (K,) or a scalar.
    torque: heights [N·m], which oppose τ: (K, n), or scalar or (n,) if ``time`` is a scalar.
    duration: how long they last [s], (K,) or a scalar, > 0; inf or None for steps.
    shape: "rectangle", or "half_sine" for one that rises and falls as sin(π s).
    """

    def __new__(
        cls,
        time: ArrayLike,
        torque: ArrayLike,
        duration: ArrayLike | None = None,
        shape: Literal["rectangle", "half_sine"] = "rectangle",
    ) -> Pulses: ...

@final
class Noise(Disturbance):
    """Coloured noise, a disturbance: white noise through a first-order low-pass.

    It is Gaussian and stationary, with standard deviation ``deviation`` and correlation
    ``exp(-2 π cutoff |Δt|)``; the joints are independent. It is a function of time: the same seed
    gives the same bits in every run, with any step, on every machine.

    Parameters
    ----------
    deviation: standard deviation [N·m], scalar or (n,), >= 0.
    cutoff: cut-off of the filter [Hz], > 0.
    seed: a whole number from 0 to 2^63 - 1.
    """

    def __new__(cls, deviation: ArrayLike, cutoff: float, seed: int = 0) -> Noise: ...

@final
class Wrench(Disturbance):
    """A force and a moment on the tip, in the axes of the base. A disturbance of ``-Jᵀ (F, m)``.

    It pushes the arm where it points: ``M ddq + H = τ + Jᵀ (F, m)``. The tip is that of
    ``arm.pose(q)``, of the arm that is really there.

    Parameters
    ----------
    force: F [N], (3,); none by default.
    moment: m [N·m], (3,); none by default.
    curve: both over time in place of constants: a curve, `Pulses` or `Noise` of six columns, force
        before moment.
    """

    def __new__(
        cls,
        force: ArrayLike | None = None,
        moment: ArrayLike | None = None,
        curve: Curve | Pulses | Noise | None = None,
    ) -> Wrench: ...

_Push = Curve | Disturbance | _DisturbanceCallable

@final
class RiccatiSolution:
    """P of a Riccati equation, certified: finite, symmetric, accurate, stabilising.

    P is positive semidefinite where Q is.
    """

    @property
    def P(self) -> _Array:
        """P, (S, S), symmetric."""
    @property
    def residual(self) -> float:
        """‖left side‖ / (2‖A‖‖P‖ + ‖G‖‖P‖² + ‖Q‖), Frobenius norms, at most 1e-12.

        G is γ⁻²BB' or BR⁻¹B'.
        """
    @property
    def min_eigenvalue(self) -> float:
        """Smallest eigenvalue of P; negative only where Q is indefinite, or by rounding."""
    @property
    def max_real(self) -> float:
        """Largest real part of the closed-loop matrix (A + γ⁻²BB'P, or A - BR⁻¹B'P) [1/s], < 0."""
    @property
    def gamma(self) -> float | None:
        """γ that was asked for; None for `care`."""
    @property
    def gamma_opt(self) -> float | None:
        """The smallest γ with a solution (γ must be larger), found when read; None for `care`."""
    @property
    def max_scale(self) -> float | None:
        """Q times anything smaller than this has a solution at this γ; None for `care`."""
    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]: ...

def bounded_real_riccati(
    A: ArrayLike, B: ArrayLike, Q: ArrayLike, gamma: float = 1.0
) -> RiccatiSolution:
    """Solve ``A'P + PA + γ⁻² P B B' P + Q = 0`` (19) for the stabilising P, with a certificate.

    Parameters
    ----------
    A: (S, S), Hurwitz, S up to 512.
    B: (S, m), m up to S.
    Q: (S, S), symmetric positive semidefinite.
    gamma: γ > 0, or infinity: the Lyapunov equation.

    Raises
    ------
    NoStabilizingSolution
        If γ is not larger than γ_opt = ‖Q^½ (sI - A)⁻¹ B‖∞.
    ValueError, TypeError
        Naming the argument.
    """

def care(A: ArrayLike, B: ArrayLike, Q: ArrayLike, R: ArrayLike) -> RiccatiSolution:
    """Solve ``A'P + PA - P B R⁻¹ B' P + Q = 0`` for the stabilising P, with a certificate.

    Parameters
    ----------
    A: (S, S), S up to 512.
    B: (S, m), m up to S, with (A, B) stabilisable.
    Q: (S, S), symmetric. It may be indefinite, where a stabilising solution exists.
    R: (m, m), symmetric positive definite.

    Raises
    ------
    ValueError, TypeError
        Naming the argument: B if no input stabilises A; Q if the Hamiltonian matrix
        ``[A, -BR⁻¹B'; -Q, -A']`` has an eigenvalue on the imaginary axis, with its frequency.
    """

def simulate(
    plant: Plant,
    tracker: Controller | Guard,
    reference: Curve | _ReferenceCallable,
    duration: float,
    dt: float,
    method: Literal["rk4", "dp54"],
    control_period: float | None,
    q0: ArrayLike | None,
    dq0: ArrayLike | None,
    rtol: float,
    atol: float,
    record_every: int,
    record: str,
    effects: Effects | None,
    progress: Callable[[float], object] | None,
) -> tuple[dict[str, Any], BaseException | None]:
    """Run `steadyarm.simulate`; the tracker given stays as it is.

    Returns the record as a dict, and what a callable raised. The dict has the state that the run
    started in, and the parts of a tracker in the state that it ended in.
    """

def simulate_many(
    count: int,
    plants: list[Plant],
    trackers: list[Controller | Guard],
    references: list[Any],
    effects: list[Effects | None],
    q0: list[Any],
    dq0: list[Any],
    duration: float,
    dt: float,
    method: str,
    control_period: float | None,
    rtol: float,
    atol: float,
    record_every: int,
    window: tuple[float, float],
    band: float,
    threads: int,
    progress: Callable[[int], object],
) -> tuple[dict[str, _Array], list[tuple[str, float, str] | None]] | None:
    """Run `steadyarm.simulate_many` where only figures are wanted, and nothing calls Python.

    Lists have one entry for all runs, or one a run. Returns the figures, (M, n) each, and the
    status of each run: its kind, when it ended, and the reason; None for a run that was not begun.
    Returns None where a run would call Python, or has a guard. ``progress`` is called with the
    number of runs that ended.
    """

def describe(controller: Controller) -> dict[str, _Array]:
    """Return a controller's gains and what it has learnt, at the end of the latest period: arrays
    by name.

    Of the recommended controller: ``bandwidth`` [rad/s], ``braking`` [rad/s²], ``cut_off`` [Hz],
    ``learning`` [Hz], ``acceleration_share``, ``quickness``, ``quickest`` [rad/s²], ``condition``,
    ``friction_widths`` [rad/s], ``of_links`` (how many of the parameters are those of links),
    ``weight`` [kg·m²], ``unit`` [N·m], ``parameters`` (m,), ``covariance`` (m, m) as a flat array,
    ``prior`` (m,). Empty for others.
    """

def paper_scenario(number: int, preset: str) -> str:
    """Return a simulation of the paper, "printed" or "claimed", as TOML."""

def canonical_scenario(text: str) -> str:
    """Return a scenario in TOML as TOML with every default written out: what it says, to the bit.

    Raises ValueError as `read_scenario`.
    """

def read_scenario(text: str) -> dict[str, Any]:
    """Read a scenario in TOML: objects by section, None for a section that it does not have.

    ``two_link`` (the arm that the controller believes in) and ``plant`` give a `TwoLink`,
    ``compensator`` with its ``compensator.basis`` a `FuzzyCompensator`; ``reference.sines``,
    ``reference.quintic``, ``reference.table`` or ``reference.waypoints`` that class under
    "reference", and ``transfer`` likewise; ``disturbance`` these and `Pulses`, `Noise`, `Wrench`,
    one or a list of them; ``effects`` an `Effects`; ``controller`` a dict of ``kp``, ``kv``,
    ``effort_limit``, ``effort_rate_limit``, and ``run`` one of arguments of `simulate`; ``title``,
    ``robot``, ``actual``, ``front``, ``metrics`` and ``controllers`` (laws by name) are as in the
    file, see `Scenario`. Keys are the arguments of the classes. Raises ValueError naming the path
    of what is unknown, of the wrong type or out of range:
    ``compensator.gain[1]: got -1, wants a number > 0``.
    """

def channels() -> list[tuple[str, str, bool, str]]:
    """Tell the signals of every record: name, unit, whether there is one a joint, what it is."""

def desired_motion(
    reference: Curve | _ReferenceCallable,
    arm: Arm,
    t: ArrayLike,
    q: ArrayLike,
    dq: ArrayLike,
) -> list[_Array]:
    """Return [q_d, dq_d, ddq_d, e, de] at each of these times, (T, n) each.

    e and de are those of a controller with this nominal arm that was at ``q``, ``dq``, (T, n) each.
    Raises what a callable raises, and ValueError where it returns what is not finite.
    """

def design(
    tracker: ComputedTorque,
    control_period: float,
    delay: int | None,
    velocity_filter: float | None,
    disturbance: ArrayLike | None,
    inertia_ratio: float,
    path: Curve | _ReferenceCallable | None,
    plant: Plant | None,
    duration: float | None,
) -> dict[str, Any]:
    """Run `steadyarm.design`: figures joint by joint, findings in words, and the verdict.

    ``delay``: None is what the tracker knows of. ``velocity_filter``: of the loop, where the
    tracker has none [Hz].
    """

def choices(
    tracker: Controller | Guard,
    plant: Plant,
    path: Curve | None,
    duration: float,
    q0: ArrayLike | None,
) -> list[str]:
    """Tell the choices of a simulation that do nothing, or ruin it, in words.

    ``tracker`` may be a guard. ``path`` is the reference, or what was recorded of it; None if it is
    not known. No callable of the plant is called.
    """

def metrics(
    t: ArrayLike, e: ArrayLike, tau: ArrayLike | None, window: tuple[float, float], band: float
) -> _MetricsRecord:
    """Run `steadyarm.Run.metrics`: the figures of every joint.

    Without ``tau``, the arrays of its figures are empty.
    """
