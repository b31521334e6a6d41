"""Ships of the package and of a user: loading, changing, refusing, and the level of the frigate-like ship's motion."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from ssmash_gym.assets import asset_path
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.hull import DATA
from ssmash_gym.ship.response import HullResponse
from ssmash_gym.ship.response_table import ResponseTable
from ssmash_gym.ship.sea import SEA_STATES, Spectrum, Spreading
from ssmash_gym.ship.seaway_statistics import spectral_deck_rms
from ssmash_gym.ship.ships import KNOT, Ship, load_ship, ship_names
from ssmash_gym.vehicle.document import split


def document() -> dict[str, Any]:
    """The frigate's description without marks."""
    text = asset_path("configs", "ships", "frigate.yaml").read_text(encoding="utf-8")
    plain, _ = split(yaml.safe_load(text), "frigate")
    return plain


def hull_of(ship: Ship) -> HullResponse:
    assert isinstance(ship.response, HullResponse)
    return ship.response


def leaves(node: Any, path: str = "") -> list[str]:
    """Dotted paths of the numbers and lists of a document without marks."""
    if isinstance(node, dict):
        return [leaf for key, child in node.items() for leaf in leaves(child, f"{path}.{key}" if path else key)]
    return [path] if isinstance(node, int | float | list) else []


# --- the ships of the package --------------------------------------------------------------------------------------


def test_every_ship_of_the_package_loads_and_tells_about_itself() -> None:
    assert {"frigate", "destroyer"} <= set(ship_names())
    for name in ship_names():
        ship = load_ship(name)
        assert ship.name == name
        assert ship.deck_point_m.shape == (3,) and not ship.deck_point_m.flags.writeable
        for word in (name, "displacement", "KG, GM", "natural period roll", "roll damping", "deck origin"):
            assert word in ship.summary()
        assert ship.summary().count(" at 10 kn") == 1


@pytest.mark.parametrize("name", ["frigate", "destroyer"])
def test_every_number_of_a_ship_says_where_it_comes_from(name: str) -> None:
    description = load_ship(name).description
    plain = yaml.safe_load(asset_path("configs", "ships", f"{name}.yaml").read_text(encoding="utf-8"))
    numbers = set(leaves(split(plain, name)[0])) - {"hull.scale"}  # 1.0 for the frigate needs no origin
    assert numbers <= set(description.marks)
    assert description.marks["kg_m"].origin == "assumed"
    assert description.marks["deck_point_m"].origin == "assumed"


def test_frigate_has_the_particulars_of_its_description() -> None:
    ship = load_ship("frigate")
    response = hull_of(ship)
    assert response.gm_m == pytest.approx(1.18, abs=0.01)
    assert response.natural_period_s["roll"] == pytest.approx(11.0, abs=0.1)
    assert response.loading.radii_m == pytest.approx((0.38 * 14.8, 0.25 * 124.5, 0.25 * 124.5))
    np.testing.assert_array_equal(ship.deck_point_m, [-45.0, 0.0, -6.0])


def test_destroyer_is_the_frigate_scaled() -> None:
    small, large = hull_of(load_ship("frigate")), hull_of(load_ship("destroyer"))
    scale = large.hull.length_m / small.hull.length_m
    assert large.hull.length_m == pytest.approx(142.0, abs=0.01)
    assert large.mass_kg == pytest.approx(scale**3 * small.mass_kg)
    assert large.gm_m == pytest.approx(scale * small.gm_m, rel=1e-3)
    assert large.natural_period_s["roll"] == pytest.approx(math.sqrt(scale) * small.natural_period_s["roll"], rel=1e-3)
    np.testing.assert_allclose(
        load_ship("destroyer").deck_point_m, scale * load_ship("frigate").deck_point_m, atol=0.05
    )


# Roll, pitch [deg], vertical velocity of the deck [m/s], lateral specific force [g], RMS: a prototype of this model on
# another panelling of a like hull, sampled (3 to 4 % scatter).
REFERENCE = {
    (5, 10.0, 90.0): (3.26, 0.77, 0.59, 0.083),
    (5, 10.0, 45.0): (3.05, 0.68, 0.40, 0.071),
    (5, 18.0, 180.0): (0.59, 1.04, 0.68, 0.033),
    (4, 18.0, 90.0): (1.43, 0.45, 0.39, 0.039),
    (6, 10.0, 90.0): (4.38, 1.04, 0.79, 0.102),
    (6, 18.0, 135.0): (2.28, 1.42, 0.99, 0.070),
}


