"""Where the tip goes

A Panda's flange seen from the side: the path that is wanted, and with 2 kg that computed torque
does not know of. It sags from the first moment on.
"""

import numpy as np
import steadyarm as sa

arm = sa.Serial.shipped("panda")
path = sa.Quintic((0, -0.6, 0, -2, 0, 1.6, 0.8), goal=(0, 0.3, 0, -1, 0, 1.6, 0.8), duration=3.0)
law = sa.laws.computed_torque(arm, bandwidth=15.0)
run = sa.simulate(sa.Plant(arm.with_payload(2.0)), law, path, 3.5, q0=path(0.0)[0], record_every=10)


def picture(style="light"):
    figure = sa.plots.Picture(width=5.0, height=2.2, style=style)
    axes = figure.add_subplot(xlabel="forward [m]", ylabel="up [m]", aspect="equal")
    keys, ways = {}, {"wanted": run.q_d, "with 2 kg": run.q}
    for (name, q), (colour, line) in zip(ways.items(), figure.look.cycle, strict=False):
        tip = np.array([arm.pose(it)[:3, 3] for it in q])
        (keys[name],) = axes.plot(tip[:, 0], tip[:, 2], color=colour, linestyle=line)
    figure.frame(axes)
    figure.explain(keys)
    return figure


if __name__ == "__main__":
    picture().savefig("tip.png")
