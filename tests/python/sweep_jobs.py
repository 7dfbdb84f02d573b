"""What the tests of sweeps compute: functions that workers can import."""

from __future__ import annotations

import os
import signal
import sys
import time
from typing import Any

import numpy as np
import steadyarm as sa

ARM = sa.TwoLink(4.0, 0.5, 0.2)
PATH = sa.Sines(2.0, sin=(0.3, 0.2))


def product(a: float, b: float, seed: int = 0) -> dict[str, Any]:
    """Figures, which no seed changes; three is bad."""
    if a == 3:
        raise ValueError("three is bad")
    return {"product": a * b, "word": f"{a}"} | ({"even": a % 2 == 0} if a > 3 else {})


def arguments(scale: float, kp: float, seed: int) -> dict[str, Any]:
    """Arguments of `simulate`. Some gains are refused, some runs blow up."""
    plant = sa.Plant(ARM.__replace__(mass=4.0 * scale))
    return {
        "plant": plant,
        "tracker": sa.ComputedTorque(ARM, kp=kp, kv=5.5),
        "reference": PATH,
        "duration": 0.1 if kp < 10 else 0.2,
        "control_period": 1e-3,
        "q0": (0.1 * scale, 0.0),
        "effects": sa.Effects(noise=1e-4, seed=seed),
        "window": (0.05, 0.1),
    }


def total(a: float, b: float) -> dict[str, float]:
    """Another figure of the same inputs."""
    return {"total": a + b}


def slow(number: int) -> dict[str, float]:
    """A fiftieth of a second."""
    time.sleep(0.02)
    return {"square": float(number) ** 2}


def fatal(number: int) -> dict[str, float]:
    """One of them ends its process; it is not among the first chunks."""
    if number == 25:
        os._exit(1)
    return slow(number)


def stopped(number: int) -> dict[str, float]:
    """Ctrl-C in the middle of it, which a simulation takes for itself."""
    if number == 5:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            return {"square": -1.0}
    return {"square": float(number) ** 2}


def of_two(left: float, right: str) -> dict[str, float]:
    """Fails for some."""
    if left > 3 and right == "b":
        raise ValueError("too far")
    return {"error": 10.0**left}


def by_word(number: float, word: str, seed: int) -> dict[str, float]:
    """Far larger for one of the words."""
    return {"error": number + seed + (100.0 if word == "b" else 0.0)}


def named(word: Any) -> dict[str, Any]:
    """A figure, whatever the input."""
    return {"y": 1.0}


def constant() -> dict[str, Any]:
    """The same without inputs."""
    return {"y": 1.0}


def said(place: int) -> dict[str, Any]:
    """Words of its own for the status, two of which no row can have."""
    return {"status": ("\ud800", "interrupted", "well")[place]}


def windowed(begin: float) -> dict[str, Any]:
    """A run whose figures begin so late."""
    tracker = sa.ComputedTorque(ARM, kp=8.0, kv=5.5)
    made = {"plant": sa.Plant(ARM), "tracker": tracker, "reference": PATH, "duration": 0.1}
    return made | {"q0": (0.1, 0.0), "window": np.array([begin, 0.1])}


def misnamed(rms_e_1: float) -> dict[str, Any]:
    """A run that has a figure of the name of its input."""
    return windowed(0.0)


def leaving(row: int) -> dict[str, Any]:
    """A row, but for the second, which wants to leave."""
    if row == 1:
        sys.exit(3)
    return {"row_again": row}
