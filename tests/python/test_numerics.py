"""The numbers, against SciPy and against formulas written down a second time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import steadyarm as sa
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CENTERS, WIDTH, actual, nominal, run, tracker

KP, KV = 8.0, 5.5
A = np.array([[0.0, 1.0], [-KP, -KV]])
P11, P12, P22 = 12.01352353475379, 0.6515307716504657, 1.147191888366882


def mass_and_bias(arm: sa.TwoLink, q: np.ndarray, dq: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """M and H from the paper's formulas; G and f from the potential and the friction law."""
    (m1, m2), (l1, l2), (i1, i2), g, viscous, coulomb, smoothing = arm.parameters
    t1, t2, t3 = i1 + (m1 / 4 + m2) * l1**2, m2 * l1 * l2 / 2, i2 + m2 * l2**2 / 4
    c2, s2 = np.cos(q[1]), np.sin(q[1])
    mass = np.array([[t1 + t3 + 2 * t2 * c2, t3 + t2 * c2], [t3 + t2 * c2, t3]])
    bias = np.array([-t2 * (2 * dq[0] * dq[1] + dq[1] ** 2) * s2, t2 * dq[0] ** 2 * s2])
    outer = m2 * g * l2 / 2 * np.cos(q[0] + q[1])
    bias += [(m1 / 2 + m2) * g * l1 * np.cos(q[0]) + outer, outer]
    bias += np.array(viscous) * dq + np.array(coulomb) * np.tanh(dq / np.array(smoothing))
    return mass, bias


def reference(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    s, c, s3, c3 = np.sin(t), np.cos(t), np.sin(3 * t), np.cos(3 * t)
    q = np.array([0.5 * c + 0.2 * s3, -0.2 * s - 0.5 * c])
    dq = np.array([-0.5 * s + 0.6 * c3, -0.2 * c + 0.5 * s])
    return q, dq, np.array([-0.5 * c - 1.8 * s3, 0.2 * s + 0.5 * c])


def xi_of(form: str, normalized: bool, x: np.ndarray, centers: Any = CENTERS) -> np.ndarray:
    """ξ by the definition: products of memberships, normalised by their sum."""
    mu = np.exp(-(((x[:, None] - np.array(centers)) / WIDTH) ** 2) / 2)
    if form == "concat":
        return np.concatenate([m / m.sum() if normalized else m for m in mu])
    if form == "per_joint":
        blocks = [np.multiply.outer(mu[n], mu[n + 2]).ravel() for n in range(2)]
        return np.concatenate([b / b.sum() if normalized else b for b in blocks])
    if form == "shared":
        xi = mu.prod(axis=0)
    else:
        xi = mu[0]
        for m in mu[1:]:
            xi = np.multiply.outer(xi, m).ravel()
    return xi / xi.sum() if normalized else xi


class ClosedLoop:
    """(q, dq, W) of simulation 3 as one dense ODE."""

    def __init__(self, form: str, normalized: bool, centers: Any, **law: float) -> None:
        self.form, self.normalized, self.centers = form, normalized, centers
        self.arms = nominal(), actual()
        defaults = {"leak_rate": 0.0, "error_modification": 0.0, "projection_radius": np.inf}
        self.law = defaults | {"dead_zone": 0.0, "normalization": 0.0} | law

    def __call__(self, t: float, y: np.ndarray) -> np.ndarray:
        q, dq, weights = y[:2], y[2:4], y[4:].reshape(2, -1)
        q_d, dq_d, ddq_d = reference(t)
        e, de = q - q_d, dq - dq_d
        xi = xi_of(self.form, self.normalized, np.concatenate([e, de]), self.centers)
        s = P12 * e + P22 * de
        (m0, h0), (m, h) = (mass_and_bias(arm, q, dq) for arm in self.arms)
        tau = m0 @ (ddq_d - KV * de - KP * e - weights @ xi) + h0
        ddq = np.linalg.solve(m, tau - [np.sin(t), np.cos(t)] - h)
        return np.concatenate([dq, ddq, self.adapt(weights, s, xi).ravel()])

    def adapt(self, weights: np.ndarray, s: np.ndarray, xi: np.ndarray) -> np.ndarray:
        law, size = self.law, np.linalg.norm(s)
        factor = max(0.0, 1 - law["dead_zone"] / size) if law["dead_zone"] else 1.0
        factor /= 1 + law["normalization"] * (xi @ xi)
        drive = factor * law["gain"] * np.outer(s, xi)
        rate = drive - law["leak_rate"] * weights
        rate -= law["gain"] * law["error_modification"] * size * weights
        growth, norm = np.sum(drive * weights), np.sum(weights**2)
        outer = law["projection_radius"] ** 2
        depth = (norm - 0.81 * outer) / (0.19 * outer) if np.isfinite(outer) else 0.0
        if depth > 0 and growth > 0:
            rate -= depth * growth / norm * weights
        return rate

    def solve(self, t: np.ndarray, rules: int) -> scipy.integrate.OdeSolution:
        options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13, "t_eval": t, "max_step": 0.02}
        return scipy.integrate.solve_ivp(self, (0, t[-1]), np.zeros(4 + 2 * rules), **options)


