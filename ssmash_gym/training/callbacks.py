"""What happens beside the learning: the curve, the progress bar, checkpoints, and a stop that loses nothing."""

from __future__ import annotations

import csv
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ssmash_gym.envs.limits import failed
from ssmash_gym.files import whole_file
from ssmash_gym.training.config import TrainingConfig
from ssmash_gym.training.costs import Priced

try:
    from stable_baselines3.common.callbacks import BaseCallback
except ImportError as error:
    raise ImportError('training needs Stable-Baselines3: pip install "ssmash_gym[train]".') from error

EPISODES: Final = (
    "steps", "episodes", "success_rate", "aligned_rate", "failure_rate", "return_mean", "peak_probe_kN_mean",
    "peak_probe_kN_p95", "time_s_median", "saturation_mean",
)  # fmt: skip
EXPLORATION: Final = ("std_along", "std_across")  # PPO's is the same everywhere, SAC's and TQC's is not
LOGGED: Final[Mapping[str, Mapping[str, str]]] = {
    "ppo": {
        "learning_rate": "train/learning_rate",
        "approx_kl": "train/approx_kl",
        "clip_fraction": "train/clip_fraction",
        "value_loss": "train/value_loss",
        "explained_variance": "train/explained_variance",
    },
    "sac": {
        "learning_rate": "train/learning_rate",
        "entropy_weight": "train/ent_coef",
        "actor_loss": "train/actor_loss",
        "critic_loss": "train/critic_loss",
    },
}
SECONDS: Final = ("collect_s", "update_s", "wall_s")
AGAIN_S: Final = 1.0


class Curve(BaseCallback):
    """Writes one line an update to ``curve.csv`` and the same numbers to TensorBoard.

    The values of the optimiser and ``update_s`` are those of the update before the samples of the line. SAC and TQC
    train many times between two lines: their values are those of the last training.

    Args:
        path: The file; lines beyond the model's steps are dropped when a run is resumed.
        show: Called with each line.
        every: Control intervals of all helicopters together between two lines.
        priced: The costs' wrapper, if there are costs.
    """

    def __init__(
        self, path: Path, show: Callable[[dict[str, float]], None], every: int, priced: Priced | None = None
    ) -> None:
        super().__init__()
        self.path, self.show, self.every, self.priced = path, show, every, priced
        self.finished: list[dict[str, Any]] = []
        self.lines: list[dict[str, Any]] = []
        self.wall_s = 0.0
        self._collect_from = self._update_from = self._since = 0.0
        self._collected_s = self._updated_s = 0.0
        self._off_policy = False

    def _on_training_start(self) -> None:
        self._off_policy = hasattr(self.model, "replay_buffer")
        if self.path.is_file():
            with self.path.open(newline="", encoding="utf-8") as file:
                self.lines = [line for line in csv.DictReader(file) if int(line["steps"]) <= self.model.num_timesteps]
        self.wall_s = float(self.lines[-1]["wall_s"]) if self.lines else 0.0
        with whole_file(self.path) as path, path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, self.columns)
            writer.writeheader()
            writer.writerows(self.lines)
        self._since = self._update_from = time.perf_counter()

    @property
    def logged(self) -> Mapping[str, str]:
        """Keys of the optimiser's values in Stable-Baselines3's log, by column."""
        return LOGGED["sac" if self._off_policy else "ppo"]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        exploration = () if self._off_policy else EXPLORATION
        costs = () if self.priced is None else tuple(self.priced.told())
        return (*EPISODES, *exploration, *self.logged, *SECONDS, *costs)

    def _on_rollout_start(self) -> None:
        self._collect_from = time.perf_counter()
        self._updated_s += self._collect_from - self._update_from

    def _on_step(self) -> bool:
        for k in np.flatnonzero(self.locals["dones"]):
            metrics = self.locals["infos"][k].get("episode_metrics")
            if metrics is not None:  # else it was cut short to get the helicopters out of step
                self.finished.append(metrics)
        return True

    def _on_rollout_end(self) -> None:
        self._update_from = time.perf_counter()
        self._collected_s += self._update_from - self._collect_from
        if self.model.num_timesteps % self.every == 0:
            self._write(self._line())

    def _line(self) -> dict[str, float]:
        """The numbers since the last line; counts anew."""
        line = summary(self.finished)
        self.finished = []
        line["steps"] = self.model.num_timesteps
        if not self._off_policy:
            policy: Any = self.model.policy
            line |= dict(zip(EXPLORATION, np.exp(policy.log_std.detach().cpu().numpy()).tolist(), strict=True))
        line |= {name: float(self.logger.name_to_value.get(key, np.nan)) for name, key in self.logged.items()}
        line |= {"collect_s": self._collected_s, "update_s": self._updated_s}
        line["wall_s"] = self.wall_s + self._update_from - self._since
        self._collected_s = self._updated_s = 0.0
        return line | ({} if self.priced is None else self.priced.told())

    def _write(self, line: dict[str, float]) -> None:
        for name, value in line.items():
            if name not in self.logged and name != "steps" and np.isfinite(value):
                self.logger.record(f"traverse/{name}", value)
        if self._off_policy:  # PPO does it by itself
            self.logger.dump(self.model.num_timesteps)
        with self.path.open("a", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, self.columns).writerow(
                {name: f"{value:.6g}" for name, value in line.items()} | {"steps": line["steps"]}
            )
        self.show(line)


