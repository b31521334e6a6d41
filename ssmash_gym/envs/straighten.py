"""`ssmash/Straighten-v0`: the same environments with another task and scenario (configs/tasks/straighten.yaml)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ssmash_gym.envs.loading import BASE_KEY
from ssmash_gym.envs.traverse import TraverseEnv
from ssmash_gym.envs.vector import TraverseVectorEnv

STRAIGHTEN: Final = "straighten"  # name of the task and of its scenario


def based(given: Any) -> Any:
    """A mapping of changes without a base changes this task (or its scenario), not the traverse's."""
    return {BASE_KEY: STRAIGHTEN, **given} if isinstance(given, Mapping) else given


class StraightenEnv(TraverseEnv):
    """Straighten a helicopter that has landed up to 30 deg crooked, with the claw that holds its probe.

    Spaces, rewards, infos and arguments are those of `TraverseEnv`; `task` and `scenario` are ``straighten`` by
    default, and a mapping changes those. The goal is to stand straight over the centre line, anywhere on the track.
    Docs: ``docs/environments/straighten.md``.
    """

    def __init__(self, *, task: Any = STRAIGHTEN, scenario: Any = STRAIGHTEN, **arguments: Any) -> None:
        super().__init__(task=based(task), scenario=based(scenario), **arguments)


class StraightenVectorEnv(TraverseVectorEnv):
    """N of them as one vector environment: `TraverseVectorEnv` with the defaults of `StraightenEnv`."""

    def __init__(
        self, num_envs: int = 1, *, task: Any = STRAIGHTEN, scenario: Any = STRAIGHTEN, **arguments: Any
    ) -> None:
        super().__init__(num_envs, task=based(task), scenario=based(scenario), **arguments)
