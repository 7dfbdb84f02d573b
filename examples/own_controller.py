"""A controller of one's own beside those of the package, in one table."""

import numpy as np
import steadyarm as sa


class Springs:
    """A spring and a damper at each joint, which grow stiffer while an error stays."""

    def __init__(self, arm):
        self.arm = arm
        self.pushed = np.zeros(arm.joints)

    def step(self, q, dq, q_d, dq_d, ddq_d, dt):
        """Return the torque [N·m] for one sample."""
        e, de = q - q_d, dq - dq_d
        self.pushed = np.clip(self.pushed + 200.0 * e * dt, -10.0, 10.0)
        return self.arm.gravity(q) - 150.0 * e - 25.0 * de - self.pushed


table = sa.compare(
    "paper_sensors", {"springs": Springs}, only=["springs", "computed_torque", "pid"]
)
print(table)
