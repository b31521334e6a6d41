"""The other systems of the thesis: each is a configuration that does what its page says, and no more."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ssmash_gym.cases import Case, History, case_document, case_from, load_case, quantity, run_case
from ssmash_gym.dynamics.layout import State
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.systems import System, apply, label, load_system, system_from, system_names, why_not
from ssmash_gym.systems.rigid_suspension import corners
from ssmash_gym.vehicle import load_helicopter

ROOT = Path(__file__).resolve().parents[2]
HELICOPTERS = ("generic_tricycle", "seahawk_like")
STRUTS = ["u13", "u15", "u17"]
STEERS = ["u14", "u16", "u18"]


def short(**changes: Any) -> Case:
    """A second on a level deck."""
    return case_from(
        {
            "name": "short",
            "helicopter": "generic_tricycle",
            "solution": {"end_s": 1.0, "output_step_s": 0.02},
            **changes,
        }
    )


def values(history: History, name: str) -> NDArray[np.float64]:
    return quantity(name).of(history)


def at_rest(system: str, **changes: Any) -> History:
    """A history that begins at the rest."""
    solution = {"end_s": 0.02, "output_step_s": 0.02}
    return run_case(apply(load_system(system), short(**{"solution": solution, **changes})))


# --- the catalogue ---------------------------------------------------------------------------------------------


def test_the_catalogue_has_the_systems_of_the_thesis_and_the_full_model_first() -> None:
    names = system_names()
    assert names[0] == "ssmash"
    assert {"blackwell_feik", "dynaface_like", "dynaface_like_linear", "heliman_like", "feldman_scale"} < set(names)
    for name in names:
        system = load_system(name)
        assert system.name == name
        assert "Léveillé 2013" in system.source
        assert system.answers and system.cannot


def test_every_system_has_its_place_on_the_page() -> None:
    page = (ROOT / "docs" / "guide" / "systems.md").read_text(encoding="utf-8")
    for name in system_names():
        assert f"`{name}`" in page
        assert load_system(name).title.split(",")[0].split(" (")[0].casefold() in page.casefold()


def test_the_full_model_changes_nothing(rolling_traverse: Case) -> None:
    assert case_document(apply(load_system("ssmash"), rolling_traverse)) == case_document(rolling_traverse)


@pytest.mark.parametrize("name", ["Blackwell-Feik", "blackwell_feik", "BLACKWELL_FEIK"])
def test_capitals_and_hyphens_of_a_name_do_not_matter(name: str) -> None:
    assert load_system(name).name == "blackwell_feik"


def test_an_unknown_system_costs_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"^There is no system 'blackwel': give one of ssmash, .*\.$"):
        load_system("blackwel")
    with pytest.raises(ConfigurationError, match=r"none\.yaml: there is no such system file\.$"):
        load_system(tmp_path / "none.yaml")


SOUND = {"name": "mine", "title": "Mine", "source": "nowhere"}


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        ({"held": ["u6"]}, "held.0 = 'u6' is refused"),
        ({"deck": "flat"}, "deck = 'flat' is refused"),
        ({"model": {"friction": "none"}}, "model"),
        ({"model": {"tires": "round"}}, "tires"),
        ({"scale": 0.0}, "scale = 0.0 is refused"),
        ({"scales": 0.5}, "scales"),
        ({"title": ""}, "title = '' is refused"),
    ],
)
def test_a_mistake_in_a_system_costs_one_sentence(broken: dict[str, Any], words: str) -> None:
    assert isinstance(system_from(SOUND), System)
    with pytest.raises(ConfigurationError, match=words) as refused:
        system_from({**SOUND, **broken}, "mine.yaml")
    assert str(refused.value).startswith("mine.yaml: ")
    assert str(refused.value).count("\n") == 0


def test_a_change_that_the_helicopter_does_not_know_is_refused() -> None:
    system = system_from({**SOUND, "changes": {"wings": 2}})
    with pytest.raises(ConfigurationError, match="there is no key wings in a helicopter"):
        apply(system, short())


def test_a_further_system_is_one_file(tmp_path: Path) -> None:
    file = tmp_path / "no_yaw.yaml"
    file.write_text("title: Full model without yaw\nsource: this test\nheld: [u12]\nprobe: 'off'\n", encoding="utf-8")
    system = load_system(file)
    case = short(deck={"type": "sinusoid", "dof": "roll", "amplitude_deg": 3.0, "period_s": 5.0})
    history = run_case(apply(system, case))
    assert system.name == "no_yaw"
    assert np.all(history.states[State.U12] == 0.0)
    assert np.all(history["probe_in_plane"] == 0.0)
    assert np.ptp(values(history, "roll_deg")) > 0.1


# --- what each system holds, leaves out and keeps --------------------------------------------------------------


@pytest.mark.parametrize("name", ["blackwell_feik", "heliman_like"])
def test_held_speeds_stay_exactly_zero(name: str, runs: dict[str, History]) -> None:
    system = load_system(name)
    held = [State[speed.upper()] for speed in system.held]
    assert held
    assert np.all(runs[name].states[held] == 0.0)
    free = [row for row in range(State.U7, State.U12 + 1) if row not in held]
    assert all(np.ptp(runs[name].states[row]) > 0.0 for row in free)


def test_heliman_is_planar(runs: dict[str, History]) -> None:
    """Heave, roll, pitch and the vertical loads stay what they are at rest while the helicopter turns by 77 degrees."""
    history = runs["heliman_like"]
    assert np.ptp(values(history, "yaw_deg")) > 60.0
    assert np.ptp(values(history, "z_m")) == 0.0
    for name in ("roll_deg", "pitch_deg"):
        assert np.max(np.abs(values(history, name))) < 1e-4
    full = runs["ssmash"]
    for name in ("nose_load_kN", "right_load_kN", "left_load_kN"):
        assert np.ptp(values(history, name)) < 0.01
        assert values(history, name)[0] == pytest.approx(values(full, name)[0], rel=1e-3)
    assert np.all(history["deck_roll"] == 0.0)


@pytest.mark.parametrize("helicopter", HELICOPTERS)
def test_heliman_stands_level_where_the_full_model_stands(helicopter: str) -> None:
    planar, full = (at_rest(name, helicopter=helicopter) for name in ("heliman_like", "ssmash"))
    for name in ("nose_load_kN", "right_load_kN", "left_load_kN"):
        assert values(planar, name)[0] == pytest.approx(values(full, name)[0], rel=1e-3)
    for station in ("auxiliary", "right", "left"):
        assert planar[f"{station}_contact_x"][0] == pytest.approx(full[f"{station}_contact_x"][0], abs=2e-3)
    assert abs(values(planar, "pitch_deg")[0]) < 1e-4


def test_dynaface_neither_rolls_nor_steers(runs: dict[str, History]) -> None:
    """Unsecured on an inclined deck it stays within its tires' deflection, where the full model rolls away."""
    deck = {"type": "fixed", "pitch_deg": 4.0}
    case = short(deck=deck, changes={"probe.active": False}, start={"type": "settled", "surface": "level"})
    for name in ("dynaface_like", "dynaface_like_linear"):
        stays = run_case(apply(load_system(name), case))
        assert np.ptp(stays["right_contact_x"]) < 0.05
        assert np.max(np.abs(stays["right_tire_longitudinal_deflection"])) > 1e-3
        assert np.all(runs[name].states[[State[s.upper()] for s in STEERS]] == 0.0)
    rolls = run_case(case)
    assert np.ptp(rolls["right_contact_x"]) > 0.2


