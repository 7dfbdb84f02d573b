"""A payload that is picked up

2 kg from 6 s on, and down again at 12 s, which no controller is told. Each jump is an error that
the law must get rid of.
"""

import steadyarm as sa

scene = sa.Scenario.read("panda_pickup")
runs = {law: scene.simulate(law) for law in ("computed_torque", "pid", "recommended")}


def picture(style="light"):
    return sa.plots.errors(runs, joints=[2, 4], window=(5, 15), style=style)


if __name__ == "__main__":
    picture().savefig("payload.png")
