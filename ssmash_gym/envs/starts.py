"""How an episode starts: the draw goes into the parameters, the helicopter is settled, the sea comes up."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics import vectors
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import SPEEDS, STATION_ROWS, STATIONS, TIRE_PAR, TIRE_ROWS, TIRES, Par, Sta, State, Tir
from ssmash_gym.envs.decks import Decks
from ssmash_gym.envs.scenario import EpisodeDraw, ScenarioConfig, check_draw
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.envs.touchdown import set_down
from ssmash_gym.errors import ConfigurationError, refusal, shown
from ssmash_gym.ship import Motion, MotionTable
from ssmash_gym.ship.wind import blows_towards, wind_over_deck
from ssmash_gym.simulation.batch import Batch, Timing
from ssmash_gym.simulation.parameters import parameter_column
from ssmash_gym.vehicle import Helicopter, with_changes

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
_rotation = uncompiled(vectors.rotation)
_apply = uncompiled(vectors.apply)
_SETTLING_S = 4.0  # a lead-in of this length settles small differences of mass, c.g. and tire pressure
_SLIGHT_DEG = 3.0  # heel and trim at the start of a seaway that need no settling of their own
_VARIED = {  # what a draw changes of the helicopter, and its undisturbed value
    "mass_factor": 1.0,
    "cg_x_m": 0.0,
    "cg_y_m": 0.0,
    "cg_z_m": 0.0,
    "friction_factor": 1.0,
    "pressure_factor": 1.0,
}
WHEEL_CHANGES = {
    "rolling": {"stations.right.rolling": "free", "stations.left.rolling": "free"},
    "braked": {"stations.right.rolling": "locked", "stations.left.rolling": "locked"},
    "locked": {
        "stations.right.rolling": "free",
        "stations.left.rolling": "free",
        "stations.auxiliary.steering": "locked",
    },
}


def prepared(helicopter: Helicopter, task: TaskConfig) -> Helicopter:
    """The helicopter with its wheels as the task wants them and the probe held by the claw.

    Raises:
        ConfigurationError: The helicopter's auxiliary station cannot castor (a swing arm), but the task wants it to, or
            the task's ultimate probe load lies above the probe's own.
    """
    bears_kN = 1e-3 * helicopter.probe.ultimate_load_N
    if task.limits.probe_ultimate_kN > bears_kN * (1.0 + 1e-9):
        raise ConfigurationError(
            f"task: limits.probe_ultimate_kN = {task.limits.probe_ultimate_kN:g} is refused for {helicopter.name}: "
            f"must be at most the {bears_kN:g} kN at which its probe is lost (probe.ultimate_load_N)."
        )
    changes: dict[str, object] = {**WHEEL_CHANGES[task.wheels], "probe.active": True, "probe.captured": True}
    if task.wheels != "locked":
        if helicopter.stations.auxiliary.kind == "swing_arm":
            raise ConfigurationError(
                f"task: wheels = {task.wheels!r} is refused for {helicopter.name}: its auxiliary station is a swing "
                "arm and cannot castor; use 'locked'."
            )
        changes["stations.auxiliary.steering"] = "free"
    return with_changes(helicopter, changes)


def varied(helicopter: Helicopter, draw: EpisodeDraw) -> Helicopter:
    """The helicopter of a draw as a validated description: the readable twin of `vary`.

    Raises:
        ConfigurationError: The draw makes it no helicopter.
    """
    f = draw.helicopter_mass_factor
    shift = (draw.helicopter_cg_x_m, draw.helicopter_cg_y_m, draw.helicopter_cg_z_m)
    changes: dict[str, object] = {
        "mass_kg": f * helicopter.mass_kg,
        "inertia_kgm2": [[f * number for number in row] for row in helicopter.inertia_kgm2],
        "cg_offset_m": [a + b for a, b in zip(helicopter.cg_offset_m, shift, strict=True)],
    }
    for name, station in zip(("auxiliary", "right", "left"), helicopter.station_tuple, strict=True):
        for k, tire in enumerate(station.tires):
            path = f"stations.{name}.tires.{k}"
            changes[f"{path}.friction_coefficient"] = draw.helicopter_friction_factor * tire.friction_coefficient
            changes[f"{path}.pressure_Pa"] = draw.helicopter_pressure_factor * tire.pressure_Pa
    return with_changes(helicopter, changes)


def vary(column: Array, draw: EpisodeDraw) -> None:
    """Put a draw's mass, c.g., friction and tire pressure into a parameter column, in place.

    The inertia tensor goes with the mass; the c.g. shift moves every mounting point the other way.
    """
    column[Par.MASS : Par.IZZ + 1] *= draw.helicopter_mass_factor
    points = [int(Par.CP), int(Par.PROBE_MOUNT)]
    for i in range(STATIONS):
        base = Par.STATION + i * STATION_ROWS
        points += [base + Sta.MOUNT, base + Sta.P1] if column[base + Sta.LENGTH] else [base + Sta.MOUNT]
    for row in points:
        column[row : row + 3] -= _cg_shift(draw)
    for t in range(TIRES):
        base = TIRE_PAR + t * TIRE_ROWS
        column[base + Tir.MU] *= draw.helicopter_friction_factor
        gauge = column[base + Tir.P_O] * draw.helicopter_pressure_factor
        column[base + Tir.P_ABS] += gauge - column[base + Tir.P_O]
        column[base + Tir.P_O] = gauge


def _cg_shift(draw: EpisodeDraw) -> Array:
    return np.array([draw.helicopter_cg_x_m, draw.helicopter_cg_y_m, draw.helicopter_cg_z_m])


def relative_wind(draw: EpisodeDraw) -> Array:
    """True wind minus the ship's mean velocity [m/s], N axes (x along the mean heading, y starboard, z down), (3,)."""
    return wind_over_deck(draw.wind_speed_mps, draw.wind_from_deg, draw.wind_ship_speed_mps)


