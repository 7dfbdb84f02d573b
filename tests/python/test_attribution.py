"""Attribution: its parts add up, each planted cause is found, each part is what it should be."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attribution_scenes as scenes
import numpy as np
import pytest
import steadyarm as sa
from attribution_scenes import PANDA, PERIOD, PLANTED, follow, robot, small, two_link, waves
from steadyarm.attribution import WORDS

ARM = ("inertia", "coriolis", "gravity", "friction", "contact", "disturbance")
LOAD = ("payload_inertia", "payload_coriolis", "payload_gravity")


def times(matrices: Any, vectors: Any) -> np.ndarray:
    return np.einsum("tij,tj->ti", np.asarray(matrices), vectors)


def assert_adds_up(found: sa.Attribution, run: sa.Run) -> None:
    """To 1e-9 N·m at every row, with a rest that is rounding; and the error to rounding."""
    assert np.abs(sum(found.torque.values()) - found.whole).max() < 1e-9
    assert np.abs(found.torque["rest"]).max() < 1e-9
    assert np.abs(sum(found.error.values()) - run.e).max() < 1e-12
    for shares in (found.torque_shares, found.error_shares):
        total = sum(shares.values())
        assert np.abs(total[~np.isnan(total)] - 1.0).max(initial=0.0) < 1e-9


@pytest.mark.parametrize("scene", PLANTED, ids=lambda scene: scene.__name__)
def test_a_planted_cause_has_the_largest_share(scene: Callable[[], sa.Run]) -> None:
    run, cause = scene(), PLANTED[scene]
    found = sa.attribution(run)
    assert_adds_up(found, run)
    worst = int(np.argmax(np.sqrt((found.mismatch**2).mean(axis=0))))
    torque = {name: share[worst] for name, share in found.torque_shares.items()}
    assert max(torque, key=lambda name: abs(torque[name])) == cause
    assert torque[cause] > 0.85
    farthest = int(np.argmax(found.rms_of_error))
    error = {name: share[farthest] for name, share in found.error_shares.items()}
    assert max(error, key=lambda name: abs(error[name])) == cause
    assert WORDS[cause] in found.sentence().split(";")[0]


def test_a_start_off_the_path_is_the_error_without_any_torque() -> None:
    run = scenes.start()
    found = sa.attribution(run)
    assert_adds_up(found, run)
    assert (found.error_shares["start"] > 0.99).all()
    # Only the last row has a torque of the row before it: no sample is taken at the end.
    assert np.abs(found.whole[:-1]).max() < 1e-9


# Against what was recorded, and what others compute.


@pytest.mark.parametrize("method", ["rk4", "dp54"])
def test_causes_of_the_arm_are_the_recorded_model_error(method: str) -> None:
    """ρ = q̈ - v + ρ̂ of the core, so M₀ ρ is minus all that the model leaves out."""
    plant = sa.Plant(
        two_link(mass=(6, 5), inertia=(0.3, 0.1), gravity=9.81, coulomb=0.7, viscous=0.4),
        sa.paper.disturbance(),
    )
    tracker = sa.ComputedTorque(two_link(gravity=9.0, viscous=0.1), 100.0, 20.0)
    run = sa.simulate(plant, tracker, waves(2, 0.6), 3.0, PERIOD, method)
    found = sa.attribution(run)
    assert_adds_up(found, run)
    mass = [tracker.arm.mass_matrix(q) for q in run.q]
    missing = sum(found.torque[name] for name in ARM)
    np.testing.assert_allclose(missing, -times(mass, run.rho), rtol=0, atol=1e-9)
    # In continuous time nothing else is missing.
    np.testing.assert_allclose(found.whole, missing, rtol=0, atol=1e-9)


def test_causes_of_a_sampled_loop_are_the_recorded_model_error_too() -> None:
    """Where the law saw what was there, M₀ ρ = M₀ q̈ + H₀ - (model + compensation)."""
    arm = robot("ur5e")
    true = arm.with_payload(1.5).with_friction(viscous=0.4, coulomb=0.6)
    plant = sa.Plant(arm, sa.Noise(0.3, 10.0), 150.0, changes=[(0.5, true)])
    effects = sa.Effects(delay=2, gain=0.93, lag=2e-3, cogging=0.2, effort_rate_limit=3e3)
    path = waves(6, 0.2, offset=scenes.UR5E)
    run = follow(arm, plant, path, sa.laws.pid, duration=1.0, bandwidth=8.0, effects=effects)
    found = sa.attribution(run)
    assert_adds_up(found, run)
    acted = sum(found.torque[name] for name in (*ARM, *LOAD, "saturation", "delay", "actuators"))
    wanted = -times([arm.mass_matrix(q) for q in run.q], run.rho)
    # At the last row no sample is taken.
    np.testing.assert_allclose(acted[:-1], wanted[:-1], rtol=0, atol=1e-9)
    assert np.abs(found.torque["measurement"][:-1]).max() < 1e-9


PUSHES = {
    "pulses": sa.Pulses((0.2, 0.5), ((2.0, -1.0), (0.5, 3.0)), 0.4, "half_sine"),
    "noise": sa.Noise((0.5, 1.0), 5.0, seed=3),
    "sines": sa.Sines((1.0, 7.0), sin=((1.0, 2.0), (0.3, 0.4)), start_time=0.3),
    "wrench": sa.Wrench(force=(3.0, -4.0, 1.0), moment=(0.1, 0.2, 0.3)),
    "wrench over time": sa.Wrench(curve=sa.Sines(3.0, sin=(1.0, 2.0, 0.0, 0.0, 0.0, 0.5))),
    "callable": lambda q, dq, t: 0.3 * dq + np.array([np.sin(t), q[0]]),
    "a list": [sa.Noise(0.2, 5.0), sa.Wrench(force=(0.0, 1.0, 0.0)), lambda q, dq, t: dq],
}


@pytest.mark.parametrize("name", PUSHES)
def test_every_disturbance_is_what_acted_in_the_run(name: str) -> None:
    """Of an exact model ρ = -M⁻¹τ_d."""
    arm = two_link(gravity=9.81)
    plant = sa.Plant(arm, PUSHES[name])
    path = waves(2, 0.4)
    run = sa.simulate(plant, sa.ComputedTorque(arm, 100, 20), path, 1.0, PERIOD, record_every=7)
    found = sa.attribution(run)
    acted = -times([arm.mass_matrix(q) for q in run.q], run.rho)
    np.testing.assert_allclose(found.torque["disturbance"], acted, rtol=0, atol=1e-10)
    assert np.abs(acted).max() > 0.1


def test_a_wrench_pushes_a_serial_arm_at_its_tip() -> None:
    run = scenes.panda_wrench()
    force = np.array([3.0, 5.0, -8.0])
    lever = [robot("panda").jacobian(q)[:3].T @ force for q in run.q]
    found = sa.attribution(run).torque["disturbance"]
    np.testing.assert_allclose(found, -np.array(lever), rtol=0, atol=1e-12)


def test_gravity_of_a_payload_is_the_slope_of_its_energy() -> None:
    """G = ∂(m g z)/∂q of its centre of mass, by central differences."""
    run = scenes.panda_payload()
    arm, com = robot("panda"), np.array([0.0, 0.0, 0.05, 1.0])
    found = sa.attribution(run)

    def height(q: np.ndarray) -> float:
        return float((arm.pose(q) @ com)[2])

    for row in (0, 700, 2500):
        slopes = [
            (height(run.q[row] + step) - height(run.q[row] - step)) / 2e-6
            for step in 1e-6 * np.eye(7)
        ]
        wanted = 2.0 * 9.81 * np.array(slopes)
        np.testing.assert_allclose(found.torque["payload_gravity"][row], wanted, atol=1e-7)
    for name in ("inertia", "coriolis", "gravity"):
        assert np.abs(found.torque[name]).max() < 1e-12


def test_a_payload_that_is_picked_up_is_missing_from_then_on() -> None:
    arm = robot("panda")
    loaded = arm.with_payload(2.0, (0.0, 0.0, 0.05))
    plant = sa.Plant(arm, changes=[(1.0, loaded), (3.0, arm)])
    run = follow(arm, plant, waves(7, 0.2, offset=PANDA))
    found = sa.attribution(run)
    assert_adds_up(found, run)
    carried = (run.t >= 1.0) & (run.t < 3.0)
    load = np.abs(found.torque["payload_gravity"][:, 1])
    assert (load[~carried] == 0.0).all() and (load[carried] > 5.0).all()
    assert "gravity of the payload" in found.sentence()
    # A window after it was put down has none of it.
    later = sa.attribution(run, window=(3.5, 4.0))
    assert (later.torque_shares["payload_gravity"][:2] == 0.0).all()


def test_a_payload_that_the_controller_believes_in_is_taken_off_a_lighter_plant() -> None:
    """Nothing is carried then; the model is wrong."""
    arm = robot("panda")
    nominal = arm.with_payload(2.0)
    found = sa.attribution(follow(nominal, sa.Plant(arm), waves(7, 0.2, offset=PANDA)))
    assert all(not found.torque[name].any() for name in LOAD)
    assert np.abs(found.torque["gravity"]).max() > 5.0


def test_a_heavier_last_link_that_no_added_body_explains_is_no_payload() -> None:
    """A kilogram more, and less about one axis: no body has negative moments."""
    arm = robot("panda")
    changed = arm.inertial_parameters()
    changed[60] += 1.0
    changed[64] -= 0.002  # the moment about x
    plant = sa.Plant(arm.with_parameters(changed))
    found = sa.attribution(follow(arm, plant, waves(7, 0.2, offset=PANDA)))
    assert all(not found.torque[name].any() for name in LOAD)
    assert np.abs(found.torque["gravity"]).max() > 1.0


def test_what_is_carried_can_be_told() -> None:
    """Of a two-link arm, or where other links are wrong too."""
    arm = robot("panda")
    wrong = scenes.heavier(arm, 2, 1.5)
    run = follow(arm, sa.Plant(wrong.with_payload(2.0)), waves(7, 0.2, offset=PANDA))
    assert not sa.attribution(run).torque["payload_gravity"].any()
    found = sa.attribution(run, unloaded=wrong)
    assert_adds_up(found, run)
    lighter = scenes.panda_gravity()
    wanted = [wrong.gravity(q) - arm.gravity(q) for q in run.q]
    np.testing.assert_allclose(found.torque["gravity"], wanted, atol=1e-12)
    assert "gravity" in sa.attribution(lighter).sentence()


def test_delay_gain_and_limits_are_told_apart() -> None:
    """With a gain of 0.8 and two samples late: each from the definition of the effect."""
    effects = sa.Effects(gain=0.8, delay=2, cogging=0.3)
    limit = np.array([9.0, 3.0])
    plant = sa.Plant(two_link(), effort_limit=limit)
    run = follow(two_link(), plant, waves(2, 0.6, 3.0), effects=effects, control_period=2e-3)
    found = sa.attribution(run)
    assert_adds_up(found, run)
    asked = run.tau_model + run.tau_compensation
    told = np.clip(asked, -limit, limit)
    assert (told != asked).any()
    # Two samples are four rows; before them what holds the arm at rest acts: nothing.
    acting = np.concatenate([np.zeros((4, 2)), told[:-4]])
    # At the last row no sample is taken, so it is late by one row less.
    acting[-1] = acting[-2]
    np.testing.assert_allclose(found.torque["saturation"], asked - told, atol=1e-12)
    np.testing.assert_allclose(found.torque["delay"], told - acting, atol=1e-9)
    cogging = 0.3 * np.sin(100.0 * run.q)
    np.testing.assert_allclose(found.torque["actuators"], 0.2 * acting + cogging, atol=1e-9)


def test_a_held_torque_is_missing_what_the_law_would_ask_for_now() -> None:
    """Between samples v has moved on; at a sample nothing is missing."""
    run = scenes.sampling()
    found = sa.attribution(run)
    v = run.ddq_d - 30.0 * run.de - 225.0 * run.e
    arm = two_link()
    now = times([arm.mass_matrix(q) for q in run.q], v)
    now += [arm.bias(q, dq) for q, dq in zip(run.q, run.dq, strict=True)]
    np.testing.assert_allclose(found.torque["sampling"], now - run.tau, atol=1e-9)
    assert np.abs(found.torque["sampling"][:-1:25]).max() < 1e-9


@pytest.mark.parametrize(
    "effects",
    [
        sa.Effects(encoder_bits=12, velocity="difference", delay=1, jitter=0.3, drop=0.05, seed=1),
        sa.Effects(effort_rate_limit=60.0, noise=1e-4),
        sa.Effects(effort_rate_limit=60.0, lag=4e-3, delay=2),
        sa.Effects(joint_stiffness=2e3, rotor_inertia=0.2, joint_damping=2.0, backlash=1e-3),
    ],
    ids=["a rough loop", "rate limit", "lag", "gears"],
)
def test_all_effects_add_up(effects: sa.Effects) -> None:
    for options in ({}, {"record_every": 5, "control_period": 2e-3}):
        run = follow(*small(coulomb=0.5), waves(2, 0.5), effects=effects, **options)
        assert_adds_up(sa.attribution(run), run)


def test_until_the_first_torque_arrives_that_acts_which_was_there() -> None:
    """Gravity is carried from the start; a drive with a lag has a share of 0.9 of it."""
    arm = two_link(gravity=9.81)
    effects = sa.Effects(delay=3, lag=5e-3, gain=0.9)
    run = follow(arm, sa.Plant(arm), waves(2, 0.3), effects=effects, duration=0.1)
    found = sa.attribution(run)
    begun = arm.gravity(run.q[0])
    np.testing.assert_allclose(run.tau[0], 0.9 * begun, rtol=1e-12)
    np.testing.assert_allclose(found.torque["actuators"][:3], begun - run.tau[:3], atol=1e-9)


@pytest.mark.parametrize("law", ["computed_torque", "pid"])
def test_a_hand_over_is_all_that_is_missing_where_the_model_is_right(law: str) -> None:
    """The law sees what is there, of the reference that is handed over: nothing is measured wrong.

    And an integral that sees no error in it makes none.
    """
    tracker = getattr(sa.laws, law)(two_link(), bandwidth=15.0, hand_over=3.0)
    run = follow(*small(), waves(2, 0.5), tracker, q0=(0.4, -0.4), dq0=(0.3, 0.0))
    found = sa.attribution(run)
    assert_adds_up(found, run)
    assert np.abs(found.torque["measurement"]).max() < 1e-9
    shares = found.error_shares
    assert (np.abs(shares["hand_over"] + shares["start"] - 1.0) < 0.01).all()
    assert (np.abs(shares.get("cancelled", np.zeros(2))) < 0.01).all()


def test_a_bumpless_start_is_part_of_the_hand_over() -> None:
    """(τ(0₋) - τ(0)) exp(-at) of the torque, from 2 N·m on."""
    tracker = sa.laws.computed_torque(two_link(), bandwidth=15.0, bumpless=4.0, last_tau=2.0)
    run = follow(*small(), waves(2, 0.5), tracker)
    found = sa.attribution(run)
    assert_adds_up(found, run)
    assert np.abs(found.torque["measurement"]).max() < 1e-9
    np.testing.assert_allclose(run.tau[0], 2.0, rtol=1e-12)
    missing = found.torque["hand_over"]
    np.testing.assert_allclose(missing, missing[0] * np.exp(-4.0 * run.t)[:, None], atol=1e-9)


def test_what_a_late_drive_follows_slowly_acts_so_much_later() -> None:
    """What its rate limit lets through at a row acts two samples, four rows, after it."""
    effects = sa.Effects(effort_rate_limit=40.0, delay=2, gain=1.1)
    run = follow(*small(), waves(2, 0.5, 3.0), effects=effects, control_period=2e-3)
    found = sa.attribution(run)
    told = run.tau_model + run.tau_compensation - found.torque["saturation"]
    acting = told - found.torque["delay"]
    assert np.abs(found.torque["saturation"]).max() > 1.0
    assert (np.abs(np.diff(told, axis=0)) <= 0.08 + 1e-9).all()
    np.testing.assert_allclose(acting[4:-1], told[:-5], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.torque["actuators"], -0.1 * acting, rtol=0, atol=1e-9)


def test_gears_that_give_are_actuators() -> None:
    """What arrives is K (q_motor - q), where nothing damps."""
    effects = sa.Effects(joint_stiffness=2e3, rotor_inertia=0.2)
    run = follow(*small(), waves(2, 0.5), effects=effects)
    found = sa.attribution(run)
    given = 2e3 * (run.q_motor - run.q)
    np.testing.assert_allclose(found.torque["actuators"], run.tau - given, atol=1e-9)


def test_friction_of_a_joint_that_sticks_is_what_holds_it() -> None:
    """A push of 1 N·m against 3 N·m of dry friction: 1 N·m, and nothing moves."""
    arm = two_link()
    plant = sa.Plant(
        arm.with_friction(coulomb=3.0, smoothing=0.0), sa.Sines(0.0, offset=(1.0, -1.0))
    )
    rest = sa.Sines(1.0, offset=(0.0, 0.0))
    found = sa.attribution(follow(arm, plant, rest, duration=0.1))
    np.testing.assert_allclose(found.torque["friction"], [[-1.0, 1.0]] * 101, atol=1e-12)
    np.testing.assert_allclose(found.torque["disturbance"], [[1.0, -1.0]] * 101, atol=1e-12)
    assert found.sentence() == "There is no error of joint 1 to speak of."


# The error.


def rotor(**friction: Any) -> sa.Serial:
    """A joint of 0.5 kg·m²."""
    return sa.Serial.from_dh([0.0], 0.0, 0.0, armature=0.5, gravity=np.zeros(3), **friction)


def test_the_error_of_a_push_has_the_amplitude_of_the_loop() -> None:
    """-(F/M) / (k_p - ω² + i k_v ω) after the start has faded, for F sin ωt."""
    force, speed, kp, kv = 2.0, 6.0, 100.0, 20.0
    plant = sa.Plant(rotor(), sa.Sines(speed, sin=[force]))
    run = sa.simulate(plant, sa.ComputedTorque(rotor(), kp, kv), waves(1, 0.3), 6.0, PERIOD)
    found = sa.attribution(run)
    answer = -(force / 0.5) / complex(kp - speed**2, kv * speed)
    wanted = np.imag(answer * np.exp(1j * speed * run.t))
    late = run.t > 3.0
    np.testing.assert_allclose(found.error["disturbance"][late, 0], wanted[late], atol=1e-7)


def test_an_integral_takes_a_constant_push_off_the_error_and_friction_stays() -> None:
    plant = sa.Plant(rotor(coulomb=1.0), sa.Sines(0.0, offset=[5.0]))
    run = follow(rotor(), plant, waves(1, 0.3), sa.laws.pid, duration=8.0)
    found = sa.attribution(run, window=(4.0, 8.0))
    assert_adds_up(found, run)
    # The push is 25 times as strong as friction in power, and of the torque most.
    assert found.torque_shares["disturbance"][0] > 0.9
    assert abs(found.error_shares["disturbance"][0]) < 0.01
    assert found.error_shares["friction"][0] > 0.95
    assert found.cancelled[0] > 0.7


LINEAR = ("computed_torque", "pd_gravity", "h_infinity", "pid")
OBSERVERS = ("momentum_observer", "disturbance_observer")


@pytest.mark.parametrize("law", LINEAR + OBSERVERS)
def test_the_error_by_a_cause_is_what_goes_away_without_it(law: str) -> None:
    """Friction, of an arm with a link that is heavier than the model: the runs differ by it.

    Not to rounding, for without friction the arm is elsewhere, by the error. And half a sample of
    hold is in no torque at the rows.
    """
    nominal, path = robot("ur5e"), waves(6, 0.2, offset=scenes.UR5E)
    arm, make = scenes.heavier(nominal, 2, 1.5), getattr(sa.laws, law)
    run = follow(nominal, sa.Plant(arm.with_friction(coulomb=1.0)), path, make)
    without = follow(nominal, sa.Plant(arm), path, make)
    found = sa.attribution(run)
    assert_adds_up(found, run)
    assert (np.abs(found.error_shares["rest"]) < 0.03).all()
    rows = run.t > 1.0
    gone = (run.e - without.e)[rows]
    off = np.linalg.norm(found.error["friction"][rows] - gone, axis=0)
    assert (off < 0.08 * np.linalg.norm(gone, axis=0)).all()


def test_a_fuzzy_compensator_takes_its_share_off_every_cause() -> None:
    run = sa.paper.simulation(3, "claimed", duration=20.0).run()
    found = sa.attribution(run, window=(10.0, 20.0))
    assert_adds_up(found, run)
    left = np.sqrt((found.whole[run.t >= 10] ** 2).mean(axis=0))
    whole = np.sqrt(((found.whole + run.tau_compensation)[run.t >= 10] ** 2).mean(axis=0))
    np.testing.assert_allclose(found.cancelled, 1.0 - left / whole, rtol=1e-12)
    assert (found.cancelled > 0.9).all()
    assert "late or wrong cancelling" in found.sentence()
    assert "cancels 92 % of what its model lacks" in found.sentence()


def test_where_no_linear_loop_explains_the_error_the_sentence_says_so() -> None:
    run = sa.Scenario.read("panda_payload").simulate("super_twisting", duration=4.0)
    found = sa.attribution(run, window=(2.0, 4.0))
    assert_adds_up(found, run)
    assert found.sentence().startswith("No linear loop explains the error of joint ")


# What runs there are.


def test_a_run_from_a_file_has_the_same_attribution(tmp_path: Path) -> None:
    run = scenes.panda_payload()
    run.save(tmp_path / "run.npz")
    fresh, loaded = sa.attribution(run), sa.attribution(sa.Run.load(tmp_path / "run.npz"))
    assert list(fresh.torque) == list(loaded.torque)
    for name in fresh.torque:
        np.testing.assert_array_equal(fresh.torque[name], loaded.torque[name])
    assert str(fresh) == str(loaded)


def test_a_callable_disturbance_is_given_anew_to_a_run_from_a_file(tmp_path: Path) -> None:
    def push(q: np.ndarray, dq: np.ndarray, t: float) -> np.ndarray:
        return 0.5 * np.array([np.sin(t), 1.0])

    run = follow(two_link(), sa.Plant(two_link(), push), waves(2, 0.5), duration=1.0)
    run.save(tmp_path / "run.npz")
    loaded = sa.Run.load(tmp_path / "run.npz")
    with pytest.raises(ValueError, match=r"disturbance: it was a callable, .*; give disturbance="):
        sa.attribution(loaded)
    given, known = sa.attribution(loaded, disturbance=push), sa.attribution(run)
    np.testing.assert_array_equal(given.torque["disturbance"], known.torque["disturbance"])


class Spring:
    """A controller of one's own: a stiff spring on a constant inertia."""

    def step(self, q: Any, dq: Any, q_d: Any, dq_d: Any, ddq_d: Any, dt: float) -> Any:
        return 2.0 * ddq_d - 400.0 * (q - q_d) - 60.0 * (dq - dq_d)


