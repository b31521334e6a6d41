"""Seas of scenarios: draws, targets of severity, ships in draws, and the page's tables of keys."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from ssmash_gym.assets import asset_path
from ssmash_gym.envs import EpisodeDraw, load_scenario
from ssmash_gym.envs.loading import merged
from ssmash_gym.envs.motions import FixedMotion, IrregularMotion, RecordedMotions, SinusoidMotion, plain
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.envs.seaways import HIGHEST_M, SeawayMotions, solved
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import parse_motion
from ssmash_gym.ship.sea import SEA_STATES, period_of_height
from ssmash_gym.ship.seaway import Seaway
from ssmash_gym.ship.wind import true_wind_of_height


def test_the_evaluation_seas_differ_in_the_sea_state_only() -> None:
    """Same seed, same course, phases, landing and noise in each: paired comparisons."""
    plain = load_scenario("ss3").model_dump(mode="json")
    draws = {}
    for state in SEA_STATES:
        if state == 2:
            continue
        scenario = load_scenario(f"ss{state}")
        document = scenario.model_dump(mode="json")
        assert document["motion"].pop("sea_state") == state
        assert {**document, "description": "", "motion": None} == {**plain, "description": "", "motion": None}
        draws[state] = scenario.sample(np.random.default_rng(5)).to_dict()
        assert (draws[state]["motion"]["hs_m"], draws[state]["motion"]["tp_s"]) == SEA_STATES[state]
    for draw in draws.values():
        differs = {key for key in draw if draw[key] != draws[3][key]}
        assert differs <= {"motion", "wind_speed_mps"}
        assert {key for key in draw["motion"] if draw["motion"][key] != draws[3]["motion"][key]} <= {"hs_m", "tp_s"}
        phases = [
            parse_motion(sea["motion"]).realise(np.random.default_rng(sea["motion_seed"])).waves.phase  # type: ignore[union-attr]
            for sea in (draw, draws[3])
        ]
        assert np.array_equal(*phases)


def test_the_training_seas() -> None:
    """Ranges, shares of the kinds, and what goes with what; a draw is a section that is a seaway."""
    scenario = load_scenario()
    draws = [scenario.sample(np.random.default_rng(k)) for k in range(400)]
    seas = [draw.motion for draw in draws]
    for key, low, high in (
        ("hs_m", 0.5, 5.0), ("heading_deg", 0.0, 360.0), ("speed_kn", 0.0, 20.0), ("roll_damping_factor", 0.7, 1.3),
        ("gm_factor", 0.85, 1.15), ("heel_deg", -2.0, 2.0), ("trim_deg", 0.0, 0.0),
    ):  # fmt: skip
        values = np.array([sea[key] for sea in seas])
        assert low <= values.min() and values.max() <= high
        assert np.ptp(values) >= 0.97 * (high - low)
    factors = np.array([sea["tp_s"] / period_of_height(sea["hs_m"]) for sea in seas])
    assert 0.85 <= factors.min() < 0.86 and 1.14 < factors.max() <= 1.15
    shift = np.array([sea["deck_shift_m"] for sea in seas])
    assert np.abs(shift).max(axis=0) == pytest.approx([5.0, 0.0, 1.0], rel=0.02)
    assert np.mean([sea["spectrum"] == "jonswap" for sea in seas]) == pytest.approx(0.3, abs=0.06)
    assert np.mean([sea["spreading"] == "long_crested" for sea in seas]) == pytest.approx(0.2, abs=0.05)
    for draw in draws[:20]:
        source = parse_motion(draw.motion)
        assert isinstance(source, Seaway) and source.sea().hs_m == draw.motion["hs_m"]


def test_the_wind_goes_with_the_sea() -> None:
    """Speed by the height, direction by the waves, the ship's speed by the seaway."""
    motion = {"hs_m": 3.0, "heading_deg": 60.0, "speed_kn": 10.0, "components": 24}
    wind = {"speed_factor": 1.2, "from_waves_deg": -20.0, "gust_intensity": 0.1}
    draw = load_scenario({"motion": motion, "wind": wind}).sample(np.random.default_rng(0))
    assert draw.wind_speed_mps == pytest.approx(1.2 * true_wind_of_height(3.0))
    assert draw.wind_from_deg == pytest.approx(220.0)  # waves that travel to 60 deg come from 240
    assert draw.wind_ship_speed_mps == pytest.approx(10.0 * 1852.0 / 3600.0)
    assert draw.wind_gust_intensity == 0.1
    document = load_scenario("ss3").model_dump(mode="json")
    document["motion"] = {"type": "seaway", **motion, "hs_m": HIGHEST_M, "tp_s": 16.0}
    document["wind"] |= {"speed_factor": 2.0}
    draw = ScenarioConfig.model_validate(document).sample(np.random.default_rng(0))
    assert EpisodeDraw.from_dict(draw.to_dict()) == draw  # the strongest wind that goes with a sea is a wind
    free = {"type": "free", "speed_mps": 7.0, "from_deg": 30.0}
    draw = load_scenario({"motion": motion, "wind": free}).sample(np.random.default_rng(0))
    assert (draw.wind_speed_mps, draw.wind_from_deg, draw.wind_gust_intensity) == (7.0, 30.0, 0.0)
    assert draw.wind_ship_speed_mps == pytest.approx(5.144, abs=1e-3)


