"""Short episodes for the contract tests: the full physics and all noise, little time; every id in turn."""

from __future__ import annotations

from typing import Any

import pytest

from tests.contract.kinds import KINDS, Kind


@pytest.fixture(params=KINDS, ids=lambda kind: kind.task)
def kind(request: pytest.FixtureRequest) -> Kind:
    """Each environment that is registered."""
    found: Kind = request.param
    return found


@pytest.fixture
def short(kind: Kind) -> dict[str, Any]:
    """Arguments of an environment whose episodes last 0.5 s, in a sea, with noisy and late sensors."""
    return {
        "task": {"horizon_s": 0.5, "lead_in": {"duration_s": 2.0, "ramp_s": 2.0}, "grace_s": 0.1},
        "scenario": {
            "motion": {**kind.motion, "components": 24},
            "claw": {"delay_s": {"uniform": [0.0, 0.2]}},
            "sensors": {"noise": 1.0, "delay_s": {"uniform": [0.0, 0.15]}},
        },
    }


@pytest.fixture
def told(kind: Kind, short: dict[str, Any]) -> dict[str, Any]:
    """The same arguments for a class that knows nothing of the id's defaults."""
    return {
        "task": {"base": kind.task, **short["task"]},
        "scenario": {"base": kind.scenario, **short["scenario"]},
    }


@pytest.fixture
def env_id(kind: Kind) -> str:
    """The id under which Gymnasium knows the environment."""
    return kind.id
