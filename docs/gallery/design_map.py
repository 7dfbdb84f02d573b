"""How fast must the loop be?

What `sa.design` says of a period, over the bandwidth, where torques act a sample late. Twice the
bandwidth wants half the period.
"""

import numpy as np
import steadyarm as sa

bandwidth = np.geomspace(5, 100, 40)
laws = [sa.ComputedTorque(sa.paper.nominal(), p**2, 2 * p) for p in bandwidth]
longest = np.array([1e3 * sa.design(law, 1e-4, delay=1).max_period.min() for law in laws])


def picture(style="light"):
    figure = sa.plots.Picture(width=5.0, height=3.2, style=style)
    axes = figure.add_subplot(xlabel="bandwidth [rad/s]", ylabel="control period [ms]")
    edges, look = [0.1 + 0 * longest, longest / 3, longest * 3 / 4, 100 + 0 * longest], figure.look
    parts = zip(
        ("go ahead", "warned", "refused"), (look.green, look.amber, look.orange), strict=True
    )
    keys = {name: axes.fill_between(bandwidth, *edges[k : k + 2], color=colour, alpha=0.6)
            for k, (name, colour) in enumerate(parts)}  # fmt: skip
    axes.set(xscale="log", yscale="log", xlim=(5, 100), ylim=(0.3, 100))
    figure.frame(axes)
    figure.explain(keys)
    return figure


if __name__ == "__main__":
    picture().savefig("design_map.png")
