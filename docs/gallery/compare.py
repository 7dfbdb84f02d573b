"""Which law is best?

Error against how much the torque moves, a dot a law; down and to the left is better. Laws that
switch pay for a small error with a torque that jumps.
"""

import steadyarm as sa

only = ["computed_torque", "pd", "fuzzy_claimed", "pid", "slotine_li", "sliding_mode", "robust",
        "super_twisting", "momentum_observer", "recommended"]  # fmt: skip
rows = sa.compare("paper_sensors", only=only, seeds=1, freeze=False).rows


def picture(style="light"):
    figure = sa.plots.Picture(height=3.6, style=style)
    axes = figure.add_subplot(xlabel="torque variation [N·m/s]", ylabel="RMS error [rad]")
    words = {"color": figure.look.ink, "fontsize": 7, "textcoords": "offset points"}
    for row in rows:
        at = (row.torque_variation, row.steady_rms_e)
        axes.loglog(*at, "o", color=figure.look.blue)
        axes.annotate(row.controller, at, (4, 3), **words)
    figure.frame(axes)
    return figure


if __name__ == "__main__":
    picture().savefig("compare.png")
