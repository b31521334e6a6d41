"""What caused the peaks of a trial, in words, and what another driver makes of the same sea.

The causes are read off the recorded telemetry by simple estimates: how much of the probe's load at the peak can come
from the deck's push, from the claw's acceleration, from the claw drawn across the wheels, and from a helicopter drawn
along askew. They rank causes for a reader; they are no balance of forces, and the deck's push on the centre of gravity
is taken at the deck's origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.trials.scripted import policy_for, scripted_trial
from ssmash_gym.trials.stamps import NOBODY
from ssmash_gym.trials.trial import Trial

Array = NDArray[np.float64]
MOST: Final = 3  # peaks that are told
APART_S: Final = 3.0  # between two of them at least; half a roll period or so
LEAST_SHARE: Final = 0.3  # of the highest peak: lower ones are not worth a sentence
BEFORE_S: Final = 1.5  # what happened so long before a peak may have caused it
WHEELS_N_PER_M: Final = 4e5  # of side force for a way across the wheels; assumed: 3e5 to 6e5 in runs in a calm sea
TELLING: Final = 0.4  # a second cause is told from this share of the first one on
LEAST_PART: Final = 0.2  # of the peak that a cause must explain to be told
STILL_M_S: Final = 0.02  # a claw slower than this stands still: the drive's ripple reaches 0.01 m/s
GAVE_WAY_M: Final = 0.01  # less than this across the track is not giving way
DREW: Final = "the claw drew the helicopter "
AT_THE_END_M: Final = 0.01  # of its travel


def moments(trial: Trial) -> list[dict[str, Any]]:
    """The two or three highest separate peaks of the in-plane probe load, and what caused each.

    Args:
        trial: A whole one, or one that was broken off.

    Returns:
        In the order of time: ``time_s``, ``peak_kN``, ``words``: one sentence without a full stop.
    """
    look = _Look(trial)
    found = []
    for row in sorted(_peaks(trial)):
        time_s, peak_kN = float(look["time_s"][row]), 1e-3 * float(look["probe_in_plane_max"][row])
        words = f"{peak_kN:.1f} kN at {time_s:.1f} s: {look.causes(row)}"
        found.append({"time_s": time_s, "peak_kN": peak_kN, "words": words})
    return found


def rival_run(condition: Condition, seed: int, policy_name: str) -> Trial:
    """A policy's own run in the same sea.

    Args:
        condition: What is simulated.
        seed: Of the episode.
        policy_name: A baseline, a planner, or a trained agent.

    Raises:
        ConfigurationError: There is no such policy, or it cannot drive this condition.
    """
    return scripted_trial(condition, seed, policy_for(policy_name, condition))


def _peaks(trial: Trial) -> list[int]:
    """Rows of the highest peaks, the highest first; those within the grace do not count."""
    load = trial.table["probe_in_plane_max"].to_numpy()
    time = trial.table["time_s"].to_numpy()
    chosen: list[int] = []
    for row in np.argsort(-load, kind="stable"):
        if time[row] <= trial.condition.task.grace_s + 1e-9:
            continue
        if chosen and (len(chosen) == MOST or load[row] < LEAST_SHARE * load[chosen[0]]):
            break
        apart = all(abs(time[row] - time[other]) >= APART_S for other in chosen)
        if apart and _highest_around(load, int(row)):
            chosen.append(int(row))
    return chosen


def _highest_around(load: NDArray[Any], row: int) -> bool:
    """Whether neither neighbour is higher: the flank of another peak is none of its own."""
    return bool(load[row] >= load[max(row - 1, 0) : row + 2].max())


def _joined(causes: list[str]) -> str:
    """Causes as one sentence; the claw's ways along and across the track share a verb."""
    if len(causes) == 2 and all(cause.startswith(DREW) for cause in causes):
        return f"{causes[0]} and {causes[1].removeprefix(DREW)}"
    return ", while ".join(causes)


@dataclass(frozen=True)
class _Cause:
    """What it can have added to the load [N], and how it is told."""

    part_N: float
    words: str