def test_dynaface_has_carriages_of_its_own(runs: dict[str, History]) -> None:
    for speed in STRUTS:
        assert np.ptp(runs["dynaface_like"].states[State[speed.upper()]]) > 0.0


def test_dynaface_with_linear_tires_is_linear() -> None:
    history = at_rest("dynaface_like_linear")
    tire = load_helicopter("generic_tricycle").stations.right.tires[0]
    assert tire.linear is not None
    expected = 2.0 * tire.linear.vertical_stiffness_Npm * history["right_tire_vertical_deflection"][0]
    assert history["right_vertical_load"][0] == pytest.approx(expected, rel=1e-9)


def test_blackwell_feels_no_wind_and_no_probe() -> None:
    case = short(
        changes={"aerodynamics.wind_N_mps": [0.0, 20.0, 0.0]},
        deck={"type": "sinusoid", "dof": "roll", "amplitude_deg": 3.0, "period_s": 5.0},
    )
    for name, wind in (("ssmash", True), ("dynaface_like", True), ("blackwell_feik", False)):
        history = run_case(apply(load_system(name), case))
        assert (history.largest("wind_fy") > 100.0) == wind
        assert (history.largest("probe_in_plane") > 10.0) == (name != "blackwell_feik")


# --- Blackwell and Feik: struts and tires in series ------------------------------------------------------------


@pytest.mark.parametrize("helicopter", HELICOPTERS)
def test_blackwell_stands_like_the_full_model(helicopter: str) -> None:
    """Static loads within 0.2 %, the c.g. within a millimetre, the attitude within 0.02 degrees."""
    rigid, full = (at_rest(name, helicopter=helicopter) for name in ("blackwell_feik", "ssmash"))
    for name in ("nose_load_kN", "right_load_kN", "left_load_kN"):
        assert values(rigid, name)[0] == pytest.approx(values(full, name)[0], rel=2e-3)
    assert values(rigid, "z_m")[0] == pytest.approx(values(full, "z_m")[0], abs=1e-3)
    assert values(rigid, "pitch_deg")[0] == pytest.approx(values(full, "pitch_deg")[0], abs=0.02)


@pytest.mark.parametrize("helicopter", HELICOPTERS)
def test_blackwell_touches_the_deck_where_the_full_model_does(helicopter: str) -> None:
    """Secant stiffness: the load goes from zero at the height of first touch to the static load at rest."""
    system = load_system("blackwell_feik")
    full = load_helicopter(helicopter)
    case = apply(system, short(helicopter=helicopter))
    for i, (name, corner) in enumerate(corners(full).items()):
        tire = case.vehicle.station_tuple[i].tires[0]
        assert tire.linear is not None
        travel = corner.rise_m + corner.deflection_m
        assert corner.tires * tire.linear.vertical_stiffness_Npm * travel == pytest.approx(corner.load_N)
        marks = case.vehicle.marks
        assert marks[f"stations.{name}.tires.0.linear.vertical_stiffness_Npm"].origin == "derived"
        assert tire.bottoming_stiffness_Npm == 0.0


