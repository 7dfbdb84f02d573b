"""Error against its rate

Both start off the path. With too little damping the error turns around zero; with kv = 2√kp it goes
there at once.
"""

import steadyarm as sa

path, plant = sa.Sines(frequency=1.0, sin=0.3), sa.Plant(sa.paper.nominal())
laws = {f"kv = {kv:g}": sa.ComputedTorque(plant.arm, 8.0, kv) for kv in (1.0, 5.66)}
runs = {name: sa.simulate(plant, law, path, 8.0, q0=(0.4, 0)) for name, law in laws.items()}


def picture(style="light"):
    figure = sa.plots.Picture(width=5.0, height=3.2, style=style)
    axes = figure.add_subplot(xlabel="error [rad]", ylabel="its rate [rad/s]")
    keys = {}
    for (name, run), (colour, line) in zip(runs.items(), figure.look.cycle, strict=False):
        (keys[name],) = axes.plot(run.e[:, 0], run.de[:, 0], color=colour, linestyle=line)
    figure.frame(axes)
    figure.explain(keys)
    return figure


if __name__ == "__main__":
    picture().savefig("phase_plane.png")
