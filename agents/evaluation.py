"""`ssmash evaluate`: the comparison on frozen seeds, which lies in `ssmash_gym.evaluation`."""

from __future__ import annotations

from ssmash_gym.evaluation.evaluate import evaluate

__all__ = ["evaluate"]