LAWS = {
    "plain": {},
    "leak": {"leak_rate": 0.7},
    "e-modification": {"error_modification": 0.2},
    "projection": {"projection_radius": 1.5},
    "dead zone": {"dead_zone": 0.05},
    "normalisation": {"normalization": 0.5},
    "everything": {
        "leak_rate": 0.3,
        "error_modification": 0.1,
        "projection_radius": 2.0,
        "dead_zone": 0.02,
        "normalization": 0.2,
    },
}
BASES = {"concat": ("concat", False, CENTERS), "grid": ("grid", True, (-0.5, 0.0, 0.5))}
KINKED = {"projection", "dead zone", "everything"}
"""Laws with a corner in their right-hand side, which costs every integrator its order there."""


@pytest.mark.parametrize("method", ["rk4", "dp54"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("shape", BASES)
def test_closed_loop_agrees_with_scipy(shape: str, law: str, method: str) -> None:
    form, normalized, centers = BASES[shape]
    gain = 20.0 if shape == "concat" else 400.0
    loop = ClosedLoop(form, normalized, centers, gain=gain, **LAWS[law])
    basis = sa.FuzzyBasis(form, centers, WIDTH, normalized)
    compensator = sa.FuzzyCompensator(basis, q=10, gain=gain, **LAWS[law])
    controller = sa.ComputedTorque(nominal(), KP, KV, compensator)
    options = {"method": method, "duration": 5.0, "rtol": 1e-11, "atol": 1e-13}
    found = run(controller, **options)
    assert found.weights is not None
    exact = loop.solve(found.t[::100], found.weights.shape[1])
    tolerance = 2e-6 if law in KINKED else 2e-9
    np.testing.assert_allclose(found.q[::100].T, exact.y[:2], atol=tolerance)
    np.testing.assert_allclose(found.dq[::100].T, exact.y[2:4], atol=10 * tolerance)
    weights = exact.y[4:, -1].reshape(2, -1)
    assert np.linalg.norm(weights) > 0.3
    scale = abs(weights).max()
    np.testing.assert_allclose(found.weights, weights, atol=10 * tolerance * max(1.0, scale))
    norms = np.linalg.norm(exact.y[4:], axis=0)
    np.testing.assert_allclose(found.weights_norm[::100], norms, atol=10 * tolerance * scale)


@pytest.mark.parametrize("law", LAWS)
def test_modification_changes_the_run(law: str) -> None:
    plain = run(tracker("concat", False, gain=20.0), duration=2.0)
    other = run(tracker("concat", False, gain=20.0, **LAWS[law]), duration=2.0)
    assert np.array_equal(plain.q, other.q) == (law == "plain")


numbers = st.floats(-10, 10)
sizes = st.floats(0.05, 20)
pairs = st.tuples(sizes, sizes)


@settings(deadline=None)
@given(pairs, pairs, pairs, numbers, st.lists(numbers, min_size=6, max_size=6))
def test_two_link_dynamics_agree_with_their_formulas(
    mass: Any, length: Any, inertia: Any, gravity: float, state: list[float]
) -> None:
    q, dq, ddq = np.array(state).reshape(3, 2)
    arm = sa.TwoLink(mass, length, inertia, gravity, (0.3, 0.1), (0.2, 0.5), 0.1)
    expected_mass, expected_bias = mass_and_bias(arm, q, dq)
    scale = abs(expected_mass).max() * (1 + abs(dq).max() ** 2) + 1e3 * abs(gravity)
    np.testing.assert_allclose(arm.mass_matrix(q), expected_mass, rtol=1e-12, atol=1e-13 * scale)
    np.testing.assert_allclose(arm.bias(q, dq), expected_bias, rtol=1e-11, atol=1e-12 * scale)
    coriolis = arm.coriolis(q, dq) @ dq + arm.gravity(q) + arm.friction(dq)
    np.testing.assert_allclose(coriolis, expected_bias, rtol=1e-11, atol=1e-12 * scale)
    inverse = arm.inverse_dynamics(q, dq, ddq)
    np.testing.assert_allclose(
        inverse, expected_mass @ ddq + expected_bias, rtol=1e-11, atol=1e-12 * scale
    )
    back = arm.forward_dynamics(q, dq, inverse)
    condition = np.linalg.cond(expected_mass)
    np.testing.assert_allclose(back, ddq, rtol=1e-10, atol=1e-13 * condition * (scale + 10))
    np.testing.assert_allclose(
        arm.kinetic_energy(q, dq), dq @ expected_mass @ dq / 2, rtol=1e-11, atol=1e-13 * scale
    )


@settings(deadline=None)
@given(
    st.sampled_from(["grid", "shared", "concat", "per_joint"]),
    st.booleans(),
    st.lists(st.floats(-4, 4), min_size=4, max_size=4),
)
def test_basis_agrees_with_its_definition(form: str, normalized: bool, x: list[float]) -> None:
    basis = sa.FuzzyBasis(form, CENTERS, WIDTH, normalized)
    expected = xi_of(form, normalized, np.array(x))
    assert basis.rules == expected.size
    # Memberships below 1e-22 count as zero: no step sees a subnormal number.
    np.testing.assert_allclose(basis.evaluate([x])[0], expected, rtol=1e-11, atol=1e-22)


@pytest.mark.parametrize(
    ("form", "normalized", "raw"),
    [
        ("shared", 0.42163, 1.27067),
        ("concat", 1.16663, 8.94112),
        ("grid", 0.0072360, 24.9647),
        ("per_joint", 0.17013, None),
    ],
)
def test_strength_of_the_integrator_at_zero_error(form: str, normalized: float, raw: Any) -> None:
    for flag, expected in ((True, normalized), (False, raw)):
        xi = sa.FuzzyBasis(form, CENTERS, WIDTH, flag).evaluate(np.zeros((1, 4)))
        if expected is not None:
            assert np.sum(xi**2) == pytest.approx(expected, rel=1e-4)


def test_fitted_approximator_solves_the_ridge_regression() -> None:
    random = np.random.default_rng(3)
    x, y = random.uniform(-2, 2, (200, 4)), random.normal(size=(200, 3))
    basis = sa.FuzzyBasis("per_joint", CENTERS, WIDTH)
    fitted = sa.FuzzyApproximator.fit(basis, x, y, ridge=1e-3)
    xi = basis.evaluate(x)
    expected = np.linalg.solve(xi.T @ xi + 0.2 * np.eye(xi.shape[1]), xi.T @ y).T
    np.testing.assert_allclose(fitted.weights, expected, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(fitted(x), xi @ fitted.weights.T, rtol=1e-12, atol=1e-13)


def residual(equation: np.ndarray, p: np.ndarray, a: np.ndarray) -> float:
    return float(np.linalg.norm(equation) / (np.linalg.norm(p) * np.linalg.norm(a) + 1e-300))


@pytest.mark.parametrize("seed", range(40))
def test_care_agrees_with_scipy(seed: int) -> None:
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 9))
    m = int(random.integers(1, n + 1))
    a, b = random.normal(size=(n, n)), random.normal(size=(n, m))
    c = random.normal(size=(n, n))
    q, r = c @ c.T + 0.1 * np.eye(n), np.diag(random.uniform(0.5, 2, m))
    expected = scipy.linalg.solve_continuous_are(a, b, q, r)
    found = sa.care(a, b, q, r)
    np.testing.assert_allclose(found.P, expected, rtol=1e-6, atol=1e-7 * abs(expected).max())
    assert np.array_equal(found.P, found.P.T)
    closed = a - b @ np.linalg.solve(r, b.T @ found.P)
    assert found.max_real == pytest.approx(np.linalg.eigvals(closed).real.max(), rel=1e-5)
    assert found.min_eigenvalue == pytest.approx(np.linalg.eigvalsh(found.P).min(), rel=1e-6)


@pytest.mark.parametrize("seed", range(40))
def test_bounded_real_riccati_agrees_with_scipy_where_scipy_solves_it(seed: int) -> None:
    random = np.random.default_rng(100 + seed)
    n = int(random.integers(1, 9))
    m = int(random.integers(1, n + 1))
    a = random.normal(size=(n, n))
    a -= (np.linalg.eigvals(a).real.max() + random.uniform(0.3, 2)) * np.eye(n)
    b, c = random.normal(size=(n, m)), random.normal(size=(n, n))
    q = c @ c.T
    gamma = 1.2 * sa.bounded_real_riccati(a, b, q, gamma=1e6).gamma_opt
    found = sa.bounded_real_riccati(a, b, q, gamma)
    p = found.P
    equation = a.T @ p + p @ a + p @ b @ b.T @ p / gamma**2 + q
    assert residual(equation, p, a) < 1e-10
    assert np.linalg.eigvals(a + b @ b.T @ p / gamma**2).real.max() < 0
    with pytest.raises(sa.NoStabilizingSolution):
        sa.bounded_real_riccati(a, b, q, found.gamma_opt * (1 - 1e-6))
    try:
        other = scipy.linalg.solve_continuous_are(a, b, q, -(gamma**2) * np.eye(m))
    except np.linalg.LinAlgError:
        return
    check = a.T @ other + other @ a + other @ b @ b.T @ other / gamma**2 + q
    if residual(check, other, a) < 1e-10:
        np.testing.assert_allclose(p, other, rtol=1e-6, atol=1e-7 * abs(p).max())


def test_golden_solution_of_the_papers_equation() -> None:
    big = np.kron(A, np.eye(2))
    b = np.vstack([np.zeros((2, 2)), np.eye(2)])
    solution = sa.bounded_real_riccati(big, b, 10 * np.eye(4))
    expected = np.kron([[P11, P12], [P12, P22]], np.eye(2))
    np.testing.assert_allclose(solution.P, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(tracker().P, expected, rtol=1e-14)
    assert solution.max_real == pytest.approx(-2.1764040558, rel=1e-9)
    assert solution.gamma_opt == pytest.approx(0.6143205381, rel=1e-9)
    assert 10 * solution.max_scale == pytest.approx(26.4978068488, rel=1e-9)


@pytest.mark.parametrize(
    ("number", "overrides", "rms", "most"),
    [
        (2, {}, (0.193026, 0.447902), 15.350),
        (3, {"preset": "printed"}, (0.192160, 0.443569), 15.350),
        (3, {"form": "shared", "gain": 70, "normalized": False}, (0.021925, 0.040805), 23.860),
        (3, {"form": "concat", "gain": 7, "normalized": False}, (0.030918, 0.057160), 23.923),
        (3, {"preset": "claimed"}, (0.010938, 0.021588), 25.302),
        (3, {"form": "grid", "gain": 7, "inputs": "state"}, (0.184484, 0.427863), 15.350),
    ],
)
def test_golden_errors_of_the_papers_simulations(
    number: int, overrides: Any, rms: tuple[float, float], most: float
) -> None:
    run = sa.paper.simulation(number, **overrides).run()
    figures = run.metrics(window=(20, 40))
    np.testing.assert_allclose(figures.rms_e, rms, atol=1e-5)
    assert run.metrics().max_abs_tau[0] == pytest.approx(most, abs=2e-3)
    if run.certificate is not None:
        assert run.certificate.residual < 1e-10


def test_simulation_1_settles_as_computed() -> None:
    run = sa.paper.simulation(1).run()
    assert (run.metrics(window=(20, 40)).rms_e < 1e-9).all()
    size = np.linalg.norm(run.e, axis=1)
    for band, expected in ((0.01, 2.168), (0.001, 2.946)):
        settled = run.t[np.flatnonzero(size > band)[-1] + 1]
        assert settled == pytest.approx(expected, abs=1.5e-3)
    assert run.metrics(band=0.01).settling_time.max() == pytest.approx(2.078, abs=1.5e-3)


def test_metrics_agree_with_their_definitions() -> None:
    record = run(tracker(), duration=3.0)
    inside = (record.t >= 1) & (record.t <= 2)
    t, e, tau = record.t[inside] - 1, record.e[inside], record.tau[inside]
    figures = record.metrics(window=(1, 2), band=0.3)
    np.testing.assert_allclose(figures.rms_e, np.sqrt(np.mean(e**2, axis=0)), rtol=1e-12)
    np.testing.assert_allclose(figures.rms_tau, np.sqrt(np.mean(tau**2, axis=0)), rtol=1e-12)
    assert np.array_equal(figures.max_abs_e, abs(e).max(axis=0))
    assert np.array_equal(figures.max_abs_tau, abs(tau).max(axis=0))
    itae = np.trapezoid(t[:, None] * abs(e), t, axis=0)
    np.testing.assert_allclose(figures.itae, itae, rtol=1e-12)
    variation = abs(np.diff(tau, axis=0)).sum(axis=0) / (t[-1] - t[0])
    np.testing.assert_allclose(figures.torque_variation, variation, rtol=1e-9)


def test_references_agree_with_their_formulas() -> None:
    for t in (0.0, 0.7, 12.3):
        for found, expected in zip(sa.paper.reference()(t), reference(t), strict=True):
            np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-15)
    move = sa.Quintic((0, 1), (2, -1), duration=2.0, start_time=1.0)
    assert np.array_equal(move(0.5)[0], [0, 1])
    np.testing.assert_allclose(move(2.0)[0], [1, 0], atol=1e-15)
    np.testing.assert_allclose(move(2.0)[1], np.array([2, -2]) / 2 * 1.875, rtol=1e-14)
    assert np.array_equal(move(9.0)[0], [2, -1])
    grid = np.linspace(0, 5, 501)
    columns = [np.array(x) for x in zip(*map(reference, grid), strict=True)]
    for table, tolerance in ((sa.Table(grid, *columns), 1e-8), (sa.Table(grid, columns[0]), 1e-3)):
        for t in (0.001, 1.2345, 4.999):
            for found, expected in zip(table(t), reference(t), strict=True):
                np.testing.assert_allclose(found, expected, atol=tolerance)
