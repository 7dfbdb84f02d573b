"""Many runs in Numba: plants side by side (prange), each by compiled scalar loops, RK4 of 1 ms."""

from math import cos, sin, sqrt

import numba
import numpy as np
from closed_loop_numba import SETS, axpy, dynamics, memberships
from many_problem import STEP, STEPS, plants, thetas
from numba import njit, prange
from problem import GAIN, KP, KV, NOMINAL, P12, P22

RULES = SETS * SETS


@njit(fastmath=True)
def desired(t, d):
    """q_d, its velocity and acceleration, and the disturbance."""
    s1, c1, s3, c3 = sin(t), cos(t), sin(3 * t), cos(3 * t)
    d[0], d[1] = 0.5 * c1 + 0.2 * s3, -0.2 * s1 - 0.5 * c1
    d[2], d[3] = -0.5 * s1 + 0.6 * c3, -0.2 * c1 + 0.5 * s1
    d[4], d[5] = -0.5 * c1 - 1.8 * s3, 0.2 * s1 + 0.5 * c1
    d[6], d[7] = s1, c1


@njit(fastmath=True)
def rhs(d, theta, y, dy, mu, u):
    for i in range(2):
        e, de = y[i] - d[i], y[2 + i] - d[2 + i]
        memberships(e, mu[0])
        memberships(de, mu[1])
        w, dw = y[4 + i * RULES :], dy[4 + i * RULES :]
        g, rho = GAIN * (P12 * e + P22 * de), 0.0
        for a in range(SETS):
            for b in range(SETS):
                xi = mu[0, a] * mu[1, b]
                rho += w[a * SETS + b] * xi
                dw[a * SETS + b] = g * xi
        u[i] = d[4 + i] - KV * de - KP * e - rho

    (m11, m12, m22), (h1, h2) = dynamics(NOMINAL, y[1], y[2], y[3])
    tau1, tau2 = m11 * u[0] + m12 * u[1] + h1, m12 * u[0] + m22 * u[1] + h2
    (m11, m12, m22), (h1, h2) = dynamics(theta, y[1], y[2], y[3])
    net1, net2, det = tau1 - h1 - d[6], tau2 - h2 - d[7], m11 * m22 - m12 * m12
    dy[0], dy[1] = y[2], y[3]
    dy[2] = (m22 * net1 - m12 * net2) / det
    dy[3] = (m11 * net2 - m12 * net1) / det


@njit(fastmath=True)
def integrate(path, theta, q0, rms):
    y = np.zeros(4 + 2 * RULES)
    y[0], y[1] = q0[0], q0[1]
    mu, u, at = np.empty((2, SETS)), np.empty(2), np.empty_like(y)
    k1, k2, k3, k4 = np.empty_like(y), np.empty_like(y), np.empty_like(y), np.empty_like(y)
    s1, s2 = (y[0] - path[0, 0]) ** 2, (y[1] - path[0, 1]) ** 2
    for n in range(STEPS):
        rhs(path[2 * n], theta, y, k1, mu, u)
        axpy(y, STEP / 2, k1, at)
        rhs(path[2 * n + 1], theta, at, k2, mu, u)
        axpy(y, STEP / 2, k2, at)
        rhs(path[2 * n + 1], theta, at, k3, mu, u)
        axpy(y, STEP, k3, at)
        rhs(path[2 * n + 2], theta, at, k4, mu, u)
        for i in range(y.size):
            y[i] += STEP / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i])
        s1 += (y[0] - path[2 * n + 2, 0]) ** 2
        s2 += (y[1] - path[2 * n + 2, 1]) ** 2
    rms[0], rms[1] = sqrt(s1 / (STEPS + 1)), sqrt(s2 / (STEPS + 1))


@njit(parallel=True, fastmath=True)
def integrate_all(theta, q0, rms):
    # What depends on time alone, at every half of a step, once for all plants.
    path = np.empty((2 * STEPS + 1, 8))
    for n in range(2 * STEPS + 1):
        desired(n * STEP / 2, path[n])
    for i in prange(len(theta)):
        integrate(path, theta[i], q0[i], rms[i])


def prepare(count, threads=1):
    """Return a function that returns the RMS errors of so many runs, (count, 2); it is compiled."""
    mass, q0 = plants(count)
    theta, rms = thetas(mass), np.empty((count, 2))
    integrate_all(theta[:1], q0[:1], rms[:1])

    def run():
        numba.set_num_threads(threads)
        integrate_all(theta, q0, rms)
        return rms

    return run
