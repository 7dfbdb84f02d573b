"""Figures of a path, and the sets that it needs."""

import math

import numpy as np
import pytest
import steadyarm as sa
from steadyarm.paths import path_figures, sample

FOUND = 1e-6
"""Relative: peaks are looked for between the samples."""

JERK_TOL = 0.01
"""Relative: jerk is a mean over a step, of 64 or more in a period or a move."""

HALF = math.sqrt(2.0 * math.log(2.0))
"""exp(-x²/2) is 1/2 there."""


def two_sines(amplitude: float, third: float, omega: float) -> sa.Sines:
    """amplitude sin ωt + third sin 3ωt, of two joints, the second one half as large."""
    sin = np.outer([amplitude, third], [1.0, 0.5])
    return sa.Sines([omega, 3.0 * omega], sin=sin, offset=[0.3, -0.2])


def test_peaks_of_sines_are_those_of_the_closed_form() -> None:
    # With s = sin ωt: A s + B (3 s - 4 s³), whose slope is zero at s² = (A + 3 B) / 12 B.
    # Velocity and acceleration: ω (A cos + 3 B cos 3), ω² (A s + 9 B sin 3), likewise.
    A, B, omega = 0.5, 0.2, 1.7
    position = math.sqrt((A + 3 * B) / (12 * B)) * (A + 3 * B) * 2 / 3
    root = math.sqrt((A + 27 * B) / (108 * B))
    acceleration = max(abs(A - 9 * B), root * (A + 27 * B) * 2 / 3)
    figures = path_figures(two_sines(A, B, omega))
    assert np.allclose(figures["q"][:, 0], [0.3 - position, 0.3 + position], rtol=FOUND)
    assert np.allclose(figures["q"][:, 1], [-0.2 - position / 2, -0.2 + position / 2], rtol=FOUND)
    assert np.allclose(figures["speed"], omega * (A + 3 * B) * np.array([1, 0.5]), rtol=FOUND)
    peak = omega**2 * acceleration * np.array([1, 0.5])
    assert np.allclose(figures["acceleration"], peak, rtol=FOUND)
    assert np.allclose(figures["dq"][1], figures["speed"], rtol=FOUND)
    jerk = omega**3 * (A + 27 * B) * np.array([1, 0.5])
    assert np.allclose(figures["jerk"], jerk, rtol=JERK_TOL)


@pytest.mark.parametrize("duration", [3.0, 40.0, 400.0])
def test_a_fast_small_sine_is_seen_for_as_long_as_it_lasts(duration: float) -> None:
    path = sa.Sines([0.5, 90.0], sin=[[1.0, 0.0], [0.01, 0.01]])
    figures = path_figures(path, duration)
    # The second joint has the fast one alone: A ω and A ω².
    assert np.allclose(figures["speed"][1], 0.9, rtol=FOUND)
    assert np.allclose(figures["acceleration"][1], 81.0, rtol=FOUND)


def test_peaks_of_a_quintic_are_those_of_the_closed_form() -> None:
    # Least jerk: 15/8 Δ/T, 10/√3 Δ/T², 60 Δ/T³ (Flash, Hogan 1985).
    far, time = np.array([1.0, -2.0]), 2.0
    for path in (
        sa.Quintic([0, 0], far, time, start_time=0.7),
        sa.Table(*knots(sa.Quintic([0, 0], far, time))),
        (*knots(sa.Quintic([0, 0], far, time)),),
    ):
        figures = path_figures(path)
        size = np.abs(far)
        assert np.allclose(figures["q"], [[0, -2], [1, 0]], atol=1e-12)
        assert np.allclose(figures["speed"], 15 / 8 * size / time, rtol=FOUND)
        assert np.allclose(figures["acceleration"], 10 / 3**0.5 * size / time**2, rtol=FOUND)
        assert np.allclose(figures["jerk"], 60 * size / time**3, rtol=JERK_TOL)


