"""What `steadyarm design` says of a scenario, or of one's own robot: which controllers suit its
loop, how slow the loop may be for each, what the recommended one chose, what the motion teaches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import floor, log10
from typing import Any

import numpy as np

from . import _core
from ._report import finite, itemized
from ._robots import described
from ._source import SHARE, Kind, hint, mass_of
from .bench import Scenario, rotors_missing
from .design import DesignReport, design
from .learnable import Learnable, learnable
from .learned import DOUBTFUL

PERIOD = 1e-3
"""Of a loop that says none [s]."""

SHORTEST, LONGEST = 1e-5, 1.0
"""Periods between which the longest that a controller accepts is looked for [s]."""

ASKED = 10
"""How often a controller is asked for it: the answer is within a hundredth or so."""

RECOMMENDED = "recommended"


@dataclass(frozen=True)
class Judged:
    """What one controller says of the loop."""

    name: str
    refusal: str | None
    """Why it is refused; None: it is accepted."""
    longest: float | None
    """The longest period that it accepts [s]; None: none, or it depends on no period."""

    def line(self) -> str:
        """One line on it, with the reason."""
        slow = "" if self.longest is None else f"accepted up to {period_words(self.longest)}"
        if self.refusal is None:
            return f"{self.name:28}{slow or 'accepted'}"
        after = f"; {slow}" if slow else hint(self.refusal, "scenario")
        return f"{self.name:28}refused: {self.refusal}{after}"

    def cells(self) -> str:
        """One line of a table, without the reason."""
        slow = "none" if self.longest is None else period_words(self.longest)
        verdict = "accepted" if self.refusal is None else "refused"
        return f"  {self.name:26}{verdict:12}{slow}"


@dataclass(frozen=True)
class Judgement:
    """What all controllers of a scene say of its loop."""

    scene: Scenario
    kind: Kind

    @property
    def period(self) -> float | None:
        """Of the loop [s]; None: continuous."""
        return self.scene.options.get("control_period")

    @property
    def delay(self) -> int:
        """Samples that a torque is late."""
        return int(self.scene.front.get("delay", 0))

    @cached_property
    def judged(self) -> list[Judged]:
        """All controllers, in their order."""
        return [self._judge(name) for name in self.scene.controllers]

    @cached_property
    def reports(self) -> dict[str, DesignReport]:
        """What `design` says of those that are computed torque with a fuzzy compensator."""
        trackers = {it.name: self._tracker(it.name) for it in self.judged if it.refusal is None}
        scene, period = self.scene, PERIOD if self.period is None else self.period
        return {
            name: design(
                tracker,
                period,
                self.delay,
                path=scene.reference,
                plant=scene.plant,
                effects=scene.effects,
            )
            for name, tracker in trackers.items()
            if tracker is not None
        }

    @cached_property
    def teaches(self) -> Learnable:
        """What the motion of the scene can teach."""
        load = _payload(self.scene)
        return learnable(self.scene.nominal, self.scene.reference, payload=load or 1.0)

    @cached_property
    def chosen(self) -> dict[str, Any] | None:
        """What the rule of the recommended controller chose; None where it is refused."""
        if not any(it.name == RECOMMENDED and it.refusal is None for it in self.judged):
            return None
        tracker = self.scene.controller(self.scene.controllers[RECOMMENDED])
        told = _core.describe(tracker)
        names = ("bandwidth", "cut_off", "quickness", "braking")
        gains: dict[str, Any] = {name: told[name] for name in names}
        condition, learning = float(told["condition"][0]), float(told["learning"][0])
        return {**gains, "learning": learning, "condition": condition}

    @property
    def sound(self) -> bool:
        """Whether nothing is refused; of a robot, whether the recommended controller is not."""
        if self.kind == "robot":
            return self.chosen is not None
        every = all(it.refusal is None for it in self.judged)
        return every and all(report.sound for report in self.reports.values())

    def _judge(self, name: str) -> Judged:
        refusal = _refusal(self.scene, name)
        if not isinstance(self.scene.controllers[name], Mapping) or self.period is None:
            return Judged(name, refusal, None)
        return Judged(name, refusal, _longest(self.scene, name))

    def _tracker(self, name: str) -> _core.ComputedTorque | None:
        """Computed torque with a fuzzy compensator as such; None of another controller."""
        law = self.scene.controllers[name]
        if not isinstance(law, Mapping) or law["law"] != "computed_torque":
            return None
        given = {key: value for key, value in law.items() if value is not None}
        if "compensator" not in given:
            return None
        settings = dict(given["compensator"])
        basis = _core.FuzzyBasis(**settings.pop("basis"))
        compensator = _core.FuzzyCompensator(basis, **settings)
        arm, cut_off = self.scene.nominal, self.scene.front.get("velocity_filter")
        if "bandwidth" in given:
            bandwidth = np.asarray(given["bandwidth"], dtype=float)
            gains = bandwidth**2, 2.0 * bandwidth
        else:
            gains = given["kp"], given["kv"]
        return _core.ComputedTorque(arm, *gains, compensator, velocity_filter=cut_off)

    def words(self) -> str:
        """The report."""
        return "\n".join(self._of_robot() if self.kind == "robot" else self._of_scenario())

    def _of_scenario(self) -> list[str]:
        loop = loop_words(self.period, self.delay)
        lines = [f"scenario    {self.scene.title}", f"loop        {loop}", ""]
        lines += [it.line() for it in self.judged]
        for name, report in self.reports.items():
            along = "along the path of the scenario, without hand-over"
            lines += [f"\n{name}, {along}", str(report)]
        return lines

    def _of_robot(self) -> list[str]:
        arm = self.scene.nominal
        assert isinstance(arm, _core.Serial)
        loop = loop_words(self.period, self.delay)
        rivals = [it for it in self.judged if it.refusal and it.name != RECOMMENDED]
        return [
            f"robot       {arm.name}, {arm.joints} joints, {mass_of(arm):.3g} kg",
            f"loop        {loop}, encoders of 16 bits, velocities by difference",
            f"motion      a sine in every joint, {self.teaches.duration:.3g} s",
            *(f"note        {note}" for note in self._notes()),
            "",
            *self._recommended(arm),
            "",
            f"Which suit this loop, and how slow it may be ({self._bandwidth()}):",
            *(it.cells() for it in self.judged),
            *itemized(f"{it.name}: {it.refusal}" for it in rivals if it.longest is None),
            "",
            "What this motion can teach, whatever learns:",
            *itemized(self.teaches.sentences),
            "",
            "Next: steadyarm simulate or compare, with the same SOURCE and options.",
        ]

    def _notes(self) -> tuple[str, ...]:
        """What is missing in the model, where the recommended controller does not say it."""
        if self.chosen is None:
            return ()
        return rotors_missing(self.scene) or self._rotors_unstated()

    def _rotors_unstated(self) -> tuple[str, ...]:
        """A note where the model has no rotors at all: it does not tell if it lacks some."""
        arm = self.scene.nominal
        assert isinstance(arm, _core.Serial)
        if any(joint["armature"] for joint in described(arm)["joints"]):
            return ()
        return ("the model states no rotors; if the robot has some, give them: --armature",)

    def _bandwidth(self) -> str:
        laws = [law for law in self.scene.controllers.values() if "bandwidth" in law]
        return f"bandwidth {laws[0]['bandwidth']:g} rad/s, but for the recommended one"

    def _recommended(self, arm: _core.Serial) -> list[str]:
        """What the recommended controller is here, or why it is none."""
        it = next(it for it in self.judged if it.name == RECOMMENDED)
        if self.chosen is None:
            slow = f"; accepted up to {period_words(it.longest)}" if it.longest else ""
            refusal = it.refusal or ""
            said = f"{refusal}{slow}{hint(refusal, self.kind)}"
            return ["Verdict: the recommended controller cannot be used so.", *itemized([said])]
        gains = self.chosen
        heads = (("p", "rad/s"), ("filter", "Hz"), ("at most", "rad/s²"), ("brakes", "rad/s²"))
        wide = max(map(len, arm.joint_names)) + 2
        columns = [gains[name] for name in ("bandwidth", "cut_off", "quickness", "braking")]
        return [
            "Verdict: take the recommended controller. It chose all its gains from arm and loop:",
            "",
            " " * wide + "".join(f"{head:>12}" for head, _ in heads),
            " " * wide + "".join(f"{f'[{unit}]':>12}" for _, unit in heads),
            *(
                f"{name:{wide}}" + "".join(f"{column[n]:12.3g}" for column in columns)
                for n, name in enumerate(arm.joint_names)
            ),
            "p: its three poles; filter: of the velocity; at most: what the largest torque gives;",
            "brakes: what is left of it against gravity and the load, to come back to the path",
            "",
            *itemized(self._margins(it, gains, arm)),
        ]

    def _margins(self, it: Judged, gains: Mapping[str, Any], arm: _core.Serial) -> list[str]:
        """How far this is from what does not work."""
        assert self.period is not None
        said = []
        if it.longest is not None:
            said.append(
                f"it is accepted up to {period_words(it.longest)}, {it.longest / self.period:.2g} "
                f"times the period here; take a third of that at most, "
                f"{period_words(it.longest / 3.0)}"
            )
        bound, load = SHARE * mass_of(arm), _payload(self.scene)
        said.append(
            f"it reckons with a load of up to {bound:.2g} kg, a sixth of the arm, and with "
            "masses that are about right; in Python sa.recommended(payload=…) takes other bounds"
        )
        if load > bound:
            said.append(
                f"the load of {load:.3g} kg here is more than it reckons with: declare it, "
                "or nothing says that this is stable"
            )
        condition = gains["condition"]
        sure = f"below {DOUBTFUL:g} it converges at every pose, if the arm stands still"
        if condition > DOUBTFUL:
            sure += "; here no proof says so: a narrower load in sa.recommended, or a run, tells"
        said.append(f"what it learns has a condition of {condition:.2g}; {sure}")
        return said

    def plain(self) -> dict[str, Any]:
        """All of that for programs."""
        return {
            "scenario": self.scene.name,
            "title": self.scene.title,
            "control_period": self.period,
            "delay": self.delay,
            "effort_limit": finite(self.scene.plant.effort_limit),
            "sound": self.sound,
            "controllers": [
                {
                    "controller": it.name,
                    "status": "accepted" if it.refusal is None else "refused",
                    "reason": it.refusal or "",
                    "longest_period": it.longest,
                }
                for it in self.judged
            ],
            "recommended": self.chosen,
            "learnable": vars(self.teaches) if self.kind == "robot" else None,
            "reports": {name: report_plain(report) for name, report in self.reports.items()},
            "notes": list(self._notes()) if self.kind == "robot" else [],
        }


def report_plain(report: DesignReport) -> dict[str, Any]:
    """A design report for programs, by the names of the Python API."""
    found = dict(vars(report))
    teaches = found.pop("learnable")
    return {**found, "learnable": None if teaches is None else vars(teaches)}


def loop_words(period: float | None, delay: int) -> str:
    """A loop in words."""
    if period is None:
        return "continuous"
    late = f"{delay} sample" + "s" * (delay != 1)
    return f"{1e3 * period:.4g} ms, torques {late} late"


def period_words(period: float) -> str:
    """A period and its rate."""
    rate = 1.0 / period
    return f"{1e3 * period:.3g} ms ({rate:.{0 if rate >= 100.0 else 1}f} Hz)"


def _refusal(scene: Scenario, name: str) -> str | None:
    """Why a controller is refused in a scene; None: it is not."""
    try:
        scene.controller(scene.controllers[name])
    except (ValueError, TypeError) as error:
        return str(error)
    return None


def _longest(scene: Scenario, name: str) -> float | None:
    """The longest period that a controller accepts [s], to two digits; None: it accepts none.

    Accepting ends once, on the way from short periods to long ones.
    """

    def accepts(period: float) -> bool:
        options = {**scene.options, "control_period": period}
        return _refusal(replace(scene, options=options), name) is None

    low, high = log10(SHORTEST), log10(LONGEST)
    if not accepts(SHORTEST):
        return None
    if accepts(LONGEST):
        return LONGEST
    for _ in range(ASKED):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if accepts(10.0**middle) else (low, middle)
    digits = 1 - floor(low)
    return float(floor(round(10.0 ** (low + digits), 6)) / 10.0**digits)


def _payload(scene: Scenario) -> float:
    """What the arm that is really there carries beyond the nominal one [kg]; 0 of two links."""
    real, nominal = scene.plant.arm, scene.nominal
    if not (isinstance(real, _core.Serial) and isinstance(nominal, _core.Serial)):
        return 0.0
    return round(max(0.0, mass_of(real) - mass_of(nominal)), 9)
