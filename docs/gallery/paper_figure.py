"""The paper's third figure

Desired and actual position as the paper draws them, of its compensator as claimed.
"""

import steadyarm as sa

run = sa.paper.simulation(3, "claimed").run()


def picture(style="light"):
    return sa.plots.paper_figure(run, "Simulation 3, as claimed", style=style)


if __name__ == "__main__":
    picture().savefig("paper_figure.png")
