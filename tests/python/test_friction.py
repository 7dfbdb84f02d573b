"""Runs of 1 ms are right where friction is stiff; dry friction sticks; a step too long is told."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import friction_scenes as scenes
import numpy as np
import pytest
import steadyarm as sa
from steadyarm import cli

RIGHT = 5e-5
"""What positions may be off by [rad]; the worst of these is 6e-6, and 8e-5 of all 360 such runs."""

LOOPS: dict[str, dict[str, Any]] = {"continuous": {}, "sampled": {"control_period": 1e-3}}
loops = pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)

ORACLE = scenes.read_oracle()


@pytest.mark.parametrize("number", range(len(scenes.TESTED)), ids=map(str, scenes.TESTED))
def test_real_arms_move_as_the_oracle_says(number: int) -> None:
    """Ten arms with 1 to 10 % of their largest torque as dry friction.

    ``friction_oracle.csv`` holds positions every 0.25 s: the continuous runs by SciPy's Radau
    (rtol 1e-9, atol 1e-11, the law in NumPy), the sampled ones with steps of 50 µs, to which those
    of 100 µs agree to 1e-5 rad (``benches/friction_accuracy.py --oracle``).
    """
    run = scenes.TESTED[number].run()
    rows = np.rint(scenes.ORACLE_TIMES * 1e3).astype(int)
    assert run.status.kind == "finished", run.status
    assert np.allclose(run.t[rows], scenes.ORACLE_TIMES)
    assert np.abs(run.q[-1] - ORACLE[number][-1]).max() < RIGHT
    assert np.abs(run.q[rows] - ORACLE[number]).max() < RIGHT


def test_error_control_follows_stiff_friction() -> None:
    """The Lite 6 with 10 % of friction: explicit steps took a million of them for this."""
    number = next(n for n, scene in enumerate(scenes.TESTED) if str(scene).startswith("lite6, 10"))
    run = scenes.TESTED[number].run(method="dp54")
    rows = np.rint(scenes.ORACLE_TIMES * 1e3).astype(int)
    assert run.status.finished
    assert np.abs(run.q[rows] - ORACLE[number]).max() < 1e-5


def wrist(smoothing: float = 0.01) -> sa.Serial:
    """One joint of 1e-3 kg m² with the friction that the official FR3 file states."""
    arm = sa.Serial.from_dh([0.0], [0.0], [0.0], mass=0.5, inertia=1e-3, gravity=(0, 0, 0))
    return arm.with_friction(viscous=0.003, coulomb=0.2, smoothing=smoothing)


@loops
def test_light_wrist_sticks(loop: dict[str, Any]) -> None:
    """It stays 0.30 rad from its goal. q(3) is Radau's, rtol 1e-9, atol 1e-11."""
    tracker = sa.ComputedTorque(wrist().without_friction(), kp=100, kv=20)
    path = sa.Quintic(start=(0.0,), goal=(0.3,), duration=2.0)
    run = sa.simulate(sa.Plant(wrist()), tracker, path, duration=3.0, **loop)
    assert run.status.finished
    assert run.q[-1, 0] == pytest.approx(0.0032986617608, abs=2e-6)


@loops
def test_comparison_is_not_turned_round(loop: dict[str, Any]) -> None:
    """The compensator helps. RMS [mrad] by RK4 of 10 µs, and by error control (tolerance 1e-8)."""
    arm = sa.Serial.from_dh(
        [0.0], [0.0], [0.0], mass=0.2, com=0.0, inertia=5e-4, coulomb=0.6, viscous=0.3
    )
    centers = [[-0.3, 0, 0.3, 0.6], [-0.6, -0.3, 0, 0.3, 0.6]]
    basis = sa.FuzzyBasis("per_joint", centers, 0.2, inputs="reference")
    adaptive = sa.FuzzyCompensator(basis, q=[400, 40], gain=1e4)
    path = sa.Quintic(0.0, 0.3, 2.0)
    for compensator, right in ((None, 248.829), (adaptive, 243.222)):
        tracker = sa.ComputedTorque(arm.without_friction(), 400, 40, compensator)
        run = sa.simulate(sa.Plant(arm), tracker, path, duration=4.0, **loop)
        assert run.status.finished
        assert 1e3 * run.metrics().rms_e[0] == pytest.approx(right, rel=1e-3)


