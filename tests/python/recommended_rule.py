"""The rule that finds every gain of the recommended law, in plain numpy, apart from the crate's.

h is the period [s], d the delay in samples, D(q) the mass matrix that weights the feedback, M that
of the lightest or the heaviest arm that is declared, p the bandwidths [rad/s], σ a quarter of the
effort limits [N·m].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import steadyarm as sa
from numpy.typing import NDArray

Array = NDArray[np.float64]
Map = Callable[..., Array]

TURN = 2.0 * np.pi
PRIMES = np.array([2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37], dtype=float)
CENTERS = np.array([-1.5, -0.5, 0.0, 0.5, 1.5])
BALL = 0.05
"""Radius of a declared load [m]."""
REACH = 0.15
"""Where the prior has the mass of a link [m]."""
BELIEF = 1.0
"""Of an inertial parameter, deviation as a share of its size."""


@dataclass
class Model:
    """What the law knows of an arm; each function is of q, or of (q, q̇, q̈)."""

    joints: int
    poses: Array
    torque: Map
    """Inverse dynamics of the nominal arm."""
    regressor: Map
    deviation: Array
    """Prior standard deviation of each inertial parameter."""
    lightest: Map
    heaviest: Map
    weight: Map
    """Mass matrices M_lo, M_hi and D of the pose."""
    extra: Map | None = None
    """Features for what is in no regressor, the same for every joint."""


def spread(lower: Array, upper: Array) -> Array:
    """24 poses over the joints' ranges, (24, n)."""
    turns = np.arange(1, 25)[:, None] * np.sqrt(PRIMES[: len(lower)])
    return np.asarray(lower + (turns - np.floor(turns)) * (upper - lower))


def fuzzy(q: Array, dq: Array, ddq: Array) -> Array:
    """1, and five Gaussian sets of each of (q, q̇, q̈): 31 raw features on the two-link arm."""
    x = np.concatenate([q, dq, ddq])[:, None]
    return np.concatenate([[1.0], np.exp(-((x - CENTERS) ** 2)).ravel()])


def two_link_regressor(q: Array, dq: Array, ddq: Array) -> Array:
    """Y of the arm that lies flat; parameters I₁ + m₁c₁² + m₂l₁², m₂l₁c₂, I₂ + m₂c₂²."""
    (one, two), cos, sin = ddq, np.cos(q[1]), np.sin(q[1])
    across = 2.0 * dq[0] * dq[1] + dq[1] ** 2
    coupling = (2.0 * one + two) * cos - across * sin, one * cos + dq[0] ** 2 * sin
    return np.array([[one, coupling[0], one + two], [0.0, coupling[1], one + two]])


def two_link(arm: sa.TwoLink, lowest: float = 1.0, highest: float = 1.0) -> Model:
    """Model of a flat two-link arm of this inertia, times lowest … highest by declaration."""
    (m1, m2), (l1, l2), (i1, i2) = arm.parameters[:3]
    c1, c2 = 0.5 * l1, 0.5 * l2
    pi = np.array([i1 + m1 * c1**2 + m2 * l1**2, m2 * l1 * c2, i2 + m2 * c2**2])
    quarter = 1.0 + (highest - 1.0) / 4.0
    return Model(
        joints=2,
        poses=spread(np.full(2, -np.pi), np.full(2, np.pi)),
        torque=arm.inverse_dynamics,
        regressor=two_link_regressor,
        deviation=BELIEF * pi,
        lightest=lambda q: lowest * arm.mass_matrix(q),
        heaviest=lambda q: highest * arm.mass_matrix(q),
        weight=lambda q: quarter * arm.mass_matrix(q),
        extra=fuzzy,
    )


def chain(arm: sa.Serial, load: float) -> Model:
    """Model of a chain that may carry up to ``load`` [kg] at its tip."""

    def carrying(mass: float) -> Map:
        if mass == 0.0:
            return rigid.mass_matrix
        return rigid.with_payload(mass, inertia=0.4 * mass * BALL**2).mass_matrix

    rigid = arm.without_friction()
    bounds = [rigid.limits["lower"], rigid.limits["upper"]]
    ends = np.isfinite(bounds).all(axis=0)
    size = np.repeat([1.0, REACH, REACH**2], [1, 3, 6])
    mass = arm.inertial_parameters().reshape(-1, 10)[:, 0]
    return Model(
        joints=arm.joints,
        poses=spread(np.where(ends, bounds[0], -np.pi), np.where(ends, bounds[1], np.pi)),
        torque=rigid.inverse_dynamics,
        regressor=rigid.regressor,
        deviation=BELIEF * np.outer(mass, size).ravel(),
        lightest=rigid.mass_matrix,
        heaviest=carrying(load),
        weight=carrying(load / 4.0),
    )


@dataclass
class Design:
    """What the rule finds."""

    p: Array
    """Bandwidth of each joint [rad/s]."""
    f2: Array
    """Second filter of the velocity [Hz]."""
    fl: float
    """Filter of the regression [rad/s]."""
    c: float
    condition: float
    """Largest |Δ(1 − Δ)⁻¹|, at most 1."""
    root: float
    """Largest real part of the roots of the sampled loop, as a multiple of min p."""
    h: float
    delay: int
    f_s: float
    sigma: Array


