"""Friction that sticks

Slow motion with dry friction: at every turn the joint stands still until the error, and with it the
torque, is large enough to pull it on.
"""

import steadyarm as sa

arm = sa.paper.nominal()
there = arm.with_friction(coulomb=1.0, smoothing=0.0)
path = sa.Sines(frequency=0.3, sin=(0.05, 0.0))
run = sa.simulate(sa.Plant(there), sa.ComputedTorque(arm, 40.0, 12.0), path, 30.0)


def picture(style="light"):
    return run.plot("q", "dq", "tau", joints=[1], style=style)


if __name__ == "__main__":
    picture().savefig("stick_slip.png")
