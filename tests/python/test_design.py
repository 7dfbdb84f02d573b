"""The design report, as an object and on the command line."""

import numpy as np
import pytest
import steadyarm as sa
from steadyarm.cli import main

ARM = sa.TwoLink(mass=(4.0, 4.0), length=(0.5, 0.5), inertia=(0.2, 0.2))


def tracker(**overrides: object) -> sa.ComputedTorque:
    return sa.paper.simulation(3, preset="claimed", **overrides).tracker


def test_the_printed_compensator_is_reported_inert_with_a_gain_that_helps() -> None:
    report = sa.design(sa.paper.simulation(3, preset="printed").tracker)
    assert report.sound
    assert "the compensator is inert" in report.findings[0]
    assert "a gain of about" in report.findings[0]
    assert "go ahead, but know that" in str(report)


def test_figures_are_those_of_the_equation() -> None:
    report = sa.design(tracker())
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-8 * np.eye(2), -5.5 * np.eye(2)]])
    B = np.vstack([np.zeros((2, 2)), np.eye(2)])
    solution = sa.bounded_real_riccati(A, B, 10 * np.eye(4))
    assert np.allclose(report.gamma_opt, solution.gamma_opt, rtol=1e-9)
    assert np.allclose(report.max_scale, solution.max_scale, rtol=1e-9)
    assert np.allclose(report.max_real, solution.max_real, rtol=1e-9)
    assert np.allclose(
        [report.p11[0], report.p12[0], report.p22[0]], solution.P[[0, 0, 2], [0, 2, 2]]
    )
    assert report.poles.shape == (2, 3)
    assert not report.findings
    assert str(report).endswith("Verdict: go ahead.")


