"""Tracking control of robot arms whose dynamics nobody knows exactly.

>>> import steadyarm as sa
>>> scene = sa.paper.simulation(3, preset="claimed")
>>> run = scene.run()
>>> print(run.metrics(window=(20, 40)))

What you need is here: an arm (`TwoLink`, or `Serial` for any other), a controller
(`ComputedTorque`) with or without a `FuzzyCompensator` over a `FuzzyBasis`, a `Plant`, a reference
(`Sines`, `Quintic`, `Table` or any callable), `simulate()`, and the Riccati equations
(`bounded_real_riccati`, `care`).
"""

from importlib.metadata import version as _version

from . import paper
from ._core import (
    ComputedTorque,
    Excess,
    FuzzyApproximator,
    FuzzyBasis,
    FuzzyCompensator,
    NoStabilizingSolution,
    Plant,
    Quintic,
    RiccatiSolution,
    Serial,
    Sines,
    Table,
    TwoLink,
    bounded_real_riccati,
    care,
)
from .design import DesignReport, design
from .run import Certificate, Metrics, Run, Status
from .simulation import simulate

__version__ = _version("steadyarm")

__all__ = [
    "Certificate",
    "ComputedTorque",
    "DesignReport",
    "Excess",
    "FuzzyApproximator",
    "FuzzyBasis",
    "FuzzyCompensator",
    "Metrics",
    "NoStabilizingSolution",
    "Plant",
    "Quintic",
    "RiccatiSolution",
    "Run",
    "Serial",
    "Sines",
    "Status",
    "Table",
    "TwoLink",
    "__version__",
    "bounded_real_riccati",
    "care",
    "design",
    "paper",
    "simulate",
]