def knots(path: sa.Quintic) -> tuple[np.ndarray, ...]:
    """Three samples of it, between which a table of q, dq and ddq is the same quintic."""
    t = np.array([0.0, 0.8, 2.0])
    return (t, *path(t))


def test_waypoints_go_at_their_limits() -> None:
    figures = path_figures(sa.Waypoints([[0, 0], [1, 0.2], [0, 0]], 2.0, 10.0, 100.0))
    assert np.allclose(figures["speed"], [2.0, 0.4], rtol=FOUND)
    assert np.allclose(figures["acceleration"], [10.0, 2.0], rtol=FOUND)
    assert np.allclose(figures["jerk"], [100.0, 20.0], rtol=JERK_TOL)


@pytest.mark.parametrize("omega", [0.3, 40.0, 2 * np.pi * 51.2, 900.0])
def test_a_callable_is_sampled_as_finely_as_it_changes(omega: float) -> None:
    def path(t: float) -> tuple[list[float], list[float], list[float]]:
        s, c = math.sin(omega * t + 0.3), math.cos(omega * t + 0.3)
        return [0.1 * s, 1.0], [0.1 * omega * c, 0.0], [-0.1 * omega**2 * s, 0.0]

    duration = max(10.0, 2 * np.pi / omega)
    figures = path_figures(path, duration)
    assert np.allclose(figures["speed"], [0.1 * omega, 0.0], rtol=1e-3)
    assert np.allclose(figures["acceleration"], [0.1 * omega**2, 0.0], rtol=1e-3)
    assert np.allclose(figures["q"], [[-0.1, 1.0], [0.1, 1.0]], rtol=1e-3)


def test_a_short_move_in_a_long_rest_of_a_callable_is_seen() -> None:
    move = sa.Quintic([0, 0], [0.1, 0.2], 0.1, start_time=3.123)
    figures = path_figures(lambda t: move(t), 20.0)
    assert np.allclose(figures["speed"], 15 / 8 * np.array([1.0, 2.0]), rtol=1e-3)


def test_positions_and_pairs_are_the_table_of_them() -> None:
    t = np.linspace(0.0, 3.0, 31)
    q = np.column_stack([np.sin(t), np.cos(2 * t)])
    of_table = path_figures(sa.Table(t, q))
    for figures in (path_figures((t, q)), path_figures(q, 3.0), path_figures(q.tolist(), 3.0)):
        for name, values in of_table.items():
            assert np.array_equal(figures[name], values), name


def test_scalars_are_for_the_joints_of_the_arm() -> None:
    path = sa.Sines(2.0, sin=0.3)
    assert path_figures(path)["speed"].shape == (2,)
    speed = path_figures(path, arm=sa.Serial.shipped("panda"))["speed"]
    assert np.allclose(speed, np.full(7, 0.6), rtol=FOUND)


def test_samples_are_evenly_spaced_with_both_ends() -> None:
    course = sample(sa.Quintic([0, 0], [1, 2], 2.0))
    assert course.t[0] == 0.0 and course.t[-1] == 2.0
    assert np.allclose(np.diff(course.t), course.t[1], rtol=1e-9)
    assert np.array_equal(course.q, sa.Quintic([0, 0], [1, 2], 2.0)(course.t)[0])


@pytest.mark.parametrize(
    ("path", "duration", "error", "message"),
    [
        (3, 1.0, TypeError, "^path: got int, wants a reference"),
        (lambda t: ([0.0], [0.0], [0.0]), None, ValueError, "^duration: got None"),
        (np.zeros((3, 2)), None, ValueError, "^duration: got None"),
        (sa.Sines(1.0, sin=1.0), 0.0, ValueError, "^duration: got 0.0, wants a number > 0"),
        (sa.Sines(1.0, sin=1.0), math.inf, ValueError, "^duration: got inf"),
        (sa.Sines(1.0, sin=1.0), "x", ValueError, "^duration: got 'x'"),
        (lambda t: 3, 1.0, ValueError, "^path: at t = 0 s it gives no"),
        (lambda t: ([0.0], [0.0, 1.0], [0.0]), 1.0, ValueError, "^path: at t = 0 s"),
        (lambda t: ([math.nan], [0.0], [0.0]), 1.0, ValueError, "^path: at t = 0 s"),
        (([0.0, 1.0], [[0.0], [math.nan]]), None, ValueError, r"^q"),
    ],
)
def test_a_path_that_is_none_is_named(path: object, duration: object, error, message) -> None:
    with pytest.raises(error, match=message):
        path_figures(path, duration)  # type: ignore[arg-type]
    with pytest.raises(error, match=message):
        sa.centers_for(path, duration=duration)  # type: ignore[arg-type]


