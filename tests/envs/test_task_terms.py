"""Rewards, limits and endings of the task, each on readings that are made for it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ssmash_gym.dynamics.channels import OUTPUT_ROWS
from ssmash_gym.dynamics.layout import STATE_ROWS, State
from ssmash_gym.envs import limits, load_task
from ssmash_gym.envs.reading import Reading, half_spread
from ssmash_gym.envs.rewards import Outcome, alignment_potential, progress_potential, rewards
from ssmash_gym.simulation.telemetry import CHANNELS, Telemetry
from ssmash_gym.vehicle import load_helicopter

TASK = load_task()
SPREAD = half_spread(load_helicopter("generic_tricycle"))
UPRIGHT = {f"{s}_vertical_load": 34e3 for s in ("auxiliary", "right", "left")}


def reading(
    now: dict[str, float] | None = None,
    highs: dict[str, float] | None = None,
    lows: dict[str, float] | None = None,
    **more: Any,
) -> Reading:
    """A single helicopter whose channels have the given values; extremes are the instant's unless given."""
    tables = []
    for extra in ({}, highs or {}, lows or {}):
        table = np.zeros((OUTPUT_ROWS, 1))
        for name, value in {**UPRIGHT, **(now or {}), **extra}.items():
            if CHANNELS[name].has_peaks:
                table[CHANNELS[name].row] = value
        tables.append(table)
    state = np.zeros((STATE_ROWS, 1))
    state[State.PROBE_CAPTURED] = 1.0
    fields: dict[str, Any] = {
        "task": TASK, "telemetry": Telemetry(state, *tables), "steps": np.array([50]), "counted": np.array([True]),
        "command": np.zeros((1, 2)), "previous": np.zeros((1, 2)), "held_before": np.array([0]),
        "peak_before_N": np.zeros(1),
        "broken": np.array([False]), "half_spread_m": SPREAD, "limit_steps": TASK.horizon_steps,
    }  # fmt: skip
    return Reading(**{**fields, **more})


def terms(r: Reading, before: Reading | None = None, success: bool = False, failure: bool = False) -> dict[str, float]:
    """The reward's terms of an interval that led from one reading to another."""
    start = r if before is None else before
    progress = progress_potential(r) - progress_potential(start)
    alignment = alignment_potential(r) - alignment_potential(start)
    outcome = Outcome(progress, alignment, np.array([success]), np.array([failure]))
    return {name: float(values[0]) for name, values in rewards(r, outcome).items()}


def test_progress_pays_metres_and_telescopes() -> None:
    here, there = reading({"claw_x": 2.0}), reading({"claw_x": 2.02})
    assert terms(there, here)["progress"] == pytest.approx(0.02)
    assert terms(here, there)["progress"] == pytest.approx(-0.02)
    assert terms(reading({"claw_x": 8.1}), reading({"claw_x": 8.0}))["progress"] == pytest.approx(-0.1)


def test_alignment_counts_near_the_goal_alone() -> None:
    crooked = {"yaw": np.deg2rad(3.0), "probe_y": 0.15}
    assert alignment_potential(reading({**crooked, "claw_x": 3.0}))[0] == 0.0
    assert alignment_potential(reading({**crooked, "claw_x": 6.0}))[0] == pytest.approx(-1.0)
    assert alignment_potential(reading({**crooked, "claw_x": 8.0}))[0] == pytest.approx(-2.0)
    before, after = reading({**crooked, "claw_x": 8.0}), reading({"probe_y": 0.15, "claw_x": 8.0})
    assert terms(after, before)["alignment"] == pytest.approx(TASK.reward.alignment)


@pytest.mark.parametrize(("load", "shaped"), [(5.9e3, 0.0), (9e3, 0.25), (12e3, 1.0), (18e3, 4.0), (24e3, 8.0)])
def test_load_costs_the_square_of_the_excess_then_linearly(load: float, shaped: float) -> None:
    r = reading(highs={"probe_in_plane": load})
    assert terms(r)["load"] == pytest.approx(-0.2 * 0.1 * shaped)
    early = reading(highs={"probe_in_plane": load}, counted=np.array([False]))
    assert terms(early)["load"] == 0.0


def test_only_a_new_peak_costs_and_its_parts_add_up() -> None:
    heavy = load_task({"reward": {"peak": 5.0}})
    lower = reading(task=heavy, highs={"probe_in_plane": 9e3}, peak_before_N=np.array([11e3]))
    assert terms(lower)["peak"] == 0.0
    first = terms(reading(task=heavy, highs={"probe_in_plane": 9e3}))["peak"]
    second = terms(reading(task=heavy, highs={"probe_in_plane": 15e3}, peak_before_N=np.array([9e3])))["peak"]
    assert first + second == pytest.approx(-5.0 * (15.0 / 6.0 - 1.0))
    early = reading(task=heavy, highs={"probe_in_plane": 9e3}, counted=np.array([False]))
    assert terms(early)["peak"] == 0.0


