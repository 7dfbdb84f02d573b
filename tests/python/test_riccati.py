"""The Riccati equations: published examples, solutions by construction, SciPy, what has none."""

from __future__ import annotations

import re

import numpy as np
import pytest
import scipy.linalg
import steadyarm as sa
from carex import CAREX

Array = np.ndarray
RESIDUAL = 1e-12


def is_certified(p: Array, a: Array, g: Array, q: Array) -> None:
    """Substitute P into A'P + PA - PGP + Q = 0, and look at the closed loop A - GP."""
    assert np.array_equal(p, p.T)
    left = a.T @ p + p @ a - p @ g @ p + q
    # Singular values of large matrices take long.
    order = 2 if len(p) <= 100 else "fro"
    left_size, a_size, g_size, p_size, q_size = (
        np.linalg.norm(m, order) for m in (left, a, g, p, q)
    )
    assert left_size <= RESIDUAL * (2 * a_size * p_size + g_size * p_size**2 + q_size)
    assert np.linalg.eigvals(a - g @ p).real.max() < 0


def input_term(b: Array, r: Array) -> Array:
    return b @ np.linalg.solve(r, b.T)


def care(a: Array, b: Array, q: Array, r: Array) -> Array:
    solution = sa.care(a, b, q, r)
    assert solution.residual <= RESIDUAL
    assert solution.max_real < 0
    is_certified(solution.P, a, input_term(b, r), q)
    return solution.P


def hurwitz(random: np.random.Generator, n: int) -> Array:
    a = random.normal(size=(n, n))
    return a - (np.linalg.eigvals(a).real.max() + random.uniform(0.2, 2)) * np.eye(n)


def symmetric(random: np.random.Generator, n: int) -> Array:
    half = random.normal(size=(n, n))
    return half + half.T


def weight(random: np.random.Generator, m: int, decades: float = 1.0) -> Array:
    """R > 0 with entries over so many decades."""
    half = random.normal(size=(m, m)) + 2 * np.eye(m)
    scale = np.diag(10 ** random.uniform(-decades / 2, decades / 2, size=m))
    r = scale @ (half.T @ half) @ scale
    return (r + r.T) / 2


@pytest.mark.parametrize("number", range(1, 21))
def test_every_carex_example_is_solved(number: int) -> None:
    care(*CAREX[number - 1])


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8, 13, 16, 17, 25, 40, 100])
@pytest.mark.parametrize("seed", range(4))
def test_a_solution_known_by_construction_is_found(n: int, seed: int) -> None:
    # Choose P and a Hurwitz closed loop C; then A = C + GP and Q = PGP - A'P - PA.
    random = np.random.default_rng([n, seed])
    m = int(random.integers(1, n + 1))
    b, r, p = random.normal(size=(n, m)), weight(random, m), symmetric(random, n)
    g = input_term(b, r)
    a = hurwitz(random, n) + g @ p
    q = p @ g @ p - a.T @ p - p @ a
    q = (q + q.T) / 2
    if n > 1:
        assert np.linalg.eigvalsh(q)[0] < 0
    error = np.linalg.norm(care(a, b, q, r) - p) / np.linalg.norm(p)
    assert error < 1e-7


@pytest.mark.parametrize("seed", range(30))
def test_a_badly_scaled_indefinite_problem_is_solved(seed: int) -> None:
    # As above, with the units of the states over three decades and P over six. (Over four, one of
    # these is refused; there SciPy leaves a residual of 4e-11.)
    random = np.random.default_rng(seed)
    n = int(random.integers(2, 12))
    b, r = random.normal(size=(n, n)), weight(random, n)
    units = np.diag(10 ** random.uniform(-1.5, 1.5, n))
    p = units @ symmetric(random, n) @ units * 10 ** random.uniform(-3, 3)
    g = input_term(b, r)
    a = hurwitz(random, n) + g @ p
    q = p @ g @ p - a.T @ p - p @ a
    error = np.linalg.norm(care(a, b, (q + q.T) / 2, r) - p) / np.linalg.norm(p)
    assert error < 1e-4