def test_a_law_of_ones_own_is_feedback_as_a_whole(tmp_path: Path) -> None:
    run = sa.simulate(
        sa.Plant(two_link(coulomb=0.5)), Spring(), waves(2, 0.5), 2.0, control_period=PERIOD
    )
    found = sa.attribution(run)
    assert_adds_up(found, run)
    assert found.notes[0].startswith("the law is your own")
    assert not found.torque["sampling"].any() and not found.torque["cancelled"].any()
    run.save(tmp_path / "run.npz")
    again = sa.attribution(sa.Run.load(tmp_path / "run.npz"))
    np.testing.assert_array_equal(found.whole, again.whole)


def test_runs_that_do_not_say_enough_are_refused() -> None:
    run = scenes.gain()
    other = dataclasses.replace(run, notes=("another",))
    with pytest.raises(ValueError, match=r"^run: got one that does not say what it was made with"):
        sa.attribution(other)
    motion = sa.paper.simulation(2, duration=0.1).run(record="motion")
    with pytest.raises(ValueError, match=r'with 0 rows of torques, .* record="motion" keeps none'):
        sa.attribution(motion)
    with pytest.raises(
        ValueError, match=re.escape("window: got (9.0, 10.0), wants one with a row")
    ):
        sa.attribution(run, window=(9.0, 10.0))
    with pytest.raises(ValueError, match=r"^unloaded: got 7 joints, wants 2"):
        sa.attribution(run, unloaded=robot("panda"))
    guard = sa.Guard(sa.ComputedTorque(two_link(), 100, 20), PERIOD, effort_limit=100.0)
    guarded = sa.simulate(sa.Plant(two_link()), guard, waves(2, 0.1), 0.1, control_period=PERIOD)
    with pytest.raises(ValueError, match="wants one of `simulate` without a guard"):
        sa.attribution(guarded)