def sine(*amplitudes: float, omega: float = 2.0) -> sa.Sines:
    return sa.Sines(omega, sin=list(amplitudes), offset=[0.1] * len(amplitudes))


def test_sets_are_evenly_spaced_over_what_the_path_does() -> None:
    # q_d in ±A about 0.1, dq_d in ±A ω, with a tenth of the range beyond both ends.
    sets = sa.centers_for(sine(0.5, 1.0), "reference", sets=(3, 5))
    assert np.allclose(sets["centers"][0], 0.1 + 0.6 * np.array([-1, 0, 1]), atol=1e-6)
    assert np.allclose(sets["centers"][1], 0.1 + 1.2 * np.array([-1, 0, 1]), atol=1e-6)
    assert np.allclose(sets["centers"][2], 1.2 * np.linspace(-1, 1, 5), atol=1e-6)
    assert np.allclose(sets["centers"][3], 2.4 * np.linspace(-1, 1, 5), atol=1e-6)
    # Half of the spacing is HALF widths.
    assert np.allclose(sets["width"], np.array([0.3, 0.6, 0.3, 0.6]) / HALF, rtol=1e-6)
    basis = sa.FuzzyBasis(form="per_joint", **sets)
    assert basis.inputs == [("q_d", 1.0), ("dq_d", 1.0)] and basis.joints == 2


@pytest.mark.parametrize("crossing", [0.3, 0.5, 0.78])
def test_neighbours_cross_at_the_height_that_was_asked_for(crossing: float) -> None:
    sets = sa.centers_for(sine(0.5, 1.0), "q_d", sets=4, crossing=crossing)
    basis = sa.FuzzyBasis(form="concat", normalized=False, **sets)
    centers = np.array(sets["centers"])
    between = 0.5 * (centers[:, 1] + centers[:, 2])
    fired = basis.evaluate([between])[0].reshape(2, 4)
    assert np.allclose(fired[:, 1:3], crossing, rtol=1e-9)


def test_the_paper_s_sets_cross_at_what_the_docstring_says() -> None:
    assert round(math.exp(-((0.5 / sa.paper.WIDTH) ** 2) / 2), 2) == 0.78


def test_margin_and_scales_are_those_of_the_inputs() -> None:
    sets = sa.centers_for(sine(0.5, 1.0), {"q_d": -2.0, "ddq_d": 0.5}, sets=2, margin=0.0)
    # -2 (0.1 ± A) and 0.5 (± A ω²).
    assert np.allclose(sets["centers"][0], [-1.2, 0.8], atol=1e-6)
    assert np.allclose(sets["centers"][1], [-2.2, 1.8], atol=1e-6)
    assert np.allclose(sets["centers"][2:], [[-1.0, 1.0], [-2.0, 2.0]], atol=1e-6)
    assert sa.FuzzyBasis(form="per_joint", **sets).inputs == [("q_d", -2.0), ("ddq_d", 0.5)]


def test_errors_of_a_run_are_the_range_of_e_and_de() -> None:
    run = sa.paper.simulation(2, duration=5.0).run()
    sets = sa.centers_for(sa.paper.reference(), "error", 5, error=run, margin=0.0)
    most = [*np.abs(run.e).max(axis=0), *np.abs(run.de).max(axis=0)]
    assert np.allclose(sets["centers"], np.outer(most, np.linspace(-1, 1, 5)), atol=1e-15)
    assert [centers[2] for centers in sets["centers"]] == [0.0] * 4


