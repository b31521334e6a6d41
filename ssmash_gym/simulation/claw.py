"""What the securing device's drive can do: speeds, acceleration, travel, delay, ripple."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from ssmash_gym.dynamics.claw import place_claw
from ssmash_gym.dynamics.deck import COEFFICIENTS, gather_piece, prescribed_claw
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import Par
from ssmash_gym.errors import ConfigurationError

Array = NDArray[np.float64]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class ClawLimits(BaseModel):
    """Limits of the claw drive in ship axes; no operational source is public, so every default is assumed."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    speed_along_m_s: Positive = Field(0.3, description="speed along the track for a command of 1 [m/s]")
    speed_across_m_s: Positive = Field(0.1, description="speed across the track for a command of 1 [m/s]")
    acceleration_m_s2: Positive = Field(0.3, description="acceleration limit on both axes [m/s2]")
    x_min_m: float = Field(0.0, description="travel limit aft: the landing position [m]")
    x_max_m: float = Field(8.0, description="travel limit forward: the hangar position [m]")
    y_travel_m: Positive = Field(0.3, description="lateral travel to either side of the centre line [m]")
    height_m: NonNegative = Field(0.0, description="height of the claw plane above the deck [m]")
    delay_s: NonNegative = Field(0.1, description="delay from command to drive [s]")
    ripple_along_m: NonNegative = Field(0.0, description="amplitude of the drive's ripple along the track [m]")
    ripple_across_m: NonNegative = Field(0.0, description="amplitude of the ripple across the track [m]")
    ripple_hz: Positive = Field(1.0, description="frequency of the ripple [Hz] (about 1 Hz in the thesis' records)")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.x_min_m >= self.x_max_m:
            raise ValueError(f"x_min_m = {self.x_min_m} must be below x_max_m = {self.x_max_m}")
        return self

    def fill(self, column: NDArray[np.float64], substep_s: float) -> None:
        """Write the limits into a parameter column; the delay is rounded to whole substeps."""
        rows = {
            Par.CLAW_Z: -self.height_m,
            Par.CLAW_SPEED_X: self.speed_along_m_s,
            Par.CLAW_SPEED_Y: self.speed_across_m_s,
            Par.CLAW_ACCEL_X: self.acceleration_m_s2,
            Par.CLAW_ACCEL_Y: self.acceleration_m_s2,
            Par.CLAW_X_MIN: self.x_min_m,
            Par.CLAW_X_MAX: self.x_max_m,
            Par.CLAW_Y_MIN: -self.y_travel_m,
            Par.CLAW_Y_MAX: self.y_travel_m,
            Par.CLAW_DELAY: round(self.delay_s / substep_s) * substep_s,
            Par.RIPPLE_X: self.ripple_along_m,
            Par.RIPPLE_Y: self.ripple_across_m,
            Par.RIPPLE_OMEGA: 2.0 * np.pi * self.ripple_hz,
            Par.RIPPLE_PHASE: 0.0,
        }
        for row, value in rows.items():
            column[row] = value


def history_nodes(nodes: ArrayLike, count: int) -> Array:
    """Nodes of prescribed claws (count, nodes, 9) with the last one held behind them.

    Raises:
        ConfigurationError: the nodes have another shape.
    """
    table = np.array(nodes, dtype=np.float64)
    if table.ndim != 3 or table.shape[0] != count or table.shape[1] < 2 or table.shape[2] != 9:
        raise ConfigurationError(f"claw nodes: shape {table.shape}, must be ({count}, at least 2, 9)")
    held = table[:, -1:, :].copy()
    held[:, :, 3:] = 0.0
    return np.concatenate([table, held, held], axis=1)


def write_drive(state: Array, parameters: Array, time_s: Array, decks: Array) -> None:
    """Claw rows of `decks` (DECK_ROWS, n) of a commanded claw, ripple included, at the columns' times (n,) [s]."""
    uncompiled(place_claw)(state, parameters, 1, time_s, decks)


def write_history(nodes: Array, clocks: NDArray[np.int64], per_node: int, substep_s: float, decks: Array) -> None:
    """Claw rows of `decks` (DECK_ROWS, n) of prescribed claws: `nodes` (n, nodes, 9), `clocks` (n,) in substeps."""
    pieces = np.minimum(clocks // per_node, nodes.shape[1] - 2)
    c = np.empty((3 * COEFFICIENTS, clocks.size))
    for k, piece in enumerate(pieces):
        uncompiled(gather_piece)(nodes, k, piece, 3, per_node * substep_s, c, k)
    uncompiled(prescribed_claw)(c, (clocks % per_node) * substep_s, decks)
