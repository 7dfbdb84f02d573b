"""Scenarios to compare controllers in: an arm that is not the one that they believe in, a motion,
sensors, actuators; and `compare`, which runs them all and gives one table.

>>> print(sa.compare("paper_sensors", only=["computed_torque", "pid"]))
"""

from __future__ import annotations

import copy
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from operator import index
from pathlib import Path
from typing import Any, SupportsIndex

import numpy as np

from . import _core
from ._actual import actual_plant
from ._documented import documented
from ._sections import (
    check,
    front_of,
    nominal_arm,
    own_controller,
    sweep,
    usual_controllers,
)
from .compare_runner import Job, run_all
from .comparison import Comparison, Row
from .run import Run
from .scenario import RUN
from .simulation import simulate

LIBRARY = Path(__file__).parent / "scenarios"
"""The scenarios that come with the package, in TOML."""

BEYOND = (0.0, 0.0, 0.05)
"""The centre of mass of a robot's payload, in the frame of its tip [m]."""

FRICTION_SHARE = 0.01
"""A robot's friction as a share of its effort limits, where nobody says it."""

TIMED_STEPS = 2000
"""Steps of which the processor time is taken."""


@documented
@dataclass(frozen=True)
class Scenario:
    """A scene with controllers to compare, as a file in TOML says it.

    ``read`` takes the path of a file or the name of one that comes with the package
    (`scenario_names`), ``of_robot`` makes one for any robot.
    """

    name: str
    """What the scenario is called."""
    nominal: _core.Arm
    """What the controllers believe in."""
    plant: _core.Plant
    """What is really there."""
    reference: Any
    """The motion that is wanted: a curve or a callable."""
    controllers: Mapping[str, Any]
    """Laws by name: dicts as `Controller` takes them."""
    title: str = ""
    """What a page of it is called."""
    effects: _core.Effects | None = None
    """Sensors, timing and actuators; None: all of them ideal."""
    front: Mapping[str, Any] = field(default_factory=dict)
    """hand_over, velocity_filter, bumpless, delay of every controller."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """Arguments of `simulate`."""
    window: tuple[float, float] | None = None
    """Of the steady figures [s]; None: the second half."""
    band: float = 0.01
    """An error within it counts as settled [rad]."""
    transfer: Any = None
    """Another motion, for what was learnt on the first; None: it is not tried."""
    events: tuple[float, ...] = ()
    """Times at which something happens [s]."""

    @classmethod
    def read(cls, source: str | Path) -> Scenario:
        """Read a scenario: a path of a TOML file, or the name of one of `scenario_names`.

        Raises OSError, and ValueError naming the path of the key that is wrong.
        """
        path = Path(source)
        if path.suffix != ".toml" and str(source) in scenario_names():
            path = LIBRARY / f"{source}.toml"
        text = path.read_text(encoding="utf-8")
        try:
            return cls.of(_core.read_scenario(text), path.stem)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    @classmethod
    def of(cls, sections: Mapping[str, Any], name: str = "scenario") -> Scenario:
        """Build the sections that `read_scenario` gives."""
        nominal = nominal_arm(sections)
        if sections["reference"] is None:
            raise ValueError("reference: is missing, wants a section such as [reference.sines]")
        plant, events = actual_plant(
            nominal, sections["plant"], sections["actual"], sections["disturbance"]
        )
        effects = sections["effects"]
        front = front_of(sections["front"], effects)
        controllers = dict(sections["controllers"])
        if not controllers:
            controllers = own_controller(sections, nominal, plant, front)
        for section in ("controller", "compensator"):
            if sections["controllers"] and sections[section] is not None:
                raise ValueError(f"{section}: wants none beside a section [controllers]")
        metrics = sections["metrics"] or {}
        options = dict(sections["run"] or RUN)
        check(sections, plant, front, options)
        window = None
        if metrics.get("from") is not None or metrics.get("to") is not None:
            end = options["duration"] if metrics.get("to") is None else metrics["to"]
            window = (metrics.get("from") or 0.0, end)
        return cls(
            name,
            nominal,
            plant,
            sections["reference"],
            controllers,
            title=sections["title"] or name,
            effects=effects,
            front=front,
            options=options,
            window=window,
            band=metrics.get("band", 0.01),
            transfer=sections["transfer"],
            events=events,
        )

    @classmethod
    def of_robot(
        cls,
        arm: _core.Arm,
        *,
        payload: float = 0.0,
        friction_share: float = FRICTION_SHARE,
        name: str = "robot",
        bandwidth: float = 15.0,
        armature: Any = None,
        effort_limit: Any = None,
        light_joints: bool = False,
        duration: float = 12.0,
    ) -> Scenario:
        """A first comparison for any robot.

        The arm carries ``payload`` [kg] 5 cm beyond its tip and has friction that nobody told the
        controllers of, ``friction_share`` of each effort limit; sensors are encoders of 16 bits
        with velocities by difference, torques one sample late, at 1 kHz. Every controller has the
        ``bandwidth`` [rad/s], and the motion stays within a third of the limits. ``armature``
        [kg·m²]: rotors that the controllers know of, scalar or (n,); None: as the arm has them.
        ``effort_limit`` [N·m]: largest torques, scalar or (n,); None: as the arm has them.
        ``light_joints``: as of `recommended`.
        """
        if armature is not None:
            if not isinstance(arm, _core.Serial):
                raise ValueError(
                    "armature is for a robot from a file (a Serial); "
                    f"got one for a {type(arm).__name__}: leave it out"
                )
            arm = arm.with_armature(armature)
        actual: dict[str, Any] = {"friction_share": friction_share}
        if payload:
            actual |= {"payload": {"mass": payload, "com": list(BEYOND)}}
        if effort_limit is not None:
            limits = np.asarray(effort_limit, dtype=float).tolist()
            actual["effort_limit"] = limits if np.ndim(limits) else [limits] * arm.joints
        plant, _ = actual_plant(arm, None, actual, None)
        effects = _core.Effects(encoder_bits=16, velocity="difference", delay=1)
        reference = sweep(arm)
        return cls(
            name,
            arm,
            plant,
            reference,
            usual_controllers(arm, bandwidth, light_joints),
            title=f"{name}: {payload:g} kg and friction that nobody told the controllers of",
            effects=effects,
            front=front_of({"hand_over": 3.0, "velocity_filter": 100.0}, effects),
            options=RUN
            | {
                "duration": duration,
                "control_period": 1e-3,
                "q0": np.asarray(reference(0.0)[0]).tolist(),
            },
        )

    def controller(self, law: Any) -> Any:
        """A controller of this scene: of a law (a dict), or of what `compare` takes."""
        period = self.options.get("control_period")
        if isinstance(law, Mapping):
            limit = self.plant.effort_limit
            limits = None if not np.isfinite(limit).all() else limit
            return _core.Controller(self.nominal, law, limits, control_period=period, **self.front)
        if isinstance(law, type) or not hasattr(law, "step"):
            law = law(self.nominal)
        if isinstance(law, _core.Controller | _core.Guard):
            return law
        # What stands before every law stands before one's own too.
        return _core.Controller(self.nominal, law, control_period=period, **self.front)

    def simulate(
        self, law: Any, *, seed: int | None = None, reference: Any = None, **options: Any
    ) -> Run:
        """Run the scene with one controller; ``seed`` is that of the effects.

        ``law``: the name of one of the scenario's controllers, or as `compare` takes it.
        """
        law = self.controllers[law] if isinstance(law, str) else law
        return self._run(self.controller(law), seed, reference, options)

    def _run(self, controller: Any, seed: int | None, reference: Any, options: Any) -> Run:
        effects = self.effects
        if effects is not None and seed is not None:
            effects = effects.__replace__(seed=seed)
        reference = self.reference if reference is None else reference
        given = {**self.options, "effects": effects} | options
        return simulate(self.plant, controller, reference, **given)


def scenario_names() -> list[str]:
    """The names of the scenarios that come with the package."""
    return sorted(path.stem for path in LIBRARY.glob("*.toml"))


def compare(
    scenario: Scenario | str | Path,
    controllers: Mapping[str, Any] | None = None,
    *,
    only: Sequence[str] | None = None,
    seeds: int | Iterable[int] = 1,
    workers: int | None = None,
    progress: bool | None = None,
    freeze: bool = True,
) -> Comparison:
    """Run every controller of a scenario, and give one table.

    Parameters
    ----------
    scenario: a `Scenario`, the path of a file, or the name of one of `scenario_names`.
    controllers: more of them by name: a law as a dict, a `Controller`, an object of your own with
        a method ``step(q, dq, q_d, dq_d, ddq_d, dt) -> tau``, or a function of the nominal arm that
        makes one of these, such as a class.
    only: the names of those that run, in place of all.
    seeds: a number of seeds, counted from 0, or the seeds: of noise, jitter, lost samples.
    workers: number of threads; as many as there are cores by default.
    progress: whether to show a bar; by default on a terminal.
    freeze: whether what learns is run once more with learning stopped, and once more along the
        scenario's ``transfer``.

    Returns
    -------
    Comparison
        A controller that its own condition refuses, or that raises, keeps its row, with the reason.
        Ctrl-C keeps the rows that there are.

    Raises
    ------
    ValueError, OSError
        For a scenario that cannot be read, a name in ``only`` that no controller has, no name or
        seed at all, and seeds that are none.
    """
    scene = scenario if isinstance(scenario, Scenario) else Scenario.read(scenario)
    every = {**scene.controllers, **(controllers or {})}
    names = _chosen(every, only)
    seeds = seeds_of(seeds)
    jobs = [
        Job(name, scene.name, seed, partial(_row, scene, name, every[name], seed, freeze))
        for seed in seeds
        for name in names
    ]
    return Comparison(run_all(jobs, workers, progress), scene.title, rotors_missing(scene))


def _chosen(every: Mapping[str, Any], only: Sequence[str] | None) -> list[str]:
    """The names of the controllers that run."""
    wanted = f"some of {', '.join(map(str, every))}"
    if isinstance(only, str):
        raise TypeError(f"only: got {only!r}, wants a list of names: {wanted}")
    names = list(every) if only is None else list(only)
    for name in names:
        if name not in every:
            raise ValueError(f"only: got {name!r}, wants {wanted}")
    if not names:
        raise ValueError(f"only: got no name, wants {wanted}")
    return names


def seeds_of(seeds: int | Iterable[int]) -> list[int]:
    """The seeds, or so many of them, counted from 0."""
    refused = ValueError(
        f"seeds: got {seeds!r:.80}, wants how many, at least 1, or a list of whole numbers from 0 "
        "to 2^64 - 1"
    )
    try:
        count = isinstance(seeds, SupportsIndex) and not isinstance(seeds, np.ndarray)
        found = list(range(index(seeds)) if count else map(index, seeds))  # type: ignore[arg-type]
    except TypeError:
        raise refused from None
    possible = all(0 <= seed < 2**64 for seed in found)
    if isinstance(seeds, bool) or not found or not possible:
        raise refused
    if len(set(found)) < len(found):
        raise ValueError(f"seeds: got {seeds!r:.80}, wants each once: one seed gives one run")
    return found


FASTEST = 5000.0
"""An effort limit that could accelerate a joint faster tells of missing rotors [rad/s²]."""


def rotors_missing(scene: Scenario) -> tuple[str, ...]:
    """A note where the model of a robot says nothing of rotors that must be there."""
    arm = scene.nominal
    if not isinstance(arm, _core.Serial):
        return ()
    poses = [scene.reference(t)[0] for t in np.linspace(0.0, scene.options["duration"], 24)]
    light = np.min([np.diag(arm.mass_matrix(q)) for q in poses], axis=0)
    fast = np.flatnonzero(arm.limits["effort"] / light > FASTEST) + 1
    if not len(fast):
        return ()
    joints = ", ".join(str(joint) for joint in fast)
    return (
        f"rotor inertia is missing in this model, joint {joints}: its effort limit could "
        f"accelerate it by more than {FASTEST:g} rad/s²; state it (armature), or these "
        "figures are not those of the robot",
    )


def _row(scene: Scenario, name: str, law: Any, seed: int, freeze: bool) -> Row:
    """What one controller does with one seed."""
    try:
        controller = scene.controller(law)
    except (ValueError, TypeError) as error:
        return Row(name, scene.name, seed, "refused", str(error))
    run = scene._run(controller, seed, None, {})
    frozen = transfer = None
    if freeze and run.status.finished and getattr(run.tracker, "learns", False):
        tracker = run.tracker
        assert tracker is not None
        tracker.freeze()
        tracker.start_hand_over()
        frozen = scene._run(tracker, seed, None, {})
        if scene.transfer is not None:
            start = {"q0": scene.transfer(0.0)[0], "dq0": scene.transfer(0.0)[1]}
            transfer = scene._run(tracker, seed, scene.transfer, start)
    limit = scene.plant.effort_limit
    return Row.of(
        run,
        controller=name,
        scenario=scene.name,
        seed=seed,
        window=scene.window,
        band=scene.band,
        effort_limit=limit if np.isfinite(limit).any() else None,
        events=scene.events,
        step_time=_step_time(scene, controller, run),
        frozen=frozen,
        transfer=transfer,
        transfer_window=scene.window,
    )


def _step_time(scene: Scenario, controller: Any, run: Run) -> float | None:
    """Processor time of one step, called from Python [s]."""
    if not isinstance(controller, _core.Controller) or len(run.t) < 3:
        return None
    twin = copy.deepcopy(controller)
    dt = scene.options.get("control_period") or scene.options["dt"]
    rows = [
        [array[k] for array in (run.q, run.dq, run.q_d, run.dq_d, run.ddq_d)]
        for k in range(min(TIMED_STEPS, len(run.t)))
    ]
    begun = time.thread_time()
    for row in rows:
        q, dq, q_d, dq_d, ddq_d = row
        twin.step(q, dq, q_d, dq_d, ddq_d, dt)
    return (time.thread_time() - begun) / len(rows)
