"""What happens beside the learning: the curve, the progress bar, checkpoints, and a stop that loses nothing."""

from __future__ import annotations

import csv
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ssmash_gym.envs.task import Reward

try:
    from stable_baselines3.common.callbacks import BaseCallback
except ImportError as error:
    raise ImportError('training needs Stable-Baselines3: pip install "ssmash_gym[train]".') from error

COLUMNS: Final = (
    "steps", "episodes", "success_rate", "aligned_rate", "failure_rate", "return_mean", "peak_probe_kN_mean",
    "peak_probe_kN_p95", "time_s_median", "saturation_mean", "std_along", "std_across", "learning_rate",
    "approx_kl", "clip_fraction", "value_loss", "explained_variance", "collect_s", "update_s", "wall_s",
)  # fmt: skip
AGAIN_S: Final = 1.0
LOGGED: Final = {
    "learning_rate": "train/learning_rate",
    "approx_kl": "train/approx_kl",
    "clip_fraction": "train/clip_fraction",
    "value_loss": "train/value_loss",
    "explained_variance": "train/explained_variance",
}


class Curve(BaseCallback):
    """Writes one line an update to ``curve.csv`` and the same numbers to TensorBoard.

    The values of the optimiser and ``update_s`` are those of the update before the samples of the line.

    Args:
        path: The file; lines beyond the model's steps are dropped when a run is resumed.
        show: Called with each line.
    """

    def __init__(self, path: Path, show: Callable[[dict[str, float]], None]) -> None:
        super().__init__()
        self.path, self.show = path, show
        self.finished: list[dict[str, Any]] = []
        self.lines: list[dict[str, Any]] = []
        self.wall_s = 0.0
        self._collect_from = self._update_from = self._since = 0.0

    def _on_training_start(self) -> None:
        if self.path.is_file():
            with self.path.open(newline="", encoding="utf-8") as file:
                self.lines = [line for line in csv.DictReader(file) if int(line["steps"]) <= self.model.num_timesteps]
        self.wall_s = float(self.lines[-1]["wall_s"]) if self.lines else 0.0
        with self.path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(self.lines)
        self._since = self._update_from = time.perf_counter()

    def _on_rollout_start(self) -> None:
        self._collect_from = time.perf_counter()

    def _on_step(self) -> bool:
        for k in np.flatnonzero(self.locals["dones"]):
            metrics = self.locals["infos"][k].get("episode_metrics")
            if metrics is not None:  # else it was cut short to get the helicopters out of step
                self.finished.append(metrics)
        return True

    def _on_rollout_end(self) -> None:
        now = time.perf_counter()
        line = summary(self.finished)
        self.finished = []
        policy: Any = self.model.policy
        std = np.exp(policy.log_std.detach().numpy())
        line |= {"steps": self.model.num_timesteps, "std_along": float(std[0]), "std_across": float(std[1])}
        line |= {name: float(self.logger.name_to_value.get(key, np.nan)) for name, key in LOGGED.items()}
        line |= {"collect_s": now - self._collect_from, "update_s": self._collect_from - self._update_from}
        line["wall_s"] = self.wall_s + now - self._since
        self._update_from = now
        for name, value in line.items():
            if name not in LOGGED and name != "steps" and np.isfinite(value):
                self.logger.record(f"traverse/{name}", value)
        with self.path.open("a", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, COLUMNS).writerow(
                {name: f"{value:.6g}" for name, value in line.items()} | {"steps": line["steps"]}
            )
        self.show(line)