# Words and pictures.


def test_a_prismatic_joint_has_metres_and_newtons() -> None:
    """A carriage of 2 kg, pushed."""
    rail = sa.Serial.from_dh(
        [0.0], 0.0, 0.0, kind="prismatic", mass=2.0, inertia=[[0.1, 0.1, 0.1]], gravity=np.zeros(3)
    )
    plant = sa.Plant(rail, sa.Sines(0.0, offset=[4.0]))
    found = sa.attribution(follow(rail, plant, waves(1, 0.1), bandwidth=10.0, duration=2.0))
    # 4 N on 2 kg against k_p = 100: 20 mm in the end.
    assert np.isclose(found.e[-1, 0], -0.02, rtol=1e-3)
    assert " mm, 0 to 2 s) is the disturbance" in found.sentence()
    assert found.plot().axes[0].get_ylabel() == "force [N]"


def test_shares_are_projections_on_the_whole() -> None:
    found = sa.attribution(scenes.panda_payload(), window=(1.0, 3.0))
    rows = (found.t >= 1.0) & (found.t <= 3.0)
    whole = found.mismatch[rows]
    for name, share in found.torque_shares.items():
        part = found.torque[name][rows]
        np.testing.assert_allclose(share[1], part[:, 1] @ whole[:, 1] / (whole[:, 1] @ whole[:, 1]))
        np.testing.assert_allclose(found.rms_torque[name], np.sqrt((part**2).mean(axis=0)))


