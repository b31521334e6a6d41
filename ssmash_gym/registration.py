"""The ids under which Gymnasium knows the environments. Registering twice does no harm."""

from __future__ import annotations

from typing import Final

TRAVERSE_ID: Final = "ssmash/Traverse-v0"
STRAIGHTEN_ID: Final = "ssmash/Straighten-v0"

ENTRY_POINTS: Final = {  # of the single environment and of the native batch; strings, so that nothing is imported
    TRAVERSE_ID: ("ssmash_gym.envs.traverse:TraverseEnv", "ssmash_gym.envs.vector:TraverseVectorEnv"),
    STRAIGHTEN_ID: ("ssmash_gym.envs.straighten:StraightenEnv", "ssmash_gym.envs.straighten:StraightenVectorEnv"),
}


def register_environments() -> None:
    """Register every id that is not registered yet; nothing is imported or compiled."""
    import gymnasium

    for name, (single, batch) in ENTRY_POINTS.items():
        if name not in gymnasium.registry:
            gymnasium.register(id=name, entry_point=single, vector_entry_point=batch)