COULOMB = np.array([2.0, 3.0])
SERIAL = sa.Serial.from_dh(
    [0.5, 0.4],
    [0.0, 0.0],
    [0.0, 0.0],
    mass=[4, 3],
    com=[[-0.2, 0, 0]] * 2,
    inertia=0.1,
    gravity=(0, 0, 0),
)
STICKING = {
    "TwoLink": sa.TwoLink(4, 0.5, 0.2).with_friction(viscous=0.5, coulomb=COULOMB, smoothing=0),
    "Serial": SERIAL.with_friction(viscous=0.5, coulomb=COULOMB, smoothing=0),
    "Serial, Stribeck": SERIAL.with_friction(
        coulomb=COULOMB - 0.5, stribeck=0.5, viscous=0.5, smoothing=0
    ),
}
sticking = pytest.mark.parametrize("arm", STICKING.values(), ids=STICKING)
POSE = np.array([0.3, -0.7])


def pushed(arm: sa.TwoLink | sa.Serial, torque: np.ndarray, loop: dict[str, Any]) -> sa.Run:
    """A second at rest in its set-point, pushed by this torque [N·m]."""
    push = sa.Sines(1.0, sin=(0, 0), offset=-torque)
    believed = sa.TwoLink(4, 0.5, 0.2)
    tracker, held = sa.ComputedTorque(believed, 1, 1), sa.Sines(1.0, sin=(0, 0), offset=POSE)
    return sa.simulate(sa.Plant(arm, push), tracker, held, duration=1.0, q0=POSE, **loop)


@loops
@sticking
@pytest.mark.parametrize("share", [0.5, -0.999])
def test_dry_friction_sticks_below_its_torque(
    arm: sa.TwoLink | sa.Serial, share: float, loop: dict[str, Any]
) -> None:
    """Not by one bit do joints move that are pushed by less than what breaking away takes."""
    run = pushed(arm, share * COULOMB, loop)
    assert run.status.finished
    assert np.array_equal(run.q, np.broadcast_to(POSE, run.q.shape))
    assert not run.dq.any()


@loops
@sticking
@pytest.mark.parametrize("sign", [1, -1])
def test_dry_friction_breaks_away_above_its_torque(
    arm: sa.TwoLink | sa.Serial, sign: int, loop: dict[str, Any]
) -> None:
    """Joint 2, pushed by a thousandth more, does; joint 1 is held by its friction."""
    run = pushed(arm, sign * np.array([0.5, 1.001]) * COULOMB, loop)
    assert run.status.finished
    assert sign * (run.q[-1, 1] - POSE[1]) > 1e-5
    assert np.all(run.q[:, 0] == POSE[0])


@sticking
def test_dry_friction_sticks_in_plant_step(arm: sa.TwoLink | sa.Serial) -> None:
    plant, q, dq = sa.Plant(arm), POSE, np.zeros(2)
    for step in range(1000):
        q, dq = plant.step(q, dq, 0.999 * COULOMB, step * 1e-3, 1e-3)
    assert np.array_equal(q, POSE)
    assert not dq.any()
    q, dq = plant.step(q, dq, 1.001 * COULOMB, 1.0, 1e-3)
    assert dq.any()


