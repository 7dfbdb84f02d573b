"""Ctrl-C for simulations in threads: Python tells the main thread alone of it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_LOCAL = threading.local()


@contextmanager
def stopped_by(event: threading.Event) -> Iterator[None]:
    """Let simulations of this thread end, "interrupted", once the event is set."""
    _LOCAL.event = event
    try:
        yield
    finally:
        del _LOCAL.event


def poll() -> Callable[[float], None] | None:
    """What the core is to call now and then in this thread, with the time; None for nothing."""
    event: threading.Event | None = getattr(_LOCAL, "event", None)
    if event is None:
        return None

    def look(t: float) -> None:
        if event.is_set():
            raise KeyboardInterrupt

    return look
