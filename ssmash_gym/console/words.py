"""How an episode went, in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ssmash_gym.envs.task import TaskConfig

_REASONS: Final = {
    "goal": "The goal is reached and held",
    "ultimate_load": "The probe broke: its ultimate load was exceeded",
    "probe_lost": "The claw lost the probe",
    "overturning": "The helicopter overturned",
    "corridor": "A wheel left the corridor",
    "divergence": "The simulation diverged",
    "time": "The time is up",
}


def score_words(task: TaskConfig, ending: Mapping[str, Any]) -> list[str]:
    """The sentences of a result card.

    Args:
        task: With its limits.
        ending: ``reason`` and ``episode_metrics`` of the last step; empty where the episode was broken off.
    """
    if not ending:
        return ["Broken off."]
    found = ending["episode_metrics"]
    limit = task.limits.probe_in_plane_kN
    peak = found["peak_probe_kN"]
    words = [f"{_REASONS[ending['reason']]} after {found['time_s']:.1f} s."]
    words.append(f"Highest probe load {peak:.1f} kN: {'above' if peak > limit else 'below'} the limit of {limit:g} kN.")
    if found["over_limit_s"] > 0.0:
        words.append(f"Above that limit for {found['over_limit_s']:.1f} s.")
    if ending["reason"] == "time":
        words.append(
            f"Left to do: {max(found['final_to_go_m'], 0.0):.2f} m to go, {abs(found['final_lateral_m']):.2f} m beside "
            f"the centre line, {abs(found['final_yaw_deg']):.1f} degrees askew."
        )
    if found["lift_offs"]:
        words.append(f"A wheel was lifted {found['lift_offs']} times.")
    return words
