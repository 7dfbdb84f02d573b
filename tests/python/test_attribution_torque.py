"""Attribution: the torque of each cause is what was recorded, and what others compute."""

from __future__ import annotations

from typing import Any

import attribution_scenes as scenes
import numpy as np
import pytest
import steadyarm as sa
from attribution_scenes import PANDA, PERIOD, assert_adds_up, follow, robot, small, two_link, waves

ARM = ("inertia", "coriolis", "gravity", "friction", "contact", "disturbance")
LOAD = ("payload_inertia", "payload_coriolis", "payload_gravity")


def times(matrices: Any, vectors: Any) -> np.ndarray:
    return np.einsum("tij,tj->ti", np.asarray(matrices), vectors)


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
