"""Where the time of a training goes: `python -m benchmarks.training_time [CONFIG] [--updates 24] [--set key=value]`.

Runs the training as `train.py` does, with its callbacks and logs, for some updates, and stops the time of its parts. A
part's time does not contain that of the parts inside it, so the parts add up to the whole. Wall time is what one waits
for; processor time is that of all threads, and says the same on a machine that is busy with other work.
"""

from __future__ import annotations

import argparse
import functools
import json
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Final
from unittest import mock

from rich.console import Console
from rich.table import Table

PARTS: Final = {
    "simulation": "the engine, between two commands",
    "environment": "observation, reward, costs, limits, metrics",
    "seas": "starts of episodes: draws, seas and gusts, settling",
    "lead-in": "starts of episodes: the engine, while the sea comes up",
    "policy": "commands and values for the helicopters",
    "learning": "gradient steps",
    "rest": "buffers, normalisation, callbacks, logs, checkpoints",
}


class Stopwatch:
    """Time of nested parts, each without those inside it.

    Attributes:
        wall_s, cpu_s: By part [s]; processor time is that of all threads.
    """

    def __init__(self) -> None:
        self.wall_s = dict.fromkeys(PARTS, 0.0)
        self.cpu_s = dict.fromkeys(PARTS, 0.0)
        self._stack: list[str] = []
        self._since = (0.0, 0.0)

    def _note(self) -> None:
        now = time.perf_counter(), time.process_time()
        if self._stack:
            self.wall_s[self._stack[-1]] += now[0] - self._since[0]
            self.cpu_s[self._stack[-1]] += now[1] - self._since[1]
        self._since = now

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Time of the block goes to a part; the engine's during a start is the lead-in's."""
        self._note()
        self._stack.append("lead-in" if name == "simulation" and "seas" in self._stack else name)
        try:
            yield
        finally:
            self._note()
            self._stack.pop()

    @contextmanager
    def watching(self, places: Sequence[tuple[Any, str, str]]) -> Iterator[None]:
        """Stop the time of methods (class, name, part) while the block runs."""
        with ExitStack() as stack:
            for owner, name, part in places:
                stack.enter_context(mock.patch.object(owner, name, self._watched(getattr(owner, name), part)))
            yield

    def _watched(self, function: Any, part: str) -> Any:
        @functools.wraps(function)
        def call(*values: Any, **options: Any) -> Any:
            if part != "rest" and not self._stack:  # before or after the training
                return function(*values, **options)
            with self.part(part):
                return function(*values, **options)

        return call


def places(algorithm: str) -> list[tuple[Any, str, str]]:
    """Methods whose time is stopped: (class, name, part)."""
    from stable_baselines3 import PPO, SAC
    from stable_baselines3.common.policies import ActorCriticPolicy

    from ssmash_gym.envs.batch_env import TraverseBatch
    from ssmash_gym.envs.scenario import ScenarioConfig
    from ssmash_gym.envs.starts import Starter
    from ssmash_gym.simulation.batch import Batch

    found: list[tuple[Any, str, str]] = [
        (TraverseBatch, "step", "environment"),
        (TraverseBatch, "reset", "environment"),
        (ScenarioConfig, "sample", "seas"),
        (Starter, "start", "seas"),
        (Batch, "advance", "simulation"),
    ]
    if algorithm == "ppo":
        policy = [(ActorCriticPolicy, name, "policy") for name in ("forward", "predict_values")]
        return [*found, *policy, (PPO, "learn", "rest"), (PPO, "train", "learning")]
    from sb3_contrib import TQC

    kind: Any = TQC if algorithm == "tqc" else SAC
    return [*found, (kind, "predict", "policy"), (kind, "learn", "rest"), (kind, "train", "learning")]


def measure(config: str, updates: int, changes: Sequence[str] = ()) -> dict[str, Any]:
    """Train for some updates and stop the time.

    Args:
        config: The training, as `load_training` takes it.
        updates: How many (of SAC and TQC: lines of the curve).
        changes: ``key=value``.

    Returns:
        ``steps``, ``wall_s``, ``us_per_step``, and for each part ``wall_share`` and ``cpu_share``.
    """
    from ssmash_gym.training.config import load_training
    from ssmash_gym.training.run import learn

    settings = load_training(config, changes)
    steps = updates * settings.steps_per_update
    settings = settings.model_copy(update={"total_steps": steps})
    watch = Stopwatch()
    with tempfile.TemporaryDirectory() as folder, watch.watching(places(settings.algorithm)):
        learn(settings, Path(folder) / "run", Console(quiet=True))
    wall_s, cpu_s = sum(watch.wall_s.values()), sum(watch.cpu_s.values())
    return {
        "training": settings.name,
        "steps": steps,
        "wall_s": round(wall_s, 2),
        "us_per_step": round(1e6 * wall_s / steps, 1),
        "cpu_us_per_step": round(1e6 * cpu_s / steps, 1),
        "parts": {
            name: {
                "wall_share": round(watch.wall_s[name] / wall_s, 4),
                "cpu_share": round(watch.cpu_s[name] / cpu_s, 4),
                "cpu_us_per_step": round(1e6 * watch.cpu_s[name] / steps, 2),
            }
            for name in PARTS
        },
    }


def show(figures: dict[str, Any], console: Console) -> None:
    """The figures as a table."""
    title = (
        f"{figures['training']}: {figures['steps']:,} control intervals, {figures['us_per_step']:.0f} us each "
        f"({figures['cpu_us_per_step']:.0f} us of processor time)"
    )
    table = Table("part", "what", "wall %", "processor %", "processor us", title=title)
    for name, part in figures["parts"].items():
        shares = (f"{100 * part[key]:.1f}" for key in ("wall_share", "cpu_share"))
        table.add_row(name, PARTS[name], *shares, f"{part['cpu_us_per_step']:.1f}")
    console.print(table)


def main() -> None:
    """Measure and print a table, then JSON."""
    parser = argparse.ArgumentParser(description="Where the time of a training goes.")
    parser.add_argument("config", nargs="?", default="ppo_traverse", help="training: a name or a file (ppo_traverse)")
    parser.add_argument("--updates", type=int, default=24, help="updates that are timed (24)")
    parser.add_argument("--set", nargs="*", default=[], dest="changes", help="key=value, as of train.py")
    options = parser.parse_args()
    figures = measure(options.config, options.updates, options.changes)
    show(figures, Console(stderr=True))
    sys.stdout.write(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
