"""What the three faces of the environment share: spaces, metadata, the reset options."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from gymnasium import spaces

from ssmash_gym.envs.batch_env import ACTIONS, TraverseBatch

RENDER_MODES: Final = ("rgb_array", "human")
BATCH_RENDER_MODES: Final = ("rgb_array",)


def action_space() -> spaces.Box:
    """Normalised claw velocity command, along and across the track."""
    return spaces.Box(-1.0, 1.0, (ACTIONS,), np.float32)


def observation_space(core: TraverseBatch) -> spaces.Box:
    """Scaled observation within the task's clip."""
    clip = core.observer.clip
    return spaces.Box(-clip, clip, (core.observer.size,), np.float32)


def metadata(core: TraverseBatch, modes: tuple[str, ...] = RENDER_MODES, **more: Any) -> dict[str, Any]:
    """Metadata of one instance: a new mapping each time."""
    fps = max(1, round(1.0 / core.control_interval_s))
    return {
        "render_modes": list(modes),
        "render_fps": fps,
        "control_interval_s": core.control_interval_s,
        **more,
    }


def checked_render_mode(render_mode: str | None, modes: tuple[str, ...] = RENDER_MODES) -> str | None:
    """The render mode, if it is one of `modes`.

    Raises:
        ValueError: It is none.
    """
    if render_mode is not None and render_mode not in modes:
        raise ValueError(f"render_mode = {render_mode!r}: must be None or {' or '.join(map(repr, modes))}")
    return render_mode


def checked_options(options: Mapping[str, Any] | None, *allowed: str) -> dict[str, Any]:
    """The reset options as a new mapping.

    Raises:
        ValueError: A key is unknown.
    """
    chosen = dict(options or {})
    for key in chosen:
        if key not in allowed:
            raise ValueError(f"reset option {key!r}: must be one of {', '.join(allowed)}")
    return chosen
