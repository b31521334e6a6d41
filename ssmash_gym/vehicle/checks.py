"""Checks that need more than one number: springs that push back, wheels that reach the deck."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from ssmash_gym.fields import refuse
from ssmash_gym.vehicle.geometry import lowest_points, rotation, strut_lengths
from ssmash_gym.vehicle.oleo import GasOleo, cubic_slope

if TYPE_CHECKING:
    from ssmash_gym.vehicle.description import Helicopter
    from ssmash_gym.vehicle.station import Station

GREATEST_DECK_TILT_DEG: Final = 10.0  # between the helicopter's x-y plane and the plane its tires touch
LEAST_WHEEL_SPREAD_M: Final = 0.1  # least height of the triangle of the three stations
LEAST_LEVER: Final = 0.05  # least shortening of a strut per rise of the wheel [1]
ARM_SWEEP: Final = np.linspace(0.0, np.pi / 2.0, 181)
FALL_TOLERANCE: Final = 1.0e-9  # of the spring rate


def check_oleo(oleo: GasOleo, stroke: float) -> None:
    """Refuse an oleo whose spring force falls somewhere between full droop and the end of the stroke.

    Args:
        oleo: The gas oleo.
        stroke: Length of the stroke [m].

    Raises:
        PydanticCustomError: The gas volume is exhausted within the stroke, or the force falls.
    """
    exhausted = oleo.gas_volume_m3 / oleo.piston_area_m2
    if stroke >= exhausted:
        raise refuse(
            "spring.gas_volume_m3",
            oleo.gas_volume_m3,
            f"the gas volume must last for the stroke of {stroke:g} m, that is exceed stroke times piston area = "
            f"{stroke * oleo.piston_area_m2:.6g} m3",
        )
    slope, x = _least_slope_region2(oleo)
    if x < stroke and slope < -FALL_TOLERANCE * oleo.extension_stiffness_Npm:
        raise refuse(
            "spring.extension_stiffness_Npm",
            oleo.extension_stiffness_Npm,
            f"the oleo force must not fall with compression, but at x = {x:.4g} m (region 2) its slope is {slope:.4g} "
            f"N/m; {_allowed_stiffness(oleo)}",
        )
    _check_cubic("1", oleo.region4, oleo.x1_m, min(oleo.x2_m, stroke))
    _check_cubic("2", oleo.region5, oleo.x2_m, stroke)


def _allowed_stiffness(oleo: GasOleo) -> str:
    """Words for the stiffness below which region 2 never falls: a cubic rises if both end slopes are <= 3 F(x0)/x0."""
    force, end_slope = oleo.gas_force(oleo.x0_m)
    if end_slope * oleo.x0_m <= 3.0 * force:
        return f"up to 3 F(x0)/x0 = {3.0 * force / oleo.x0_m:.4g} N/m is always allowed"
    return (
        f"3 F(x0)/x0 and less would be allowed if F'(x0) x0, here {end_slope * oleo.x0_m:.4g} N, were at most "
        f"3 F(x0), here {3.0 * force:.4g} N (a shorter x0_m, a higher gas pressure)"
    )


def _least_slope_region2(oleo: GasOleo) -> tuple[float, float]:
    """Least slope of the cubic through region 2 [N/m], and where it is [m].

    The cubic starts at 0 with slope k and meets the gas law at ``x0`` in value and slope, (2.204)-(2.211).
    """
    x0, k = oleo.x0_m, oleo.extension_stiffness_Npm
    force, end_slope = oleo.gas_force(x0)
    mean = force / x0
    # slope(s) = k + 2 c s + 3 d s^2 on s = x/x0 in [0, 1], scaled with x0
    c = 3.0 * mean - end_slope - 2.0 * k
    d = end_slope + k - 2.0 * mean
    turning = [-c / (3.0 * d)] if d > 0.0 and 0.0 < -c / (3.0 * d) < 1.0 else []
    return min((k + 2.0 * c * s + 3.0 * d * s * s, s * x0) for s in (0.0, 1.0, *turning))


def _check_cubic(number: str, constants: tuple[float, float, float], start: float, end: float) -> None:
    if end <= start:
        return
    span = end - start
    _, f, g = constants
    turning = [-f / (3.0 * g)] if g > 0.0 and 0.0 < -f / (3.0 * g) < span else []
    slope, d = min((cubic_slope(constants, d), d) for d in (0.0, span, *turning))
    if slope < 0.0:
        raise refuse(
            f"spring.g{number}_Npm3" if g < 0.0 else f"spring.f{number}_Npm2",
            g if g < 0.0 else f,
            f"the oleo force must not fall within the stroke, but at x = {start + d:.4g} m (region {3 + int(number)}) "
            f"its slope is {slope:.4g} N/m",
        )


def check_swing_arm(station: Station) -> None:
    """Refuse a swing arm whose strut does not shorten as its wheel rises, over the whole stroke.

    Raises:
        PydanticCustomError: The geometry is not usable.
    """
    x, _, z = station.droop_m
    R_HO = rotation(station.orientation)
    rise = -np.array(np.cross(R_HO[:, 1], R_HO @ np.array(station.droop_m)))[2]  # of the wheel, per turn about o_y
    if abs(rise) < LEAST_LEVER * max(np.hypot(x, z), 1e-9):
        raise refuse(
            "droop_m", station.droop_m, "the arm must reach forward or aft of its pivot, else the wheel cannot rise"
        )
    angles = np.sign(rise) * ARM_SWEEP
    lengths = strut_lengths(station, angles)
    shortening = (lengths[0] - lengths[1]) / (abs(rise) * (ARM_SWEEP[1] - ARM_SWEEP[0]))
    assert station.arm is not None
    if shortening < LEAST_LEVER:
        raise refuse(
            "arm.helicopter_point_m",
            station.arm.helicopter_point_m,
            f"the strut must shorten by at least {LEAST_LEVER:g} m for each metre the wheel rises at full droop, here "
            f"it is {shortening:.3g} m",
        )
    turning = int(np.argmax(np.append(np.diff(lengths) >= 0.0, True)))  # up to here the strut only shortens
    available = lengths[0] - lengths[turning]
    if station.end_stop.stroke_m > available:
        raise refuse(
            "end_stop.stroke_m",
            station.end_stop.stroke_m,
            f"the arm's geometry shortens the strut by {available:.4g} m at most",
        )


def check_reach(helicopter: Helicopter) -> None:
    """Refuse a helicopter that cannot stand on its three stations.

    Raises:
        PydanticCustomError: A wheel, the body or the probe lies on the wrong side of the deck.
    """
    feet = []
    for name, station in zip(("auxiliary", "right", "left"), helicopter.station_tuple, strict=True):
        points = lowest_points(station)
        key = f"stations.{name}.droop_m"
        if abs(rotation(station.orientation)[2, 1]) > 0.5:
            raise refuse(f"stations.{name}.orientation", station.orientation, "the axle must lie across, not upright")
        if points[:, 2].min() <= station.mount_m[2]:
            raise refuse(key, station.droop_m, "the wheels cannot reach the deck: each tire must end below its mount")
        feet.append(points.mean(axis=0))
    auxiliary, right, left = feet
    normal = np.cross(left - auxiliary, right - auxiliary)
    longest = max(np.linalg.norm(right - left), np.linalg.norm(right - auxiliary), np.linalg.norm(left - auxiliary))
    if np.linalg.norm(normal) < LEAST_WHEEL_SPREAD_M * longest:
        raise refuse(
            "stations.auxiliary.mount_m",
            helicopter.stations.auxiliary.mount_m,
            f"the three stations must not lie on one line: at least {LEAST_WHEEL_SPREAD_M:g} m off it",
        )
    normal = normal / np.linalg.norm(normal) * (1.0 if normal[2] >= 0.0 else -1.0)
    tilt = float(np.degrees(np.arccos(np.clip(normal[2], -1.0, 1.0))))
    if tilt > GREATEST_DECK_TILT_DEG:
        raise refuse(
            "stations.auxiliary.droop_m",
            helicopter.stations.auxiliary.droop_m,
            f"the wheels cannot reach the deck together: the plane under them is tilted by {tilt:.3g} deg, at most "
            f"{GREATEST_DECK_TILT_DEG:g} deg is allowed",
        )
    for key, point in (("cg_offset_m", helicopter.cg_offset_m), ("probe.mount_m", helicopter.probe.mount_m)):
        if float(normal @ (auxiliary - np.array(point))) <= 0.0:
            raise refuse(
                key, point, "the wheels cannot reach the deck: this point must lie above the plane under the wheels"
            )
