"""The record of a simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, make_dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._documented import documented
from ._joints import Joints, Window, lengths_of
from ._look import Style
from ._scene import Scene, joint_names
from .metrics import Metrics
from .record import CHANNELS, DESIRED, MOTION, Certificate, Channel, GuardReport, Status

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped, import-not-found, unused-ignore]
    import xarray  # type: ignore[import-untyped, import-not-found, unused-ignore]
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

if TYPE_CHECKING:

    @dataclass(frozen=True, eq=False)
    class _Columns:
        """The signals that editors know. The core declares them, and may have more."""

        t: Array
        q: Array
        dq: Array
        q_d: Array
        dq_d: Array
        ddq_d: Array
        e: Array
        de: Array
        tau: Array
        tau_model: Array
        tau_compensation: Array
        rho: Array
        rho_hat: Array
        weights_norm: Array | None
        V: Array | None
else:
    _Columns = make_dataclass("_Columns", list(CHANNELS), frozen=True, eq=False)


@dataclass(frozen=True, eq=False)
class Run(_Columns):
    """The record of a simulation, time first: every signal is an attribute, (T,) or (T, n).

    `channels` tells which there are, with unit, shape and meaning. A signal of one number that was
    not recorded is None. A record of the motion alone (``record="motion"``) has no rows of torque
    and model error, and computes set-points and errors when one of them is first asked for.
    """

    weights: Array | None
    """Final weights (n, rules); None without a compensator, or with a dictionary."""
    status: Status
    """Why the run ended."""
    certificate: Certificate | None
    """The dissipation identity; None without a compensator, and in sampled control: the identity is
    that of a law in continuous time. Look at `design` for the margin of a sampled loop, and at a
    run of the same scene without ``control_period`` for the law."""
    dictionary: _core._Dictionary | None = None
    """The final dictionary as `ComputedTorque.dictionary` has it; None for another compensator."""
    own: Mapping[Channel, Array] = field(default_factory=dict)
    """Signals that the compensator adds; each is an attribute too."""
    notes: tuple[str, ...] = ()
    """Choices that did nothing or ruined the run, in words; empty if there are none."""
    guard: GuardReport | None = None
    """What the guard did in it; None for a run without a guard."""

    @classmethod
    def _from_record(
        cls,
        record: dict[str, Any],
        plant: _core.Plant,
        reference: Any,
        options: Mapping[str, Any],
        own: Any = None,
    ) -> Run:
        """Build a run from the core's record, and what was simulated; ``own`` as for `Scene`."""
        certificate, parts = record["certificate"], record["tracker"]
        columns, joints = record["columns"], record["columns"]["q"].shape[1]
        for name, (_, per_joint, _) in CHANNELS.items():
            array = columns[name]
            if array is not None and (per_joint or len(array) or name in MOTION):
                continue
            if name in DESIRED:
                del columns[name]
            else:
                columns[name] = np.empty((0, joints)) if per_joint else None
        run = cls.__new__(cls)
        vars(run).update(
            columns,
            weights=record["weights"],
            status=Status(*record["status"]),
            certificate=None if certificate is None else Certificate(**certificate),
            dictionary=record["dictionary"],
            own={Channel._of(declared, joints): array for declared, array in record["own"]},
            _tracker=parts,
            _reference=reference,
            guard=None if record["guard"] is None else GuardReport(*record["guard"]),
            # A guard is not part of a scene: without it, the run would be another.
            _scene=Scene.of(plant, parts[:2], record["start"], reference, options, own)
            if record["guard"] is None
            else None,
        )
        return run

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            # For what is not there alone. The reference stays, in case two threads ask at once.
            if not name.startswith("_"):
                for channel, array in vars(self).get("own", {}).items():
                    if channel.name == name:
                        return array
            if name not in DESIRED or "_reference" not in vars(self):
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            _, (nominal, *_), _ = self._tracker
            arrays = _core.desired_motion(self._reference, nominal, self.t, self.q, self.dq)
            desired = dict(zip(DESIRED, arrays, strict=True))
            vars(self).update(desired)
            return desired[name]

    def __getstate__(self) -> dict[str, Any]:
        """Return all that a copy has: set-points and errors instead of the reference."""
        for name in DESIRED:
            getattr(self, name)
        state = {name: value for name, value in vars(self).items() if name != "_reference"}
        if self._made is not None:
            state["_scene"] = Scene(self._made.plain, self._made.start)
        return state

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.channels})

    @property
    def _made(self) -> Scene | None:
        scene: Scene | None = vars(self).get("_scene")
        return scene

    @property
    def channels(self) -> dict[str, Channel]:
        """The signals that this run has rows of, by name."""
        common = [Channel._of((name, *rest), self.joints) for name, rest in CHANNELS.items()]
        recorded = [channel for channel in common if self._has(channel.name)]
        return {channel.name: channel for channel in (*recorded, *self.own)}

    def _has(self, name: str) -> bool:
        if name in DESIRED:
            return True
        array = getattr(self, name)
        return array is not None and len(array) == len(self.t)

    @property
    def scene(self) -> dict[str, Any] | None:
        """What the run was made with, in plain values, as its file has it.

        ``steadyarm``: version of the package; ``joint_names``; ``plant``, ``tracker`` (nominal arm,
        gains, compensator, limits), ``reference`` and ``options`` as `simulate` was given them. An
        object is ``{"its class": {argument: value}}``, a serial arm its TOML. None for a run from a
        file of an older version, one made of another by ``dataclasses.replace``, or one with
        a guard.
        """
        return None if self._made is None else self._made.plain

    @property
    def joint_names(self) -> list[str]:
        """The names of the plant's joints; their numbers, from 1, where it has none."""
        if self._made is None:
            return list(joint_names(None, self.joints))
        return list(self._made.parts["joint_names"])

    def replay(self, *, reference: Any = None, disturbance: Any = None, law: Any = None) -> Run:
        """Simulate the run again, from what it was made with: the same to the bit.

        No file keeps a callable: ``reference`` and ``disturbance`` give those of the run anew, or
        others in their place; ``law`` gives the controller of your own. Raises ValueError that
        names what must be given, and for a run that has no `scene`.
        """
        from .simulation import simulate

        if self._made is None:
            raise ValueError(
                "run: got one without its scene, wants one from `simulate` or its file"
            )
        plant, tracker, reference, options = self._made.build(reference, disturbance, law)
        return simulate(plant, tracker, reference, **options)

    def to_dict(self) -> dict[str, Array]:
        """All recorded signals by name, (T,) or (T, n); `channels` has their units."""
        return {name: getattr(self, name) for name in self.channels}

    def to_csv(self, path: str | Path, names: Sequence[str] | None = None) -> None:
        """Write recorded signals to a CSV file: all of them, or those of these names.

        The header has ``t``, then a column a joint, ``q_1`` to ``q_n``; a signal of one number has
        its own name. A row a sample, with all digits. The file is replaced as a whole.
        """
        from . import _csv, _files

        _files.text(path, _csv.text(_csv.table(self, names)))

    def to_pandas(self) -> pandas.DataFrame:
        """All recorded signals as a table over time.

        Columns are pairs of signal and joint, the joint "" for one number: ``frame["q"]`` has a
        column a joint. ``frame.attrs`` has "units" and "docs" by signal. Needs pandas.
        """
        from . import _tables

        return _tables.to_pandas(self)

    def to_xarray(self) -> xarray.Dataset:
        """All recorded signals over time and joint, with units and meaning as attributes.

        Coordinates are t and joint, by its name. Needs xarray.
        """
        from . import _tables

        return _tables.to_xarray(self)

    @cached_property
    def tracker(self) -> _core.Controller | None:
        """The controller with all that it learnt, to go on with.

        None in a run from a file, or one made of another by ``dataclasses.replace``.
        ``simulate(plant, run.tracker, reference, q0=run.q[-1], dq0=run.dq[-1])`` goes on where the
        run ended, at time 0 of the reference.
        """
        parts = vars(self).get("_tracker")
        if parts is None:
            return None
        kind, arguments, state = parts
        tracker: _core.Controller = kind(*arguments)
        tracker.__setstate__(state)
        return tracker

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return int(self.q.shape[1])

    def metrics(self, window: tuple[float, float] | None = None, band: float = 0.01) -> Metrics:
        """RMS, maximum, ITAE, settling time, effort and torque variation over a window.

        ``window`` is (from, to) [s], the whole run by default; ``band`` [rad] is what counts as
        settled. Raises ValueError if the window holds no sample.
        """
        window = (0.0, float("inf")) if window is None else window
        tau = self.tau if len(self.tau) else None
        figures = _core.metrics(self.t, self.e, tau, window, band)
        return Metrics(**figures, joint_names=tuple(self.joint_names), units=lengths_of(self))

    def plot(
        self,
        *names: str,
        joints: Joints = None,
        window: Window = None,
        width: float | None = None,
        style: Style = "light",
    ) -> Figure:
        """Draw the signals of these names, or else the whole run; return the figure.

        The whole: position, error, torque, (with a compensator) ρ against ρ̂, and what the
        compensator adds. `channels` has the names.

        Parameters
        ----------
        joints: some of the joints, by number from 1 or by name: ``[1, "panda_joint4"]``.
        window: (from, to) [s].
        width: of the picture as it will be printed [in]: 7.16, the default, for two columns of a
            journal, 3.5 for one. Letters have 7 and 8 pt there.
        style: "light" for paper, or "dark" for dark slides.
        """
        from . import plots

        draw = partial(plots.signals, self, names) if names else partial(plots.overview, self)
        return draw(joints=joints, window=window, width=width, style=style)

    def to_html(self, path: str | Path, *, arm: Any = None, against: Any = None) -> None:
        """Write a page of one file that needs no network: the arm in motion, curves and figures.

        ``arm``: a `TwoLink` or a `Serial`; None: the plant's, if the run says what it was made with
        (`scene`), or else the page has the curves alone. ``against``: another run, or several by
        name, beside it at the same time and in the same scale. What the plant's arm carries and
        the controller does not know of is drawn at its tip.
        """
        from . import _files, _view_page

        _files.text(path, _view_page.page(self, arm, against))

    def _repr_html_(self) -> str:
        from . import _view_page

        return _view_page.fragment(self)

    def animate(self, arm: Any, path: str | Path, *, speed: float = 1.0) -> Path:
        """Write a film of the ``arm`` in motion, the desired pose as a ghost, to a .gif or .mp4.

        ``speed`` 2 shows two seconds of the run in one. The film takes some seconds to draw; the
        file is replaced as a whole, and what was there stays if filming fails or is stopped.
        """
        from . import animation

        return animation.save_animation(self, arm, path, speed=speed)

    def save(self, path: str | Path) -> None:
        """Write the run to ``path`` (.npz); `load` reads it back.

        The file is replaced as a whole: if writing fails or is stopped, what was there stays.
        Raises OSError then, and ValueError for a run that `load` would refuse.
        """
        from . import _run_file

        _run_file.save(self, path)

    @classmethod
    def load(cls, path: str | Path) -> Run:
        """Read a run that `save` wrote, looking at names, sizes and shapes first.

        Raises ValueError for any other file, or a damaged one.
        """
        from . import _run_file

        return _run_file.load(path)

    def __repr__(self) -> str:
        said, kernel = f"{len(self.t)} rows of {self.joints} joints, {self.status}", self.dictionary
        if kernel is not None:
            said += ", {atoms} of {capacity} atoms, {dropped} dropped".format_map(kernel)
        return f"Run({said})"


documented(Run, {name: f"{doc} [{unit}]." for name, (unit, _, doc) in CHANNELS.items()})
