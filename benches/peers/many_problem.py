"""The runs that every peer of ``many.py`` computes: the paper's loop with 25 rules a joint.

Every run has a plant of its own, links of 6 to 10 kg where the controller believes 4, and starts at
rest near the desired pose. State of a run y = [q; dq; W joint by joint], 2 + 2 + 2 x 25 numbers,
W = 0 at the start. Figures are the RMS errors of each joint over all samples at every 1 ms, the
first one included; of ours they are one in seven.

Peers evaluate the formulas as they stand, an exponential for each fuzzy set.
"""

import numpy as np

DURATION = 2.0
STEP = 1e-3
STEPS = round(DURATION / STEP)
SEED = 1
LENGTH = 0.5
"""Of each link [m]."""


def inertias(mass):
    """Return the moments of inertia [kg m^2] of links of these masses [kg]."""
    return mass / 20.0


def plants(count):
    """Return masses [kg] and initial positions [rad] of so many runs, (count, 2) each.

    Those of fewer runs are the first of those of more.
    """
    unit = np.random.default_rng(SEED).uniform(size=(count, 4))
    return 6.0 + 4.0 * unit[:, :2], np.array([0.3, -0.7]) + 0.4 * unit[:, 2:]


def thetas(mass):
    """Return theta of the mass matrices, (count, 3)."""
    first, second = mass.T * LENGTH**2
    inertia = inertias(mass).T
    return np.column_stack([inertia[0] + first / 4 + second, second / 2, inertia[1] + second / 4])
