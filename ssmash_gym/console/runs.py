"""Runs for the page: a setup, frames and moments, from a trial that is simulated once more or from a recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ssmash_gym.console.recorded import RECORDING, metadata_of, run_of_recording
from ssmash_gym.console.scene import frame_of, setup_of
from ssmash_gym.errors import ConfigurationError

if TYPE_CHECKING:
    from ssmash_gym.trials.trial import Trial

__all__ = ["run_of_recording", "run_of_trial", "runs_of"]
TRIAL: Final = "ssmash_gym.trial"  # key of a trial's file


def runs_of(paths: Sequence[str | Path]) -> list[dict[str, Any]]:
    """The runs of files of any kind, in their order; each is named after its file.

    Args:
        paths: Trials, and recordings of `ssmash simulate` and of cases.

    Returns:
        One run a file: ``name``, ``driver``, ``note``, ``seed``, ``configuration``, ``version``, ``interval_s``,
        ``setup``, ``frames``, ``moments``, ``result``.

    Raises:
        ConfigurationError: A file is missing, is of no such kind, is damaged or lacks something; one sentence.
    """
    return [_run(Path(path)) for path in paths]


def _run(path: Path) -> dict[str, Any]:
    keys = metadata_of(path)
    if TRIAL in keys:
        from ssmash_gym.trials.files import read_trial

        return run_of_trial(read_trial(path), path.stem)
    if RECORDING in keys:
        return run_of_recording(path)
    raise ConfigurationError(
        f"{path}: this is neither a trial nor a recording of `ssmash simulate` or of a case: such a Parquet file says "
        f"what was simulated, this one does not."
    )


def run_of_trial(trial: Trial, name: str) -> dict[str, Any]:
    """A trial simulated once more, with what caused its highest loads.

    Args:
        trial: The trial.
        name: Of the run.

    Raises:
        ConfigurationError: This version of the package does not take its condition or its draw.
    """
    from ssmash_gym.trials.replay import batch_of, replay
    from ssmash_gym.trials.review import moments

    start = batch_of(trial)
    setup, frames = setup_of(start), [frame_of(start)]
    again = replay(trial, lambda batch, _: frames.append(frame_of(batch)), start)
    about = trial.about
    return {
        "name": name,
        "driver": trial.driver,
        "note": "" if again.agrees else f"Simulated once more, the trial {again.words}.",
        "seed": trial.seed,
        "configuration": about["configuration"],
        "version": about["version"],
        "interval_s": setup["interval_s"],
        "setup": setup,
        "frames": frames,
        "moments": moments(trial),
        "result": again.metrics,
    }