def test_the_state_reaches_as_far_beyond_the_path_as_the_error_does() -> None:
    path = sine(0.5, 1.0)
    alone = sa.centers_for(path, "state", 2, margin=0.0)
    assert np.allclose(alone["centers"][1], [-0.9, 1.1], atol=1e-6)
    sets = sa.centers_for(path, "state", 2, margin=0.0, error=([0.2, 0.3], 1.0))
    assert np.allclose(sets["centers"][:2], [[-0.6, 0.8], [-1.2, 1.4]], atol=1e-6)
    assert np.allclose(sets["centers"][2:], [[-2.0, 2.0], [-3.0, 3.0]], atol=1e-6)


def test_a_joint_that_stands_still_has_sets_about_where_it_stands() -> None:
    sets = sa.centers_for(sine(0.5, 0.0, 1.0, 1e-3), "reference", 3, margin=0.0)
    assert np.allclose(sets["centers"][1], [-0.9, 0.1, 1.1], atol=1e-6)
    assert np.allclose(sets["centers"][3], [-0.9, 0.1, 1.1], atol=1e-6)
    assert np.allclose(sets["width"][:4], sets["width"][2] * np.array([0.5, 1, 1, 1]), rtol=1e-6)
    still = sa.centers_for(np.ones((4, 3)), "reference", 3, duration=1.0, margin=0.0)
    assert still["centers"] == [[0.5, 1.0, 1.5]] * 3 + [[-0.5, 0.0, 0.5]] * 3


def test_one_set_is_in_the_middle_and_reaches_both_ends() -> None:
    sets = sa.centers_for(sine(0.5, 1.0), "q_d", 1, margin=0.0)
    assert np.allclose(sets["centers"], [[0.1], [0.1]], atol=1e-6)
    assert np.allclose(sets["width"], np.array([0.5, 1.0]) / HALF, rtol=1e-6)


def test_positions_of_a_continuous_joint_are_covered_as_they_come() -> None:
    def wrapped(t: float) -> tuple[list[float], list[float], list[float]]:
        return [(2.0 * t + math.pi) % (2 * math.pi) - math.pi], [2.0], [0.0]

    def turning(t: float) -> tuple[list[float], list[float], list[float]]:
        return [2.0 * t], [2.0], [0.0]

    around = sa.centers_for(wrapped, "q_d", 2, duration=10.0, margin=0.0)
    assert np.allclose(around["centers"], [[-math.pi, math.pi]], atol=1e-3)
    turns = sa.centers_for(turning, "q_d", 2, duration=10.0, margin=0.0)
    assert np.allclose(turns["centers"], [[0.0, 20.0]], atol=1e-9)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"inputs": "position"}, ValueError, '^inputs: got "position", wants one of'),
        ({"inputs": "error"}, ValueError, "^error: got None, wants a run .* for the input e"),
        ({"inputs": "de"}, ValueError, "^error: got None, wants a run .* for the input de"),
        ({"sets": 0}, ValueError, "^sets: got 0, wants a whole number >= 1"),
        ({"sets": 2.5}, ValueError, "^sets: got 2.5"),
        ({"sets": True}, ValueError, "^sets: got True"),
        ({"sets": "x"}, ValueError, "^sets: got 'x'"),
        ({"sets": (3, 3, 3)}, ValueError, "^sets: got 3 entries, wants one a signal, 2"),
        ({"error": 0.1}, TypeError, "^error: got float, wants a Run or a pair"),
        ({"error": ([1, 2, 3], 1)}, ValueError, r"^error: wants numbers, scalars or \(2,\)"),
        ({"error": (1, -1)}, ValueError, "^error: got .*, wants numbers >= 0"),
        ({"error": (1, math.nan)}, ValueError, "^error: got .*, wants numbers >= 0"),
        ({"margin": -0.1}, ValueError, "^margin: got -0.1, wants a number >= 0"),
        ({"margin": "x"}, ValueError, "^margin: got 'x'"),
        ({"crossing": 1.0}, ValueError, "^crossing: got 1.0, wants a number between 0 and 1"),
        ({"crossing": math.nan}, ValueError, "^crossing: got nan"),
    ],
)
def test_each_choice_that_makes_no_sense_is_named(options: dict, error, message: str) -> None:
    with pytest.raises(error, match=message):
        sa.centers_for(sine(0.5, 1.0), **options)


