"""The closed loop of a joint for other tools: it is the one that the report's figures are of."""

from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from scipy import signal

ARM = sa.TwoLink(mass=(4.0, 4.0), length=(0.5, 0.5), inertia=(0.2, 0.2))


def compensated(**options: Any) -> sa.ComputedTorque:
    return sa.paper.simulation(3, preset="claimed", **options).tracker


def along_a_path(**given: Any) -> sa.DesignReport:
    """With a plant twice as heavy in another way: an inertia ratio of its own for every joint."""
    tracker = compensated(inputs="reference", leak_rate=0.2, normalization=0.3)
    there = sa.TwoLink(mass=(8, 5), length=(0.5, 0.5), inertia=(0.4, 0.4))
    return sa.design(tracker, path=sa.paper.reference(), plant=sa.Plant(there), **given)


REPORTS = {
    "plain": lambda **given: sa.design(compensated(), **given),
    "twice as heavy": lambda **given: sa.design(compensated(), inertia_ratio=0.5, **given),
    "forgets": lambda **given: sa.design(compensated(leak_rate=0.5), inertia_ratio=0.7, **given),
    "normalised": lambda **given: sa.design(compensated(normalization=2.0), **given),
    "filtered": lambda **given: sa.design(
        compensated(leak_rate=0.5).__replace__(velocity_filter=9.0), inertia_ratio=0.7, **given
    ),
    "computed torque, filtered": lambda **given: sa.design(
        sa.ComputedTorque(ARM, 8.0, 5.5, velocity_filter=2.0), **given
    ),
    "along a path": along_a_path,
    "computed torque": lambda **given: sa.design(
        sa.paper.simulation(2).tracker, inertia_ratio=0.5, **given
    ),
}


@pytest.fixture(params=REPORTS)
def design(request: pytest.FixtureRequest) -> Any:
    return REPORTS[request.param]


def test_the_eigenvalues_are_the_poles_of_the_report(design: Any) -> None:
    report = design()
    for n, poles in enumerate(report.poles):
        model = report.linear_model(n + 1)
        known = np.linalg.eigvals(model.A)
        if report.leak_rate is None:
            # The integrator's, that there is not, is the largest.
            known = np.append(known, 0.0)
        np.testing.assert_allclose(np.sort_complex(known), np.sort_complex(poles), atol=1e-9)
        assert [part.shape for part in model] == [
            (len(model.A), len(model.A)), (len(model.A), 1), (1, len(model.A)), (1, 1)
        ]  # fmt: skip


@pytest.mark.filterwarnings("ignore:Badly conditioned")  # the numerator's leading zeros
@pytest.mark.parametrize("omega", [0.0, 1.0, 3.7, 40.0])
def test_the_predicted_error_is_its_frequency_response(design: Any, omega: float) -> None:
    report = design(disturbance=[(0.8, omega)])
    for n, rms in enumerate(report.rms):
        system = signal.StateSpace(*report.linear_model(n + 1))
        if omega == 0.0 and not report.leak_rate and report.leak_rate is not None:
            # An integrator that forgets nothing leaves no error in the end.
            assert rms == 0.0
            response = signal.freqresp(system, [1e-9])[1]
            assert abs(response[0]) < 1e-6
            continue
        response = signal.freqresp(system, [omega])[1]
        np.testing.assert_allclose(0.8 * abs(response[0]) / np.sqrt(2.0), rms, rtol=1e-9)


def test_the_gain_at_rest_is_that_of_the_feedback_and_the_leak() -> None:
    report = sa.design(compensated(leak_rate=0.5), inertia_ratio=0.5)
    for n in range(2):
        A, B, C, D = report.linear_model(n + 1)
        integral = report.k_i[n] * report.p12[n] / 0.5
        gain = (D - C @ np.linalg.solve(A, B)).item()
        np.testing.assert_allclose(gain, 1.0 / (8.0 + integral), rtol=1e-12)


def test_the_recorded_uncertainty_gives_the_recorded_error() -> None:
    """Of computed torque alone, e follows ρ by this system without any approximation."""
    run = sa.paper.simulation(2, duration=5.0).run()
    report = sa.design(sa.paper.simulation(2).tracker)
    for n in range(2):
        system = signal.StateSpace(*report.linear_model(n + 1))
        start = [run.e[0, n], run.de[0, n]]
        e = signal.lsim(system, run.rho[:, n], run.t, start)[1]
        np.testing.assert_allclose(e, run.e[:, n], atol=1e-6)


def test_joints_have_numbers_and_names() -> None:
    report = sa.design(sa.ComputedTorque(sa.Serial.shipped("panda"), 100, 20))
    for part, same in zip(report.linear_model("panda_joint3"), report.linear_model(3), strict=True):
        assert np.array_equal(part, same)
    with pytest.raises(ValueError, match=r"^joint: got 0, wants 1 to 7, or a name: panda_joint1"):
        report.linear_model(0)


def test_what_is_not_known_is_refused() -> None:
    report = sa.design(compensated(form="shared", inputs="state"))
    with pytest.raises(ValueError, match=r"^joint: the loop of 1 is not known without a path"):
        report.linear_model(1)