@pytest.mark.parametrize(("state", "knots", "heading_deg"), REFERENCE)
def test_level_of_the_motion(state: int, knots: float, heading_deg: float) -> None:
    height, period = SEA_STATES[state]
    sea = Spectrum(height, period), Spreading("cos2")
    rms = spectral_deck_rms(load_ship("frigate"), *sea, math.radians(heading_deg), knots * KNOT)
    found = (rms.roll_deg, rms.pitch_deg, rms.vertical_velocity_m_s, rms.lateral_specific_force_g)
    assert found == pytest.approx(REFERENCE[state, knots, heading_deg], rel=0.15)


def test_more_roll_damping_and_less_speed_work_as_they_must() -> None:
    sea = Spectrum(*SEA_STATES[5]), Spreading("cos2")
    ship = load_ship("frigate")
    roll = {
        (knots, factor): spectral_deck_rms(
            ship, *sea, math.radians(90.0), knots * KNOT, roll_damping_factor=factor
        ).roll_deg
        for knots in (0.0, 10.0, 18.0)
        for factor in (0.7, 1.0, 1.3)
    }
    for factor in (0.7, 1.0, 1.3):
        assert roll[0.0, factor] > roll[10.0, factor] > roll[18.0, factor]
    # the resonance's square-root law, softened by what lies beside the resonance
    assert roll[10.0, 0.7] / roll[10.0, 1.0] == pytest.approx(1.20, abs=0.05)
    assert roll[10.0, 1.3] / roll[10.0, 1.0] == pytest.approx(0.88, abs=0.04)


# --- loading -------------------------------------------------------------------------------------------------------


def test_the_same_description_is_the_same_ship(tmp_path: Path) -> None:
    assert load_ship("frigate") is load_ship("frigate")
    assert load_ship(load_ship("frigate")) is load_ship("frigate")
    assert load_ship(document()) is load_ship(document())
    file = tmp_path / "own.yaml"
    file.write_text(yaml.safe_dump(document() | {"name": "own"}), encoding="utf-8")
    assert load_ship(file) is load_ship(str(file))
    assert load_ship(file).name == "own"


def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    file.write_text(yaml.safe_dump(document()), encoding="utf-8")
    before = hull_of(load_ship(file)).gm_m
    file.write_text(yaml.safe_dump(document() | {"kg_m": 5.9}), encoding="utf-8")
    assert hull_of(load_ship(file)).gm_m == pytest.approx(before + 0.3)


def test_metacentric_height_instead_of_the_height_of_gravity() -> None:
    ship = load_ship({"base": "frigate", "gm_m": 0.9})
    assert hull_of(ship).gm_m == pytest.approx(0.9)
    assert hull_of(ship).loading.kg_m == pytest.approx(6.2 + hull_of(load_ship("frigate")).gm_m - 0.9)


def test_changes_of_a_ship_leave_the_rest_and_its_marks() -> None:
    changed = load_ship({"base": "frigate", "name": "stiff", "roll_damping": {"z0": 0.05}, "kg_m": 6.0})
    damping = changed.description.roll_damping
    assert damping is not None and damping.z0 == 0.05
    assert damping.z_rate == load_ship("frigate").description.roll_damping.z_rate  # type: ignore[union-attr]
    assert "roll_damping.z_rate" in changed.description.marks
    assert not {"roll_damping.z0", "kg_m"} & set(changed.description.marks)
    assert hull_of(load_ship("frigate")).loading.kg_m == 6.2


def test_paths_are_taken_from_the_ships_folder(tmp_path: Path) -> None:
    shutil.copy(DATA / "frigate.npz", tmp_path / "my_hull.npz")
    changed = document()
    changed["hull"]["database"] = "my_hull.npz"
    (tmp_path / "own.yaml").write_text(yaml.safe_dump(changed), encoding="utf-8")
    assert hull_of(load_ship(tmp_path / "own.yaml")).mass_kg == hull_of(load_ship("frigate")).mass_kg