@pytest.mark.parametrize("n", [2, 4, 9, 16, 30, 60])
@pytest.mark.parametrize("rank", ["full", "one"])
def test_care_agrees_with_scipy(n: int, rank: str) -> None:
    random = np.random.default_rng([n, len(rank)])
    a, b = random.normal(size=(n, n)), random.normal(size=(n, max(1, n // 2)))
    r, c = weight(random, b.shape[1]), random.normal(size=(n if rank == "full" else 1, n))
    expected = scipy.linalg.solve_continuous_are(a, b, c.T @ c, r)
    np.testing.assert_allclose(care(a, b, c.T @ c, r), expected, atol=1e-8 * abs(expected).max())


@pytest.mark.parametrize("seed", range(20))
def test_badly_scaled_r_is_no_obstacle(seed: int) -> None:
    random = np.random.default_rng(seed)
    n = int(random.integers(2, 12))
    a, b, c = (random.normal(size=(n, n)) for _ in range(3))
    care(a, b, c.T @ c, weight(random, n, decades=12))
    care(a, b, c.T @ c, np.eye(n) * 10 ** random.uniform(-10, 10))


@pytest.mark.parametrize("n", [1, 2, 5, 12, 20])
def test_zero_weight_moves_the_unstable_modes_alone(n: int) -> None:
    # With Q = 0 the closed loop has the stable modes of A and the mirror images of the others.
    random = np.random.default_rng(n)
    a, b = random.normal(size=(n, n)), random.normal(size=(n, n))
    p = care(a, b, np.zeros((n, n)), np.eye(n))
    closed = np.linalg.eigvals(a - b @ b.T @ p)
    mirrored = np.linalg.eigvals(a)
    mirrored = np.where(mirrored.real > 0, -mirrored.conj(), mirrored)
    np.testing.assert_allclose(np.sort(closed.real), np.sort(mirrored.real), rtol=1e-8, atol=1e-9)
    assert np.linalg.matrix_rank(p, 1e-9) == (np.linalg.eigvals(a).real > 0).sum()


def test_scalar_equation_has_its_formula() -> None:
    # 2ap - gp² + q = 0: p = (a + √(a² + gq))/g.
    for a in (-2.0, -1e-3, 0.0, 0.5, 30.0):
        for g in (1e-6, 1.0, 1e6):
            for q in (-0.2 * a * a / g, 0.0, 1e-9, 1.0):
                if a * a + g * q > 0:
                    p = sa.care([[a]], [[1.0]], [[q]], [[1 / g]]).P[0, 0]
                    root = np.hypot(a, np.sqrt(g * q)) if q >= 0 else np.sqrt(a * a + g * q)
                    want = (a + root) / g if a > 0 else q / (root - a)
                    assert p == pytest.approx(want, rel=1e-9)


def test_no_weight_on_a_stable_system_costs_nothing() -> None:
    for n in (1, 2, 7, 20):
        a = hurwitz(np.random.default_rng(n), n)
        assert not sa.care(a, np.eye(n), np.zeros((n, n)), np.eye(n)).P.any()
        assert not sa.bounded_real_riccati(a, np.eye(n), np.zeros((n, n))).P.any()


@pytest.mark.parametrize("n", [2, 3, 6, 12, 24])
@pytest.mark.parametrize("real", [0.0, 1e-3, 2.0])
def test_an_unstable_mode_that_no_input_reaches_is_told(n: int, real: float) -> None:
    random = np.random.default_rng(n)
    a, b = random.normal(size=(n, n)), random.normal(size=(n, 2))
    a[0], b[0] = 0.0, 0.0
    a[0, 0] = real
    turn = np.linalg.qr(random.normal(size=(n, n)))[0]
    for t in (np.eye(n), turn):
        with pytest.raises(ValueError, match=r"wants a stabilisable pair \(A, B\)"):
            sa.care(t @ a @ t.T, t @ b, np.eye(n), np.eye(2))


@pytest.mark.parametrize("n", [1, 2, 4, 17])
def test_no_input_at_all_does_not_stabilise(n: int) -> None:
    chain = np.diag(np.ones(n - 1), 1)
    for a in (chain, chain + np.eye(n)):
        with pytest.raises(ValueError, match="stabilisable"):
            sa.care(a, np.zeros((n, 1)), np.eye(n), [[1.0]])
    p = sa.care(chain - np.eye(n), np.zeros((n, 1)), np.eye(n), [[1.0]]).P
    np.testing.assert_allclose(
        p, scipy.linalg.solve_continuous_lyapunov((chain - np.eye(n)).T, -np.eye(n)), rtol=1e-12
    )


@pytest.mark.parametrize("omega", [0.0, 3.0])
def test_a_mode_on_the_axis_that_the_weight_misses_is_told(omega: float) -> None:
    block = np.array([[0.0, omega], [-omega, 0.0]])
    random = np.random.default_rng(1)
    a = scipy.linalg.block_diag(block, hurwitz(random, 3))
    q = np.diag([0.0, 0.0, 1.0, 1.0, 1.0])
    turn = np.linalg.qr(random.normal(size=(5, 5)))[0]
    for t in (np.eye(5), turn):
        with pytest.raises(ValueError, match="on the imaginary axis") as caught:
            weight_ = t @ q @ t.T
            sa.care(t @ a @ t.T, np.eye(5), (weight_ + weight_.T) / 2, np.eye(5))
        figure = re.search(r"at (\S+) rad/s", str(caught.value))
        assert figure
        assert float(figure.group(1)) == pytest.approx(omega, abs=1e-3)


def test_an_indefinite_weight_that_is_too_negative_is_told() -> None:
    # a² + gq < 0: the Hamiltonian matrix has ±j √(-a² - gq).
    with pytest.raises(ValueError, match=r"axis, or too near to tell, at 1e0 rad/s"):
        sa.care([[-1.0]], [[1.0]], [[-2.0]], [[1.0]])


def peak(a: Array, b: Array, q: Array) -> float:
    """The largest gain over a grid of frequencies, by solving at each."""
    root = np.linalg.cholesky(q + 1e-14 * np.eye(len(q))).T
    grid = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 400)])
    eye = np.eye(len(a))
    return max(np.linalg.norm(root @ np.linalg.solve(1j * w * eye - a, b), 2) for w in grid)


