"""What stands before a law, against numpy; and a plant that changes, against a loop by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from law_scenes import CHAIN, TWO, H, made, nominal, plant, reference, rows, simulated, start
from steadyarm import laws


class Sees:
    """A PD that keeps what it was given."""

    def __init__(self) -> None:
        self.seen: list[Any] = []

    def step(self, q: Any, dq: Any, q_d: Any, dq_d: Any, ddq_d: Any, dt: float) -> np.ndarray:
        self.seen.append(np.array([q, dq, q_d, dq_d, ddq_d]))
        return -200.0 * (q - q_d) - 30.0 * (dq - dq_d)


def watched(samples: list[Any], **front: Any) -> tuple[np.ndarray, np.ndarray]:
    """What the law sees of samples, and the torques that come out."""
    own = Sees()
    controller = sa.Controller(nominal(TWO), own, control_period=H, **front)
    tau = np.array([controller.step(*sample, H) for sample in samples])
    return np.array(own.seen), tau


def handed(samples: np.ndarray, a: float) -> np.ndarray:
    """q_d' = q_d + (δ + (δ̇ + aδ)t) e^(-at), with its derivatives."""
    q, dq, q_d, dq_d, ddq_d = np.moveaxis(samples, 1, 0)
    t, delta = H * np.arange(len(q))[:, None], q[0] - q_d[0]
    slope = dq[0] - dq_d[0] + a * delta
    fading = np.exp(-a * t)
    along = delta + slope * t
    first = slope - a * along
    second = -2 * a * slope + a * a * along
    desired = [q_d + along * fading, dq_d + first * fading, ddq_d + second * fading]
    return np.stack([q, dq, *desired], axis=1)


def filtered(samples: np.ndarray, cutoff: float) -> np.ndarray:
    """ė' by the difference of e' through a first-order filter; dq = dq_d' + ė'."""
    q, dq, q_d, dq_d, ddq_d = np.moveaxis(samples, 1, 0)
    e, share = q - q_d, 1 - np.exp(-2 * np.pi * cutoff * H)
    de = [dq[0] - dq_d[0]]
    for k in range(1, len(q)):
        de.append(de[-1] + share * ((e[k] - e[k - 1]) / H - de[-1]))
    return np.stack([q, dq_d + np.array(de), q_d, dq_d, ddq_d], axis=1)


SAMPLES = np.array(rows(TWO, 50))


@pytest.mark.parametrize("rate", [0.5, 3.0, 40.0])
def test_the_hand_over_is_that_of_numpy(rate: float) -> None:
    seen, _ = watched(SAMPLES, hand_over=rate)
    assert np.allclose(seen, handed(SAMPLES, rate), rtol=1e-12, atol=1e-11)
    # It starts where the arm is, at its speed.
    assert np.allclose(seen[0, 2:4], seen[0, :2], atol=1e-12)


@pytest.mark.parametrize("cutoff", [5.0, 100.0, 1e6])
def test_the_velocity_filter_is_that_of_numpy(cutoff: float) -> None:
    seen, _ = watched(SAMPLES, velocity_filter=cutoff)
    assert np.allclose(seen, filtered(SAMPLES, cutoff), rtol=1e-11, atol=1e-10)


def test_both_together_filter_the_error_to_what_was_handed_over() -> None:
    seen, _ = watched(SAMPLES, hand_over=4.0, velocity_filter=60.0)
    assert np.allclose(seen, filtered(handed(SAMPLES, 4.0), 60.0), rtol=1e-11, atol=1e-10)


@pytest.mark.parametrize("before", [None, [7.0, -3.0]])
def test_a_bumpless_start_fades_from_the_torque_before(before: Any) -> None:
    _, bare = watched(SAMPLES)
    _, tau = watched(SAMPLES, bumpless=30.0, last_tau=before)
    start = nominal(TWO).gravity(SAMPLES[0, 0]) if before is None else np.array(before)
    fading = np.exp(-30.0 * H * np.arange(len(bare)))[:, None]
    assert np.allclose(tau, bare + (start - bare[0]) * fading, rtol=1e-12, atol=1e-11)
    assert np.allclose(tau[0], start, atol=1e-12)


def test_a_hand_over_starts_anew() -> None:
    own = Sees()
    controller = sa.Controller(nominal(TWO), own, control_period=H, hand_over=5.0)
    for sample in SAMPLES[:20]:
        controller.step(*sample, H)
    controller.start_hand_over()
    for sample in SAMPLES[20:]:
        controller.step(*sample, H)
    seen = np.array(own.seen)
    assert np.allclose(seen[:20], handed(SAMPLES[:20], 5.0), atol=1e-11)
    assert np.allclose(seen[20:], handed(SAMPLES[20:], 5.0), atol=1e-11)


