"""The machine around MuJoCo's robots: what its sensors, loop, drives and gears do to a number."""

import importlib
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import steadyarm as sa

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("pinocchio")

EXAMPLES = Path(__file__).parents[2] / "examples"
H = 1e-3


@pytest.fixture(scope="module")
def bench():
    """The modules of the bench, which import one another from their folder."""
    sys.path.insert(0, str(EXAMPLES))
    try:
        names = ("arms", "bench", "machine", "payload", "report")
        modules = {name: importlib.import_module(f"mujoco_{name}") for name in names}
    finally:
        sys.path.remove(str(EXAMPLES))
    return SimpleNamespace(**modules)


class Counts:
    """Commands 1, 2, 3 … thousandths of its effort on all joints, and keeps what it is told."""

    def __init__(self, effort):
        self.effort, self.told = effort, []

    def step(self, q, dq, q_d, dq_d, ddq_d, dt, applied=None, elapsed=None):
        self.told.append((applied, elapsed))
        return len(self.told) / 1000 * self.effort


def still(middle):
    """Return the motion that rests."""
    return lambda t: (middle, np.zeros_like(middle), np.zeros_like(middle))


def counted(bench, conditions, seconds=0.03):
    """Run `Counts` on the Panda; return it, the record and what acted before its first torque."""
    robot = bench.arms.ROBOTS["panda"]
    _, effort, machine = bench.arms.machine(robot, conditions, seed=4)
    resting, counts = machine.drives.sent, Counts(effort)
    return counts, machine.run(counts, still(np.array(robot.middle)), seconds), resting


def test_encoder_counts_are_of_a_turn_and_velocity_is_the_filtered_difference(bench):
    conditions = bench.machine.Conditions(encoder_bits=12)
    sensors = bench.machine.Sensors(conditions, 3, np.random.default_rng(1))
    count, speed = 2 * np.pi / 4096, np.array([0.3, -1.0, 2.0])
    seen = [sensors.read(0.5 + speed * k * H, None, H) for k in range(200)]
    q, dq = (np.array(rows) for rows in zip(*seen, strict=True))
    truth = 0.5 + speed * H * np.arange(200)[:, None]
    assert np.abs(q - truth).max() <= count / 2 + 1e-12
    apart = (q - q[0]) / count
    assert np.abs(apart - np.round(apart)).max() < 1e-9
    assert len(np.unique(np.round(apart[:, 2]))) > 100
    # A first-order low-pass, by its recursion, of the differences of what was read.
    share, expected = 1 - np.exp(-2 * np.pi * 100 * H), np.zeros(3)
    for step in np.diff(q, axis=0):
        expected = expected + share * (step / H - expected)
    assert dq[-1] == pytest.approx(expected, rel=1e-12)


def test_noise_is_seen_and_none_is_none(bench):
    conditions = bench.machine.Conditions(noise=1e-4, encoder_bits=24)
    sensors = bench.machine.Sensors(conditions, 4, np.random.default_rng(1))
    q = np.array([sensors.read(np.ones(4), None, H)[0] for _ in range(2000)])
    # The standard deviation of 8000 draws is within 3 / √(2 · 8000) = 2.4 % of the true one.
    assert q.std() == pytest.approx(1e-4, rel=0.024)
    conditions = bench.machine.Conditions(encoder_bits=None)
    exact = bench.machine.Sensors(conditions, 4, np.random.default_rng(1))
    q, dq = np.full(4, 0.1), np.full(4, 0.2)
    assert all(map(np.array_equal, exact.read(q, dq, H), (q, dq)))


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_a_torque_acts_so_many_samples_late_and_is_told_as_applied(bench, delay):
    counts, record, resting = counted(bench, bench.machine.Conditions(delay=delay))
    unit = counts.effort / 1000
    assert record.tau == pytest.approx(np.arange(1, 31)[:, None] * unit)
    applied = [row for row, _ in counts.told[1:]]
    for k, row in enumerate(applied, start=1):
        number = k - delay  # of the command that acted in the period before sample k, from 0
        assert row == pytest.approx(resting if number < 1 else number * unit)
    assert {elapsed for _, elapsed in counts.told[1:]} == {H}