def test_command_time_success_failure() -> None:
    r = reading(command=np.array([[1.0, -0.5]]), previous=np.array([[0.0, 0.5]]))
    found = terms(r)
    assert found["command_rate"] == pytest.approx(-0.01 * 2.0)
    assert found["time"] == pytest.approx(-TASK.reward.time_per_s * 0.1)
    assert (found["success"], found["failure"]) == (0.0, 0.0)
    assert terms(r, success=True)["success"] == 10.0
    assert terms(r, failure=True)["failure"] == -15.0


def test_broken_numbers_leave_the_failure_alone() -> None:
    r = reading({"claw_x": 2.0}, broken=np.array([True]))
    found = terms(r, reading(), failure=True)
    assert sum(found.values()) == found["failure"] == -15.0


@pytest.mark.parametrize(
    ("name", "now", "highs", "lows", "margin"),
    [
        ("probe_in_plane", {}, {"probe_in_plane": 12e3}, {}, 0.2),
        ("probe_in_plane", {}, {"probe_in_plane": 18e3}, {}, -0.2),
        ("main_vertical", {}, {"left_vertical_load": 99e3}, {}, -0.1),
        ("main_vertical", {}, {"auxiliary_vertical_load": 99e3}, {}, 1.0 - 34.0 / 90.0),  # no main station
        ("lift_off", {}, {}, {"auxiliary_vertical_load": 1e3}, -0.5),
        ("lift_off", {}, {}, {"right_vertical_load": 3e3}, 0.5),
        ("roll", {}, {}, {"roll": np.deg2rad(-26.0)}, -0.04),
    ],
)
def test_margins_and_costs(name: str, now: Any, highs: Any, lows: Any, margin: float) -> None:
    found = limits.margins(reading(now, highs, lows))
    assert found[name][0] == pytest.approx(margin)
    costs = limits.costs(found)
    assert costs[name][0] == (1.0 if margin < 0.0 else 0.0)
    assert set(costs) == set(found) == set(limits.LIMITS)


def test_the_probe_has_its_grace() -> None:
    early = reading(highs={"probe_in_plane": 18e3}, counted=np.array([False]))
    assert limits.margins(early)["probe_in_plane"][0] == 1.0
    assert limits.endings(early, limits.margins(early))[limits.ULTIMATE][0] == np.False_
    broken = reading(highs={"probe_in_plane": 76e3}, counted=np.array([False]))
    assert limits.endings(broken, limits.margins(broken))[limits.ULTIMATE][0] == np.True_


@pytest.mark.parametrize(
    ("claw_x", "y", "inside"),
    [(0.0, 2.3, True), (0.0, 2.5, False), (5.9, 2.3, True), (6.0, 2.3, False), (6.0, 1.8, True)],
)
def test_corridor_narrows_in_the_door(claw_x: float, y: float, inside: bool) -> None:
    """Every wheel counts, the outer one of a twin too: a main station's tires are 0.15 to 0.2 m off its middle."""
    assert 0.1 < SPREAD[1, 0] < 0.25
    r = reading({"claw_x": claw_x, "left_contact_y": -y})
    assert (limits.margins(r)["corridor"][0] > 0.0) == inside
    assert limits.endings(r, limits.margins(r))[limits.CORRIDOR][0] != inside


@pytest.mark.parametrize(
    ("now", "within"),
    [
        ({"probe_x": 7.96, "probe_y": 0.04, "yaw": np.deg2rad(0.9)}, True),
        ({"probe_x": 7.94}, False),
        ({"probe_x": 8.06}, False),
        ({"probe_x": 8.0, "probe_y": -0.06}, False),
        ({"probe_x": 8.0, "yaw": np.deg2rad(-1.1)}, False),
    ],
)
def test_goal_tolerances(now: dict[str, float], within: bool) -> None:
    assert bool(reading(now).in_goal[0]) == within


def test_the_goal_must_be_held() -> None:
    """Two seconds are twenty intervals, which twenty-one instants bound."""
    at = {"probe_x": 8.0}
    for before, held in ((19, False), (20, True)):
        r = reading(at, held_before=np.array([before]))
        assert limits.endings(r, limits.margins(r))[limits.GOAL][0] == held
    assert reading({"probe_x": 7.0}, held_before=np.array([30])).held[0] == 0
    assert reading(at, held_before=np.array([30]), broken=np.array([True])).held[0] == 0


def test_a_lost_probe_has_its_own_reason() -> None:
    lost = reading()
    lost.telemetry.state[State.PROBE_LOST] = 1.0
    found = limits.endings(lost, limits.margins(lost))
    assert found[limits.PROBE_LOST][0] and not found[limits.ULTIMATE][0]
    assert tuple(found) == limits.REASONS[:-1]
