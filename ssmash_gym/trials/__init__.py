"""Trials: episodes at the claw as data, by a person or a program; recorded, sealed, replayed bit for bit."""

from __future__ import annotations

from ssmash_gym.trials.files import read_trial, read_trials, write_trial
from ssmash_gym.trials.recorder import TrialRecorder
from ssmash_gym.trials.stamps import Stamp
from ssmash_gym.trials.trial import Trial

__all__ = ["Stamp", "Trial", "TrialRecorder", "read_trial", "read_trials", "write_trial"]