def test_a_lost_sample_holds_the_torque_and_the_next_one_knows_the_time(bench):
    conditions = bench.machine.Conditions(drop=0.4, delay=0)
    counts, record, _ = counted(bench, conditions, 0.2)
    seen = len(counts.told)
    assert 80 < seen < 160 and len(record.t) == 200
    periods = np.array([elapsed for _, elapsed in counts.told[1:]]) / H
    assert periods == pytest.approx(np.round(periods)) and periods.max() > 2
    number = record.tau[:, 0] / counts.effort[0] * 1000
    repeats = np.diff(np.flatnonzero(np.diff(number, prepend=0.0)))
    assert repeats == pytest.approx(periods[: len(repeats)])


def test_jitter_is_within_its_share_and_measured(bench):
    counts, record, _ = counted(bench, bench.machine.Conditions(jitter=0.2), 0.2)
    elapsed = np.array([row for _, row in counts.told[1:]])
    assert elapsed == pytest.approx(np.diff(record.t))
    assert 0.8 * H <= elapsed.min() < 0.85 * H and 1.15 * H < elapsed.max() <= 1.2 * H


def test_drives_are_limited_off_by_their_gain_and_lag(bench):
    conditions = bench.machine.Conditions(delay=0, gain=0.1, lag=0.005)
    effort, random = np.array([10.0, 10.0, 20.0, 20.0]), np.random.default_rng(3)
    drives = bench.machine.Drives(conditions, effort, np.zeros(4), random)
    drives.send(np.array([4.0, 40.0, -4.0, -40.0]))
    assert drives.told.tolist() == [4.0, 10.0, -4.0, -20.0]
    assert set(np.round(drives.gain, 12)) == {0.9, 1.1}
    steps = [drives.arrive(2.5e-4) for _ in range(20)]
    # A first-order lag's answer to a step, after one time constant.
    assert steps[-1] == pytest.approx(drives.gain * drives.told * (1 - np.exp(-1.0)))


def test_gears_carry_the_weight_that_hangs_on_them(bench):
    conditions = bench.machine.Conditions(twist=0.01, rotors="known")
    robot = bench.arms.ROBOTS["panda"]
    arm, effort, machine = bench.arms.machine(robot, conditions)
    middle = np.array(robot.middle)
    tracker = sa.laws.computed_torque(arm, bandwidth=10.0, effort_limit=effort, delay=1)
    machine.run(tracker, still(middle), 2.0)
    q, theta = machine.world.data.qpos[:7], machine.world.data.qpos[7:]
    loaded = arm.with_payload(robot.payload, (0, 0, 0), 0.4 * robot.payload * 0.05**2)
    # Statics: every spring, effort / .01 rad stiff, carries what gravity loads its joint with.
    torque = effort / 0.01 * (theta - q)
    assert np.abs(torque - loaded.gravity(q)).max() < 0.02 * np.abs(loaded.gravity(q)).max()
    assert np.abs(theta - q).max() > 1e-3


def test_the_payload_comes_when_it_is_picked_up_and_the_push_is_on_the_last_joint(bench):
    robot = bench.arms.ROBOTS["panda"]
    conditions = bench.machine.Conditions(pick_up=0.02, push=2.0)
    _, effort, machine = bench.arms.machine(robot, conditions)
    world, carried = machine.world, []
    own = world.model.body_mass[world.tip]
    for seconds in (0.019, 0.002, 0.02):
        machine.run(Counts(effort), still(np.array(robot.middle)), seconds)
        carried.append(world.model.body_mass[world.tip] - own)
    assert carried == pytest.approx([0.0, robot.payload, robot.payload])
    pushed = world.data.qfrc_applied - machine.drives.told
    assert pushed == pytest.approx([0.0] * 6 + [2.0 * np.sin(2.9 * 0.040)], abs=1e-9)


