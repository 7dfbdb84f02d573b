"""Many runs in JAX on the processor: vmap over the plants, lax.scan over the steps, float64.

XLA gets one thread, before it starts: with more a run takes more processor time. Other orders of
the axes, an unrolled scan, fast mathematics and wider vectors were no faster.
"""

import os

os.environ.setdefault("NPROC", "1")

import jax
import jax.numpy as jnp
import numpy as np
from many_problem import STEP, STEPS, plants, thetas
from problem import CENTERS, GAIN, KP, KV, NOMINAL, P12, P22

jax.config.update("jax_enable_x64", True)

SETS = len(CENTERS)


def desired(t):
    """Return q_d, its velocity and acceleration, and the disturbance."""
    s1, c1, s3, c3 = jnp.sin(t), jnp.cos(t), jnp.sin(3 * t), jnp.cos(3 * t)
    return (
        jnp.array([0.5 * c1 + 0.2 * s3, -0.2 * s1 - 0.5 * c1]),
        jnp.array([-0.5 * s1 + 0.6 * c3, -0.2 * c1 + 0.5 * s1]),
        jnp.array([-0.5 * c1 - 1.8 * s3, 0.2 * s1 + 0.5 * c1]),
        jnp.array([s1, c1]),
    )


def dynamics(theta, q, dq):
    """Return the entries of the mass matrix, and the bias torque."""
    c, h = theta[1] * jnp.cos(q[1]), theta[1] * jnp.sin(q[1])
    mass = (theta[0] + theta[2] + 2 * c, theta[2] + c, theta[2])
    return mass, (-h * (2 * dq[0] + dq[1]) * dq[1], h * dq[0] ** 2)


def memberships(x):
    """Return the normalised memberships of each entry, (2, SETS)."""
    mu = jnp.exp(-((x[:, None] - CENTERS) ** 2))
    return mu / mu.sum(axis=1, keepdims=True)


def rhs(t, y, theta):
    """Return dy/dt of one run."""
    q, dq, w = y
    q_d, dq_d, ddq_d, disturbance = desired(t)
    e, de = q - q_d, dq - dq_d
    xi = memberships(e)[:, :, None] * memberships(de)[:, None, :]
    u = ddq_d - KV * de - KP * e - (w * xi).sum(axis=(1, 2))

    (m11, m12, m22), (h1, h2) = dynamics(NOMINAL, q, dq)
    tau1, tau2 = m11 * u[0] + m12 * u[1] + h1, m12 * u[0] + m22 * u[1] + h2
    (m11, m12, m22), (h1, h2) = dynamics(theta, q, dq)
    net1, net2 = tau1 - h1 - disturbance[0], tau2 - h2 - disturbance[1]
    ddq = jnp.array([m22 * net1 - m12 * net2, m11 * net2 - m12 * net1]) / (m11 * m22 - m12**2)
    return dq, ddq, (GAIN * (P12 * e + P22 * de))[:, None, None] * xi


def moved(y, *terms):
    """Return y plus the sum of h k over the terms (h, k)."""
    for h, k in terms:
        y = jax.tree.map(lambda a, b, h=h: a + h * b, y, k)
    return y


def integrate(theta, q0):
    """Return the RMS errors of one run, (2,)."""

    def step(carry, n):
        (y, squares), t = carry, n * STEP
        k1 = rhs(t, y, theta)
        k2 = rhs(t + STEP / 2, moved(y, (STEP / 2, k1)), theta)
        k3 = rhs(t + STEP / 2, moved(y, (STEP / 2, k2)), theta)
        k4 = rhs(t + STEP, moved(y, (STEP, k3)), theta)
        y = moved(y, (STEP / 6, k1), (STEP / 3, k2), (STEP / 3, k3), (STEP / 6, k4))
        return (y, squares + (y[0] - desired(t + STEP)[0]) ** 2), None

    y = q0, jnp.zeros(2), jnp.zeros((2, SETS, SETS))
    first = (q0 - desired(0.0)[0]) ** 2
    (_, squares), _ = jax.lax.scan(step, (y, first), jnp.arange(STEPS))
    return jnp.sqrt(squares / (STEPS + 1))


def prepare(count):
    """Return a function that returns the RMS errors of so many runs, (count, 2); it is compiled."""
    mass, q0 = plants(count)
    given = jnp.array(thetas(mass)), jnp.array(q0)
    compiled = jax.jit(jax.vmap(integrate)).lower(*given).compile()
    return lambda: np.asarray(compiled(*given))
