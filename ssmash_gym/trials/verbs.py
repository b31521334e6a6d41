"""`ssmash replay`: recorded trials simulated once more."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import tyro
from rich.console import Console

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.step import StepResult
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.progress import Advance, progress_bar
from ssmash_gym.trials.files import read_trial, trial_paths
from ssmash_gym.trials.film import filmed, require_video
from ssmash_gym.trials.replay import Replay, replay
from ssmash_gym.trials.trial import Trial

Files = Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="FILE|FOLDER ...")]


def replay_files(files: Files, /, video: Path | None = None, speed: float = 1.0) -> None:
    """Simulate recorded trials once more from seed and commands, and say whether each comes out bit for bit.

    Args:
        files: Files of trials, or folders of them.
        video: Film of the trial (MP4); of one file only.
        speed: How much faster than in reality the film plays.

    Raises:
        ConfigurationError: A file or an option is refused; or a trial does not agree, or is damaged.
        ImportError: The extra ``render`` is missing.
    """
    paths = listed_paths(files)
    if not 0.0 < speed <= 100.0:
        raise ConfigurationError(f"--speed {speed:g} is refused: it must be above 0 and at most 100.")
    if video is not None:
        if len(paths) > 1:
            raise ConfigurationError(f"--video is refused: {len(paths)} trials are named, a film shows one.")
        if video.is_dir():
            raise ConfigurationError(f"--video {video} is refused: this is a folder, expected a file.")
        require_video()
    wrong = 0
    with progress_bar("replaying", shown=Console(stderr=True).is_terminal) as advance:
        for k, path in enumerate(paths):
            part = functools.partial(_tell, advance, k, len(paths))
            wrong += not _replayed(path, video, speed, part)
    if wrong:
        raise ConfigurationError(f"{wrong} of {len(paths)} trials did not come out as recorded.")


def listed_paths(files: Sequence[Path]) -> list[Path]:
    """The files that are named, and those of the folders that are named, each once.

    Raises:
        ConfigurationError: None is named, or one is not there, or a folder holds none.
    """
    if not files:
        raise ConfigurationError("name a file of a recorded trial, or a folder of them.")
    found: dict[Path, None] = {}
    for path in files:
        if not path.exists():
            raise ConfigurationError(f"{path}: there is no such file or folder.")
        inside = trial_paths(path) if path.is_dir() else [path]
        if not inside:
            raise ConfigurationError(f"{path}: there is no recorded trial in this folder.")
        found |= dict.fromkeys(inside)
    return list(found)


def _tell(advance: Advance, number: int, files: int, share: float) -> None:
    """Tell the bar of one file under way."""
    advance((number + share) / files)


def _replayed(path: Path, video: Path | None, speed: float, advance: Callable[[float], None]) -> bool:
    """Replay one file, film it where that is wanted, and tell what came out; whether it agrees."""
    try:
        trial = read_trial(path)
        with nullcontext() if video is None else filmed(trial, video, speed) as film:

            def note(batch: TraverseBatch, result: StepResult) -> None:
                if film is not None:
                    film(batch, result)
                advance(int(batch.book.steps[0]) / trial.steps)

            outcome = replay(trial, note)
    except ConfigurationError as error:
        print(error)
        return False
    print(f"{path}: {outcome.words} ({told(trial, outcome)}).")
    if video is not None:
        print(f"video in {video.with_suffix('.mp4')}")
    return outcome.agrees


def told(trial: Trial, outcome: Replay) -> str:
    """Who drove, how long, and how it ended, in a few words."""
    words = f"{trial.driver}, {trial.steps} steps"
    metrics = outcome.metrics
    if metrics is None:
        return f"{words}, broken off"
    return f"{words}, {metrics['reason']} after {metrics['time_s']:.1f} s, peak {metrics['peak_probe_kN']:.1f} kN"
