"""What the tests of studies share: short studies, and agents that were never trained."""

from __future__ import annotations

import functools
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.evaluation import study, study_entrants
from ssmash_gym.evaluation.study import StudyConfig, load_study
from ssmash_gym.training.agent import ABOUT, NORMALISER, WEIGHTS, Agent
from ssmash_gym.training.config import load_training
from ssmash_gym.training.network import Network
from ssmash_gym.training.normaliser import Normaliser

SHORT = {"horizon_s": 1.0, "grace_s": 0.2, "lead_in": {"duration_s": 2.0, "ramp_s": 2.0}}


def short_study(**changes: Any) -> StudyConfig:
    """Two conditions of five seas, each an episode of a second."""
    document: dict[str, Any] = {
        "seed": 3,
        "episodes": 5,
        "chunk": 3,
        "resamples": 20,
        "conditions": {
            "calm": {"scenario": "ss3", "task": SHORT},
            "soft": {"scenario": "ss3", "task": SHORT, "helicopter_factors": {"probe.small_stiffness_x_Npm": 0.5}},
        },
        "runs": [{"conditions": ["calm", "soft"], "policies": ["hold", "trapezoid"], "agents": True}],
    }
    return load_study(document | changes)


def untrained(folder: Path, value: float, seed: int = 0, name: str = "made_up") -> Path:
    """A folder with an agent that always gives the same command along the track."""
    folder.mkdir(parents=True)
    np.savez(folder / WEIGHTS, value=np.array(value))
    Normaliser(None, None, 10.0).write(folder / NORMALISER)
    (folder / ABOUT).write_text(json.dumps({"name": name, "steps": 7, "value": value, "seed": seed}))
    return folder


def read_untrained(folder: Path) -> Agent:
    """The agent of such a folder."""
    about: Mapping[str, Any] = json.loads((folder / ABOUT).read_text())
    task = load_task()
    terms = 43
    network = Network((np.zeros((terms, 2), np.float32),), (np.array([about["value"], 0.0], np.float32),), "tanh")
    training = load_training("smoke", [f"seed={about['seed']}"])
    return Agent(about["name"], network, Normaliser(None, None, 10.0), task, load_scenario("ss5"), training, about)


@pytest.fixture(autouse=True, scope="session")
def helicopters_read_once() -> Iterator[None]:
    """Reading a helicopter's file takes as long as a short study."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "load_helicopter", functools.cache(study.load_helicopter))
        yield


@pytest.fixture
def agents_without_training(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let folders of `untrained` be read as agents."""
    monkeypatch.setattr(study_entrants, "load_agent", read_untrained)
