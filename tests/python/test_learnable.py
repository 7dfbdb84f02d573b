"""What can be learnt along a path."""

import math
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from steadyarm.learnable import FAST, PERIOD

SAMPLED = 0.01
"""Relative: a path is looked at in at most 500 points."""

STD_TOL = 1e-6
"""Relative: the same least squares, by another way."""


def lift() -> sa.Serial:
    """A joint that lifts 3 kg straight up."""
    return sa.Serial.from_dh(
        a=[0.0], alpha=0.0, d=0.0, kind="prismatic", mass=3.0, gravity=(0, 0, -9.81)
    )


def test_mass_of_a_payload_that_is_lifted_is_known_as_the_closed_form_says() -> None:
    # τ = m (g + z̈) + friction, z = A sin ωt. Over whole periods friction, odd in cos ωt, is
    # orthogonal to g + z̈, so std(m) = noise/√Σ(g + z̈)² = noise/√(N (g² + A²ω⁴/2)).
    amplitude, omega = 0.2, 3.0
    path = sa.Sines(omega, sin=[amplitude])
    duration = 5 * 2 * math.pi / omega
    report = sa.learnable(lift(), path, duration, noise=0.5)
    size = math.sqrt(9.81**2 + amplitude**2 * omega**4 / 2)
    std = 0.5 / size / math.sqrt(duration / PERIOD)
    assert math.isclose(report.payload_mass, std, rel_tol=SAMPLED)
    assert np.isinf(report.payload_com).all() and np.isinf(report.payload_inertia).all()
    assert (report.directions, report.all_directions) == (1, 1)
    assert "known: mass to" in report.sentences[2]
    assert report.sentences[3].endswith(
        "not known: x of its centre of mass, y of its centre of mass, z of its centre of mass, "
        "moment xx, moment xy, moment yy, moment xz, moment yz, moment zz"
    )


def test_four_times_as_long_or_half_the_noise_halves_the_deviation() -> None:
    path, arm = sa.Sines(3.0, sin=[0.2]), lift()
    period = 2 * math.pi / 3.0
    once = sa.learnable(arm, path, 2 * period, noise=0.5).payload_mass
    assert math.isclose(
        sa.learnable(arm, path, 8 * period, noise=0.5).payload_mass, once / 2, rel_tol=SAMPLED
    )
    assert math.isclose(
        sa.learnable(arm, path, 2 * period, noise=0.25).payload_mass, once / 2, rel_tol=1e-9
    )


def wave(joints: int) -> sa.Sines:
    """Every joint at two frequencies of its own phase."""
    n = np.arange(joints)
    sin = 0.4 * np.array([np.cos(n), np.sin(2 * n)])
    cos = 0.4 * np.array([np.sin(n), np.cos(3 * n)])
    return sa.Sines([1.0, 3.0], sin=sin, cos=cos, offset=0.3 * np.ones(joints))


def test_deviations_are_those_of_least_squares_with_payloads_that_are_hung_on() -> None:
    """The columns once more: by what `Serial.with_payload` adds to the inverse dynamics."""
    arm = sa.Serial.shipped("ur5e").without_friction()
    path, noise, duration = wave(6), np.linspace(0.01, 0.03, 6), 2 * math.pi
    times = np.linspace(0.0, duration, 512 + 1)
    rows = times[np.unique(np.linspace(0, 512, 500).astype(int))]
    random = np.random.default_rng(1)
    places = random.uniform(-0.3, 0.3, (10, 3))  # of point masses; their bodies are independent
    hung = [arm.with_payload(1.0, com=place) for place in places]
    bodies = np.array([body(place) for place in places])
    blocks = []
    for t in rows:
        motion = path(t)
        alone = arm.inverse_dynamics(*motion)
        added = np.array([other.inverse_dynamics(*motion) - alone for other in hung])
        speed = motion[1]
        friction = np.hstack([np.diag(np.tanh(speed / FAST)), np.diag(speed)])
        blocks.append(np.hstack([np.linalg.solve(bodies, added).T, friction]) / noise[:, None])
    phi = np.vstack(blocks) * math.sqrt(duration / PERIOD / len(rows))
    scale = np.linalg.norm(phi, axis=0)
    wanted = np.sqrt(np.diag(np.linalg.inv((phi / scale).T @ (phi / scale)))) / scale
    report = sa.learnable(arm, path, noise=noise, payload=2.0)
    assert math.isclose(report.payload_mass, wanted[0], rel_tol=STD_TOL)
    assert np.allclose(report.payload_com, wanted[1:4] / 2.0, rtol=STD_TOL)
    assert np.allclose(report.payload_inertia, wanted[4:10], rtol=STD_TOL)


