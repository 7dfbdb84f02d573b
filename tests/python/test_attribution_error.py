"""Attribution: the estimate of the error is the loop's, and what goes away without a cause."""

from __future__ import annotations

from typing import Any

import attribution_scenes as scenes
import numpy as np
import pytest
import steadyarm as sa
from attribution_scenes import PERIOD, assert_adds_up, follow, robot, waves


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
