"""Who computes the rows of a sweep: this process, an executor, Dask or Ray.

All of them give futures of `concurrent.futures`, and start again what a lost worker was at as far
as they can; where a future ends with a lost worker all the same, the sweep asks again.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from functools import partial
from typing import Any

from ._extras import imported
from ._sweep_work import Chunk, Row, Source, computed
from .compare_runner import threads_of

WANTS = (
    'None, "processes", "dask", "dask://host:port", "ray", an executor of concurrent.futures, or a '
    "client of Dask"
)

RESUMES = "call again, it goes on from the rows that are written"


class Here:
    """This process, with the threads of `simulate_many`."""

    count = 1
    """How many chunks are computed at a time."""
    ahead = 1
    """How many are sent at the most, so that no worker waits."""

    def submit(self, source: Source, points: list[Row]) -> Future[Chunk]:
        """Have a chunk computed."""
        future: Future[Chunk] = Future()
        future.set_result(computed(source, points, None))
        return future

    def lost(self, error: BaseException) -> bool:
        """Whether a future ended so because a worker was lost, and it can be asked again."""
        return False

    def drop(self, future: Future[Chunk]) -> None:
        """Have a chunk not computed, if it can be, before all is closed."""
        future.cancel()

    def close(self) -> None:
        """End what was started for the sweep, without waiting for what it is at."""


class Pool(Here):
    """An executor of `concurrent.futures`, of the user's."""

    def __init__(self, executor: Executor, count: int | None = None) -> None:
        self.executor = executor
        self.count = count or getattr(executor, "_max_workers", None) or _cores()
        self.ahead = 2 * self.count

    def submit(self, source: Source, points: list[Row]) -> Future[Chunk]:
        """Have a chunk computed by one thread of a worker."""
        try:
            return self.executor.submit(computed, source, points, 1)
        except Exception as error:
            self.lost(error)  # says what to do where it is clear
            raise

    def lost(self, error: BaseException) -> bool:
        """A broken pool stays broken."""
        if isinstance(error, BrokenExecutor):
            raise RuntimeError(
                f"executor: it broke ({error}); {RESUMES}, with a new executor, or with "
                'executor="processes", which starts lost workers again'
            ) from error
        return False


class Processes(Pool):
    """Processes of the sweep's own: one a core, and new ones where one is lost."""

    def __init__(self) -> None:
        super().__init__(self._made())

    @staticmethod
    def _made() -> ProcessPoolExecutor:
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(_cores(), context, initializer=_begin)

    def submit(self, source: Source, points: list[Row]) -> Future[Chunk]:
        """Have a chunk computed; a pool that broke since the last one is made anew."""
        try:
            return super().submit(source, points)
        except BrokenExecutor:
            self.close()
            self.executor = self._made()
            return super().submit(source, points)

    def lost(self, error: BaseException) -> bool:
        """Whether a worker died."""
        return isinstance(error, BrokenExecutor)

    def drop(self, future: Future[Chunk]) -> None:
        """Leave it to `close`: the pool tells futures that their process ended, and some Pythons
        print an error where one was cancelled."""

    def close(self) -> None:
        """End the processes."""
        processes = list((getattr(self.executor, "_processes", None) or {}).values())
        self.executor.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()


def _begin() -> None:
    """A process leaves Ctrl-C to the client, and ends when the client does, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    client = multiprocessing.parent_process()

    def watch() -> None:
        assert client is not None
        client.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


class Dask(Pool):
    """A client of Dask, whose scheduler gives what a lost worker was at to another."""

    def __init__(self, client: Any) -> None:
        self.client = client
        threads = sum(client.nthreads().values())
        super().__init__(client.get_executor(pure=False), max(1, threads))

    def lost(self, error: BaseException) -> bool:
        """Whether Dask gave a chunk up because its workers died."""
        if self.client.status != "running":
            raise RuntimeError(f"executor: Dask's scheduler is gone; {RESUMES}") from error
        killed = imported("distributed", "executor").KilledWorker
        return isinstance(error, killed | CancelledError)


class OwnDask(Dask):
    """A cluster of this machine, or a client of one elsewhere, for this sweep."""

    def __init__(self, address: str | None) -> None:
        distributed = imported("distributed", 'executor="dask"')
        self.cluster = None
        if address is None:
            self.cluster = distributed.LocalCluster(
                n_workers=_cores(), threads_per_worker=1, dashboard_address=None
            )
        super().__init__(distributed.Client(self.cluster or address))

    def close(self) -> None:
        """End the client, and the cluster."""
        self.client.close()
        if self.cluster is not None:
            self.cluster.close()


class Ray(Pool):
    """Ray, which gives what a lost worker was at to another."""

    RETRIES = 5

    def __init__(self) -> None:
        self.ray = imported("ray", 'executor="ray"')
        self.own = not self.ray.is_initialized()
        if self.own:
            self.ray.init(include_dashboard=False, log_to_driver=False, logging_level="ERROR")
        self.remote = self.ray.remote(max_retries=self.RETRIES)(computed)
        self.count = max(1, int(self.ray.cluster_resources().get("CPU", 1)))
        self.ahead = 2 * self.count

    def submit(self, source: Source, points: list[Row]) -> Future[Chunk]:
        """Have a chunk computed."""
        future: Future[Chunk] = self.remote.remote(source, points, 1).future()
        return future

    def lost(self, error: BaseException) -> bool:
        """Whether Ray gave a chunk up because its workers died."""
        errors = self.ray.exceptions
        return isinstance(error, errors.RayError) and not isinstance(error, errors.RayTaskError)

    def close(self) -> None:
        """End Ray, if it was started for this sweep."""
        if self.own:
            self.ray.shutdown()


def workers_of(executor: Any, source: Source) -> Callable[[], Here]:
    """What starts the workers that ``executor`` stands for. Raises ValueError if it is none."""
    if executor is None:
        return Here
    if isinstance(executor, str):
        if executor == "processes":
            _check_sent(source)
            return Processes
        if executor == "dask":
            return partial(OwnDask, None)
        if executor.startswith("dask://") and len(executor) > len("dask://"):
            return partial(OwnDask, f"tcp://{executor.removeprefix('dask://')}")
        if executor == "ray":
            return Ray
    if isinstance(executor, Executor):
        if isinstance(executor, ProcessPoolExecutor):
            _check_sent(source)
        return partial(Pool, executor)
    if hasattr(executor, "get_executor") and hasattr(executor, "nthreads"):
        return partial(Dask, executor)
    raise ValueError(f"executor: got {executor!r:.80}, wants {WANTS}")


def _check_sent(source: Source) -> None:
    """Refuse a function that processes cannot import."""
    function = getattr(source, "function", None)
    module = getattr(function, "__module__", None)
    wants = (
        "wants a function at the top of a module, which processes import by its name; Dask and Ray "
        "take any"
    )
    if module == "__main__" and not hasattr(sys.modules["__main__"], "__file__"):
        raise ValueError(f"executor: got processes for {function!r:.80} of a notebook; {wants}")
    try:
        pickle.dumps(source)
    except Exception as error:
        raise ValueError(
            f"executor: got processes for {function!r:.80} ({error}); {wants}"
        ) from error


def _cores() -> int:
    """Cores that this process may use."""
    return threads_of("executor", None)