def test_the_front_keeps_the_time_that_was_measured() -> None:
    own, elapsed = Sees(), H * (1 + 0.3 * np.sin(np.arange(50)))
    controller = sa.Controller(nominal(TWO), own, control_period=H, hand_over=5.0)
    for k, sample in enumerate(SAMPLES):
        controller.step(*sample, H, elapsed=elapsed[k] if k else None)
    t = np.concatenate([[0.0], np.cumsum(elapsed[1:])])[:, None]
    delta = SAMPLES[0, 0] - SAMPLES[0, 2]
    slope = SAMPLES[0, 1] - SAMPLES[0, 3] + 5.0 * delta
    wanted = SAMPLES[:, 2] + (delta + slope * t) * np.exp(-5.0 * t)
    assert np.allclose(np.array(own.seen)[:, 2], wanted, rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", ["pid", "momentum_observer", "slotine_li", "time_delay"])
@pytest.mark.parametrize("delay", [0, 1, 3])
def test_a_delayed_loop_is_one_by_hand_to_the_bit(name: str, delay: int) -> None:
    """What acts in a period was sent ``delay`` samples before, and the controller knows it."""
    limit = 10.0
    arm = sa.Plant(plant(TWO).arm, effort_limit=limit)
    controller = made(name, TWO, delay=delay, effort_limit=12.0, bandwidth=6.0)
    effects = sa.Effects(delay=delay) if delay else None
    options = {"control_period": H, "effects": effects} | start(TWO)
    run = sa.simulate(arm, controller, reference(TWO), 80 * H, H, **options)
    assert abs(run.tau).max() == limit, "it must be limited, or this says little"
    q, dq = run.q[0], run.dq[0]
    # Until the first torque arrives, what carries the arm acts, as far as the drives can.
    told = [np.clip(nominal(TWO).gravity(q), -limit, limit)] * (delay + 1)
    for k in range(80):
        after: Any = {"applied": told[delay]} if k else {}
        tau = controller.step(q, dq, *reference(TWO)(k * H), H, **after)
        told = [np.clip(tau, -limit, limit), *told][: delay + 1]
        assert (run.tau[k] == told[delay]).all(), k
        q, dq = arm.step(q, dq, told[delay], k * H, H)
        assert (run.q[k + 1] == q).all()


@pytest.mark.parametrize("name", ["hand_over", "velocity_filter", "bumpless"])
@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf, "x", [1.0, 2.0]])
def test_rates_that_make_no_sense_are_refused_by_name(name: str, bad: Any) -> None:
    with pytest.raises((ValueError, TypeError), match=name):
        made("pid", TWO, **{name: bad})


@pytest.mark.parametrize("bad", [-1, 5, 1.5, "x", np.nan])
def test_delays_that_make_no_sense_are_refused_by_name(bad: Any) -> None:
    with pytest.raises((ValueError, TypeError), match="delay"):
        made("pid", TWO, delay=bad)


def test_continuous_time_refuses_a_front() -> None:
    for front in ({"hand_over": 3.0}, {"velocity_filter": 100.0}, {"bumpless": 5.0}, {"delay": 1}):
        with pytest.raises(ValueError, match="control_period"):
            simulated(made("pid", TWO, **front), TWO, control_period=None)


@pytest.mark.parametrize("name", ["pid", "time_delay", "natural_slotine_li"])
def test_a_payload_that_is_picked_up_is_two_runs_by_hand(name: str) -> None:
    bare = nominal(CHAIN)
    loaded = bare.with_payload(3.0, (0.0, 0.0, 0.05))
    changing = sa.Plant(bare, changes=[(20 * H, loaded), (50 * H, bare)])
    options = {"control_period": H} | start(CHAIN)
    run = sa.simulate(changing, made(name, CHAIN), reference(CHAIN), 80 * H, H, **options)
    controller, (q, dq) = made(name, CHAIN), (run.q[0], run.dq[0])
    for k in range(80):
        tau = controller.step(q, dq, *reference(CHAIN)(k * H), H)
        now = sa.Plant(loaded if 20 <= k < 50 else bare)
        assert (run.tau[k] == tau).all() and (run.q[k] == q).all(), k
        q, dq = now.step(q, dq, tau, k * H, H)
    assert (run.q[80] == q).all()
    assert changing.changes == ((20 * H, loaded), (50 * H, bare))


def test_changes_go_with_effects_and_are_kept_in_a_file(tmp_path: Any) -> None:
    heavier = nominal(TWO).__replace__(mass=(7, 9))
    changing = sa.Plant(nominal(TWO), changes=[(20 * H, heavier)])
    effects = sa.Effects(encoder_bits=16, jitter=0.2, delay=1, seed=2)
    options = {"control_period": H, "effects": effects} | start(TWO)
    run = sa.simulate(changing, made("pid", TWO, delay=1), reference(TWO), 60 * H, H, **options)
    run.save(tmp_path / "run.npz")
    assert (sa.Run.load(tmp_path / "run.npz").replay().q == run.q).all()
    bare = sa.Plant(nominal(TWO))
    same = sa.simulate(bare, made("pid", TWO, delay=1), reference(TWO), 60 * H, H, **options)
    assert (same.q[:21] == run.q[:21]).all() and not (same.q[25:] == run.q[25:]).any()


def test_changes_that_make_no_sense_are_refused() -> None:
    two, chain = nominal(TWO), nominal(CHAIN)
    for bad in (
        [(-1.0, two)], [(np.nan, two)], [(2.0, two), (1.0, two)], [(1.0, chain)], [(1.0,)],
        3, [("x", two)],
    ):  # fmt: skip
        with pytest.raises((ValueError, TypeError), match="changes"):
            sa.Plant(two, changes=bad)
    with pytest.raises(TypeError, match="arm"):
        sa.Plant(two, changes=[(1.0, "arm")])
    with pytest.raises(ValueError, match=r"control_period|changes"):
        options = {"control_period": None} | start(TWO)
        plant = sa.Plant(two, changes=[(0.01, two)])
        sa.simulate(plant, laws.pid(two, bandwidth=5.0), reference(TWO), 20 * H, H, **options)


def test_a_loop_with_effects_but_no_jitter_has_periods_of_one_length() -> None:
    run = simulated(made("momentum_observer", TWO), TWO, 200, effects=sa.Effects(delay=1))
    controller, (q, dq) = made("momentum_observer", TWO), (run.q[0], run.dq[0])
    told = [nominal(TWO).gravity(q)] * 2
    for k in range(200):
        tau = controller.step(q, dq, *reference(TWO)(k * H), H, applied=told[0] if k else None)
        told = [tau, told[0]]
        assert (run.tau[k] == told[1]).all(), k
        q, dq = plant(TWO).step(q, dq, told[1], k * H, H)
