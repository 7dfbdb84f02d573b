"""Continuous joints from Python: the kind goes everywhere, the error is taken around the circle."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa

TAU = 2 * np.pi
LINK = """<link name="{name}"><inertial><origin xyz="0.1 0 0.2"/><mass value="2"/>
<inertia ixx="0.3" iyy="0.2" izz="0.25" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="0 0 0.4"/><axis xyz="{axis}"/>
<limit lower="-1" upper="2" effort="50" velocity="4"/></joint>"""


def urdf(*kinds: str) -> str:
    """A column about the vertical, and one joint after another on it."""
    parts = ['<link name="l0"/>']
    for k, kind in enumerate(kinds):
        axis = "0 0 1" if k == 0 else "0 1 0"
        parts.append(LINK.format(name=f"l{k + 1}"))
        ends = {"parent": f"l{k}", "child": f"l{k + 1}"}
        parts.append(JOINT.format(name=f"j{k}", kind=kind, axis=axis, **ends))
    return f'<robot name="column">{"".join(parts)}</robot>'


def endless() -> sa.Serial:
    return sa.Serial.from_urdf(urdf("continuous", "continuous"))


def tracker(arm: sa.Serial, **options: Any) -> sa.ComputedTorque:
    basis = sa.FuzzyBasis("grid", (-1.5, -0.5, 0.0, 0.5, 1.5), 0.7)
    options = {"gain": 70.0, "leak_rate": 0.05, "projection_radius": 2.0} | options
    return sa.ComputedTorque(arm, 8, 5.5, sa.FuzzyCompensator(basis, **options))


KINDS = ("continuous", "revolute", "prismatic")


def test_the_kinds_of_the_joints_are_those_of_the_file() -> None:
    arm = sa.Serial.from_urdf(urdf(*KINDS))
    assert arm.joint_kinds == KINDS
    assert arm.limits["lower"][0] == -np.inf
    assert arm.limits["lower"][1] == -1.0
    assert sa.paper.nominal().joint_kinds == ("revolute", "revolute")
    assert sa.Serial.shipped("ur5e").joint_kinds == ("revolute",) * 6


def test_the_kind_stays_with_the_arm(tmp_path: Path) -> None:
    arm = sa.Serial.from_urdf(urdf(*KINDS))
    path = tmp_path / "arm.toml"
    path.write_text(arm.to_toml())
    others = [
        sa.Serial.from_toml(arm.to_toml()),
        sa.Serial.from_toml(path),
        pickle.loads(pickle.dumps(arm)),
        arm.with_payload(1.0),
        arm.perturb(3),
        arm.without_friction(),
        arm.with_stops(1e3),
        arm.with_payload(0.5).perturb(1).with_stops(1e3).without_friction(),
    ]
    for other in others:
        assert other.joint_kinds == KINDS
        again = pickle.loads(pickle.dumps(other))
        assert again.joint_kinds == KINDS
        assert again.to_toml() == other.to_toml()
    controller = pickle.loads(pickle.dumps(tracker(endless())))
    assert controller.arm.joint_kinds == ("continuous", "continuous")


def test_a_file_from_before_has_revolute_joints() -> None:
    """Such a file calls a joint without ends revolute: its error is what it was."""
    old = endless().to_toml().replace('"continuous"', '"revolute"')
    arm = sa.Serial.from_toml(old)
    assert arm.joint_kinds == ("revolute", "revolute")
    zero = np.zeros(2)
    near, far = (
        tracker(arm).step(q, zero, zero, zero, zero, 1e-3) for q in (zero, np.array([TAU, 0]))
    )
    assert np.abs(near - far).max() > 10.0


def test_a_table_may_have_continuous_joints() -> None:
    table: dict[str, Any] = {"a": [0.3, 0.2], "alpha": 0, "d": 0, "mass": 1.0, "inertia": 0.1}
    arm = sa.Serial.from_dh(**table, kind=["continuous", "revolute"])
    assert arm.joint_kinds == ("continuous", "revolute")
    assert sa.Serial.from_dh(**table, kind="continuous").joint_kinds == ("continuous",) * 2
    wanted = r'wants "revolute" or "continuous" or "prismatic"'
    with pytest.raises(ValueError, match=wanted):
        sa.Serial.from_dh(**table, kind="planar")


def test_a_continuous_joint_has_no_ends() -> None:
    text = endless().to_toml()
    limits = "limits = { velocity"
    assert text.count(limits) == 2
    bounded = text.replace(limits, "limits = { lower = -1.0, velocity", 1)
    with pytest.raises(ValueError, match=r"limits\.lower: got -1, wants none"):
        sa.Serial.from_toml(bounded)


@pytest.mark.parametrize("turns", [1, -1, 2])
def test_a_jump_of_an_encoder_changes_no_bit_of_the_torque(turns: int) -> None:
    """Multiples of 2⁻⁴⁰ take turns without rounding; no entry of M and H has the column's q."""
    one, other = tracker(endless()), tracker(endless())
    random = np.random.default_rng(0)
    for k in range(100):
        q, q_d, dq = np.round(random.uniform(-1, 1, (3, 2)) * 2.0**40) / 2.0**40
        seen = q + np.array([turns * TAU, 0]) if k > 20 else q
        taus = [
            each.step(at, dq, q_d, 0 * q_d, 0 * q_d, 1e-3) for each, at in ((one, q), (other, seen))
        ]
        assert taus[0].tobytes() == taus[1].tobytes(), k
    # What is pending has q as it was read; to freeze ends it.
    one.freeze()
    other.freeze()
    assert one.__getstate__() == other.__getstate__()


