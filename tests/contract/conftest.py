"""Short episodes for the contract tests: the full physics and all noise, little time."""

from __future__ import annotations

from typing import Any

import pytest

ID = "ssmash_gym:ssmash/Traverse-v0"


@pytest.fixture
def short() -> dict[str, Any]:
    """Arguments of an environment whose episodes last 0.5 s, in a sea, with noisy and late sensors."""
    return {
        "task": {"horizon_s": 0.5, "lead_in": {"duration_s": 2.0, "ramp_s": 2.0}, "grace_s": 0.1},
        "scenario": {
            "motion": {"hs_m": {"uniform": [0.5, 1.5]}, "components": 24},
            "claw": {"delay_s": {"uniform": [0.0, 0.2]}},
            "sensors": {"noise": 1.0, "delay_s": {"uniform": [0.0, 0.15]}},
        },
    }


@pytest.fixture
def env_id() -> str:
    """The id under which Gymnasium knows the environment."""
    return ID
