"""The kernel form: a grid over any number of inputs, in a bounded dictionary of states."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from scenes import CENTERS, WIDTH, basis, nominal, run, samples

LAW = {"q": 10, "gain": 7.0, "gamma": 1.0}
WIDE = np.linspace(-4, 4, 5)


def grid(normalized: bool = True, inputs: Any = "error") -> sa.FuzzyBasis:
    return basis("grid", normalized, inputs)


def tracker(dictionary: int | None = 256, *, inputs: Any = "error", **law: Any) -> Any:
    normalized = law.pop("normalized", True)
    form = LAW | law | {"dictionary": dictionary}
    compensator = sa.FuzzyCompensator(grid(normalized, inputs), **form)
    return sa.ComputedTorque(nominal(), 8, 5.5, compensator)


def path(steps: int) -> list[list[np.ndarray]]:
    """Samples (q, dq, q_d, dq_d, ddq_d) along a smooth motion with an error."""
    t = np.linspace(0, 1, steps)[:, None]
    phase = np.array((1.0, 2.0))
    q_d = np.sin(3 * t + phase)
    dq_d = 3 * np.cos(3 * t + phase)
    e, de = 0.4 * np.cos(7 * t * phase), -0.5 * phase * np.sin(7 * t * phase)
    return [list(row) for row in np.stack([q_d + e, dq_d + de, q_d, dq_d, -9 * q_d], axis=1)]


def drive(controller: Any, steps: list[list[np.ndarray]]) -> np.ndarray:
    """The torques, and ρ̂ too, which is 0 where nothing is learnt."""
    rows = []
    for sample in steps:
        tau = controller.step(*sample, 1e-3)
        rows.append(np.concatenate([tau, controller.rho_hat]))
    return np.array(rows)


MODIFICATIONS: list[dict[str, Any]] = [
    {},
    {"normalized": False},
    {"inputs": "state"},
    {"inputs": {"q": 1.0, "de": 0.3}, "gain": (50.0, 3.0)},
    {"leak_rate": 0.5},
    {"error_modification": 0.3},
    {"projection_radius": 0.05},
    {"dead_zone": 0.2, "normalization": 0.7},
]


@pytest.mark.parametrize("change", MODIFICATIONS, ids=str)
def test_steps_agree_with_the_dense_grid(change: dict[str, Any]) -> None:
    kernel, dense = tracker(4096, merge_tolerance=0.0, **change), tracker(None, **change)
    got, wanted = drive(kernel, path(200)), drive(dense, path(200))
    for got_part, part in ((got[:, :2], wanted[:, :2]), (got[:, 2:], wanted[:, 2:])):
        assert np.abs(part).max() > 1e-3
        np.testing.assert_allclose(got_part, part, rtol=0, atol=1e-9 * np.abs(part).max())
    counts = kernel.dictionary
    assert counts["merged"] == counts["dropped"] == 0
    assert counts["capacity"] == 4096 and 190 <= counts["atoms"] <= 4096
    np.testing.assert_array_equal(kernel.P, dense.P)


def test_simulation_agrees_with_the_dense_grid() -> None:
    options = {"duration": 0.2, "control_period": 1e-3}
    kernel = run(tracker(1024, merge_tolerance=0.0, gain=700.0), **options)
    dense = run(tracker(None, gain=700.0), **options)
    assert kernel.dictionary is not None and dense.dictionary is None
    assert kernel.dictionary["merged"] == kernel.dictionary["dropped"] == 0
    assert kernel.weights is None and dense.weights is not None
    for name in ("q", "dq", "tau", "rho_hat", "weights_norm", "V"):
        got, wanted = getattr(kernel, name), getattr(dense, name)
        np.testing.assert_allclose(got, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())
    assert np.abs(dense.rho_hat).max() > 0.1


def test_merging_is_counted_and_the_lyapunov_identity_shown() -> None:
    record = run(tracker(256, gain=100.0), duration=2.0)
    dense = run(tracker(None, gain=100.0), duration=2.0)
    counts = record.dictionary
    assert counts is not None
    assert counts["merged"] > 5000 and 5 < counts["atoms"] < 256 and counts["dropped"] == 0
    assert (counts["error_bound"] > 0).all() and counts["error_bound"].shape == (2,)
    assert np.isfinite(record.q).all()
    # What was lost is bounded, and little of it is in the motion.
    assert np.abs(record.q - dense.q).max() < 0.05 * np.abs(dense.e).max()
    assert record.certificate is not None


def test_full_dictionary_drops_and_says_so(tmp_path: Path) -> None:
    record = run(tracker(16, merge_tolerance=0.0), duration=0.1)
    counts = record.dictionary
    assert counts is not None
    assert counts["atoms"] == counts["capacity"] == 16 and counts["dropped"] > 50
    assert f"16 of 16 atoms, {counts['dropped']} dropped" in repr(record)
    record.save(tmp_path / "run.npz")
    loaded = sa.Run.load(tmp_path / "run.npz")
    assert loaded.dictionary is not None and loaded.weights is None
    assert repr(loaded) == repr(record)
    np.testing.assert_array_equal(loaded.dictionary["error_bound"], counts["error_bound"])


def test_freeze_reset_and_twin() -> None:
    controller = tracker()
    first = drive(controller, path(50))
    assert controller.dictionary["atoms"] > 0
    controller.freeze()
    assert controller.frozen
    before = controller.dictionary
    drive(controller, path(20))
    assert {k: str(v) for k, v in controller.dictionary.items()} == {
        k: str(v) for k, v in before.items()
    }
    assert np.abs(controller.rho_hat).max() > 0
    controller.unfreeze()
    run(controller, duration=0.05)
    assert controller.steps == 70
    controller.reset()
    assert controller.dictionary["atoms"] == controller.dictionary["merged"] == 0
    assert (controller.dictionary["error_bound"] == 0).all()
    np.testing.assert_array_equal(drive(controller, path(50)), first)


@pytest.mark.parametrize(
    "change",
    [{}, {"dictionary": 16, "leak_rate": 300.0}, {"dictionary": 40, "merge_tolerance": 0.0}],
    ids=str,
)
def test_saved_state_goes_on_bit_for_bit(change: dict[str, Any], tmp_path: Path) -> None:
    controller = tracker(**change)
    drive(controller, path(300)[:200])
    controller.save(tmp_path / "state")
    loaded, copy = tracker(**change), pickle.loads(pickle.dumps(controller))
    drive(loaded, samples(5))
    loaded.load(tmp_path / "state")
    assert loaded.__getstate__() == copy.__getstate__() == controller.__getstate__()
    wanted = drive(controller, path(300)[200:])
    assert np.abs(wanted[:, 2:]).max() > 0
    np.testing.assert_array_equal(drive(loaded, path(300)[200:]), wanted)
    np.testing.assert_array_equal(drive(copy, path(300)[200:]), wanted)
    assert str(loaded.dictionary) == str(copy.dictionary) == str(controller.dictionary)
    assert loaded.__getstate__() == controller.__getstate__()


def test_frozen_is_saved() -> None:
    controller = tracker()
    drive(controller, path(10))
    controller.freeze()
    assert pickle.loads(pickle.dumps(controller)).frozen


def checksummed(body: bytes) -> bytes:
    """The bytes with a checksum (FNV-1a) that fits."""
    total = 0xCBF29CE484222325
    for byte in body:
        total = (total ^ byte) * 0x100000001B3 % 2**64
    return body + total.to_bytes(8, "little")


def test_damaged_or_foreign_state_is_refused_and_changes_nothing() -> None:
    controller = tracker(32)
    drive(controller, path(100))
    state = controller.__getstate__()
    assert checksummed(state[:-8]) == state
    # Counts and last torque, fingerprints, and the pending period: dt and seven vectors.
    start = 12 + 8 * (5 + 2 + 4 + 1 + 14)

    def with_word(index: int, word: bytes) -> bytes:
        at = start + 8 * index
        return checksummed(state[:at] + word + state[at + 8 : -8])

    nan, count = np.float64(np.nan).tobytes(), (33).to_bytes(8, "little")
    flipped = bytearray(state)
    flipped[200] ^= 1
    bad = {
        "checksum": bytes(flipped),
        "too short": state[:5],
        "is too short": checksummed(state[:-24]),
        "dictionary is not": checksummed(state[:-8] + bytes(8)),
        "not a possible one": with_word(1, count),
        "a possible one": with_word(4, nan),
        "possible one": with_word(6, np.float64(-1).tobytes()),
        "possible": with_word(10, np.float64(2).tobytes()),
        "is not a possible": with_word(10 + 20, nan),
        "capacity: got 64 entries, wants 32": tracker(64).__getstate__(),
        "sets: got 10 entries, wants 20": tracker(32, inputs="e").__getstate__(),
        "another kind": tracker(None).__getstate__(),
        "of another kind": sa.ComputedTorque(nominal(), 8, 5.5).__getstate__(),
    }
    for message, data in bad.items():
        with pytest.raises(ValueError, match=message):
            controller.__setstate__(data)
        assert controller.__getstate__() == state
    for other in (tracker(None), sa.ComputedTorque(nominal(), 8, 5.5)):
        with pytest.raises(ValueError, match="of another kind"):
            other.__setstate__(state)


@pytest.fixture(scope="module")
def panda() -> Any:
    """A Panda, with a payload that the controller does not know of, over 6.1 billion rules."""
    robot = sa.Serial.shipped("panda").without_friction()
    there = sa.Plant(robot.with_payload(2.0, com=(0.0, 0.05, 0.1), inertia=0.01))
    states = sa.FuzzyBasis("grid", centers=WIDE, width=0.6, normalized=True, inputs="state")
    start = np.array((0.0, -0.5, 0.0, -1.8, 0.0, 1.6, 0.4))
    reference = sa.Sines(2.0, sin=np.full(7, 0.3), offset=start)
    dq0 = reference(0.0)[1]

    def tracked(**change: Any) -> sa.ComputedTorque:
        law = {"gain": 30000.0, "dictionary": 256} | change
        return sa.ComputedTorque(robot, 100.0, 20.0, sa.FuzzyCompensator(states, **law))

    def simulate(controller: sa.ComputedTorque) -> sa.Run:
        options = {"control_period": 1e-3, "q0": start, "dq0": dq0}
        return sa.simulate(there, controller, reference, 8.0, **options)

    return robot, tracked, simulate


def test_seven_joints_learn_a_payload(panda: Any) -> None:
    robot, tracked, simulate = panda
    adaptive, plain = simulate(tracked()), simulate(sa.ComputedTorque(robot, 100.0, 20.0))
    assert adaptive.status.finished and np.isfinite(adaptive.tau).all()
    late = (4.0, 8.0)
    with_it = np.linalg.norm(adaptive.metrics(late).rms_e)
    without = np.linalg.norm(plain.metrics(late).rms_e)
    assert with_it < 0.2 * without, (with_it, without)
    counts = adaptive.dictionary
    assert counts is not None and counts["capacity"] == 256
    assert 0 < counts["atoms"] <= 256 and counts["error_bound"].shape == (7,)


def test_seven_joints_step(panda: Any) -> None:
    _, tracked, _ = panda
    controller = tracked()
    random = np.random.default_rng(5)
    for sample in random.normal(size=(300, 5, 7)):
        assert np.isfinite(controller.step(*sample, 1e-3)).all()
    assert controller.dictionary["atoms"] == 256 and controller.dictionary["dropped"] == 44
    assert "dictionary=256" in repr(controller)
    copy = pickle.loads(pickle.dumps(controller))
    sample = random.normal(size=(5, 7))
    np.testing.assert_array_equal(copy.step(*sample, 1e-3), controller.step(*sample, 1e-3))


def test_basis_of_any_size() -> None:
    states = sa.FuzzyBasis("grid", CENTERS, WIDTH, inputs="state", joints=7)
    assert states.rules == 5**14
    assert sa.FuzzyBasis("grid", [CENTERS] * 14, WIDTH, inputs="state").joints == 7
    signals = ["e", "de", "q", "dq", "q_d", "dq_d", "ddq_d"]
    most = sa.FuzzyBasis("grid", np.arange(8.0), WIDTH, inputs=signals, joints=8)
    assert most.rules == 8**56
    assert pickle.loads(pickle.dumps(most)).rules == most.rules
    compensator = sa.FuzzyCompensator(most, dictionary=8)
    assert compensator.dictionary == 8 and compensator.merge_tolerance == 0.05


def test_compensator_survives_pickle() -> None:
    form = sa.FuzzyCompensator(grid(), **LAW, dictionary=64, merge_tolerance=0.01)
    copy = pickle.loads(pickle.dumps(form))
    assert (copy.dictionary, copy.merge_tolerance) == (64, 0.01)
    assert repr(copy) == repr(form) and "dictionary=64" in repr(form)
    plain = pickle.loads(pickle.dumps(sa.FuzzyCompensator(grid())))
    assert plain.dictionary is None and plain.merge_tolerance is None


def compensator(form: str = "grid", **change: Any) -> sa.FuzzyCompensator:
    return sa.FuzzyCompensator(basis(form), **change)


MANY = "rules: got 6103515625, wants at most 1048576; use dictionary=256, the kernel form"

REFUSALS: list[tuple[type[Exception], str, Callable[[], object]]] = [
    (ValueError, "dictionary: got 0, wants a whole", lambda: compensator(dictionary=0)),
    (TypeError, "dictionary: got float, wants a whole", lambda: compensator(dictionary=2.5)),
    (ValueError, "dictionary: got 4097, wants at most 4096", lambda: compensator(dictionary=4097)),
    (
        ValueError,
        "merge_tolerance: got 1, wants a part of the norm, 0 <= part < 1",
        lambda: compensator(dictionary=8, merge_tolerance=1.0),
    ),
    (
        ValueError,
        "merge_tolerance: got NaN, wants a finite number",
        lambda: compensator(dictionary=8, merge_tolerance=np.nan),
    ),
    (
        ValueError,
        "merge_tolerance: got 0.1 without a dictionary, wants one: dictionary=256",
        lambda: compensator(merge_tolerance=0.1),
    ),
    *(
        (
            ValueError,
            f'dictionary: got 8 for FuzzyBasis(form="{form}"',
            lambda form=form: compensator(form, dictionary=8),
        )
        for form in ("shared", "concat", "per_joint")
    ),
    (
        ValueError,
        MANY,
        lambda: sa.FuzzyCompensator(sa.FuzzyBasis("grid", CENTERS, 1.0, joints=7)),
    ),
    (ValueError, MANY, lambda: sa.FuzzyBasis("grid", CENTERS, 1.0).evaluate(np.zeros((2, 14)))),
    (TypeError, "weights: this compensator has a dictionary", lambda: tracker().weights),
    (
        TypeError,
        "weights: this compensator has a dictionary",
        lambda: setattr(tracker(), "weights", np.zeros((2, 625))),
    ),
    (
        TypeError,
        "weights: this compensator has a dictionary",
        lambda: tracker().warm_start(np.zeros((2, 625))),
    ),
]


@pytest.mark.parametrize("form", [{}, {"normalized": False}, {"inputs": "state"}])
def test_design_report_is_that_of_the_dense_grid(form: dict[str, Any]) -> None:
    conditions: dict[str, Any] = {"disturbance": [(2.0, 1.0), (0.5, 3.0)], "inertia_ratio": 0.5}
    if "inputs" in form:
        conditions["path"] = sa.paper.reference()
    kernel = sa.design(tracker(16, **form), 1e-3, **conditions)
    dense = sa.design(tracker(None, **form), 1e-3, **conditions)
    for field in ("p12", "k_i", "rms", "poles", "sampled_radius", "max_period"):
        left, right = getattr(kernel, field), getattr(dense, field)
        np.testing.assert_allclose(left, right, rtol=1e-10, err_msg=field)
    # Sixteen states are too few for a path, as only the kernel form can say.
    shared = tuple(f for f in kernel.findings if not f.startswith("dictionary: 16"))
    assert (shared, kernel.sound) == (dense.findings, dense.sound)


def test_design_report_of_six_billion_rules() -> None:
    centers = np.linspace(-1, 1, 5)
    billions = sa.FuzzyBasis("grid", centers, 0.5, normalized=True, inputs="reference")
    compensator = sa.FuzzyCompensator(billions, q=10, gain=1e6, dictionary=16)
    tracker = sa.ComputedTorque(sa.Serial.shipped("panda"), 64, 16, compensator)
    report = sa.design(tracker, path=sa.Quintic(np.zeros(7), np.zeros(7), 1.0))
    # |ξ(0)|² is the fourteenth power of one input's.
    mu = np.exp(-((centers / 0.5) ** 2) / 2)
    np.testing.assert_allclose(report.k_i, 1e6 * ((mu / mu.sum()) ** 2).sum() ** 14, rtol=1e-12)


@pytest.mark.parametrize("kind, message, call", REFUSALS, ids=[row[1][:50] for row in REFUSALS])
def test_message_names_argument_value_and_wish(kind: Any, message: str, call: Any) -> None:
    with pytest.raises(kind, match=f"^{re.escape(message)}"):
        call()


def test_without_a_dictionary_there_are_no_figures() -> None:
    assert tracker(None).dictionary is None
    assert sa.ComputedTorque(nominal(), 8, 5.5).dictionary is None
    assert run(tracker(None), duration=0.01).dictionary is None
