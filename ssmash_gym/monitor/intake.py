"""Samples as they come in: read, checked, and kept; whatever is wrong with them is told in a sentence.

A row that cannot be used is left out. A short hole is bridged; after a longer one, after time has run backwards or a
channel has stuck, all that came before is forgotten, and a fresh past has to grow.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import Final

import numpy as np

from ssmash_gym.columns import COMMENTS, number_in
from ssmash_gym.monitor.settings import SPACING_S, Settings
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.shipmo import COLUMNS

LATEST_S: Final = 1e11  # a clock beyond this is none
CLOSEST_S: Final = 1e-3  # samples nearer to each other than this count as one
BRIEFEST_S: Final = 0.05  # least time over which a jump is judged: noise between close samples is no jump
# What no ship can do, column by column after the time, in the file's units; all assumed.
BOUNDS: Final = (60.0, 30.0, 720.0, 30.0, 30.0, 15.0, 60.0, 60.0, 60.0, 30.0, 30.0, 30.0, 200.0, 200.0, 200.0)
FASTEST: Final = (60.0, 60.0, 60.0, 30.0, 30.0, 30.0)  # change of roll, pitch, yaw [deg/s], velocities [m/s2]
CHANNELS: Final = ("roll", "pitch", "yaw", "velocity x", "velocity y", "velocity z")
USED: Final = len(CHANNELS)
_TURN_DEG: Final = 360.0
_KEPT_BEYOND_S: Final = 5.0


class Intake:
    """The usable past of one input.

    Args:
        settings: How long a gap may be, when a channel counts as stuck, how much past is kept.

    Attributes:
        malformed: Rows that could not be used so far.
        accepted: Usable samples so far.
        epoch: How often the past has been forgotten.
        rewinds: How often because time ran backwards.
        clock_s: Latest time that was read in a row of numbers, usable or not [s]; nan before the first.
        why: Why the past was last forgotten, or why the last row was not used; empty where all is well.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self.malformed = 0
        self.accepted = 0
        self.epoch = 0
        self.rewinds = 0
        self.clock_s = math.nan
        self.why = ""
        self._bad = ""
        self._names_passed = False
        self._times: list[float] = []
        self._rows: list[tuple[float, ...]] = []  # roll, pitch, yaw unwrapped [deg], velocities [m/s]
        self._begin_s = math.nan
        self._last: tuple[float, ...] = ()
        self._last_s = math.nan
        self._changed: list[float] = []

    @property
    def newest_s(self) -> float:
        """Time of the latest usable sample [s]."""
        return self._times[-1] if self._times else math.nan

    @property
    def begin_s(self) -> float:
        """Time of the first sample that is not forgotten [s]."""
        return self._begin_s if self._times else math.nan

    @property
    def latest_fault(self) -> str:
        """What was wrong with the last row that was not used since the last usable one."""
        return self._bad

    def take(self, line: str) -> bool:
        """Read one line; returns whether it was a usable sample. Never raises."""
        words = line.replace(",", " ").replace(";", " ").replace("\ufeff", " ").split()
        if not words or words[0].startswith(COMMENTS):
            return False
        numbers = [number_in(word) for word in words]
        if not self._times and not self._names_passed and all(number is None for number in numbers):
            self._names_passed = True
            return False
        fault = self._fault_of_row(words, numbers)
        if fault:
            self._refuse(fault)
            return False
        return self._accept([float(number or 0.0) for number in numbers])

    def _fault_of_row(self, words: list[str], numbers: list[float | None]) -> str:
        """What is wrong with the words of a row; empty if nothing is."""
        time = numbers[0]
        timed = time is not None and math.isfinite(time) and abs(time) < LATEST_S
        if timed:
            self.clock_s = float(time or 0.0)
        if len(words) != len(COLUMNS):
            return f"a row of {len(words)} columns, {len(COLUMNS)} are needed"
        if not timed:
            return f"a row without a time ({words[0][:24]!r})"
        for place, (number, bound) in enumerate(zip(numbers[1:], BOUNDS, strict=True), start=1):
            if number is None or not math.isfinite(number):
                return f"{COLUMNS[place][1]} is {words[place][:24]!r}, which is no finite number"
            if abs(number) > bound:
                return f"{COLUMNS[place][1]} is {number:g}, which no ship can have (bound {bound:g})"
        return ""

    def _refuse(self, fault: str) -> None:
        self.malformed += 1
        self._bad = fault

    def _accept(self, numbers: list[float]) -> bool:
        time, values = numbers[0], tuple(numbers[1 : 1 + USED])
        if self._times:
            step = time - self._times[-1]
            if step < -CLOSEST_S:
                self.rewinds += 1
                self._forget(f"time ran backwards from {self._times[-1]:g} to {time:g} s")
            elif step < CLOSEST_S:
                self._refuse(f"time stands still at {time:g} s")
                return False
            elif step > self._settings.longest_gap_s + CLOSEST_S:
                told = f" (last: {self._bad})" if self._bad else ""
                self._forget(f"no usable sample from {self._times[-1]:g} to {time:g} s{told}")
            else:
                values = self._unwrapped(values)
                fault = self._jump(values, step)
                if fault:
                    self._refuse(fault)
                    return False
        self._keep(time, values)
        return True

    def _unwrapped(self, values: tuple[float, ...]) -> tuple[float, ...]:
        turns = round((values[2] - self._rows[-1][2]) / _TURN_DEG)
        return (*values[:2], values[2] - _TURN_DEG * turns, *values[3:])

    def _jump(self, values: tuple[float, ...], step: float) -> str:
        for name, new, old, fastest in zip(CHANNELS, values, self._rows[-1], FASTEST, strict=True):
            if abs(new - old) > fastest * max(step, BRIEFEST_S):
                return f"{name} jumps from {old:g} to {new:g} within {step:g} s"
        return ""

    def _keep(self, time: float, values: tuple[float, ...]) -> None:
        if not self._last or time < self._last_s:
            self._changed = [time] * USED
        else:
            pairs = zip(values, self._last, self._changed, strict=True)
            self._changed = [since if new == old else time for new, old, since in pairs]
        self._last, self._last_s = values, time
        stuck = [name for name, since in zip(CHANNELS, self._changed, strict=True) if self._is_stuck(time - since)]
        if stuck:
            self._forget(f"{' and '.join(stuck)} repeats the same number: stuck")
        if not self._times:
            self._begin_s = time
        self._times.append(time)
        self._rows.append(values)
        self._bad = ""
        self.accepted += 1
        self._trim(time)

    def _is_stuck(self, unchanged_s: float) -> bool:
        return unchanged_s >= self._settings.stuck_s - CLOSEST_S

    def _trim(self, time: float) -> None:
        """Drop what is older than any fit looks back, now and then."""
        keep_s = self._settings.past_s + _KEPT_BEYOND_S
        if time - self._times[0] > 2.0 * keep_s:
            first = bisect_left(self._times, time - keep_s)
            del self._times[:first], self._rows[:first]

    def _forget(self, why: str) -> None:
        self.epoch += 1
        self.why = why
        self._times.clear()
        self._rows.clear()

    def lapse(self) -> None:
        """Forget the past if rows have come for longer than a gap may last, and none of them was usable."""
        if self._times and self.clock_s > self._times[-1] + self._settings.longest_gap_s + CLOSEST_S:
            self._forget(f"no usable sample after {self._times[-1]:g} s (last: {self._bad})")

    def forget(self, why: str) -> None:
        """Start again with a fresh past, for a reason that lies outside the samples."""
        self._forget(why)
        self._last = ()

    def past_s(self, now_s: float) -> float:
        """Length of the past without a gap up to a time [s]."""
        return max(0.0, now_s - self._begin_s) if self._times else 0.0

    def samples(self, now_s: float) -> FloatArray:
        """Evenly spaced samples up to a time that the usable past covers, oldest first, (n, 6).

        Velocities x, y, z [m/s] and roll, pitch, yaw [rad], in the mean frame of this past: x along its mean heading,
        the mean velocity and the mean yaw taken off. At most `past_s` of them.
        """
        from scipy.interpolate import make_interp_spline

        last = bisect_left(self._times, now_s - CLOSEST_S) + 1
        first = max(0, bisect_left(self._times, now_s - self._settings.past_s - _KEPT_BEYOND_S))
        times = np.array(self._times[first:last])
        rows = np.array(self._rows[first:last])
        room_s = min(self._settings.past_s, now_s - float(times[0]))
        count = math.floor(room_s / SPACING_S + 1e-6) + 1
        grid = now_s - SPACING_S * np.arange(count - 1, -1, -1)
        degree = min(3, len(times) - 1)
        even = make_interp_spline(times - now_s, rows, k=degree)(grid - now_s) if degree else np.repeat(rows, count, 0)
        return _in_mean_frame(np.asarray(even, dtype=np.float64))


def _in_mean_frame(rows: FloatArray) -> FloatArray:
    """Rows of angles [deg] and velocities as `Intake.samples` gives them."""
    angles = np.deg2rad(rows[:, :3])
    heading = float(np.mean(angles[:, 2]))
    velocity = rows[:, 3:] - np.mean(rows[:, 3:], axis=0)
    cos, sin = math.cos(heading), math.sin(heading)
    along = cos * velocity[:, 0] + sin * velocity[:, 1]
    across = -sin * velocity[:, 0] + cos * velocity[:, 1]
    turned = angles - np.array([0.0, 0.0, heading])
    return np.column_stack([along, across, velocity[:, 2], turned])
