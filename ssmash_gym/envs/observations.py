"""The observation: one table of named terms, each with its physical scale, sensor noise and meaning.

A term is its SI value divided by a documented physical scale, clipped to a finite bound. A new observation is one
line in `TERMS`. None knows the sea state or the draw of the episode, and none but the terms of the set ``oracle``,
which serve as a reference, the future of the deck's motion.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.layout import STATION_NAMES
from ssmash_gym.envs.reading import Reading
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.simulation.telemetry import channel

Array = NDArray[np.float64]
Read = Callable[[Reading], Array]
GRAVITY: Final = 9.81  # [m/s2]; taken from the vertical specific force, so that a deck at rest reads about zero
LEADS_S: Final = (1, 2, 3, 5)  # of the forecasts [s]: beyond 5 s accelerations are hardly foreseen at all


@dataclass(frozen=True)
class Term:
    """One number of the observation.

    Attributes:
        name: What it is called.
        meaning: In words, with the frame.
        unit: SI unit of `read` and of `scale`.
        scale: The value that is observed as 1.
        noise: Nominal standard deviation of the sensor [unit] (assumed); 0 for what is known exactly.
        read: Takes the value from a reading, (n,).
        sensor: Whether it is measured: noise and delay apply.
        basic: Whether it belongs to the set ``sensors``; ``full`` holds all but the forecasts.
        channel: The telemetry channel that `read` takes as it is, if it does no more.
        forecast_of: The measured term whose forecast this is, if it is one.
        oracle_of: The measured term whose true future this is, if it is one; lead_s: how far ahead, of both [s].
        past_of: The observed term whose earlier reading this is, if it is one; lag_s: how long before [s].
    """

    name: str
    meaning: str
    unit: str
    scale: float
    noise: float
    read: Read
    sensor: bool = True
    basic: bool = True
    channel: str = ""
    forecast_of: str = ""
    oracle_of: str = ""
    lead_s: float = 0.0
    past_of: str = ""
    lag_s: float = 0.0

    @property
    def kind(self) -> str:
        """The named set that holds it beyond ``sensors``."""
        return "forecast" if self.forecast_of else "oracle" if self.oracle_of else "full"


def _channel(name: str, meaning: str, unit: str, scale: float, noise: float, basic: bool = True) -> Term:
    """A term that is the telemetry channel of its name."""
    return Term(name, meaning, unit, scale, noise, lambda r: r[name], basic=basic, channel=name)


def _known(name: str, meaning: str, unit: str, scale: float, read: Read) -> Term:
    """A term of the task that is known exactly."""
    return Term(name, meaning, unit, scale, 0.0, read, sensor=False)


def _station(suffix: str, meaning: str, unit: str, scale: float, noise: float, basic: bool = True) -> list[Term]:
    """The same channel of the three stations."""
    return [
        _channel(f"{name}_{suffix}", f"{name} station: {meaning}", unit, scale, noise, basic=basic)
        for name in STATION_NAMES
    ]


def _forecast(name: str, of: str, scale: float, unit: str, meaning: str) -> list[Term]:
    """Forecasts of a measured term from its own past readings; `forecasts.ForecastBank` gives their values."""
    return [
        Term(
            f"forecast_{name}_{lead}s", f"{meaning}, {lead} s after the reading", unit, scale, 0.0, _nothing_yet,
            sensor=False, basic=False, forecast_of=of, lead_s=float(lead),
        )
        for lead in LEADS_S
    ]  # fmt: skip


def _oracle(name: str, of: str, scale: float, unit: str, meaning: str) -> list[Term]:
    """The true future of a measured term; `oracle.OracleBank` gives its values."""
    return [
        Term(
            f"oracle_{name}_{lead}s", f"{meaning}, {lead} s after now", unit, scale, 0.0, _nothing_yet,
            sensor=False, basic=False, oracle_of=of, lead_s=float(lead),
        )
        for lead in LEADS_S
    ]  # fmt: skip


def _nothing_yet(r: Reading) -> Array:
    return np.zeros(r.steps.size)


def _steer(r: Reading) -> Array:
    return r["auxiliary_steer"]


def _vertical_specific_force(r: Reading) -> Array:
    return np.asarray(r["deck_fz"] + GRAVITY)


def _near(r: Reading) -> Array:
    return np.asarray(r.to_go_m / (0.25 + np.abs(r.to_go_m)))


def _held(r: Reading) -> Array:
    return np.asarray(r.held / max(r.task.hold_steps + 1, 1))


_TERMS: Final = (
    _channel("roll", "helicopter relative to the deck", "rad", 0.05, 0.001),
    _channel("pitch", "helicopter relative to the deck", "rad", 0.05, 0.001),
    _channel("yaw", "helicopter relative to the deck", "rad", 0.1, 0.001),
    _channel("roll_rate", "angular velocity relative to the ship, H axes, x", "rad/s", 0.1, 0.002),
    _channel("pitch_rate", "the same, y", "rad/s", 0.1, 0.002),
    _channel("yaw_rate", "the same, z", "rad/s", 0.1, 0.002),
    _channel("deck_roll", "ship roll", "rad", 0.1, 0.001),
    _channel("deck_pitch", "ship pitch", "rad", 0.05, 0.001),
    _channel("deck_wx", "deck IMU: angular velocity, S axes, x", "rad/s", 0.1, 0.001),
    _channel("deck_wy", "deck IMU: angular velocity, y", "rad/s", 0.05, 0.001),
    _channel("deck_wz", "deck IMU: angular velocity, z", "rad/s", 0.05, 0.001),
    _channel("deck_fx", "deck IMU: specific force, S axes, x", "m/s2", 1.0, 0.02),
    _channel("deck_fy", "deck IMU: specific force, y", "m/s2", 1.0, 0.02),
    Term("deck_fz", "deck IMU: specific force, z, plus 9.81 m/s2", "m/s2", 1.0, 0.02, _vertical_specific_force),
    _channel("probe_fx", "probe force on the helicopter, H axes, x", "N", 1e4, 100.0),
    _channel("probe_fy", "probe force on the helicopter, y", "N", 1e4, 100.0),
    _channel("probe_axial", "axial probe tension", "N", 1e4, 100.0),
    Term("probe_peak", "largest in-plane probe load of the last interval", "N", 1e4, 100.0, lambda r: r.probe_peak_N),
    *_station("tire_vertical_deflection", "vertical tire deflection", "m", 0.05, 0.001),
    *_station("tire_lateral_deflection", "lateral tire deflection", "m", 0.02, 0.001),
    *_station("vertical_load", "vertical tire load", "N", 4e4, 200.0),
    *_station("compression", "oleo compression from full droop", "m", 0.3, 0.001),
    Term("auxiliary_steer_sin", "sine of the auxiliary steer angle", "1", 0.2, 0.005, lambda r: np.sin(_steer(r))),
    Term("auxiliary_steer_cos", "cosine of the auxiliary steer angle", "1", 1.0, 0.005, lambda r: np.cos(_steer(r))),
    _channel("claw_x", "claw along the track", "m", 4.0, 0.001),
    _channel("claw_y", "claw across the track", "m", 0.1, 0.001),
    _channel("claw_vx", "claw velocity along the track", "m/s", 0.3, 0.002),
    _channel("claw_vy", "claw velocity across the track", "m/s", 0.1, 0.002),
    Term("to_go", "claw's distance to the goal along the track", "m", 2.0, 0.001, lambda r: r.to_go_m),
    Term("to_go_near", "the same, d / (0.25 m + |d|): fine near the goal", "1", 1.0, 0.002, _near),
    _known("last_command_x", "command applied in the last interval, along", "1", 1.0, lambda r: r.command[:, 0]),
    _known("last_command_y", "command applied in the last interval, across", "1", 1.0, lambda r: r.command[:, 1]),
    _known("time_left", "time until the limit", "s", 60.0, lambda r: r.time_left_s),
    _known("episode_peak", "largest in-plane probe load of the episode so far", "N", 1e4, lambda r: r.episode_peak_N),
    _known("goal_held", "share of the holding time that has passed in the goal", "1", 1.0, _held),
    # --- only in "full" ---
    _channel("velocity_x", "c.g. velocity over the deck, S axes, x", "m/s", 0.3, 0.005, basic=False),
    _channel("velocity_y", "c.g. velocity over the deck, y", "m/s", 0.1, 0.005, basic=False),
    _channel("velocity_z", "c.g. velocity over the deck, z", "m/s", 0.1, 0.005, basic=False),
    _channel("probe_x", "probe point in the claw plane, S axes, x", "m", 4.0, 0.001, basic=False),
    _channel("probe_y", "probe point in the claw plane, y", "m", 0.1, 0.001, basic=False),
    _channel("probe_dx", "probe point from the claw centre, H axes, x", "m", 0.02, 0.0005, basic=False),
    _channel("probe_dy", "probe point from the claw centre, y", "m", 0.02, 0.0005, basic=False),
    _channel("probe_extension", "axial probe extension", "m", 0.02, 0.0005, basic=False),
    _channel("deck_yaw", "ship yaw about its mean heading", "rad", 0.05, 0.001, basic=False),
    _channel("auxiliary_steer_rate", "steer rate of the auxiliary station", "rad/s", 0.5, 0.01, basic=False),
    _channel("wind_fx", "wind force, H axes, x", "N", 2e3, 50.0, basic=False),
    _channel("wind_fy", "wind force, y", "N", 2e3, 50.0, basic=False),
    *_station("lateral_load", "lateral tire force", "N", 1e4, 200.0, basic=False),
    *_station("longitudinal_load", "longitudinal tire force", "N", 1e4, 200.0, basic=False),
    *_station("tire_longitudinal_deflection", "longitudinal tire deflection", "m", 0.02, 0.001, basic=False),
    *_station("tire_twist", "tire twist", "rad", 0.05, 0.002, basic=False),
    *_station("friction_use", "largest share of the tire friction limit in use", "1", 1.0, 0.01, basic=False),
    *_station("compression_rate", "oleo compression rate", "m/s", 0.1, 0.005, basic=False),
    *_station("oleo_force", "oleo force", "N", 4e4, 200.0, basic=False),
    # --- only in "forecast" ---
    *_forecast("roll", "deck_roll", 0.1, "rad", "forecast of `deck_roll`"),
    *_forecast("fx", "deck_fx", 1.0, "m/s2", "forecast of `deck_fx`"),
    *_forecast("fy", "deck_fy", 1.0, "m/s2", "forecast of `deck_fy`"),
    *_forecast("fz", "deck_fz", 1.0, "m/s2", "forecast of `deck_fz`"),
    # --- only in "oracle": a reference for what forecasts could be worth; no instrument gives them ---
    *_oracle("roll", "deck_roll", 0.1, "rad", "true future of `deck_roll`"),
    *_oracle("fx", "deck_fx", 1.0, "m/s2", "true future of `deck_fx`"),
    *_oracle("fy", "deck_fy", 1.0, "m/s2", "true future of `deck_fy`"),
    *_oracle("fz", "deck_fz", 1.0, "m/s2", "true future of `deck_fz`"),
)
TERMS: Final[Mapping[str, Term]] = {term.name: term for term in _TERMS}


def chosen_terms(observation: str | Sequence[str]) -> tuple[Term, ...]:
    """The terms of a set (``sensors``, ``full``, ``forecast``, ``oracle``) or of a list of names, in that order.

    Raises:
        ConfigurationError: A name is unknown, the list is empty or names a term twice, or a forecast stands there
            without the term it is a forecast of.
    """
    if isinstance(observation, str):
        return tuple(term for term in _TERMS if term.basic or observation == term.kind)
    for name in observation:
        if name not in TERMS:
            close = difflib.get_close_matches(name, TERMS, n=3)
            hint = f"close ones are {', '.join(close)}" if close else "see `observations.TERMS`"
            raise ConfigurationError(f"task: observation names {name!r}, which is no term; {hint}.")
    if not observation or len(set(observation)) < len(observation):
        raise ConfigurationError(f"task: observation = {list(observation)}: name at least one term, and none twice.")
    for name in observation:
        of = TERMS[name].forecast_of
        if of and of not in observation:
            raise ConfigurationError(
                f"task: observation names {name!r} but not {of!r}, whose readings it is made from."
            )
    return tuple(TERMS[name] for name in observation)


def observed_terms(task: TaskConfig) -> tuple[Term, ...]:
    """Every term of a task's observation: those it chooses, and behind them the past readings of its history.

    Raises:
        ConfigurationError: As of `chosen_terms`; or the history names a term that is not observed, or no measured one.
    """
    terms = chosen_terms(task.observation)
    if task.history is None:
        return terms
    present = {term.name: term for term in terms if term.sensor}
    for name in task.history.terms:
        if name not in present:
            raise ConfigurationError(
                f"task: history.terms names {name!r}: must be a measured term of the observation, such as "
                f"{', '.join(list(present)[:3]) or 'those of the set sensors'}."
            )
    if len(set(task.history.terms)) < len(task.history.terms):
        raise ConfigurationError(f"task: history.terms = {list(task.history.terms)}: name none twice.")
    lags = [k * task.history.every_s for k in range(1, task.history.samples + 1)]
    return terms + tuple(_past(present[name], lag) for name in task.history.terms for lag in lags)


def _past(term: Term, lag_s: float) -> Term:
    return Term(
        f"{term.name}_before_{lag_s:.4g}s", f"reading of `{term.name}` {lag_s:.4g} s before", term.unit, term.scale,
        0.0, _nothing_yet, sensor=False, basic=False, past_of=term.name, lag_s=lag_s,
    )  # fmt: skip


def _places(pairs: Iterable[tuple[int, int]]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Places in the observation and rows of the table they are read from."""
    found = np.array(list(pairs), dtype=np.int64).reshape(-1, 2)
    return found[:, 0], found[:, 1]