@pytest.mark.parametrize("robot", ["panda", "ur5e", "xarm7", "z1", "kinova"])
def test_a_loaded_robot_is_the_arm_with_that_payload_and_rotors(bench, robot):
    robot = bench.arms.ROBOTS[robot]
    conditions = bench.machine.Conditions(offset=0.05, rotors="known")
    arm, _, machine = bench.arms.machine(robot, conditions)
    machine.pick_up()
    ball = 0.4 * robot.payload * 0.05**2
    there = arm.with_payload(robot.payload, (0.05, 0.0, 0.0), ball)
    world, random = machine.world, np.random.default_rng(5)
    world.model.dof_frictionloss[:] = world.model.dof_damping[:] = 0.0
    for _ in range(10):
        q = np.array(robot.middle) + random.uniform(-0.3, 0.3, arm.joints)
        dq, tau = random.uniform(-1.5, 1.5, (2, arm.joints))
        world.start(q)
        world.data.qvel[:], world.data.qfrc_applied[:] = dq, tau
        mujoco.mj_forward(world.model, world.data)
        theirs = world.data.qacc
        error = np.abs(there.forward_dynamics(q, dq, tau) - theirs).max()
        assert error <= 1e-7 * np.abs(theirs).max()


def test_figures_are_those_of_a_record_known_by_hand(bench):
    t = np.arange(0.0, 36.0, 0.01)
    e = np.zeros((3600, 2))
    e[t < 5.0], e[t >= 30.0] = (0.01, 0.0), (3e-4, 4e-4)
    tau = np.where(np.arange(3600) % 2, 1.0, -2.0)[:, None] * (1.0, 0.0)
    row = bench.bench.Row(None)
    bench.bench.measure(row, bench.machine.Record(t, e, tau), event=0.0)
    assert row.joints == pytest.approx([3e-4, 4e-4])
    assert [row.rms, row.worst] == pytest.approx([5e-4, 5e-4])
    assert row.peak == 2.0
    assert row.variation == pytest.approx(300.0, rel=2e-3)  # 3 N·m, a hundred times in a second
    assert row.low_after == pytest.approx(5.0, abs=0.011)


def test_an_observer_takes_away_what_computed_torque_leaves(bench):
    robot, conditions = bench.arms.ROBOTS["panda"], bench.machine.Conditions()
    middle = np.array(robot.middle)
    error = {}
    for law in ("computed_torque", "momentum_observer"):
        arm, effort, machine = bench.arms.machine(robot, conditions)
        motion = bench.payload.sine(middle)
        tracker = bench.arms.controllers(robot, arm, effort, conditions, motion)[law]()
        record = machine.run(tracker, motion, 2.0)
        assert not record.note
        error[law] = np.abs(record.e[-500:]).max()
    assert error["momentum_observer"] < error["computed_torque"] / 5


def test_a_run_gives_a_row_and_a_refusal_gives_its_reason(bench, monkeypatch):
    monkeypatch.setattr(bench.bench, "PERIODS", 2)
    monkeypatch.setattr(bench.bench, "PERIOD", 0.25)
    jobs = [
        bench.bench.Job("panda", case, motion, "slotine_li")
        for case in ("base", "rotors")
        for motion in bench.bench.MOTIONS
    ]
    rows = [bench.bench.run(job) for job in jobs]
    assert all(row.note.startswith("refused: damping") for row in rows[:2])
    assert all(not row.note and 0.0 < row.rms <= row.worst < 0.1 for row in rows[2:])
    assert all(row.frozen and row.other for row in rows[2:])
    assert all(len(row.curve) == 5 for row in rows[2:])
    assert [bench.report.brief(x) for x in (15678.9, 0.27849, 3.0)] == ["15700", "0.278", "3"]
    text = bench.report.tables(rows)
    pair = " / ".join(bench.report.brief(1e3 * row.rms) for row in rows[2:])
    assert f"| slotine li | {pair} |" in text
    assert f"- slotine li, sine: {rows[0].note}" in text
