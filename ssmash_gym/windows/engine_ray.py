"""Runs the chunks of a window on Ray, on this machine or on a cluster (extra ``distributed``).

A task is a chunk. Ray runs it again elsewhere when its worker or its node dies, and a chunk that has been given back is
on disk: nothing is lost but what was under way. The rows are those of the threads, bit for bit.
"""

from __future__ import annotations

import functools
import os
import socket
from collections.abc import Callable, Sequence
from typing import Any, Final

import polars as pl

from ssmash_gym.dynamics.engine import available_threads
from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.windows.chunks import Chunk, Job, Worker
from ssmash_gym.windows.engines import Done, Steps

RETRIES: Final = 20  # of a chunk whose worker or node has died
ANSWER_S: Final = 5.0  # within which a cluster must answer
POLL_S: Final = 1.0  # between two looks at what is done


class Ray:
    """Workers of a Ray cluster, one core each.

    Args:
        address: Of a running cluster, as `ray.init` takes it; None starts one on this machine, or takes the one that
            this process is connected to already.
        workers: Cores of the cluster that is started; None: all of this machine.

    Raises:
        ConfigurationError: There is no cluster at the address.
        ImportError: Ray is missing; the sentence names the extra.
    """

    def __init__(self, address: str | None = None, workers: int | None = None) -> None:
        require("ray", 'the engine ray needs Ray: pip install "ssmash_gym[distributed]".')
        import ray

        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        address = address or os.environ.get("RAY_ADDRESS") or None  # as within a submitted job
        if address is not None and workers is not None:
            raise ConfigurationError(
                f"--threads {workers} is refused with a cluster at {address}: it has its own cores."
            )
        if address is not None:
            _refuse_unreachable(address)
        if not ray.is_initialized():
            options: dict[str, Any] = {"log_to_driver": False, "logging_level": "error"}
            if address is None:
                options |= {"num_cpus": workers or available_threads(), "include_dashboard": False}
            try:
                ray.init(address=address, **options)
            except (ConnectionError, ValueError, RuntimeError) as error:
                told = str(error).strip().splitlines()[0]
                raise ConfigurationError(f"--address {address} is refused: {told}") from None
        self._ray = ray

    @property
    def workers(self) -> int:
        """Cores of the cluster."""
        return max(1, int(self._ray.cluster_resources().get("CPU", 1)))  # type: ignore[no-untyped-call]

    def run(self, job: Job, chunks: Sequence[Chunk], tell: Steps) -> Done:
        """Run chunks; each is given back as soon as it is done. Leaving early cancels those under way."""
        ray = self._ray
        shared = ray.put(job)
        task: Callable[..., Any] = ray.remote(num_cpus=1, max_retries=RETRIES)(_work).remote
        waiting = {task(shared, chunk): chunk for chunk in chunks}
        try:
            while waiting:
                for done in ray.wait(list(waiting), timeout=POLL_S)[0]:
                    chunk = waiting.pop(done)
                    rows: pl.DataFrame = ray.get(done)
                    tell(job.most_steps(chunk))  # workers do not tell how far they are
                    yield chunk, rows
        finally:
            for left in waiting:
                ray.cancel(left, force=True)


def _refuse_unreachable(address: str) -> None:
    """Refuse an address at which nobody answers: Ray itself would try for minutes.

    Raises:
        ConfigurationError: It is neither ``auto`` nor ``host:port``, or nobody listens there.
    """
    if address in ("auto", "local"):
        return
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not host or not port.isdigit():
        raise ConfigurationError(f"--address {address} is refused: give host:port of a running cluster, or auto.")
    try:
        socket.create_connection((host.strip("[]"), int(port)), ANSWER_S).close()
    except (OSError, OverflowError) as error:
        raise ConfigurationError(f"--address {address} is refused: no cluster answers there ({error}).") from None


def _work(job: Job, chunk: Chunk) -> pl.DataFrame:
    """Run one chunk in a process of the cluster."""
    return _worker(job).run(chunk)


@functools.lru_cache(maxsize=1)
def _worker(job: Job) -> Worker:
    """The helicopters of a process, which serve all chunks of a window that it gets."""
    return Worker(job)
