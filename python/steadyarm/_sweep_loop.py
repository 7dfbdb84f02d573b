"""The loop of a sweep: chunks go out, rows come back and are written.

A chunk has as many rows as take ``chunk_seconds`` at the speed of those before it.
"""

from __future__ import annotations

from collections import deque
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from ._progress import Progress
from ._scene import VERSION
from ._sweep_folder import Folder
from ._sweep_plan import Plan
from ._sweep_pools import Here
from ._sweep_work import Chunk, Source

FIRST = 4
"""Rows of the first chunks, of which nothing is known yet."""

GROWTH = 8
"""A chunk has so many times the rows of a measured one at the most."""

WAIT = 0.2
"""A wait is that long at the most, for some systems tell of Ctrl-C only between waits [s]."""

LOSSES = 8
"""So often the workers of a chunk may be lost. It is half as large after each."""

SUSPECT = 2
"""After so many losses rows are computed last and alone: they may be what kills the workers."""

BARREN = 3
"""So often before any chunk came back."""

Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Sent:
    """Rows that are computed, and how often their worker was lost."""

    rows: Rows
    losses: int = 0


class Loop:
    """What is left of a sweep, what is computed, and what a row takes."""

    def __init__(
        self,
        source: Source,
        plan: Plan,
        folder: Folder,
        chunk_seconds: float,
    ) -> None:
        self.source, self.plan, self.folder = source, plan, folder
        self.left: Rows = np.flatnonzero(~folder.done(plan))
        self._seconds, self._size = chunk_seconds, FIRST
        self._begun = 0
        self._done = 0
        self._lost: deque[Sent] = deque()
        self._suspects: deque[Sent] = deque()
        self._given_up: list[tuple[Sent, BaseException]] = []
        self._flying: dict[Future[Chunk], Sent] = {}

    def run(self, workers: Here, shown: bool) -> None:
        """Compute what is left; Ctrl-C ends it. What has come back by then is kept."""
        self.workers = workers
        with Progress(len(self.left), "rows", shown=shown) as bar:
            try:
                while self._send() or self._flying:
                    done, _ = wait(self._flying, WAIT, return_when=FIRST_COMPLETED)
                    for future in done:
                        self._take(future)
                    bar.to(self._done)
            except KeyboardInterrupt:
                self._stop()
            except Exception:
                self._stop()
                raise
            bar.to(self._done)
        if self._given_up:
            sent, error = self._given_up[0]
            count = sum(len(it.rows) for it, _ in self._given_up)
            raise RuntimeError(
                f"sweep: {count} rows are missing (row {sent.rows[0]} is the first): their workers "
                f"were lost {sent.losses} times, killed or out of memory; all others are written, "
                "and another call tries again"
            ) from error

    def _send(self) -> bool:
        """Send chunks until all workers have enough to do; whether there was one to send."""
        sent = False
        while len(self._flying) < self.workers.ahead and (chunk := self._next()) is not None:
            future = self.workers.submit(self.source, self.plan.points(chunk.rows))
            self._flying[future] = chunk
            sent = True
        return sent

    def _next(self) -> Sent | None:
        if self._lost:
            return self._lost.popleft()
        left = len(self.left) - self._begun
        if left == 0:
            return self._suspects.popleft() if self._suspects and not self._flying else None
        # In the end all workers have a share of what is left.
        size = min(self._size, ceil(left / self.workers.count))
        rows = self.left[self._begun : self._begun + size]
        self._begun += size
        return Sent(rows)

    def _take(self, future: Future[Chunk]) -> None:
        sent = self._flying.pop(future)
        try:
            chunk = future.result()
        except Exception as error:
            if not self.workers.lost(error):
                raise
            self._again(sent, error)
            return
        if chunk.version != VERSION:
            raise RuntimeError(
                f"executor: a worker has steadyarm {chunk.version}, wants {VERSION} as here"
            )
        each = chunk.seconds / len(sent.rows)
        wanted = self._seconds / max(each, 1e-9)
        self._size = max(1, min(int(wanted), GROWTH * len(sent.rows)))
        self._write(sent.rows, chunk)

    def _write(self, rows: Rows, chunk: Chunk) -> None:
        """Write rows but those that Ctrl-C ended, and then stop."""
        whole = np.array([status != "interrupted" for status in chunk.columns["status"]])
        rows = rows[whole]
        if len(rows):
            inputs = {"index": rows, **self.plan.columns(rows)}
            kept = {
                name: [value for value, keep in zip(values, whole, strict=True) if keep]
                for name, values in chunk.columns.items()
            }
            version = {"version": [VERSION] * len(rows)}
            self.folder.write({**inputs, **kept, **version}, chunk.units)
            self._done += len(rows)
        if not whole.all():
            raise KeyboardInterrupt

    def _again(self, sent: Sent, error: BaseException) -> None:
        """Ask again for rows whose worker was lost, or give them up."""
        losses = sent.losses + 1
        if losses == BARREN and not self._done:
            raise RuntimeError(
                f"executor: no row came back, and workers were lost {losses} times; is there "
                '`if __name__ == "__main__":` in the script, and enough memory?'
            ) from error
        if losses == LOSSES:
            self._given_up.append((Sent(sent.rows, losses), error))
            return
        halves = np.array_split(sent.rows, 2) if len(sent.rows) > 1 else [sent.rows]
        again = self._lost if losses < SUSPECT else self._suspects
        again.extend(Sent(rows, losses) for rows in halves)

    def _stop(self) -> None:
        """Take what has come back, and no more."""
        for future in list(self._flying):
            if future.done() and not future.cancelled() and future.exception() is None:
                try:
                    self._take(future)
                except KeyboardInterrupt:
                    continue
            self.workers.drop(future)
