"""The same bits: in a loop by hand, again, in threads, in processes, pickled, on every machine."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import re
import struct
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from scenes import ZERO, actual, drive, nominal, plant, run, samples, tracker

RUST_TESTS = Path(__file__).parents[1] / "std" / "determinism.rs"
"""The golden hashes stand there, once for both languages."""

ARRAYS = ("t", "q", "dq", "e", "tau", "rho", "rho_hat", "weights", "weights_norm", "V")

CONTROLLERS: dict[str, dict[str, Any]] = {
    "grid": {},
    "concat, raw": {"form": "concat", "normalized": False, "gain": 70},
    "per joint, everything": {
        "form": "per_joint",
        "inputs": "trajectory",
        "gain": 70,
        "leak_rate": 0.3,
        "error_modification": 0.1,
        "projection_radius": 2.0,
        "dead_zone": 0.02,
        "normalization": 0.2,
        "limits": {"effort_limit": 12.0, "effort_rate_limit": 800.0},
    },
}


def same(one: sa.Run, other: sa.Run) -> bool:
    """Whether two runs agree in every bit."""
    pairs = ((getattr(one, name), getattr(other, name)) for name in ARRAYS)
    return one.status == other.status and all(
        (a is None and b is None) or a.tobytes() == b.tobytes() for a, b in pairs
    )


def fnv1a(values: np.ndarray) -> int:
    """FNV-1a, 64 bits, over the bytes of little-endian doubles."""
    digest = 0xCBF2_9CE4_8422_2325
    for byte in struct.pack(f"<{values.size}d", *values.ravel()):
        digest = (digest ^ byte) * 0x0000_0100_0000_01B3 % 2**64
    return digest


@pytest.mark.parametrize("hold", [1, 5])
@pytest.mark.parametrize("name", CONTROLLERS)
def test_sampled_simulation_is_the_loop_of_step_and_plant_step(name: str, hold: int) -> None:
    dt, steps = 1e-3, 1000
    controller, real, reference = tracker(**CONTROLLERS[name]), plant(), sa.paper.reference()
    found = run(controller, control_period=hold * dt, q0=(0.5, -0.5), dq0=(0.1, 0.2))
    q, dq = np.array([0.5, -0.5]), np.array([0.1, 0.2])
    tau = ZERO
    for k in range(steps):
        t = k * dt
        if k % hold == 0:
            tau = controller.step(q, dq, *reference(t), hold * dt)
        assert q.tobytes() == found.q[k].tobytes()
        assert dq.tobytes() == found.dq[k].tobytes()
        assert tau.tobytes() == found.tau[k].tobytes()
        q, dq = real.step(q, dq, tau, t, dt)
    assert q.tobytes() == found.q[steps].tobytes()
    assert controller.weights.tobytes() == found.weights.tobytes()


@pytest.mark.parametrize("options", [{}, {"method": "dp54"}, {"control_period": 1e-3}], ids=repr)
def test_same_run_again_has_the_same_bits(options: dict[str, Any]) -> None:
    controller = tracker("concat", gain=70)
    first = run(controller, **options)
    assert same(first, run(controller, **options))
    assert same(first, run(tracker("concat", gain=70), **options))


def test_record_every_thins_the_record_and_nothing_else() -> None:
    full, thin = run(tracker()), run(tracker(), record_every=7)
    assert thin.q.tobytes() == np.concatenate([full.q[::7], full.q[-1:]]).tobytes()
    assert thin.weights.tobytes() == full.weights.tobytes()


@pytest.mark.parametrize("options", [{}, {"method": "dp54"}, {"control_period": 1e-3}], ids=repr)
def test_record_of_the_motion_leaves_out_the_torque_and_nothing_else(
    options: dict[str, Any], tmp_path: Path
) -> None:
    full, motion = run(tracker(), **options), run(tracker(), record="motion", **options)
    assert "q_d" not in vars(motion)
    assert same(pickle.loads(pickle.dumps(motion)), motion)
    for name in ("t", "q", "dq", "q_d", "dq_d", "ddq_d", "e", "de", "weights"):
        assert getattr(motion, name).tobytes() == getattr(full, name).tobytes(), name
    for name in ("tau", "tau_model", "tau_compensation", "rho", "rho_hat"):
        assert getattr(motion, name).shape == (0, 2), name
    assert motion.weights_norm is None and motion.V is None
    assert motion.certificate == full.certificate
    figures = motion.metrics()
    assert figures.rms_e.tobytes() == full.metrics().rms_e.tobytes()
    assert figures.rms_tau.size == figures.max_abs_tau.size == figures.torque_variation.size == 0
    assert "rms_e" in str(figures) and "tau" not in str(figures)
    motion.save(tmp_path / "run.npz")
    assert same(sa.Run.load(tmp_path / "run.npz"), motion)
    assert len(motion.plot().axes) == 2 * 2


def test_record_of_the_motion_asks_a_callable_again() -> None:
    calls: list[float] = []

    def reference(t: float) -> tuple[Any, Any, Any]:
        calls.append(t)
        if len(calls) > 5000:
            raise RuntimeError("that is enough")
        return [0.1 * t, 0.0], [0.1, 0.0], [0.0, 0.0]

    def motion() -> sa.Run:
        return sa.simulate(plant(), tracker(), reference, 0.2, record="motion")

    first = motion()
    calls.clear()
    assert first.e[-1, 0] == first.q[-1, 0] - 0.1 * first.t[-1]
    assert calls == first.t.tolist()
    assert first.q_d.shape == first.ddq_d.shape == (201, 2) and len(calls) == 201
    second = motion()
    calls.extend(5000 * [0.0])
    with pytest.raises(RuntimeError, match="that is enough"):
        second.metrics()
    calls.clear()
    assert same(copy.copy(second), first)
    assert "_reference" not in vars(copy.copy(second)) and not hasattr(second, "torque")


def test_set_points_that_are_no_numbers_are_refused_when_asked_for() -> None:
    desired = [0.0]
    run = sa.simulate(
        plant(), tracker(), lambda t: (desired * 2, [0, 0], [0, 0]), 0.1, record="motion"
    )
    desired[0] = float("nan")
    with pytest.raises(ValueError, match=r"^reference: got no number at t = 0 s"):
        _ = run.e


def test_progress_bar_changes_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert same(run(tracker(), progress=True), run(tracker()))


@pytest.mark.parametrize("options", [{}, {"control_period": 1e-3}], ids=repr)
def test_threads_on_one_tracker_have_the_bits_of_a_serial_run(options: dict[str, Any]) -> None:
    controller = tracker(gain=700)
    serial = run(controller, **options)
    with ThreadPoolExecutor(4) as pool:
        runs = list(pool.map(lambda _: run(controller, **options), range(8)))
    assert all(same(serial, other) for other in runs)
    assert controller.steps == 0


def test_tracker_may_step_while_a_thread_simulates_it() -> None:
    controller, twin = tracker(), tracker()
    serial = run(controller, duration=5.0)
    steps = samples(200)
    with ThreadPoolExecutor(1) as pool:
        going = pool.submit(run, controller, duration=5.0)
        while not going.running() and not going.done():
            pass
        drive(controller, steps)
        going.result()
    assert drive(controller, steps).tobytes() == drive(twin, steps + steps)[200:].tobytes()
    assert serial.status.finished


@pytest.mark.parametrize("name", [*CONTROLLERS, "plain with limits"])
def test_pickled_tracker_goes_on_with_the_same_bits(name: str) -> None:
    if name in CONTROLLERS:
        controller = tracker(**CONTROLLERS[name])
        controller.warm_start(np.full_like(controller.weights, 1e-3))
    else:
        controller = sa.ComputedTorque(nominal(), 8, 5.5, None, 12, 800)
    drive(controller, samples(300, seed=1))
    restored = pickle.loads(pickle.dumps(controller))
    copied = copy.deepcopy(controller)
    assert restored.steps == copied.steps == 300
    ahead = samples(10_000, seed=2)
    expected = drive(controller, ahead).tobytes()
    assert drive(restored, ahead).tobytes() == expected
    assert drive(copied, ahead).tobytes() == expected
    assert restored.__getstate__() == controller.__getstate__()


def test_pickled_frozen_tracker_stays_frozen() -> None:
    controller = tracker("concat")
    drive(controller, samples(10))
    controller.freeze()
    restored = pickle.loads(pickle.dumps(controller))
    assert restored.frozen
    assert restored.weights.tobytes() == controller.weights.tobytes()


def test_pickle_does_not_see_later_changes_of_an_argument() -> None:
    kp, limit = np.array([8.0, 8.0]), np.array([3.0, 3.0])
    controller = sa.ComputedTorque(nominal(), kp, 5.5)
    real = sa.Plant(actual(), effort_limit=limit)
    kp[:], limit[:] = 1, 1
    assert np.array_equal(pickle.loads(pickle.dumps(controller)).kp, [8, 8])
    assert np.array_equal(pickle.loads(pickle.dumps(real)).effort_limit, [3, 3])


@pytest.mark.parametrize(
    "thing",
    [
        sa.TwoLink((4, 3), 0.5, 0.2, 9.81, 0.1, (0.2, 0), 0.05),
        sa.FuzzyBasis(
            "grid", [(-1, 0), (0, 1), (2,), (3,)], (0.1, 0.2, 0.3, 0.4), False, {"e": 2, "q": 1}
        ),
        sa.FuzzyCompensator(
            sa.FuzzyBasis("shared", (0, 1), 1.0), 3, (1, 2), 2.0, 0.1, 0.2, 0.3, 0.4, 0.5
        ),
        sa.paper.reference(),
        sa.Sines(2.0, sin=(1, 2), offset=3),
        sa.Quintic(0, (1, 2), 3, 4),
        sa.Table((0, 1, 2), np.arange(6.0).reshape(3, 2)),
        sa.Plant(sa.paper.actual(), sa.paper.disturbance(), (3, np.inf)),
        sa.paper.simulation(3),
    ],
    ids=lambda thing: type(thing).__name__,
)
def test_pickled_object_is_the_same_object(thing: object) -> None:
    restored = pickle.loads(pickle.dumps(thing))
    assert type(restored) is type(thing)
    assert repr(restored) == repr(thing)
    assert pickle.dumps(restored) == pickle.dumps(pickle.loads(pickle.dumps(restored)))


def run_scene(scene: sa.paper.Scene) -> sa.Run:
    return scene.run()


@pytest.mark.parametrize("start", ["spawn", "fork"])
def test_processes_have_the_bits_of_this_one(start: str) -> None:
    if start not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system has no {start}")
    scenes = [
        sa.paper.simulation(3, preset="claimed", duration=1.0),
        sa.paper.simulation(3, form="concat", gain=70, duration=1.0),
    ]
    context = multiprocessing.get_context(start)
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        runs = list(pool.map(run_scene, scenes))
    assert all(same(found, scene.run()) for found, scene in zip(runs, scenes, strict=True))


@pytest.mark.parametrize(
    ("name", "method"), [("CONTINUOUS", "rk4"), ("ERROR_CONTROLLED", "dp54")], ids=["rk4", "dp54"]
)
def test_final_state_has_its_golden_hash(name: str, method: str) -> None:
    """625 rules, normalised, gain 7000, q0 = (0.5, -0.5), dt 1 ms, 5 s: last q dq tau V W."""
    if not RUST_TESTS.exists():
        pytest.skip("the golden hashes stand in the source tree")
    (golden,) = re.findall(rf"const {name}: u64 = (0x[0-9a-f_]+);", RUST_TESTS.read_text())
    final = run(tracker(gain=7000), duration=5.0, q0=(0.5, -0.5), method=method)
    state = np.concatenate(
        [final.q[-1], final.dq[-1], final.tau[-1], final.V[-1:], final.weights.ravel()]
    )
    assert f"{fnv1a(state):#018x}" == f"{int(golden, 16):#018x}"