def gust_direction(draw: EpisodeDraw) -> Array:
    """Unit vector along which the gusts add to the true wind, N axes, (3,): its own direction; zero without gusts."""
    gusty = draw.wind_gust_intensity * draw.wind_speed_mps > 0.0
    return blows_towards(draw.wind_from_deg) if gusty else np.zeros(3)


def _level(draw: EpisodeDraw) -> bool:
    """Whether the deck is level before the motion is ramped in, or nearly so before a sea.

    A slight heel loads the probe by what the tires do not take, some 0.9 kN a degree: as a landing on a ship under way
    does, and less than the sea does during the lead-in. The search for equilibrium would take twice as long as that.
    """
    kind = draw.motion["type"]
    if kind == "seaway":
        return all(abs(draw.motion.get(key, 0.0)) <= _SLIGHT_DEG for key in ("heel_deg", "trim_deg"))
    return kind != "file" and not (draw.motion.get("roll_deg") or draw.motion.get("pitch_deg"))


class Starter:
    """Starts episodes of one task and scenario with one helicopter.

    Args:
        helicopter: As in the catalogue.
        task: The task.
        scenario: Its extremes are tried at once, so that a bad range is refused before the first episode.

    Raises:
        ConfigurationError: The task or the scenario does not suit the helicopter or the claw.
    """

    def __init__(self, helicopter: Helicopter, task: TaskConfig, scenario: ScenarioConfig) -> None:
        self.task = task
        self.scenario = scenario
        self.helicopter = prepared(helicopter, task)
        self.timing = Timing(task.substep_s, task.control_interval_s)
        delay = scenario.bounds("claw.delay_s")
        self.longest_delay_s = task.claw.delay_s if delay is None else delay[1]
        self._column = parameter_column(self.helicopter)
        task.claw.fill(self._column, task.substep_s)
        self.decks = Decks(task, self.timing)
        self._check_ranges()

    def _check_ranges(self) -> None:
        self._check_motion()  # first: an example of a bad motion would be refused as a draw
        lateral = self.scenario.bounds("start.lateral_m") or (0.0, 0.0)
        least = self.scenario.bounds("claw.y_travel_m")
        travel_m = self.task.claw.y_travel_m if least is None else least[0]
        if max(abs(lateral[0]), abs(lateral[1])) > travel_m:
            raise ConfigurationError(
                f"scenario: start.lateral_m reaches {lateral[0]:g} to {lateral[1]:g} m: must lie within the claw's "
                f"lateral travel of {travel_m:g} m."
            )
        example = self.scenario.sample(np.random.default_rng(0)).to_dict()
        for end in (0, 1):
            extreme = {
                f"helicopter_{key}": (self.scenario.bounds(f"helicopter.{key}") or (0.0, 0.0))[end] for key in _VARIED
            }
            if tuple(extreme.values()) != tuple(_VARIED.values()):
                varied(self.helicopter, EpisodeDraw.from_dict({**example, **extreme}))

    def _check_motion(self) -> None:
        """Bake the motions that ask most of a table: what cannot be is told now, with the scenario's key."""
        for key, section in self.scenario.motion.extremes():
            try:
                self.decks.baked(section, 0)
            except ConfigurationError as error:
                raise ConfigurationError(f"scenario: {key} is refused: {error}") from None

    def checked(
        self,
        draws: Sequence[EpisodeDraw | Mapping[str, Any] | None] | None,
        count: int,
        longest_sensor_delay_s: float,
        noisy: bool,
    ) -> list[EpisodeDraw | None]:
        """Draws given by hand for `count` helicopters (None: let the scenario draw), each `check`-ed.

        Raises:
            ConfigurationError: It is no list of that length, or a draw is refused.
        """
        if draws is None:
            return [None] * count
        if not isinstance(draws, list | tuple) or len(draws) != count:
            raise ConfigurationError(f"draws: {shown(draws)} is refused: must be a list of {count}, one a helicopter.")
        given = [d if d is None or isinstance(d, EpisodeDraw) else EpisodeDraw.from_dict(d) for d in draws]
        for draw in given:
            if draw is not None:
                self.check(draw, longest_sensor_delay_s, noisy)
        return given

    def check(self, draw: EpisodeDraw, longest_sensor_delay_s: float, noisy: bool) -> None:
        """Refuse a draw given by hand that is none, or that this environment has no room for.

        Args:
            draw: The draw.
            longest_sensor_delay_s: What the sensors' memory reaches back [s].
            noisy: Whether the sensors can have noise.

        Raises:
            ConfigurationError: It is refused; one sentence.
        """
        check_draw(draw)
        interval = self.task.control_interval_s
        claw_s = math.ceil(self.longest_delay_s / interval - 1e-9) * interval
        rooms = {
            "claw_delay_s": (claw_s, "s, the longest claw delay of this task and scenario"),
            "sensors_delay_s": (longest_sensor_delay_s, "s, the longest sensor delay of this scenario"),
            "start_lateral_m": (
                self.task.claw.y_travel_m if draw.claw_y_travel_m is None else draw.claw_y_travel_m,
                "m either way, the claw's lateral travel",
            ),
        }
        for field, (most, what) in rooms.items():
            value = getattr(draw, field)
            if value is not None and abs(value) > most + 1e-9:
                raise refusal("draw", field, value, f"must be at most {most:g} {what}")
        if draw.sensors_noise and not noisy:
            raise refusal("draw", "sensors_noise", draw.sensors_noise, "must be 0, as this scenario has no noise")
        if any(getattr(draw, f"helicopter_{key}") != plain for key, plain in _VARIED.items()):
            varied(self.helicopter, draw)

    def batch(self, n: int, threads: int) -> Batch:
        """A batch of n such helicopters."""
        return Batch(
            self.helicopter, n, timing=self.timing, modes=self.task.models.modes(), claw=self.task.claw,
            threads=threads, longest_delay_s=self.longest_delay_s,
        )  # fmt: skip

    def column(self, draw: EpisodeDraw) -> Array:
        """The parameters of a draw, (PARAMETER_ROWS,)."""
        column = self._column.copy()
        vary(column, draw)
        column[Par.WIND : Par.WIND + 3] = relative_wind(draw)
        column[Par.GUST : Par.GUST + 3] = gust_direction(draw)
        if draw.claw_delay_s is not None:
            column[Par.CLAW_DELAY] = round(draw.claw_delay_s / self.task.substep_s) * self.task.substep_s
        if draw.claw_ripple_along_m is not None:
            column[Par.RIPPLE_X] = draw.claw_ripple_along_m
        if draw.claw_ripple_across_m is not None:
            column[Par.RIPPLE_Y] = draw.claw_ripple_across_m
        if draw.claw_y_travel_m is not None:
            column[Par.CLAW_Y_MIN], column[Par.CLAW_Y_MAX] = -draw.claw_y_travel_m, draw.claw_y_travel_m
        column[Par.RIPPLE_PHASE] = np.deg2rad(draw.claw_ripple_phase_deg)
        return column

    def table(self, draw: EpisodeDraw) -> MotionTable:
        """The deck motion of a draw: lead-in, horizon and a little more."""
        return self.decks.baked(draw.motion, draw.motion_seed)

    def motion(self, draw: EpisodeDraw) -> tuple[Motion, float]:
        """The same before it is baked and ramped in, and its time when the lead-in starts [s]."""
        return self.decks.motion(draw.motion, draw.motion_seed)

    @cached_property
    def _rest(self) -> Array:
        """State of the undisturbed helicopter at rest on a level deck, probe point over the origin, (STATE_ROWS,)."""
        batch = self.batch(1, 1)
        batch.place(0.0, 0.0, 0.0)
        batch.state[:SPEEDS] = 0.0
        return batch.state[:, 0].copy()

    def _set_down(self, batch: Batch, k: int, draw: EpisodeDraw) -> None:
        """Put column k where the undisturbed helicopter would rest; the lead-in takes up what differs (see tests)."""
        half = 0.5 * math.radians(draw.start_yaw_deg)
        c, s = math.cos(half), math.sin(half)
        state = self._rest.copy()
        x, y = state[State.Q8 : State.Q9 + 1].tolist()
        cos, sin = c * c - s * s, 2.0 * c * s
        state[State.Q8] = self.task.track.start_x_m + cos * x - sin * y
        state[State.Q9] = draw.start_lateral_m + sin * x + cos * y
        e0, e1, e2, e3 = state[State.Q11 : State.Q14 + 1].tolist()
        state[State.Q11 : State.Q14 + 1] = (c * e0 - s * e3, c * e1 - s * e2, c * e2 + s * e1, c * e3 + s * e0)
        state[State.CLAW_X], state[State.CLAW_Y] = self.task.track.start_x_m, draw.start_lateral_m
        R_SH = _rotation(*state[State.Q11 : State.Q14 + 1])
        state[State.Q8 : State.Q10 + 1] += _apply(R_SH, _cg_shift(draw))  # the state tells where the c.g. is
        batch.state[:, k] = state

    def start(self, batch: Batch, columns: Columns, draws: Sequence[EpisodeDraw]) -> None:
        """Bring the listed columns of a batch to the start of the task's time.

        The helicopter is settled on the deck as it first stands, the claw goes to its probe and is held through the
        lead-in while the motion is ramped in. On a level deck a long lead-in settles what the draw has changed. With a
        sink rate, the helicopter is then taken up again and set down (`touchdown.set_down`).

        Raises:
            ConfigurationError: A draw is refused by its table; the batch is as it was.
        """
        parameters = [self.column(draw) for draw in draws]
        decks, gusts = self.decks.tables(draws)
        batch.set_motion(decks, columns)
        batch.set_gusts(gusts, columns)
        for k, column in zip(columns, parameters, strict=True):
            batch.parameters[:, k] = column
        settles_by_itself = self.task.lead_in.duration_s >= _SETTLING_S
        exact = []
        for k, draw in zip(columns, draws, strict=True):
            if settles_by_itself and _level(draw):
                self._set_down(batch, int(k), draw)
            else:
                exact.append((int(k), draw.start_lateral_m, math.radians(draw.start_yaw_deg)))
        if exact:
            some, lateral, yaw = (np.array(numbers) for numbers in zip(*exact, strict=True))
            batch.place(np.full(some.size, self.task.track.start_x_m), lateral, yaw, some)
        if self.task.lead_in_steps:
            batch.advance(None, columns, intervals=self.task.lead_in_steps)
        set_down(batch, columns, draws)


def check_room(scenario: ScenarioConfig, longest_delay_s: float, longest_sensor_delay_s: float, noisy: bool) -> None:
    """Refuse a scenario whose delays or noise an environment has no memory for.

    Args:
        scenario: What its later episodes are to be drawn from.
        longest_delay_s: Of the claw's commands, that it was made for [s].
        longest_sensor_delay_s: Of the sensors [s].
        noisy: Whether its sensors can have noise.

    Raises:
        ConfigurationError: One of them reaches beyond.
    """
    for key, most in (
        ("claw.delay_s", longest_delay_s),
        ("sensors.delay_s", longest_sensor_delay_s),
        ("sensors.noise", math.inf if noisy else 0.0),
    ):
        found = scenario.bounds(key)
        if found is not None and found[1] > most + 1e-9:
            raise ConfigurationError(
                f"scenario: {key} up to {found[1]:g} is refused as a change: the batch was made for {most:g}."
            )