class _Look:
    """A trial's telemetry as numbers, for the search of causes. Components are ship axes: x forward, y starboard."""

    def __init__(self, trial: Trial) -> None:
        self._table = trial.table
        self._task = trial.condition.task
        self._interval_s = self._task.control_interval_s
        draw = trial.about["draw"]
        self._mass_kg = trial.condition.helicopter.mass_kg * draw["helicopter_mass_factor"]
        travel = draw["claw_y_travel_m"]
        self._travel_m = self._task.claw.y_travel_m if travel is None else float(travel)

    def __getitem__(self, name: str) -> Array:
        return self._table[name].to_numpy().astype(np.float64)

    def causes(self, row: int) -> str:
        """What caused the peak of a row, in words."""
        at = row if row == 0 or self["probe_in_plane"][row] >= self["probe_in_plane"][row - 1] else row - 1
        before = slice(max(at - round(BEFORE_S / self._interval_s), 0), at + 1)
        along = self._direction(at)
        known = [self._deck(at, before, along), *self._claw(before, along), self._across(before, along)]
        known.append(self._askew(at, before, along))
        ranked = sorted((one for one in known if one is not None), key=lambda one: -one.part_N)
        peak_N = float(self["probe_in_plane_max"][row])
        told = [one for one in ranked[:2] if one.part_N >= max(TELLING * ranked[0].part_N, LEAST_PART * peak_N)]
        words = _joined([one.words for one in told]) or "no single cause stands out"
        if bool((self._table["driver"][before] == NOBODY).any()):
            words += "; nobody held the claw"
        return words

    def _direction(self, at: int) -> Array:
        """Unit vector of the in-plane probe force on the helicopter, (2,)."""
        yaw = self["yaw"][at]
        fx, fy = self["probe_fx"][at], self["probe_fy"][at]
        force = np.array([np.cos(yaw) * fx - np.sin(yaw) * fy, np.sin(yaw) * fx + np.cos(yaw) * fy])
        return np.asarray(force / max(float(np.linalg.norm(force)), 1e-9))

    def _deck(self, at: int, before: slice, along: Array) -> _Cause | None:
        """The deck pushes the helicopter against the probe: inertia and slope."""
        specific = np.array([self["deck_fx"][at], self["deck_fy"][at]])  # the push is its opposite
        part_N = self._mass_kg * float(specific @ along)
        if part_N <= 0.0:
            return None
        sideways = abs(specific[1] * along[1]) >= abs(specific[0] * along[0])
        push = -specific[1] if sideways else -specific[0]
        words = f"the deck pushed {abs(push):.1f} m/s2 {_side(push) if sideways else _way(push)}"
        if not sideways:
            return _Cause(part_N, words + _tilt(self["deck_pitch"][at], "bow up", "bow down"))
        words += _tilt(self["deck_roll"][at], "starboard down", "port down")
        return _Cause(part_N, words + self._giving_way(at, before, push))

    def _giving_way(self, at: int, before: slice, push: float) -> str:
        """Whether the claw went with a push across the track, in words."""
        y = self["claw_y"]
        if np.sign(push) * y[at] > self._travel_m - AT_THE_END_M:
            return f", and the claw was at the end of its travel to {_board(push)}"
        gone = np.sign(push) * (y[at] - y[before][0])
        return ", and the claw did not give way" if gone < GAVE_WAY_M else ""

    def _claw(self, before: slice, along: Array) -> list[_Cause | None]:
        """The claw starts, stops or reverses, along the track and across it."""
        return [
            self._jerk(before, along[0], "claw_vx", "claw_x", "forward", "aft"),
            self._jerk(before, along[1], "claw_vy", "claw_y", "to starboard", "to port"),
        ]

    def _jerk(self, before: slice, along: float, speed: str, place: str, plus: str, minus: str) -> _Cause | None:
        """An acceleration of the claw towards the load on one axis."""
        v = self[speed][before]
        if v.size < 2 or not along:
            return None
        towards = float(np.sign(along))
        a = towards * np.diff(v) / self._interval_s
        part_N = self._mass_kg * abs(along) * float(a.max())
        lowest = int((towards * v).argmin()) if part_N > 0.0 else 0  # the change towards the load starts there
        v0, v1 = float(v[lowest]), float(towards * (towards * v[lowest:]).max())
        if part_N <= 0.0 or abs(v1 - v0) < STILL_M_S:
            return None
        return _Cause(part_N, f"the claw {_change(v0, v1, plus, minus)}{self._end(before, place)}")

    def _end(self, before: slice, place: str) -> str:
        """That the claw has reached an end of its travel, in words."""
        claw, now = self._task.claw, float(self[place][before][-1])
        ends = (claw.x_min_m, claw.x_max_m) if place == "claw_x" else (-self._travel_m, self._travel_m)
        return " at the end of its travel" if min(abs(now - end) for end in ends) < AT_THE_END_M else ""

    def _across(self, before: slice, along: Array) -> _Cause | None:
        """The claw draws the helicopter across its wheels."""
        y = self["claw_y"][before]
        moved = float(y[-1] - y[0])
        part_N = WHEELS_N_PER_M * moved * along[1]
        if part_N <= 0.0 or abs(moved) < GAVE_WAY_M:
            return None
        fastest = float(np.abs(self["claw_vy"][before]).max())
        words = f"{DREW}{abs(moved):.2f} m {_side(moved)}, at up to {fastest:.2f} m/s"
        return _Cause(part_N, words)

    def _askew(self, at: int, before: slice, along: Array) -> _Cause | None:
        """The claw draws a helicopter along the track that does not point along it: its wheels want another way."""
        x, yaw = self["claw_x"][before], float(self["yaw"][at])
        moved = float(x[-1] - x[0])
        part_N = WHEELS_N_PER_M * -moved * np.sin(yaw) * along[1]
        if part_N <= 0.0:
            return None
        askew = f"with its bow {abs(np.rad2deg(yaw)):.1f} deg {_side(yaw)}"
        words = f"{DREW}{abs(moved):.2f} m {_way(moved)} {askew}"
        return _Cause(float(part_N), words)


def _board(value: float) -> str:
    return "starboard" if value > 0.0 else "port"


def _side(value: float) -> str:
    return f"to {_board(value)}"


def _way(value: float) -> str:
    return "forward" if value > 0.0 else "aft"


def _tilt(angle_rad: float, plus: str, minus: str) -> str:
    """The deck's angle, in words; nothing below half a degree."""
    degrees = float(np.rad2deg(angle_rad))
    return f" ({abs(degrees):.1f} deg {plus if degrees > 0.0 else minus})" if abs(degrees) >= 0.5 else ""


def _change(v0: float, v1: float, plus: str, minus: str) -> str:
    """A change of the claw's velocity on one axis, in words."""

    def told(v: float) -> str:
        return f"{abs(v):.2f} m/s {plus if v > 0.0 else minus}"

    if abs(v0) < STILL_M_S:
        return f"started to {told(v1)}"
    if abs(v1) < STILL_M_S:
        return f"stopped from {told(v0)}"
    if v0 * v1 < 0.0:
        return f"reversed from {told(v0)} to {told(v1)}"
    return f"{'sped up' if abs(v1) > abs(v0) else 'slowed'} from {abs(v0):.2f} to {told(v1)}"
