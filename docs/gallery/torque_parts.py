"""Where the torque comes from

All of the torque, the part from the model, and the part that the compensator adds: of an arm twice
as heavy as believed, about half.
"""

import steadyarm as sa

run = sa.paper.simulation(3, "claimed").run(duration=20.0)


def picture(style="light"):
    return run.plot("tau", "tau_model", "tau_compensation", window=(10, 20), style=style)


if __name__ == "__main__":
    picture().savefig("torque_parts.png")
