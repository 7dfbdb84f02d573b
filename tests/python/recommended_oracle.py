"""The recommended law in plain numpy, written apart from the crate's: its design rule and its step.

Symbols: e = q − q_d, h the period [s], d the delay in samples, D(q) the mass matrix that weights the
feedback, M that of the lightest or the heaviest arm that is declared, p the bandwidths [rad/s], σ a
quarter of the effort limits [N·m], τ_a the torque that acted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import steadyarm as sa
from numpy.typing import NDArray
from scipy.linalg import block_diag

Array = NDArray[np.float64]
Map = Callable[..., Array]

TURN = 2.0 * np.pi
PRIMES = np.array([2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37], dtype=float)
CENTERS = np.array([-1.5, -0.5, 0.0, 0.5, 1.5])
FRICTION_WIDTHS = np.array([0.005, 0.05, 0.5])
"""Of tanh(v/width) [rad/s]."""
FRICTION = 4
"""Features of a joint: three tanh, and v."""
BALL = 0.05
"""Radius of a declared load [m]."""
REACH = 0.15
"""Where the prior has the mass of a link [m]."""
BELIEF = 0.75
"""Of an inertial parameter, deviation as a share of its size."""
MEMORY = 100.0
"""Time in which what was learnt fades into the prior [s]."""
NOISE = 0.01
"""Of a row, in units of σ."""


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
    share = 1.0 + (highest - 1.0) / 4.0
    return Model(
        joints=2,
        poses=spread(np.full(2, -np.pi), np.full(2, np.pi)),
        torque=arm.inverse_dynamics,
        regressor=two_link_regressor,
        deviation=BELIEF * pi,
        lightest=lambda q: lowest * arm.mass_matrix(q),
        heaviest=lambda q: highest * arm.mass_matrix(q),
        weight=lambda q: share * arm.mass_matrix(q),
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
    """Largest |Δ(1 − Δ)⁻¹|."""
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
    model: Model, h: float, bits: int, delay: int, effort: Array, f_s: float = 100.0
) -> Design:
    """Follow the rule: no number to choose."""
    d = np.array([model.weight(q) for q in model.poses])
    light, heavy = (np.array([m(q) for q in model.poses]) for m in (model.lightest, model.heaviest))
    weights, lowest = (np.diagonal(x, axis1=1, axis2=2) for x in (d, light))
    sigma_q = TURN / 2.0**bits / np.sqrt(12.0)
    pairs = zip(weights.max(axis=0), effort, strict=True)
    found = np.array([fastest(a, b, h, delay, f_s, sigma_q) for a, b in pairs])
    p, f2 = found[:, 0] * np.minimum(1.0, 2.0 * (lowest / weights).min(axis=0)), found[:, 1]

    def root() -> float:
        every = [loop_root(m[k], d[k], p, f2, h, delay, f_s) for m in (light, heavy) for k in turns]
        return max(every) / p.min()

    turns = range(len(d))
    while (last := root()) > -0.05:
        p = 0.9 * p
    fl, sigma = p.min() / 5.0, effort / 4.0
    values = {
        c: max(condition(m[k], d[k], p, fl, c, sigma) for m in (light, heavy) for k in turns)
        for c in (1.0, 1.25, 1.5, 2.0)
    }
    c = min(values, key=lambda c: values[c])
    return Design(p, f2, fl, c, values[c], last, h, delay, f_s, sigma)


class Recommended:
    """The law: one call of `step` a period."""

    def __init__(
        self, model: Model, made: Design, hand_over: float = 3.0, extra_deviation: float = 0.03
    ) -> None:
        n, self.model, self.design, self.hand_over = model.joints, model, made, hand_over
        extras = 0 if model.extra is None else len(model.extra(*np.zeros((3, n))))
        own = np.repeat([0.1, extra_deviation], [FRICTION, extras])
        self.prior = (
            np.diag(np.concatenate([model.deviation, np.outer(made.sigma, own).ravel()])) ** 2
        )
        self.P, self.theta, self.learns = self.prior.copy(), np.zeros(len(self.prior)), True
        self.cycle, self.k = max(round(0.02 / made.h), n), 0
        self.ring: list[dict[str, Array]] = []
        self.ed1, self.ed, self.zeta, self.slow = np.zeros((4, n))
        self.y, self.de, self.rests, self.limited = np.zeros((4, n))
        self.Y = np.zeros((n, len(self.prior)))

    def features(self, inertial: Array, extra: Array, v: Array) -> Array:
        """Φ, (n, parameters): inertial, then friction and extra features joint by joint."""
        rub = np.concatenate([np.tanh(v[:, None] / FRICTION_WIDTHS), v[:, None]], axis=1)
        own = [np.concatenate([row, extra]) for row in rub]
        return np.concatenate([inertial, block_diag(*own)], axis=1)

    def step(self, q: Array, q_d: Array, dq_d: Array, ddq_d: Array, applied: Array) -> Array:
        """Torque for the next period; ``applied`` acted in the last one. It starts from rest."""
        made, h = self.design, self.design.h
        if self.k == 0:
            self.away, self.drift = q - q_d, -dq_d + self.hand_over * (q - q_d)
        q_d, dq_d, ddq_d = self.handed_over(q_d, dq_d, ddq_d)
        e = q - q_d
        before = e if self.k == 0 else self.e
        self.e = e
        self.ed1 = self.ed1 + share(made.f_s, h) * ((e - before) / h - self.ed1)
        self.ed = self.ed + share(made.f2, h) * (self.ed1 - self.ed)
        d, p = self.model.weight(q_d), made.p
        acted = self.ring[-1 - made.delay] if len(self.ring) > made.delay else None
        if acted is not None:
            missing = np.linalg.solve(d, applied - acted["tau"])
            self.zeta = self.zeta + h * p * (acted["v"] + missing - self.zeta + p * self.ed)
        v = -3.0 * p * self.ed - p**2 * e + self.zeta
        now = {
            "v": v,
            "dq_d": dq_d,
            "nominal": self.model.torque(q_d, dq_d, ddq_d),
            "inertial": self.model.regressor(q_d, dq_d, ddq_d),
            "extra": np.zeros(0)
            if self.model.extra is None
            else self.model.extra(q_d, dq_d, ddq_d),
        }
        phi = self.features(now["inertial"], now["extra"], dq_d)
        now["tau"] = now["nominal"] + phi @ self.theta + d @ v
        self.slow = self.slow + share(15.0, h) * (self.ed - self.slow)
        if acted is not None:
            self.listen(acted, applied, d @ self.ed)
        self.ring = [*self.ring[-made.delay - 1 :], now]
        self.k += 1
        return now["tau"]

    def handed_over(self, q_d: Array, dq_d: Array, ddq_d: Array) -> tuple[Array, Array, Array]:
        """The desired motion that starts where the arm is, at rest."""
        a, t = self.hand_over, self.k * self.design.h
        fades = np.exp(-a * t)
        gap = self.away + self.drift * t
        return (
            q_d + gap * fades,
            dq_d + (self.drift - a * gap) * fades,
            ddq_d + (a**2 * gap - 2.0 * a * self.drift) * fades,
        )

    def listen(self, acted: dict[str, Array], applied: Array, momentum: Array) -> None:
        """Filter what the last period told, and take one row of it."""
        made, h = self.design, self.design.h
        a = 1.0 - np.exp(-made.fl * h)
        v = acted["dq_d"] + self.slow
        self.y = self.y + a * (applied - acted["nominal"] - self.y)
        self.Y = self.Y + a * (self.features(acted["inertial"], acted["extra"], v) - self.Y)
        change = a * (momentum - self.de)
        self.de = self.de + change
        self.rests = self.rests + a * ((abs(v) < 0.02) - self.rests)
        self.limited = self.limited + a * ((abs(applied - acted["tau"]) > 1e-9) - self.limited)
        row = self.k % self.cycle
        if not self.learns:
            return
        if row == 0:
            self.P = self.P + self.cycle * h / MEMORY * (self.prior - self.P)
        if row < len(v) and self.rests[row] <= 0.3 and self.limited.max() <= 0.02:
            f = self.Y[row] / made.sigma[row]
            y = (self.y[row] - made.c * change[row] / h) / made.sigma[row]
            p_f = self.P @ f
            gain = p_f / (max(NOISE**2, f @ p_f) + f @ p_f)
            self.theta = self.theta + gain * (y - f @ self.theta)
            self.P = self.P - np.outer(gain, p_f)


def replay(law: Recommended, steps: int, limit: Array) -> list[Array]:
    """q, q_d, q̇_d, q̈_d, τ_a and the torques of a smooth replay, (steps, n) each.

    The arm trails sines by a small sine, and what acts is what was asked for, late and limited.
    """
    n, h, delay = law.model.joints, law.design.h, law.design.delay
    t = h * np.arange(steps)[:, None]
    w, phase, middle = 1.0 + 0.7 * np.sqrt(PRIMES[:n]), PRIMES[:n], law.model.poses.mean(axis=0)
    q_d = middle + 0.4 * np.sin(w * t + phase)
    dq_d, ddq_d = 0.4 * w * np.cos(w * t + phase), -(w**2) * (q_d - middle)
    q = q_d + 0.01 * np.sin(5.0 * w * t + 2.0 * phase) * np.exp(-t)
    applied, torques = np.zeros((2, steps, n))
    for k in range(steps):
        if k > delay:
            applied[k] = np.clip(torques[k - 1 - delay], -limit, limit)
        torques[k] = law.step(q[k], q_d[k], dq_d[k], ddq_d[k], applied[k])
    return [q, q_d, dq_d, ddq_d, applied, torques]


def track(
    law: Recommended, plant: sa.Plant, motion: Map, seconds: float, bits: int = 16
) -> tuple[Array, Array]:
    """Errors [rad] and torques that acted [N·m] of a run from q = 0 at rest, a row a period."""
    n, h = law.model.joints, law.design.h
    q, dq, count = np.zeros(n), np.zeros(n), TURN / 2.0**bits
    waiting = [np.zeros(n)] * (law.design.delay + 1)
    e, tau = np.empty((2, round(seconds / h), n))
    for k in range(len(e)):
        desired = motion(k * h)
        e[k] = q - desired[0]
        waiting.append(law.step(np.rint(q / count) * count, *desired, waiting.pop(0)))
        tau[k] = np.clip(waiting[0], -plant.effort_limit, plant.effort_limit)
        waiting[0] = tau[k]
        q, dq = plant.step(q, dq, tau[k], k * h, h)
    return e, tau
