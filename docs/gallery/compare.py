"""Which law is best?

Error against how much the torque moves; down and to the left is better. A line joins the laws that
no other beats in both. Laws that switch pay for a small error with a torque that jumps.
"""

import steadyarm as sa

table = sa.compare("paper_sensors", seeds=1, freeze=False)


def picture(style="light"):
    return sa.plots.pareto(table, style=style)


if __name__ == "__main__":
    picture().savefig("compare.png")
