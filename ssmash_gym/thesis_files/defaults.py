"""What a case needs and the thesis' files do not say: the values that are taken where no sidecar gives them.

The one place for them. Values of a helicopter carry the mark "assumed" in the document that is read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, Final, cast

import numpy as np

from ssmash_gym.thesis_files.paths import expand, get, put

GAS_SHARE: Final = 0.92  # of the stroke at which the gas volume is exhausted; that of the generic tricycle
ARM_SHARE: Final = 0.9  # of the shortening that the arm's geometry allows
DROOP_SHARE: Final = 0.9  # of the carriage's distance from its mount at full droop
BOTTOMING_SHARE: Final = 0.15  # of the tire's diameter; the generic tricycle has 0.143 and 0.152
LONGEST_SUBSTEP_S: Final = 0.002
NEVER: Final = 1.0e12

Rule = Callable[[Mapping[str, Any], str], float]


@dataclass(frozen=True)
class Default:
    """One value that is taken.

    Attributes:
        path: Its path in a case's document; ``*`` for every station and tire.
        value: The value, or the rule that gives it.
        shown: The value in words.
        why: Where it comes from.
    """

    path: str
    value: Any
    shown: str
    why: str


def end_of_stroke(helicopter: Mapping[str, Any], path: str) -> float:
    """Stroke of a station [m]: short of what gas, arm or strut have room for; the thesis has no end of the stroke."""
    station = get(helicopter, ".".join(path.split(".")[:2]))
    spring = station["spring"]
    room = []
    if spring["type"] == "gas_oleo" and spring["piston_area_m2"] > 0.0:
        room.append(GAS_SHARE * spring["gas_volume_m3"] / spring["piston_area_m2"])
    if station["kind"] == "swing_arm":
        room.append(ARM_SHARE * _shortening(station))
    elif not room:
        room.append(DROOP_SHARE * station["droop_m"][2])
    return min(room, default=0.0)


def _shortening(station: Mapping[str, Any]) -> float:
    """Most that the strut of a swing arm shortens as its wheel rises [m]; 0 where the geometry is not usable."""
    from ssmash_gym.vehicle.checks import ARM_SWEEP
    from ssmash_gym.vehicle.geometry import rotation, strut_lengths
    from ssmash_gym.vehicle.station import Station

    if not any(station["orientation"]):
        return 0.0
    arm = SimpleNamespace(**station["arm"])
    geometry = SimpleNamespace(arm=arm, mount_m=station["mount_m"], orientation=station["orientation"])
    R_HO = rotation(station["orientation"])
    rise = -float(np.cross(R_HO[:, 1], R_HO @ np.array(station["droop_m"]))[2])
    lengths = strut_lengths(cast(Station, geometry), math.copysign(1.0, rise) * ARM_SWEEP)
    turning = int(np.argmax(np.append(np.diff(lengths) >= 0.0, True)))
    return float(lengths[0] - lengths[turning])


def bottoming(helicopter: Mapping[str, Any], path: str) -> float:
    """Deflection at which the rim is reached [m]."""
    diameter = get(helicopter, ".".join([*path.split(".")[:-1], "diameter_m"]))
    return BOTTOMING_SHARE * float(diameter)


def substep(output_step_s: float) -> float:
    """Step of the engine [s]: at most 2 ms, and a whole number of them from row to row."""
    return output_step_s / max(1, math.ceil(output_step_s / LONGEST_SUBSTEP_S - 1e-9))


_TIRES: Final = "stations.*.tires.*."
HELICOPTER: Final = (
    Default("cg_offset_m", [0.0, 0.0, 0.0], "0 0 0", "the files' coordinates are from the c.g."),
    Default("tire_model", "smiley_horne", "Smiley and Horne's equations", "the thesis' tire"),
    Default("stations.*.steer_decay_spr", 10.0, "10 s/rad", "as assumed for the generic tricycle"),
    Default(
        "stations.*.end_stop.stroke_m",
        end_of_stroke,
        f"{GAS_SHARE:g} V/A of a gas oleo, {DROOP_SHARE:g} of the droop length of a linear strut, and no more than "
        f"{ARM_SHARE:g} of what a swing arm allows",
        "the thesis' struts have no end; without one the gas law has a pole",
    ),
    Default("stations.*.end_stop.stiffness_Npm", 5.0e6, "5e6 N/m", "as assumed for the generic tricycle"),
    Default("stations.*.end_stop.damping_Nspm", 2.0e4, "2e4 N s/m", "as assumed for the generic tricycle"),
    Default("stations.*.spring.reference_pressure_Pa", 0.0, "0 Pa", "the thesis subtracts none"),
    Default(_TIRES + "rolling_decay_spm", 10.0, "10 s/m", "as assumed for the generic tricycle"),
    Default(_TIRES + "minimum_relaxation_m", 0.05, "0.05 m", "as assumed for the generic tricycle"),
    Default(
        _TIRES + "bottoming_deflection_m",
        bottoming,
        f"{BOTTOMING_SHARE:g} of the diameter",
        "the share of the generic tricycle",
    ),
    Default(_TIRES + "bottoming_stiffness_Npm", 5.0e6, "5e6 N/m", "as assumed for the generic tricycle"),
    Default(_TIRES + "pull_back_rate_ps", 100.0, "100 1/s", "numerical; any rate between 50 and 200 will do"),
    Default(_TIRES + "pitch_moment_coefficient", 0.25, "0.25", "Léveillé 2013 (2.159); the sign could not be settled"),
    Default("probe.capture_radius_m", 0.05, "0.05 m", "the thesis has no law of capture"),
    Default("probe.ultimate_load_N", NEVER, "1e12 N, never", "the thesis' probe does not break"),
    Default("surroundings.gravity_mps2", 9.81, "9.81 m/s2", "case 2 of Table 3.1"),
    Default("surroundings.air_density_kgpm3", 1.225, "1.225 kg/m3", "standard atmosphere at sea level"),
    Default("surroundings.atmospheric_pressure_Pa", 101325.0, "101325 Pa", "standard atmosphere at sea level"),
)

# Of the other sections of a case; where `value` is None the case's own default stands.
CASE: Final = (
    Default("model.contact", None, "contact", "where the tire's travel is taken; `centre` is the thesis'"),
    Default("model.friction", None, "limit_surface", "friction limit of the tires; `independent` is the thesis'"),
    Default("model.probe_law", None, "potential", "law of the probe; `printed` is the thesis'"),
    Default("solution.substep_s", None, "2 ms or the next shorter whole share of line 2", "step of the engine"),
    Default("deck.rates", "body", "body", "columns 8-10 and 14-16 of shipmo.inp: components in ship axes, (2.20)"),
    Default("deck.euler_order", "zyx", "zyx", "sequence of the ship's angles: yaw, pitch, roll"),
    Default("deck.detrend", False, "false", "mean velocity and heading of shipmo.inp stay, as the wind needs them"),
)


def fill(helicopter: dict[str, Any], given: set[str]) -> dict[str, Default]:
    """Put the defaults into a helicopter's document.

    Args:
        helicopter: What the files say; changed in place.
        given: Paths for which no default is to be taken.

    Returns:
        What has been taken, by full path.
    """
    taken = {}
    for default in HELICOPTER:
        for path in expand(helicopter, default.path):
            if path in given or _belongs_elsewhere(helicopter, path):
                continue
            put(helicopter, path, default.value(helicopter, path) if callable(default.value) else default.value)
            taken[path] = default
    return taken


def _belongs_elsewhere(helicopter: Mapping[str, Any], path: str) -> bool:
    """Whether a key of gas oleos is at a linear strut."""
    keys = path.split(".")
    return keys[0] == "stations" and keys[2] == "spring" and get(helicopter, ".".join(keys[:3]))["type"] != "gas_oleo"
