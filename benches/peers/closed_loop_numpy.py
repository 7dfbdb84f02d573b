"""The run in NumPy: whole-array operations, RK4 over the flat state."""

import numpy as np
from problem import (
    ACTUAL,
    CENTERS,
    GAIN,
    KP,
    KV,
    NOMINAL,
    P12,
    P22,
    RULES,
    STEP,
    STEPS,
    report,
    start,
)


def desired(t):
    """Return q_d, its velocity and its acceleration."""
    s1, c1, s3, c3 = np.sin(t), np.cos(t), np.sin(3 * t), np.cos(3 * t)
    return (
        np.array([0.5 * c1 + 0.2 * s3, -0.2 * s1 - 0.5 * c1]),
        np.array([-0.5 * s1 + 0.6 * c3, -0.2 * c1 + 0.5 * s1]),
        np.array([-0.5 * c1 - 1.8 * s3, 0.2 * s1 + 0.5 * c1]),
    )


def dynamics(theta, q, dq):
    """Return the mass matrix and the bias torque."""
    c, s = np.cos(q[1]), np.sin(q[1])
    m12 = theta[2] + theta[1] * c
    mass = np.array([[theta[0] + theta[2] + 2 * theta[1] * c, m12], [m12, theta[2]]])
    bias = theta[1] * s * np.array([-(2 * dq[0] + dq[1]) * dq[1], dq[0] ** 2])
    return mass, bias


def basis(x):
    """Return the 625 fuzzy basis functions at x = [e; de]."""
    mu = np.exp(-((x[:, None] - CENTERS) ** 2))
    mu /= mu.sum(axis=1, keepdims=True)
    pairs = mu[0::2, :, None] * mu[1::2, None, :]
    return np.outer(pairs[0], pairs[1]).ravel()


def rhs(t, y):
    """Return dy/dt of the closed loop."""
    q, dq, w = y[:2], y[2:4], y[4:].reshape(2, RULES)
    q_d, dq_d, ddq_d = desired(t)
    e, de = q - q_d, dq - dq_d
    xi = basis(np.concatenate([e, de]))

    mass, bias = dynamics(NOMINAL, q, dq)
    tau = mass @ (ddq_d - KV * de - KP * e - w @ xi) + bias
    mass, bias = dynamics(ACTUAL, q, dq)
    net = tau - bias - np.array([np.sin(t), np.cos(t)])

    dy = np.empty_like(y)
    dy[:2] = dq
    # A 2 x 2 system by hand: np.linalg.solve would cost as much as all the rest.
    det = mass[0, 0] * mass[1, 1] - mass[0, 1] ** 2
    dy[2] = (mass[1, 1] * net[0] - mass[0, 1] * net[1]) / det
    dy[3] = (mass[0, 0] * net[1] - mass[0, 1] * net[0]) / det
    dy[4:] = np.outer(GAIN * (P12 * e + P22 * de), xi).ravel()
    return dy


def run():
    """Return the positions after every step."""
    y, q = start(), np.empty((STEPS, 2))
    for k in range(STEPS):
        t = k * STEP
        k1 = rhs(t, y)
        k2 = rhs(t + STEP / 2, y + STEP / 2 * k1)
        k3 = rhs(t + STEP / 2, y + STEP / 2 * k2)
        k4 = rhs(t + STEP, y + STEP * k3)
        y = y + STEP / 6 * (k1 + 2 * (k2 + k3) + k4)
        q[k] = y[:2]
    return q


if __name__ == "__main__":
    report("numpy", run)
