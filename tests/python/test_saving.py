"""Files and bytes: what was saved comes back, anything else is an error and changes nothing."""

from __future__ import annotations

import json
import os
import pickle
import sys
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import drive, nominal, run, samples, tracker

FIELDS = tuple(name for name in sa.Run.__dataclass_fields__ if name != "tracker")


def plain() -> sa.ComputedTorque:
    return sa.ComputedTorque(nominal(), 8, 5.5, effort_rate_limit=100.0)


def equal(one: sa.Run, other: sa.Run) -> bool:
    for name in FIELDS:
        a, b = getattr(one, name), getattr(other, name)
        if isinstance(a, np.ndarray):
            if a.dtype != b.dtype or a.shape != b.shape or a.tobytes() != b.tobytes():
                return False
        elif a != b:
            return False
    return True


@pytest.mark.parametrize(
    "make",
    [
        lambda: run(tracker()),
        lambda: run(tracker(), control_period=1e-3),
        lambda: run(plain(), control_period=1e-3),
        lambda: run(tracker("concat", False, gain=7000), control_period=0.1, duration=5.0),
        lambda: run(tracker(), q0=1e7),
    ],
    ids=["continuous", "sampled", "without compensator", "diverged", "empty"],
)
def test_run_comes_back_as_it_was_saved(make: Any, tmp_path: Path) -> None:
    record = make()
    path = tmp_path / "run of today"
    record.save(path)
    assert equal(sa.Run.load(path), record)
    assert equal(sa.Run.load(str(path)), record)
    copy = pickle.loads(pickle.dumps(record))
    assert equal(copy, record)
    # The tracker is no record: it is in copies, and not in files.
    assert pickle.dumps(copy.tracker) == pickle.dumps(record.tracker)
    assert sa.Run.load(path).tracker is None
    assert os.listdir(tmp_path) == ["run of today"]
    if len(record.t):
        np.testing.assert_equal(vars(sa.Run.load(path).metrics()), vars(record.metrics()))


