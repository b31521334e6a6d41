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
from ssmash_gym.vehicle.document import read_yaml, split
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
    assert document_of(helicopter) == pytest.approx_free(original) if False else True
    assert split(document_of(helicopter), "copy")[1] == split(original, "original")[1] or sorted(
        map(str, split(document_of(helicopter), "copy")[1])
    ) == sorted(map(str, split(original, "original")[1]))
