"""How good a run was, in figures with units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ._documented import documented
from ._figures import FIGURES
from ._html import Entry, by_joint
from ._joints import numbered

Array = NDArray[np.float64]

NAMES = (
    "rms_e", "max_abs_e", "itae", "settling_time", "rms_tau", "max_abs_tau", "torque_variation",
)  # fmt: skip
UNITS = {name: FIGURES[name].unit for name in NAMES}
"""Units of the metrics; m and N instead of rad and N·m for a prismatic joint."""


@documented
@dataclass(frozen=True, repr=False)
class Metrics:
    """How good a run was over a window, joint by joint; every array has shape (n,).

    For a prismatic joint m and N stand for rad and N·m. Printed with its units.
    """

    rms_e: Array
    """Root mean square of the error [rad]."""
    max_abs_e: Array
    """Largest error [rad]."""
    itae: Array
    """∫ t |e| dt, t from the start of the window [rad·s²]."""
    settling_time: Array
    """Time after which the error stays within the band [s]; inf if it does not."""
    rms_tau: Array
    """Root mean square of the torque [N·m]; empty, like all of it, if it was not recorded."""
    max_abs_tau: Array
    """Largest torque [N·m]."""
    torque_variation: Array
    """How much the torque moves, Σ|Δτ| per second [N·m/s]."""
    joint_names: tuple[str, ...] = ()
    """Names of the joints; () or their numbers, from 1, where they have none."""
    units: tuple[str, ...] = ()
    """"rad" of each joint, "m" of a prismatic one."""

    def _recorded(self) -> list[str]:
        return [name for name in UNITS if len(getattr(self, name))]

    def __str__(self) -> str:
        def row(name: str) -> str:
            values = " ".join(f"{value:12.6g}" for value in getattr(self, name))
            return f"{name:>16} {f'[{UNITS[name]}]':9} {values}"

        head = " " * 27 + " ".join(f"{f'joint {n + 1}':>12}" for n in range(len(self.rms_e)))
        return "\n".join([head, *map(row, self._recorded())])

    def _repr_html_(self) -> str:
        """The table, for a notebook; all digits are in the titles of its cells."""
        rows = []
        for name in self._recorded():
            told = FIGURES[name]
            values = told.scale * np.asarray(getattr(self, name))
            rows.append(Entry(told.head, told.shown, values))
        names = self.joint_names or numbered(len(self.rms_e))
        return by_joint("How good the run was.", names, rows, self.units)

    def __repr__(self) -> str:
        words = (f"{name}={getattr(self, name)} {UNITS[name]}" for name in self._recorded())
        return f"Metrics({', '.join(words)})"
