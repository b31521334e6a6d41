"""Short episodes in a moving sea for tests of scenes and runs: full physics, little time."""

from __future__ import annotations

from typing import Any

from ssmash_gym.console.scene import frame_of, setup_of
from ssmash_gym.envs.batch_env import TraverseBatch

TASK: dict[str, Any] = {"horizon_s": 2.0, "lead_in": {"duration_s": 3.0, "ramp_s": 3.0}, "grace_s": 0.1}
SCENARIO: dict[str, Any] = {
    "base": "ss5",
    "motion": {"sea_state": None, "hs_m": 1.2, "tp_s": 9.0, "heading_deg": 60.0, "speed_kn": 12.0, "components": 24},
    "start": {"yaw_deg": 6.0, "lateral_m": 0.0},
}


def started(helicopter: str = "generic_tricycle", seed: int = 3, n: int = 1) -> TraverseBatch:
    """A batch at the start of its episodes."""
    batch = TraverseBatch(n, task=TASK, scenario=SCENARIO, helicopter=helicopter, threads=1)
    batch.reset(seeds=[seed + k for k in range(n)])
    return batch


def live_run(name: str, along: float) -> dict[str, Any]:
    """A run of the page as it is seen live, under a constant command along the track."""
    batch = started()
    setup, frames = setup_of(batch), [frame_of(batch)]
    while not batch.book.over[0]:
        batch.step([[along, 0.2]])
        frames.append(frame_of(batch))
    moment = {"time_s": frames[-5]["t"], "peak_kN": frames[-5]["probe_peak_kN"], "words": f"a peak of {name}"}
    return {
        "name": name, "driver": "constant command", "note": "", "seed": 3, "configuration": "none", "version": "0",
        "interval_s": batch.control_interval_s, "setup": setup, "frames": frames, "moments": [moment], "result": None,
    }  # fmt: skip
