"""The registered environments, each with what the contract tests need to know of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ssmash_gym.envs.straighten import StraightenEnv, StraightenVectorEnv
from ssmash_gym.envs.traverse import TraverseEnv
from ssmash_gym.envs.vector import TraverseVectorEnv


@dataclass(frozen=True)
class Kind:
    """An id with its classes, and the base that a class without defaults of its own has to be told."""

    id: str
    single: type[TraverseEnv]
    batch: type[TraverseVectorEnv]
    task: str
    scenario: str
    motion: dict[str, Any]


KINDS = (
    Kind(
        "ssmash_gym:ssmash/Traverse-v0", TraverseEnv, TraverseVectorEnv, "traverse", "training",
        {"hs_m": {"uniform": [0.5, 1.5]}},
    ),
    Kind(
        "ssmash_gym:ssmash/Straighten-v0", StraightenEnv, StraightenVectorEnv, "straighten", "straighten",
        {"heading_deg": {"uniform": [45.0, 135.0]}},
    ),
)  # fmt: skip
