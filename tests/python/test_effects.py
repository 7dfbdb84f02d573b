"""Effects between controller and arm: each does what its words say, alone and with the others."""

from __future__ import annotations

import hashlib
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from law_scenes import CHAIN, TWO, H, made, nominal, plant, reference, simulated, start

STEPS = 400


def run(name: str = "computed_torque", steps: int = STEPS, **effects: Any) -> sa.Run:
    found = simulated(made(name, TWO), TWO, steps, effects=sa.Effects(**effects))
    assert found.status.finished
    return found


def sampled(found: sa.Run) -> tuple[np.ndarray, np.ndarray]:
    """Measured positions and velocities, a row a sample; the last row of a run is none."""
    return found.q_measured[:-1], found.dq_measured[:-1]


def test_the_channels_are_there_with_units() -> None:
    found = run(delay=1, cogging=0.2, cogging_per_turn=30.0)
    units = {name: found.channels[name].unit for name in list(found.channels)[-6:]}
    assert units == {
        "q_measured": "rad", "dq_measured": "rad/s", "tau_commanded": "N·m", "q_motor": "rad",
        "tau_cogging": "N·m", "sample_age": "s",
    }  # fmt: skip
    assert (found.q_motor == found.q).all(), "links follow their motors"
    assert np.allclose(found.tau_cogging, 0.2 * np.sin(30.0 * found.q), rtol=0, atol=1e-12)
    assert "q_measured" not in simulated(made("pid", TWO), TWO).channels


@pytest.mark.parametrize(
    "name", ["computed_torque", "momentum_observer", "slotine_li", "time_delay"]
)
@pytest.mark.parametrize("seed", [0, 7])
def test_all_off_is_a_run_without_to_the_bit(name: str, seed: int) -> None:
    bare = simulated(made(name, TWO), TWO, STEPS)
    for off in (sa.Effects(seed=seed), sa.Effects(gain=1.0, lag=0.0, drop=0.0, seed=seed)):
        found = simulated(made(name, TWO), TWO, STEPS, effects=off)
        for channel in bare.channels:
            assert np.array_equal(getattr(found, channel), getattr(bare, channel)), channel


@pytest.mark.parametrize("bits", [8, 16, [10, 20]])
def test_an_encoder_measures_whole_steps(bits: Any) -> None:
    found = run(encoder_bits=bits)
    q, _ = sampled(found)
    step = 2 * np.pi / 2.0 ** np.asarray(bits)
    assert np.allclose(q / step, np.rint(q / step), rtol=0, atol=1e-6)
    assert (abs(q - found.q[:-1]) <= step / 2 * (1 + 1e-9)).all()
    assert (abs(q - found.q[:-1]).max(axis=0) > step / 4).all()


def test_noise_has_its_deviation_and_is_independent() -> None:
    found = run(steps=2000, noise=[1e-5, 3e-5], velocity_noise=2e-3)
    off = np.hstack([sampled(found)[0] - found.q[:-1], sampled(found)[1] - found.dq[:-1]])
    wanted = np.array([1e-5, 3e-5, 2e-3, 2e-3])
    # Of 2000 draws the deviation is known to 1.6 %, a correlation to 0.022: five of these.
    assert np.allclose(off.std(axis=0) / wanted, 1.0, atol=0.08)
    assert (abs(np.corrcoef(off.T) - np.eye(4)) < 0.11).all()
    assert (abs(off.mean(axis=0) / wanted) < 0.11).all()


def difference(q: np.ndarray) -> np.ndarray:
    v, share = np.zeros_like(q), 1 - np.exp(-2 * np.pi * 80.0 * H)
    for k in range(1, len(q)):
        v[k] = v[k - 1] + share * ((q[k] - q[k - 1]) / H - v[k - 1])
    return v


def tracking(q: np.ndarray, r: float = 250.0) -> np.ndarray:
    """Z' = A Z + B q held for a period, by the exponential of the matrix, from its series."""
    a = np.array([[0, 1, 0, 0], [-r * r, -2 * r, r * r, 0], [0, 0, 0, 1], [0, 0, 0, 0]]) * H
    power, whole = np.eye(4), np.eye(4)
    for k in range(1, 40):
        power = power @ a / k
        whole = whole + power
    v = np.zeros_like(q)
    for joint in range(q.shape[1]):
        z = np.array([q[0, joint], 0.0])
        for k in range(1, len(q)):
            last = q[k - 1, joint]
            z = whole[:2] @ [*z, last, (q[k, joint] - last) / H]
            v[k, joint] = z[1]
    return v


