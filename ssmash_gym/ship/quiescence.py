"""Quiescent periods of a deck: windows in which chosen quantities stay within limits.

`label` and `windows` read the stored table of a motion, its true future included: they are an oracle, for evaluation
and for judging forecasts, and never part of an observation. `energy_index` rests on one instant's values and rates
and needs no future.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import CHANNELS, GRAVITY, MotionTable, Signal, pose_of

SAMPLING_S: Final = 0.05  # an excursion beyond a limit that is shorter than this may be missed
SHORTEST_S: Final = 6.0  # windows shorter than this are of no use to anybody (assumed)
_BISECTIONS: Final = 26  # of a sampling interval: the ends of a window are good to a nanosecond
_ROLL, _PITCH, _Z = (CHANNELS.index(name) for name in ("roll", "pitch", "z"))


@dataclass(frozen=True)
class Quantity:
    """Something that is limited.

    Attributes:
        meaning: In words.
        value: Takes it from a signal, (n,).
        rate: Its time derivative [per s], (n,); None where the table does not hold it.
    """

    meaning: str
    value: Callable[[Signal], FloatArray]
    rate: Callable[[Signal], FloatArray] | None = None


def _specific_force_y(s: Signal) -> FloatArray:
    return pose_of(s).specific_force_S(GRAVITY)[..., 1] / GRAVITY


QUANTITIES: Final[Mapping[str, Quantity]] = {
    "roll_deg": Quantity(
        "roll of the deck", lambda s: np.rad2deg(s.position[..., _ROLL]), lambda s: np.rad2deg(s.rate[..., _ROLL])
    ),
    "pitch_deg": Quantity(
        "pitch of the deck", lambda s: np.rad2deg(s.position[..., _PITCH]), lambda s: np.rad2deg(s.rate[..., _PITCH])
    ),
    "vertical_velocity_m_s": Quantity(
        "vertical velocity of the deck origin", lambda s: s.rate[..., _Z], lambda s: s.acceleration[..., _Z]
    ),
    "vertical_acceleration_g": Quantity(
        "vertical acceleration of the deck origin, over 9.81 m/s2", lambda s: s.acceleration[..., _Z] / GRAVITY
    ),
    "lateral_specific_force_g": Quantity(
        "specific force along y of the deck at its origin, over 9.81 m/s2", _specific_force_y
    ),
}
# Illustrative instantaneous limits (assumed): the figures for helicopter operations that are public are RMS values
# (STANAG 4154, as cited in J. Mar. Sci. Eng. 12(9) 1591, 2024: roll 2.5 deg, pitch 1.5 deg, vertical velocity 1 m/s).
ILLUSTRATIVE: Final[Mapping[str, float]] = {"roll_deg": 2.5, "pitch_deg": 1.5, "vertical_velocity_m_s": 0.8}


@dataclass(frozen=True, eq=False)
class Label:
    """The oracle's word at n times; every array has shape (n,).

    Attributes:
        inside: Whether all quantities are within their limits.
        to_exceedance_s: Time until a limit is next passed [s]; 0 outside.
        start_s, end_s: The window that holds the time [s of the table]; nan outside.
        open_start, open_end: Whether that window is cut off by the table's beginning or end: then its length, and with
            `open_end` the time to the next exceedance, is a lower bound.
    """

    inside: npt.NDArray[np.bool_]
    to_exceedance_s: FloatArray
    start_s: FloatArray
    end_s: FloatArray
    open_start: npt.NDArray[np.bool_]
    open_end: npt.NDArray[np.bool_]

    @property
    def length_s(self) -> FloatArray:
        """Length of the window that holds the time [s]; 0 outside."""
        return np.where(self.inside, self.end_s - self.start_s, 0.0)


@dataclass(frozen=True)
class Window:
    """A time within all limits [s of the table]; open where the table begins or ends within it."""

    start_s: float
    end_s: float
    open_start: bool = False
    open_end: bool = False

    @property
    def length_s(self) -> float:
        """How long it lasts [s]; a lower bound where it is open."""
        return self.end_s - self.start_s


@dataclass(frozen=True)
class WindowStatistics:
    """What the windows of a record amount to.

    Attributes:
        count: How many.
        fraction: Share of the record's time that lies in them.
        median_s: Their median length [s]; nan without one.
        spacing_s: Mean time from the start of one to the start of the next [s]; nan with fewer than two.
    """

    count: int
    fraction: float
    median_s: float
    spacing_s: float


def label(
    table: MotionTable, limits: Mapping[str, float], times: npt.ArrayLike, *, sampling_s: float = SAMPLING_S
) -> Label:
    """The oracle's label at given times, from the true motion before and after them. Never for an observation.

    The largest share of a limit in use is sampled every `sampling_s` and each passage through 1 found by bisection on
    the table's own polynomial pieces, to a nanosecond. An excursion or a lull shorter than `sampling_s` may be missed.

    Args:
        table: The motion.
        limits: Limit on the absolute value of each of any `QUANTITIES`, for example `ILLUSTRATIVE`.
        times: Times of the table [s], (n,).
        sampling_s: How finely passages are looked for [s].

    Raises:
        ConfigurationError: An unknown quantity, a limit or sampling that is not positive, or a time outside the table.
    """
    at = np.atleast_1d(np.asarray(times, dtype=np.float64))
    table.at(at)  # refuses times outside
    found = windows(table, limits, shortest_s=0.0, sampling_s=sampling_s)
    if not found:
        nothing = np.full(at.shape, np.nan)
        no = np.zeros(at.shape, np.bool_)
        return Label(no, np.zeros(at.shape), nothing, nothing.copy(), no.copy(), no.copy())
    starts, ends = np.array([w.start_s for w in found]), np.array([w.end_s for w in found])
    which = np.clip(np.searchsorted(starts, at, side="right") - 1, 0, len(found) - 1)
    inside = (at >= starts[which]) & (at <= ends[which])
    return Label(
        inside=inside,
        to_exceedance_s=np.where(inside, ends[which] - at, 0.0),
        start_s=np.where(inside, starts[which], np.nan),
        end_s=np.where(inside, ends[which], np.nan),
        open_start=inside & np.array([w.open_start for w in found])[which],
        open_end=inside & np.array([w.open_end for w in found])[which],
    )


def windows(
    table: MotionTable,
    limits: Mapping[str, float],
    *,
    shortest_s: float = SHORTEST_S,
    sampling_s: float = SAMPLING_S,
) -> list[Window]:
    """All windows within the limits that last `shortest_s` or more, in order; see `label`.

    Raises:
        ConfigurationError: As `label`.
    """
    checked = _checked(limits)
    if not (math.isfinite(sampling_s) and sampling_s > 0.0):
        raise ConfigurationError(f"quiescence: sampling_s = {sampling_s}: must be above 0")
    count = max(1, math.ceil(table.duration_s / sampling_s - 1e-9))
    grid = np.linspace(0.0, table.duration_s, count + 1)
    within = _use(table.at(grid), checked) <= 1.0
    turns = np.flatnonzero(within[1:] != within[:-1])
    passages = _bisected(table, checked, grid[turns], grid[turns + 1], within[turns])
    edges = [0.0] * bool(within[0]) + passages.tolist() + [table.duration_s] * bool(within[-1])
    found = [
        Window(start, end, start == 0.0 and bool(within[0]), end == table.duration_s and bool(within[-1]))
        for start, end in zip(edges[::2], edges[1::2], strict=True)
    ]
    return [window for window in found if window.length_s >= shortest_s]


def statistics(found: list[Window], duration_s: float) -> WindowStatistics:
    """Count, share of the time, median length and spacing of windows found in a record of `duration_s` [s]."""
    lengths = [window.length_s for window in found]
    starts = [window.start_s for window in found]
    return WindowStatistics(
        count=len(found),
        fraction=sum(lengths) / duration_s,
        median_s=float(np.median(lengths)) if found else math.nan,
        spacing_s=(starts[-1] - starts[0]) / (len(found) - 1) if len(found) > 1 else math.nan,
    )


def zero_crossing_frequencies(table: MotionTable, limits: Mapping[str, float]) -> dict[str, float]:
    """Mean angular frequency of each limited quantity in a record [rad/s]: RMS of its rate over RMS about its mean.

    Raises:
        ConfigurationError: As `label`, a quantity whose rate no table holds, or one that does not move.
    """
    signal = table.at(table.spacing_s * np.arange(len(table.nodes)))
    frequencies = {}
    for name in _checked(limits):
        values, rates = QUANTITIES[name].value(signal), _rate(name)(signal)
        scatter = float(np.std(values))
        if scatter == 0.0:
            raise ConfigurationError(f"quiescence: {name} does not move in this record: it has no frequency")
        frequencies[name] = float(np.sqrt(np.mean(rates**2))) / scatter
    return frequencies


def record_means(table: MotionTable, limits: Mapping[str, float]) -> dict[str, float]:
    """Mean of each limited quantity in a record, in its unit: heel, trim and the like.

    Raises:
        ConfigurationError: As `label`.
    """
    signal = table.at(table.spacing_s * np.arange(len(table.nodes)))
    return {name: float(np.mean(QUANTITIES[name].value(signal))) for name in _checked(limits)}


def energy_index(
    signal: Signal,
    limits: Mapping[str, float],
    frequencies: Mapping[str, float],
    means: Mapping[str, float] | None = None,
) -> FloatArray:
    """Running index of how lively the deck is: below 1 where no quantity's envelope about its mean reaches its limit.

    ``max over quantities of (|m| + sqrt((q - m)^2 + (dq/dt / w)^2)) / limit``: for a sine of frequency w about the mean
    m the root is its amplitude, whatever the phase, so the index follows the envelope and does not dip at every passage
    through the mean. A definition of this package's own; published indices of that kind weigh more quantities, by
    coefficients that are not public.

    Args:
        signal: Values and rates of now, each (..., 6), as measured or from a table.
        limits: Limit on the absolute value of each quantity; those with a rate in `QUANTITIES`.
        frequencies: w of each [rad/s], of a record up to now (`zero_crossing_frequencies`) or assumed.
        means: m of each in its unit, of such a record (`record_means`) or assumed; 0 where there is none. Without its
            mean a heeled deck has an index that swings, and that dips below 1 although every roll passes the limit.

    Returns:
        The index, (...).

    Raises:
        ConfigurationError: As `label`, a quantity without rate or frequency, or a mean that is not finite.
    """
    checked = _checked(limits)
    shares = []
    for name, limit in checked.items():
        rate = _rate(name)(signal)
        w = frequencies.get(name)
        if w is None or not (math.isfinite(w) and w > 0.0):
            raise ConfigurationError(f"quiescence: the frequency of {name} is {w!r}: must be above 0 rad/s")
        mean = 0.0 if means is None else means.get(name, 0.0)
        if not math.isfinite(mean):
            raise ConfigurationError(f"quiescence: the mean of {name} is {mean!r}: must be a finite number")
        shares.append((abs(mean) + np.hypot(QUANTITIES[name].value(signal) - mean, rate / w)) / limit)
    return np.asarray(np.max(np.stack(shares), axis=0), dtype=np.float64)


def _checked(limits: Mapping[str, float]) -> dict[str, float]:
    if not limits:
        raise ConfigurationError(f"quiescence: no limits; allowed are {', '.join(QUANTITIES)}")
    for name, limit in limits.items():
        if name not in QUANTITIES:
            raise ConfigurationError(f"quiescence: {name!r} is not limited, allowed are {', '.join(QUANTITIES)}")
        if not (isinstance(limit, int | float) and math.isfinite(limit) and limit > 0.0):
            raise ConfigurationError(f"quiescence: the limit of {name} is {limit!r}: must be a number above 0")
    return dict(limits)


def _rate(name: str) -> Callable[[Signal], FloatArray]:
    rate = QUANTITIES[name].rate
    if rate is None:
        known = ", ".join(key for key, quantity in QUANTITIES.items() if quantity.rate is not None)
        raise ConfigurationError(f"quiescence: {name} has no rate in a table, the index allows {known}")
    return rate


def _use(signal: Signal, limits: Mapping[str, float]) -> FloatArray:
    """Largest share of a limit that is in use, (n,)."""
    shares = [np.abs(QUANTITIES[name].value(signal)) / limit for name, limit in limits.items()]
    return np.asarray(np.max(np.stack(shares), axis=0), dtype=np.float64)


def _bisected(
    table: MotionTable,
    limits: Mapping[str, float],
    before: FloatArray,
    after: FloatArray,
    within_before: npt.NDArray[np.bool_],
) -> FloatArray:
    """Where the use of the limits passes 1 between two times each, (n,)."""
    lower, upper = before.copy(), after.copy()
    for _ in range(_BISECTIONS):
        middle = 0.5 * (lower + upper)
        same = (_use(table.at(middle), limits) <= 1.0) == within_before
        lower, upper = np.where(same, middle, lower), np.where(same, upper, middle)
    return 0.5 * (lower + upper)
