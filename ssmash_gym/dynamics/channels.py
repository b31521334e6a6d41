"""The kernel's output rows: the sources of telemetry, each with its unit, frame, meaning and thesis symbol.

A new quantity is one member here and one `store` in the force element that computes it.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final

from ssmash_gym.dynamics.layout import STATIONS


class Channel(IntEnum):
    """Base of the output rows: an integer row that knows its unit, frame, meaning and thesis symbol."""

    unit: str
    frame: str
    meaning: str
    symbol: str

    def __new__(cls, unit: str, frame: str, meaning: str, symbol: str = "") -> Channel:
        """Number the members in the order they are written."""
        row = len(cls.__members__)
        member = int.__new__(cls, row)
        member._value_ = row
        member.unit, member.frame, member.meaning, member.symbol = unit, frame, meaning, symbol
        return member


class Out(Channel):
    """Output rows of the helicopter, the probe, the claw and the deck."""

    PROBE_FX = ("N", "H", "securing-probe force on the helicopter, x", "F^P_x")
    PROBE_FY = ("N", "H", "securing-probe force on the helicopter, y", "F^P_y")
    PROBE_FZ = ("N", "H", "securing-probe force on the helicopter, z", "F^P_z")
    PROBE_IN_PLANE = ("N", "H", "magnitude of the in-plane probe force", "|F^P_plane|")
    PROBE_AXIAL = ("N", "H", "axial probe tension", "F^P_z,d + F^P_z,v")
    PROBE_DX = ("m", "H", "probe point from the claw centre, x", "-delta_x")
    PROBE_DY = ("m", "H", "probe point from the claw centre, y", "-delta_y")
    PROBE_EXTENSION = ("m", "H", "axial probe extension", "delta_z")
    PROBE_REACH = ("1", "H", "length factor of the probe: 1 when its undeflected tip lies in the claw plane", "d_b")
    ROLL = ("rad", "S", "helicopter roll relative to the deck (yaw-pitch-roll angles)", "")
    PITCH = ("rad", "S", "helicopter pitch relative to the deck", "")
    YAW = ("rad", "S", "helicopter yaw relative to the deck", "")
    CLAW_X = ("m", "S", "claw centre, x, ripple included", "r^RSD_x")
    CLAW_Y = ("m", "S", "claw centre, y, ripple included", "r^RSD_y")
    CLAW_VX = ("m/s", "S", "claw velocity, x", "")
    CLAW_VY = ("m/s", "S", "claw velocity, y", "")
    PROBE_X = ("m", "S", "probe point b in the claw plane, x", "r^b_x")
    PROBE_Y = ("m", "S", "probe point b in the claw plane, y", "r^b_y")
    DECK_ROLL = ("rad", "N", "ship roll", "")
    DECK_PITCH = ("rad", "N", "ship pitch", "")
    DECK_YAW = ("rad", "N", "ship yaw", "")
    DECK_WX = ("rad/s", "S", "ship angular velocity, x", "u4")
    DECK_WY = ("rad/s", "S", "ship angular velocity, y", "u5")
    DECK_WZ = ("rad/s", "S", "ship angular velocity, z", "u6")
    DECK_FX = ("m/s2", "S", "specific force at the deck origin, x (what a deck IMU reads)", "")
    DECK_FY = ("m/s2", "S", "specific force at the deck origin, y", "")
    DECK_FZ = ("m/s2", "S", "specific force at the deck origin, z", "")
    WIND_FX = ("N", "H", "wind force, x", "F^wind_x")
    WIND_FY = ("N", "H", "wind force, y", "F^wind_y")
    WIND_FZ = ("N", "H", "wind force, z", "F^wind_z")


class StaOut(Channel):
    """Output rows of one station, from ``STATION_OUT + i * STATION_OUT_ROWS``."""

    VERTICAL_LOAD = ("N", "S", "vertical tire load of the station (sum of its tires)", "F_tz")
    LATERAL_LOAD = ("N", "T", "lateral tire force of the station (sum)", "F_ty")
    LONGITUDINAL_LOAD = ("N", "T", "longitudinal tire force of the station (sum)", "F_tx")
    TIRE_VERTICAL_DEFLECTION = ("m", "S", "vertical tire deflection (mean of its tires, 0 in the air)", "delta_z")
    TIRE_LATERAL_DEFLECTION = ("m", "T", "lateral tire deflection (mean)", "delta_y")
    TIRE_LONGITUDINAL_DEFLECTION = ("m", "T", "longitudinal tire deflection (mean)", "delta_x")
    TIRE_TWIST = ("rad", "T", "tire twist (mean)", "psi")
    TIRE_LATERAL_DEFLECTION_LARGEST = ("m", "T", "lateral deflection of the tire that deflects most", "delta_y")
    FRICTION_USE = ("1", "T", "largest share of the tire friction limit in use", "")
    COMPRESSION = ("m", "O", "oleo compression from full droop", "x")
    COMPRESSION_RATE = ("m/s", "O", "oleo compression rate", "v")
    OLEO_FORCE = ("N", "O", "oleo force", "F_oleo")
    STEER = ("rad", "H", "steer angle of the station about its oleo axis", "")
    CONTACT_X = ("m", "S", "contact point of the station (mean of its tires), x", "")
    CONTACT_Y = ("m", "S", "contact point of the station, y", "")
    TIRE_VERTICAL_DEFLECTION_LARGEST = ("m", "S", "vertical deflection of the tire that deflects most", "delta_z")
    TIRE_LONGITUDINAL_DEFLECTION_LARGEST = (
        "m",
        "T",
        "longitudinal deflection of the tire that deflects most",
        "delta_x",
    )
    TIRE_TWIST_LARGEST = ("rad", "T", "twist of the tire that is twisted most", "psi")


OUT_ROWS: Final = len(Out)
STATION_OUT: Final = OUT_ROWS
STATION_OUT_ROWS: Final = len(StaOut)
OUTPUT_ROWS: Final = OUT_ROWS + STATIONS * STATION_OUT_ROWS
