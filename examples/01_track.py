"""01: an arm whose model is right follows a path. Computed torque, in continuous time."""

import steadyarm as sa

# The paper's arm: two links of 4 kg [kg, m, kg·m²], flat on a table.
arm = sa.TwoLink(mass=(4, 4), length=(0.5, 0.5), inertia=(0.2, 0.2))

# q_d = [0.5 cos t + 0.2 sin 3t, -0.2 sin t - 0.5 cos t] [rad]
path = sa.Sines(frequency=(1, 3), sin=((0, -0.2), (0.2, 0)), cos=((0.5, -0.5), (0, 0)))

# The error obeys dde + 5.5 de + 8 e = 0: it dies out, whatever the path.
tracker = sa.ComputedTorque(arm, kp=8, kv=5.5)
run = sa.simulate(sa.Plant(arm), tracker, path, duration=4.0)

for row in range(0, 4001, 1000):
    e, tau = 1e3 * run.e[row], run.tau[row]
    print(
        f"t = {run.t[row]:.1f} s   e = {e[0]:+8.3f} {e[1]:+8.3f} mrad"
        f"   tau = {tau[0]:+8.4f} {tau[1]:+8.4f} N·m"
    )