def kalman(q: np.ndarray) -> np.ndarray:
    """The filter with its Riccati equation iterated to rest: encoder 14 bits, noise 1e-5."""
    scatter = np.hypot(2 * np.pi / 2**14 / np.sqrt(12), 1e-5)
    f, noise = np.array([[1, H], [0, 1]]), 20.0**2 * np.outer([H**2 / 2, H], [H**2 / 2, H])
    p = np.eye(2)
    for _ in range(20_000):
        p = f @ p @ f.T + noise
        gain = p[:, 0] / (p[0, 0] + scatter**2)
        p = p - np.outer(gain, p[0])
    x, v = np.array([q[0], 0 * q[0]]), np.zeros_like(q)
    for k in range(1, len(q)):
        x = f @ x
        x = x + np.outer(gain, q[k] - x[0])
        v[k] = x[1]
    return v


@pytest.mark.parametrize(
    ("model", "velocity", "options"),
    [
        (difference, "difference", {"velocity_cutoff": 80.0}),
        (tracking, "tracking", {"velocity_bandwidth": 250.0}),
        (kalman, "kalman", {"velocity_acceleration": 20.0}),
    ],
)
def test_a_velocity_of_positions_is_that_of_numpy(
    model: Any, velocity: str, options: dict[str, float]
) -> None:
    found = run(encoder_bits=14, noise=1e-5, velocity=velocity, **options)
    q, dq = sampled(found)
    assert np.allclose(dq, model(q), rtol=1e-7, atol=1e-7)
    assert abs(dq[50:] - found.dq[50:-1]).max() < 0.4


@pytest.mark.parametrize("delay", [1, 2, 4])
def test_a_delay_shifts_the_torque_by_so_many_rows(delay: int) -> None:
    found = run(delay=delay)
    sent = found.tau_commanded[: STEPS - delay]
    assert (found.tau[delay:STEPS] == sent).all()
    assert (found.tau[:delay] == nominal(TWO).gravity(found.q[0])).all()
    tracker = made("computed_torque", TWO, last_tau=[3.0, -2.0])
    found = simulated(tracker, TWO, effects=sa.Effects(delay=delay))
    assert (found.tau[:delay] == [3.0, -2.0]).all()


def test_jitter_moves_the_samples_evenly_around_their_times() -> None:
    found = run(steps=2000, jitter=0.4, seed=5)
    times = np.unique(np.round((found.t - found.sample_age)[:-1] / H, 6))
    off = times - np.rint(times)
    assert (found.sample_age > -1e-12).all() and (found.sample_age < 1.4 * H).all()
    # Samples that came between two rows both, a fifth at the most, are not seen.
    assert abs(off).max() <= 0.2 + 1e-6 and off[0] == 0.0 and len(times) > 1400
    assert np.ptp(off) > 0.38


def test_a_lost_sample_holds_torque_and_measurement() -> None:
    found = run(steps=2000, drop=0.3, seed=5)
    lost = found.sample_age[:-1] > H / 2
    # Of 2000 draws a share of 0.3 is known to 0.01: five of these.
    assert abs(lost.mean() - 0.3) < 0.05 and not lost[0]
    for held in (found.tau, found.q_measured, found.dq_measured, found.tau_commanded):
        same = (held[1:-1] == held[:-2]).all(axis=1)
        assert (same == lost[1:]).all()
    age = found.sample_age / H
    assert np.allclose(age, np.rint(age), atol=1e-6)


def test_a_drive_follows_no_faster_than_its_rate_limit() -> None:
    found, rate = run(effort_rate_limit=[500.0, 2000.0]), np.array([500.0, 2000.0])
    limited, told = nominal(TWO).gravity(found.q[0]), []
    for sent in found.tau_commanded[:STEPS]:
        limited = np.clip(sent, limited - rate * H, limited + rate * H)
        told.append(limited)
    assert np.allclose(found.tau[:STEPS], told, rtol=0, atol=1e-12)
    assert abs(found.tau - found.tau_commanded).max() > 1.0


def test_a_gain_is_what_arrives() -> None:
    found = run(gain=[0.9, 1.1])
    assert np.allclose(found.tau[:STEPS], [0.9, 1.1] * found.tau_commanded[:STEPS], rtol=1e-14)


def test_a_lag_is_a_first_order_filter() -> None:
    lag = np.array([2e-3, 10e-3])
    found = run(lag=lag, gain=1.2)
    arrived, fading = [1.2 * nominal(TWO).gravity(found.q[0])], np.exp(-H / lag)
    for sent in found.tau_commanded[: STEPS - 1]:
        arrived.append(1.2 * sent + (arrived[-1] - 1.2 * sent) * fading)
    assert np.allclose(found.tau[:STEPS], arrived, rtol=1e-12, atol=1e-12)