def learnt(gain: float, inertia_ratio: float | None = None) -> tuple[sa.ComputedTorque, object]:
    """The paper's 625 rules over the path's own sets, and the report on them."""
    path = sa.paper.reference()
    basis = sa.FuzzyBasis("grid", **sa.centers_for(path, "reference", sets=5))
    learning = sa.FuzzyCompensator(basis, gain=gain)
    tracker = sa.ComputedTorque(sa.paper.nominal(), **sa.paper.FEEDBACK, compensator=learning)
    return tracker, sa.design(tracker, path=path, inertia_ratio=inertia_ratio)


def test_the_paper_s_rules_over_the_path_do_what_the_manual_says() -> None:
    """Figures of docs/symptoms.md; "printed" and "claimed" are in test_cli.py."""
    _, report = learnt(1.0, inertia_ratio=0.5)
    assert all("a gain of about 225 removes 90 %" in line for line in report.findings)
    path, plant = sa.paper.reference(), sa.paper.simulation(2).plant
    tracker, report = learnt(225.0)
    assert report.verdict == "go ahead"
    run = sa.simulate(plant, tracker, path, 40.0)
    assert np.array_equal(run.metrics(window=(20, 40)).rms_e.round(4), [0.0052, 0.0062])
    assert round(float(np.abs(run.tau[:, 0]).max()), 1) == 18.1
    frozen = run.tracker
    frozen.freeze()
    q0, dq0, _ = path(0.0)
    again = sa.simulate(plant, frozen, path, 40.0, q0=q0, dq0=dq0).metrics(window=(20, 40))
    assert np.array_equal(again.rms_e.round(4), [0.0044, 0.0049])


def test_with_sensors_and_on_another_motion_they_do_what_the_manual_says() -> None:
    sensors = sa.Effects(encoder_bits=16, velocity="difference", velocity_cutoff=100.0, delay=1)
    path, plant = sa.paper.reference(), sa.paper.simulation(2).plant
    tracker = learnt(225.0)[0].__replace__(hand_over=2.0, velocity_filter=100.0, delay=1)
    options = {"control_period": 1e-3, "effects": sensors}
    run = sa.simulate(plant, tracker, path, 40.0, **options)
    assert round(length(run), 1) == 8.1
    assert round(float(np.abs(run.tau).max()), 1) == 13.6
    frozen = run.tracker
    frozen.freeze()
    q0, dq0, _ = path(0.0)
    assert (
        round(length(sa.simulate(plant, frozen, path, 40.0, q0=q0, dq0=dq0, **options)), 1) == 6.5
    )
    other = sa.Sines([0.7, 2.0], sin=[[0.4, 0.3], [0.1, -0.1]], offset=[-0.1, 0.2])
    q0, dq0, _ = other(0.0)
    moved = sa.simulate(plant, frozen, other, 40.0, q0=q0, dq0=dq0, **options)
    plain = sa.ComputedTorque(
        sa.paper.nominal(), **sa.paper.FEEDBACK, velocity_filter=100.0, delay=1
    )
    without = sa.simulate(plant, plain, other, 40.0, q0=q0, dq0=dq0, **options)
    assert np.array_equal(moved.metrics(window=(20, 40)).rms_e.round(2), [0.19, 0.55])
    assert np.array_equal(without.metrics(window=(20, 40)).rms_e.round(2), [0.18, 0.51])


def length(run: sa.Run) -> float:
    """RMS of |e| from 20 to 40 s [mrad]."""
    return 1e3 * float(np.linalg.norm(run.metrics(window=(20, 40)).rms_e))
