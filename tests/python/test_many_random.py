"""Many runs of scenes drawn at random: each is that of `simulate`, to the bit.

STEADYARM_SCENES is how many scenes are drawn, and STEADYARM_SEED which ones.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import steadyarm as sa

SCENES = int(os.environ.get("STEADYARM_SCENES", "200"))
SEED = int(os.environ.get("STEADYARM_SEED", "16"))

FIGURES = [name for name in sa.Runs.__dataclass_fields__ if name[0] != "_" and name != "status"]
POSE = (0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8)
SETS = (
    (-1.0, -0.5, 0.0, 0.5, 1.0),
    (-1.5, -0.5, 0.0, 0.5, 1.5),
    (-1.0, 0.0, 1.0),
    (-1.0, -0.6, -0.3, 0.0, 0.3, 0.6, 1.0),
    (-1.0, 0.1, 1.0),
)

Random = np.random.Generator
Tracker = Callable[[Random, Any, float], Any]


def some(rng: Random, share: float, **options: Callable[[], Any]) -> dict[str, Any]:
    """Draw some of the options."""
    return {name: draw() for name, draw in options.items() if rng.random() < share}


def fuzzy(rng: Random, arm: Any, bandwidth: float, form: str = "per_joint") -> Any:
    centers = SETS[2] if form == "grid" else SETS[rng.integers(len(SETS))]
    raw = bool(rng.random() < 0.3)
    basis = sa.FuzzyBasis(form=form, centers=centers, width=0.6, normalized=not raw)
    modified = some(
        rng,
        0.25,
        leak_rate=lambda: float(rng.choice([0.1, 300.0])),
        dead_zone=lambda: float(rng.uniform(0.0, 1.0)),
        normalization=lambda: float(rng.uniform(0.0, 5.0)),
        error_modification=lambda: 0.1,
        projection_radius=lambda: 50.0,
    )
    gain = float(rng.uniform(5.0, 300.0))
    learns = sa.FuzzyCompensator(basis, gain=gain, **modified)
    return sa.ComputedTorque(arm, bandwidth**2, 2.0 * bandwidth, compensator=learns)


LAWS: dict[str, Tracker] = {
    "computed torque": lambda _, arm, p: sa.ComputedTorque(arm, p * p, 2.0 * p),
    "per joint": fuzzy,
    "per joint, again": fuzzy,
    "grid": lambda rng, arm, p: fuzzy(rng, arm, p, "grid" if arm.joints == 2 else "per_joint"),
    "pid": lambda _, arm, p: sa.laws.pid(arm, bandwidth=p),
    "disturbance observer": lambda _, arm, p: sa.laws.disturbance_observer(arm, bandwidth=p),
    "momentum observer": lambda _, arm, p: sa.laws.momentum_observer(arm, bandwidth=p),
    "slotine_li": lambda _, arm, p: sa.laws.slotine_li(arm, bandwidth=p),
    "recommended": lambda rng, arm, _: recommended(rng, arm),
    "h infinity": lambda _, arm, p: sa.laws.h_infinity(arm, bandwidth=p),
}


def recommended(rng: Random, arm: Any) -> Any:
    """Return the recommended controller, for a loop at 1 kHz."""
    loads = {} if isinstance(arm, sa.TwoLink) else {"payload": 2.0}
    residual = bool(rng.random() < 0.5) if isinstance(arm, sa.TwoLink) else False
    options: dict[str, Any] = {"residual": residual, "light_joints": True}
    return sa.recommended(arm, effort_limit=60.0, **loads, **options)


def arms(rng: Random, runs: int) -> tuple[list[Any], Any]:
    """Draw an arm a run, and what is believed of all of them."""
    if rng.random() < 0.5:
        smooth = {"viscous": rng.uniform(0, 1.5, 2), "coulomb": rng.uniform(0, 1.0, 2)}
        smooth["smoothing"] = rng.uniform(0.02, 0.5, 2) * (rng.random() < 0.8)
        rubs: dict[str, Any] = smooth if rng.random() < 0.6 else {}
        common = {"length": (0.5, 0.5), "gravity": float(rng.choice([0.0, 9.81]))}

        def made(mass: float, **friction: Any) -> Any:
            of_links = {"mass": (mass, 0.9 * mass), "inertia": (mass / 20, mass / 20)}
            return sa.TwoLink(**of_links, **common, **friction)

        believed = made(4.0, **(rubs if rng.random() < 0.5 else {}))
        return [made(rng.uniform(3.0, 7.0), **rubs) for _ in range(runs)], believed
    base = sa.Serial.shipped(str(rng.choice(["panda", "ur5e"])))
    base = base if rng.random() < 0.6 else base.without_friction()
    believed = base if rng.random() < 0.5 else base.without_friction()
    return [base.with_payload(float(rng.uniform(0.0, 2.0))) for _ in range(runs)], believed


def effects(rng: Random) -> sa.Effects:
    drawn = some(
        rng,
        0.3,
        encoder_bits=lambda: int(rng.integers(12, 22)),
        velocity=lambda: str(rng.choice(["measured", "tracking", "kalman"])),
        noise=lambda: 1e-5,
        delay=lambda: int(rng.integers(0, 3)),
        drop=lambda: 0.1,
        lag=lambda: float(rng.uniform(0.5, 5.0)) * 1e-3,
        gain=lambda: 0.95,
        jitter=lambda: 0.1,
    )
    if drawn.get("velocity") == "kalman":  # which filters noise
        drawn.setdefault("noise", 1e-5)
    return sa.Effects(**drawn, seed=int(rng.integers(99)))


def before_laws(rng: Random, trackers: list[Any]) -> list[Any]:
    """Put before all laws what one sampled loop may have there, with a rate of its own in each."""
    rates: dict[str, Callable[[], Any]] = {
        "hand_over": lambda: float(rng.uniform(2.0, 20.0)),
        "velocity_filter": lambda: float(rng.uniform(150.0, 400.0)),
        "bumpless": lambda: float(rng.uniform(5.0, 50.0)),
        "effort_rate_limit": lambda: float(rng.uniform(200.0, 2e4)),
    }
    names = [name for name in rates if rng.random() < 0.2]
    delay = int(rng.choice([0, 0, 1, 2]))
    return [
        tracker.__replace__(delay=delay, **{name: rates[name]() for name in names})
        for tracker in trackers
    ]


@pytest.mark.filterwarnings("ignore::steadyarm.DesignWarning")
@pytest.mark.parametrize("scene", range(SCENES))
def test_runs_of_a_scene_drawn_at_random_are_those_of_simulate(scene: int) -> None:
    rng = np.random.default_rng([SEED, scene])
    count = int(rng.choice([8, 9]))
    plants, believed = arms(rng, count)
    joints = believed.joints
    law, bandwidth = str(rng.choice(list(LAWS))), rng.uniform(5.0, 15.0)
    # All alike, or each with other gains, and perhaps with what stands in the way of lanes.
    drawn = [LAWS[law](rng, believed, bandwidth)]
    if rng.random() < 0.3 and law != "recommended":
        drawn = [LAWS[law](rng, believed, rng.uniform(5.0, 15.0)) for _ in range(count)]
    if rng.random() < 0.3:
        limit = float(rng.uniform(20.0, 90.0))
        drawn = [tracker.__replace__(effort_limit=limit) for tracker in drawn]
    one = {"frequency": [float(rng.uniform(1.0, 4.0))], "sin": [[0.2] * joints]}
    path = sa.Sines(**one, cos=[[0.0] * joints], offset=POSE[:joints])
    push = sa.Sines(frequency=[2.0], sin=[[0.5] * joints], cos=[[0.1] * joints])
    pushed = [sa.Plant(arm, disturbance=push if rng.random() < 0.9 else None) for arm in plants]
    sampled = rng.random() < 0.6 or law == "recommended"
    options: dict[str, Any] = {"control_period": None}
    through: list[sa.Effects | None] = [None] * count
    if sampled:
        periods = [1.0] if law == "recommended" else [1.0, 2.0, 4.0]
        options["control_period"] = float(rng.choice(periods)) * 1e-3
        drawn = before_laws(rng, drawn)
        one_for_all = [effects(rng) if rng.random() < 0.5 else None] * count
        each = [effects(rng) if rng.random() < 0.5 else None for _ in range(count)]
        through = each if rng.random() < 0.3 else one_for_all
    trackers = drawn * count if len(drawn) == 1 else drawn
    timing = float(rng.choice([0.05, 0.1, 0.155])), 1e-3
    q0 = np.array(POSE[:joints]) + rng.uniform(-0.1, 0.1, (count, joints))
    several = {"q0": q0, "effects": through, "progress": False}
    many = sa.simulate_many(pushed, trackers, path, *timing, **several, **options)
    for run, (plant, tracker) in enumerate(zip(pushed, trackers, strict=True)):
        own = {"q0": q0[run], "effects": through[run]}
        alone = sa.simulate(plant, tracker, path, *timing, **own, **options)
        figures = alone.metrics()
        assert many.status[run].kind == alone.status.kind, (law, run)
        for name in FIGURES:
            found, wanted = getattr(many, name)[run], getattr(figures, name)
            np.testing.assert_array_equal(found, wanted, err_msg=f"{law}, run {run}: {name}")
