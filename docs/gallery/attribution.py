"""Why the error is what it is

A Panda with 2 kg and friction that its PID does not know of. Gravity of the payload is most of the
missing torque at joint 2, and friction most of its error: the integral carries what is constant.
"""

import steadyarm as sa

run = sa.Scenario.read("panda_payload").simulate("pid")
found = sa.attribution(run, window=(6, 12))


def picture(style="light"):
    return found.plot(joints=[2, 6], style=style)


if __name__ == "__main__":
    picture().savefig("attribution.png")