def test_cogging_is_a_torque_that_opposes_by_position() -> None:
    found = run(cogging=[0.5, 0.2], cogging_per_turn=40.0)
    pushed = sa.Plant(plant(TWO).arm, lambda q, dq, t: [0.5, 0.2] * np.sin(40.0 * q))
    options = {"control_period": H} | start(TWO)
    other = sa.simulate(
        pushed, made("computed_torque", TWO), reference(TWO), STEPS * H, H, **options
    )
    assert np.allclose(found.q, other.q, rtol=0, atol=1e-12)
    assert abs(found.q - run().q).max() > 1e-5


GEARS = {"joint_stiffness": 2e4, "joint_damping": 20.0, "rotor_inertia": 0.1}


def geared(side: str = "motor", **more: Any) -> sa.Run:
    """An arm whose gears give, and which is to stand still."""
    pose = sa.Sines(1.0, sin=np.zeros(2), offset=[0.2, -0.9])
    effects = sa.Effects(encoder_side=side, **(GEARS | more))
    options = {"control_period": H, "effects": effects, "q0": pose(0.0)[0]}
    return sa.simulate(sa.Plant(nominal(TWO)), made("pid", TWO), pose, 2.0, H, **options)


def test_gears_give_by_the_torque_that_they_carry() -> None:
    at_motor, at_link = geared("motor"), geared("link")
    assert at_motor.status.finished and at_link.status.finished
    carried = nominal(TWO).gravity(at_motor.q[-1]) / 2e4
    assert np.allclose(at_motor.q_measured[-1] - at_motor.q[-1], carried, rtol=0, atol=1e-6)
    assert abs(carried).max() > 1e-3
    assert (sampled(at_motor)[0] == at_motor.q_motor[:-1]).all()
    assert (sampled(at_link)[0] == at_link.q[:-1]).all()


def test_stiff_gears_are_a_rigid_arm_with_rotors() -> None:
    bare = nominal(CHAIN).with_armature(0.0)
    effects = sa.Effects(joint_stiffness=1e5, joint_damping=30.0, rotor_inertia=0.1)
    options = {"control_period": H} | start(CHAIN)
    arms = [(sa.Plant(bare), effects), (sa.Plant(bare.with_armature(0.1)), None)]
    scene = (made("computed_torque", CHAIN), reference(CHAIN), 0.04, H)
    runs = [sa.simulate(arm, *scene, effects=it, **options) for arm, it in arms]
    # Off by the torque over the stiffness: 60 N·m / 1e5.
    assert abs(runs[0].q - runs[1].q).max() < 1e-3


def test_backlash_lets_the_motor_move_by_half_the_play() -> None:
    found = geared(backlash=2e-3)
    carried = nominal(TWO).gravity(found.q[-1])
    assert (abs(carried) > 1.0).all()
    apart = (found.q_measured[-1] - found.q[-1] - carried / 2e4) * np.sign(carried)
    assert np.allclose(apart, 1e-3, rtol=0, atol=1e-5)


EVERYTHING: dict[str, Any] = {
    "encoder_bits": 17, "noise": 1e-5, "velocity": "difference", "velocity_cutoff": 60.0,
    "delay": 1, "jitter": 0.2, "drop": 0.05, "effort_rate_limit": 3000.0, "gain": 0.97, "lag": 1e-3,
    "cogging": 0.05, "joint_stiffness": 2e4, "joint_damping": 5.0, "rotor_inertia": 0.1,
    "backlash": 1e-4, "seed": 11,
}  # fmt: skip


def all_of_it(seed: int = 11) -> sa.Run:
    effects = sa.Effects(**(EVERYTHING | {"seed": seed}))
    return simulated(made("computed_torque", TWO, delay=1), TWO, 200, effects=effects)


def digest(found: sa.Run) -> str:
    columns = b"".join(getattr(found, name).tobytes() for name in found.channels)
    return hashlib.sha256(columns).hexdigest()


def test_all_together_they_run() -> None:
    found = all_of_it()
    assert found.status.finished
    assert all(np.isfinite(getattr(found, name)).all() for name in found.channels)
    assert abs(found.e[100:]).max() < 0.2


