"""Froude scaling of a description: every number by the power of the length scale that its unit asks for.

A model at the length scale ``L`` keeps gravity and the densities of air and material: mass goes with ``L^3``, time
with ``sqrt(L)``, force and weight with ``L^3``, pressure with ``L``, a velocity with ``sqrt(L)``; angles, accelerations
and coefficients stay. The exponent of a number is read from the unit at the end of its key (``_Nspm``: N s/m).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

from ssmash_gym.document import Mark
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.vehicle import Helicopter, helicopter_from

# Exponent of the length scale for each unit that keys are made of.
BASE: Final[Mapping[str, float]] = {
    "kg": 3.0,
    "m": 1.0,
    "s": 0.5,
    "N": 3.0,  # kg m/s2
    "Pa": 1.0,  # N/m2
    "rad": 0.0,
    "r": 0.0,  # rad, as in _spr and _Nmspr
    "deg": 0.0,
    "hz": -0.5,
}
# Numbers of a helicopter without a unit: ratios, coefficients, exponents, Euler parameters.
PURE: Final = frozenset(
    {
        "friction_coefficient",
        "rolling_resistance",
        "axle_friction",
        "vertical_constant",
        "pitch_moment_coefficient",
        "gas_exponent",
        "bearing_friction",
        "orientation",
    }
)
LEAST, GREATEST = 0.001, 1000.0  # length scales that make sense
_TOKEN: Final = re.compile("(" + "|".join(sorted(BASE, key=len, reverse=True)) + r")(\d?)")


def check_scale(scale: float) -> float:
    """The length scale as a float.

    Raises:
        ConfigurationError: It is not a number between `LEAST` and `GREATEST`.
    """
    if isinstance(scale, bool) or not isinstance(scale, int | float) or not LEAST <= scale <= GREATEST:
        raise ConfigurationError(
            f"scale = {scale!r} is refused: a length scale must be a number from {LEAST:g} to {GREATEST:g}, "
            "0.1 for a model of a tenth."
        )
    return float(scale)


def unit_exponent(unit: str) -> float | None:
    """Exponent of the length scale of a unit as keys write it; None where it is not one.

    Args:
        unit: For example ``Nspm`` (N s/m), ``kgm2`` (kg m2), ``ps`` (1/s), ``Ns2pm2`` (N s2/m2).
    """
    total, sign, rest = 0.0, 1.0, unit
    while rest:
        if rest[0] == "p" and sign > 0.0:  # what follows divides
            sign, rest = -1.0, rest[1:]
            continue
        token = _TOKEN.match(rest)
        if token is None:
            return None
        total += sign * BASE[token[1]] * int(token[2] or 1)
        rest = rest[token.end() :]
    return total if unit and not unit.endswith("p") else None


def exponent(key: str, pure: frozenset[str] = PURE) -> float:
    """Exponent of the length scale of the number that a key names.

    Args:
        key: Name of a field, its unit at the end.
        pure: Names of numbers without a unit.

    Raises:
        ConfigurationError: The key neither ends in a unit nor is a known number without one.
    """
    if key in pure:
        return 0.0
    found = unit_exponent(key.rpartition("_")[2]) if "_" in key else None
    if found is None:
        raise ConfigurationError(
            f"scaling: {key} ends in no unit that scaling knows ({', '.join(BASE)}, joined, p for per), nor is it a "
            "known number without a unit."
        )
    return found


def scaled_node(node: Any, scale: float, key: str = "", pure: frozenset[str] = PURE) -> Any:
    """A plain document with every number scaled by its key; texts, switches and nulls stay.

    Args:
        node: Mapping, list, number, text, switch or null.
        scale: Length scale.
        key: Key that the node stands under; a list's entries have its key.
        pure: Names of numbers without a unit.

    Raises:
        ConfigurationError: A number's key names no unit that scaling knows.
    """
    if isinstance(node, Mapping):
        return {name: scaled_node(child, scale, str(name), pure) for name, child in node.items()}
    if isinstance(node, Sequence) and not isinstance(node, str):
        return [scaled_node(child, scale, key, pure) for child in node]
    if isinstance(node, bool) or not isinstance(node, int | float):
        return node
    return node * scale ** exponent(key, pure)


def scaled(helicopter: Helicopter, scale: float) -> Helicopter:
    """A helicopter's model at a length scale: all its numbers, with what they are marked by.

    A published figure, scaled, is derived from it; what is fitted or assumed stays so. The pressures scale too, that
    of the atmosphere among them, which no workshop can do: see docs/guide/systems.md.

    Args:
        helicopter: The full-scale helicopter, left as it is.
        scale: Length of the model over that of the original.

    Raises:
        ConfigurationError: The scale makes no sense, or the scaled helicopter is refused.
    """
    scale = check_scale(scale)
    if scale == 1.0:
        return helicopter
    document = helicopter.model_dump(mode="json", exclude={"provenance"})
    plain = scaled_node(document, scale)
    plain["name"] = f"{helicopter.name}_{ratio(scale)}"
    plain["description"] = f"Froude-scaled {ratio(scale, ':')} from {helicopter.name}. {helicopter.description}".strip()
    plain["provenance"] = [_scaled_mark(helicopter, mark, scale) for mark in helicopter.provenance]
    return helicopter_from(plain, f"{helicopter.name} scaled {ratio(scale, ':')}")


def ratio(scale: float, between: str = "_to_") -> str:
    """A scale in words: ``1:10`` for 0.1, ``2:1`` for 2; `between` stands between the two numbers."""
    return f"1{between}{1.0 / scale:g}" if scale <= 1.0 else f"{scale:g}{between}1"


def _scaled_mark(helicopter: Helicopter, mark: Mark, scale: float) -> dict[str, str]:
    """The mark of a scaled value; one that does not change, a switch or a ratio, keeps its own."""
    key = next(part for part in reversed(mark.path.split(".")) if not part.isdigit())
    value = helicopter.value(mark.path)
    power = 0.0 if isinstance(value, bool | str) or value is None else exponent(key)
    if power == 0.0:
        return mark.model_dump()
    note = "; ".join(part for part in (mark.note, f"times {scale:g}^{power:g}") if part)
    return {"path": mark.path, "origin": "derived" if mark.origin == "source" else mark.origin, "note": note}