def share(hertz: Any, h: float) -> Any:
    """Of the way that a first-order low-pass goes in a period."""
    return 1.0 - np.exp(-TURN * hertz * h)


def noise_gain(f_s: float, f2: float, h: float) -> float:
    """RMS of (1 − z⁻¹)/√2 through both filters, for white noise of 1.

    The response to a step through two poles x, y is known; its square summed is
    (1 + xy)/((1 − x²)(1 − y²)(1 − xy)) for 1/((1 − xz⁻¹)(1 − yz⁻¹)), less its neighbours' product.
    """
    x, y = 1.0 - share(f_s, h), 1.0 - share(f2, h)
    power = (1.0 + x * y) / ((1.0 - x**2) * (1.0 - y**2) * (1.0 - x * y))
    neighbours = power * (x + y) / (1.0 + x * y)
    return float((1.0 - x) * (1.0 - y) * np.sqrt(power - neighbours))


def fastest(
    inertia: float, effort: float, h: float, delay: int, f_s: float, sigma_q: float
) -> tuple[float, float]:
    """(p, f2) of the largest p whose noise is at most .5 % of the effort; 20 Hz if none is."""
    found = (0.0, 0.0)
    for f2 in np.geomspace(20.0, 2000.0, 401):
        late = (0.5 + delay) * h + 1.0 / (TURN * f_s) + 1.0 / (TURN * f2)
        p = min(0.35 / (3.0 * late), 40.0)
        noise = 3.0 * p * inertia * sigma_q * np.sqrt(2.0) / h * noise_gain(f_s, f2, h)
        if found[0] == 0.0 or (noise <= 0.005 * effort and p > found[0]):
            found = (p, f2)
    return found


def loop_root(m: Array, d: Array, p: Array, f2: Array, h: float, delay: int, f_s: float) -> float:
    """Largest real part of the roots of the sampled loop at a frozen pose [1/s].

    States: e, ė, e of the sample before, two filters, ζ, and v of the last 1 + d samples.
    """
    n, blocks = len(p), 7 + delay
    e, de, before, ed1, ed, zeta, *asked = np.eye(blocks * n).reshape(blocks, n, -1)
    p = p[:, None]
    ed1 = ed1 + share(f_s, h) * ((e - before) / h - ed1)
    ed = ed + share(f2, h)[:, None] * (ed1 - ed)
    zeta = zeta + h * p * (asked[delay] - zeta + p * ed)
    asked = [-3.0 * p * ed - p**2 * e + zeta, *asked[:delay]]
    pushed = np.linalg.solve(m, d @ asked[delay])
    after = [e + h * de + 0.5 * h**2 * pushed, de + h * pushed, e, ed1, ed, zeta, *asked]
    return float(np.log(abs(np.linalg.eigvals(np.concatenate(after))).max()) / h)


def condition(m: Array, d: Array, p: Array, fl: float, c: float, sigma: Array) -> float:
    """Largest singular value of Δ(1 − Δ)⁻¹ over frequencies, Δ = LP(1 − cDM⁻¹)S, in units of σ."""
    one, worst = np.eye(len(p)), 0.0
    for s in 1j * p.min() * np.geomspace(0.01, 100.0, 121):
        stiff = d * (3.0 * p * s + 3.0 * p**2 + p**3 / s)
        s_m = np.linalg.solve((m * s**2 + stiff).T, (m * s**2).T).T
        delta = (one - c * np.linalg.solve(m, d).T) @ s_m / (1.0 + s / fl)
        delta = delta * sigma / sigma[:, None]
        worst = max(worst, float(np.linalg.norm(delta @ np.linalg.inv(one - delta), 2)))
    return worst


def design(
    model: Model,
    h: float,
    bits: int,
    delay: int,
    effort: Array,
    f_s: float = 100.0,
    noise: float = 0.0,
) -> Design:
    """Follow the rule: no number to choose. ``noise`` is of the positions [rad]."""
    d = np.array([model.weight(q) for q in model.poses])
    light, heavy = (np.array([m(q) for q in model.poses]) for m in (model.lightest, model.heaviest))
    weights, lowest = (np.diagonal(x, axis1=1, axis2=2) for x in (d, light))
    sigma_q = float(np.hypot(TURN / 2.0**bits / np.sqrt(12.0), noise))
    pairs = zip(weights.max(axis=0), effort, strict=True)
    found = np.array([fastest(a, b, h, delay, f_s, sigma_q) for a, b in pairs])
    p, f2 = found[:, 0] * np.minimum(1.0, 2.0 * (lowest / weights).min(axis=0)), found[:, 1]

    def root() -> float:
        every = [loop_root(m[k], d[k], p, f2, h, delay, f_s) for m in (light, heavy) for k in turns]
        return float(max(every) / p.min())

    turns = range(len(d))
    while (last := root()) > -0.05:
        p = 0.9 * p
    sigma, fl = effort / 4.0, float(p.min()) / 5.0

    def worst(c: float) -> float:
        return max(condition(m[k], d[k], p, fl, c, sigma) for m in (light, heavy) for k in turns)

    while True:
        value, c = min((worst(c), c) for c in (1.0, 1.25, 1.5, 2.0))
        if value <= 1.0:
            return Design(p, f2, fl, c, value, last, h, delay, f_s, sigma)
        fl *= 0.9
