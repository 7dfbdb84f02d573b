"""What the record of a simulation says: its signals, how it ended, what certifies it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from . import _core
from ._documented import documented

CHANNELS = {name: (unit, per_joint, doc) for name, unit, per_joint, doc in _core.channels()}
"""The signals of every record: name to unit, whether there is one a joint, and what it is."""

MOTION = ("t", "q", "dq")
"""Arrays that every record has."""

DESIRED = ("q_d", "dq_d", "ddq_d", "e", "de")
"""Arrays that a record of the motion alone has when they are first asked for."""

TORQUES = ("tau", "tau_model", "tau_compensation", "rho", "rho_hat")
"""Arrays that a record of the motion alone has no rows of."""


@documented
@dataclass(frozen=True)
class Status:
    """Why a run ended, and when.

    A run that is "unresolved" reached its duration in steps that were too long for the motion, for
    a stop, or for friction: do not believe its numbers. The reason names ``dt``, what it was too
    long for, and an estimate of the error; take a smaller ``dt``, or ``method="dp54"``.
    """

    kind: Literal["finished", "unresolved", "diverged", "interrupted", "raised"]
    """How it ended; "raised", by an exception of a callable, in `simulate_many` alone."""
    t: float
    """When it ended [s]."""
    reason: str = ""
    """Why, in words; empty if it just finished."""

    @property
    def finished(self) -> bool:
        """Whether the run reached its duration, in steps that followed the motion."""
        return self.kind == "finished"

    def __str__(self) -> str:
        if self.finished:
            return "finished"
        if self.kind == "unresolved":
            return f"finished, but not resolved: {self.reason}"
        return f"{self.kind} at t = {self.t:.6g} s because {self.reason}"


@documented
@dataclass(frozen=True)
class Certificate:
    """The Lyapunov certificate: the dissipation identity, integrated beside the motion.

    For the adaptive law (18) with P from (19), ``V(T) - V(0) = supplied`` holds exactly, so
    ``residual`` (relative) shows whether this run was what the theory speaks of: about 1e-13 for
    RK4 at 1 ms, some 1e-5 where an arm runs into its stops; of order 1 if a sign were wrong, or
    where the error of a continuous joint passes half a turn, at which V jumps. It is of continuous
    time: a run with a ``control_period`` has none, and `design` tells its margin.
    """

    residual: float
    """V(T) - V(0) less ``supplied``, relative."""
    v_start: float
    """V(0)."""
    v_end: float
    """V(T)."""
    supplied: float
    """What the identity says that V changes by."""
    state_cost: float
    """∫ x'Qx dt, at most ``v_start + gamma² uncertainty``."""
    uncertainty: float
    """∫ |ρ|² dt."""


@documented
@dataclass(frozen=True)
class GuardReport:
    """What a `Guard` did in a run."""

    events: Mapping[str, int]
    """In how many periods of the run each event happened, by name; see `Guard.events`."""
    stopped: str | None
    """Why the guard had stopped at the end of the run, such as "position of joint 2"; or None."""


@documented
@dataclass(frozen=True)
class Channel:
    """A recorded signal: what a column of a `Run` holds.

    For a prismatic joint m and N stand for rad and N·m.
    """

    name: str
    """Its attribute of the run."""
    unit: str
    """Its unit; "1" for a number without one."""
    shape: tuple[int, ...]
    """Shape of a row: (n,), or () for one number."""
    doc: str
    """What it is."""

    @classmethod
    def _of(cls, declared: tuple[str, str, bool, str], joints: int) -> Channel:
        name, unit, per_joint, doc = declared
        return cls(name, unit, (joints,) if per_joint else (), doc)