def summary(episodes: list[dict[str, Any]]) -> dict[str, float]:
    """Numbers of the episodes that ended during one collection; not a number where none did."""

    def of(name: str, statistic: Callable[[Any], Any] = np.mean) -> float:
        return float(statistic([episode[name] for episode in episodes])) if episodes else float("nan")

    lost = [failed(episode["reason"]) for episode in episodes]
    return {
        "episodes": float(len(episodes)),
        "success_rate": of("success"),
        "aligned_rate": of("aligned"),
        "failure_rate": float(np.mean(lost)) if episodes else float("nan"),
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
        unit: Control intervals of all helicopters together between two updates.

    Attributes:
        left: Whether the training was stopped before its end.
    """

    def __init__(self, every_steps: int, save: Callable[[], None], stop: threading.Event, unit: int) -> None:
        super().__init__()
        self.every_steps, self.save, self.stop, self.unit = every_steps, save, stop, unit
        self._saved_at = 0
        self.left = False

    def _on_training_start(self) -> None:
        self._saved_at = self.model.num_timesteps

    def _on_rollout_start(self) -> None:
        steps = self.model.num_timesteps
        if steps % self.unit:
            return
        if self.stop.is_set() or steps - self._saved_at >= self.every_steps:
            self.save()
            self._saved_at = steps
        self.left = self.stop.is_set()

    def _on_step(self) -> bool:
        return not self.left


class Stages(BaseCallback):
    """Changes the weights of the reward and the scenario along the way.

    Args:
        core: The `TraverseBatch` that is trained on, as it is made at the start of a run.
        settings: Says what holds from which step on.
    """

    def __init__(self, core: Any, settings: TrainingConfig) -> None:
        super().__init__()
        self.core, self.settings = core, settings
        self._first = core.task.reward, core.scenario
        self._stage = 0

    def _on_rollout_start(self) -> None:
        steps = self.model.num_timesteps
        stage = self.settings.stage_at(steps)
        if stage == self._stage:
            return
        self._stage = stage
        reward = self.settings.reward_at(steps, self._first[0])
        scenario = self.settings.scenario_at(steps, self._first[1])
        self.core.change(scenario=None if scenario == self.core.scenario else scenario, reward=reward.model_dump())

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
def stop_on_interrupt(stop: threading.Event, console: Console, unit: str = "update") -> Iterator[None]:
    """Ctrl-C asks for a stop after the unit that is running; another one, a second later or more, stops at once.

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
        console.print(f"stopping after this {unit} (once more stops at once and loses it)")

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
