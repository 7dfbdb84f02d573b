"""What the encoder does to the torque

The same loop with encoders of 14, 16 and 20 bits and velocities by difference. The coarser the
encoder, the more the torque shakes; the motion hardly shows it.
"""

import steadyarm as sa

arm, path, runs = sa.paper.nominal(), sa.paper.reference(), {}
law = sa.ComputedTorque(arm, 100.0, 20.0, velocity_filter=100.0)
start = {"q0": path(0.0)[0], "dq0": path(0.0)[1]}
for bits in (14, 16, 20):
    seen = sa.Effects(encoder_bits=bits, velocity="difference")
    runs[bits] = sa.simulate(
        sa.Plant(arm), law, path, 4.0, control_period=1e-3, effects=seen, **start
    )


def picture(style="light"):
    figure = sa.plots.Picture(height=2.6, style=style)
    axes = figure.add_subplot(xlabel="time [s]", ylabel="torque of joint 1 [N·m]", xlim=(2, 2.2))
    keys = {}
    for (bits, run), (colour, _) in zip(runs.items(), figure.look.cycle, strict=False):
        (keys[f"{bits} bits"],) = axes.plot(run.t[2000:2201], run.tau[2000:2201, 0], color=colour)
    figure.frame(axes)
    figure.explain(keys)
    return figure


if __name__ == "__main__":
    picture().savefig("sensors.png")
