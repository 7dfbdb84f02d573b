"""The run in Numba: compiled scalar loops, buffers made once, RK4 over the flat state."""

from math import cos, exp, sin

import numpy as np
from numba import njit
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

SETS = len(CENTERS)


@njit(fastmath=True)
def memberships(x, out):
    total = 0.0
    for j in range(SETS):
        out[j] = exp(-((x - CENTERS[j]) ** 2))
        total += out[j]
    for j in range(SETS):
        out[j] /= total


@njit(fastmath=True)
def basis(x, mu, xi):
    for i in range(4):
        memberships(x[i], mu[i])
    k = 0
    for a in range(SETS):
        for b in range(SETS):
            outer = mu[0, a] * mu[1, b]
            for c in range(SETS):
                left = outer * mu[2, c]
                for d in range(SETS):
                    xi[k] = left * mu[3, d]
                    k += 1


@njit(fastmath=True)
def dynamics(theta, q2, dq1, dq2):
    c, h = theta[1] * cos(q2), theta[1] * sin(q2)
    mass = (theta[0] + theta[2] + 2 * c, theta[2] + c, theta[2])
    return mass, (-h * (2 * dq1 + dq2) * dq2, h * dq1 * dq1)


@njit(fastmath=True)
def rhs(t, y, dy, mu, xi):
    s1, c1, s3, c3 = sin(t), cos(t), sin(3 * t), cos(3 * t)
    e1 = y[0] - 0.5 * c1 - 0.2 * s3
    e2 = y[1] + 0.2 * s1 + 0.5 * c1
    de1 = y[2] + 0.5 * s1 - 0.6 * c3
    de2 = y[3] + 0.2 * c1 - 0.5 * s1
    basis((e1, e2, de1, de2), mu, xi)

    w1, w2 = y[4 : 4 + RULES], y[4 + RULES :]
    rho1 = rho2 = 0.0
    for k in range(RULES):
        rho1 += w1[k] * xi[k]
        rho2 += w2[k] * xi[k]
    u1 = -0.5 * c1 - 1.8 * s3 - KV * de1 - KP * e1 - rho1
    u2 = 0.2 * s1 + 0.5 * c1 - KV * de2 - KP * e2 - rho2

    (m11, m12, m22), (h1, h2) = dynamics(NOMINAL, y[1], y[2], y[3])
    tau1, tau2 = m11 * u1 + m12 * u2 + h1, m12 * u1 + m22 * u2 + h2
    (m11, m12, m22), (h1, h2) = dynamics(ACTUAL, y[1], y[2], y[3])
    net1, net2, det = tau1 - h1 - s1, tau2 - h2 - c1, m11 * m22 - m12 * m12
    dy[0], dy[1] = y[2], y[3]
    dy[2] = (m22 * net1 - m12 * net2) / det
    dy[3] = (m11 * net2 - m12 * net1) / det

    g1, g2 = GAIN * (P12 * e1 + P22 * de1), GAIN * (P12 * e2 + P22 * de2)
    dw1, dw2 = dy[4 : 4 + RULES], dy[4 + RULES :]
    for k in range(RULES):
        dw1[k] = g1 * xi[k]
        dw2[k] = g2 * xi[k]


@njit(fastmath=True)
def axpy(y, h, dy, out):
    for i in range(y.size):
        out[i] = y[i] + h * dy[i]


@njit(fastmath=True)
def integrate(y, q):
    mu, xi, at = np.empty((4, SETS)), np.empty(RULES), np.empty_like(y)
    k1, k2, k3, k4 = np.empty_like(y), np.empty_like(y), np.empty_like(y), np.empty_like(y)
    for n in range(STEPS):
        t = n * STEP
        rhs(t, y, k1, mu, xi)
        axpy(y, STEP / 2, k1, at)
        rhs(t + STEP / 2, at, k2, mu, xi)
        axpy(y, STEP / 2, k2, at)
        rhs(t + STEP / 2, at, k3, mu, xi)
        axpy(y, STEP, k3, at)
        rhs(t + STEP, at, k4, mu, xi)
        for i in range(y.size):
            y[i] += STEP / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i])
        q[n, 0], q[n, 1] = y[0], y[1]


def run():
    """Return the positions after every step."""
    q = np.empty((STEPS, 2))
    integrate(start(), q)
    return q


if __name__ == "__main__":
    # The first call compiles.
    report("numba", run, warm=1)
