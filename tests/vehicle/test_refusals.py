"""Every mistake costs one sentence that names the file, the key, the value and what is allowed."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.document import read_yaml, write_yaml
from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.vehicle import document_of, helicopter_from, load_helicopter, with_changes

OLEO = "stations.auxiliary.spring"
PLAY = {"play_rad": 0.0175, "stop_stiffness_Nmprad": 1.2e5, "stop_damping_Nmspr": 350.0}

TRICYCLE: list[tuple[dict[str, Any], tuple[str, ...]]] = [
    ({"mass_kg": -1.0}, ("mass_kg = -1.0", "greater than 0")),
    ({"stations.left.mass_kg": 0.0}, ("stations.left.mass_kg = 0.0", "greater than 0")),
    ({"mass_kg": float("nan")}, ("mass_kg = nan", "finite")),
    ({"mass_kg": "heavy"}, ("mass_kg = 'heavy'", "must be a number")),
    ({"mass_kg": True}, ("mass_kg = True", "must be a number")),
    ({"probe.active": 1}, ("probe.active = 1", "true or false")),
    ({"stations.right.kind": "ski"}, ("stations.right.kind = 'ski'", "'prismatic' or 'swing_arm'")),
    ({"stations.right.tires": []}, ("stations.right.tires = []", "at least 1")),
    ({f"{OLEO}.type": "bungee"}, (OLEO, "'gas_oleo', 'linear_strut'")),
    (
        {"inertia_kgm2": [[16e3, 1.0, 0], [2.0, 56e3, 0], [0, 0, 50e3]]},
        ("inertia_kgm2", "symmetric", "(1,2) is 1", "(2,1) is 2"),
    ),
    ({"inertia_kgm2": [[16e3, 0, 0], [0, -56e3, 0], [0, 0, 50e3]]}, ("inertia_kgm2", "positive definite", "-56000")),
    (
        {"inertia_kgm2": [[16e3, 0, 0], [0, 80e3, 0], [0, 0, 50e3]]},
        ("inertia_kgm2", "triangle inequality", "16000, 50000, 80000"),
    ),
    (
        {"stations.right.inertia_kgm2": [[1, 0, 0], [0, 1, 0], [0, 0, 3]]},
        ("stations.right.inertia_kgm2", "triangle inequality"),
    ),
    (
        {f"{OLEO}.extension_stiffness_Npm": 5.0e6},
        (f"{OLEO}.extension_stiffness_Npm = 5000000.0", "must not fall", "region 2", "is always allowed"),
    ),
    ({f"{OLEO}.x1_m": 0.46}, (f"{OLEO}.x1_m = 0.46", "V/A = 0.4548")),
    ({f"{OLEO}.x0_m": 0.42}, (f"{OLEO}.x0_m = 0.42", "less than x1_m")),
    ({f"{OLEO}.x2_m": 0.41}, (f"{OLEO}.x2_m = 0.41", "at least x1_m")),
    ({f"{OLEO}.relief_2_N": 5.0}, (f"{OLEO}.relief_2_N = 5.0", "at least relief_1_N")),
    (
        {"stations.auxiliary.end_stop.stroke_m": 0.46},
        (f"{OLEO}.gas_volume_m3 = 0.0020", "stroke of 0.46 m", "exceed"),
    ),
    (
        {f"{OLEO}.x1_m": 0.3, f"{OLEO}.x2_m": 0.35, f"{OLEO}.g1_Npm3": -1.0e9},
        (f"{OLEO}.g1_Npm3 = -1000000000.0", "must not fall", "region 4"),
    ),
    (
        {f"{OLEO}.x1_m": 0.3, f"{OLEO}.x2_m": 0.35, f"{OLEO}.f2_Npm2": -1.0e8},
        (f"{OLEO}.f2_Npm2 = -100000000.0", "must not fall", "region 5"),
    ),
    ({"stations.right.kind": "swing_arm"}, ("stations.right.arm = None", "two mounts")),
    ({"stations.right.arm": {"helicopter_point_m": [0, 0, 0], "arm_point_m": [0, 0, 1]}}, ("prismatic", "swing_arm")),
    ({"stations.right.droop_m": [0, 0, -1.0]}, ("stations.right.droop_m", "below the mount")),
    ({"stations.*.mount_m": [0, 0, -3.0]}, ("stations.auxiliary.mount_m", "one line")),
    ({"stations.auxiliary.droop_m": [0, 0, 3.0]}, ("stations.auxiliary.droop_m", "cannot reach the deck", "10 deg")),
    ({"cg_offset_m": [0, 0, 3.0]}, ("cg_offset_m = (0.0, 0.0, 3.0)", "cannot reach the deck")),
    ({"probe.mount_m": [0, 0, 3.0]}, ("probe.mount_m = (0.0, 0.0, 3.0)", "cannot reach the deck")),
    ({"stations.auxiliary.mount_m": [-1.9, 0, 1.17]}, ("stations.auxiliary.mount_m", "one line")),
    ({"stations.right.orientation": [0.7071068, 0.7071068, 0, 0]}, ("stations.right.orientation", "across")),
    ({"stations.right.orientation": [1, 0.1, 0, 0]}, ("stations.right.orientation", "norm 1", "1.00499")),
    ({"probe.vector_m": [1.0, 0, 0.01]}, ("probe.vector_m = (1.0, 0.0, 0.01)", "parallel to the deck")),
    ({"probe.vector_m": [0, 0, 0]}, ("probe.vector_m", "parallel to the deck")),
    ({"stations.right.tires.0.axle_radius_m": 0.4}, ("tires.0.axle_radius_m = 0.4", "tire radius 0.33")),
    ({"stations.right.tires.0.bottoming_deflection_m": 0.4}, ("bottoming_deflection_m = 0.4", "0.33")),
    ({"tire_model": "linear", "stations.right.tires.1.linear": None}, ("stations.right.tires.1.linear", "constants")),
    ({"mass_kg": {"value": 1.0, "origin": "guess"}}, ("mass_kg.origin = 'guess'", "source, derived, fitted, assumed")),
    ({"mass_kg": {"value": 1.0, "reason": "x"}}, ("mass_kg", "{value: ..., origin:")),
    (
        {"stations.auxiliary.steer_play": PLAY},
        ("stations.auxiliary.steer_play = 0.0175", "prismatic", "locked steering", "leave the key"),
    ),
    ({"stations.right.steer_play": {**PLAY, "play_rad": 0.5}}, ("right.steer_play.play_rad = 0.5", "at most 0.35")),
    ({"stations.right.steer_play": {**PLAY, "play_rad": -0.1}}, ("right.steer_play.play_rad = -0.1", "at least 0 ")),
    (
        {"stations.right.steer_play": {**PLAY, "stop_stiffness_Nmprad": 0.0}},
        ("right.steer_play.stop_stiffness_Nmprad = 0.0", "greater than 0"),
    ),
    (
        {"stations.right.steer_play": {**PLAY, "stop_stiffness_Nmprad": 5.1e5, "stop_damping_Nmspr": 1.0e4}},
        ("right.steer_play.stop_stiffness_Nmprad = 510000.0", "Izz of 8 kg m2", "at most 500000 N m/rad", "250 rad/s"),
    ),
    (
        {"stations.right.steer_play": {**PLAY, "stop_damping_Nmspr": 90.0}},
        ("right.steer_play.stop_damping_Nmspr = 90.0", "Izz of 8 kg m2", "at least 97.9796 N m s/rad", "5 % of the"),
    ),
    ({"mass": 1.0}, ("no key mass",)),
    ({"stations.right.tires.2.width_m": 1.0}, ("no key stations.right.tires.2.width_m",)),
]

SEAHAWK: list[tuple[dict[str, Any], tuple[str, ...]]] = [
    ({"stations.right.steering": "free"}, ("stations.right.steering = 'free'", "swing arm", "locked")),
    ({"stations.right.steer_play": PLAY}, ("stations.right.steer_play = 0.0175", "only a prismatic station")),
    ({"stations.left.arm": None}, ("stations.left.arm = None", "two mounts")),
    ({"stations.right.droop_m": [0, 0.1, 0.5]}, ("stations.right.droop_m", "forward or aft")),
    ({"stations.right.arm.helicopter_point_m": [1.27, 1.22, 2.5]}, ("right.arm.helicopter_point_m", "shorten")),
    (
        {"stations.right.arm.helicopter_point_m": [1.12, 1.22, 1.37]},
        ("stations.right.end_stop.stroke_m = 0.3", "shortens the strut by 0.2", "at most"),
    ),
]


def check_sentence(text: str, fragments: tuple[str, ...]) -> None:
    assert "\n" not in text
    assert text.endswith(".")
    for fragment in fragments:
        assert fragment in text


@pytest.mark.parametrize(("changes", "fragments"), TRICYCLE)
def test_tricycle_refusals(changes: dict[str, Any], fragments: tuple[str, ...]) -> None:
    with pytest.raises(ConfigurationError) as caught:
        with_changes(load_cached("generic_tricycle"), changes)
    check_sentence(str(caught.value), fragments)


@pytest.mark.parametrize(("changes", "fragments"), SEAHAWK)
def test_swing_arm_refusals(changes: dict[str, Any], fragments: tuple[str, ...]) -> None:
    with pytest.raises(ConfigurationError) as caught:
        with_changes(load_cached("seahawk_like"), changes)
    check_sentence(str(caught.value), fragments)


_loaded: dict[str, Any] = {}


def load_cached(name: str) -> Any:
    if name not in _loaded:
        _loaded[name] = load_helicopter(name)
    return _loaded[name]


@pytest.mark.parametrize(
    ("path", "fragments"),
    [
        ("colour", ("colour = 3", "unknown", "known are name, description")),
        ("stations.right.tires.0.diamter_m", ("stations.right.tires.0.diamter_m = 3", "did you mean diameter_m?")),
        (f"{OLEO}.gas_presure_Pa", (f"{OLEO}.gas_presure_Pa = 3", "did you mean gas_pressure_Pa?")),
    ],
)
def test_unknown_keys_in_a_file(tmp_path: Path, path: str, fragments: tuple[str, ...]) -> None:
    document = document_of(load_cached("generic_tricycle"))
    node: Any = document
    *parents, key = path.split(".")
    for parent in parents:
        node = node[int(parent) if parent.isdigit() else parent]
    node[key] = 3
    file = tmp_path / "mine.yaml"
    file.write_text(write_yaml(document), encoding="utf-8")
    with pytest.raises(ConfigurationError) as caught:
        load_helicopter(file)
    check_sentence(str(caught.value), (str(file), *fragments))


def test_a_missing_key_says_what_it_means(tmp_path: Path) -> None:
    document = document_of(load_cached("generic_tricycle"))
    del document["stations"]["left"]["spring"]["piston_area_m2"]
    with pytest.raises(ConfigurationError) as caught:
        helicopter_from(document, "mine")
    check_sentence(str(caught.value), ("mine: stations.left.spring.piston_area_m2 is missing", "Piston area", "[m2]"))


@pytest.mark.parametrize(
    ("text", "fragments"),
    [
        ("a: 1\nb: 2\na: 3\n", ("here, line 1", "the key a is written twice")),
        ("a: [1, 2\nb: 3\n", ("here, line", "not valid YAML")),
        ("- 1\n- 2\n", ("here", "mapping")),
    ],
)
def test_broken_files(text: str, fragments: tuple[str, ...]) -> None:
    with pytest.raises(ConfigurationError) as caught:
        read_yaml(text, "here")
    check_sentence(str(caught.value), fragments)


def test_unknown_names_and_files(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"'hovercraft'.*generic_tricycle, seahawk_like.*path"):
        load_helicopter("hovercraft")
    with pytest.raises(ConfigurationError, match="no such helicopter file"):
        load_helicopter(tmp_path / "none.yaml")
    with pytest.raises(ConfigurationError, match="no such helicopter file"):
        load_helicopter("none.yaml")


def test_a_kink_between_oleo_regions_is_a_warning() -> None:
    tricycle = load_cached("generic_tricycle")
    slope = tricycle.stations.auxiliary.spring.region4[0]
    with pytest.warns(ConfigurationWarning, match=r"e1_Npm = 1000 N/m puts a kink .* at x1_m"):
        with_changes(tricycle, {f"{OLEO}.e1_Npm": 1000.0, f"{OLEO}.e2_Npm": 1000.0})
    with pytest.warns(ConfigurationWarning, match=r"e2_Npm = 1000 N/m puts a kink .* at x2_m"):
        with_changes(tricycle, {f"{OLEO}.e2_Npm": 1000.0})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with_changes(tricycle, {f"{OLEO}.e1_Npm": slope, f"{OLEO}.f1_Npm2": 1.0e6})  # e2 follows by itself


def test_region_2_is_refused_exactly_when_its_force_falls() -> None:
    """Random springs: the closed form of the check against the sampled cubic of (2.204)."""
    rng = np.random.default_rng(7)
    tricycle = load_cached("generic_tricycle")
    gas = tricycle.stations.auxiliary.spring
    refused = 0
    for k, x0 in zip(10 ** rng.uniform(5.5, 7.5, 60), rng.uniform(0.002, 0.03, 60), strict=True):
        x = np.linspace(0.0, x0, 20001)
        force, slope = gas.gas_force(x0)
        c = (3 * force - slope * x0 - 2 * k * x0) / x0**2
        d = (slope * x0 - 2 * force + k * x0) / x0**3
        falls = bool(np.any(np.diff(k * x + c * x**2 + d * x**3) < -1e-9 * k * x[1]))
        try:
            with_changes(tricycle, {f"{OLEO}.extension_stiffness_Npm": float(k), f"{OLEO}.x0_m": float(x0)})
        except ConfigurationError:
            refused += 1
            assert falls, (k, x0)
        else:
            assert not falls, (k, x0)
    assert 10 < refused < 50