def body(place: np.ndarray) -> list[float]:
    """Mass, first moments, and moments xx, xy, yy, xz, yz, zz of 1 kg in a point."""
    x, y, z = place
    moments = [y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y]
    return [1.0, x, y, z, *moments]


@pytest.mark.parametrize(
    ("arm", "every"),
    [
        # Mayeda, Yoshida, Osuka 1990: 7N - 4β₁ - 2β₂, where the axes of the first β₁ joints are
        # parallel, and β₂ is 1 where the first is along gravity. By hand: m₂c₂x, m₂c₂y, I₂,
        # I₁ + m₂l₁²; under gravity m₁c₁x + m₂l₁ and m₁c₁y too.
        (sa.paper.nominal(), 4),
        (sa.paper.nominal().with_gravity(9.81), 6),
        (sa.Serial.shipped("puma560"), 36),
        (sa.Serial.shipped("panda"), 43),
    ],
    ids=["flat", "upright", "puma560", "panda"],
)
def test_directions_that_matter_are_the_base_parameters(arm: sa.Arm, every: int) -> None:
    assert sa.learnable(arm, wave(arm.joints)).all_directions == every


def test_an_arm_at_rest_shows_what_carries_it_alone() -> None:
    still = (np.array([0.0, 4.0]), np.tile([0.3, 0.4], (2, 1)))
    flat = sa.learnable(sa.paper.nominal(), still)
    assert flat.directions == 0 and math.isinf(flat.payload_mass)
    # Two torques of gravity; of a payload m they differ by m g l₁ cos q₁, and know no more.
    upright = sa.learnable(sa.paper.nominal().with_gravity(9.81), still, noise=0.02)
    std = 0.02 * math.sqrt(2.0) / (9.81 * 0.5 * math.cos(0.3)) / math.sqrt(4.0 / PERIOD)
    assert upright.directions == 2
    assert math.isclose(upright.payload_mass, std, rel_tol=1e-6)
    assert np.isinf(upright.payload_com).all() and np.isinf(upright.payload_inertia).all()
    assert "joints 1 and 2 never move: their friction cannot be learnt" in upright.sentences
    assert "2 of the 6 combinations" in str(upright)


def test_two_link_arm_and_the_chain_of_it_teach_the_same() -> None:
    mass, length, inertia = (4.0, 3.0), (0.5, 0.7), (0.2, 0.1)
    arm = sa.TwoLink(mass, length, inertia, gravity=9.81)
    chain = sa.Serial.from_dh(
        a=length, alpha=0.0, d=0.0, mass=mass, gravity=(0.0, -9.81, 0.0),
        com=[[-x / 2, 0.0, 0.0] for x in length], inertia=[[x, x, x] for x in inertia],
    )  # fmt: skip
    one, other = sa.learnable(arm, wave(2)), sa.learnable(chain, wave(2))
    assert one.payload_mass == other.payload_mass < 0.1
    assert np.array_equal(one.payload_com, other.payload_com)
    assert one.sentences == other.sentences


def test_friction_is_told_joint_by_joint() -> None:
    arm = sa.Serial.shipped("ur5e")
    # Least jerk: 15/8 Δ/T is 0.047 rad/s for Δ = 0.05 in 2 s, and 0.94 for Δ = 1.
    go = np.array([1.0, 0.05, 0.0, -1.0, 0.0, 0.0])
    report = sa.learnable(arm, sa.Quintic(np.zeros(6), go, 2.0))
    assert report.friction == ("one way", "slow", "nothing", "one way", "nothing", "nothing")
    assert np.allclose(report.speeds[0], [0, 0, 0, 15 / 16, 0, 0], atol=1e-4)
    assert np.allclose(report.speeds[1], [15 / 16, 15 / 320, 0, 0, 0, 0], atol=1e-4)
    assert report.sentences[:3] == (
        "joints 1 and 4 move one way only: their friction can be learnt for that way alone",
        "joint 2 is never faster than 0.05 rad/s: its friction cannot be learnt",
        "joints 3, 5 and 6 never move: their friction cannot be learnt",
    )
    there_and_back = sa.learnable(arm, wave(6))
    assert there_and_back.friction == ("both ways",) * 6


def with_sets(basis: sa.FuzzyBasis) -> sa.ComputedTorque:
    arm = sa.paper.nominal()
    return sa.ComputedTorque(arm, kp=8.0, kv=5.5, compensator=sa.FuzzyCompensator(basis))


