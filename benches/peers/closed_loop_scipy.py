"""The run with SciPy's adaptive integrators, on the right-hand side of the NumPy peer."""

import numpy as np
from closed_loop_numpy import rhs
from problem import DURATION, STEP, STEPS, report, start
from scipy.integrate import solve_ivp

RTOL, ATOL = 1e-8, 1e-10


def solve(method="RK45", rtol=RTOL, atol=ATOL):
    """Return y at every STEP, first sample included."""
    t = STEP * np.arange(STEPS + 1)
    return solve_ivp(rhs, (0.0, DURATION), start(), method, t_eval=t, rtol=rtol, atol=atol).y.T


def run():
    """Return the positions at every STEP."""
    return solve()[1:, :2]


if __name__ == "__main__":
    report("scipy", run)
