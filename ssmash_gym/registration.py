"""The ids under which Gymnasium knows the environments. Registering twice does no harm."""

from __future__ import annotations

from typing import Final

TRAVERSE_ID: Final = "ssmash/Traverse-v0"


def register_environments() -> None:
    """Register every id that is not registered yet; nothing is imported or compiled: the entry points are strings."""
    import gymnasium

    if TRAVERSE_ID not in gymnasium.registry:
        gymnasium.register(
            id=TRAVERSE_ID,
            entry_point="ssmash_gym.envs.traverse:TraverseEnv",
            vector_entry_point="ssmash_gym.envs.vector:TraverseVectorEnv",
        )
