"""03: your own loop. The controller takes a sample and gives the torque to hold for 1 ms."""

import numpy as np
import steadyarm as sa

PERIOD = 1e-3  # s

believed = sa.TwoLink(mass=(4, 4), length=(0.5, 0.5), inertia=(0.2, 0.2))
basis = sa.FuzzyBasis("grid", (-1.5, -0.5, 0.0, 0.5, 1.5), 0.5**0.5, normalized=False)
compensator = sa.FuzzyCompensator(basis, q=10, gain=7.0)
tracker = sa.ComputedTorque(believed, kp=8, kv=5.5, compensator=compensator, effort_limit=20.0)
path = sa.Quintic(start=(0, 0), goal=(0.8, -0.5), duration=2.0)

# In place of your robot: an arm twice as heavy as believed.
robot = sa.Plant(sa.TwoLink(mass=(8, 8), length=(0.5, 0.5), inertia=(0.4, 0.4)))
q, dq = np.zeros(2), np.zeros(2)

for tick in range(4001):
    t = tick * PERIOD
    q_d, dq_d, ddq_d = path(t)
    tau = tracker.step(q, dq, q_d, dq_d, ddq_d, PERIOD)
    if tick % 500 == 0:
        e = 1e3 * (q - q_d)
        print(
            f"t = {t:.1f} s   e = {e[0]:+7.3f} {e[1]:+7.3f} mrad"
            f"   tau = {tau[0]:+7.4f} {tau[1]:+7.4f} N·m"
        )
    q, dq = robot.step(q, dq, tau, t, PERIOD)