def summary(episodes: list[dict[str, Any]]) -> dict[str, float]:
    """Numbers of the episodes that ended during one collection; not a number where none did."""

    def of(name: str, statistic: Callable[[Any], Any] = np.mean) -> float:
        return float(statistic([episode[name] for episode in episodes])) if episodes else float("nan")

    failed = [episode["reason"] not in ("goal", "time") for episode in episodes]
    return {
        "episodes": float(len(episodes)),
        "success_rate": of("success"),
        "aligned_rate": of("aligned"),
        "failure_rate": float(np.mean(failed)) if episodes else float("nan"),
        "return_mean": of("return"),
        "peak_probe_kN_mean": of("peak_probe_kN"),
        "peak_probe_kN_p95": of("peak_probe_kN", lambda values: np.percentile(values, 95.0)),
        "time_s_median": of("time_s", np.median),
        "saturation_mean": of("saturation"),
    }


class Keeper(BaseCallback):
    """Saves checkpoints between two updates, and stops the training there when asked to.

    Args:
        every_steps: Control intervals between two checkpoints.
        save: Writes a checkpoint.
        stop: Is set when the training shall stop.
    """

    def __init__(self, every_steps: int, save: Callable[[], None], stop: threading.Event) -> None:
        super().__init__()
        self.every_steps, self.save, self.stop = every_steps, save, stop
        self._saved_at = 0
        self._leave = False

    def _on_training_start(self) -> None:
        self._saved_at = self.model.num_timesteps

    def _on_rollout_start(self) -> None:
        steps = self.model.num_timesteps
        if self.stop.is_set() or steps - self._saved_at >= self.every_steps:
            self.save()
            self._saved_at = steps
        self._leave = self.stop.is_set()

    def _on_step(self) -> bool:
        return not self._leave


class Stages(BaseCallback):
    """Changes the weights of the reward along the way.

    Args:
        core: The `TraverseBatch` that is trained on.
        reward_at: The weights after so many steps.
    """

    def __init__(self, core: Any, reward_at: Callable[[int, Reward], Reward]) -> None:
        super().__init__()
        self.core, self.reward_at = core, reward_at
        self._first = core.task.reward

    def _on_rollout_start(self) -> None:
        reward = self.reward_at(self.model.num_timesteps, self._first)
        if reward != self.core.task.reward:
            self.core.task = self.core.task.model_copy(update={"reward": reward})

    def _on_step(self) -> bool:
        return True


class Bar:
    """Progress on a terminal; a line at every tenth of the way where there is none.

    Args:
        total: Steps of the whole run.
        console: Where to write.
    """

    def __init__(self, total: int, console: Console) -> None:
        self.total, self.console = total, console
        self.progress = Progress(
            TextColumn("training"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
            TextColumn("{task.fields[told]}"), console=console, disable=not console.is_terminal,
        )  # fmt: skip
        self._task = self.progress.add_task("training", total=total, told="")
        self._tenth = -1

    def __call__(self, line: dict[str, float]) -> None:
        """Show a line of the curve."""
        told = (
            f"success {100.0 * line['success_rate']:3.0f} %, peak probe load {line['peak_probe_kN_mean']:.1f} kN, "
            f"return {line['return_mean']:.1f}"
        )
        self.progress.update(self._task, completed=line["steps"], told=told if line["episodes"] else "")
        tenth = int(10 * line["steps"] / self.total)
        if not self.console.is_terminal and tenth > self._tenth and line["episodes"]:
            self._tenth = tenth
            done = f"{int(line['steps']):>9,} of {self.total:,} steps, {line['wall_s']:.0f} s"
            self.console.print(f"{done}: {told}", soft_wrap=True)


@contextmanager
def stop_on_interrupt(stop: threading.Event, console: Console) -> Iterator[None]:
    """Ctrl-C asks for a stop after the update that is running; another one, a second later or more, stops at once.

    The delay is there because one Ctrl-C may arrive twice: from the terminal and from a parent that passes it on.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    asked_at = float("-inf")

    def ask(number: int, frame: FrameType | None) -> None:
        nonlocal asked_at
        if stop.is_set() and time.monotonic() - asked_at < AGAIN_S:
            return
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()
        asked_at = time.monotonic()
        console.print("stopping after this update (once more stops at once and loses it)")

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
