"""How much of the simulation's own speed a window keeps: seas, bookkeeping, policies and files included.

    python -m benchmarks.window_speed [--policies trapezoid,linear] [--cells 96] [--seeds 20] [--turns 2] [--threads 2]

A part of the shipped window is run by `ssmash window`'s own code into a temporary folder. Before and after each turn
as many helicopters are advanced by `Batch.advance` alone, on as many threads: nothing but the compiled call. Speeds are
simulated seconds a second of wall time, and of CPU time; what the policies start from in common is simulated once and
counted once. The time in the policies' `act` is told apart. Ratios of one run; the machine should be idle. Steadier
than the ratio of two speeds is ``share_in_kernel``: the part of the window's own CPU time that its compiled calls take.
"""

from __future__ import annotations

import argparse
import json
import resource
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ssmash_gym.dynamics import engine
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.windows.config import WindowConfig, load_window
from ssmash_gym.windows.engines import Threads
from ssmash_gym.windows.rows import read_rows
from ssmash_gym.windows.sweep import SIZE, Sweep, prepared, run_sweep

INTERVALS = 60  # of the plain simulation, a turn


@dataclass
class Timed:
    """A policy that notes how long it thinks, in CPU seconds of its thread."""

    policy: Any
    spent_s: list[float]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.policy, name)

    def act(self, observations: Any, starts: Any = None) -> Any:
        """The policy's commands."""
        began = time.thread_time()
        commands = self.policy.act(observations, starts)
        self.spent_s.append(time.thread_time() - began)
        return commands


@contextmanager
def timed_kernel() -> Iterator[list[float]]:
    """A list that gets the CPU seconds of each compiled call, in the thread that makes it."""
    plain, spent_s = engine.advance, []

    def advance(*arguments: Any, **options: Any) -> None:
        began = time.thread_time()
        plain(*arguments, **options)
        spent_s.append(time.thread_time() - began)

    engine.advance = advance
    try:
        yield spent_s
    finally:
        engine.advance = plain


def clocks() -> tuple[float, float]:
    """Wall time and CPU time of the process [s]."""
    return time.perf_counter(), time.process_time()


def part(cells: int, seeds: int, policies: Sequence[str], spent_s: list[float]) -> Sweep:
    """Some cells of the shipped window, spread over sea states and directions."""
    whole = load_window("frigate_traverse")
    directions = np.array(whole.axes["waves_from_deg"])
    count = max(1, min(len(directions), cells // (len(whole.axes["sea_state"]))))
    chosen = directions[np.linspace(0, len(directions) - 1, count).round().astype(int)].tolist()
    document = {
        **whole.model_dump(mode="json"), "axes": {**whole.axes, "waves_from_deg": chosen, "speed_kn": [10.0]},
        "effort": {"seeds": seeds, "step": seeds, "most": seeds},
    }  # fmt: skip
    sweep = prepared(WindowConfig.model_validate(document), "benchmark", policies)
    for entrants in sweep.job.entrants.values():
        for name, one in entrants.items():
            entrants[name] = replace(one, make=lambda task, make=one.make: Timed(make(task), spent_s))
    return sweep


def simulated_s(sweep: Sweep, out: Path, policies: int) -> float:
    """Simulated seconds of a window's episodes; the common start of a sea is counted once."""
    rows = read_rows(out, ["time_s"])
    lead_in_s = sweep.job.settings["traverse"].task.lead_in.duration_s
    return float(rows["time_s"].sum()) + lead_in_s * rows.height / policies


def alone(sweep: Sweep, threads: int, count: int) -> tuple[float, float]:
    """Simulated seconds a second of wall time and of CPU time of the compiled call alone."""
    setting = sweep.job.settings["traverse"]
    core = TraverseBatch(count, task=setting.task, scenario=setting.scenario, threads=threads)
    core.reset(seeds=list(range(count)))
    commands = np.full((count, 2), [0.6, 0.0])
    core.batch.advance(commands)
    wall, cpu = clocks()
    for _ in range(INTERVALS):
        core.batch.advance(commands)
    passed, used = (after - before for after, before in zip(clocks(), (wall, cpu), strict=True))
    done = count * INTERVALS * core.control_interval_s
    return done / passed, done / used


def measured(cells: int, seeds: int, policies: Sequence[str], turns: int, threads: int) -> dict[str, Any]:
    """The figures of all turns."""
    spent_s: list[float] = []
    sweep = part(cells, seeds, policies, spent_s)
    count = min(SIZE, len(sweep.job.grid) * seeds)
    alone(sweep, threads, 64)  # compiled before anything is measured
    turned = []
    for _ in range(turns):
        before = alone(sweep, threads, count)
        spent_s.clear()
        with tempfile.TemporaryDirectory() as folder, timed_kernel() as kernel_s:
            wall, cpu = clocks()
            run_sweep(sweep, Path(folder), Threads(threads), shown=False)
            passed, used = (after - start for after, start in zip(clocks(), (wall, cpu), strict=True))
            done = simulated_s(sweep, Path(folder), len(policies))
        after = alone(sweep, threads, count)
        plain = [0.5 * (a + b) for a, b in zip(before, after, strict=True)]
        turned.append(
            {
                "wall_s": passed, "cpu_s": used, "simulated_s": done, "acting_cpu_s": sum(spent_s),
                "share_in_kernel": sum(kernel_s) / used,
                "share_in_kernel_without_acting": sum(kernel_s) / (used - sum(spent_s)),
                "window_per_wall_s": done / passed, "simulation_per_wall_s": plain[0],
                "window_per_cpu_s": done / used, "simulation_per_cpu_s": plain[1],
                "share_of_wall": done / passed / plain[0], "share_of_cpu": done / used / plain[1],
                "share_of_cpu_without_acting": done / (used - sum(spent_s)) / plain[1],
            }
        )  # fmt: skip
    episodes = len(sweep.job.grid) * seeds * len(policies)
    peak_MB = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return {
        "episodes": episodes,
        "policies": list(policies),
        "threads": threads,
        "peak_memory_MB": peak_MB,
        "turns": turned,
    }


def main(words: Sequence[str] | None = None) -> None:
    """Print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--policies", default="trapezoid,linear")
    for name, default in (("cells", 96), ("seeds", 20), ("turns", 2), ("threads", 2)):
        parser.add_argument(f"--{name}", type=int, default=default)
    given = parser.parse_args(words)
    found = measured(given.cells, given.seeds, given.policies.split(","), given.turns, given.threads)
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