class Observer:
    """Turns a reading into scaled numbers, and measured numbers into an observation.

    Args:
        task: The task; `observation`, `history` and `observation_clip` are used.

    Attributes:
        terms: The terms, in order.
        size: How many.
        sensors: Columns that are measured, (k,).
        noise: Their nominal noise in units of their scale, (k,).
    """

    def __init__(self, task: TaskConfig) -> None:
        self.terms = observed_terms(task)
        self.size = len(self.terms)
        self.clip = task.observation_clip
        self.sensors = np.array([k for k, term in enumerate(self.terms) if term.sensor], dtype=np.int64)
        self.noise = np.array([term.noise / term.scale for term in self.terms if term.sensor])
        self._inverse = 1.0 / np.array([[term.scale] for term in self.terms])
        found = [(k, channel(term.channel)) for k, term in enumerate(self.terms) if term.channel]
        self._outputs = _places((k, c.row) for k, c in found if c.has_peaks)
        self._states = _places((k, c.row) for k, c in found if not c.has_peaks)
        self._computed = [(k, term) for k, term in enumerate(self.terms) if not term.channel]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the terms, in order."""
        return tuple(term.name for term in self.terms)

    def scaled(self, reading: Reading) -> Array:
        """True values in units of their scales, (n, size)."""
        values = np.empty((self.size, reading.steps.size))
        for (places, rows), table in (
            (self._outputs, reading.telemetry.outputs),
            (self._states, reading.telemetry.state),
        ):
            values[places] = table[rows]
        for k, term in self._computed:
            values[k] = term.read(reading)
        return np.ascontiguousarray((values * self._inverse).T)

    def observation(self, scaled: Array) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
        """Clip; returns the observation (n, size) and how many of its numbers were clipped, (n,)."""
        clipped = np.count_nonzero(np.abs(scaled) > self.clip, axis=1)
        return np.clip(scaled, -self.clip, self.clip).astype(np.float32), clipped
