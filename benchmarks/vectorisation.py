"""The native batch beside Stable-Baselines3's own vectorisation: `python -m benchmarks.vectorisation`.

The same work for each: the same seeds, the same commands, the same observations at the end (that is checked), with the
starts of episodes that fall into it. `DummyVecEnv` steps single environments one after the other in one process,
`SubprocVecEnv` has a process for each; the native batch advances all of them in one call. Turns alternate; the best
turn of each counts, for other work on the machine can only make a turn slower.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from typing import Any, Final

import gymnasium
import numpy as np
from rich.console import Console
from rich.table import Table

NATIVE: Final = "native"
KINDS: Final = (NATIVE, "dummy", "subproc")


def single(scenario: str) -> Callable[[], Any]:
    """Makes the single environment, in this process or in another."""

    def make() -> Any:
        return gymnasium.make("ssmash_gym:ssmash/Traverse-v0", scenario=scenario, threads=1)

    return make


def environment(kind: str, count: int, scenario: str, threads: int) -> Any:
    """One of the three, with `count` helicopters."""
    from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

    from ssmash_gym.envs.sb3 import TraverseVecEnv

    if kind == NATIVE:
        return TraverseVecEnv(count, scenario=scenario, threads=threads)
    makers = [single(scenario) for _ in range(count)]
    return SubprocVecEnv(makers) if kind == "subproc" else DummyVecEnv(makers)


def turn(env: Any, commands: np.ndarray, seed: int) -> tuple[float, float, np.ndarray, int]:
    """One turn over the commands (steps, count, 2).

    Returns:
        Wall time of the steps [s], without the first starts; processor time of this process' threads [s]; the last
        observation; how many episodes ended.
    """
    env.seed(seed)
    env.reset()
    ended, seen = 0, np.zeros(0)
    begin, busy = time.perf_counter(), time.process_time()
    for command in commands:
        seen, _, dones, _ = env.step(command)
        ended += int(np.sum(dones))
    return time.perf_counter() - begin, time.process_time() - busy, seen, ended


def measure(count: int, steps: int, repeats: int, *, kinds: tuple[str, ...] = KINDS, scenario: str = "training",
            threads: int = 2) -> dict[str, Any]:  # fmt: skip
    """Time the kinds in alternation.

    Args:
        count: Helicopters.
        steps: Control intervals of a turn.
        repeats: Turns of each.
        kinds: Which.
        scenario: Name of the scenario.
        threads: Threads of the native batch.

    Returns:
        For each kind ``steps_per_s`` (control intervals of all helicopters together, best turn),
        ``native_is_times_as_fast`` (of the first kind's rate) and ``cpu_us_per_step`` (processor time of all threads,
        None where other processes do the work), and ``same`` (whether the last observations are equal, bit for bit).
    """
    environments = {kind: environment(kind, count, scenario, threads) for kind in kinds}
    noise = np.random.default_rng(0).normal(0.0, 0.1, (steps, count, 2))
    commands = np.clip(np.array([0.6, 0.0]) + noise, -1.0, 1.0).astype(np.float32)
    best, least, last, ended = dict.fromkeys(kinds, np.inf), dict.fromkeys(kinds, np.inf), {}, 0
    for env in environments.values():
        turn(env, commands[:2], 0)
    for number in range(repeats):
        for kind, env in environments.items():
            wall_s, cpu_s, last[kind], ended = turn(env, commands, 1000 * number)
            best[kind], least[kind] = min(best[kind], wall_s), min(least[kind], cpu_s)
    for env in environments.values():
        env.close()
    return {
        "count": count,
        "steps": steps,
        "episodes_ended": ended,
        "same": all(np.array_equal(last[kind], last[kinds[0]]) for kind in kinds),
        "kinds": {
            kind: {
                "steps_per_s": round(count * steps / best[kind], 1),
                "native_is_times_as_fast": round(best[kind] / best[kinds[0]], 2),
                "cpu_us_per_step": None if kind == "subproc" else round(1e6 * least[kind] / count / steps, 1),
            }
            for kind in kinds
        },
    }  # fmt: skip


def main() -> None:
    """Measure and print a table, then JSON."""
    parser = argparse.ArgumentParser(description="The native batch beside SB3's vectorisation of single environments.")
    parser.add_argument("--counts", type=int, nargs="*", default=[16, 64], help="helicopters (16 64)")
    parser.add_argument("--steps", type=int, default=400, help="control intervals of a turn (400)")
    parser.add_argument("--repeats", type=int, default=3, help="turns of each; the best counts (3)")
    parser.add_argument("--most-processes", type=int, default=16, help="SubprocVecEnv up to so many (16)")
    options = parser.parse_args()
    found = []
    for count in options.counts:
        kinds = KINDS if count <= options.most_processes else KINDS[:2]
        found.append(measure(count, options.steps, options.repeats, kinds=kinds))
    table = Table("helicopters", "kind", "steps a second", "native is ... times as fast", "processor us", "same")
    for figures in found:
        for kind, one in figures["kinds"].items():
            ratio = "" if kind == NATIVE else f"{one['native_is_times_as_fast']:.1f}"
            busy = "" if one["cpu_us_per_step"] is None else f"{one['cpu_us_per_step']:.0f}"
            table.add_row(str(figures["count"]), kind, f"{one['steps_per_s']:.0f}", ratio, busy, str(figures["same"]))
    Console(stderr=True).print(table)
    sys.stdout.write(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
