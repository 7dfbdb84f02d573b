"""Why the error is what it is: the torque that the model lacks, and the error, split by cause."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._error_loop import responses
from ._html import Entry, by_joint, joined, listed, text
from ._joints import Joints, Window, chosen, chosen_one, lengths, rows_in
from ._look import Style
from ._mismatch import INSIDE, mismatch
from .run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

WORDS = {
    "inertia": "wrong inertia",
    "coriolis": "wrong Coriolis torque",
    "gravity": "wrong gravity",
    "friction": "friction",
    "payload_inertia": "inertia of the payload",
    "payload_coriolis": "Coriolis torque of the payload",
    "payload_gravity": "gravity of the payload",
    "disturbance": "the disturbance",
    "contact": "contact at the stops",
    "feedforward": "what the law leaves out",
    "hand_over": "the hand-over",
    "measurement": "measurement",
    "sampling": "sampling",
    "delay": "the delay",
    "saturation": "limits of the torque",
    "actuators": "the actuators",
    "cancelled": "late or wrong cancelling",
    "start": "the start",
    "rest": "the rest",
}
"""The causes in their order, in words."""

NAMED, SMALL, DOUBTED = 3, 0.05, 0.3
"""How many causes a sentence names at the most, from which share on, and which rest of the error
makes it doubt the estimate."""

CANCELLED = "cancelled of what the model lacks [%]"

NOTHING = 1e-12
"""An error [rad] or a torque [N·m] that is smaller is rounding."""


@dataclass(frozen=True, eq=False)
class Attribution:
    """What the error of a run is made of, by cause; `attribution` makes it.

    The torque is split exactly, sample by sample. The error is an estimate. Causes, all as torque
    that was missing:

    - "inertia", "coriolis", "gravity", "friction": the plant's less the model's; what the payload
      makes of the first three is in "payload_inertia", "payload_coriolis", "payload_gravity";
    - "disturbance"; "contact" at the stops;
    - "feedforward": what the law does not use of its model, as PD leaves out the inertia;
    - "hand_over": a reference, or a first torque, that was taken over softly;
    - "measurement": what sensors, filters and a motor behind its gear show in the place of the
      motion; "sampling": a torque that is held while the motion goes on; "delay";
    - "saturation": what limits of effort and rate cut off; "actuators": gain, lag, cogging, gears
      that give;
    - "cancelled", of the other sign: what the controller adds to its law because of what it learnt,
      observed or integrated;
    - "rest": rounding.

    Of the error "start" is what was there at the first row and fades, "cancelled" what the
    controller cancelled in another way than `error` says, and "rest" what the estimate cannot tell.
    """

    t: Array
    """Time [s], (T,)."""
    torque: Mapping[str, Array]
    """Torque that was missing by cause [N·m], (T, n) each; their sum is ``whole``."""
    whole: Array
    """Torque that was missing in the end [N·m], (T, n): what keeps the error from fading as the law
    wants it, ``(A - A₀) - M₀ (ddq - ddq_d)`` with the feedback ``A - A₀`` of the law; ``M₀ (v -
    ddq)`` in computed torque."""
    error: Mapping[str, Array]
    """Estimate of the error by cause [rad], (T, n) each; their sum is ``e``. Each torque is sent
    through the linear loop of the law. What the controller cancels is taken for an integral of the
    error, for an observer, or for a share of every cause, whichever fits the run best. NaN where
    no such loop stays near the run."""
    e: Array
    """Tracking error [rad], (T, n)."""
    window: tuple[float, float]
    """From when to when the shares are [s]."""
    units: tuple[str, ...]
    """"rad" of each joint, "m" of a prismatic one, whose torques are forces [N]."""
    joint_names: tuple[str, ...]
    """Names of the joints; their numbers, from 1, where they have none."""
    notes: tuple[str, ...] = ()
    """What to know of these figures, in words."""

    @property
    def mismatch(self) -> Array:
        """All causes together, before the controller cancels any [N·m], (T, n)."""
        return self.whole - self.torque["cancelled"]

    @property
    def torque_shares(self) -> dict[str, Array]:
        """Shares of the mismatch, (n,) each: they add up to 1.

        ``Σ cause · mismatch / Σ mismatch²`` over the window: the projection of a cause on the
        whole. It is negative for a cause that made the mismatch smaller. NaN without a mismatch.
        """
        parts = {name: part for name, part in self.torque.items() if name != "cancelled"}
        return self._shares(parts, self.mismatch)

    @property
    def error_shares(self) -> dict[str, Array]:
        """Shares of the error, (n,) each, likewise: an estimate."""
        return self._shares(self.error, self.e)

    @property
    def rms_torque(self) -> dict[str, Array]:
        """RMS of each cause over the window [N·m], (n,)."""
        return {name: _rms(part[self.rows]) for name, part in self.torque.items()}

    @property
    def rms_error(self) -> dict[str, Array]:
        """RMS of the error by cause over the window [rad], (n,): an estimate."""
        return {name: _rms(part[self.rows]) for name, part in self.error.items()}

    @property
    def rms_of_error(self) -> Array:
        """RMS of the error itself over the window [rad], (n,)."""
        return _rms(self.e[self.rows])

    @property
    def cancelled(self) -> Array:
        """Share of what the model lacks that the controller cancels, (n,).

        1 - RMS left / RMS of all, of the causes but "hand_over", "sampling", "measurement", "delay"
        and "saturation", which no controller can cancel. Negative where it makes them larger; NaN
        where there are none.
        """
        known = (name for name in self.torque if name not in (*INSIDE, "cancelled"))
        lacks = np.sum([self.torque[name] for name in known], axis=0)
        left, whole = (_rms(it[self.rows]) for it in (lacks + self.torque["cancelled"], lacks))
        there = whole > NOTHING
        return np.where(there, 1.0 - left / np.where(there, whole, 1.0), np.nan)

    def sentence(self, joint: int | str | None = None) -> str:
        """Why the error of a joint is what it is, in words.

        ``joint``: its number, from 1, or its name; None: that with the largest RMS error. Raises
        ValueError for a joint that is not there.
        """
        size = self.rms_of_error
        place = int(np.argmax(size)) if joint is None else chosen_one(joint, self.joint_names)
        return self._said_of(place)

    def _said_of(self, joint: int) -> str:
        """The sentence about the joint at this place."""
        size = self.rms_of_error
        of_error = {name: float(share[joint]) for name, share in self.error_shares.items()}
        of_torque = {name: float(share[joint]) for name, share in self.torque_shares.items()}
        start, end = self.window
        rms = f"RMS {1e3 * size[joint]:.3g} m{self.units[joint]}"
        where = f"joint {joint + 1} ({rms}, {start:.4g} to {end:.4g} s)"
        if size[joint] <= NOTHING:
            return f"There is no error of joint {joint + 1} to speak of."
        if abs(of_error["rest"]) <= DOUBTED:
            said = f"About {_listed(of_error, f'of the error of {where} is')}."
        elif np.isnan(of_torque["rest"]):
            return f"Nothing is missing at {where}, and no linear loop explains its error."
        else:
            said = (
                f"No linear loop explains the error of {where}. Of the torque that is missing "
                f"there, {_listed(of_torque, 'is')}."
            )
        return f"{said} {self._made_up_for(joint)}"

    def plot(
        self,
        *,
        joints: Joints = None,
        window: tuple[float, float] | None = None,
        width: float | None = None,
        style: Style = "light",
    ) -> Figure:
        """Draw the torque by cause over the window, and the shares of the error.

        Parameters
        ----------
        joints: some of the joints, by number from 1 or by name: ``[1, "panda_joint4"]``.
        window: (from, to) [s] of torques and shares, in place of its own.
        width: of the picture as it will be printed [in]: 7.16, the default, for two columns of a
            journal, 3.5 for one.
        style: "light" for paper, or "dark" for dark slides.
        """
        from . import _attribution_plot

        found = self if window is None else replace(self, window=_within(self.t, window))
        shown = chosen(joints, self.joint_names)
        picture: Figure = _attribution_plot.attribution(found, shown, width, style)
        return picture

    def __str__(self) -> str:
        """The sentence, and the shares in tables."""
        heads = "".join(f"{f'joint {n + 1}':>10}" for n in range(len(self.units)))
        lines = [self.sentence(), *self.notes]
        for heading, shares in self._tables().items():
            lines += ["", f"{heading:<38}{heads}"]
            lines += [f"  {words:<36}{_cells(share)}" for words, share in shares.items()]
        return "\n".join([*lines, "", f"{CANCELLED:<38}{_cells(self.cancelled)}"])

    def _tables(self) -> dict[str, dict[str, Array]]:
        """Shares that show, by the heads of their tables and the words of the causes."""
        tables = {
            "of the error, estimated [%]": self.error_shares,
            "of the missing torque [%]": self.torque_shares,
        }
        return {
            heading: {
                WORDS[name]: share
                for name, share in shares.items()
                if (np.abs(share) >= 5e-4).any()
            }
            for heading, shares in tables.items()
        }

    def _repr_html_(self) -> str:
        """The sentence and the tables, for a notebook."""
        tables = []
        for heading, shares in self._tables().items():
            figures = [Entry(words, "", _percents(share)) for words, share in shares.items()]
            tables.append(by_joint(f"Shares {heading}", self.joint_names, figures))
        rms = [
            Entry("RMS error", "mrad", 1e3 * self.rms_of_error),
            Entry(CANCELLED.removesuffix(" [%]"), "%", _percents(self.cancelled)),
        ]
        whole = by_joint("Error and what is cancelled.", self.joint_names, rms, self.units)
        said = f"<p>{text(self.sentence())}</p>"
        return joined([said, whole, *tables, listed("Notes:", self.notes)])

    def _made_up_for(self, joint: int) -> str:
        share = float(self.cancelled[joint])
        if np.isnan(share):
            return "Its model lacks nothing."
        if not self.torque["cancelled"].any():
            return "The controller cancels nothing of what its model lacks."
        if share <= -0.005:
            return f"What it adds makes what its model lacks {percent(-share)} larger."
        return f"The controller cancels {percent(max(share, 0.0))} of what its model lacks."

    @property
    def rows(self) -> NDArray[np.bool_]:
        """Which rows are in the window, (T,)."""
        rows: NDArray[np.bool_] = (self.t >= self.window[0]) & (self.t <= self.window[1])
        return rows

    def _shares(self, parts: Mapping[str, Array], whole: Array) -> dict[str, Array]:
        whole = whole[self.rows]
        power = (whole**2).mean(axis=0)
        power = np.where(np.sqrt(power) > NOTHING, power, np.nan)
        return {
            name: (part[self.rows] * whole).mean(axis=0) / power for name, part in parts.items()
        }


def attribution(
    run: Run,
    *,
    window: tuple[float, float] | None = None,
    disturbance: Any = None,
    unloaded: _core.Arm | None = None,
) -> Attribution:
    """Tell why the error of a run is what it is.

    The torque that the model of its controller lacks is split by cause, exactly, at every row; an
    estimate sends each cause through the loop to the error. `Attribution` says what the causes are;
    print it, or draw it. Rows that are further apart than the samples (``record_every``) make the
    estimate of the error coarser.

    Parameters
    ----------
    run: from `simulate`, or from a file; recorded whole.
    window: (from, to) [s] of the shares, the whole run by default. Take the time after the start if
        that is all that the shares tell.
    disturbance: of a run from a file whose disturbance was a callable, which no file keeps.
    unloaded: the plant's arm without what it carries. None: a body that the last link has and the
        controller's arm has not, or the plant's at another time, is a payload if all other links
        are the same; nothing tells it from a last link that is heavier than the model says.

    Raises
    ------
    ValueError, TypeError
        Naming the argument: a run that does not say what it was made with (of a guard, of
        an older file, or made by ``dataclasses.replace``), that has no torques or fewer than two
        rows, or a ``window`` without a row.
    """
    scene = run._made
    if scene is None:
        raise ValueError(
            "run: got one that does not say what it was made with, wants one of `simulate` without "
            "a guard, or its file"
        )
    if len(run.tau) != len(run.t) or len(run.t) < 2:
        raise ValueError(
            f"run: got one with {len(run.tau)} rows of torques, wants two at least; "
            'record="motion" keeps none'
        )
    if unloaded is not None and not isinstance(unloaded, _core.Arm):
        raise TypeError(f"unloaded: got {unloaded!r:.80}, wants an Arm")
    if unloaded is not None and unloaded.joints != run.joints:
        raise ValueError(f"unloaded: got {unloaded.joints} joints, wants {run.joints}")
    shown = _within(run.t, window)
    lacks = mismatch(run, scene, disturbance, unloaded)
    torque = {name: lacks.parts[name] for name in WORDS if name in lacks.parts}
    found = responses(run, lacks)
    error = {name: found[name] for name in WORDS if name in found}
    units, names = lengths(lacks.kinds), tuple(run.joint_names)
    return Attribution(run.t, torque, lacks.whole, error, run.e, shown, units, names, lacks.notes)


def _within(t: Array, window: Window) -> tuple[float, float]:
    """The window, as far as the run goes."""
    rows_in(t, window)
    start, end = (-np.inf, np.inf) if window is None else window
    return max(float(start), float(t[0])), min(float(end), float(t[-1]))


def _listed(shares: Mapping[str, float], link: str) -> str:
    """The largest shares in words; ``link`` follows the first number."""
    ordered = sorted(shares, key=lambda name: -abs(shares[name]))
    named = [name for name in ordered if abs(shares[name]) >= SMALL][:NAMED]
    words = [f"{percent(shares[name])} {WORDS[name]}" for name in named]
    words[0] = f"{percent(shares[named[0]])} {link} {WORDS[named[0]]}"
    against = any(shares[name] < 0.0 for name in named)
    return "; ".join(words) + " (what is negative works against the others)" * against


def percent(share: float) -> str:
    """A share in whole percent."""
    return f"{100.0 * share:.0f} %".replace("-", "−")


def _cells(shares: Array) -> str:
    """A row of a table, in percent."""
    return "".join(f"{share:>10}" for share in _percents(shares))


def _percents(shares: Array) -> list[str]:
    """Shares in percent, with one digit after the point."""
    return ["–" if np.isnan(x) else f"{round(100.0 * x, 1) + 0.0:.1f}" for x in shares]


def _rms(values: Array) -> Array:
    """RMS over the rows, (n,)."""
    root: Array = np.sqrt((values**2).mean(axis=0))
    return root
