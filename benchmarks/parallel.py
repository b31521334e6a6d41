"""Two threads of one batch against two independent processes, on the wall clock."""

from __future__ import annotations

import multiprocessing
import time
from multiprocessing.synchronize import Barrier

from benchmarks.scenario import Traverse
from benchmarks.timing import wall_rate


def two_threads(helicopter: str, count: int, intervals: int) -> float:
    """Simulated seconds per second on the wall clock of one batch on two threads."""
    traverse = Traverse(helicopter, count, threads=2)
    traverse.advance(2)
    return wall_rate(lambda: traverse.advance(intervals))


def _process(helicopter: str, count: int, intervals: int, barrier: Barrier, results: multiprocessing.Queue) -> None:
    traverse = Traverse(helicopter, count)
    traverse.advance(2)
    barrier.wait()
    start = time.monotonic()
    simulated_s = traverse.advance(intervals)
    results.put((start, time.monotonic(), simulated_s))


def two_processes(helicopter: str, count: int, intervals: int) -> float:
    """The same of two processes that know nothing of each other, each with half of the helicopters."""
    context = multiprocessing.get_context("spawn")
    barrier, results = context.Barrier(2), context.Queue()
    arguments = (helicopter, count // 2, intervals, barrier, results)
    processes = [context.Process(target=_process, args=arguments) for _ in range(2)]
    for process in processes:
        process.start()
    spans = [results.get(timeout=300.0) for _ in processes]
    for process in processes:
        process.join()
    first, last = min(start for start, _, _ in spans), max(end for _, end, _ in spans)
    return sum(simulated_s for _, _, simulated_s in spans) / (last - first)
