"""02: the arm is twice as heavy as believed, and something pushes. The compensator learns that."""

import steadyarm as sa

believed = sa.TwoLink(mass=(4, 4), length=(0.5, 0.5), inertia=(0.2, 0.2))
there = sa.TwoLink(mass=(8, 8), length=(0.5, 0.5), inertia=(0.4, 0.4))
push = sa.Sines(frequency=1, sin=(1, 0), cos=(0, 1))  # [sin t, cos t] N·m
plant = sa.Plant(there, disturbance=push)
path = sa.Sines(frequency=(1, 3), sin=((0, -0.2), (0.2, 0)), cos=((0.5, -0.5), (0, 0)))

# Five sets for each of e₁, e₂, de₁, de₂ make 5⁴ = 625 rules.
sets = (-1.5, -0.5, 0.0, 0.5, 1.5)
basis = sa.FuzzyBasis("grid", centers=sets, width=0.5**0.5, normalized=False)
compensator = sa.FuzzyCompensator(basis, q=10, gain=7.0)

for name, learning in (("learning off", False), ("learning on", True)):
    tracker = sa.ComputedTorque(believed, kp=8, kv=5.5, compensator=compensator)
    if not learning:
        tracker.freeze()  # at zero: computed torque alone
    run = sa.simulate(plant, tracker, path, duration=20.0)
    rms = run.metrics(window=(10, 20)).rms_e
    print(f"{name:12}   RMS of e = {rms[0]:.4f} {rms[1]:.4f} rad")
