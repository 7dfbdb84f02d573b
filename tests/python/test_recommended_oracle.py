"""The oracle of the recommended law holds what can be known of it without the oracle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import steadyarm as sa
from recommended_oracle import Recommended, Record, track
from recommended_rule import (
    chain,
    condition,
    design,
    fastest,
    loop_root,
    noise_gain,
    share,
    two_link,
)

NOMINAL = sa.TwoLink(mass=4, length=0.5, inertia=0.2)
EFFORT = np.full(2, 20.0)
MIDDLE = np.array([0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8])


@pytest.mark.parametrize("f2", [20.0, 137.0, 2000.0])
def test_the_gain_for_noise_is_that_of_the_response(f2: float) -> None:
    first, second = share(100.0, 1e-3), share(f2, 1e-3)
    x, y, response = 0.0, 0.0, []
    for k in range(4000):
        x += first * ((k == 0) - (k == 1) - x)
        y += second * (x - y)
        response.append(y)
    assert noise_gain(100.0, f2, 1e-3) == pytest.approx(np.sqrt(np.dot(response, response) / 2))


def test_the_bandwidths_of_a_panda_are_those_of_a_program_written_apart() -> None:
    """Which printed 20 16 21 24 33 34 37 for 24 poses within 0.8 rad of the middle, and 2 kg."""
    panda = sa.Serial.shipped("panda")
    poses = MIDDLE + np.random.default_rng(2).uniform(-0.8, 0.8, (24, 7))
    weight = chain(panda, 2.0).weight
    inertia = np.array([np.diag(weight(q)) for q in poses]).max(axis=0)
    sigma_q = 2 * np.pi / 2**16 / np.sqrt(12)
    effort = panda.limits["effort"]
    found = [
        fastest(a, b, 1e-3, 1, 100.0, sigma_q)[0] for a, b in zip(inertia, effort, strict=True)
    ]
    assert np.rint(found).tolist() == [20, 16, 21, 24, 33, 34, 37]


@pytest.mark.parametrize(("heavier", "stable"), [(8.9, True), (9.1, False)])
def test_the_triple_pole_is_stable_up_to_nine_times_the_inertia(
    heavier: float, stable: bool
) -> None:
    """Routh: M s³ + D(3ps² + 3p²s + p³) is Hurwitz for M < 9D; so is a fast loop of no delay."""
    one, p = np.eye(1), np.array([10.0])
    root = loop_root(heavier * one, one, p, np.array([1e5]), 1e-6, 0, 1e5)
    assert (root < 0.0) == stable


def test_the_condition_of_one_joint_is_its_formula() -> None:
    one, p, share_of_d = np.eye(1), np.array([7.0]), 0.4
    s = 7j * np.geomspace(0.01, 100.0, 121)
    delta = (1 - 1.25 * share_of_d) / (1 + s / 1.4) * s**3
    delta /= s**3 + share_of_d * (3 * 7 * s**2 + 3 * 49 * s + 343)
    want = abs(delta / (1 - delta)).max()
    got = condition(one, share_of_d * one, p, 1.4, 1.25, np.array([3.0]))
    assert got == pytest.approx(want, rel=1e-12)
    assert condition(one, one, p, 1.4, 1.0, np.array([3.0])) == 0.0


def test_half_and_fourfold_in_one_design_cost_what_the_weight_says() -> None:
    """D = 1 + (4 - 1)/4 times the nominal inertia, the lightest a half: p times 2 · 0.5/1.75."""
    one = design(two_link(NOMINAL, 1.0, 4.0), 1e-3, 16, 1, EFFORT)
    both = design(two_link(NOMINAL, 0.5, 4.0), 1e-3, 16, 1, EFFORT)
    assert np.allclose(both.p / one.p, 1 / 1.75, rtol=1e-12)
    assert np.array_equal(both.f2, one.f2)


def test_where_nothing_is_wrong_the_torque_is_that_of_the_motion() -> None:
    """On the desired motion, the model's torque applied, nothing is fed back or learnt."""
    model = two_link(NOMINAL)
    law = Recommended(model, design(model, 1e-3, 16, 0, EFFORT))
    applied = np.zeros(2)
    for k in range(300):
        t = 1e-3 * k
        q, dq, ddq = (np.full(2, x) for x in (1 - np.cos(t), np.sin(t), np.cos(t)))
        tau = law.step(q, q, dq, ddq, applied)
        assert np.allclose(tau, NOMINAL.inverse_dynamics(q, dq, ddq), rtol=0, atol=1e-13)
        applied = tau
    assert abs(law.theta).max() < 1e-13


