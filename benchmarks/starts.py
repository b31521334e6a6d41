"""What a newcomer waits for, how much memory a large batch takes, and what a new sea costs at each episode's start."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
FIRST_STEP = "from benchmarks.scenario import Traverse; Traverse('generic_tricycle', 1).advance(1)"
MEMORY = """
import json, resource
from benchmarks.scenario import Traverse
import sys
traverse = Traverse('generic_tricycle', int(sys.argv[1]))
traverse.advance(3)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps(peak / 2**10 if sys.platform != 'darwin' else peak / 2**20))
"""


def _run(code: str, *arguments: str, cache: str | None = None) -> str:
    """Run code in a fresh process; what it prints."""
    environment = os.environ | ({"SSMASH_CACHE_DIR": cache} if cache else {})
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True).stdout


def start_times_s() -> dict[str, float]:
    """Wall time of a whole process that imports the package, settles one helicopter and makes one step."""
    times = {}
    with tempfile.TemporaryDirectory() as cache:
        for name in ("cold", "cached"):
            start = time.perf_counter()
            _run(FIRST_STEP, cache=cache)
            times[name] = round(time.perf_counter() - start, 2)
    return times


def peak_memory_mb(count: int) -> float:
    """Greatest resident memory [MiB] of a process that holds `count` helicopters and advances them."""
    return round(float(json.loads(_run(MEMORY, str(count)))), 0)


def sea_costs_ms(count: int = 64, intervals: int = 100) -> dict[str, float]:
    """Processor time of an episode of the training scenario, and of its parts that draw the sea and the wind [ms].

    Starts are those of a batch, prepared several at once, on one thread. An episode is taken to last 400 control
    intervals, about what a success takes; the interval is timed with everything that the environment does.

    Args:
        count: Helicopters, and starts that are timed.
        intervals: Control intervals that are timed.

    Returns:
        ``draw`` (all random numbers), ``deck`` (sea, ship and table), ``gusts``, ``start`` (all of these, settling and
        lead-in), ``episode`` (a start and 400 intervals).
    """
    from ssmash_gym.envs.batch_env import TraverseBatch

    env = TraverseBatch(count, scenario="training", threads=1)
    env.reset(seeds=list(range(count)))
    env.step(np.zeros((count, 2)))
    rng = np.random.default_rng(0)
    draws = [env.scenario.sample(rng) for _ in range(count)]
    jobs: dict[str, Callable[[], object]] = {
        "draw": lambda: [env.scenario.sample(rng) for _ in range(count)],
        "deck": lambda: [env.starter.table(draw) for draw in draws],
        "gusts": lambda: [env.starter.decks.gusts(draw) for draw in draws],
        "start": lambda: env.reset(draws=draws),
    }
    costs = {name: _cpu_ms(job) / count for name, job in jobs.items()}
    steps, running = 0, np.arange(count)
    begin = time.process_time()
    for _ in range(intervals):
        result = env.step(np.zeros((running.size, 2)), running)
        steps += running.size
        running = running[~(result.terminated | result.truncated)]
    interval = 1e3 * (time.process_time() - begin) / steps
    return {name: round(value, 2) for name, value in {**costs, "episode": costs["start"] + 400 * interval}.items()}


def _cpu_ms(job: Callable[[], object]) -> float:
    """Processor time of a call [ms]."""
    begin = time.process_time()
    job()
    return 1e3 * (time.process_time() - begin)
