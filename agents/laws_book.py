"""Driving by the book: how far along the track the claw is at a time, with a slower begin and a slower end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SlowingBook:
    """Ramp to a slow speed, cruise, ramp to the speed of the way, cruise, ramp to another slow one, cruise, stop.

    Numbers, or arrays with one for each helicopter, (n,). Speeds too great for the track are lowered until the ramps
    fit; the slow speeds are never greater than that of the way.

    Attributes:
        length_m: Length of the track.
        start_speed_m_s: Over the begin of the track.
        start_m: Length of that begin; at most a quarter of the track is taken.
        speed_m_s: On the way.
        near_speed_m_s: Over the end of the track.
        near_m: Length of that end; at most half the track is taken.
        acceleration_m_s2: Of every ramp.
    """

    length_m: float
    start_speed_m_s: float | Array
    start_m: float | Array
    speed_m_s: float | Array
    near_speed_m_s: float | Array
    near_m: float | Array
    acceleration_m_s2: float

    def travelled(self, time_s: Array) -> Array:
        """Distance from the start at a time since then [m]; shape of the numbers and the time, broadcast."""
        begun_s, way = 0.0, np.zeros(np.shape(time_s))
        for duration_s, speed, acceleration in self._pieces():
            within_s = np.clip(time_s - begun_s, 0.0, duration_s)
            way = way + speed * within_s + 0.5 * acceleration * within_s**2
            begun_s = begun_s + duration_s
        return way

    def _pieces(self) -> tuple[tuple[float | Array, float | Array, float], ...]:
        """Duration, speed at its begin and acceleration of each piece of the way."""
        a = self.acceleration_m_s2
        start_m, near_m = np.minimum(self.start_m, 0.25 * self.length_m), np.minimum(self.near_m, 0.5 * self.length_m)
        way_m = self.length_m - start_m - near_m
        first = np.minimum(np.minimum(self.start_speed_m_s, self.speed_m_s), np.sqrt(2.0 * a * start_m))
        last = np.minimum(np.minimum(self.near_speed_m_s, self.speed_m_s), np.sqrt(2.0 * a * near_m))
        top = np.minimum(self.speed_m_s, np.sqrt(a * way_m + 0.5 * (first**2 + last**2)))
        first, last = np.minimum(first, top), np.minimum(last, top)
        cruise_m = way_m - (top**2 - 0.5 * (first**2 + last**2)) / a
        return (
            (first / a, 0.0, a),
            ((start_m - 0.5 * first**2 / a) / first, first, 0.0),
            ((top - first) / a, first, a),
            (cruise_m / top, top, 0.0),
            ((top - last) / a, top, -a),
            ((near_m - 0.5 * last**2 / a) / last, last, 0.0),
            (last / a, last, -a),
        )