def test_a_seed_gives_the_same_bits_here_in_threads_and_in_another_process() -> None:
    wanted = digest(all_of_it())
    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(lambda _: digest(all_of_it()), range(8))) == {wanted}
    code = "import test_effects as it; print(it.digest(it.all_of_it()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=".")
    assert done.stdout.strip() == wanted, done.stderr
    assert len({digest(all_of_it(seed)) for seed in range(5)} | {wanted}) == 6


@pytest.mark.parametrize("what", ["jitter", "drop", "noise", "velocity_noise"])
def test_an_effect_draws_numbers_of_its_own(what: str) -> None:
    random = {"jitter": 0.2, "drop": 0.1, "noise": 1e-5, "velocity_noise": 1e-3}
    seen = [run(**random, seed=4), run(**{k: v for k, v in random.items() if k != what}, seed=4)]
    if what in ("noise", "velocity_noise"):
        assert (seen[0].sample_age == seen[1].sample_age).all()
    elif what == "jitter":
        lost = [it.sample_age[:-1] > 1.2 * H for it in seen]
        assert (lost[0] == lost[1]).mean() > 0.8
    assert digest(seen[0]) != digest(seen[1])


def test_effects_are_nothing_but_their_arguments() -> None:
    effects = sa.Effects(**EVERYTHING)
    assert effects == sa.Effects(**EVERYTHING) == pickle.loads(pickle.dumps(effects))
    assert hash(effects) == hash(sa.Effects(**EVERYTHING)) and effects != sa.Effects()
    assert effects.__replace__(seed=3) == sa.Effects(**(EVERYTHING | {"seed": 3}))
    assert (effects.delay, effects.seed) == (1, 11) and "encoder_bits=17" in repr(effects)


def test_continuous_time_refuses_effects() -> None:
    with pytest.raises(ValueError, match="control_period"):
        simulated(made("pid", TWO), TWO, control_period=None, effects=sa.Effects(delay=1))


NAN, INF = np.nan, np.inf
HOSTILE = [
    ("encoder_bits", (0, -1, 65, NAN, "x", [16, 0])), ("noise", (-1.0, NAN, INF, "x")),
    ("velocity", ("fast", 3)), ("velocity_noise", (-1.0, NAN)), ("delay", (-1, 5, 1.5, "x")),
    ("jitter", (-0.1, 0.91, NAN)), ("drop", (-0.1, 0.91, NAN)), ("seed", (-1, 1.5, "x", 2**64)),
    ("effort_rate_limit", (0.0, -1.0, NAN)), ("gain", (0.0, -1.0, NAN, INF)),
    ("lag", (-1.0, NAN, INF)), ("cogging", (-1.0, NAN)), ("cogging_per_turn", (0.0, NAN)),
    ("joint_stiffness", (0.0, -1.0, NAN)), ("joint_damping", (-1.0, NAN)),
    ("rotor_inertia", (0.0, -1.0, NAN)), ("backlash", (-1.0, NAN)), ("encoder_side", ("x", 3)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "values"), HOSTILE)
def test_values_that_make_no_sense_are_refused_by_name(name: str, values: tuple[Any, ...]) -> None:
    gears = GEARS if name in (*GEARS, "backlash") else {}
    for value in values:
        with pytest.raises((ValueError, TypeError), match=f"^{name}"):
            sa.Effects(**(gears | {name: value}))


@pytest.mark.parametrize("name", ["encoder_bits", "noise", "gain", "lag", "cogging"])
def test_a_list_of_another_length_is_refused(name: str) -> None:
    effects = sa.Effects(**{name: [1.0, 1.0, 1.0]})
    with pytest.raises(ValueError, match=f"{name}: got 3 entries, wants 2"):
        simulated(made("pid", TWO), TWO, effects=effects)


@pytest.mark.parametrize(
    ("velocity", "name"),
    [
        ("difference", "velocity_cutoff"),
        ("tracking", "velocity_bandwidth"),
        ("kalman", "velocity_acceleration"),
    ],
)
@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan])
def test_a_velocity_filter_wants_a_number_above_zero(velocity: Any, name: str, bad: float) -> None:
    with pytest.raises(ValueError, match=f"^{name}"):
        sa.Effects(encoder_bits=16, velocity=velocity, **{name: bad})


@pytest.mark.parametrize("name", ["velocity_cutoff", "velocity_bandwidth", "velocity_acceleration"])
def test_numbers_that_are_not_used_are_checked_too(name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name}"):
        sa.Effects(**{name: np.nan})


def test_a_difference_without_a_filter() -> None:
    found = run(encoder_bits=14, velocity="difference", velocity_cutoff=np.inf)
    q, dq = sampled(found)
    assert np.allclose(dq[1:], np.diff(q, axis=0) / H)