def test_blackwell_heaves_at_the_frequency_of_its_springs() -> None:
    """Pushed down by 20 mm and let go: the period of mass on the three series springs, within 3 %."""
    rest = values(at_rest("blackwell_feik"), "z_m")[0]
    start = {"type": "drop", "cg_height_m": float(-rest - 0.02), "pitch_deg": 0.434}
    history = run_case(
        apply(load_system("blackwell_feik"), short(start=start, solution={"end_s": 3.0, "output_step_s": 0.002}))
    )
    helicopter = load_helicopter("generic_tricycle")
    stiffness = sum(corner.secant_Npm for corner in corners(helicopter).values())
    expected = 2.0 * np.pi * np.sqrt(helicopter.total_mass_kg / stiffness)
    away = values(history, "z_m") - rest
    crossings = np.flatnonzero(np.diff(np.sign(away)) != 0)
    measured = 2.0 * np.mean(np.diff(history.time_s[crossings[:4]]))
    assert measured == pytest.approx(expected, rel=0.03)
    assert 0.7 < 1.0 / measured < 1.5  # Hz


@pytest.mark.parametrize("helicopter", HELICOPTERS)
def test_the_secant_is_near_the_tangent_at_the_rest(helicopter: str) -> None:
    """What one linear spring cannot do: the sum is off by at most a fifth, one station by at most a half."""
    found = corners(load_helicopter(helicopter)).values()
    assert sum(c.secant_Npm for c in found) == pytest.approx(sum(c.tangent_Npm for c in found), rel=0.22)
    for corner in found:
        assert corner.secant_Npm == pytest.approx(corner.tangent_Npm, rel=0.5)


def test_blackwell_drops_like_the_full_model_until_a_wheel_touches() -> None:
    """The wheels touch in the same step; then a linear damper without dry friction lets it swing on about the rest."""
    case = load_case("1a")
    rigid = run_case(apply(load_system("blackwell_feik"), case))
    full = run_case(case)
    touch = [int(np.argmax(h["auxiliary_vertical_load"] > 0.0)) for h in (rigid, full)]
    assert touch[0] == pytest.approx(touch[1], abs=1)
    late = full.time_s > 2.0
    assert np.mean(values(rigid, "z_m")[late]) == pytest.approx(np.mean(values(full, "z_m")[late]), abs=0.005)
    assert np.ptp(values(rigid, "z_m")[late]) > 5.0 * np.ptp(values(full, "z_m")[late])


# --- what a system cannot do -----------------------------------------------------------------------------------


HEAVE = {"type": "sinusoid", "dof": "heave", "amplitude_m": 1.0, "period_s": 6.0}
FORWARD = {"type": "points", "time_s": [0, 1], "x_m": [0, 1], "y_m": [0, 0]}
SEA = {"type": "seaway", "ship": "frigate", "sea_state": 5, "heading_deg": 90.0, "speed_kn": 10.0}


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        ("heliman_like", {"start": {"type": "drop", "cg_height_m": 2.7}}, "start.type = drop"),
        ("heliman_like", {"deck": {"type": "fixed", "roll_deg": 5.0}}, "the deck is inclined, and with deck levelled"),
        ("heliman_like", {"deck": HEAVE}, "the deck moves, and with deck levelled"),
        ("dynaface_like", {"claw": FORWARD}, "the claw moves, and with claw held still"),
        ("blackwell_feik", {"changes": {"aerodynamics.wind_N_mps": [0.0, 9.0, 0.0]}}, "and with no wind nothing of it"),
        ("feldman_scale", {"deck": SEA}, "deck.type = 'seaway'"),
    ],
)  # fmt: skip
def test_what_a_system_cannot_do_it_says_in_one_sentence(name: str, changes: dict[str, Any], words: str) -> None:
    system, case = load_system(name), short(**changes)
    sentence = why_not(system, case)
    assert sentence is not None
    assert sentence.startswith(f"{name} cannot do case short: ") and sentence.endswith(".")
    assert words in sentence
    with pytest.raises(ConfigurationError) as refused:
        apply(system, case)
    assert str(refused.value) == sentence
    assert why_not(load_system("ssmash"), case) is None


def test_labels_say_what_is_left_out(rolling_traverse: Case) -> None:
    named = {name: label(load_system(name), rolling_traverse) for name in system_names()}
    assert named["ssmash"] == "ssmash"
    assert named["heliman_like"] == "heliman_like (deck levelled)"
    assert named["blackwell_feik"] == "blackwell_feik (claw held still, not secured)"
    assert named["dynaface_like"] == "dynaface_like (claw held still)"
    assert named["feldman_scale"] == "feldman_scale (1:10, scaled back)"