def test_a_table_of_responses_makes_a_ship(tmp_path: Path) -> None:
    rows = ["speed_kn,heading_deg,omega_rad_s,heave_m_per_m,heave_phase_deg,roll_deg_per_m,roll_phase_deg"]
    for heading in range(0, 360, 30):
        rows += [f"10,{heading},{omega},0.8,180,2.0,90" for omega in (0.3, 0.6, 0.9, 1.2)]
    (tmp_path / "rao.csv").write_text("\n".join(rows), encoding="utf-8")
    description = {"name": "measured", "response": {"table": "rao.csv"}, "deck_point_m": [-30.0, 0.0, -5.0]}
    (tmp_path / "measured.yaml").write_text(yaml.safe_dump(description), encoding="utf-8")
    ship = load_ship(tmp_path / "measured.yaml")
    assert isinstance(ship.response, ResponseTable)
    assert "rao.csv" in ship.summary()
    answer = ship.response.respond(np.array([0.6]), np.array([1.0]), np.array([1.0]), 10.0 * KNOT)
    assert answer.transfer[0, 2] == pytest.approx(-0.8)
    assert math.isnan(answer.roll_damping)


# --- mistakes ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("corvette", r"none called 'corvette': give one of destroyer, frigate, or the path of a YAML file"),
        ("nowhere.yaml", r"nowhere\.yaml: there is no such ship file"),
        (7, r"ships: 7 is refused: give a name"),
        ({"base": "corvette"}, r"none called 'corvette'"),
        ({"base": "frigate", "kg_m": -1.0}, r"frigate with changes: kg_m = -1.0 is refused: .*greater than 0"),
        ({"base": "frigate", "kg_m": 9.0}, r"ship frigate: hull frigate: kg_m is 9, allowed is less than 7\.38 m"),
        ({"base": "frigate", "kg_m": 6.0, "gm_m": 1.0}, r"either kg_m or gm_m"),
        ({"base": "frigate", "kg": 6.0}, r"kg = 6.0 is refused: the key is unknown here"),
        (
            {"base": "frigate", "roll_damping": {"z1": 6.0}},
            r"roll_damping.z1 = 6.0 is refused: .* known are z0, z_speed, z_rate",
        ),
        ({"base": "frigate", "hull": {"scale": 0.0}}, r"hull.scale = 0.0 is refused"),
        ({"base": "frigate", "hull": {"database": "tanker"}}, r"tanker.*frigate"),
        ({"base": "frigate", "response": {"table": "x.csv"}}, r"either a hull or a response"),
        ({"base": "frigate", "hull": None}, r"either a hull or a response"),
        ({"base": "frigate", "gyration": None}, r"gyration = None is refused: a hull needs it"),
        ({"base": "frigate", "deck_point_m": [1.0, 2.0]}, r"deck_point_m"),
        ({"base": "frigate", "deck_point_m": [1.0, 2.0, math.nan]}, r"deck_point_m.2 = nan is refused"),
        ({"name": "bare"}, r"ship: .*(hull|deck_point_m)"),
        (
            {"name": "t", "response": {"table": "x.csv"}, "kg_m": 6.0, "deck_point_m": [0.0, 0.0, 0.0]},
            r"kg_m = 6.0 is refused: a ship whose response is a table does not have it",
        ),
        ({"name": "t", "response": {"table": "x.csv"}, "deck_point_m": [0.0, 0.0, 0.0]}, r"x\.csv.*cannot be read"),
    ],
)
def test_mistakes_cost_one_sentence(given: Any, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message) as refused:
        load_ship(given)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_a_description(tmp_path: Path) -> None:
    file = tmp_path / "ship.yaml"
    file.write_text("name: [broken", encoding="utf-8")
    with pytest.raises(ConfigurationError, match="not valid YAML"):
        load_ship(file)
    file.write_text("", encoding="utf-8")
    with pytest.raises(ConfigurationError, match="must hold a mapping"):
        load_ship(file)
