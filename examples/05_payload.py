"""05: a Panda carries 2 kg that its controller knows nothing of. A small compensator a joint."""

import steadyarm as sa

arm = sa.Serial.shipped("panda")
plant = sa.Plant(arm.with_payload(2.0, com=(0, 0, 0.05)))
believed = arm.without_friction()

start = (0, -0.6, 0, -2, 0, 1.6, 0.8)
goal = (0.3, -0.3, 0.3, -1.7, 0.3, 1.9, 1.1)
path = sa.Quintic(start, goal, duration=2.0)

# What a joint lacks depends on where it should be and how fast it should go: 5 × 5 rules a joint.
centers = [[q - 0.6, q - 0.3, q, q + 0.3, q + 0.6] for q in start + 7 * (0,)]
basis = sa.FuzzyBasis("per_joint", centers, width=0.2, inputs="reference")
compensator = sa.FuzzyCompensator(basis, q=7 * [400] + 7 * [40], gain=1e4)

for name, learning in (("learning off", False), ("learning on", True)):
    tracker = sa.ComputedTorque(believed, kp=400, kv=40, compensator=compensator)
    if not learning:
        tracker.freeze()
    run = sa.simulate(plant, tracker, path, duration=4.0, control_period=1e-3, q0=start)
    e = 1e3 * abs(run.e[-1])
    print(f"{name:12}   after {run.t[-1]:.0f} s   |e| =", *(f"{x:7.3f}" for x in e), "mrad")
