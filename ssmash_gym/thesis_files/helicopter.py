"""HELI.INP and the helicopter: 68 lines of numbers to a document, and back.

Almost all of it is the table of paths in `heli_layout`. What is not: a second tire of zeros is no tire, a line of an
element that the station does not have is not used, one number of steer friction and one of steer damping serve all
stations, and a prismatic station whose orientation is zero takes that of INITIALS.INP without its steer angle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from ssmash_gym.thesis_files.conditions import normalised
from ssmash_gym.thesis_files.heli_layout import HELI
from ssmash_gym.thesis_files.layout import STATIONS, Column, Line
from ssmash_gym.thesis_files.paths import MISSING, get, put, with_lists
from ssmash_gym.thesis_files.reading import Row, Rows
from ssmash_gym.vehicle import GasOleo, Helicopter

PRISMATIC: Final = 1  # on line 32
ORIENTATIONS: Final = (23, 24, 25)  # lines of Euler parameters
# Points that the description gives from its reference point, the files from the c.g.
_POINTS: Final = (
    "stations.*.mount_m",
    "stations.*.arm.helicopter_point_m",
    "aerodynamics.centre_of_pressure_m",
    "probe.mount_m",
)


def document(rows: Rows, initials: Rows | None = None) -> dict[str, Any]:
    """What 68 lines say of a helicopter, in the form of its document; what they do not say is not there.

    Args:
        rows: Numbers of the lines.
        initials: Those of INITIALS.INP, for stations whose orientation is zero.
    """
    tree: dict[str, Any] = {}
    for line, numbers in _used(rows):
        taken = normalised(numbers) if line.number in ORIENTATIONS else numbers
        for column, number in zip(line.columns, taken, strict=True):
            put(tree, column.path, column.value(number))
    for i, name in enumerate(STATIONS):
        station = tree["stations"][name]
        if station["kind"] == "prismatic" and initials is not None and not any(rows[22 + i]):
            station["orientation"] = list(unsteered(normalised(initials[3 + i])))
    made: dict[str, Any] = with_lists(tree)
    return made


def _used(rows: Rows) -> Iterator[tuple[Line, Row]]:
    """The lines that say something of this helicopter; types first, so that what hangs on them is known."""
    kinds, springs = rows[31], rows[61]
    order = sorted(zip(HELI, rows, strict=True), key=lambda pair: pair[0].number not in (32, 62))
    for line, numbers in order:
        if line.number in range(26, 32) and kinds[(line.number - 26) % 3] != 2:
            continue
        if line.number in (57, 59, 61) and not any(numbers):
            continue
        if line.number in range(63, 66) and springs[line.number - 63] != 1:
            continue
        if line.number in range(66, 69) and springs[line.number - 66] != 2:
            continue
        if line.number in (35, 36):
            for name in STATIONS:
                column = replace(line.columns[0], path=line.columns[0].path.replace("*", name))
                yield replace(line, columns=(column,)), numbers
            continue
        yield line, numbers


def unsteered(parameters: Sequence[float]) -> tuple[float, float, float, float]:
    """Euler parameters of a frame before its turn about its own z axis (the steering).

    Args:
        parameters: Euler parameters O to H, steered.

    Returns:
        Those of the frame that turned about its own z becomes this one, by the smallest rotation.
    """
    e0, e1, e2, e3 = parameters
    turn = math.hypot(e0, e3)
    if turn < 1e-9:
        return e0, e1, e2, e3
    c, s = e0 / turn, e3 / turn
    return turn, c * e1 - s * e2, c * e2 + s * e1, 0.0


def tilt(one: Sequence[float], other: Sequence[float]) -> float:
    """Angle between the z axes of two frames [rad], from their Euler parameters O to H."""
    a0, a1, a2, a3 = one
    b0, b1, b2, b3 = other
    x = a0 * b1 - a1 * b0 - a2 * b3 + a3 * b2
    y = a0 * b2 + a1 * b3 - a2 * b0 - a3 * b1
    return 2.0 * math.asin(min(1.0, math.hypot(x, y)))


def rows(filed: Mapping[str, Any]) -> Rows:
    """The numbers of the 68 lines of a document in the files' form, see `filed`."""
    return tuple(tuple(_number(column, filed) for column in line.columns) for line in HELI)


def _number(column: Column, filed: Mapping[str, Any]) -> float:
    """The number of a column; 0 where the helicopter has no such thing."""
    value = get(filed, column.path)
    return 0.0 if value is MISSING or value is None else column.number(value)


def filed(helicopter: Helicopter) -> dict[str, Any]:
    """The plain document of a helicopter as the files can say it: coordinates from the c.g., slopes as numbers."""
    plain: dict[str, Any] = helicopter.model_dump(mode="json", exclude={"provenance"})
    for name, station in zip(STATIONS, helicopter.station_tuple, strict=True):
        if isinstance(station.spring, GasOleo):
            spring = plain["stations"][name]["spring"]
            spring["e1_Npm"], spring["e2_Npm"] = station.spring.region4[0], station.spring.region5[0]
    if any(helicopter.cg_offset_m):
        plain["cg_offset_m"] = [0.0, 0.0, 0.0]
        for pattern in _POINTS:
            for path in (pattern.replace("*", name) for name in STATIONS if "*" in pattern or name == STATIONS[0]):
                point = get(plain, path)
                if point is not MISSING and point is not None:
                    put(plain, path, [a - b for a, b in zip(point, helicopter.cg_offset_m, strict=True)])
    return plain
