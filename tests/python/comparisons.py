"""Rows that the tests of comparisons share."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import steadyarm as sa
from steadyarm.comparison import Row

HOSTILE = (
    "<script>alert(1)</script>",
    "</script><!--",
    "a|b`c`*d*_e_[f](g) & \"h\" 'i' \\",
    "two\nlines\r\nand\ttab",
    "=1+1",
    "日本語 é́ \u202e right to left",
    "\x1b[31mred\x00",
    '"quoted", and, commas',
    "http://example.com/x.js",
    "x" * 500,
)
"""Names of controllers that somebody may choose."""

VALUES = (None, 0.0, -0.0, 1e-300, 5e-324, 1e300, 1.7976931348623157e308, float("inf"), 1 / 3)
"""Figures that a run may have."""


@functools.cache
def run(number: int = 3, preset: str = "claimed", **options: Any) -> sa.Run:
    """A run of one of the paper's scenes, 4 s in samples of 1 ms."""
    return sa.paper.simulation(number, preset).run(**({"duration": 4.0} | options))


def diverged() -> sa.Run:
    """A run that blows up: for this damping, the controller samples far too slowly."""
    return sa.paper.simulation(2, kv=100.0).run(duration=40.0, control_period=0.1)


def row(name: str = "fuzzy", scenario: str = "paper", seed: int = 0, **options: Any) -> Row:
    """The row of a run."""
    return Row.of(run(), controller=name, scenario=scenario, seed=seed, **options)


def rows(controllers: int, joints: int = 2) -> list[Row]:
    """Rows of so many controllers, made of noise, with curves of full length."""
    found = []
    for k in range(controllers):
        noise = np.random.default_rng(k)
        t = 0.01 * np.arange(4001)
        e = np.exp(-0.2 * t)[:, None] * np.ones(joints) / 7 + 1e-3 * noise.normal(
            size=(4001, joints)
        )
        made = functools.partial(noise.normal, size=(4001, joints))
        found.append(Row.of(fake(t, e, made(), made()), controller=f"controller {k}"))
    return found


def fake(
    t: np.ndarray, e: np.ndarray, tau: np.ndarray, q: np.ndarray, kind: str = "finished"
) -> Any:
    """A run of these signals."""
    made = sa.Run.__new__(sa.Run)
    status = sa.Status(kind, float(t[-1]), "" if kind == "finished" else "of the test")
    vars(made).update(t=t, e=e, tau=tau, q=q, status=status)
    return made