def test_a_loop_that_is_too_slow_is_refused() -> None:
    report = sa.design(tracker(form="concat", gain=70.0), control_period=8e-3)
    assert not report.sound
    assert np.allclose(report.max_period, 6.9e-3, atol=1e-4)
    # A third of 6.85 ms, which the linear model of one joint has.
    assert any("sample every 2.2838 ms" in f and "6.8515 ms" in f for f in report.findings)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"control_period": 0.0}, "control_period: got 0, wants a number > 0"),
        ({"delay": 9}, "^delay: got 9, wants at most 8"),
        ({"disturbance": ()}, "disturbance: got 0 entries, wants 1"),
        ({"inertia_ratio": -1.0}, "inertia_ratio: got -1, wants a number > 0"),
    ],
)
def test_each_argument_that_makes_no_sense_is_named(options: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sa.design(tracker(), **options)


def test_computed_torque_alone_is_reported_on() -> None:
    scene = sa.paper.simulation(2)
    report = sa.design(scene.tracker, 0.1)
    # h kv = 2 is the limit of a double integrator, and e = ρ / |kp - ω² + kv jω|.
    assert np.allclose(report.max_period, 2 / 5.5, rtol=1e-9)
    assert np.allclose(report.rms_without, report.rms)
    assert np.allclose(report.rms, 1 / np.hypot(7.0, 5.5) / np.sqrt(2))
    assert np.isnan(report.p11).all() and np.isnan(report.gamma_opt).all()
    assert report.sound and "go ahead" in str(report) and "nan" not in str(report)
    assert not sa.design(scene.tracker, 0.3).sound
    assert "Verdict: do not run this" in str(sa.design(scene.tracker, 0.4))


def weightless(joints: int = 2) -> sa.Serial:
    """A chain whose first joint turns about a vertical axis: it looks the same from all sides."""
    n = np.arange(1, joints + 1)
    return sa.Serial.from_dh(
        a=0.4, alpha=0.0, d=0.0, kind=["revolute"] * joints, mass=3.0 / n,
        com=np.tile([-0.2, 0.0, 0.0], (joints, 1)),
        inertia=np.tile([0.01, 0.04, 0.04], (joints, 1)),
    )  # fmt: skip


@pytest.mark.parametrize("inputs", ["reference", "state", "trajectory"])
@pytest.mark.parametrize("normalized", [True, False])
@pytest.mark.parametrize("dictionary", [None, 200])
def test_a_problem_that_is_moved_as_a_whole_has_the_same_report(
    inputs: str, normalized: bool, dictionary: int | None
) -> None:
    reports = []
    for moved in (0.0, 1.5, -3.0):
        path = sa.Sines(
            [1.0, 3.0], [[0.3, 0.2], [0.1, 0.2]], [[0.0, 0.3], [0.2, 0.0]], [moved, 0.4]
        )
        signals = 3 if inputs == "trajectory" else 2
        first = [[moved - 0.5, moved, moved + 0.5], [-0.1, 0.4, 0.9]]
        centers = first + [[-1.0, 0.0, 1.0]] * 2 * (signals - 1)
        basis = sa.FuzzyBasis("grid", centers, 0.6, normalized, inputs)
        fuzzy = sa.FuzzyCompensator(basis, gain=100.0, dictionary=dictionary)
        arm = weightless()
        tracker = sa.ComputedTorque(arm, 30.0, 11.0, fuzzy)
        plant = sa.Plant(arm.perturb(1, mass=0.3), sa.Sines(1.0, [1.0, 0.5]))
        reports.append(sa.design(tracker, 2e-3, path=path, plant=plant))
    same, figures = reports[0], ("k_i", "rms", "sampled_radius", "max_period", "stiffness")
    for other in reports[1:]:
        for name in (*figures, "survives", "poles", "rms_without"):
            assert np.allclose(getattr(other, name), getattr(same, name), rtol=1e-6), name
        assert other.findings == same.findings and other.verdict == same.verdict
        assert other.directions == same.directions
        assert other.rules_excited == same.rules_excited
    # At the origin none of this would be seen: it is 1.5 and 3 rad away.
    assert (same.k_i > 1e-3).all()


@pytest.mark.parametrize("inputs", ["reference", "state", "trajectory", ["e", "q_d"]])
def test_without_a_path_it_says_what_it_cannot_know(inputs: object) -> None:
    report = sa.design(tracker(form="shared", inputs=inputs))
    assert not report.known and not report.sound
    assert report.verdict == "cannot tell without a path"
    for unknown in (report.k_i, report.rms, report.sampled_radius, report.max_period):
        assert np.isnan(unknown).all()
    assert any("give path=" in finding for finding in report.findings)
    assert "nan" not in str(report)
    reference = sa.paper.reference()
    known = sa.design(tracker(form="shared", inputs=inputs), path=reference)
    assert known.known and np.isfinite(known.max_period).all()


def test_a_path_may_be_any_reference() -> None:
    sines = sa.Sines(1.0, [0.3, 0.4], [0.1, 0.2])
    t = np.linspace(0.0, 2 * np.pi, 500)
    q, dq, ddq = (np.array(rows) for rows in zip(*(sines(time) for time in t), strict=True))
    chosen = tracker(form="shared", inputs="state", gain=70.0)
    wanted = sa.design(chosen, path=sines)
    for path in (sa.Table(t, q, dq, ddq), (t, q, dq, ddq), lambda time: sines(time)):
        given = {"duration": 2 * np.pi} if callable(path) and not isinstance(path, sa.Table) else {}
        report = sa.design(chosen, path=path, **given)
        assert np.allclose(report.max_period, wanted.max_period, rtol=1e-2)
        assert np.allclose(report.k_i, wanted.k_i, rtol=1e-3)
    for positions in (q, q.tolist()):
        report = sa.design(chosen, path=positions, duration=2 * np.pi)
        assert np.allclose(report.max_period, wanted.max_period, rtol=1e-2)
    with pytest.raises(ValueError, match="duration: got None"):
        sa.design(chosen, path=q)
    quintic = sa.Quintic([0.0, 0.0], [1.0, 0.5], 2.0)
    assert sa.design(chosen, path=quintic).known


def test_what_is_wrong_with_path_and_plant_is_named() -> None:
    chosen, plant = tracker(), sa.Plant(sa.paper.actual())
    path = sa.paper.reference()
    with pytest.raises(ValueError, match="path: got None"):
        sa.design(chosen, plant=plant)
    with pytest.raises(ValueError, match="duration: got None"):
        sa.design(chosen, path=lambda t: path(t))
    with pytest.raises(ValueError, match=r"inertia_ratio: got 0\.5"):
        sa.design(chosen, path=path, plant=plant, inertia_ratio=0.5)
    with pytest.raises(ValueError, match="duration: got 0"):
        sa.design(chosen, path=path, duration=0.0)
    with pytest.raises(ValueError, match="path: got one of 3 joints, wants one of 2"):
        sa.design(chosen, path=sa.Quintic([0.0] * 3, [1.0] * 3, 1.0))
    with pytest.raises(ValueError, match="plant: got one of 3 joints, wants one of 2"):
        sa.design(chosen, path=path, plant=sa.Plant(weightless(3)))
    with pytest.raises(TypeError, match="plant: got int"):
        sa.design(chosen, path=path, plant=3)  # type: ignore[arg-type]
    with pytest.raises(ZeroDivisionError):
        sa.design(chosen, path=lambda t: 1 / 0, duration=1.0)


@pytest.mark.parametrize(
    ("form", "gain", "modified"),
    [
        ("grid", 7.0, {}),
        ("concat", 7.0, {}),
        ("concat", 70.0, {}),
        ("concat", 70.0, {"leak_rate": 0.5}),
        ("concat", 70.0, {"leak_rate": 5.0}),
        ("concat", 700.0, {"normalization": 1.0}),
        ("concat", 700.0, {"normalization": 0.3, "leak_rate": 2.0}),
    ],
)
def test_predicted_error_along_the_path_is_that_of_the_run(
    form: str, gain: float, modified: dict
) -> None:
    scene = sa.paper.simulation(3, "claimed", form=form, gain=gain, **modified)
    report = sa.design(scene.tracker, path=scene.reference, plant=scene.plant)
    simulated = scene.run().metrics(window=(20, 40)).rms_e
    # Errors of a few hundredths, where the rules are linear. Without leak and normalisation in the
    # model the prediction would be up to 10 times too small.
    assert np.allclose(report.rms, simulated, rtol=0.1), (report.rms, simulated)


@pytest.mark.parametrize(("inputs", "learns"), [("error", False), ("trajectory", True)])
def test_only_rules_that_see_the_motion_learn_and_a_freeze_shows_it(
    inputs: str, learns: bool
) -> None:
    scene = sa.paper.simulation(
        3, "claimed", form="concat", inputs=inputs, gain=7.0, centers=[-2.0, -1.0, 0.0, 1.0, 2.0]
    )
    report = sa.design(scene.tracker, path=scene.reference, plant=scene.plant)
    assert report.survives is not None and report.directions is not None
    # What rules of the error gather in a longer time is a stiffness, which is no memory either.
    learnt = scene.run(duration=1000.0 if learns else 40.0, dt=2e-3, record_every=500).tracker
    learnt.freeze()
    frozen = sa.simulate(scene.plant, learnt, scene.reference, 40.0)
    late = frozen.t > 20.0
    left = ((frozen.rho - frozen.rho_hat)[late] ** 2).mean(axis=0)
    kept = 1.0 - np.sqrt(left / (frozen.rho[late] ** 2).mean(axis=0))
    if learns:  # measured: 0.947 and 0.962, after 1000 s
        assert (report.survives > kept).all() and (kept > 0.9).all(), (report.survives, kept)
        assert min(report.directions) > 5
    else:
        assert (report.survives < 0.05).all() and (kept < 0.3).all(), (report.survives, kept)
        assert report.directions == (1, 1)


def test_stiffness_and_damping_are_the_gains_times_the_inertia() -> None:
    arm = sa.Serial.shipped("panda")
    tracker = sa.ComputedTorque(arm, 400.0, 40.0)
    q = np.array([0.0, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8])
    held = sa.design(tracker, path=sa.Quintic(q, q, 1.0))
    assert np.allclose(held.stiffness, 400.0 * np.diag(arm.mass_matrix(q)), rtol=1e-12)
    assert np.allclose(held.damping, 40.0 * np.diag(arm.mass_matrix(q)), rtol=1e-12)
    anywhere = sa.design(tracker)
    assert (anywhere.stiffness <= held.stiffness * 1.2).all() and (anywhere.stiffness > 0).all()


def test_command_prints_the_report_and_its_exit_code_is_the_verdict(capsys) -> None:
    assert main(["design", "--preset", "claimed", "--disturbance", "2@1,0.5@3"]) == 0
    assert capsys.readouterr().out.rstrip().endswith("Verdict: go ahead.")
    arguments = ["design", "--form", "concat", "--raw", "--gain", "70", "--control-period", "0.008"]
    assert main(arguments) == 1
    assert "do not run this" in capsys.readouterr().out


def test_command_refuses_a_disturbance_it_does_not_understand(capsys) -> None:
    assert main(["design", "--disturbance", "2"]) == 2
    assert "wants amplitude@frequency" in capsys.readouterr().err


def test_a_compensator_that_learns_slowly_is_told_from_an_inert_one() -> None:
    """It is inert as an integrator, and has learnt in about the time that the report says."""
    scene = sa.paper.simulation(
        3, "claimed", form="concat", inputs="trajectory", gain=0.1, centers=np.arange(-2.0, 3.0)
    )
    report = sa.design(scene.tracker, path=scene.reference, plant=scene.plant)
    slow = [f for f in report.findings if "learns slowly" in f]
    assert len(slow) == 2 and "inert" not in " ".join(report.findings)
    time = float(slow[0].split("takes it some ")[1].split(" s")[0])
    run = scene.run(duration=round(3 * time), dt=4e-3, record_every=25)
    at_first = run.metrics((7.0, 14.0)).rms_e
    early = run.metrics((0.2 * time, 0.2 * time + 7.0)).rms_e
    later = run.metrics((3 * time - 7.0, 3 * time)).rms_e
    # One time is about an e-folding: exp(-0.2) = 0.82, exp(-3) = 0.05.
    assert (early > 0.6 * at_first).all() and (later < 0.35 * at_first).all(), (at_first, later)
    # The same gain on rules of the error is inert for good.
    scene = sa.paper.simulation(3, "claimed", form="concat", gain=0.1)
    findings = sa.design(scene.tracker, path=scene.reference, plant=scene.plant).findings
    assert any("inert" in f for f in findings) and "learns" not in " ".join(findings)


def test_what_a_linear_model_cannot_tell_is_said_to_be_so() -> None:
    """A rod that stands, twice as heavy as believed: kp M₀ must hold ΔK = ½ m g l, the gravity that
    the model lacks, so kp > 37.4 1/s²; and near that the error is wide."""
    rod = sa.Serial.from_dh(
        a=[0.4], alpha=[0.0], d=[0.0], mass=[4.0], com=[[-0.2, 0.0, 0.0]],
        inertia=[[0.01, 0.05, 0.05]], gravity=[0.0, -9.81, 0.0],
    )  # fmt: skip
    light = rod.with_parameters(0.5 * rod.inertial_parameters())
    edge = 0.5 * 4.0 * 9.81 * 0.2 / (0.5 * 0.21)
    path, plant = sa.Sines(1.0, 0.1, 0.0, np.pi / 2 + 0.2), sa.Plant(rod)
    for times, words in (
        (0.8, "grows at any control period"),
        (1.1, "predicted error of"),
        (9, ""),
    ):
        kp = times * edge
        for period in (1e-4, 1e-3, 1e-2):
            tracker = sa.ComputedTorque(light, kp, 2.0 * np.sqrt(kp))
            report = sa.design(tracker, period, path=path, plant=plant)
            known = not words
            assert report.known == report.sound == known, report.findings
            assert report.verdict == ("go ahead" if known else "cannot tell from a linear model")
            assert known or words in " ".join(report.findings)
            assert (report.max_period > 0.0).all() == (times > 1.0)
            assert "too slow" not in str(report) and "-inf" not in str(report)


def test_a_path_on_which_the_arm_cannot_be_carried_is_refused() -> None:
    arm = sa.TwoLink(4, 0.5, 0.2, gravity=9.81)
    path = sa.Sines(1.0, sin=0.5)
    weak = sa.design(sa.ComputedTorque(arm, 100, 20, effort_limit=5.0), 1e-3, path=path)
    assert not weak.sound and weak.verdict == "do not run this"
    strong = sa.design(sa.ComputedTorque(arm, 100, 20, effort_limit=200.0), 1e-3, path=path)
    assert strong.sound and strong.verdict == "go ahead"
    with pytest.raises(ValueError, match=r"^delay: got 9"):
        sa.design(sa.ComputedTorque(arm, 100, 20), 1e-3, delay=9)


def late(**front: float) -> sa.ComputedTorque:
    """Critically damped at 20 rad/s, on one joint after another."""
    return sa.ComputedTorque(ARM, 400.0, 40.0, **front)


def test_a_loop_whose_velocity_filter_is_too_slow_is_refused_and_diverges() -> None:
    """At 1 Hz the velocity of a loop of 20 rad/s is too late for 4 ms and a delay of 1."""
    path, effects = sa.Sines(1.0, [0.2, 0.2]), sa.Effects(delay=1)
    for cut_off, sound in ((100.0, True), (1.0, False)):
        tracker = late(delay=1, velocity_filter=cut_off)
        report = sa.design(tracker, 4e-3, path=path, plant=sa.Plant(ARM))
        assert report.sound == sound, report.findings
        assert sa.design(tracker, 4e-3).sound == sound
        words = f"velocity_filter: {cut_off:g} Hz is slow for joint 1"
        assert any(finding.startswith(words) for finding in report.findings) == (not sound)
        loop = {"control_period": 4e-3, "effects": effects, "q0": [0.01, 0.0], "progress": False}
        run = sa.simulate(sa.Plant(ARM), tracker, path, 8.0, 1e-3, **loop)
        assert (not run.status.finished or abs(run.e[-1000:]).max() > 0.1) != sound


def test_the_delay_that_the_tracker_knows_of_counts_where_none_is_given() -> None:
    for given in (None, 0, 3):
        report = sa.design(late(delay=2), delay=given)
        known = 2 if given is None else given
        assert report.delay == known
        assert (report.max_period == sa.design(late(), delay=known).max_period).all()


def test_velocities_by_difference_count_as_a_filter_does() -> None:
    machine = sa.Effects(velocity="difference", velocity_cutoff=8.0, delay=1)
    sensed, own = sa.design(late(), effects=machine), sa.design(late(velocity_filter=8.0), delay=1)
    for name in ("poles", "sampled_radius", "max_period", "rms"):
        assert (getattr(sensed, name) == getattr(own, name)).all()
    assert sensed.velocity_filter == own.velocity_filter == 8.0 and sensed.delay == 1
    assert any("velocity lags behind dq_d" in words for words in sensed.left_out)
    # A filter of its own takes positions, whatever velocities are made of.
    both = sa.design(late(velocity_filter=8.0), effects=machine.__replace__(velocity_cutoff=2.0))
    assert (both.poles == own.poles).all() and len(both.left_out) == 1
    sharp = sa.design(late(), effects=machine.__replace__(velocity_cutoff=float("inf")))
    assert np.isfinite(sharp.max_period).all() and np.isfinite(sharp.poles).all()
    lagging = sa.design(late(), effects=sa.Effects(velocity="kalman", encoder_bits=16))
    assert lagging.velocity_filter is None and "what velocities by kalman lag" in lagging.left_out
    with pytest.raises(TypeError, match="effects: got int, wants an Effects"):
        sa.design(late(), effects=1)  # type: ignore[arg-type]


@pytest.mark.parametrize("cut_off", [300.0, 500.0, 1000.0, 2000.0])
def test_what_a_fast_filter_forgets_in_a_lap_leaves_the_radius_known(cut_off: float) -> None:
    arm = sa.Serial.shipped("panda")
    centre = [0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7]
    path = sa.Sines([1.0, 1.7], sin=np.full((2, 7), 0.1), offset=centre)
    for p in (10.0, 20.0, 30.0):
        tracker = sa.ComputedTorque(arm, p**2, 2 * p, velocity_filter=cut_off)
        report, without = sa.design(tracker, path=path), sa.design(tracker)
        assert report.sound and report.max_period == pytest.approx(without.max_period, rel=0.05)