PUSH = sa.Sines(1.0, sin=[1.0, 0.0], cos=[0.0, 1.0])
PATH = sa.Sines([1.0, 3.0], sin=[[0.0, -0.2], [0.2, 0.0]], cos=[[0.5, -0.5], [0.0, 0.0]])
HEAVY = NOMINAL.__replace__(mass=8.0, inertia=0.4)
CHAIN = sa.Serial.from_dh(
    a=[0.0, 0.4, 0.3], alpha=[np.pi / 2, 0.0, 0.0], d=[0.3, 0.0, 0.0], mass=[3.0, 2.0, 1.0],
    com=[[0.0, -0.1, 0.0], [-0.2, 0.0, 0.0], [-0.15, 0.0, 0.0]], inertia=0.02, armature=0.05,
)  # fmt: skip


def two_links() -> Recommended:
    model = two_link(NOMINAL)
    return Recommended(model, design(model, 1e-3, 16, 1, EFFORT), hand_over=2.0)


def three_joints() -> Recommended:
    model = chain(CHAIN, 1.0)
    return Recommended(model, design(model, 1e-3, 16, 1, np.array([60.0, 60.0, 20.0])))


def limited(steps: int) -> tuple[Recommended, Record]:
    """A two-link arm that is pushed harder than its motors can, three fifths through the run."""
    law, end = two_links(), 1e-3 * steps
    knock = sa.Pulses(0.6 * end, [40.0, 0.0], 0.05 * end)
    plant = sa.Plant(HEAVY, [PUSH, knock], effort_limit=20.0)
    return law, track(law, plant, PATH, end)


def resting(steps: int) -> tuple[Recommended, Record]:
    """A chain with friction and a load that moves in the middle third of the run and rests."""
    law, third = three_joints(), 1e-3 * steps / 3.0
    there = sa.Quintic([0.0, 0.5, -0.9], [0.4, 0.1, -0.6], duration=third, start_time=third)
    really = CHAIN.with_payload(0.8).with_friction(viscous=0.4, coulomb=0.5)
    return law, track(law, sa.Plant(really), there, 1e-3 * steps, start=np.array([0.0, 0.5, -0.9]))


@pytest.mark.parametrize("scene", [limited, resting])
def test_a_record_played_back_gives_its_torques(
    scene: Callable[[int], tuple[Recommended, Record]],
) -> None:
    law, run = scene(900)
    again = Recommended(law.model, law.design, law.hand_over)
    for q, q_d, dq_d, ddq_d, applied, tau in zip(
        run.q, run.q_d, run.dq_d, run.ddq_d, run.applied, run.tau, strict=True
    ):
        assert np.array_equal(again.step(q, q_d, dq_d, ddq_d, applied), tau)
    assert np.array_equal(again.theta, law.theta)
    assert (again.theta != 0.0).any()


def test_it_learns_twice_the_inertia_and_a_push() -> None:
    """The figures that were printed for it: 0.0003 rad, peak 17 to 19 N·m, 374 N·m/s."""
    run = track(two_links(), sa.Plant(HEAVY, PUSH), PATH, 40.0)
    late = slice(len(run.e) // 2, None)
    assert np.sqrt((run.e[late] ** 2).sum(axis=1).mean()) <= 3e-4
    assert 17.0 <= abs(run.applied).max() <= 19.0
    assert abs(np.diff(run.applied[late], axis=0)).sum() / 20.0 == pytest.approx(374.0, rel=0.05)
