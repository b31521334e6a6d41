"""What a window's file may say; every mistake costs one sentence before anything is written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from ssmash_gym.document import write_yaml
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.seaways import SeawayMotions
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.windows.axes import AXES
from ssmash_gym.windows.cells import Grid, settings
from ssmash_gym.windows.config import load_window
from ssmash_gym.windows.sweep import prepared

PLAIN: dict[str, Any] = {
    "seed": 1, "scenario": {"base": "ss5"}, "axes": {"sea_state": [3, 5], "waves_from_deg": [0, 90], "speed_kn": [10]},
    "limits": {"probe_in_plane_kN": 15.0},
}  # fmt: skip


def test_the_shipped_window_is_the_one_of_its_description() -> None:
    config = load_window("frigate_traverse")
    assert len(Grid(config.axes)) == 4 * 24 * 5
    assert all("operational" not in limit.note.replace("operations", "") for limit in config.limits.values())


def test_cells_are_numbered_with_the_last_axis_fastest() -> None:
    grid = Grid({"sea_state": (3.0, 5.0), "speed_kn": (0.0, 5.0, 10.0)})
    assert [grid.cell(k) for k in (0, 1, 3, 5)] == [
        {"sea_state": 3.0, "speed_kn": 0.0},
        {"sea_state": 3.0, "speed_kn": 5.0},
        {"sea_state": 5.0, "speed_kn": 0.0},
        {"sea_state": 5.0, "speed_kn": 10.0},
    ]


def test_waves_come_from_where_the_chart_says() -> None:
    setting = settings(load_window(PLAIN))["traverse"]
    motion = setting.of({"waves_from_deg": 90.0}).motion.draw(lambda name: 0.5, 0)
    assert motion["heading_deg"] == 270.0  # from starboard: they travel to port


@pytest.mark.parametrize("name", [name for name in AXES if name not in ("sea_state", "hs_m", "sink_rate_m_s")])
def test_every_axis_changes_what_is_drawn(name: str) -> None:
    base = {"base": "ss5", **({"wind": {"type": "free", "speed_mps": 5.0}} if name.startswith("wind") else {})}
    setting = settings(load_window({**PLAIN, "scenario": base, "axes": {name: [0.5, 1.5]}}))["traverse"]
    import numpy as np

    draws = [setting.of({name: value}).sample(np.random.default_rng(0)).to_dict() for value in (0.5, 1.5)]
    assert draws[0] != draws[1]
    same = {key for key in draws[0] if draws[0][key] == draws[1][key]}
    assert {"motion_seed", "sensor_seed", "start_yaw_deg"} <= same  # common random numbers


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "unknown key": ({"colour": 1}, "there is no key colour"),
    "unknown axis": ({"axes": {"depth_m": [1]}}, "there is no axis 'depth_m'"),
    "empty axis": ({"axes": {"speed_kn": []}}, "axes.speed_kn"),
    "twice the same value": ({"axes": {"speed_kn": [5, 5]}}, "listed twice"),
    "no list": ({"axes": {"speed_kn": 0}}, "give a list of numbers"),
    "not reached": ({"axes": {"speed_kn": {"from": 0, "to": 10, "by": 3}}}, "to is not reached"),
    "lift-off of what is in the air": (
        {"stages": ["touchdown"], "limits": {"least_station_kN": 2.0}},
        "refused with the stage touchdown",
    ),
    "backwards": ({"axes": {"speed_kn": {"from": 5, "to": 0, "by": 1}}}, "from must not exceed to"),
    "too many": ({"axes": {"speed_kn": {"from": 0, "to": 20, "by": 1e-7}}}, "too many"),
    "sea state without source": ({"axes": {"sea_state": [7]}}, "sea_state = 7"),
    "two heights": ({"axes": {"sea_state": [3], "hs_m": [1.0]}}, "both set the height"),
    "unknown limit": ({"limits": {"probe_kN": 1.0}}, "there is no limit 'probe_kN'"),
    "impossible limit": ({"limits": {"probe_in_plane_kN": -3.0}}, "probe_in_plane_kN = -3"),
    "limit below nothing": ({"limits": {"corridor_clearance_m": -5.0}}, "must be at least 0"),
    "no policy": ({"policies": []}, "policies"),
    "the same direction twice": ({"axes": {"waves_from_deg": [0, 360]}}, "listed twice"),
    "too many seas": ({"axes": {"speed_kn": {"from": 0, "to": 20, "by": 0.0002}}, "effort": {"most": 1000}}, "at most"),
    "no limit": ({"limits": {}}, "limits"),
    "no number": ({"limits": {"probe_in_plane_kN": "much"}}, "limits.probe_in_plane_kN"),
    "acceptance": ({"acceptance": 1.5}, "acceptance = 1.5"),
    "effort": ({"effort": {"seeds": 20, "most": 10}}, "most = 10"),
    "unknown stage": ({"stages": ["flying"]}, "stages"),
    "sink rate while traversing": ({"axes": {"sink_rate_m_s": [1.0]}}, "is of the stage touchdown alone"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_windows_are_refused_in_a_sentence(case: str) -> None:
    changes, told = REFUSED[case]
    with pytest.raises(ConfigurationError) as refused:
        load_window({**PLAIN, **changes})
    assert told in str(refused.value) and str(refused.value).count("\n") == 0


RESOLVED: dict[str, tuple[dict[str, Any], tuple[str, ...], str]] = {
    "unknown policy": ({}, ("wizard",), "wizard"),
    "policy twice": ({}, ("linear", "linear"), "linear is named twice"),
    "unknown scenario": ({"scenario": "moon"}, (), "moon"),
    "unknown helicopter": ({"helicopter": "blimp"}, (), "blimp"),
    "no seaway": ({"scenario": "calm"}, (), "axes of the sea need a seaway"),
    "wind of the sea": ({"axes": {"wind_speed_mps": [5.0]}}, (), "give the wind by itself"),
    "budget": ({"effort": {"episodes": 79}}, (), "the first round alone takes 80"),
    "wider than the door": ({"limits": {"corridor_clearance_m": 500.0}}, (), "the hangar door is"),
    "unknown policy where none is asked": ({"stages": ["secured"]}, ("wizard",), "wizard"),
    "speed beyond": ({"axes": {"speed_kn": [90.0]}}, (), "90"),
    "steep": ({"axes": {"hs_m": [9.0]}}, (), "9"),
}


@pytest.mark.parametrize("case", RESOLVED)
def test_what_a_window_names_is_tried_before_anything_runs(case: str) -> None:
    changes, policies, told = RESOLVED[case]
    with pytest.raises(ConfigurationError) as refused:
        prepared(load_window({**PLAIN, **changes}), "window", policies)
    assert told in str(refused.value) and str(refused.value).count("\n") == 0


def test_a_file_is_a_window_and_paths_are_told(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(write_yaml(PLAIN))
    assert load_window(path).figures == {"probe_in_plane_kN": 15.0}
    with pytest.raises(ConfigurationError, match="there is no such file"):
        load_window(tmp_path / "other.yaml")


def test_files_that_a_window_names_lie_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "sea.yaml").write_text(write_yaml(load_scenario("ss4").model_dump(mode="json", exclude_none=True)))
    (tmp_path / "base.yaml").write_text(write_yaml({**PLAIN, "scenario": "sea.yaml"}))
    (tmp_path / "mine.yaml").write_text(write_yaml({"base": "base.yaml", "seed": 9}))
    monkeypatch.chdir("/")
    found = settings(load_window(tmp_path / "mine.yaml"))["traverse"]
    assert isinstance(found.scenario.motion, SeawayMotions) and found.scenario.motion.sea_state == 4


def test_bases_have_bases_and_null_takes_away(tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text(
        write_yaml(
            {"base": "frigate_secured", "axes": {"speed_kn": None}, "limits": {"deck_roll_deg": None}, "seed": 4}
        )
    )
    found, base = load_window(mine), load_window("frigate_traverse")
    assert found.stages == ("secured",) and set(base.axes) - set(found.axes) == {"speed_kn"}
    assert set(base.limits) - set(found.limits) == {"deck_roll_deg"}
    (tmp_path / "a.yaml").write_text(write_yaml({"base": "b.yaml"}))
    (tmp_path / "b.yaml").write_text(write_yaml({"base": "a.yaml"}))
    with pytest.raises(ConfigurationError, match="a window is its own base"):
        load_window(tmp_path / "a.yaml")


def test_the_scenario_of_the_shipped_window_is_known() -> None:
    assert load_scenario(load_window("frigate_traverse").scenario).motion.type == "seaway"
