"""Tracking control of robot arms whose dynamics nobody knows exactly.

>>> import steadyarm as sa
>>> scene = sa.paper.simulation(3, preset="claimed")
>>> run = scene.run()
>>> print(run.metrics(window=(20, 40)))

What you need is here: an `Arm` (`TwoLink`, or `Serial` for any other), a controller
(`recommended`, which tunes itself; `ComputedTorque` with or without a `FuzzyCompensator` over a
`FuzzyBasis`, whose sets `centers_for` takes from a path; or another of `laws`), a `Plant` that
`Pulses`, `Noise`, `Wrench` and curves push, `Effects` of sensors and actuators, a reference
(`Sines`, `Quintic`, `Table`, `Waypoints` or any callable), `simulate()`, and `compare()`, which
runs every controller of a `Scenario`. `design` and `learnable` say beforehand what will come of
it, `attribution` why the error of a run is what it is, `learned` what a recommended controller
knows by now. `simulate_many()` has many runs in one call, `sweep()` keeps them in a folder.
`plots` and `animation` are imported when they are first used.

Arrays may be anything that numpy understands: numbers, lists, arrays of any real type, order and
stride. They are copied, and results are new float64 arrays. Time comes first, (T, n); angles are in
radians, all else in SI units; for a prismatic joint m and N stand for rad and N·m. Where a number
may stand for a vector, it counts for every joint. Errors name the argument, what it got and what it
wants: TypeError for a wrong type, ValueError for a wrong shape or value, NaN and infinity too.

Everything pickles. Arms, plants, motions, bases and compensators are equal, with one hash, when
their arguments are; ``copy.replace(it, ...)``, or before Python 3.13 ``it.__replace__(...)``, is a
copy with other arguments. Files are replaced as a whole: a reader sees the old one or the new one.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING

from . import _extras, laws, paper
from ._core import (
    Arm,
    ComputedTorque,
    Controller,
    Effects,
    Excess,
    FuzzyApproximator,
    FuzzyBasis,
    FuzzyCompensator,
    Guard,
    Noise,
    NoStabilizingSolution,
    Plant,
    Pulses,
    Quintic,
    RiccatiSolution,
    Serial,
    Sines,
    Table,
    TwoLink,
    Waypoints,
    Wrench,
    bounded_real_riccati,
    care,
    read_scenario,
)
from ._scene import VERSION as _VERSION
from .attribution import Attribution, attribution
from .bench import Scenario, compare, scenario_names
from .centers import centers_for
from .comparison import Comparison
from .design import DesignReport, LinearModel, design
from .learnable import Learnable, learnable
from .learned import Learned, learned
from .many import Runs, simulate_many
from .metrics import Metrics
from .recommended import recommended
from .record import Certificate, Channel, GuardReport, Status
from .run import Run
from .scenario import Scene
from .simulation import DesignWarning, replay, simulate
from .sweep import LatinHypercube, Sweep, sweep

if _TYPE_CHECKING:
    from types import ModuleType

    from . import animation as animation
    from . import plots as plots

__version__ = _VERSION

_DRAWING = ("animation", "plots")
"""Modules that take matplotlib, half a second to import."""

__all__ = [
    "Arm",
    "Attribution",
    "Certificate",
    "Channel",
    "Comparison",
    "ComputedTorque",
    "Controller",
    "DesignReport",
    "DesignWarning",
    "Effects",
    "Excess",
    "FuzzyApproximator",
    "FuzzyBasis",
    "FuzzyCompensator",
    "Guard",
    "GuardReport",
    "LatinHypercube",
    "Learnable",
    "Learned",
    "LinearModel",
    "Metrics",
    "NoStabilizingSolution",
    "Noise",
    "Plant",
    "Pulses",
    "Quintic",
    "RiccatiSolution",
    "Run",
    "Runs",
    "Scenario",
    "Scene",
    "Serial",
    "Sines",
    "Status",
    "Sweep",
    "Table",
    "TwoLink",
    "Waypoints",
    "Wrench",
    "__version__",
    "attribution",
    "bounded_real_riccati",
    "care",
    "centers_for",
    "compare",
    "design",
    "laws",
    "learnable",
    "learned",
    "paper",
    "read_scenario",
    "recommended",
    "replay",
    "scenario_names",
    "simulate",
    "simulate_many",
    "sweep",
]


def __getattr__(name: str) -> "ModuleType":
    if name in _DRAWING:
        try:
            return _import_module(f"{__name__}.{name}")
        except ModuleNotFoundError as error:
            raise _extras.missing(error, f"sa.{name}") from error
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_DRAWING})
