"""`Serial` from Python: sources, identities, output arrays, refusals."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from test_joints import EACH, arm

URDF = """<robot name="pendulum">
  <link name="base"/>
  <link name="rod">
    <inertial>
      <origin xyz="0 0 -0.5"/>
      <mass value="2"/>
      <inertia ixx="0.2" iyy="0.2" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="base"/>
    <child link="rod"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="30" velocity="4"/>
    <dynamics damping="0.5" friction="0.1"/>
  </joint>
</robot>
"""
SHIPPED = ("panda", "puma560", "ur5e")


def motion(joints: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(4, joints))


@pytest.mark.parametrize("joints", EACH)
def test_identities_of_the_dynamics(joints: int) -> None:
    chain = arm(joints)
    q, dq, ddq, dq_r = motion(joints, joints)
    mass = chain.mass_matrix(q)
    scale = np.abs(mass).max()
    assert chain.joints == joints
    assert np.linalg.eigvalsh(mass).min() > 0
    np.testing.assert_allclose(mass, mass.T, rtol=0, atol=1e-14 * scale)
    tau = chain.inverse_dynamics(q, dq, ddq)
    np.testing.assert_allclose(tau, mass @ ddq + chain.bias(q, dq), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(chain.forward_dynamics(q, dq, tau), ddq, rtol=1e-10, atol=1e-10)
    bias = chain.coriolis(q, dq) @ dq + chain.gravity(q) + chain.friction(dq)
    np.testing.assert_allclose(chain.bias(q, dq), bias, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(
        chain.slotine_li(q, dq, dq_r, ddq),
        mass @ ddq + chain.coriolis(q, dq) @ dq_r + chain.gravity(q),
        rtol=1e-12,
        atol=1e-12,
    )
    rigid = tau - chain.friction(dq) - 0.05 * ddq
    y = chain.regressor(q, dq, ddq)
    assert y.shape == (joints, 10 * joints)
    np.testing.assert_allclose(y @ chain.inertial_parameters(), rigid, rtol=1e-11, atol=1e-11)
    assert chain.kinetic_energy(q, dq) == pytest.approx(0.5 * dq @ mass @ dq, rel=1e-13)


@pytest.mark.parametrize("joints", EACH)
def test_derivatives_of_pose_and_energy(joints: int) -> None:
    """Central differences over 1e-6: about 1e-12 off by truncation, 1e-10 by rounding."""
    chain = arm(joints)
    q = motion(joints, joints)[0]
    jacobian, gravity = chain.jacobian(q), chain.gravity(q)
    assert jacobian.shape == (6, joints)
    rotation = chain.pose(q)[:3, :3]
    for n, step in enumerate(1e-6 * np.eye(joints)):
        slope = (chain.pose(q + step) - chain.pose(q - step)) / 2e-6
        np.testing.assert_allclose(jacobian[:3, n], slope[:3, 3], rtol=0, atol=1e-8)
        spin = slope[:3, :3] @ rotation.T
        turning = (spin[2, 1], spin[0, 2], spin[1, 0])
        np.testing.assert_allclose(jacobian[3:, n], turning, rtol=0, atol=1e-8)
        energy = (chain.potential_energy(q + step) - chain.potential_energy(q - step)) / 2e-6
        np.testing.assert_allclose(gravity[n], energy, rtol=0, atol=1e-7)
    poses = chain.link_poses(q)
    assert poses.shape == (joints, 4, 4)
    assert np.array_equal(poses[:, 3], np.tile((0, 0, 0, 1), (joints, 1)))
    np.testing.assert_allclose(
        poses[:, :3, :3] @ poses[:, :3, :3].transpose(0, 2, 1),
        np.tile(np.eye(3), (joints, 1, 1)),
        atol=1e-14,
    )


def test_pendulum_from_urdf(tmp_path: Path) -> None:
    path = tmp_path / "pendulum.urdf"
    path.write_text(URDF)
    for source in (URDF, "\ufeff \n" + URDF, path, str(path)):
        rod = sa.Serial.from_urdf(source)
        assert (rod.joints, rod.name) == (1, "pendulum")
        assert (rod.joint_names, rod.link_names) == (["hinge"], ["rod"])
        limits = {name: values.tolist() for name, values in rod.limits.items()}
        assert limits == {"lower": [-1], "upper": [2], "velocity": [4], "effort": [30]}
        # 2 kg half a metre below a horizontal axis: I = 0.2 + 2 · 0.25.
        np.testing.assert_allclose(rod.mass_matrix([0.3]), [[0.7]], rtol=1e-14)
        torque = rod.inverse_dynamics([0.3], [0.0], [0.0])
        np.testing.assert_allclose(torque, [2 * 9.81 * 0.5 * np.sin(0.3)], rtol=1e-13)
        np.testing.assert_allclose(rod.friction([2.0]), [1.1], rtol=1e-12)
        assert np.array_equal(rod.without_friction().friction([2.0]), [0.0])
    still = sa.Serial.from_urdf(URDF, base="base", tip="rod", gravity=(0, 0, 0))
    assert np.array_equal(still.gravity([1.0]), [0.0])


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_arms_survive_toml_and_pickle(name: str, tmp_path: Path) -> None:
    robot = sa.Serial.shipped(name)
    n = robot.joints
    assert len(robot.joint_names) == n
    q, dq, ddq, _ = motion(n)
    tau = robot.inverse_dynamics(q, dq, ddq).tobytes()
    path = tmp_path / "arm.toml"
    path.write_text(robot.to_toml())
    loaded = robot.with_payload(0.7, (0.01, 0.02, 0.03), 1e-3).perturb(3)
    for source in (robot.to_toml(), path, str(path)):
        assert sa.Serial.from_toml(source).inverse_dynamics(q, dq, ddq).tobytes() == tau
    for original in (robot, loaded):
        copy = pickle.loads(pickle.dumps(original))
        assert copy.to_toml() == original.to_toml()
        assert repr(copy) == repr(original)
        left, right = (it.inverse_dynamics(q, dq, ddq) for it in (original, copy))
        assert left.tobytes() == right.tobytes()
    controller = sa.ComputedTorque(robot, 64, 16)
    assert controller.arm.joints == n
    again = pickle.loads(pickle.dumps(controller))
    sample = (q, dq, q, dq, ddq, 1e-3)
    assert again.step(*sample).tobytes() == controller.step(*sample).tobytes()


def test_a_joint_stops_at_the_end_of_its_range() -> None:
    rod = sa.Serial.from_urdf(URDF)
    stopped = rod.with_stops(1e4, dissipation=2.0)
    # -1 to 2 rad; k δ (1 + c dδ/dt) beyond
    np.testing.assert_allclose(stopped.stops([2.01], [0.5]), [200.0], rtol=1e-12)
    np.testing.assert_allclose(stopped.stops([-1.01], [0.25]), [-50.0], rtol=1e-12)
    assert [stopped.stops([q], [3.0])[0] for q in (-1.0, 0.0, 2.0)] == [0.0] * 3
    assert np.array_equal(stopped.bias([2.01], [0.5]), rod.bias([2.01], [0.5]))
    tau = stopped.inverse_dynamics([2.01], [0.5], [1.0])
    np.testing.assert_allclose(tau - rod.inverse_dynamics([2.01], [0.5], [1.0]), [200.0])
    np.testing.assert_allclose(stopped.forward_dynamics([2.01], [0.5], tau), [1.0])
    assert "stop = { stiffness = 10000.0, dissipation = 2.0 }" in stopped.to_toml()
    assert pickle.loads(pickle.dumps(stopped)).to_toml() == stopped.to_toml()
    assert stopped.with_stops(0, 0).to_toml() == rod.to_toml()

    # A controller that knows nothing of the stop asks for 2.5 rad, and pushes.
    tracker = sa.ComputedTorque(rod, kp=100, kv=20)
    there = sa.Quintic(0.0, 2.5, duration=1.0)
    runs = {
        method: sa.simulate(sa.Plant(stopped), tracker, there, 4.0, method=method)
        for method in ("rk4", "dp54")
    }
    for run in runs.values():
        assert run.status.finished
        push = run.tau[-1, 0] - stopped.bias(run.q[-1], run.dq[-1])[0]
        assert push > 10.0
        np.testing.assert_allclose(run.q[-1, 0], 2.0 + push / 1e4, rtol=0, atol=1e-6)
        assert run.q.max() < 2.05
    np.testing.assert_allclose(runs["rk4"].q[-1], runs["dp54"].q[-1], rtol=0, atol=1e-6)
    beyond = sa.simulate(sa.Plant(rod), tracker, there, 4.0)
    np.testing.assert_allclose(beyond.q[-1], [2.5], rtol=0, atol=1e-3)


def test_stops_that_make_no_sense_are_refused() -> None:
    robot = sa.Serial.shipped("panda")
    for arguments, message in (
        ((-1.0,), r"stiffness\[0\]: got -1, wants a number >= 0"),
        ((np.inf,), r"stiffness\[0\]: got inf"),
        ((1e4, [1, 1, 1, -2, 1, 1, 1]), r"dissipation\[3\]: got -2, wants a number >= 0"),
        (([1e4, 1e4],), r"stiffness: got shape \(2,\), wants a scalar or \(7,\)"),
    ):
        with pytest.raises(ValueError, match=message):
            robot.with_stops(*arguments)
    with pytest.raises(TypeError, match="stiffness: got str"):
        robot.with_stops("hard")
    endless = sa.Serial.from_dh(a=[0.5, 0.5], alpha=0, d=0, mass=1.0)
    with pytest.raises(ValueError, match="stiffness: got 10000 for an arm whose joints have no"):
        endless.with_stops(1e4)
    assert endless.with_stops(0, 0).to_toml() == endless.to_toml()


def test_every_joint_has_its_own_stop() -> None:
    panda = sa.Serial.shipped("panda")
    stiffness, dissipation = np.linspace(1e3, 7e3, 7), np.linspace(0, 1.2, 7)
    stopped = panda.with_stops(stiffness, dissipation)
    lower, upper, speed = panda.limits["lower"], panda.limits["upper"], np.full(7, 0.5)
    above = stiffness * 0.01 * (1 + dissipation * speed)
    np.testing.assert_allclose(stopped.stops(upper + 0.01, speed), above, rtol=1e-12)
    np.testing.assert_allclose(stopped.stops(lower - 0.01, -speed), -above, rtol=1e-12)
    inside = stopped.stops((lower + upper) / 2, speed)
    assert np.array_equal(inside, np.zeros(7))
    for changed in (stopped.with_payload(1.0), stopped.perturb(1), stopped.without_friction()):
        np.testing.assert_allclose(changed.stops(upper + 0.01, speed), above, rtol=1e-12)


def test_payload_adds_its_weight_and_inertia() -> None:
    chain = arm(3)
    loaded = chain.with_payload(2.0, com=(0.1, 0, 0), inertia=(0.01, 0.02, 0.02))
    q, dq, _, _ = motion(3)
    tip = chain.jacobian(q)
    lever = chain.pose(q)[:3, :3] @ (0.1, 0, 0)
    at_com = tip[:3] + np.cross(tip[3:].T, lever).T
    moments = chain.pose(q)[:3, :3] @ np.diag((0.01, 0.02, 0.02)) @ chain.pose(q)[:3, :3].T
    added = 2.0 * at_com.T @ at_com + tip[3:].T @ moments @ tip[3:]
    np.testing.assert_allclose(
        loaded.mass_matrix(q), chain.mass_matrix(q) + added, rtol=1e-12, atol=1e-12
    )
    np.testing.assert_allclose(
        loaded.gravity(q), chain.gravity(q) + 2.0 * 9.81 * at_com[2], rtol=1e-12, atol=1e-12
    )
    matrix = chain.with_payload(2.0, (0.1, 0, 0), np.diag((0.01, 0.02, 0.02)))
    assert matrix.to_toml() == loaded.to_toml()
    assert np.array_equal(loaded.friction(dq), chain.friction(dq))


def test_perturbed_arm_depends_on_the_seed_alone() -> None:
    chain = arm(4)
    q = motion(4)[0]
    assert chain.perturb(1).to_toml() == chain.perturb(1).to_toml()
    assert chain.perturb(1).to_toml() != chain.perturb(2).to_toml()
    same = chain.perturb(5, mass=0, com=0, inertia=0, friction=0)
    assert same.mass_matrix(q).tobytes() == chain.mass_matrix(q).tobytes()
    ratio = chain.perturb(9, mass=0.2).inertial_parameters() / chain.inertial_parameters()
    masses = ratio.reshape(4, 10)[:, 0]
    assert ((masses >= 0.8) & (masses <= 1.2) & (masses != 1.0)).all()


@pytest.mark.parametrize("joints", EACH)
def test_out_is_written_and_returned(joints: int) -> None:
    chain = arm(joints)
    q, dq, ddq, _ = motion(joints)
    for method in (chain.inverse_dynamics, chain.forward_dynamics):
        expected = method(q, dq, ddq)
        spread = np.full(3 * joints, 7.0)
        for out in (np.empty(joints), spread[::3]):
            assert method(q, dq, ddq, out=out) is out
            assert out.tobytes() == expected.tobytes()
        assert (np.delete(spread, np.s_[::3]) == 7.0).all()
        own = ddq.copy()
        assert method(q, dq, own, own) is own
        assert own.tobytes() == expected.tobytes()


@pytest.mark.parametrize("change", ["lists", "strided", "float32", "integers", "read-only"])
def test_arguments_may_be_any_real_array(change: str) -> None:
    chain = arm(3)
    whole = np.array([1.0, -2.0, 3.0])
    other: Any = {
        "lists": whole.tolist(),
        "strided": np.repeat(whole, 2)[::2],
        "float32": whole.astype("f4"),
        "integers": whole.astype("i8"),
        "read-only": np.frombuffer(whole.tobytes()),
    }[change]
    expected = chain.inverse_dynamics(whole, whole, whole)
    assert chain.inverse_dynamics(other, other, other).tobytes() == expected.tobytes()


def frozen() -> np.ndarray:
    array = np.zeros(3)
    array.flags.writeable = False
    return array


def dynamics(**change: Any) -> np.ndarray:
    zero = dict.fromkeys(("q", "dq", "ddq"), np.zeros(3))
    return arm(3).inverse_dynamics(**(zero | change))


CASES: list[tuple[type[Exception], str, Callable[[], object]]] = [
    (ValueError, "q: got shape (2,), wants (3,)", lambda: dynamics(q=np.zeros(2))),
    (ValueError, "dq[1]: got NaN, wants", lambda: dynamics(dq=(0, float("nan"), 0))),
    (TypeError, "ddq: got str, wants real numbers", lambda: dynamics(ddq="x")),
    (ValueError, "out: got shape (2,), wants (3,)", lambda: dynamics(out=np.zeros(2))),
    (TypeError, "out: got list, wants a float64", lambda: dynamics(out=[0, 0, 0])),
    (TypeError, "out: got ndarray, wants a float64", lambda: dynamics(out=np.zeros(3, "f4"))),
    (TypeError, "out: got ndarray, wants a float64", lambda: dynamics(out=np.zeros((3, 1)))),
    (ValueError, "out: got one that is read-only", lambda: dynamics(out=frozen())),
    (TypeError, "path_or_text: got int, wants a path", lambda: sa.Serial.from_urdf(3)),
    (FileNotFoundError, "[Errno 2]", lambda: sa.Serial.from_urdf("no/such.urdf")),
    (FileNotFoundError, "[Errno 2]", lambda: sa.Serial.from_toml("no/such.toml")),
    (ValueError, "line 3: ", lambda: sa.Serial.from_urdf(URDF.replace("rod", "base", 1))),
    (ValueError, "", lambda: sa.Serial.from_urdf(URDF, tip="nothing")),
    (
        ValueError,
        "gravity: got shape (2,), wants (3,)",
        lambda: sa.Serial.from_urdf(URDF, gravity=(0, 0)),
    ),
    (ValueError, 'shipped arm: got "c3po", wants', lambda: sa.Serial.shipped("c3po")),
    (ValueError, "", lambda: sa.Serial.from_toml("format = 1\nnonsense\n")),
    (ValueError, "mass: got -1", lambda: arm(3).with_payload(-1)),
    (
        ValueError,
        "inertia: got shape (2,), wants a sc",
        lambda: arm(3).with_payload(1, inertia=(1, 1)),
    ),
    (ValueError, "com: got shape (), wants (3,)", lambda: arm(3).with_payload(1, com=1)),
    (ValueError, "mass: got 1, wants", lambda: arm(3).perturb(1, mass=1)),
    (TypeError, "seed: got str, wants a whole number", lambda: arm(3).perturb("1")),
    (ValueError, "seed: got -1, wants a whole number", lambda: arm(3).perturb(-1)),
    (ValueError, "mass: got shape (2,), wants a scalar or (3,)", lambda: arm(3, mass=(1, 1))),
    (ValueError, "com: got shape (3,), wants a scalar or (3, 3)", lambda: arm(3, com=(1, 1, 1))),
    (
        ValueError,
        "inertia: got shape (3,), wants a scalar or (3, 3) or (3, 3, 3)",
        lambda: arm(3, inertia=(1, 1, 1)),
    ),
    (ValueError, 'convention: got "craig", wants', lambda: arm(3, convention="craig")),
    (ValueError, 'kind: got "ball", wants', lambda: arm(3, kind="ball")),
    (ValueError, "kind: got 2 words, wants one, or one", lambda: arm(3, kind=["revolute"] * 2)),
]


@pytest.mark.parametrize(("kind", "message", "call"), CASES, ids=range(len(CASES)))
def test_message_names_argument_value_and_wish(kind: Any, message: str, call: Any) -> None:
    with pytest.raises(kind, match=f"^{re.escape(message)}") as caught:
        call()
    assert str(caught.value)


def test_prismatic_joint_slides() -> None:
    lift = sa.Serial.from_dh(0, 0, [0.2], kind=["prismatic"], mass=3, convention="modified")
    np.testing.assert_allclose(lift.gravity([0.4]), [3 * 9.81], rtol=1e-14)
    np.testing.assert_allclose(lift.pose([0.4])[:3, 3], (0, 0, 0.6), atol=1e-15)
    np.testing.assert_allclose(lift.jacobian([0.4])[:, 0], (0, 0, 1, 0, 0, 0), atol=1e-15)