@pytest.mark.parametrize("name", ["e", "q"])
def test_inputs_of_e_are_around_the_circle_and_those_of_q_as_they_are(name: str) -> None:
    """ρ̂ from frozen weights over one signal, here and a turn on."""
    basis = sa.FuzzyBasis("concat", (-1.0, 0.0, 1.0), 1.0, False, [name])
    controller = sa.ComputedTorque(endless(), 8, 5.5, sa.FuzzyCompensator(basis))
    controller.weights = np.arange(12.0).reshape(2, 6)
    controller.freeze()
    zero, estimates = np.zeros(2), []
    for turn in (0.0, TAU):
        controller.step(np.array([0.5 + turn, 0.25]), zero, zero, zero, zero, 1e-3)
        estimates.append(controller.rho_hat)
    assert np.allclose(*estimates, rtol=0, atol=1e-13) == (name == "e")


def turning(wrapped: bool) -> Any:
    def reference(t: float) -> Any:
        angle = 2.0 * t
        if wrapped:
            angle -= TAU * np.floor((angle + np.pi) / TAU)
        return np.full(2, angle), np.full(2, 2.0), np.zeros(2)

    return reference


@pytest.mark.parametrize("options", [{}, {"method": "dp54"}, {"control_period": 0.01}], ids=str)
def test_every_loop_and_record_has_the_error_around_the_circle(
    options: dict[str, Any], tmp_path: Path
) -> None:
    plant, start = sa.Plant(endless().with_payload(0.5)), {"q0": (0.4, -0.3), "dq0": (2.0, 2.0)}
    settings: dict[str, Any] = {"duration": 8.0, "dt": 0.01} | start | options
    runs = [
        sa.simulate(plant, tracker(endless()), turning(wrapped), **settings)
        for wrapped in (False, True)
    ]
    assert runs[0].status.finished
    assert runs[1].status.finished
    np.testing.assert_allclose(runs[0].e, runs[1].e, rtol=0, atol=1e-6)
    assert np.abs(runs[1].e).max() < 0.8
    assert runs[1].q[-1, 0] > 15
    # The record of the motion works e out by the same rule, and so does its metrics.
    motion = sa.simulate(plant, tracker(endless()), turning(True), record="motion", **settings)
    if options.get("method") != "dp54":
        assert motion.e.tobytes() == runs[1].e.tobytes()
    assert np.abs(motion.e).max() < 0.8
    assert motion.metrics().max_abs_e.max() < 0.8
    motion.save(tmp_path / "run")
    assert sa.Run.load(tmp_path / "run").e.tobytes() == motion.e.tobytes()
    assert pickle.loads(pickle.dumps(motion)).e.tobytes() == motion.e.tobytes()


def test_the_nominal_arm_says_which_joints_wrap() -> None:
    """The plant's joints are revolute, the model's are not: the controller sees no turn."""
    bounded = sa.Serial.from_toml(endless().to_toml().replace('"continuous"', '"revolute"'))
    rest = sa.Quintic([0.1, 0.2], [0.1, 0.2], 1.0)
    options: dict[str, Any] = {"duration": 0.1, "dt": 0.01, "q0": (0.1 + TAU, 0.2)}
    run = sa.simulate(sa.Plant(bounded), tracker(endless()), rest, **options)
    assert np.abs(run.e).max() < 1e-12
    run = sa.simulate(sa.Plant(endless()), tracker(bounded), rest, **options)
    assert run.e[0, 0] == pytest.approx(TAU)