def test_severity_can_be_the_lateral_force() -> None:
    """The height is solved for in the very sea of the episode; where it cannot be reached, a bound is taken."""
    motion = {"components": 24, "heading_deg": {"choice": [60.0, 90.0]}}
    for target in (0.03, 0.05):
        scenario = load_scenario({"motion": {**motion, "lateral_g": target}})
        for k in range(4):
            draw = scenario.sample(np.random.default_rng(k))
            assert 0.5 < draw.motion["hs_m"] < 5.0
            section, besides = plain(draw.motion)
            assert besides == {"lateral_g": target}  # what was asked for, beside what came of it
            assert EpisodeDraw.from_dict(json.loads(json.dumps(draw.to_dict()))) == draw
            found = parse_motion(section).realise(np.random.default_rng(draw.motion_seed)).deck_rms()
            assert found.lateral_specific_force_g == pytest.approx(target, rel=0.01)
    for target, height in ((0.0, 0.5), (0.4, 5.0)):
        draw = load_scenario({"motion": {**motion, "lateral_g": target}}).sample(np.random.default_rng(0))
        assert (draw.motion["hs_m"], draw.motion["lateral_g"]) == (height, target)
    with pytest.raises(ConfigurationError, match=r"motion\.lateral_g = nan"):
        EpisodeDraw.from_dict({**draw.to_dict(), "motion": {**draw.motion, "lateral_g": float("nan")}})


def test_a_sea_state_makes_room_for_a_target() -> None:
    changes = {"sea_state": None, "hs_m": {"uniform": [0.3, 5.0]}, "lateral_g": 0.05, "components": 24}
    scenario = load_scenario({"base": "ss5", "motion": {**changes, "heading_deg": 90.0}})
    draw = scenario.sample(np.random.default_rng(1))
    assert 0.3 < draw.motion["hs_m"] < 5.0
    page = (Path(__file__).parents[2] / "docs" / "environments" / "traverse.md").read_text(encoding="utf-8")
    assert "sea_state: null\n  hs_m: {uniform: [0.3, 5.0]}\n  lateral_g: 0.05\n" in page


@pytest.mark.parametrize(
    ("key", "low", "high"),
    [
        ("roll_damping_factor", 0.5, 2.0),
        ("gm_factor", 0.5, 2.0),
        ("heading_deg", -720.0, 720.0),
        ("speed_kn", 0.0, 25.0),
        ("deck_shift_z_m", -500.0, 500.0),
        ("heel_deg", -30.0, 30.0),
    ],
)
def test_what_a_scenario_allows_the_seaway_allows(key: str, low: float, high: float) -> None:
    for bound, beyond in ((low, low - 0.01), (high, high + 0.01)):
        draw = load_scenario({"base": "ss4", "motion": {key: bound}}).sample(np.random.default_rng(0))
        parse_motion(draw.motion)
        with pytest.raises(ConfigurationError, match=f"motion.{key}.*allowed are {low:g} to {high:g}"):
            load_scenario({"base": "ss4", "motion": {key: beyond}})


