"""Where a case starts: settled on the deck, dropped from a height, or in a given state (INITIALS.INP)."""

from __future__ import annotations

from typing import Annotated, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ssmash_gym.cases.section import CaseSection
from ssmash_gym.dynamics.layout import STATION_COORDINATES, STATIONS, State
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.fields import EulerParameters, Number, Vector
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.parameters import droop_state, unit
from ssmash_gym.simulation.settle import probe_point, turn

Array = NDArray[np.float64]
# Largest acceleration left in a rest [m/s2, rad/s2]; where wheels roll down a sloping deck there is none to be found.
AT_REST: Final = 1.0e-6
SLACK_M: Final = 0.05  # by which a strut may be longer than at full droop, or past its end stop


class Settled(CaseSection):
    """At rest on its wheels, with the claw at its probe."""

    type: Literal["settled"] = "settled"
    x_m: Number = Field(0.0, description="claw and probe point along the track, S axes [m]")
    y_m: Number = Field(0.0, description="claw and probe point across the track, S axes [m]")
    yaw_deg: Number = Field(0.0, description="heading relative to the track [deg]")
    steer_deg: Number = Field(0.0, description="steer angle of the auxiliary station [deg]")
    surface: Literal["deck", "level"] = Field("deck", description="the deck as it stands at the start, or a level one")


class Drop(CaseSection):
    """In the air, at rest relative to the deck, every suspension at full droop."""

    type: Literal["drop"] = "drop"
    cg_height_m: Number = Field(description="height of the body's c.g. over the deck [m]")
    x_m: Number = Field(0.0, description="body's c.g. along the track, S axes [m]")
    y_m: Number = Field(0.0, description="body's c.g. across the track, S axes [m]")
    roll_deg: Number = Field(0.0, description="attitude relative to the deck, yaw-pitch-roll [deg]")
    pitch_deg: Number = Field(0.0, description="attitude relative to the deck [deg]")
    yaw_deg: Number = Field(0.0, description="attitude relative to the deck [deg]")
    sink_mps: Number = Field(0.0, description="speed towards the deck [m/s]")


class Given(CaseSection):
    """The state in numbers, as INITIALS.INP has it (Léveillé 2013, appendix A)."""

    type: Literal["state"] = "state"
    position_m: Vector = Field(description="body's c.g. from the ship-frame origin, S axes, r_SH_S (line 1) [m]")
    orientation: EulerParameters = Field(description="Euler parameters H to S (line 2)")
    strut_m: Vector = Field(description="distances O to W along o_z: auxiliary, right, left (line 3) [m]")
    strut_orientations: tuple[EulerParameters, EulerParameters, EulerParameters] = Field(
        description="Euler parameters O to H: auxiliary, right, left (lines 4-6)"
    )
    velocity_mps: Vector = Field((0.0, 0.0, 0.0), description="velocity over the ship, S axes (line 7) [m/s]")
    angular_velocity_radps: Vector = Field(
        (0.0, 0.0, 0.0), description="angular velocity relative to the ship, H axes (line 8) [rad/s]"
    )
    strut_rates: Vector = Field(
        (0.0, 0.0, 0.0), description="slide speeds along o_z [m/s] or arm rates about o_y [rad/s] (line 9)"
    )
    steer_rates_radps: Vector = Field((0.0, 0.0, 0.0), description="steer rates about o_z (line 10) [rad/s]")


Start = Annotated[Settled | Drop | Given, Field(discriminator="type")]


def place(batch: Batch, start: Settled | Drop | Given, name: str) -> None:
    """Bring a batch of one to its start; the deck's table has been set, and its clock stands at zero.

    Args:
        batch: One helicopter, claw commanded and still.
        start: Where it starts.
        name: The case, for messages.

    Raises:
        ConfigurationError: A start at rest was asked for and there is none: wheels roll down a sloping deck.
    """
    if isinstance(start, Settled):
        _settle(batch, start, name)
        return
    if isinstance(start, Given):
        _check(batch, start, name)
    batch.state[:, 0] = _dropped(batch, start) if isinstance(start, Drop) else _given(batch, start)
    batch.state[State.CLAW_X : State.CLAW_Y + 1, 0] = probe_point(batch, np.arange(1))[:, 0]


def _settle(batch: Batch, start: Settled, name: str) -> None:
    left = batch.place(start.x_m, start.y_m, np.radians(start.yaw_deg))
    if start.steer_deg != 0.0:
        none = np.zeros(1)
        turn(batch.state, State.Q16, (none, none, np.radians([start.steer_deg])))
        left = batch.settle()
    if left[0] > AT_REST:
        raise ConfigurationError(
            f"case {name}: start.type = 'settled' is refused: there is no rest on this deck, {left[0]:.2g} m/s2 "
            "are left; lock the wheels, activate the probe, or start on 'surface: level'."
        )


def _dropped(batch: Batch, start: Drop) -> Array:
    roll, pitch, yaw = np.radians([start.roll_deg, start.pitch_deg, start.yaw_deg])
    e = _euler_parameters(float(roll), float(pitch), float(yaw))
    position = (start.x_m, start.y_m, -start.cg_height_m)
    state = droop_state(batch.helicopters[0], position_S=position, orientation=e)
    state[State.U9] = start.sink_mps
    return state


def _given(batch: Batch, start: Given) -> Array:
    state = droop_state(batch.helicopters[0], position_S=start.position_m, orientation=start.orientation)
    for i in range(STATIONS):
        row = State.Q15 + STATION_COORDINATES * i
        state[row] = start.strut_m[i]
        state[row + 1 : row + 5] = unit(start.strut_orientations[i])
        state[State.U13 + 2 * i] = start.strut_rates[i]
        state[State.U14 + 2 * i] = start.steer_rates_radps[i]
    state[State.U7 : State.U9 + 1] = start.velocity_mps
    state[State.U10 : State.U12 + 1] = start.angular_velocity_radps
    return state


def _check(batch: Batch, start: Given, name: str) -> None:
    """Refuse a start that no run can begin with.

    Raises:
        ConfigurationError: A prismatic strut is out of its stroke, or the c.g. lies below the deck.
    """
    if start.position_m[2] >= 0.0:
        raise ConfigurationError(
            f"case {name}: start.position_m = {start.position_m} is refused: the body's c.g. must lie above the deck, "
            "its z is negative there."
        )
    for station, strut in zip(batch.helicopters[0].station_tuple, start.strut_m, strict=True):
        droop, stroke = station.droop_m[2], station.end_stop.stroke_m
        if station.kind == "prismatic" and not droop - stroke - SLACK_M <= strut <= droop + SLACK_M:
            raise ConfigurationError(
                f"case {name}: start.strut_m = {start.strut_m} is refused: each prismatic strut must be between its "
                f"length at the end stop and at full droop, one of them {droop - stroke:g} to {droop:g} m."
            )


def _euler_parameters(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Euler parameters of yaw-pitch-roll angles [rad]."""
    cr, sr = np.cos(0.5 * roll), np.sin(0.5 * roll)
    cp, sp = np.cos(0.5 * pitch), np.sin(0.5 * pitch)
    cy, sy = np.cos(0.5 * yaw), np.sin(0.5 * yaw)
    return (
        float(cr * cp * cy + sr * sp * sy),
        float(sr * cp * cy - cr * sp * sy),
        float(cr * sp * cy + sr * cp * sy),
        float(cr * cp * sy - sr * sp * cy),
    )
