"""What runs the chunks: threads of this process, or Ray. The rows are the same, bit for bit."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from typing import Protocol

import polars as pl

from ssmash_gym.dynamics.engine import available_threads
from ssmash_gym.windows.chunks import Chunk, Job, Worker

Steps = Callable[[int], None]  # told how many control intervals have been simulated since the last time
Done = Iterator[tuple[Chunk, pl.DataFrame]]


class Engine(Protocol):
    """Runs chunks of a window."""

    @property
    def workers(self) -> int:
        """How many chunks it runs at once."""

    def run(self, job: Job, chunks: Sequence[Chunk], tell: Steps) -> Done:
        """Run chunks; each is given back as soon as it is done, in any order."""


class Stopped(Exception):
    """A worker was asked to stop in the middle of a chunk."""


class Threads:
    """Threads of this process: each with helicopters of its own, in compiled code without the interpreter's lock.

    Args:
        workers: How many; None: one a core.
    """

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or available_threads()
        self._own = threading.local()
        self._pool = ThreadPoolExecutor(self.workers, thread_name_prefix="ssmash-window")

    def run(self, job: Job, chunks: Sequence[Chunk], tell: Steps) -> Done:
        """Run chunks; each is given back as soon as it is done. Leaving early stops the workers at once."""
        stop = threading.Event()
        lock = threading.Lock()

        def told(steps: int) -> None:
            if stop.is_set():
                raise Stopped
            with lock:
                tell(steps)

        waiting = {self._pool.submit(self._work, job, chunk, told): chunk for chunk in chunks}
        try:
            while waiting:
                for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                    yield waiting.pop(future), future.result()
        finally:
            stop.set()
            for future in waiting:
                future.cancel()
            wait(waiting)

    def _work(self, job: Job, chunk: Chunk, tell: Steps) -> pl.DataFrame:
        if getattr(self._own, "job", None) is not job:
            self._own.job, self._own.worker = job, Worker(job)
        worker: Worker = self._own.worker
        return worker.run(chunk, tell)
