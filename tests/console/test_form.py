"""The console's form: JSON schemas and values, changes that mean what the same YAML means, one-sentence mistakes."""

import json
from pathlib import Path

import pytest

from ssmash_gym.console.form import FILES, Bases, checked, form_of, yaml_files
from ssmash_gym.document import write_yaml
from ssmash_gym.envs.given import as_helicopter
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition

FORM = form_of(Bases())
CHANGES = {
    "scenario": {
        "motion": {"heading_deg": 60.5, "hs_m": {"uniform": [2.0, 3.0]}, "sea_state": None},
        "start": {"yaw_deg": {"normal": [0.0, 3.0], "within": [-8.0, 8.0]}},
    },
    "task": {"limits": {"probe_in_plane_kN": 12.5}, "claw": {"speed_along_m_s": 0.2}},
    "helicopter": {"mass_kg": 9000.5, "stations.right.tires.0.pressure_Pa": 900000.5},
}


def _from_files(files: dict[str, str], folder: Path) -> Condition:
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    scenario, task, helicopter = (folder / FILES[kind] for kind in ("scenario", "task", "helicopter"))
    return Condition("files", "", load_task(task), load_scenario(scenario), as_helicopter(helicopter))


def test_the_form_is_json_and_offers_the_catalogue() -> None:
    again = json.loads(json.dumps(FORM, allow_nan=False))
    assert again["names"]["scenario"] and set(again["names"]["ship"]) == {"destroyer", "frigate"}
    for kind, names in again["names"].items():
        assert set(again["values"][kind]) == set(names)
        assert again["schemas"][kind]["properties"].keys() >= again["values"][kind][names[0]].keys()


@pytest.mark.parametrize("scenario", FORM["names"]["scenario"])
def test_every_scenario_comes_back_from_its_yaml(scenario: str, tmp_path: Path) -> None:
    task = "straighten" if scenario == "straighten" else "traverse"
    condition = checked({"scenario": scenario, "task": task}, {})
    again = _from_files(yaml_files(condition), tmp_path)
    assert again.scenario == condition.scenario
    assert again.configuration == condition.configuration


@pytest.mark.parametrize("helicopter", FORM["names"]["helicopter"])
def test_every_helicopter_comes_back_with_its_marks(helicopter: str, tmp_path: Path) -> None:
    condition = checked({"helicopter": helicopter}, {})
    again = _from_files(yaml_files(condition), tmp_path)
    assert again.helicopter == condition.helicopter
    assert again.configuration == condition.configuration


def test_changes_mean_what_the_same_yaml_means(tmp_path: Path) -> None:
    """By hand: a file with the changed values in place of the old ones."""
    scenario = load_scenario("ss5").model_dump(mode="json", exclude_unset=True)
    scenario["motion"] |= CHANGES["scenario"]["motion"]
    scenario["start"] |= CHANGES["scenario"]["start"]
    (tmp_path / "own.yaml").write_text(write_yaml(scenario), encoding="utf-8")
    by_hand = Condition(
        "by hand",
        "",
        load_task({"base": "traverse", **CHANGES["task"]}),
        load_scenario(tmp_path / "own.yaml"),
        as_helicopter({"base": "generic_tricycle", **CHANGES["helicopter"]}),
    )
    condition = checked({"scenario": "ss5"}, CHANGES)
    assert condition.configuration == by_hand.configuration != checked({}, {}).configuration
    assert _from_files(yaml_files(condition), tmp_path).configuration == condition.configuration


def test_a_changed_ship_and_another_motion_come_back(tmp_path: Path) -> None:
    ship = {"scenario": {"motion": {"ship": {"base": "destroyer", "gm_m": 1.5}}}}
    sine = {
        "scenario": {
            "motion": {"type": "sinusoid", "dof": "roll", "amplitude": 4.0, "period_s": 11.0},
            "wind": {"type": "free", "speed_mps": 5.0},
        }
    }
    for changes in (ship, sine):
        condition = checked({}, changes)
        again = _from_files(yaml_files(condition), tmp_path)
        assert again.configuration == condition.configuration != checked({}, {}).configuration


MISTAKES = [
    ({"scenario": "sea"}, {}, "base: scenario = 'sea'"),
    ({"scenario": "/etc/passwd"}, {}, "base: scenario"),
    ({"sea": "ss5"}, {}, "no key sea"),
    ([], {}, "must be a mapping"),
    ({}, {"ship": {}}, "no key ship"),
    ({}, {"scenario": {"base": "calm"}}, "scenario.base is refused"),
    ({}, {"scenario": {"motion": {"sea_state": 9}}}, "sea_state = 9"),
    ({}, {"scenario": {"motion": {"speed_kn": {"uniform": [10, 0]}}}}, "speed_kn"),
    ({}, {"scenario": {"motion": {"ship": {"base": "frigate", "gm_m": -1.0}}}}, "gm_m = -1.0"),
    ({}, {"task": {"limits": {"probe_in_plane_kN": -2.0}}}, "limits.probe_in_plane_kN = -2.0"),
    ({}, {"task": {"horizon_s": 60.03}}, "horizon_s = 60.03"),
    ({}, {"task": {"limits": {"probe_ultimate_kN": 900.0}}}, "limits.probe_ultimate_kN = 900"),
    ({}, {"helicopter": {"mass_kg": float("nan")}}, "mass_kg"),
    ({}, {"helicopter": {"stations.middle.mass_kg": 1.0}}, "stations.middle.mass_kg"),
]


@pytest.mark.parametrize(("base", "changes", "words"), MISTAKES)
def test_a_mistake_costs_one_sentence(base: object, changes: object, words: str) -> None:
    with pytest.raises(ConfigurationError) as refusal:
        checked(base, changes)
    message = str(refusal.value)
    assert words in message and message.endswith(".") and "\n" not in message


def test_what_the_console_was_started_with_is_a_base_too(tmp_path: Path) -> None:
    own = tmp_path / "own.yaml"
    own.write_text("motion: {type: fixed, heel_deg: 2}\n", encoding="utf-8")
    also = Bases(scenario=str(own))
    assert form_of(also)["values"]["scenario"][str(own)]["motion"]["heel_deg"] == {"constant": 2.0}
    assert checked({}, {}, also).scenario == load_scenario(own)
    assert checked({"scenario": "calm"}, {}, also).scenario == load_scenario("calm")


@pytest.mark.parametrize(
    "motion",
    [
        {"type": "file", "paths": ["records/x.dat"]},
        {"ship": "own/ship.yaml"},
        {"ship": {"base": "../ship.yaml"}},
        {"ship": {"base": "frigate", "hull": {"database": "own/x.npz"}}},
    ],
)
def test_a_page_from_elsewhere_names_no_files(motion: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError, match="names a file"):
        checked({}, {"scenario": {"motion": motion}}, files=False)


def test_without_files_the_catalogue_stays() -> None:
    changes = {"scenario": {"motion": {"ship": {"base": "destroyer", "gm_m": 1.5}, "sea_state": 4}}}
    assert checked({}, changes, files=False).configuration == checked({}, changes).configuration
