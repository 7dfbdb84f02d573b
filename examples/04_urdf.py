"""04: your own robot from a URDF, and its dynamics: M(q) ddq + H(q, dq) = tau."""

from pathlib import Path

import steadyarm as sa

URDF = Path(__file__).with_name("04_arm.urdf")

arm = sa.Serial.from_urdf(URDF, base="base", tip="tool")
print("joints:", ", ".join(arm.joint_names))

q, dq, ddq = (0.3, 0.5, -0.8), (0.1, 0.2, -0.4), (0.5, 1.0, 2.0)  # m and rad, m/s and rad/s, …


def row(name, values):
    """Print a line of numbers."""
    print(f"{name:10}", *(f"{value:+10.5f}" for value in values))


for name, line in zip(("M [kg·m²]", "", ""), arm.mass_matrix(q), strict=True):
    row(name, line)
row("H [N·m]", arm.bias(q, dq))  # C dq + G + friction
row("tau [N·m]", arm.inverse_dynamics(q, dq, ddq))
row("ddq", arm.forward_dynamics(q, dq, arm.inverse_dynamics(q, dq, ddq)))
row("tip [m]", arm.pose(q)[:3, 3])
