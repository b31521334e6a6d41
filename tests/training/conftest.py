"""One small training run that the tests of this folder share."""

from __future__ import annotations

from pathlib import Path

import pytest
from rich.console import Console

from ssmash_gym.training.config import TrainingConfig, load_training


@pytest.fixture(scope="session")
def settings() -> TrainingConfig:
    """The smoke configuration with both normalisers on."""
    return load_training("smoke", ["normalise.observation=true"])


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory, settings: TrainingConfig) -> Path:
    """The folder of a finished run."""
    from ssmash_gym.training.run import learn

    run = tmp_path_factory.mktemp("runs") / "finished"
    assert learn(settings, run, Console(quiet=True))
    return run