def test_friction_holds_an_arm_against_gravity() -> None:
    """A Panda without motors, whose joints' friction exceeds what its weight asks of them."""
    arm, q, dq = sa.Serial.shipped("panda"), np.array(scenes.ARMS["panda"].pose), np.zeros(7)
    weight = np.abs(arm.gravity(q))
    held = sa.Plant(arm.with_friction(coulomb=1.01 * weight + 0.1, smoothing=0))
    falls = sa.Plant(arm.with_friction(coulomb=0.9 * weight, smoothing=0))
    for step in range(100):
        q, dq = held.step(q, dq, np.zeros(7), step * 1e-3, 1e-3)
    assert np.array_equal(q, scenes.ARMS["panda"].pose)
    assert not dq.any()
    assert falls.step(q, dq, np.zeros(7), 0.0, 1e-3)[1].any()


@sticking
def test_pickle_keeps_dry_friction(arm: sa.TwoLink | sa.Serial) -> None:
    again = pickle.loads(pickle.dumps(arm))
    rows = [pushed(a, 0.9 * COULOMB, {}).q for a in (arm, again)]
    assert np.array_equal(rows[0], rows[1])
    assert np.array_equal(rows[1][-1], POSE)


def test_toml_keeps_dry_friction() -> None:
    arm = STICKING["Serial, Stribeck"]
    assert isinstance(arm, sa.Serial)
    again = sa.Serial.from_toml(arm.to_toml())
    assert again.to_toml() == arm.to_toml()
    assert np.array_equal(pushed(again, 0.9 * COULOMB, {}).q[-1], POSE)


def test_smooth_friction_creeps() -> None:
    """Half the Coulomb torque: smoothing · atanh(½) = 5.5 mrad/s."""
    arm = SERIAL.with_friction(coulomb=COULOMB, smoothing=0.01)
    run = pushed(arm, np.array([0.0, 0.5]) * COULOMB, {"control_period": 1e-3})
    assert run.dq[500, 1] == pytest.approx(0.01 * np.arctanh(0.5), rel=0.05)


TOO_LONG = sa.paper.simulation(2, duration=40.0, dt=1.0)


def test_a_step_too_long_for_the_paper_is_told() -> None:
    """RMS errors of 0.273 and 0.483 rad where 0.193 and 0.448 are right."""
    status = TOO_LONG.run().status
    assert status.kind == "unresolved"
    assert not status.finished
    assert "dt = 1 s is too long" in status.reason
    assert "use a smaller dt" in str(status)


def test_files_keep_that_it_was_not_resolved(tmp_path: Path) -> None:
    run, path = TOO_LONG.run(), tmp_path / "run.npz"
    run.save(path)
    assert sa.Run.load(path).status == run.status


def test_a_plain_run_is_finished() -> None:
    for number in (1, 2):
        scene = sa.paper.simulation(number, duration=5.0)  # type: ignore[arg-type]
        assert scene.run().status.kind == "finished"


def test_the_command_line_tells_it_and_fails(capsys: pytest.CaptureFixture[str]) -> None:
    common = ["simulate", "--simulation", "2", "--duration", "40"]
    assert cli.main([*common, "--dt", "1"]) not in (0, None)
    told = capsys.readouterr().out
    assert "not resolved" in told
    assert "dt = 1 s is too long" in told
    assert "gain" not in told
    assert cli.main([*common, "--dt", "0.001"]) == 0
    assert "status      finished\n" in capsys.readouterr().out


def test_plant_step_stops_a_damped_joint() -> None:
    """1e-4 kg m², 10 N·m·s/rad: a time constant of 10 µs. RK4 alone made it 240 784 rad/s.

    Right is 0 rad/s, at 1e-5 rad. -0.0366 a step is the tableau's own R(-100).
    """
    arm = sa.Serial.from_dh([0.0], [0.0], [0.0], mass=0.1, inertia=1e-4, viscous=10.0)
    plant, q, dq = sa.Plant(arm), np.zeros(1), np.ones(1)
    for step, left in enumerate((0.04, 2e-3, 1e-4, 1e-5, 1e-6)):
        q, dq = plant.step(q, dq, [0.0], step * 1e-3, 1e-3)
        assert abs(dq[0]) < left
    assert 0 < q[0] < 2e-4
