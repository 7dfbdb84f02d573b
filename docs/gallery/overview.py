"""A whole run

Position, error, torque, and what the model leaves out against its estimate: the compensator's green
follows the grey within 5 s, and the error becomes small from there on.
"""

import steadyarm as sa

run = sa.paper.simulation(3, "claimed").run(duration=20.0)


def picture(style="light"):
    return run.plot(style=style)


if __name__ == "__main__":
    picture().savefig("overview.png")
