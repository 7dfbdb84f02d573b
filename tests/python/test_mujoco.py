"""MuJoCo, a simulator that none of us wrote, against ours, and as the world of our controllers."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import steadyarm as sa

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("pinocchio")

EXAMPLE = Path(__file__).parents[2] / "examples" / "mujoco_payload.py"

ACCELERATION_TOL = 1e-9
"""Relative: the same equations, in double precision."""

MOTION_TOL = 1e-4
"""After 2 s [rad]. MuJoCo takes its RK4 steps with the torque held, as ours does."""


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("mujoco_payload", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def urdf(example):
    return example.bare(example.panda(), example.PANDA["base"], example.PANDA["tip"])


def inside(arm, random):
    """Return joint angles within the limits, which MuJoCo enforces."""
    lower, upper = arm.limits["lower"], arm.limits["upper"]
    return lower + random.uniform(0.05, 0.95, arm.joints) * (upper - lower)


def test_acceleration_agrees_with_mujoco(example, urdf):
    arm = sa.Serial.from_urdf(urdf, tip=example.PANDA["tip"]).without_friction()
    world = example.World(urdf, example.PANDA["tip"])
    random = np.random.default_rng(2)
    for _ in range(100):
        q, dq, tau = inside(arm, random), *random.uniform(-1.5, 1.5, (2, 7))
        world.start(q)
        world.data.qvel[:], world.data.qfrc_applied[:] = dq, tau
        mujoco.mj_forward(world.model, world.data)
        theirs = world.data.qacc
        error = np.abs(arm.forward_dynamics(q, dq, tau) - theirs).max()
        assert error <= ACCELERATION_TOL * np.abs(theirs).max()


def test_payload_in_mujoco_is_that_of_with_payload(example, urdf):
    tip, ball = example.PANDA["tip"], 0.4 * 2.0 * 0.05**2
    arm = sa.Serial.from_urdf(urdf, tip=tip).without_friction()
    arm = arm.with_payload(2.0, com=(0, 0, 0), inertia=ball)
    world = example.World(urdf, tip, payload=2.0)
    random = np.random.default_rng(3)
    for _ in range(20):
        q, dq, tau = inside(arm, random), *random.uniform(-1.5, 1.5, (2, 7))
        world.start(q)
        world.data.qvel[:], world.data.qfrc_applied[:] = dq, tau
        mujoco.mj_forward(world.model, world.data)
        theirs = world.data.qacc
        error = np.abs(arm.forward_dynamics(q, dq, tau) - theirs).max()
        assert error <= 1e-7 * np.abs(theirs).max()


def test_our_simulation_moves_as_mujoco_does(example, urdf):
    tip, middle = example.PANDA["tip"], np.array(example.PANDA["middle"])
    arm = sa.Serial.from_urdf(urdf, tip=tip).without_friction()
    motion = example.sine(middle)
    q0 = middle + 0.05

    def tracker():
        return sa.ComputedTorque(arm, kp=100.0, kv=20.0)

    world, control = example.World(urdf, tip), tracker()
    world.start(q0)
    for k in range(2000):
        q, dq = world.data.qpos.copy(), world.data.qvel.copy()
        world.step(control.step(q, dq, *motion(k * 1e-3), 1e-3))
    run = sa.simulate(
        sa.Plant(arm), tracker(), motion, 2.0, 1e-3, "rk4", control_period=1e-3, q0=q0
    )
    assert run.status.finished
    assert np.abs(run.q[-1] - world.data.qpos).max() < MOTION_TOL


@pytest.mark.parametrize("path", ["sine", "point_to_point"])
def test_an_unknown_payload_is_learnt(example, urdf, path):
    tip, middle = example.PANDA["tip"], np.array(example.PANDA["middle"])
    arm, world = example.scene(urdf, tip)
    motion = getattr(example, path)(middle)
    rivals = example.controllers(arm, middle, motion)
    plain, plain_tau = example.track(world, rivals["computed torque"], motion, periods=2)
    fuzzy = rivals["computed torque + fuzzy"]
    learning, tau = example.track(world, fuzzy, motion)
    fuzzy.freeze()
    frozen, _ = example.track(world, fuzzy, motion, periods=1)
    assert example.total(learning) <= example.total(plain) / 5
    assert np.abs(tau).max() <= 1.5 * np.abs(plain_tau).max()
    assert example.total(frozen) <= example.total(plain) / 5
