"""Arms of 1 to 12 joints: the same tracker, plant, signals and saved states for each."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from scenes import CENTERS, WIDTH, actual, nominal, samples

EACH = range(1, 13)


def arm(joints: int, **change: Any) -> sa.Serial:
    """Links of 0.4 m that turn about axes at right angles to each other, thinner to the tip."""
    size = 1.0 / np.arange(1, joints + 1)
    table = {
        "a": 0.4,
        "alpha": np.where(np.arange(joints) % 2, -np.pi / 2, np.pi / 2),
        "d": 0.1,
        "mass": 3.0 * size,
        "com": np.tile((-0.2, 0.01, 0.02), (joints, 1)),
        "inertia": np.outer(size, (0.02, 0.03, 0.04)),
        "viscous": 0.3,
        "coulomb": 0.2,
        "armature": 0.05,
    }
    return sa.Serial.from_dh(**(table | change))


def compensator(**change: Any) -> sa.FuzzyCompensator:
    basis = sa.FuzzyBasis("per_joint", CENTERS, WIDTH)
    return sa.FuzzyCompensator(**({"basis": basis, "gain": 30.0} | change))


def tracker(joints: int, **change: Any) -> sa.ComputedTorque:
    parts = {"arm": arm(joints), "kp": 64.0, "kv": 16.0, "compensator": compensator()}
    return sa.ComputedTorque(**(parts | change))


def plant(joints: int) -> sa.Plant:
    return sa.Plant(arm(joints).perturb(7), disturbance=sa.Sines(2.0, sin=0.5))


def reference(joints: int) -> sa.Sines:
    amplitudes = np.linspace(0.2, 0.5, joints)
    return sa.Sines((1.0, 3.0), sin=[amplitudes, amplitudes[::-1]], cos=np.zeros((2, joints)))


@pytest.mark.parametrize("joints", EACH)
def test_simulate_equals_manual_loop_bit_for_bit(joints: int) -> None:
    there, controller, path = plant(joints), tracker(joints), reference(joints)
    run = sa.simulate(there, controller, path, 0.05, control_period=1e-3)
    q, dq = np.zeros(joints), np.zeros(joints)
    for k in range(51):
        assert q.tobytes() == run.q[k].tobytes()
        assert dq.tobytes() == run.dq[k].tobytes()
        if k < 50:
            tau = controller.step(q, dq, *path(run.t[k]), 1e-3)
            assert tau.tobytes() == run.tau[k].tobytes()
            q, dq = there.step(q, dq, tau, run.t[k], 1e-3)
    assert controller.weights.tobytes() == run.weights.tobytes()
    assert run.weights.shape == (joints, 25)


@pytest.mark.parametrize("dictionary", [None, 16])
@pytest.mark.parametrize("options", [{}, {"method": "dp54"}, {"control_period": 2e-3}])
def test_tracker_of_a_run_goes_on_from_it(dictionary: int | None, options: dict[str, Any]) -> None:
    """Nothing here depends on time, so that a run in two parts is the run in one."""
    basis = sa.FuzzyBasis("grid", np.linspace(-1, 1, 5), 0.5, normalized=True, inputs="error")
    compensator = sa.FuzzyCompensator(basis, q=10, gain=50.0, dictionary=dictionary)
    controller = sa.ComputedTorque(sa.paper.nominal(), 8, 5.5, compensator)
    rest = sa.Quintic((0.1, 0.2), (0.1, 0.2), 1.0)

    def run(tracker: sa.ComputedTorque, duration: float, **start: Any) -> sa.Run:
        there = sa.Plant(sa.paper.actual())
        return sa.simulate(there, tracker, rest, duration, 1e-3, **options, **start)

    before = pickle.dumps(controller)
    first = run(controller, 0.4, q0=(0.5, -0.5))
    assert pickle.dumps(controller) == before
    going_on = pickle.dumps(first.tracker)
    second = run(first.tracker, 0.2, q0=first.q[-1], dq0=first.dq[-1])
    assert pickle.dumps(first.tracker) == going_on != before
    whole = run(controller, 0.6, q0=(0.5, -0.5))
    if options.get("method") == "dp54":
        # Its steps end elsewhere, and so do the states that a dictionary keeps.
        apart = 1e-7 if dictionary is None else 1e-5
        np.testing.assert_allclose(second.q, whole.q[400:], rtol=0, atol=apart)
    else:
        assert second.q.tobytes() == whole.q[400:].tobytes()
        assert pickle.dumps(second.tracker) == pickle.dumps(whole.tracker)
    if dictionary is None:
        assert first.tracker.weights.tobytes() == first.weights.tobytes()
    else:
        assert first.tracker.dictionary["atoms"] == first.dictionary["atoms"] > 0
    assert pickle.loads(pickle.dumps(first)).tracker.steps == first.tracker.steps


@pytest.mark.parametrize("joints", EACH)
def test_compensator_tracks_better_and_its_certificate_holds(joints: int) -> None:
    there, path = plant(joints), reference(joints)
    plain, adaptive = (
        sa.simulate(there, tracker(joints, compensator=rho), path, 4.0)
        for rho in (None, compensator(gain=1e3, q=100.0))
    )
    assert plain.status.finished and adaptive.status.finished
    assert adaptive.certificate is not None
    # Coulomb friction, smoothed over 0.01 rad/s, is a kink to steps of 1 ms: 7e-10 at the most.
    assert adaptive.certificate.residual < 1e-8
    rms = [np.sqrt(np.mean(run.e[2000:] ** 2)) for run in (plain, adaptive)]
    assert rms[1] < 0.4 * rms[0]
    assert adaptive.metrics((2, 4)).rms_e.shape == (joints,)


@pytest.mark.parametrize("joints", EACH)
def test_shapes_follow_the_arm(joints: int) -> None:
    controller = tracker(joints, effort_limit=50.0)
    assert controller.kp.shape == controller.kv.shape == (joints,)
    assert controller.P.shape == (2 * joints, 2 * joints)
    assert controller.weights.shape == (joints, 25)
    assert controller.compensator.gain.shape == (joints,)
    assert controller.compensator.q.shape == (2 * joints,)
    report = sa.design(controller)
    assert report.k_i.shape == (joints,)
    assert report.poles.shape == (joints, 3)
    zero = np.zeros(joints)
    assert controller.step(zero, zero, zero, zero, zero, 1e-3).shape == (joints,)
    for part in (controller.tau_model, controller.tau_compensation, controller.rho_hat):
        assert part.shape == (joints,)


@pytest.mark.parametrize("joints", EACH)
def test_restored_tracker_goes_on_bit_for_bit(joints: int, tmp_path: Path) -> None:
    random = np.random.default_rng(joints)
    steps = random.normal(size=(40, 5, joints))
    controller = tracker(joints)
    for sample in steps[:20]:
        controller.step(*sample, 1e-3)
    controller.save(tmp_path / "state")
    loaded = tracker(joints)
    loaded.load(tmp_path / "state")
    copies = [loaded, pickle.loads(pickle.dumps(controller))]
    for sample in steps[20:]:
        tau = controller.step(*sample, 1e-3).tobytes()
        assert all(copy.step(*sample, 1e-3).tobytes() == tau for copy in copies)
    other = tracker(joints % 8 + 1)
    with pytest.raises(ValueError, match=rf"path: .*joints: got {joints} entries, wants"):
        other.load(tmp_path / "state")
    assert other.steps == 0


@pytest.mark.parametrize("joints", EACH)
def test_pickled_pieces_are_the_same(joints: int) -> None:
    t = np.linspace(0, 1, 5)
    table = sa.Table(t, np.outer(t**2, np.ones(joints)))
    goal = np.arange(joints, dtype=float)
    for signal in (reference(joints), sa.Quintic(0, goal, 2.0), table):
        copy = pickle.loads(pickle.dumps(signal))
        for now in (0.0, 0.37, 5.0):
            for left, right in zip(signal(now), copy(now), strict=True):
                assert left.shape == (joints,)
                assert left.tobytes() == right.tobytes()
    run = sa.simulate(plant(joints), tracker(joints), reference(joints), 0.02)
    again = sa.simulate(
        pickle.loads(pickle.dumps(plant(joints))), tracker(joints), reference(joints), 0.02
    )
    assert run.q.tobytes() == again.q.tobytes()
    known = pickle.loads(pickle.dumps(tracker(joints).compensator))
    assert known.gain.shape == (joints,)


@pytest.mark.parametrize("joints", EACH)
def test_scalars_count_for_every_joint(joints: int) -> None:
    ones = np.ones(joints)
    scalars = tracker(joints, compensator=compensator(q=9.0))
    vectors = tracker(
        joints,
        kp=64 * ones,
        kv=16 * ones,
        compensator=compensator(gain=30 * ones, q=np.diag(np.repeat(9.0, 2 * joints))),
    )
    pairs = [
        (sa.Quintic(0, 1, 2.0), sa.Quintic(0 * ones, ones, 2.0)),
        (sa.Sines(2.0, sin=0.3, offset=1), sa.Sines(2.0, sin=0.3 * ones, offset=ones)),
    ]
    for scalar, vector in [*pairs, *((pickle.loads(pickle.dumps(s)), v) for s, v in pairs)]:
        left = sa.simulate(sa.Plant(arm(joints), scalar), scalars, scalar, 0.05, q0=0.1)
        right = sa.simulate(sa.Plant(arm(joints), vector), vectors, vector, 0.05, q0=0.1 * ones)
        assert left.q.tobytes() == right.q.tobytes()
        assert left.weights.tobytes() == right.weights.tobytes()


def test_callables_see_the_joints_of_the_arm() -> None:
    seen = set()

    def disturbance(q: np.ndarray, dq: np.ndarray, t: float) -> np.ndarray:
        seen.add((q.shape, dq.shape))
        return np.zeros(3)

    run = sa.simulate(sa.Plant(arm(3), disturbance), tracker(3), lambda t: (np.zeros(3),) * 3, 0.01)
    assert seen == {((3,), (3,))}
    assert run.status.finished


def step(joints: int, **change: Any) -> np.ndarray:
    zero = dict.fromkeys(("q", "dq", "q_d", "dq_d", "ddq_d"), np.zeros(joints))
    return tracker(joints).step(**(zero | {"dt": 1e-3} | change))


def simulate(**change: Any) -> sa.Run:
    parts = {"plant": plant(3), "tracker": tracker(3), "reference": reference(3)}
    return sa.simulate(**(parts | {"duration": 0.01} | change))


THREE, TWO = np.zeros(3), np.zeros(2)

CASES: list[tuple[str, Callable[[], object]]] = [
    (r"kp: got shape (2,), wants a scalar or (3,)", lambda: tracker(3, kp=TWO + 1)),
    (r"kv: got shape (4,), wants a scalar or (3,)", lambda: tracker(3, kv=np.ones(4))),
    (r"effort_limit: got shape (2,), wants a sc", lambda: tracker(3, effort_limit=TWO + 1)),
    (
        "compensator: got one of 2 joints, wants one of 3",
        lambda: tracker(3, compensator=compensator(gain=TWO + 1)),
    ),
    (
        "compensator: got one of 3 joints, wants one of 2",
        lambda: sa.ComputedTorque(nominal(), 8, 5.5, compensator(q=np.ones(6))),
    ),
    (
        "compensator: got one of 1 joints, wants one of 3",
        lambda: tracker(
            3, compensator=sa.FuzzyCompensator(sa.FuzzyBasis("shared", [CENTERS] * 2, 1.0))
        ),
    ),
    (
        "compensator: got one of 7 joints, wants one of 3",
        lambda: tracker(
            3, compensator=sa.FuzzyCompensator(sa.FuzzyBasis("concat", CENTERS, 1.0, joints=7))
        ),
    ),
    (
        "gain: got values for 2 joints, wants 3",
        lambda: compensator(basis=sa.FuzzyBasis("shared", CENTERS, 1.0, joints=3), gain=(1, 1)),
    ),
    ("q: got shape (4,), wants a scalar, (6,)", lambda: compensator(gain=THREE + 1, q=np.ones(4))),
    ("q: got shape (3,), wants a scalar, (2n,)", lambda: compensator(q=np.ones(3))),
    ("q: got shape (26,), wants a scalar, (2n,)", lambda: compensator(q=np.ones(26))),
    (
        "rules: got 6103515625, wants at most 1048576",
        lambda: tracker(7, compensator=compensator(basis=sa.FuzzyBasis("grid", CENTERS, 1.0))),
    ),
    ("joints: got 13, wants 1 to 12", lambda: sa.FuzzyBasis("shared", CENTERS, 1.0, joints=13)),
    ("joints: got 0, wants a whole", lambda: sa.FuzzyBasis("shared", CENTERS, 1.0, joints=0)),
    ("joints: got 13, wants 1 to 12", lambda: arm(13)),
    ("q: got shape (2,), wants (3,)", lambda: step(3, q=TWO)),
    ("ddq_d: got shape (8,), wants (7,)", lambda: step(7, ddq_d=np.zeros(8))),
    ("plant: got one of 2 joints, wants 3", lambda: simulate(plant=sa.Plant(actual()))),
    ("reference: got one of 2 joints, wants one of 3", lambda: simulate(reference=reference(2))),
    (
        "reference: got one of 4 joints, wants one of 3",
        lambda: simulate(reference=sa.Table((0, 1), np.zeros((2, 4)))),
    ),
    ("reference: q_d: got shape (2,), wants (3,)", lambda: simulate(reference=lambda t: [TWO] * 3)),
    ("q0: got shape (2,), wants a scalar or (3,)", lambda: simulate(q0=TWO)),
    (
        "disturbance: got one of 2 joints, wants one of 3",
        lambda: sa.Plant(arm(3), sa.paper.disturbance()),
    ),
    ("disturbance: got shape (2,), wants (3,)", lambda: simulate(plant=sa.Plant(arm(3), two))),
    ("effort_limit: got shape (2,), wants a s", lambda: sa.Plant(arm(3), effort_limit=TWO + 1)),
    ("goal: got values for 3 joints, wants 2", lambda: sa.Quintic(TWO, THREE, 1.0)),
    ("cos: got values for 3 joints, wants 2", lambda: sa.Sines(1.0, sin=TWO, cos=THREE)),
    ("offset: got values for 2 joints, wants 3", lambda: sa.Sines([1], sin=[THREE], offset=TWO)),
    ("sin: got shape (2, 2), wants (1, n) with n", lambda: sa.Sines([1], sin=np.zeros((2, 2)))),
    ("q: got shape (2, 13), wants (2, n) with n", lambda: sa.Table((0, 1), np.zeros((2, 13)))),
    (
        "ddq: got shape (2, 3), wants (2, 2)",
        lambda: sa.Table((0, 1), np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 3))),
    ),
    (
        "weights: got shape (2, 25), wants (3, 25)",
        lambda: tracker(3).warm_start(np.zeros((2, 25))),
    ),
]


def two(q: np.ndarray, dq: np.ndarray, t: float) -> np.ndarray:
    return TWO


@pytest.mark.parametrize(("message", "call"), CASES, ids=[message[:30] for message, _ in CASES])
def test_wrong_joint_count_is_refused(message: str, call: Callable[[], object]) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        call()


def test_no_harmonics_at_all_is_rest() -> None:
    rest = sa.Sines((), sin=np.zeros((0, 3)), offset=1.0)
    assert np.array_equal(rest(0.5), [[1.0] * 3, [0.0] * 3, [0.0] * 3])


def test_rules_follow_the_joints_of_the_basis() -> None:
    for joints in EACH:
        basis = sa.FuzzyBasis("per_joint", CENTERS, 1.0, joints=joints)
        assert basis.joints == joints
        assert basis.rules == 25 * joints
        xi = basis.evaluate(np.zeros((1, 2 * joints)))
        assert xi.shape == (1, 25 * joints)
        assert np.allclose(xi.reshape(joints, 25).sum(axis=1), 1.0, rtol=1e-14)
        lists = sa.FuzzyBasis("per_joint", [CENTERS] * (2 * joints), 1.0)
        assert lists.joints == joints
        assert pickle.loads(pickle.dumps(basis)).rules == basis.rules
    assert sa.FuzzyBasis("per_joint", CENTERS, 1.0).joints is None


def test_closed_form_and_chain_agree_in_the_loop() -> None:
    """The paper's arm twice: closed form and chain. Sums are taken in another order."""
    chain = sa.Serial.from_dh(
        a=0.5, alpha=0, d=(0, 0), mass=4, com=[(-0.25, 0, 0)] * 2, inertia=0.2, gravity=(0, 0, 0)
    )
    for q, dq, ddq, *_ in samples(20):
        for name in ("mass_matrix", "bias", "coriolis"):
            arguments = (q,) if name == "mass_matrix" else (q, dq)
            exact = getattr(nominal(), name)(*arguments)
            np.testing.assert_allclose(getattr(chain, name)(*arguments), exact, rtol=0, atol=1e-13)
        np.testing.assert_allclose(
            chain.inverse_dynamics(q, dq, ddq), nominal().inverse_dynamics(q, dq, ddq), atol=1e-13
        )
    there = sa.Plant(actual(), sa.paper.disturbance())
    runs = [
        sa.simulate(there, sa.ComputedTorque(believed, 8, 5.5, compensator()), reference(2), 2.0)
        for believed in (nominal(), chain)
    ]
    np.testing.assert_allclose(runs[1].q, runs[0].q, rtol=0, atol=1e-12)
    assert runs[0].q.tobytes() != np.zeros_like(runs[0].q).tobytes()
