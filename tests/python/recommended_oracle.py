"""The recommended law in plain numpy, written apart from the crate's, one call a period.

e = q − q_d, where q_d starts where the arm is and fades into what is desired; τ_a is the torque
that acted in the last period. Units: rad, s, N·m.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import steadyarm as sa
from recommended_rule import TURN, Array, Design, Model, share

FRICTION_WIDTHS = np.array([0.005, 0.05, 0.5])
"""Of tanh(v/width) [rad/s]."""
FRICTION = 4
"""Features of a joint: three tanh, and v."""
MEMORY = 100.0
"""Time in which what was learnt fades into the prior [s]."""
NOISE = 0.01
"""Of a row, in units of σ."""


class Recommended:
    """The law: one call of `step` a period."""

    def __init__(
        self,
        model: Model,
        made: Design,
        hand_over: float = 3.0,
        extra_deviation: float = 0.1,
        braking: Array | float = np.inf,
    ) -> None:
        n, self.model, self.design, self.hand_over = model.joints, model, made, hand_over
        extras = 0 if model.extra is None else len(model.extra(*np.zeros((3, n))))
        own = np.repeat([0.1, extra_deviation], [FRICTION, extras])
        self.prior = (
            np.diag(np.concatenate([model.deviation, np.outer(made.sigma, own).ravel()])) ** 2
        )
        self.P, self.theta, self.learns = self.prior.copy(), np.zeros(len(self.prior)), True
        self.cycle, self.k, self.since = max(round(0.02 / made.h), n + 1), 0, 0.0
        self.braking = np.broadcast_to(braking, (n,))
        self.ring: list[dict[str, Array]] = []
        self.before, self.ed1, self.ed, self.zeta, self.slow = np.zeros((5, n))
        self.y, self.de, self.rests = np.zeros((3, n))
        self.astray = 0.0
        self.away, self.drift, self.held = np.zeros((3, n))
        self.Y = np.zeros((n, len(self.prior)))

    def features(self, inertial: Array, extra: Array, v: Array) -> Array:
        """Φ, (n, parameters): inertial, then friction and extra features joint by joint."""
        rub = np.concatenate([np.tanh(v[:, None] / FRICTION_WIDTHS), v[:, None]], axis=1)
        own = np.zeros((len(v), len(v), FRICTION + len(extra)))
        for i, row in enumerate(rub):
            own[i, i] = np.concatenate([row, extra])
        return np.concatenate([inertial, own.reshape(len(v), -1)], axis=1)

    def step(self, q: Array, q_d: Array, dq_d: Array, ddq_d: Array, applied: Array) -> Array:
        """Torque for the next period; ``applied`` acted in the last one. It starts from rest."""
        made, h = self.design, self.design.h
        if self.k > 0:
            self.end(applied)
        if self.k == 0:
            self.held = self.model.torque(q, 0.0 * q, 0.0 * q)
            self.away, self.drift = q - q_d, -dq_d + self.hand_over * (q - q_d)
        q_d, dq_d, ddq_d = self.handed_over(q_d, dq_d, ddq_d)
        e = q - q_d
        before = e if self.k == 0 else self.before
        self.before = e
        self.ed1 = self.ed1 + share(made.f_s, h) * ((e - before) / h - self.ed1)
        self.ed = self.ed + share(made.f2, h) * (self.ed1 - self.ed)
        d, p = self.model.weight(q_d), made.p
        alpha = self.zeta - p * self.ed
        v = alpha - 2.0 * p * (self.ed + self.way_back(e))
        now = {
            "v": v,
            "alpha": alpha,
            "e": e,
            "ed": self.ed,
            "weight": d,
            "dq_d": dq_d,
            "nominal": self.model.torque(q_d, dq_d, ddq_d),
            "inertial": self.model.regressor(q_d, dq_d, ddq_d),
            "extra": np.zeros(0)
            if self.model.extra is None
            else self.model.extra(q_d, dq_d, ddq_d),
        }
        phi = self.features(now["inertial"], now["extra"], dq_d)
        now["tau"] = now["nominal"] + phi @ self.theta + d @ v
        self.ring = [*self.ring[-made.delay :], now] if made.delay else [now]
        self.k += 1
        return now["tau"]

    def way_back(self, e: Array) -> Array:
        """The speed at which an error is brought back: p e/2, and less where braking wants it."""
        near = 4.0 * self.braking / self.design.p**2
        braked = np.sqrt(2.0 * np.where(near < abs(e), self.braking * (abs(e) - near / 2), 0.0))
        return np.where(abs(e) <= near, 0.5 * self.design.p * e, np.copysign(braked, e))

    def end(self, applied: Array) -> None:
        """The period of the last sample, in which ``applied`` acted, is over."""
        made, h, last = self.design, self.design.h, self.ring[-1]
        acted = self.ring[0] if len(self.ring) > made.delay else None
        cut = applied - (self.held if acted is None else acted["tau"])
        went = (0.0 if acted is None else acted["v"]) + np.linalg.solve(last["weight"], cut)
        self.zeta = self.zeta + h * made.p * (went - last["alpha"])
        self.slow = self.slow + share(15.0, h) * (last["ed"] - self.slow)
        if acted is not None:
            far = abs(last["e"]).max() > 0.1
            self.listen(acted, applied, last["weight"] @ last["ed"], far or abs(cut).max() > 1e-9)

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

    def listen(
        self, acted: dict[str, Array], applied: Array, momentum: Array, astray: bool
    ) -> None:
        """Filter what the last period told, and take one row of it."""
        made, h = self.design, self.design.h
        a = 1.0 - np.exp(-made.fl * h)
        v = acted["dq_d"] + self.slow
        self.y = self.y + a * (applied - acted["nominal"] - self.y)
        self.Y = self.Y + a * (self.features(acted["inertial"], acted["extra"], v) - self.Y)
        change = a * (momentum - self.de)
        self.de = self.de + change
        slow = np.minimum(abs(v), abs(acted["dq_d"])) < 0.02
        self.rests = self.rests + a * (slow - self.rests)
        self.astray = self.astray + a * (astray - self.astray)
        self.since += h
        row = (self.k - 1) % self.cycle
        if not self.learns:
            return
        if row == len(v):
            self.P = self.P + self.since / MEMORY * (self.prior - self.P)
            self.since = 0.0
        if row < len(v) and self.rests[row] <= 0.3 and self.astray <= 0.02:
            f = self.Y[row] / made.sigma[row]
            y = (self.y[row] - made.c * change[row] / h) / made.sigma[row]
            p_f = self.P @ f
            gain = p_f / (max(NOISE**2, f @ p_f) + f @ p_f)
            self.theta = self.theta + gain * (y - f @ self.theta)
            self.P = self.P - np.outer(gain, p_f)


@dataclass
class Record:
    """A run, a row a period, (T, n) each: what the law was told, what it asked for, and e."""

    q: Array
    """Measured."""
    q_d: Array
    dq_d: Array
    ddq_d: Array
    applied: Array
    """What acted in the period before [N·m]; fed to the law with this row."""
    tau: Array
    """What the law asked for [N·m]."""
    e: Array
    """True error [rad]."""


def track(
    law: Recommended,
    plant: sa.Plant,
    motion: sa.Sines | sa.Quintic,
    seconds: float,
    bits: int = 16,
    start: Array | None = None,
) -> Record:
    """Run the law on a plant from rest at ``start``, q = 0 by default; at first no torque acts."""
    n, h = law.model.joints, law.design.h
    q, dq, count = np.zeros(n) if start is None else start, np.zeros(n), TURN / 2.0**bits
    acted, waiting = np.zeros(n), [np.zeros(n)] * law.design.delay
    run = Record(*np.empty((7, round(seconds / h), n)))
    for k in range(len(run.q)):
        run.q_d[k], run.dq_d[k], run.ddq_d[k] = motion(k * h)
        run.q[k], run.e[k], run.applied[k] = np.rint(q / count) * count, q - run.q_d[k], acted
        run.tau[k] = law.step(run.q[k], run.q_d[k], run.dq_d[k], run.ddq_d[k], acted)
        waiting.append(run.tau[k])
        acted = np.clip(waiting.pop(0), -plant.effort_limit, plant.effort_limit)
        q, dq = plant.step(q, dq, acted, k * h, h)
    return run
