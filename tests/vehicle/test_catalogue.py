"""The catalogue: marks at every number, nothing lost on the way through files, and helicopters that stand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from scipy.optimize import root

import ssmash_gym.assets
from ssmash_gym.assets import asset_path
from ssmash_gym.document import read_yaml, split
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.vehicle import (
    Helicopter,
    Station,
    Tire,
    document_of,
    helicopter_from,
    helicopter_names,
    load_helicopter,
    save_helicopter,
    with_changes,
)
from ssmash_gym.vehicle.geometry import lowest_points, rotation, strut_length

NAMES = ("generic_tricycle", "seahawk_like")


# --- marks and files ---------------------------------------------------------------------------------------


def is_number(node: Any) -> bool:
    return isinstance(node, int | float) and not isinstance(node, bool)


def numbers(node: Any, path: str = "") -> list[str]:
    """Paths of all numbers under a plain node."""
    if is_number(node):
        return [path]
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list | tuple) else ()
    return [found for key, child in items for found in numbers(child, f"{path}.{key}".lstrip("."))]


def marks_above(node: Any, path: str = "", marks: int = 0) -> dict[str, int]:
    """How many marks each number of a raw file stands under."""
    if is_number(node):
        return {path: marks}
    found: dict[str, int] = {}
    if isinstance(node, dict) and "origin" in node:
        assert node["origin"] in ("source", "derived", "fitted", "assumed")
        return marks_above(node["value"], path, marks + 1)
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in items:
        found |= marks_above(child, f"{path}.{key}".lstrip("."), marks)
    return found


def written(node: Any) -> Any:
    """A plain node without the keys that hold nothing."""
    if isinstance(node, dict):
        return {key: written(child) for key, child in node.items() if child is not None}
    return [written(child) for child in node] if isinstance(node, list) else node


def test_names() -> None:
    assert helicopter_names() == sorted(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_every_number_of_a_catalogue_file_carries_exactly_one_mark(name: str) -> None:
    raw = yaml.safe_load(asset_path("configs", "helicopters", f"{name}.yaml").read_text(encoding="utf-8"))
    counted = marks_above(raw)
    assert set(counted.values()) == {1}, [path for path, count in counted.items() if count != 1]
    helicopter = load_helicopter(name)
    plain = helicopter.model_dump(mode="json", exclude={"provenance"})
    assert sorted(numbers(plain)) == sorted(counted)  # the files leave nothing to defaults
    marked = [found for path in helicopter.marks for found in numbers(helicopter.value(path), path)]
    assert sorted(marked) == sorted(counted)


@pytest.mark.parametrize("name", NAMES)
def test_origins_can_be_listed(name: str) -> None:
    helicopter = load_helicopter(name)
    assert helicopter.name == name
    by_origin = [helicopter.values_of_origin(o) for o in ("source", "derived", "fitted", "assumed")]
    assert sum(map(len, by_origin)) == len(helicopter.provenance)
    assumed = by_origin[3]
    assert assumed["probe.ultimate_load_N"] == helicopter.probe.ultimate_load_N
    assert "mass_kg" not in assumed


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_nothing_is_lost_from_file_to_object_to_file(name: str, suffix: str, tmp_path: Path) -> None:
    helicopter = load_helicopter(name)
    file = tmp_path / f"copy{suffix}"
    save_helicopter(helicopter, file)
    again = load_helicopter(file)
    assert again == helicopter
    assert document_of(again) == document_of(helicopter)
    original = yaml.safe_load(asset_path("configs", "helicopters", f"{name}.yaml").read_text(encoding="utf-8"))
    plain, marks = split(original, "original")
    plain_again, marks_again = split(document_of(again), "copy")
    assert written(plain_again) == written(plain)
    assert sorted(map(str, marks_again)) == sorted(map(str, marks))


def test_free_play_of_the_steering_goes_into_a_file_and_comes_back(tmp_path: Path) -> None:
    play = {"play_rad": {"value": 0.0175, "origin": "assumed"}, "stop_stiffness_Nmprad": 1e5, "stop_damping_Nmspr": 1e2}
    tricycle = load_helicopter("generic_tricycle")
    helicopter = with_changes(tricycle, {"stations.right.steer_play": play})
    save_helicopter(helicopter, tmp_path / "play.yaml")
    again = load_helicopter(tmp_path / "play.yaml")
    assert again == helicopter != tricycle
    assert again.values_of_origin("assumed")["stations.right.steer_play.play_rad"] == 0.0175
    assert with_changes(again, {"stations.right.steer_play": None}).stations.right == tricycle.stations.right


def test_the_dumped_model_builds_the_same_helicopter() -> None:
    helicopter = load_helicopter("seahawk_like")
    assert helicopter_from(json.loads(helicopter.model_dump_json())) == helicopter
    assert Helicopter.model_validate(helicopter.model_dump()) == helicopter


def test_numbers_that_plain_yaml_would_read_as_text() -> None:
    read = read_yaml("a: 1e6\nb: 2.5E-3\nc: -1e+3\nd: .5e1\ne: e6\nf: 1.5\n", "here")
    assert read == {"a": 1e6, "b": 2.5e-3, "c": -1e3, "d": 5.0, "e": "e6", "f": 1.5}


def test_a_file_is_saved_under_a_known_suffix_only(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"must end in one of \.yaml"):
        save_helicopter(load_helicopter("seahawk_like"), tmp_path / "copy.txt")
    assert not (tmp_path / "copy.txt").exists()


def test_assets_are_found_in_the_installed_package_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "site" / "ssmash_gym"
    inside = package / "_assets" / "configs" / "helicopters"
    inside.mkdir(parents=True)
    save_helicopter(with_changes(load_helicopter("seahawk_like"), {"name": "packed"}), inside / "packed.yaml")
    monkeypatch.setattr(ssmash_gym.assets, "_PACKAGE", package)
    assert helicopter_names() == ["packed"]
    assert load_helicopter("packed").name == "packed"
    with pytest.raises(FileNotFoundError, match="configs/ships"):
        asset_path("configs", "ships")


# --- changes -----------------------------------------------------------------------------------------------


def test_changes_make_a_validated_copy() -> None:
    helicopter = load_helicopter("generic_tricycle")
    changed = with_changes(
        helicopter,
        {
            "mass_kg": np.float64(9000.0),
            "stations.*.tires.*.friction_coefficient": np.float32(0.5),
            "cg_offset_m": np.array([0.5, 0.0, 0.0]),
            "stations.right.mount_m.1": 1.7,
            "probe.active": False,
            "stations.auxiliary.steering": "locked",
            "surroundings.gravity_mps2": {"value": 9.80665, "origin": "source", "note": "standard gravity"},
            "stations.left.spring": {"type": "linear_strut", "stiffness_Npm": 2.0e5, "damping_Nspm": 1.0e4},
        },
    )
    assert helicopter == load_helicopter("generic_tricycle")
    assert changed.mass_kg == 9000.0
    assert [t.friction_coefficient for s in changed.station_tuple for t in s.tires] == [0.5] * 6
    assert changed.cg_offset_m == (0.5, 0.0, 0.0)
    assert changed.stations.right.mount_m == (helicopter.stations.right.mount_m[0], 1.7, 1.17)
    assert not changed.probe.active
    assert changed.stations.auxiliary.steering == "locked"
    assert changed.stations.left.spring.type == "linear_strut"


def test_a_changed_number_no_longer_claims_its_old_origin() -> None:
    helicopter = load_helicopter("generic_tricycle")
    changed = with_changes(
        helicopter,
        {
            "mass_kg": 9000.0,
            "stations.right.mount_m.1": 1.7,
            "surroundings.gravity_mps2": {"value": 9.80665, "origin": "source", "note": "standard gravity"},
            "stations.left.spring": {"type": "linear_strut", "stiffness_Npm": 2.0e5, "damping_Nspm": 1.0e4},
        },
    )
    lost = {path for path in set(helicopter.marks) - set(changed.marks) if not path.startswith("stations.left.spring.")}
    assert lost == {"mass_kg", "stations.right.mount_m"}
    assert not any(path.startswith("stations.left.spring") for path in changed.marks)
    assert changed.marks["surroundings.gravity_mps2"].origin == "source"
    assert helicopter_from(document_of(changed)) == changed


def test_no_changes_change_nothing() -> None:
    helicopter = load_helicopter("seahawk_like")
    assert with_changes(helicopter, {}) == helicopter


# --- the catalogue's helicopters stand as they should --------------------------------------------------------

Array = NDArray[np.float64]


def tire_load(tire: Tire, deflection: float, atmosphere: float) -> float:
    """Smiley and Horne's vertical law, by hand: (2.118)-(2.125)."""
    if deflection <= 0.0:
        return 0.0
    w, d, c = tire.width_m, tire.diameter_m, tire.vertical_constant
    x = deflection / w
    pressure = tire.pressure_Pa + 1.5 * w / d * (tire.pressure_Pa + atmosphere) * x * x
    shape = 0.96 * x + 0.216 * x * x / c if x <= 10.0 * c / 3.0 else 2.4 * (x - c)
    return float((pressure + 0.08 * tire.rated_pressure_Pa) * w * np.sqrt(w * d) * shape)


