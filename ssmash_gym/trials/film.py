"""A trial as a video: what was to be seen, at the speed of reality or faster."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ssmash_gym.envs.pictures import Film
from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.evaluation.film import encoder
from ssmash_gym.files import whole_files
from ssmash_gym.trials.trial import Trial

if TYPE_CHECKING:
    from ssmash_gym.envs.batch_env import TraverseBatch
    from ssmash_gym.envs.step import StepResult
    from ssmash_gym.trials.replay import Note


def require_video() -> None:
    """Check that videos can be made.

    Raises:
        ImportError: A library is missing; the sentence names the extra.
    """
    for name in ("pygame", "imageio_ffmpeg"):
        require(name, f'--video needs {name}: pip install "ssmash_gym[render]".')


@contextmanager
def filmed(trial: Trial, path: Path, speed: float) -> Iterator[Note]:
    """What a replay is to be told, to film it as MP4; the file is written whole or not at all.

    Args:
        trial: What will be replayed.
        path: File to write; its ending becomes ``.mp4``.
        speed: How much faster than in reality it plays.

    Raises:
        ConfigurationError: The trial has no step.
    """
    if not trial.steps:
        raise ConfigurationError("--video is refused: the trial was broken off before its first step.")
    target = path.with_suffix(".mp4")
    target.parent.mkdir(parents=True, exist_ok=True)
    rate = speed / float(trial.about["timing"]["interval_s"])
    with whole_files([target]) as staged, ExitStack() as stack:
        running: dict[str, Any] = {}

        def note(batch: TraverseBatch, result: StepResult) -> None:
            film = running.setdefault("film", None) or Film(batch, 0, "rgb_array")
            film.note(result)
            frame = np.ascontiguousarray(film.picture())
            if running["film"] is None:
                size = (frame.shape[1], frame.shape[0])
                running["write"] = stack.enter_context(encoder(staged[target], size, rate, []))
                running["film"] = film
            running["write"](frame)

        yield note
        stack.close()  # the encoder ends the file before it takes its place
