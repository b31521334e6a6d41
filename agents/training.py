"""`ssmash train`: the training set-up, which lies in `ssmash_gym.training`."""

from __future__ import annotations

from ssmash_gym.training.run import train

__all__ = ["train"]
