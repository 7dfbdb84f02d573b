"""How far long work is: one line on standard error, which is written over."""

from __future__ import annotations

import sys
import time
from types import TracebackType

WIDTH = 24
"""Characters of the bar."""

PAUSE = 0.1
"""Between two writings of the line [s]."""


class Progress:
    """A bar over ``total`` of a ``unit``, with the time that it took and an estimate of the rest.

    >>> with Progress(40, "runs") as progress:
    ...     progress.to(12)
    """

    def __init__(self, total: float, unit: str, shown: bool = True) -> None:
        self.done = 0.0
        self._total, self._unit, self._shown = total, unit, shown
        self._start, self._next = time.monotonic(), 0.0

    def __enter__(self) -> Progress:
        self.to(0.0)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        if self._shown:
            sys.stderr.write(f"\r{self.line()}\n")
            sys.stderr.flush()

    def to(self, done: float) -> None:
        """Say how much of the total is done."""
        self.done = done
        now = time.monotonic()
        if self._shown and now >= self._next:
            self._next = now + PAUSE
            sys.stderr.write(f"\r{self.line()}")
            sys.stderr.flush()

    def line(self) -> str:
        """The line: share, bar, done and total, time gone and left."""
        share = min(1.0, self.done / self._total) if self._total > 0 else 1.0
        bar = ("█" * round(WIDTH * share)).ljust(WIDTH, "·")
        gone = time.monotonic() - self._start
        left = f", {_clock(gone * (1 / share - 1))} left" if 0 < share < 1 else ""
        amount = f"{self.done:.6g} of {self._total:.6g} {self._unit}"
        return f"{100 * share:3.0f} % {bar} {amount}, {_clock(gone)}{left}".ljust(78)


def _clock(seconds: float) -> str:
    """A time as 4:05 or 1:02:03."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