def test_the_sentence_names_joint_cause_and_what_is_cancelled() -> None:
    arm = robot("panda")
    plant = sa.Plant(arm.with_payload(2.0, (0.0, 0.0, 0.05)).with_friction(coulomb=0.5))
    run = follow(arm, plant, waves(7, 0.2, offset=PANDA), sa.laws.pid)
    found = sa.attribution(run)
    # The integral takes gravity off: what is left is friction.
    share = 100.0 * found.error_shares["friction"][1]
    rms = 1e3 * run.metrics().rms_e[1]
    said = found.sentence(1)
    where = f"joint 2 (RMS {rms:.3g} mrad, 0 to 4 s)"
    assert said.startswith(f"About {share:.0f} % of the error of {where} is friction")
    assert (
        f"The controller cancels {100 * found.cancelled[1]:.0f} % of what its model lacks." in said
    )
    assert str(found).startswith(found.sentence())
    assert "of the missing torque [%]" in str(found)


def test_the_picture_has_a_row_a_joint_with_areas_that_end_at_their_sum() -> None:
    found = sa.attribution(scenes.panda_payload())
    figure = found.plot(1, 3)
    over_time = figure.axes[0::2]
    assert [axes.get_title("right") for axes in over_time] == ["joint 2", "joint 4"]
    assert [axes.get_ylabel() for axes in over_time] == ["torque [N·m]"] * 2
    areas = {area.get_label() for area in over_time[0].collections}
    assert {"gravity of the payload", "inertia of the payload"} <= areas
    line = over_time[0].get_lines()[0].get_ydata()
    assert np.isclose(line.mean(), found.mismatch[:, 1].mean(), rtol=1e-2)
    first = figure.axes[1].texts[0].get_text()
    share = 100.0 * found.error_shares["payload_gravity"][1]
    assert first == f"{share:.0f} %  gravity of the payload"
    assert len(found.plot().axes) == 14
    with pytest.raises(ValueError, match=r"^joint: got 7, wants 0 to 6"):
        found.plot(7)
    with pytest.raises(ValueError, match=r"^joint: got -1, wants 0 to 6"):
        found.sentence(-1)