def test_a_target_is_solved_for() -> None:
    calls: list[float] = []

    def excess(x: float) -> float:
        calls.append(x)
        return x**3 - 2.0

    assert solved(excess, 0.0, 3.0) == pytest.approx(2.0 ** (1 / 3), abs=0.02)
    assert len(calls) < 15
    assert solved(lambda x: x + 1.0, 0.0, 3.0) == 0.0
    assert solved(lambda x: x - 9.0, 0.0, 3.0) == 3.0


def test_a_ships_file_is_found_from_the_scenarios_folder(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(asset_path("configs", "ships", "frigate.yaml").read_text())
    document = yaml.safe_load(asset_path("configs", "scenarios", "ss4.yaml").read_text())
    document["motion"]["ship"] = "mine.yaml"
    (tmp_path / "sea.yaml").write_text(yaml.safe_dump(document))
    motion = load_scenario(tmp_path / "sea.yaml").sample(np.random.default_rng(0)).motion
    assert Path(motion["ship"]) == tmp_path / "mine.yaml"
    parse_motion(motion)
    document["motion"]["ship"] = {"base": "mine.yaml", "kg_m": 6.0}
    (tmp_path / "sea.yaml").write_text(yaml.safe_dump(document))
    motion = load_scenario(tmp_path / "sea.yaml").sample(np.random.default_rng(0)).motion
    assert motion["ship"] == {"base": str(tmp_path / "mine.yaml"), "kg_m": 6.0}
    parse_motion(motion)


def test_a_changed_ship_is_a_ship_of_a_scenario() -> None:
    """A mapping goes through draws and their JSON; on its base it merges, on another one it takes the place."""
    ship = {"base": "frigate", "kg_m": 6.0, "deck_point_m": (-50.0, 0.0, -5.5)}
    scenario = load_scenario({"base": "ss5", "motion": {"ship": ship, "components": 24}})
    draw = scenario.sample(np.random.default_rng(3))
    again = EpisodeDraw.from_dict(json.loads(json.dumps(draw.to_dict())))
    assert again == draw and draw.motion["ship"]["deck_point_m"] == [-50.0, 0.0, -5.5]
    plain_draw = load_scenario({"base": "ss5", "motion": {"components": 24}}).sample(np.random.default_rng(3))
    assert {key for key in draw.motion if draw.motion[key] != plain_draw.motion[key]} == {"ship"}
    roll = [parse_motion(d.motion).realise(np.random.default_rng(0)).deck_rms().roll_deg for d in (draw, plain_draw)]
    assert abs(roll[0] / roll[1] - 1.0) > 0.01
    document = scenario.model_dump(mode="json")
    assert merged(document, {"motion": {"ship": {"kg_m": 5.0}}})["motion"]["ship"]["base"] == "frigate"
    other = {"base": "destroyer", "kg_m": 7.0}
    assert merged(document, {"motion": {"ship": other}})["motion"]["ship"] == other


def test_the_page_names_every_key_of_every_motion() -> None:
    """docs/environments/traverse.md: keys of scenarios beside those of motion sections, with the ranges marked."""
    page = (Path(__file__).parents[2] / "docs" / "environments" / "traverse.md").read_text(encoding="utf-8")
    table = dict(re.findall(r"^\| `(fixed|sinusoid|irregular|file|seaway)` \| .* \| (.*) \|$", page, re.MULTILINE))
    sea = page.partition("### The sea\n")[2].partition("### The wind\n")[0]
    for kind in (FixedMotion, SinusoidMotion, IrregularMotion, RecordedMotions, SeawayMotions):
        name = kind.model_fields["type"].default
        for key, field in kind.model_fields.items():
            if key in ("type", "surge", "sway", "heave", "pitch", "yaw"):  # "and so on" after roll
                continue
            if name == "seaway" and not key.startswith("deck_shift"):
                assert f"`{key}`" in sea, key
                continue
            written = key.replace("deck_shift_y", "_y").replace("deck_shift_z", "_z")
            assert f"`{written}`" in table[name] or f"`{written}:" in table[name], (name, key)
            if "Uniform" in str(field.annotation) + str(field.metadata):
                assert f"`{written}` ~" in table[name], (name, key)
