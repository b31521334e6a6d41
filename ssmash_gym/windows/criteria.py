"""What is judged of an episode: limits by name, each on a column of its row. A new limit is one entry here.

The figures themselves stand in the YAML of a window (``limits``), each with what it rests on; none is operational.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import polars as pl

Sense = Literal["above", "below"]
LOST: Final = "lost"  # ended by a failure: exceeded in any case
GOAL: Final = "goal"  # the goal was not reached within the episode's time


@dataclass(frozen=True)
class Criterion:
    """Something that can be limited.

    Attributes:
        label: In words.
        unit: Of the limit.
        column: Of an episode's row.
        sense: Which side of the limit is too much.
        factor: On the column, e.g. 2 from an RMS to the significant amplitude.
        of_the_sea: Whether no policy can change it.
    """

    label: str
    unit: str
    column: str
    sense: Sense = "above"
    factor: float = 1.0
    of_the_sea: bool = False

    def value(self) -> pl.Expr:
        """The limited quantity of each row, in `unit`."""
        return pl.col(self.column).cast(pl.Float64) * self.factor

    def exceeded(self, limit: float) -> pl.Expr:
        """Whether each row is beyond a limit; what is no number is."""
        value = self.value()
        within = value <= limit if self.sense == "above" else value >= limit
        return ~(within & value.is_finite()).fill_null(False)

    def use(self, limit: float) -> pl.Expr:
        """How much of a limit each row has used: 1 at the limit, more beyond it.

        Of a limit from below, 0 where twice the limit is left, more than 1 where less than the limit is; of one of 0, 2
        below it and 0 above.
        """
        value = self.value()
        if self.sense == "above":
            return value / limit if limit > 0.0 else value.sign() + 1.0
        return 2.0 - value / limit if limit > 0.0 else 1.0 - value.sign()


CRITERIA: Final[Mapping[str, Criterion]] = {
    "probe_in_plane_kN": Criterion("probe load in the deck's plane", "kN", "peak_probe_kN"),
    "probe_axial_kN": Criterion("axial probe load", "kN", "peak_axial_kN"),
    "main_vertical_kN": Criterion("vertical load of a main station", "kN", "peak_main_kN"),
    "auxiliary_vertical_kN": Criterion("vertical load of the auxiliary station", "kN", "peak_auxiliary_kN"),
    "least_station_kN": Criterion("least vertical load of a station (lift-off)", "kN", "least_station_kN", "below"),
    "oleo_share": Criterion("share of an oleo's stroke in use (end stop at 1)", "1", "peak_oleo_share"),
    "roll_deg": Criterion("roll relative to the deck", "deg", "peak_roll_deg"),
    "sliding_m": Criterion("distance slid by a station", "m", "sliding_m"),
    "corridor_clearance_m": Criterion("clearance of a wheel in the corridor", "m", "least_clearance_m", "below"),
    "deck_tilt_deg": Criterion("tilt of apparent gravity on the deck", "deg", "peak_deck_tilt_deg", of_the_sea=True),
    "deck_roll_deg": Criterion("roll of the ship within the episode", "deg", "peak_deck_roll_deg", of_the_sea=True),
    "deck_pitch_deg": Criterion("pitch of the ship within the episode", "deg", "peak_deck_pitch_deg", of_the_sea=True),
    "significant_roll_deg": Criterion(
        "significant roll amplitude of the ship", "deg", "sea_roll_deg", factor=2.0, of_the_sea=True
    ),
    "significant_pitch_deg": Criterion(
        "significant pitch amplitude of the ship", "deg", "sea_pitch_deg", factor=2.0, of_the_sea=True
    ),
    "significant_vertical_velocity_m_s": Criterion(
        "significant vertical velocity of the deck", "m/s", "sea_vertical_velocity_m_s", factor=2.0, of_the_sea=True
    ),
}
_ALWAYS: Final[Mapping[str, str]] = {
    LOST: "the probe or the helicopter was lost, or the corridor left",
    GOAL: "the goal was not reached in time",
}


def label_of(name: str) -> str:
    """A limit in words."""
    return CRITERIA[name].label if name in CRITERIA else _ALWAYS[name]


def judged(rows: pl.DataFrame, limits: Mapping[str, float], *, must_arrive: bool) -> pl.DataFrame:
    """The rows with what was exceeded in each.

    Args:
        rows: Episodes.
        limits: Figures by name of `CRITERIA`, each in its own unit.
        must_arrive: Whether an episode that has not reached the goal counts as exceeding (`GOAL`).

    Returns:
        `rows` with, for each limit, ``over_NAME`` (bool) and ``use_NAME`` (peak over limit); ``over_lost`` and, with
        `must_arrive`, ``over_goal``; ``exceeded``, whether any is; and ``worst_use``, the largest of the uses that a
        policy can change.
    """
    lost = pl.col("failed")
    over = {name: CRITERIA[name].exceeded(figure) for name, figure in limits.items()} | {LOST: lost}
    if must_arrive:
        over[GOAL] = ~pl.col("success") & ~lost
    found = rows.with_columns(
        *(flag.alias(f"over_{name}") for name, flag in over.items()),
        *(CRITERIA[name].use(figure).alias(f"use_{name}") for name, figure in limits.items()),
    )
    uses = [f"use_{name}" for name in limits if not CRITERIA[name].of_the_sea] or [f"use_{name}" for name in limits]
    return found.with_columns(
        pl.any_horizontal(*(f"over_{name}" for name in over)).alias("exceeded"),
        (pl.max_horizontal(*uses) if uses else pl.lit(0.0)).alias("worst_use"),
    )


def columns_read(limits: Mapping[str, float]) -> list[str]:
    """The columns of an episode's row that `judged` reads."""
    return sorted({"failed", "success", *(CRITERIA[name].column for name in limits)})


def names_of(limits: Mapping[str, float], *, must_arrive: bool) -> list[str]:
    """Everything that is judged, `LOST` and `GOAL` included."""
    return [*limits, LOST, *([GOAL] if must_arrive else [])]