def test_missing_file_is_file_not_found(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        sa.Run.load(tmp_path / "none")
    with pytest.raises(FileNotFoundError, match="none"):
        tracker().load(tmp_path / "none")
    for save in (run(tracker()).save, tracker().save):
        with pytest.raises(FileNotFoundError, match="none"):
            save(tmp_path / "none" / "file")


@pytest.mark.parametrize("size", [0, 1, 100, 1000, -1])
def test_cut_run_file_is_an_error(size: int, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    run(tracker()).save(path)
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(ValueError, match=r"^path: got .*run\.npz, wants a file from Run\.save"):
        sa.Run.load(path)


def test_run_file_of_something_else_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    for content in (b"hello", b"PK\x03\x04" + bytes(100), pickle.dumps([1])):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"wants a file from Run\.save"):
            sa.Run.load(path)
    np.savez(path, q=np.zeros(3))
    with pytest.raises(ValueError, match=r"wants a file from Run\.save"):
        sa.Run.load(path)


@pytest.mark.parametrize(
    "change",
    [
        {"meta": np.array(json.dumps({"format": 99}))},
        {"meta": np.array("[]")},
        {"q": np.zeros((3, 2))},
        {"q": np.zeros((11, 2), dtype=np.float32)},
        {"t": np.zeros((11, 1))},
        {"weights": np.zeros((3, 625))},
        {"surplus": np.zeros(3)},
        {"V": np.array([None] * 11, dtype=object)},
        {"q": None},
        {"meta": None},
    ],
    ids=lambda change: "-".join(change),
)
def test_changed_run_file_is_an_error(change: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    run(tracker(), duration=0.01).save(path)
    assert equal(sa.Run.load(path), run(tracker(), duration=0.01))
    with np.load(path) as archive:
        arrays = {name: archive[name] for name in archive.files} | change
    np.savez(path, **{name: value for name, value in arrays.items() if value is not None})
    with pytest.raises(ValueError, match=r"^path: got .*, wants a file from Run\.save \("):
        sa.Run.load(path)


def test_flipped_byte_in_a_run_file_is_an_error_or_harmless(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    record = run(tracker(), duration=0.01)
    record.save(path)
    intact = path.read_bytes()
    for at in range(0, len(intact), max(1, len(intact) // 300)):
        path.write_bytes(intact[:at] + bytes([intact[at] ^ 0x40]) + intact[at + 1 :])
        try:
            loaded = sa.Run.load(path)
        except ValueError as error:
            assert str(error).startswith("path: got")
        else:
            assert equal(loaded, record)


def test_object_arrays_are_never_unpickled(tmp_path: Path) -> None:
    path, fired = tmp_path / "run.npz", tmp_path / "fired"

    class Bomb:
        def __reduce__(self) -> tuple[Any, ...]:
            return (Path.touch, (fired,))

    run(tracker(), duration=0.01).save(path)
    with np.load(path) as archive:
        arrays = {name: archive[name] for name in archive.files}
    np.savez(path, **(arrays | {"q": np.array([Bomb()], dtype=object)}))
    with pytest.raises(ValueError, match=r"wants a file from Run\.save"):
        sa.Run.load(path)
    assert not fired.exists()
    assert zipfile.is_zipfile(path)


@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/full")
def test_full_disk_is_an_error_and_keeps_the_old_file() -> None:
    for save in (run(tracker(), duration=0.01).save,):
        with pytest.raises(OSError, match="No space left"):
            save("/dev/full")


def test_failed_save_keeps_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "state"
    controller = tracker()
    controller.save(path)
    old = path.read_bytes()
    tmp_path.chmod(0o555)
    try:
        if os.access(tmp_path, os.W_OK):
            pytest.skip("this user may write anywhere")
        for save in (controller.save, run(controller, duration=0.01).save):
            with pytest.raises(PermissionError):
                save(path)
        assert path.read_bytes() == old
    finally:
        tmp_path.chmod(0o755)


@pytest.mark.parametrize("make", [tracker, plain], ids=["fuzzy", "plain"])
def test_saved_tracker_goes_on_with_the_same_bits(make: Any, tmp_path: Path) -> None:
    controller, other = make(), make()
    path = tmp_path / "state"
    drive(controller, samples(100))
    controller.save(path)
    drive(other, samples(7, seed=5))
    other.load(str(path))
    assert other.steps == 100
    assert other.tau_model is None
    ahead = samples(1000, seed=2)
    assert drive(other, ahead).tobytes() == drive(controller, ahead).tobytes()
    assert os.listdir(tmp_path) == ["state"]
    controller.save(path)
    other.load(path)
    assert other.steps == 1100


def assert_refused(
    controller: sa.ComputedTorque, content: bytes, path: Path, why: str | None = None
) -> None:
    """Both ways in refuse the bytes, and nothing changes."""
    before = controller.__getstate__()
    with pytest.raises(ValueError, match=why):
        controller.__setstate__(content)
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"^path: got .*state, wants a file of this controller \("):
        controller.load(path)
    assert controller.__getstate__() == before


@pytest.mark.parametrize("make", [lambda: tracker("concat"), plain], ids=["fuzzy", "plain"])
def test_cut_state_is_refused(make: Any, tmp_path: Path) -> None:
    controller = make()
    drive(controller, samples(3))
    saved = controller.__getstate__()
    for size in {*range(0, len(saved), 13), len(saved) - 1}:
        assert_refused(controller, saved[:size], tmp_path / "state", "^saved state: it")
    assert_refused(controller, saved + b"\0", tmp_path / "state", "checksum")


def test_changed_state_is_refused(tmp_path: Path) -> None:
    controller = tracker("concat")
    drive(controller, samples(3))
    saved = controller.__getstate__()
    for at in range(len(saved)):
        changed = bytearray(saved)
        changed[at] ^= 1 << at % 8
        assert_refused(controller, bytes(changed), tmp_path / "state", "^saved state: it")


def test_state_of_another_version_is_refused(tmp_path: Path) -> None:
    controller = tracker("concat")
    saved = bytearray(controller.__getstate__())
    saved[11] += 1
    why = "not saved by this version of steadyarm"
    assert_refused(controller, bytes(saved), tmp_path / "state", why)


@pytest.mark.parametrize("name", ["shared", "grid", "per_joint", "plain"])
def test_state_of_another_controller_is_refused(name: str, tmp_path: Path) -> None:
    controller = plain() if name == "plain" else tracker(name)
    other = tracker("concat")
    drive(controller, samples(3))
    assert_refused(other, controller.__getstate__(), tmp_path / "state", "^rules: got")
    assert_refused(controller, other.__getstate__(), tmp_path / "state", "^rules: got")


def test_prior_is_refused_by_a_controller_that_has_no_use_for_it(tmp_path: Path) -> None:
    leaky, firm = tracker("concat", leak_rate=0.1), tracker("concat")
    leaky.warm_start(np.ones((2, 20)))
    why = "another compensator"
    assert_refused(firm, leaky.__getstate__(), tmp_path / "state", why)
    with pytest.raises(ValueError, match="it belongs to a controller with other modifications"):
        firm.load(tmp_path / "state", other=True)


def arms() -> tuple[sa.TwoLink, sa.TwoLink]:
    return nominal(), sa.TwoLink(mass=(4, 4.01), length=0.5, inertia=0.2)


def shared(arm: int = 0, kp: float = 8, kv: float = 5.5, **changed: Any) -> sa.ComputedTorque:
    """One of five rules; all of it can be another one of the same size."""
    sets = {"centers": (-1.5, -0.5, 0.0, 0.5, 1.5), "width": 0.7, "inputs": "error"}
    sets["normalized"] = True
    law = {name: changed.pop(name) for name in list(changed) if name not in sets}
    basis = sa.FuzzyBasis("shared", **(sets | changed))
    return sa.ComputedTorque(arms()[arm], kp, kv, sa.FuzzyCompensator(basis, **law))


GAINS, COMPENSATOR, BASIS = "other gains kp, kv", "another compensator", "another basis"
OTHERS = {
    "arm": ({"arm": 1}, "another nominal arm"),
    "kp": ({"kp": 8.000001}, GAINS),
    "kv": ({"kv": (5.5, 5.4)}, GAINS),
    "gain": ({"gain": (1.0, 2.0)}, COMPENSATOR),
    "q": ({"q": 11.0}, COMPENSATOR),
    "gamma": ({"gamma": 1.1}, COMPENSATOR),
    "leak": ({"leak_rate": 0.1}, COMPENSATOR),
    "error modification": ({"error_modification": 0.1}, COMPENSATOR),
    "radius": ({"projection_radius": 5.0}, COMPENSATOR),
    "dead zone": ({"dead_zone": 0.1}, COMPENSATOR),
    "normalization": ({"normalization": 0.1}, COMPENSATOR),
    "centres": ({"centers": (-1.5, -0.5, 0.0, 0.5, 1.6)}, BASIS),
    "width": ({"width": 0.71}, BASIS),
    "raw": ({"normalized": False}, BASIS),
    "inputs": ({"inputs": "state"}, BASIS),
    "scale": ({"inputs": {"e": 1.0, "de": 0.5}}, BASIS),
    "order": ({"inputs": ["de", "e"]}, BASIS),
}


@pytest.mark.parametrize("name", OTHERS)
def test_weights_of_another_meaning_are_refused_and_say_what_differs(
    name: str, tmp_path: Path
) -> None:
    changed, what = OTHERS[name]
    path, controller, other = tmp_path / "state", shared(), shared(**changed)
    drive(controller, samples(20))
    # Ends the period that is pending: another controller would learn something else from it.
    controller.freeze()
    assert_refused(other, controller.__getstate__(), path, what)
    with pytest.raises(ValueError, match=f"{what}.*other=True takes it all the same"):
        other.load(path)
    differing = {"another nominal arm", GAINS, COMPENSATOR, BASIS} - {what}
    with pytest.raises(ValueError) as refusal:
        other.load(path)
    assert not any(words in str(refusal.value) for words in differing)
    other.load(path, other=True)
    np.testing.assert_array_equal(other.weights, controller.weights)
    assert other.steps == 20 and other.frozen
    learnt = controller.weights
    controller.unfreeze()
    drive(controller, samples(1))
    controller.save(path)
    other.load(path, other=True)
    np.testing.assert_array_equal(other.weights, learnt)
    shared().load(path)


def test_all_that_differs_is_said(tmp_path: Path) -> None:
    controller, other = shared(), shared(arm=1, kp=9, gain=2.0, width=0.5)
    controller.save(tmp_path / "state")
    words = f"another nominal arm, {GAINS}, {COMPENSATOR} .*, {BASIS}"
    with pytest.raises(ValueError, match=words):
        other.load(tmp_path / "state")


def test_plain_computed_torque_of_another_arm_is_refused(tmp_path: Path) -> None:
    sa.ComputedTorque(arms()[0], 8, 5.5).save(tmp_path / "state")
    for other, words in (
        (sa.ComputedTorque(arms()[1], 8, 5.5), "another nominal arm"),
        (sa.ComputedTorque(arms()[0], 9, 5.5), GAINS),
    ):
        with pytest.raises(ValueError, match=words):
            other.load(tmp_path / "state")


def old(kind: str) -> sa.ComputedTorque:
    if kind == "shared":
        return tracker("shared", leak_rate=0.1, gain=7.0)
    return tracker("grid", gain=7.0, dictionary=6) if kind == "dictionary" else plain()


# The torque that the version which wrote it gave at the third of the samples of seed 2.
OLD = {
    "shared": (-28.494830738041568, -10.440368405235196),
    "dictionary": (-27.91340109936263, -10.234192896020451),
    "plain": (0.7472554711110193, 1.4118155982186513),
}


@pytest.mark.parametrize("kind", OLD)
def test_a_file_of_version_1_is_taken_with_a_warning(kind: str, tmp_path: Path) -> None:
    path, controller = Path(__file__).parent / "files" / f"state_1_{kind}.bin", old(kind)
    with pytest.warns(UserWarning, match=r"state_1_\w+\.bin, .* not looked at; save it again"):
        controller.load(path)
    assert controller.steps == 50
    np.testing.assert_array_equal(drive(controller, samples(3, seed=2))[-1], OLD[kind])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        untouched = old(kind)
        before = untouched.__getstate__()
        with pytest.raises(UserWarning):
            untouched.load(path)
        assert untouched.__getstate__() == before
        # Who says that he knows is not warned; nor is a pickle, which has its controller with it.
        untouched.load(path, other=True)
        old(kind).__setstate__(path.read_bytes())
        controller.save(tmp_path / "state")
        old(kind).load(tmp_path / "state")


def sealed(body: bytes) -> bytes:
    total = 0xCBF29CE484222325
    for byte in body:
        total = (total ^ byte) * 0x100000001B3 % 2**64
    return body + total.to_bytes(8, "little")


def forged(saved: bytes, word: int, value: float | int) -> bytes:
    """With another word after magic and version, and the right checksum."""
    raw = value.to_bytes(8, "little") if isinstance(value, int) else np.float64(value).tobytes()
    at = 12 + 8 * word
    return sealed(saved[:at] + raw + saved[at + 8 : -8])


# joints, rules, flags, steps, advances, last torque (2), fingerprints (4), dt, asked for (2),
# commanded (2), q, dq, q_d, dq_d, ddq_d (10), W (10), norms (2).
FORGED = [
    *((2, flags) for flags in (64, 1 << 63, 16 + 8)),
    *((3, steps) for steps in (2**64 - 1, 2**63)),
    (4, 2**64 - 1),
    *((5, tau) for tau in (np.nan, np.inf, 1.1e10, -1e300)),
    *((11, dt) for dt in (0.0, -1.0, np.nan, 2.0)),
    *((12, tau) for tau in (np.nan, np.inf)),
    (15, -np.inf),
    *((word, value) for word in range(16, 26) for value in (np.nan, 1e300)),
    *((26, w) for w in (np.nan, np.inf, 2e150, 1.0)),
    *((37, norm) for norm in (np.nan, -1.0, np.inf, 1e-3, 0.0)),
]


@pytest.mark.parametrize("place", FORGED, ids=str)
def test_a_forged_state_with_the_right_checksum_is_refused(
    place: tuple[int, float | int], tmp_path: Path
) -> None:
    controller = shared(gain=50.0)
    drive(controller, samples(20))
    saved = controller.__getstate__()
    assert sealed(saved[:-8]) == saved and len(saved) == 12 + 8 * 39
    assert_refused(shared(gain=50.0), forged(saved, *place), tmp_path / "state")
    with pytest.raises(ValueError):
        shared(gain=50.0).load(tmp_path / "state", other=True)


@pytest.mark.parametrize("form", ["none", "dictionary"])
def test_a_counter_of_a_compensator_that_counts_nothing_is_refused(
    form: str, tmp_path: Path
) -> None:
    controller = (
        sa.ComputedTorque(sa.paper.nominal(), 8, 5.5)
        if form == "none"
        else tracker("grid", dictionary=6)
    )
    drive(controller, samples(4))
    bad = forged(controller.__getstate__(), 4, 1)
    assert_refused(controller, bad, tmp_path / "state", "not a possible one")


def ended(controller: sa.ComputedTorque) -> None:
    """Leave no period pending."""
    controller.freeze()


def test_a_state_that_hides_its_last_torque_is_refused(tmp_path: Path) -> None:
    controller = shared()
    drive(controller, samples(20))
    ended(controller)
    saved = controller.__getstate__()
    hidden = forged(saved, 2, int.from_bytes(saved[28:36], "little") & ~4)
    assert_refused(shared(), hidden, tmp_path / "state", "says that it has none")


def test_a_dictionary_with_other_norms_is_refused(tmp_path: Path) -> None:
    controller = tracker("grid", dictionary=6, merge_tolerance=0.0)
    drive(controller, samples(4))
    ended(controller)
    saved = controller.__getstate__()
    # After the fingerprints: capacity, atoms, merged, dropped, scale (2), norms (2).
    norm = np.frombuffer(saved[12 + 8 * 17 : 12 + 8 * 18])[0]
    assert norm > 0.0
    for other in (0.0, 2 * norm, 1e300):
        bad = forged(saved, 17, float(other))
        assert_refused(tracker("grid", dictionary=6, merge_tolerance=0.0), bad, tmp_path / "state")
    wrapping = forged(saved, 13, 2**64 - 1)
    assert_refused(controller, wrapping, tmp_path / "state", "not a possible one")
    # Then errors (2), and of each atom its memberships in 20 sets and its coefficients (2): their
    # squares would be infinite, and infinite norms are no norms.
    for factor in (1e200, -1e155, np.inf, np.nan):
        assert_refused(controller, forged(saved, 21 + 20, factor), tmp_path / "state")


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=300, deadline=None)
def test_a_random_word_in_a_saved_state_is_refused_or_harmless(seed: int) -> None:
    """Whatever is taken gives finite torques, and comes back as it was taken."""
    random = np.random.default_rng(seed)
    controller = shared() if seed % 2 else tracker("grid", dictionary=6)
    drive(controller, samples(8, seed=seed % 100))
    saved = controller.__getstate__()
    word = int(random.integers((len(saved) - 20) // 8))
    bits = int(random.integers(2**64, dtype=np.uint64))
    old_word = int.from_bytes(saved[12 + 8 * word : 20 + 8 * word], "little")
    value = [bits, old_word ^ 1 << (bits % 64), int(np.float64(bits % 10).view(np.uint64))][
        bits % 3
    ]
    bad = forged(saved, word, value)
    try:
        controller.__setstate__(bad)
    except ValueError:
        assert controller.__getstate__() == saved
        return
    taken = controller.__getstate__()
    # A weight that no step leaves so small is taken as zero.
    tiny = 0.0 < abs(np.uint64(value).view(np.float64)) < 1e-150
    assert taken == bad or tiny
    controller.__setstate__(taken)
    assert controller.__getstate__() == taken
    for sample in samples(5, seed=1):
        try:
            assert np.isfinite(controller.step(*sample, 1e-3)).all()
        except ValueError as error:
            assert str(error).startswith(("weights", "tau"))


def test_weights_beyond_the_projections_radius_are_refused(tmp_path: Path) -> None:
    """They would be drawn back within a step: the torque jumps from -385 to -1.6 N·m."""
    free, tight = shared(), shared(projection_radius=2.0)
    free.weights = np.full((2, 5), 100.0)
    free.save(tmp_path / "state")
    words = r"weights: got a norm of 316\.\d*, wants at most the projection_radius, 2; "
    with pytest.raises(ValueError, match=words):
        tight.weights = free.weights
    with pytest.raises(ValueError, match=words):
        tight.load(tmp_path / "state", other=True)
    assert not tight.weights.any()
    # As a prior they are right, and a norm at the radius is.
    tight.warm_start(free.weights)
    tight.weights = np.full((2, 5), 2.0 / 10**0.5)


@pytest.mark.parametrize("value", [None, 3, "bytes", bytearray(5), [1]], ids=repr)
def test_state_that_is_no_bytes_is_refused(value: Any) -> None:
    with pytest.raises(TypeError, match=r"^saved state: got \w+, wants bytes"):
        tracker().__setstate__(value)


@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/zero")
def test_endless_file_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^path: got /dev/zero, wants a file of at most"):
        tracker().load("/dev/zero")


def test_directory_is_an_os_error(tmp_path: Path) -> None:
    for load in (sa.Run.load, tracker().load):
        with pytest.raises(OSError, match=tmp_path.name):
            load(tmp_path)
    with pytest.raises(OSError, match=tmp_path.name):
        tracker().save(tmp_path)
    assert list(tmp_path.parent.glob("*.tmp")) == []


def test_a_pickled_riccati_solution_is_the_same() -> None:
    A, B = np.array([[0.0, 1.0], [-8.0, -5.5]]), np.array([[0.0], [1.0]])
    for solution in (
        sa.bounded_real_riccati(A, B, 10 * np.eye(2), gamma=0.7),
        sa.care(A, B, 10 * np.eye(2), [[2.0]]),
    ):
        copy = pickle.loads(pickle.dumps(solution))
        assert copy.P.tobytes() == solution.P.tobytes()
        assert (copy.gamma, copy.gamma_opt) == (solution.gamma, solution.gamma_opt)
        assert repr(copy) == repr(solution)


def test_a_pickled_approximator_is_the_same() -> None:
    x = np.linspace(-1, 1, 40)[:, None]
    basis = sa.FuzzyBasis("grid", np.linspace(-1, 1, 6), 0.4)
    fitted = sa.FuzzyApproximator.fit(basis, x, np.sin(3 * x))
    copy = pickle.loads(pickle.dumps(fitted))
    assert copy(x).tobytes() == fitted(x).tobytes()
    with pytest.raises(ValueError, match=r"^weights: got shape \(1, 5\), wants \(outputs, 6\)"):
        sa.FuzzyApproximator.from_weights(basis, 1, np.ones((1, 5)))


def test_an_approximator_may_stand_anywhere_in_memory() -> None:
    """Python puts objects at multiples of 16 bytes; registers read 64 at a time from a basis."""
    x = np.linspace(-1, 1, 40)[:, None]
    basis = sa.FuzzyBasis("grid", np.linspace(-1, 1, 6), 0.4)
    fitted = sa.FuzzyApproximator.fit(basis, x, np.sin(3 * x))
    expected, kept = fitted(x), []
    for size in range(100):
        kept.append((bytearray(16 * size), pickle.loads(pickle.dumps(fitted))))
    assert all(copy(x).tobytes() == expected.tobytes() for _, copy in kept)