def about_y(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def placed(station: Station, z: float, pitch: float, joint: float) -> tuple[float, float, list[float]]:
    """Depth of the carriage, oleo compression and tire deflections, for a body at depth z and a joint coordinate."""
    R_SH, R_HO, r_OW = about_y(pitch), rotation(station.orientation), np.array(station.droop_m)
    if station.kind == "prismatic":
        compression = joint
        turn = np.eye(3)
        r_OW = r_OW - [0.0, 0.0, joint]
    else:
        compression = strut_length(station) - strut_length(station, joint)
        turn = about_y(joint)
        r_OW = turn @ r_OW
    carriage = z + (R_SH @ (np.array(station.mount_m) + R_HO @ r_OW))[2]
    tires = [carriage + (R_SH @ R_HO @ turn @ np.array(t.position_m))[2] + 0.5 * t.diameter_m for t in station.tires]
    return carriage, compression, tires


def virtual_work(helicopter: Helicopter, q: Array) -> Array:
    """Generalized forces on (depth, pitch, three joints): weights, oleos, tires. All zero at rest on a flat deck."""
    gravity, atmosphere = helicopter.surroundings.gravity_mps2, helicopter.surroundings.atmospheric_pressure_Pa
    work = np.zeros(5)
    work[0] = helicopter.mass_kg * gravity
    step = 1e-6
    for i, station in enumerate(helicopter.station_tuple):
        _, compression, tires = placed(station, q[0], q[1], q[2 + i])
        force = station.spring.gas_force(compression)[0]
        loads = [tire_load(t, d, atmosphere) for t, d in zip(station.tires, tires, strict=True)]
        for k in (0, 1, 2 + i):
            ahead, back = q.copy(), q.copy()
            ahead[k] += step
            back[k] -= step
            up, down = (placed(station, p[0], p[1], p[2 + i]) for p in (ahead, back))
            work[k] += station.mass_kg * gravity * (up[0] - down[0]) / (2 * step)
            work[k] -= force * (up[1] - down[1]) / (2 * step)
            work[k] -= sum(f * (a - b) for f, a, b in zip(loads, up[2], down[2], strict=True)) / (2 * step)
    return work


def at_rest(helicopter: Helicopter, guess: list[float]) -> tuple[Array, list[float], list[float]]:
    found = root(lambda q: virtual_work(helicopter, q) / 1e4, guess, tol=1e-10)
    assert found.success
    atmosphere = helicopter.surroundings.atmospheric_pressure_Pa
    loads, compressions = [], []
    for i, station in enumerate(helicopter.station_tuple):
        _, compression, tires = placed(station, found.x[0], found.x[1], found.x[2 + i])
        loads.append(sum(tire_load(t, d, atmosphere) for t, d in zip(station.tires, tires, strict=True)))
        compressions.append(compression)
    return found.x, loads, compressions


def test_the_tricycle_stands_as_table_3_1_says() -> None:
    helicopter = load_helicopter("generic_tricycle")
    assert helicopter.total_mass_kg == pytest.approx(10450.0, abs=1e-9)
    q, loads, compressions = at_rest(helicopter, [-2.3, 0.0, 0.25, 0.2, 0.2])
    assert loads == pytest.approx([34999.0, 33758.0, 33758.0], abs=20.0)
    assert sum(loads) == pytest.approx(102514.5, rel=1e-5)
    assert q[0] == pytest.approx(-2.292, abs=0.0015)
    assert np.degrees(q[1]) == pytest.approx(0.436, abs=0.005)
    assert compressions[0] == pytest.approx(0.277, abs=0.0015)
    tip = q[0] + (about_y(q[1]) @ np.add(helicopter.probe.mount_m, helicopter.probe.vector_m))[2]
    assert 0.0 < tip < 0.01  # just below the claw plane at deck level: it can be captured, and is not stretched


def test_the_tricycle_s_wheels_hang_where_the_drop_starts() -> None:
    helicopter = load_helicopter("generic_tricycle")
    nose, right, left = (lowest_points(station) for station in helicopter.station_tuple)
    assert nose[:, 2] == pytest.approx([2.626] * 2, abs=0.002)  # some 0.07 m
    assert np.concatenate([right, left])[:, 2] == pytest.approx([2.5] * 4)  # 0.2 m clearance from 2.7 m
    assert nose[:, 0] == pytest.approx([helicopter.stations.auxiliary.mount_m[0] - 0.05] * 2)  # the trail
    assert right[:, 1].mean() == pytest.approx(helicopter.stations.right.mount_m[1])
    assert left[:, 1].mean() == pytest.approx(-right[:, 1].mean())


def test_the_seahawk_like_stands_sensibly() -> None:
    helicopter = load_helicopter("seahawk_like")
    assert helicopter.total_mass_kg == pytest.approx(9927.0)
    q, loads, compressions = at_rest(helicopter, [-2.0, 0.0, 0.15, -0.2, -0.2])
    assert abs(np.degrees(q[1])) < 0.5
    assert sum(loads) == pytest.approx(9927.0 * 9.81, rel=1e-5)
    assert loads[1] == pytest.approx(loads[2], rel=1e-9)
    assert 0.15 < loads[0] / sum(loads) < 0.35
    assert loads[0] / 2 < 12.23e3  # rated load of a tail tire, 2750 lb
    assert loads[1] < 43.15e3  # rated load of a main tire, 9700 lb
    for station, compression in zip(helicopter.station_tuple, compressions, strict=True):
        assert 0.35 < compression / station.end_stop.stroke_m < 0.65
    tip = q[0] + (about_y(q[1]) @ np.add(helicopter.probe.mount_m, helicopter.probe.vector_m))[2]
    assert 0.0 < tip < 0.01


def test_the_tail_wheel_trails_its_steer_axis() -> None:
    tail = load_helicopter("seahawk_like").stations.auxiliary
    assert tail.steering == "free"
    assert len(tail.tires) == 2
    assert tail.mount_m[0] < 0.0
    assert tail.droop_m[0] < 0.0


@pytest.mark.parametrize("name", NAMES)
def test_left_mirrors_right(name: str) -> None:
    stations = load_helicopter(name).stations
    mirror = np.array([1.0, -1.0, 1.0])
    assert np.array(stations.left.mount_m) == pytest.approx(stations.right.mount_m * mirror)
    assert np.array(stations.left.droop_m) == pytest.approx(stations.right.droop_m * mirror)
    assert stations.left.spring == stations.right.spring
    if stations.left.arm is not None and stations.right.arm is not None:
        assert np.array(stations.left.arm.arm_point_m) == pytest.approx(stations.right.arm.arm_point_m * mirror)
        assert strut_length(stations.left) == pytest.approx(strut_length(stations.right), abs=1e-12)
