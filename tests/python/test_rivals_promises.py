"""What is promised for every law through all effects: the same bits, torques within limits."""

import hashlib
from dataclasses import replace

import numpy as np
import pytest
import steadyarm as sa

LIMIT = 9.0
"""Largest torque of the actuators of the scenes [N·m]."""


def scene(duration: float = 1.0) -> sa.Scenario:
    """The paper's plant with noise, jitter, lost samples, gears that give and weak actuators."""
    read = sa.Scenario.read("paper_noisy")
    effects = read.effects.__replace__(
        lag=2e-3, gain=0.95, cogging=0.1, joint_stiffness=1e4, rotor_inertia=0.5, joint_damping=20.0
    )
    plant = sa.Plant(read.plant.arm, read.plant.disturbance, LIMIT)
    options = {**read.options, "duration": duration}
    return replace(read, effects=effects, plant=plant, options=options)


def laws() -> list[str]:
    found = scene()
    return [name for name, law in found.controllers.items() if accepted(found, law)]


def accepted(found: sa.Scenario, law: dict) -> bool:
    try:
        found.controller(law)
    except ValueError:
        return False
    return True


def bits(run: sa.Run) -> str:
    arrays = (run.q, run.dq, run.tau, run.q_measured, run.dq_measured, run.tau_commanded)
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


def test_most_laws_are_looked_at() -> None:
    assert len(laws()) >= 15


@pytest.mark.parametrize("law", laws())
def test_a_seed_gives_the_same_bits_and_another_seed_others(law: str) -> None:
    runs = [scene().simulate(law, seed=seed) for seed in (3, 3, 4)]
    first, again, other = (bits(run) for run in runs)
    assert first == again != other


@pytest.mark.parametrize("law", laws())
def test_torques_are_finite_and_within_the_limit_through_all_effects(law: str) -> None:
    run = scene(duration=4.0).simulate(law, seed=1)
    assert len(run.t) > 1
    for array in (run.tau_commanded, run.tau, run.q, run.dq):
        assert np.isfinite(array).all()
    assert np.abs(run.tau_commanded).max() <= LIMIT
    assert np.abs(run.tau_commanded).max() > 0.0


def sampled(controller: sa.Controller, first: int, count: int) -> np.ndarray:
    """Torques for a fixed motion beside the path, told that a drive cut some of them."""
    random = np.random.default_rng(5)
    noise = random.normal(size=(first + count, 2, 2)) * [[1e-3], [1e-2]]
    torques = []
    for k in range(first, first + count):
        q_d, dq_d, ddq_d = PATH(k * 1e-3)
        cut = {} if not torques else {"applied": np.clip(torques[-1], -4.0, 4.0)}
        q, dq = q_d + 0.01 + noise[k, 0], dq_d + noise[k, 1]
        torques.append(controller.step(q, dq, q_d, dq_d, ddq_d, 1e-3, **cut))
    return np.array(torques)


PATH = sa.Scenario.read("paper_noisy").reference


@pytest.mark.parametrize("law", laws())
def test_a_refused_sample_changes_no_bit(law: str) -> None:
    found = scene()
    controller, twin = (found.controller(found.controllers[law]) for _ in range(2))
    assert sampled(controller, 0, 100).tobytes() == sampled(twin, 0, 100).tobytes()
    before = controller.__getstate__()
    motion = PATH(0.1)
    for bad in (np.nan, np.inf, 1e11):
        for place in range(5):
            given = [motion[0] + 0.01, motion[1], *motion]
            given[place] = np.array([0.1, bad])
            with pytest.raises(ValueError):
                controller.step(*given, 1e-3)
    for dt in (0.0, -1.0, 1e-300, 1e3):
        with pytest.raises(ValueError):
            controller.step(motion[0], motion[1], *motion, dt)
    assert controller.__getstate__() == before
    assert sampled(controller, 100, 100).tobytes() == sampled(twin, 100, 100).tobytes()