def test_coverage_is_the_share_of_time_in_the_sets() -> None:
    # |sin t| <= 1/2 for a third of the time; the set fires by half at 1/2, and the path is at 1.
    path = sa.Sines(1.0, sin=[1.0, 0.5])
    width = 0.5 / math.sqrt(2 * math.log(2))
    report = sa.learnable(with_sets(sa.FuzzyBasis("concat", [0.0], width, inputs="q_d")), path)
    assert report.coverage == pytest.approx(1 / 3, abs=2 / 512)
    (outside,) = report.outside
    assert (outside.signal, outside.joint) == ("q_d", 0)
    assert outside.by == pytest.approx(0.5, rel=1e-4)
    assert report.sentences[-1] == "q_d of joint 1 leaves its sets by 0.5 rad"


@pytest.mark.parametrize("width", [0.3, [0.3, 0.2, 0.4]])
@pytest.mark.parametrize("scale", [-2.0, 1.0])
def test_sets_for_all_inputs_are_the_same_sets_given_one_by_one(width: Any, scale: float) -> None:
    path, centers = sa.Sines(1.0, sin=[1.0, 0.5]), [-1.0, 0.1, 0.4]
    inputs = {"dq_d": scale}
    one = sa.FuzzyBasis("concat", centers, width, inputs=inputs)
    own = sa.FuzzyBasis(
        "concat", [centers] * 2, [np.broadcast_to(width, 3).tolist()] * 2, inputs=inputs
    )
    first, second = (sa.learnable(with_sets(basis), path) for basis in (one, own))
    assert first.coverage == second.coverage and first.outside == second.outside
    x = scale * np.cos(np.linspace(0, 2 * np.pi, 513))[:, None] * [1.0, 0.5]
    fires = np.exp(-(((x[:, :, None] - centers) / width) ** 2) / 2).max(axis=2)
    assert first.coverage == pytest.approx((fires >= 0.5).all(axis=1).mean(), abs=2 / 513)


@pytest.mark.parametrize("inputs", ["reference", "state", "trajectory"])
@pytest.mark.parametrize("sets", [1, 2, 9])
def test_sets_for_a_path_cover_it(inputs: str, sets: int) -> None:
    path = sa.paper.reference()
    basis = sa.FuzzyBasis("per_joint", **sa.centers_for(path, inputs, sets, margin=0.0))
    report = sa.learnable(with_sets(basis), path)
    assert report.coverage == 1.0 and report.outside == ()
    assert report.sentences[-1] == "the sets cover 100 % of the path's time"


def test_the_report_of_a_design_along_a_path_has_it() -> None:
    scene = sa.paper.simulation(3, "claimed")
    report = sa.design(scene.tracker, path=scene.reference)
    alone = sa.learnable(scene.tracker, scene.reference)
    assert report.learnable is not None
    assert report.learnable.sentences == alone.sentences
    assert f"What this path can teach:\n{alone}\n" in str(report)
    assert sa.design(scene.tracker).learnable is None
    assert (
        sa.learnable(sa.laws.pid(scene.tracker.arm, bandwidth=9.0), scene.reference).coverage
        is None
    )


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"robot": 3}, TypeError, "^robot: got int, wants an Arm or a Controller"),
        ({"path": 3}, TypeError, "^path: got int"),
        ({"duration": -1.0}, ValueError, "^duration: got -1.0, wants a number > 0"),
        ({"noise": 0.0}, ValueError, "^noise: got 0.0, wants numbers > 0"),
        ({"noise": [1, 2, 3]}, TypeError, r"^noise: got \[1, 2, 3\], wants a number, or \(2,\)"),
        ({"noise": "x"}, TypeError, "^noise: got 'x'"),
        ({"payload": math.inf}, ValueError, "^payload: got inf, wants numbers > 0"),
        ({"path": wave(3)}, ValueError, "^path: got one of 3 joints, wants one of 2"),
        ({"path": lambda t: ([t], [t], [t])}, ValueError, "^duration: got None, wants the length"),
        (
            {"path": lambda t: ([t], [t], [t]), "duration": 1.0},
            ValueError,
            r"^path: q_d: got shape \(1,\), wants \(2,\)",
        ),
    ],
)
def test_each_argument_that_makes_no_sense_is_named(options: dict, error, message: str) -> None:
    with pytest.raises(error, match=message):
        sa.learnable(**{"robot": sa.paper.nominal(), "path": wave(2)} | options)
