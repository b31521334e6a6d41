"""The causes of peaks, on made-up telemetry in which the cause is known; and a rival in the same sea."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl
import pytest

from ssmash_gym.trials import Trial
from ssmash_gym.trials.review import moments, rival_run
from ssmash_gym.trials.trial import COLUMNS
from tests.trials.rig import condition, recorded

STEPS = 300
MASS_kg = 9937.24


@pytest.fixture(scope="module")
def quiet() -> Trial:
    """Thirty seconds in which nothing happens."""
    real = recorded(condition("calm"), 1, [[0.0, 0.0]])
    draw = {**real.about["draw"], "helicopter_mass_factor": 1.0, "claw_y_travel_m": 0.3}
    columns: dict[str, Any] = {name: np.zeros(STEPS) for name in COLUMNS}
    columns |= {"time_s": 0.1 * np.arange(1, STEPS + 1), "driver": ["person"] * STEPS, "device": [""] * STEPS}
    columns["late"] = np.zeros(STEPS, dtype=bool)
    columns["claw_x"] = np.full(STEPS, 4.0)
    return Trial(pl.DataFrame(columns).cast(dict(COLUMNS)), {**real.about, "draw": draw})


def changed(trial: Trial, **columns: Any) -> Trial:
    table = trial.table.with_columns(
        pl.Series(name, values, dtype=trial.table.schema[name]) for name, values in columns.items()
    )
    return replace(trial, table=table)


def bump(time_s: float, height: float, width_s: float = 0.5) -> Any:
    time = 0.1 * np.arange(1, STEPS + 1)
    return height * np.exp(-(((time - time_s) / width_s) ** 2))


def peak(trial: Trial, time_s: float, force_N: tuple[float, float], **columns: Any) -> Trial:
    load = bump(time_s, float(np.hypot(*force_N)))
    return changed(
        trial, probe_in_plane=load, probe_in_plane_max=load, probe_fx=bump(time_s, force_N[0]),
        probe_fy=bump(time_s, force_N[1]), **columns,
    )  # fmt: skip


def words(trial: Trial) -> str:
    found = moments(trial)
    assert len(found) == 1
    return str(found[0]["words"])


def place(speed: Any, start: float = 0.0) -> Any:
    return start + 0.1 * np.cumsum(speed)


def test_the_deck_pushes_and_the_claw_holds_still(quiet: Trial) -> None:
    told = words(peak(quiet, 20.0, (0.0, 12400.0), deck_fy=bump(20.0, 1.1), deck_roll=np.deg2rad(bump(20.0, -6.0))))
    assert (
        told == "12.4 kN at 20.0 s: the deck pushed 1.1 m/s2 to port (6.0 deg port down), and the claw did not give way"
    )


def test_a_claw_that_gives_way_is_not_blamed(quiet: Trial) -> None:
    speed = np.where(np.abs(0.1 * np.arange(1, STEPS + 1) - 19.5) < 0.4, -0.05, 0.0)
    told = words(peak(quiet, 20.0, (0.0, 12400.0), deck_fy=bump(20.0, 1.1), claw_vy=speed, claw_y=place(speed)))
    assert "the deck pushed 1.1 m/s2 to port" in told and "give way" not in told


def test_a_claw_at_the_end_of_its_travel_cannot_give_way(quiet: Trial) -> None:
    told = words(peak(quiet, 20.0, (0.0, -9000.0), deck_fy=bump(20.0, -0.9), claw_y=np.full(STEPS, 0.3)))
    assert told.endswith(
        "the deck pushed 0.9 m/s2 to starboard, and the claw was at the end of its travel to starboard"
    )


def test_a_pitched_deck_pushes_along(quiet: Trial) -> None:
    told = words(peak(quiet, 20.0, (6000.0, 0.0), deck_fx=bump(20.0, 0.6), deck_pitch=np.deg2rad(bump(20.0, 3.0))))
    assert told == "6.0 kN at 20.0 s: the deck pushed 0.6 m/s2 aft (3.0 deg bow up)"


def test_a_push_against_the_load_is_no_cause(quiet: Trial) -> None:
    assert words(peak(quiet, 20.0, (0.0, 8000.0), deck_fy=bump(20.0, -1.0))).endswith("no single cause stands out")


@pytest.mark.parametrize(
    ("before", "after", "force_N", "told"),
    [
        (0.2, 0.0, -4000.0, "the claw stopped from 0.20 m/s forward"),
        (0.0, 0.25, 4000.0, "the claw started to 0.25 m/s forward"),
        (0.1, -0.15, -4000.0, "the claw reversed from 0.10 m/s forward to 0.15 m/s aft"),
        (0.25, 0.1, -4000.0, "the claw slowed from 0.25 to 0.10 m/s forward"),
        (-0.1, -0.3, -4000.0, "the claw sped up from 0.10 to 0.30 m/s aft"),
    ],
)
def test_the_claw_changes_its_speed_along_the_track(
    quiet: Trial, before: float, after: float, force_N: float, told: str
) -> None:
    time = 0.1 * np.arange(1, STEPS + 1)
    speed = np.interp(time, [18.8, 18.8 + abs(after - before) / 0.3], [before, after])
    trial = peak(quiet, 19.8, (force_N, 0.0), claw_vx=speed, claw_x=place(speed, 3.0))
    assert words(trial) == f"4.0 kN at 19.8 s: {told}"


def test_the_claw_runs_into_its_end(quiet: Trial) -> None:
    time = 0.1 * np.arange(1, STEPS + 1)
    speed = np.where(time < 19.5, 0.2, 0.0)
    x = place(speed)
    trial = peak(quiet, 19.8, (-5000.0, 0.0), claw_vx=speed, claw_x=x + (8.0 - x[-1]))
    assert words(trial).endswith("the claw stopped from 0.20 m/s forward at the end of its travel")


def test_the_claw_draws_it_across(quiet: Trial) -> None:
    speed = np.where(np.abs(0.1 * np.arange(1, STEPS + 1) - 19.4) < 0.55, 0.08, 0.0)
    trial = peak(quiet, 20.0, (0.0, 30000.0), claw_vy=speed, claw_y=place(speed))
    assert "the claw drew the helicopter 0.09 m to starboard, at up to 0.08 m/s" in words(trial)


@pytest.mark.parametrize(("yaw_deg", "force_N", "board"), [(-5.0, 11000.0, "port"), (5.0, -11000.0, "starboard")])
def test_it_is_drawn_along_askew(quiet: Trial, yaw_deg: float, force_N: float, board: str) -> None:
    speed = np.full(STEPS, 0.2)
    yaw = np.full(STEPS, np.deg2rad(yaw_deg))
    trial = peak(quiet, 20.0, (0.0, force_N), claw_vx=speed, claw_x=place(speed), yaw=yaw)
    assert words(trial).endswith(f"the claw drew the helicopter 0.30 m forward with its bow 5.0 deg to {board}")


def test_two_ways_of_the_claw_share_a_verb(quiet: Trial) -> None:
    speed, across = np.full(STEPS, 0.2), np.where(np.abs(0.1 * np.arange(1, STEPS + 1) - 19.4) < 0.35, 0.02, 0.0)
    trial = peak(
        quiet, 20.0, (0.0, 15000.0), claw_vx=speed, claw_x=place(speed), claw_vy=across, claw_y=place(across),
        yaw=np.full(STEPS, np.deg2rad(-4.0)),
    )  # fmt: skip
    assert words(trial).endswith(
        "0.30 m forward with its bow 4.0 deg to port and 0.01 m to starboard, at up to 0.02 m/s"
    )


def test_two_causes_the_stronger_first(quiet: Trial) -> None:
    time = 0.1 * np.arange(1, STEPS + 1)
    speed = np.interp(time, [22.3, 23.0], [0.2, 0.0])
    trial = peak(quiet, 23.1, (-12400.0, 0.0), deck_fx=bump(23.1, -1.0), claw_vx=speed, claw_x=place(speed, 2.0))
    assert words(trial) == "12.4 kN at 23.1 s: the deck pushed 1.0 m/s2 forward"  # the other is a quarter of it
    sharper = changed(trial, deck_fx=bump(23.1, -0.5))
    assert words(sharper).endswith("the deck pushed 0.5 m/s2 forward, while the claw stopped from 0.20 m/s forward")
    gentle = changed(trial, deck_fx=bump(23.1, -0.26))
    assert words(gentle).endswith("the claw stopped from 0.20 m/s forward, while the deck pushed 0.3 m/s2 forward")


def test_nobody_at_the_claw_is_told(quiet: Trial) -> None:
    driver = ["none" if 190 <= k < 195 else "person" for k in range(STEPS)]
    trial = peak(quiet, 20.0, (0.0, 9000.0), deck_fy=bump(20.0, 0.9), driver=driver)
    assert words(trial).endswith("; nobody held the claw")
    assert "nobody" not in words(changed(trial, driver=["person"] * STEPS))


def test_separate_peaks_in_the_order_of_time(quiet: Trial) -> None:
    load = (
        bump(0.5, 50e3, 0.2) + bump(5.0, 9e3) + bump(7.0, 8e3) + bump(15.0, 12e3) + bump(25.0, 2e3) + bump(28.5, 10e3)
    )
    found = moments(changed(quiet, probe_in_plane=load, probe_in_plane_max=load))
    assert [moment["time_s"] for moment in found] == pytest.approx([5.0, 15.0, 28.5])
    assert [moment["peak_kN"] for moment in found] == pytest.approx([9.0, 12.0, 10.0], rel=1e-3)


def test_nothing_to_tell(quiet: Trial) -> None:
    assert moments(replace(quiet, table=quiet.table.head(0))) == []
    assert moments(replace(quiet, table=quiet.table.head(5))) == []  # all of it in the grace


def test_a_rival_meets_the_same_sea() -> None:
    what = condition("ss5", {"horizon_s": 3.0})
    own = recorded(what, 21, [[0.3, 0.0]] * 30)
    rival = rival_run(what, 21, "trapezoid")
    assert rival.driver == "trapezoid" and rival.about["origin"] == "script"
    assert rival.about["draw"] == own.about["draw"]
    assert rival.table["deck_fy"].equals(own.table["deck_fy"])
    assert own.metrics is not None and rival.metrics is not None
    told = moments(own)
    assert max(moment["peak_kN"] for moment in told) == pytest.approx(own.metrics["peak_probe_kN"], rel=1e-6)
