"""The design report, as an object and on the command line."""

import numpy as np
import pytest
import steadyarm as sa
from steadyarm.cli import main


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
    report = sa.design(tracker(form="concat", gain=70.0), period=8e-3)
    assert not report.sound
    assert np.allclose(report.max_period, 6.9e-3, atol=1e-4)
    assert "sample faster than every 6.85" in report.findings[0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"period": 0.0}, "period: got 0, wants a number > 0"),
        ({"delay": 9}, "delay_samples: got 9, wants at most 8"),
        ({"disturbance": ()}, "disturbance: got 0 entries, wants 1"),
        ({"inertia_ratio": -1.0}, "inertia_ratio: got -1, wants a number > 0"),
    ],
)
def test_each_argument_that_makes_no_sense_is_named(options: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sa.design(tracker(), **options)


def test_a_controller_without_compensator_has_nothing_to_report() -> None:
    with pytest.raises(TypeError, match="tracker: got one without a compensator"):
        sa.design(sa.paper.simulation(2).tracker)


def test_command_prints_the_report_and_its_exit_code_is_the_verdict(capsys) -> None:
    assert main(["design", "--preset", "claimed", "--disturbance", "2@1,0.5@3"]) == 0
    assert capsys.readouterr().out.rstrip().endswith("Verdict: go ahead.")
    arguments = ["design", "--form", "concat", "--raw", "--gain", "70", "--period", "0.008"]
    assert main(arguments) == 1
    assert "do not run this" in capsys.readouterr().out


def test_command_refuses_a_disturbance_it_does_not_understand(capsys) -> None:
    assert main(["design", "--disturbance", "2"]) == 2
    assert "wants amplitude@frequency" in capsys.readouterr().err
