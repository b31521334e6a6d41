"""Gains of the searched laws, by the drive's nominal delay: found by `tools/law_search.py`, kept in `agents/data`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.laws_book import SlowingBook

from ssmash_gym.assets import asset_path
from ssmash_gym.document import read_file

Array = NDArray[np.float64]
Number = float | Array  # one for all helicopters, or (n,)
FILE: Final = ("agents", "data", "yield_gains.yaml")


@dataclass(frozen=True)
class Gains:
    """Gains of ``v_y = -k_y F_y - k_c y - k_psi yaw``: numbers, or arrays with one for each helicopter, (n,).

    Attributes:
        k_y: Yielding to the load [m/s per N].
        k_c: Centring [1/s].
        k_psi: Straightening [m/s per rad].
    """

    k_y: Number
    k_c: Number
    k_psi: Number


@dataclass(frozen=True)
class Schedule:
    """Where on the track which gains and speeds hold: numbers, or arrays with one for each helicopter, (n,).

    Attributes:
        start_m: Distance from the start up to which the gains of the begin hold alone [m].
        start_blend_m: Length over which they give way to those of the way, after that [m].
        near_m: Distance to go from which on the gains of the end hold alone [m].
        near_blend_m: Length over which they take over, before that [m].
        start_speed_m_s, speed_m_s, near_speed_m_s: Speed along the track.
        start_slow_m, near_slow_m: Lengths of the track's begin and end with a speed of their own [m].
    """

    start_m: Number
    start_blend_m: Number
    near_m: Number
    near_blend_m: Number
    start_speed_m_s: Number
    speed_m_s: Number
    near_speed_m_s: Number
    start_slow_m: Number
    near_slow_m: Number

    def shares(self, travelled_m: Array, length_m: float) -> tuple[Array, Array, Array]:
        """Shares of the gains of begin, way and end at a distance along a track, (n,) each; their sum is 1."""
        start = _smooth((self.start_m + self.start_blend_m - travelled_m) / self.start_blend_m)
        near = (1.0 - start) * _smooth((self.near_m + self.near_blend_m - length_m + travelled_m) / self.near_blend_m)
        return start, 1.0 - start - near, near

    def book(self, length_m: float, greatest_m_s: float, acceleration_m_s2: float) -> SlowingBook:
        """The way along a track with these speeds."""
        top = np.minimum(self.speed_m_s, greatest_m_s)
        return SlowingBook(
            length_m, self.start_speed_m_s, self.start_slow_m, top, self.near_speed_m_s, self.near_slow_m,
            acceleration_m_s2,
        )  # fmt: skip


@dataclass(frozen=True)
class FeedbackGains:
    """Gains of ``v_y = - sum of k_term term`` for named terms of the observation, each with three values on the track.

    Attributes:
        schedule: Where which of them hold, and how fast the claw drives.
        start, way, near: Gain of each term [m/s per unit of the term]: at the begin, on the way, at the end.
    """

    schedule: Schedule
    start: Mapping[str, Number]
    way: Mapping[str, Number]
    near: Mapping[str, Number]


def _smooth(share: Array) -> Array:
    """0 up to 0, 1 from 1 on, and a smooth step between."""
    within = np.clip(share, 0.0, 1.0)
    return within**2 * (3.0 - 2.0 * within)


def yield_gains(delay_s: float, law: str = "yield") -> Gains:
    """Gains of a yielding law for a drive's delay: interpolated between the delays of the search, held beyond them."""
    return Gains(**interpolated(table(law), delay_s))


def feedback_gains(delay_s: float, law: str) -> FeedbackGains:
    """The same for a law with a schedule."""
    return as_feedback(interpolated(table(law), delay_s))


def as_feedback(gains: Mapping[str, Any]) -> FeedbackGains:
    """Gains as the file holds them."""
    return FeedbackGains(Schedule(**gains["schedule"]), gains["start"], gains["way"], gains["near"])


def interpolated(rows: list[dict[str, Any]], delay_s: float) -> dict[str, Any]:
    """Gains between the rows of a law, whose ``delay_s`` rises; beyond the first and the last one theirs are held."""
    delays = [float(row["delay_s"]) for row in rows]
    return _between([row["gains"] for row in rows], lambda values: float(np.interp(delay_s, delays, values)))


def _between(nodes: list[Any], mix: Any) -> Any:
    if isinstance(nodes[0], Mapping):
        return {key: _between([node[key] for node in nodes], mix) for key in nodes[0]}
    return mix([float(node) for node in nodes])


def table(law: str) -> list[dict[str, Any]]:
    """The rows of a law in the file, one a delay."""
    rows: list[dict[str, Any]] = _document()["laws"][law]
    return rows


@cache
def _document() -> Mapping[str, Any]:
    return read_file(asset_path(*FILE))
