"""What SAC and TQC have to remember beyond their networks and optimisers, so that a resumed run is the same run."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np

_COLUMNS: Final = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")


def algorithm_state(model: Any) -> dict[str, Any]:
    """The learned weight of the entropy and the count of episodes; PPO: nothing."""
    if not hasattr(model, "replay_buffer"):
        return {}
    weight = model.log_ent_coef
    return {
        "log_entropy_weight": None if weight is None else float(weight.item()),
        "episodes": int(model._episode_num),
    }


def restore_algorithm(model: Any, state: dict[str, Any]) -> None:
    """The inverse of `algorithm_state`."""
    if not state:
        return
    import torch

    if state["log_entropy_weight"] is not None:
        with torch.no_grad():
            model.log_ent_coef.fill_(state["log_entropy_weight"])
    model._episode_num = state["episodes"]


def write_transitions(path: Path, model: Any) -> None:
    """Write the past transitions of SAC or TQC; nothing for PPO."""
    buffer = getattr(model, "replay_buffer", None)
    if buffer is None:
        return
    rows = buffer.buffer_size if buffer.full else buffer.pos
    place = np.array([buffer.pos, int(buffer.full)])
    np.savez(path, place=place, **{name: getattr(buffer, name)[:rows] for name in _COLUMNS})


def restore_transitions(path: Path, model: Any) -> None:
    """The inverse of `write_transitions`."""
    buffer = model.replay_buffer
    with np.load(path) as arrays:
        position, full = arrays["place"].tolist()
        for name in _COLUMNS:
            rows = arrays[name]
            getattr(buffer, name)[: len(rows)] = rows
    buffer.pos, buffer.full = position, bool(full)
