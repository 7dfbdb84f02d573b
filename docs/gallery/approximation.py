"""Enough rules come as close as you like

The largest error of fuzzy systems that were fitted to x sin(3x) against their number of rules.
"""

import numpy as np
import steadyarm as sa

x = np.linspace(-2, 2, 801)[:, None]
y = x * np.sin(3 * x)
rows = []
for sets in (4, 6, 9, 13, 19, 28):
    centers = np.linspace(-2, 2, sets)
    basis = sa.FuzzyBasis("grid", centers, width=2.4 / (sets - 1))
    rows.append((sets, abs(sa.FuzzyApproximator.fit(basis, x, y)(x) - y).max()))


def picture(style="light"):
    return sa.plots.approximation(rows, style=style)


if __name__ == "__main__":
    picture().savefig("approximation.png")
