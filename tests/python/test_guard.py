"""`Guard`: an answer to every sample, from Python and in a simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa

PERIOD = 1e-3
EFFORT = (60.0, 40.0)
RATE = 20_000.0
ZERO = np.zeros(2)


def tracker(**change: Any) -> sa.ComputedTorque:
    basis = sa.FuzzyBasis("per_joint", sa.paper.CENTERS, sa.paper.WIDTH)
    compensator = sa.FuzzyCompensator(basis, gain=7.0)
    arguments = {"kp": 64.0, "kv": 16.0, "compensator": compensator} | change
    return sa.ComputedTorque(sa.paper.nominal(), **arguments)


def guard(**change: Any) -> sa.Guard:
    limits = {
        "position_limits": [(-2, 2), (-2, 2)],
        "velocity_limit": 8.0,
        "effort_limit": EFFORT,
        "effort_rate_limit": RATE,
        "power_limit": 300.0,
        "envelope": 1.0,
    }
    return sa.Guard(tracker(), PERIOD, **(limits | change))


def step(guarded: sa.Guard, q: Any = (0.1, 0.0), dq: Any = ZERO, **more: Any) -> np.ndarray:
    return guarded.step(q, dq, ZERO, ZERO, ZERO, **more)


BAD = {
    "NaN in q": ({"q": (np.nan, 0)}, "not_finite"),
    "infinite dq": ({"dq": (0, -np.inf)}, "not_finite"),
    "q of 1e300": ({"q": (0.1, 1e300)}, "not_finite"),
    "a spike of q": ({"q": (0.6, 0)}, "jump"),
    "a spike of dq": ({"dq": (0, 90.0)}, "jump"),
    "the same tick twice": ({"elapsed": 1e-5}, "early"),
    "a clock that goes back": ({"elapsed": -1.0}, "clock"),
    "a clock that is NaN": ({"elapsed": np.nan}, "clock"),
}


@pytest.mark.parametrize(("sample", "event"), BAD.values(), ids=BAD)
def test_a_bad_sample_is_answered_and_teaches_nothing(sample: dict[str, Any], event: str) -> None:
    guarded = guard()
    for _ in range(20):
        last = step(guarded)
    before = guarded.tracker.weights
    tau = step(guarded, **sample)
    np.testing.assert_array_equal(tau, last)
    np.testing.assert_array_equal(guarded.tracker.weights, before)
    assert guarded.latest == [event]
    assert guarded.events[event] == 1
    assert guarded.stopped is None
    for _ in range(20):
        assert np.isfinite(step(guarded)).all()
    assert guarded.latest == []


def test_what_is_outside_its_limits_stops_until_rearmed() -> None:
    for q, dq, why in [
        ((0.0, 2.1), ZERO, "position of joint 2"),
        ((0.0, 0.0), (9.0, 0.0), "velocity of joint 1"),
        ((1.1, 0.0), ZERO, "envelope of joint 1"),
    ]:
        guarded = guard()
        step(guarded, q, dq)
        assert guarded.stopped == why
        assert "stopped" in repr(guarded)
        step(guarded, (0.1, 0.0))
        assert guarded.stopped == why
        guarded.rearm()
        step(guarded, (0.1, 0.0))
        assert guarded.stopped is None


def test_a_guard_without_work_changes_no_bit() -> None:
    scene = sa.paper.simulation(3, "claimed")
    alone = tracker()
    options = {"duration": 1.0, "control_period": PERIOD, "q0": (0.5, -0.5)}
    run = sa.simulate(scene.plant, alone, scene.reference, **options)
    guarded = guard(power_limit=None, envelope=None, effort_rate_limit=None, effort_limit=None)
    other = sa.simulate(scene.plant, guarded, scene.reference, **options)
    assert run.tau.tobytes() == other.tau.tobytes()
    assert run.e.tobytes() == other.e.tobytes()
    assert run.guard is None
    assert other.guard is not None
    assert set(other.guard.events.values()) == {0}
    assert other.guard.stopped is None
    # The guard that was given has seen nothing, as the tracker has not.
    assert guarded.last_tau is None and guarded.tracker.steps == 0


def test_a_run_whose_arm_leaves_its_envelope_is_braked_and_says_so() -> None:
    scene = sa.paper.simulation(3, "claimed")

    def away(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return np.full(2, 1.5 * (t > 0.5)), ZERO, ZERO

    run = sa.simulate(scene.plant, guard(), away, 2.0, control_period=PERIOD)
    assert run.status.finished
    assert run.guard is not None
    assert run.guard.stopped == "envelope of joint 1"
    assert run.guard.events["envelope"] > 0
    assert (abs(run.tau) <= EFFORT).all()
    assert (abs(np.diff(run.tau, axis=0)) <= RATE * PERIOD * (1 + 1e-12)).all()
    late = run.t > 1.5
    assert abs(run.dq[late]).max() < 0.1
    assert run.scene is None
    with pytest.raises(ValueError, match="run: got one without its scene"):
        run.replay()


def test_a_robots_own_limits_are_the_guards() -> None:
    panda = sa.Serial.shipped("panda")
    rest = np.array([0, -0.6, 0, -2, 0, 1.6, 0.8])
    guarded = sa.Guard(sa.ComputedTorque(panda, 100, 20), PERIOD)
    still = np.zeros(7)
    for _ in range(3):
        tau = guarded.step(rest, still, rest, still, still)
    np.testing.assert_allclose(tau, panda.gravity(rest), atol=1e-9)
    outside = rest.copy()
    outside[3] = 0.5  # its range ends at -0.07 rad
    guarded.rearm()
    guarded.step(outside, still, outside, still, still)
    assert guarded.stopped == "position of joint 4"
    far = sa.Guard(sa.ComputedTorque(panda, 1e4, 200), PERIOD)
    tau = far.step(rest, still, rest + 0.5, still, still)
    assert (abs(tau) <= panda.limits["effort"]).all()
    assert "effort" in far.latest


def test_missing_samples_hold_the_torque_then_stop() -> None:
    guarded = guard(hold=2, decay=2)
    first = step(guarded)
    taus = [guarded.missed() for _ in range(8)]
    np.testing.assert_array_equal(taus[1], first)
    np.testing.assert_allclose(taus[2], first / 2)
    np.testing.assert_array_equal(taus[4], ZERO)  # no gravity: nothing carries the arm
    assert guarded.stopped == "missed"
    assert (guarded.lost, guarded.events["missed"]) == (8, 8)


def test_reset_is_as_new_and_a_take_over_counts() -> None:
    guarded = guard(last_tau=(30.0, -20.0), effort_rate_limit=1000.0)
    tau = step(guarded)
    np.testing.assert_allclose(tau, (29.0, -19.0))
    guarded.stop()
    step(guarded)
    assert guarded.stopped == "stop"
    guarded.reset()
    assert (guarded.stopped, guarded.tracker.steps, guarded.latest) == (None, 0, [])
    assert set(guarded.events.values()) == {0}
    np.testing.assert_array_equal(step(guarded), tau)


REFUSED: dict[str, tuple[type[Exception], Any]] = {
    "tracker: got float, wants a Controller, such as a ComputedTorque": (
        TypeError,
        lambda: sa.Guard(1.0, PERIOD),
    ),  # type: ignore[arg-type]
    "control_period: got 0, wants a period": (ValueError, lambda: sa.Guard(tracker(), 0.0)),
    r"effort_limit\[1\]: got -1, wants a limit > 0": (
        ValueError,
        lambda: guard(effort_limit=(1, -1)),
    ),
    r"velocity_limit: got shape \(3,\)": (ValueError, lambda: guard(velocity_limit=(1, 1, 1))),
    r"position_limits: got shape \(2,\), wants \(2, 2\)": (
        ValueError,
        lambda: guard(position_limits=(-1, 1)),
    ),
    r"position_limits\[0\]: got 1, wants a range": (
        ValueError,
        lambda: guard(position_limits=((1, -1), (-1, 1))),
    ),
    "hold: got -1, wants a whole number": (ValueError, lambda: guard(hold=-1)),
    r"deceleration\[0\]: got 0, wants a number > 0": (ValueError, lambda: guard(deceleration=0)),
    "last_tau": (ValueError, lambda: guard(last_tau=np.nan)),
    "control_period: got 0.002, wants the period of the guard": (
        ValueError,
        lambda: sa.simulate(
            sa.Plant(sa.paper.actual()), guard(), sa.paper.reference(), 1.0, control_period=2e-3
        ),
    ),
    "control_period: got None, wants the period of the guard": (
        ValueError,
        lambda: sa.simulate(sa.Plant(sa.paper.actual()), guard(), sa.paper.reference(), 1.0),
    ),
}


@pytest.mark.parametrize(("message", "case"), REFUSED.items(), ids=range(len(REFUSED)))
def test_arguments_that_make_no_sense_are_refused_by_name(
    message: str, case: tuple[type[Exception], Any]
) -> None:
    kind, call = case
    with pytest.raises(kind, match=message):
        call()


def test_a_stop_brings_any_arm_to_rest_and_keeps_it_there() -> None:
    """Coupled links, of which each alone has little inertia: the brake has M(q), not its diagonal.

    With a diagonal one the first arm goes on for ever with 4 rad/s, and a Panda swings for seconds.
    """
    links, period = 3, 2e-3
    chain = sa.Serial.from_dh(
        a=[0.3] * links,
        alpha=0,
        d=0,
        mass=2.0,
        com=[[-0.15, 0, 0]] * links,
        inertia=0.015,
        viscous=0.2,
        gravity=(0, 0, 0),
    )
    panda = sa.Serial.shipped("panda")
    poses = [(0, -0.6, 0, -2.0, 0, 1.6, 0.8), (0.5, 0.4, -1, -1.2, 1, 2.2, -1)]
    scenes = [(chain, np.full(links, 0.1), {"effort_limit": 50.0})]
    scenes += [(panda, np.array(pose), {}) for pose in poses]
    for arm, q, limits in scenes:
        path, plant = sa.Quintic(q, q + 0.3, 1.0, 0.1), sa.Plant(arm)
        tracker, dq = sa.ComputedTorque(arm, 100, 20), np.zeros_like(q)
        guarded = sa.Guard(tracker, period, **limits)
        for tick in range(1500):
            if tick == 275:
                guarded.stop()
                assert np.abs(dq).max() > 0.2
            tau = guarded.step(q, dq, *path(tick * period))
            q, dq = plant.step(q, dq, tau, tick * period, period)
        assert np.abs(dq).max() < 1e-3


def test_no_call_gives_more_than_the_effort_limit_at_a_take_over_beyond_it() -> None:
    for first in ("early", "missed", "late", "good"):
        guarded = sa.Guard(tracker(), PERIOD, effort_limit=10.0, last_tau=[500.0, 0.0])
        elapsed = {"early": 2e-4, "late": 5e-3}.get(first)
        tau = guarded.missed() if first == "missed" else step(guarded, elapsed=elapsed)
        assert np.abs(tau).max() <= 10.0, first


def cut(**change: Any) -> sa.Guard:
    """A guard that cuts every torque, so that nothing may ever be learnt."""
    return sa.Guard(tracker(), PERIOD, **({"effort_limit": 0.1} | change))


def test_nothing_is_learnt_from_a_torque_that_the_guard_cut_whatever_is_called_between() -> None:
    for call in ("nothing", "freeze", "weights", "stop", "missed"):
        guarded = cut()
        for _ in range(50):
            step(guarded, q=(0.3, 0.2))
            if call == "freeze":
                guarded.tracker.freeze()
                guarded.tracker.unfreeze()
            elif call == "weights":
                guarded.tracker.weights = guarded.tracker.weights
            elif call == "stop":
                guarded.stop()
                guarded.rearm()
            elif call == "missed":
                guarded.missed()
        assert np.linalg.norm(guarded.tracker.weights) == 0.0, call
        assert guarded.tracker.limited


def test_an_applied_torque_that_is_not_finite_is_an_event_and_teaches_nothing() -> None:
    for applied in ([np.nan, 0.0], [0.0, np.inf]):
        guarded, plain = guard(), guard()
        step(guarded)
        step(plain)
        for _ in range(60):
            tau = step(guarded, applied=applied)
            assert guarded.latest == ["not_finite"]
            assert np.isfinite(tau).all()
            step(plain)
        guarded.tracker.freeze(applied=ZERO)  # ends the last period
        assert np.linalg.norm(guarded.tracker.weights) == 0.0
        assert guarded.stopped is None
        assert np.linalg.norm(plain.tracker.weights) > 0.0


def test_power_is_limited_in_every_call_that_brings_a_velocity() -> None:
    """Also where the set-point is not finite, or the controller refuses."""
    huge = np.array([1e300, 0.0])
    for set_point in ((huge, ZERO, ZERO), (ZERO, huge, ZERO), (ZERO, ZERO, huge)):
        guarded = sa.Guard(sa.ComputedTorque(sa.paper.nominal(), 100, 20), PERIOD, power_limit=1.0)
        guarded.step(ZERO, [-0.01, 0], [0.1, 0], ZERO, ZERO)
        tau = guarded.step(ZERO, [2.0, 0.0], *set_point)
        assert "not_finite" in guarded.latest
        assert tau[0] * 2.0 <= 1.0 + 1e-12


def test_a_sample_soon_after_a_missed_one_is_used() -> None:
    """The deadline passed, `missed` gave the torque, and then the sample came: not an early one."""
    guarded = guard()
    for _ in range(60):
        step(guarded, elapsed=0.9 * PERIOD)
        guarded.missed()
        step(guarded, elapsed=0.1 * PERIOD)
    assert guarded.events["early"] == 0
    assert guarded.stopped is None
    assert guarded.tracker.steps == 120


def test_periods_that_a_late_sample_left_out_are_counted_as_missed() -> None:
    guarded = guard()
    step(guarded)
    step(guarded, elapsed=10 * PERIOD)
    assert guarded.latest == ["late"]
    assert guarded.events["missed"] == 9
    step(guarded, elapsed=0.9)
    assert guarded.stopped == "missed"
    assert guarded.events["missed"] == 9 + 899


def heavy(**change: Any) -> sa.ComputedTorque:
    return sa.ComputedTorque(sa.TwoLink(4, 0.5, 0.2, gravity=9.81), 100, 20, **change)


def test_samples_lost_before_the_first_good_one_do_not_make_the_arm_drop() -> None:
    gravity = heavy().arm.gravity(ZERO)
    for lost in (None, {"q": (np.nan, 0.0)}):
        guarded = sa.Guard(heavy(), PERIOD, effort_rate_limit=1000.0)
        for _ in range(3):
            tau = guarded.missed() if lost is None else step(guarded, **lost)
            np.testing.assert_array_equal(tau, 0.0)
            assert guarded.last_tau is None
        np.testing.assert_allclose(step(guarded, q=ZERO), gravity)


def test_a_guard_takes_over_at_what_its_tracker_commanded_last() -> None:
    used = heavy()
    last = used.step([-0.3, -0.2], ZERO, ZERO, ZERO, ZERO, PERIOD)
    stated = heavy(last_tau=[50.0, 5.0])
    for controller, begun in ((used, last), (stated, stated.reset() or np.array([50.0, 5.0]))):
        guarded = sa.Guard(controller, PERIOD, effort_rate_limit=1000.0)
        np.testing.assert_array_equal(guarded.last_tau, begun)
        tau = step(guarded, q=(-0.3, -0.2))
        assert np.abs(tau - begun).max() <= 1000.0 * PERIOD * (1 + 1e-12)
    guarded.reset(last_tau=[7.0, 3.0])
    np.testing.assert_array_equal(guarded.last_tau, [7.0, 3.0])
    guarded.reset()
    np.testing.assert_array_equal(guarded.last_tau, [50.0, 5.0])


def test_the_report_of_a_run_counts_the_run_alone_and_is_kept_in_its_file(tmp_path: Path) -> None:
    guarded = guard()
    for _ in range(5):
        guarded.missed()
    run = sa.simulate(
        sa.Plant(sa.paper.nominal()), guarded, sa.paper.reference(), 0.2, control_period=PERIOD
    )
    assert run.guard is not None
    assert run.guard.events["missed"] == 0
    assert guarded.events["missed"] == 5
    run.save(tmp_path / "run.npz")
    assert sa.Run.load(tmp_path / "run.npz").guard == run.guard


def test_a_run_says_what_its_guard_ruined() -> None:
    plant = sa.Plant(heavy().arm)
    path = sa.Quintic((0.0, 0.0), (0.4, 0.2), 1.0)
    for limits, said in [
        ({"effort_limit": 5.0}, "effort_limit: joint 1 has 5.0000 N·m, and gravity alone takes"),
        ({"position_limits": [(-1, 0.2), (-1, 1)]}, "guard: it stopped (position of joint 1)"),
    ]:
        with pytest.warns(sa.DesignWarning):
            run = sa.simulate(
                plant, sa.Guard(heavy(), PERIOD, **limits), path, 1.5, control_period=PERIOD
            )
        assert any(note.startswith(said) for note in run.notes), run.notes
    with pytest.raises(
        ValueError, match=r"^control_period: got .*the period of the guard; a guard"
    ):
        sa.simulate(plant, sa.Guard(heavy(), PERIOD), path, 0.1)
