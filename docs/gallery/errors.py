"""Errors of rivals, joint by joint

The arm is twice as heavy as believed and pushed. Computed torque keeps its error, a PID makes it
small, and the recommended law smaller.
"""

import steadyarm as sa

scene = sa.Scenario.read("paper_sensors")
laws = {"computed torque": "computed_torque", "PID": "pid", "recommended": "recommended"}
runs = {name: scene.simulate(law) for name, law in laws.items()}


def picture(style="light"):
    return sa.plots.errors(runs, style=style)


if __name__ == "__main__":
    picture().savefig("errors.png")
