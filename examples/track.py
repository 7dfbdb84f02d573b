"""An arm twice as heavy as believed, pushed by a disturbance: with and without the compensator."""

import steadyarm as sa

believed = sa.TwoLink(mass=(4, 4), length=(0.5, 0.5), inertia=(0.2, 0.2))
there = sa.TwoLink(mass=(8, 8), length=(0.5, 0.5), inertia=(0.4, 0.4))
push = sa.Sines(frequency=(1,), sin=((1, 0),), cos=((0, 1),))
plant = sa.Plant(there, disturbance=push)
path = sa.Sines(frequency=(1, 3), sin=((0, -0.2), (0.2, 0)), cos=((0.5, -0.5), (0, 0)))

basis = sa.FuzzyBasis("grid", (-1.5, -0.5, 0.0, 0.5, 1.5), 0.5**0.5, normalized=False)
for name, compensator in {
    "computed torque": None,
    "with compensator": sa.FuzzyCompensator(basis, q=10, gain=7.0),
}.items():
    tracker = sa.ComputedTorque(believed, kp=8, kv=5.5, compensator=compensator)
    run = sa.simulate(plant, tracker, path, duration=40.0, control_period=1e-3)
    print(f"{name}: {run.status}")
    print(run.metrics(window=(20, 40)), end="\n\n")