@pytest.mark.parametrize("turn", ["none", "orthogonal", "random"])
@pytest.mark.parametrize("blocks", ["one", "some"])
def test_defective_plants_are_solved_above_their_limit_and_refused_below(
    turn: str, blocks: str
) -> None:
    for seed in range(25):
        random = np.random.default_rng([seed, len(turn), len(blocks)])
        n, a, i = int(random.integers(2, 9)), np.zeros((9, 9)), 0
        while i < n:
            size = n if blocks == "one" else int(random.integers(1, n - i + 1))
            jordan = np.diag(np.ones(size - 1), 1) - random.uniform(0.7, 3) * np.eye(size)
            a[i : i + size, i : i + size] = jordan
            i += size
        t = random.normal(size=(n, n))
        t = {"none": np.eye(n), "orthogonal": np.linalg.qr(t)[0], "random": t}[turn]
        a = t @ a[:n, :n] @ np.linalg.inv(t)
        b, q = random.normal(size=(n, 2)), np.eye(n)
        limit = peak(a, b, q)
        for ratio in (1.1, 2.0, 100.0):
            solution = sa.bounded_real_riccati(a, b, q, ratio * limit)
            is_certified(solution.P, a, -b @ b.T / (ratio * limit) ** 2, q)
        assert solution.gamma_opt == pytest.approx(limit, rel=0.05)
        with pytest.raises(sa.NoStabilizingSolution):
            sa.bounded_real_riccati(a, b, q, 0.99 * limit)


@pytest.mark.parametrize("n", [3, 20, 50])
def test_bounded_real_tends_to_the_lyapunov_equation(n: int) -> None:
    # P(γ) - P(∞) falls with γ⁻².
    random = np.random.default_rng(n)
    a, b, q = hurwitz(random, n), random.normal(size=(n, 2)), np.eye(n)
    limit = scipy.linalg.solve_continuous_lyapunov(a.T, -q)
    solution = sa.bounded_real_riccati(a, b, q, np.inf)
    np.testing.assert_allclose(solution.P, limit, atol=1e-10 * abs(limit).max())
    gamma = 100 * sa.bounded_real_riccati(a, b, q, 1e9).gamma_opt
    near, nearer = (sa.bounded_real_riccati(a, b, q, k * gamma).P - limit for k in (1.0, 10.0))
    assert np.linalg.norm(nearer) == pytest.approx(np.linalg.norm(near) / 100, rel=0.01)


@pytest.mark.parametrize("n", [20, 60])
def test_the_limit_is_told_apart_beyond_sixteen_states(n: int) -> None:
    random = np.random.default_rng(n)
    a, b, c = hurwitz(random, n), random.normal(size=(n, 3)), random.normal(size=(n, n))
    limit = sa.bounded_real_riccati(a, b, c @ c.T, 1e9).gamma_opt
    assert limit is not None
    assert peak(a, b, c @ c.T) <= limit * (1 + 1e-9)
    above = sa.bounded_real_riccati(a, b, c @ c.T, limit * (1 + 1e-6))
    is_certified(above.P, a, -b @ b.T / above.gamma**2, c @ c.T)
    with pytest.raises(sa.NoStabilizingSolution):
        sa.bounded_real_riccati(a, b, c @ c.T, limit * (1 - 1e-6))


def test_512_states_are_solved() -> None:
    # A chain of 256 masses on springs, a force on each. In the modes of the springs (stiffness k)
    # it is 256 equations of one joint, which have a closed form.
    n, damping = 256, 0.1
    springs = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-springs, -damping * np.eye(n)]])
    b = np.vstack([np.zeros((n, n)), np.eye(n)])
    p = care(a, b, np.eye(2 * n), np.eye(n))
    k, shapes = np.linalg.eigh(springs)
    p12 = 1 / (k + np.sqrt(k**2 + 1))
    p22 = (1 + 2 * p12) / (damping + np.sqrt(damping**2 + 1 + 2 * p12))
    p11 = damping * p12 + k * p22 + p12 * p22
    blocks = [[shapes * x @ shapes.T for x in row] for row in ((p11, p12), (p12, p22))]
    np.testing.assert_allclose(p, np.block(blocks), atol=1e-10 * abs(p).max())
