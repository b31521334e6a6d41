"""What a newcomer waits for, how much memory a large batch takes, and what an episode costs.

`python -m benchmarks.starts` measures the last of these alone, by scenario: its start, the sea and the wind of it, and
its end.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ssmash_gym.envs.batch_env import TraverseBatch

EPISODE = 400  # control intervals of an episode, about what a success takes
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


def sea_costs_ms(
    scenario: str = "training", *, count: int = 64, intervals: int = 100, repeats: int = 3
) -> dict[str, float]:
    """Processor time of an episode of a scenario, and of its parts that draw the sea and the wind [ms].

    Starts are those of a batch, prepared several at once, on one thread. An episode is taken to last 400 control
    intervals, about what a success takes; an interval is timed with everything that the environment does, and so is
    the last one, in which an episode's metrics are gathered. Each turn has episodes of its own, as in training, so that
    nothing that an earlier turn has worked out serves again.

    Args:
        scenario: Its name.
        count: Helicopters, and starts that are timed.
        intervals: Control intervals that are timed.
        repeats: Turns; the least of each time counts.

    Returns:
        ``draw`` (all random numbers), ``deck`` (sea, ship and table), ``gusts``, ``start`` (all of these, settling and
        lead-in), ``interval``, ``end`` (by how much the last interval takes longer), ``episode`` (a start, 400
        intervals and an end).
    """
    from ssmash_gym.envs.batch_env import TraverseBatch

    env = TraverseBatch(count, scenario=scenario, threads=1, max_episode_steps=intervals + 1)
    env.reset(seeds=list(range(count)))
    env.step(np.zeros((count, 2)))
    turns = [_turn_ms(env, np.random.default_rng(k), intervals) for k in range(repeats)]
    costs = {name: min(turn[name] for turn in turns) for name in turns[0]}
    costs["end"] = costs.pop("last") - costs["interval"]
    costs["episode"] = costs["start"] + EPISODE * costs["interval"] + costs["end"]
    return {name: round(value, 3) for name, value in costs.items()}


def _turn_ms(env: TraverseBatch, rng: np.random.Generator, intervals: int) -> dict[str, float]:
    """Processor times of one start, interval and last interval of a helicopter, and of a start's parts [ms]."""
    draws = [env.scenario.sample(rng) for _ in range(env.n)]
    jobs: dict[str, Callable[[], object]] = {
        "draw": lambda: [env.scenario.sample(rng) for _ in range(env.n)],
        "deck": lambda: [env.starter.table(draw) for draw in draws],
        "gusts": lambda: [env.starter.decks.gusts(draw) for draw in draws],
        "start": env.reset,
    }
    costs = {name: _cpu_ms(job) / env.n for name, job in jobs.items()}
    steps, running = 0, np.arange(env.n)
    begin = time.process_time()
    for _ in range(intervals):
        result = env.step(np.zeros((running.size, 2)), running)
        steps += running.size
        running = running[~(result.terminated | result.truncated)]
    costs["interval"] = 1e3 * (time.process_time() - begin) / steps
    costs["last"] = _cpu_ms(lambda: env.step(np.zeros((running.size, 2)), running)) / running.size
    return costs


def _cpu_ms(job: Callable[[], object]) -> float:
    """Processor time of a call [ms]."""
    begin = time.process_time()
    job()
    return 1e3 * (time.process_time() - begin)


def main() -> None:
    """Measure and print what episodes cost: a line for each scenario, then JSON."""
    parser = argparse.ArgumentParser(description="What an episode costs, and its start, its sea and its wind.")
    parser.add_argument("scenarios", nargs="*", default=["training", "irregular", "calm"], help="names")
    parser.add_argument("--repeats", type=int, default=5, help="turns of each; the least time counts (5)")
    options = parser.parse_args()
    found = {}
    for name in options.scenarios:
        found[name] = costs = sea_costs_ms(name, repeats=options.repeats)
        sea, whole = costs["draw"] + costs["deck"] + costs["gusts"], costs["episode"]
        sys.stderr.write(
            f"{name}: an episode takes {whole:.1f} ms; its start {costs['start']:.1f} ms "
            f"({100.0 * costs['start'] / whole:.0f} %), sea and wind of it {sea:.1f} ms ({100.0 * sea / whole:.0f} %), "
            f"its end {costs['end']:.2f} ms\n"
        )
    sys.stdout.write(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
