"""Curves for pages, packed: two characters a sample, so that many fit one file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ALPHABET = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_"
GAP = 4095
"""A sample that is not there; others are 0 to 4094 from the least to the largest of a curve."""

_LETTERS = np.frombuffer(ALPHABET.encode(), np.uint8)


def packed(values: Array) -> list[Any]:
    """A curve: its least and largest value, and the samples between in steps of 1/4094."""
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)
    with np.errstate(all="ignore"):
        share = (values - low) / (high - low) if high > low else 0.0 * values
    steps = np.where(np.isfinite(share), np.rint(share * (GAP - 1)), GAP).astype(int)
    letters = _LETTERS[np.stack([steps // 64, steps % 64], axis=-1)]
    return [float(f"{low:.9g}"), float(f"{high:.9g}"), letters.tobytes().decode()]
