"""Froude scaling: every number of a description has a unit that says how it scales, and bodies stay similar."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.systems.scaling import BASE, PURE, exponent, scaled, unit_exponent
from ssmash_gym.vehicle import Helicopter, load_helicopter
from ssmash_gym.vehicle.catalogue import _models_in

NAMES = ("generic_tricycle", "seahawk_like")
TRICYCLE = load_helicopter("generic_tricycle")


def numeric_fields() -> dict[str, str]:
    """Every field of a helicopter that holds numbers, with its description; found through the models themselves."""
    found: dict[str, str] = {}
    seen: set[type[BaseModel]] = set()
    waiting: list[type[BaseModel]] = [Helicopter]
    while waiting:
        part = waiting.pop()
        if part in seen:
            continue
        seen.add(part)
        for name, field in part.model_fields.items():
            waiting += _models_in(field.annotation)
            if "float" in str(field.annotation) and name != "provenance":
                found[name] = field.description or ""
    return found


def printed_exponent(description: str) -> float | None:
    """Exponent of the unit that a description ends in, as in ``[N s2/m2]``; None where it ends in none."""
    bracket = re.search(r"\[([^\]]*)\]\s*$", description)
    if bracket is None:
        return None
    over, _, under = bracket[1].partition("/")
    total = 0.0
    for part, sign in ((over, 1.0), (under, -1.0)):
        for token in part.split():
            if token != "1":
                name, power = re.fullmatch(r"([A-Za-z]+)(\d?)", token).groups()
                total += sign * BASE[name] * int(power or 1)
    return total


def test_every_number_of_a_helicopter_has_a_known_unit_and_its_description_names_the_same_one() -> None:
    fields = numeric_fields()
    assert len(fields) >= 90
    for name, description in fields.items():
        found = exponent(name)  # raises for a new field without a known unit
        printed = printed_exponent(description)
        if printed is not None:
            assert printed == found, f"{name}: {description}"
        else:
            assert name in PURE, f"{name}: its description does not end in a unit"
    assert set(fields) >= PURE


def test_a_number_without_a_known_unit_is_refused() -> None:
    for key in ("stiffness", "warmth_K", "length_furlong", "rate_p", "x_mp"):
        with pytest.raises(ConfigurationError, match=re.escape(key)):
            exponent(key)


@pytest.mark.parametrize(
    ("unit", "power"),
    [("m", 1), ("kg", 3), ("s", 0.5), ("kgm2", 5), ("N", 3), ("Nm", 4), ("Npm", 2), ("Npm2", 1), ("Npm3", 0),
     ("Nspm", 2.5), ("Ns2pm2", 2), ("Pa", 1), ("m3", 3), ("spm", -0.5), ("ps", -0.5), ("Nmprad", 4), ("Nmspr", 4.5),
     ("spr", 0.5), ("mps2", 0), ("mps", 0.5), ("kgpm3", 0), ("deg", 0), ("radps", -0.5)],
)  # fmt: skip
def test_exponents_of_units(unit: str, power: float) -> None:
    assert unit_exponent(unit) == power


@pytest.mark.parametrize("name", NAMES)
def test_a_scaled_helicopter_is_a_sound_helicopter(name: str) -> None:
    helicopter = load_helicopter(name)
    model = scaled(helicopter, 0.1)
    assert model.total_mass_kg == pytest.approx(1e-3 * helicopter.total_mass_kg)
    np.testing.assert_allclose(model.inertia_kgm2, 1e-5 * np.array(helicopter.inertia_kgm2), rtol=1e-12)
    assert model.surroundings.gravity_mps2 == helicopter.surroundings.gravity_mps2
    assert model.surroundings.air_density_kgpm3 == helicopter.surroundings.air_density_kgpm3
    assert model.surroundings.atmospheric_pressure_Pa == pytest.approx(10132.5)
    tire, small = helicopter.stations.right.tires[0], model.stations.right.tires[0]
    assert small.pressure_Pa == pytest.approx(0.1 * tire.pressure_Pa)
    assert small.friction_coefficient == tire.friction_coefficient
    assert {mark.path for mark in model.provenance} == {mark.path for mark in helicopter.provenance}
    assert model.marks["mass_kg"].origin == "derived"
    assert model.marks["probe.damping_x_Nspm"].origin == "assumed"
    assert "0.1^2.5" in model.marks["probe.damping_x_Nspm"].note


def test_scaling_there_and_back_gives_the_same_numbers() -> None:
    helicopter = load_helicopter("seahawk_like")
    back = scaled(scaled(helicopter, 0.1), 10.0)
    _assert_close(back.model_dump(exclude=_WORDS), helicopter.model_dump(exclude=_WORDS))
    assert scaled(helicopter, 1.0) == helicopter


_WORDS: Any = {"name", "description", "provenance"}


def _assert_close(a: Any, b: Any) -> None:
    if isinstance(b, dict):
        assert a.keys() == b.keys()
        for key in b:
            _assert_close(a[key], b[key])
    elif isinstance(b, list | tuple):
        for left, right in zip(a, b, strict=True):
            _assert_close(left, right)
    elif isinstance(b, float):
        assert a == pytest.approx(b, rel=1e-12, abs=0.0)
    else:
        assert a == b


@settings(max_examples=15, deadline=None)
@given(st.floats(0.05, 20.0))
def test_the_oleo_of_a_model_is_similar(scale: float) -> None:
    """Force with L^3 at a compression with L, slope with L^2: through the code of the gas law itself."""
    spring = TRICYCLE.stations.right.spring
    model = scaled(TRICYCLE, scale).stations.right.spring
    assert spring.type == model.type == "gas_oleo"
    force, slope = spring.gas_force(0.2)
    small_force, small_slope = model.gas_force(0.2 * scale)
    assert small_force == pytest.approx(scale**3 * force, rel=1e-9)
    assert small_slope == pytest.approx(scale**2 * slope, rel=1e-9)


@pytest.mark.parametrize("scale", [0.0, -1.0, 1e-6, float("nan"), True, "a tenth"])
def test_a_scale_that_makes_no_sense_costs_one_sentence(scale: Any) -> None:
    with pytest.raises(ConfigurationError, match="a length scale must be a number") as refused:
        scaled(TRICYCLE, scale)
    assert "\n" not in str(refused.value)
