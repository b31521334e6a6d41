"""The output files: RUN.OUT, STATE.OUT and AUX.OUT (Léveillé 2013, appendix A)."""

from __future__ import annotations

from typing import Final

from ssmash_gym.dynamics.layout import State
from ssmash_gym.thesis_files.layout import STATIONS, Column, Line

RUN: Final = (
    Line(1, "run time of the simulation", (Column("run time", "s"),)),
    Line(2, "iterations of the main loop completed: steps from row to row", (Column("iterations", whole=True),)),
    Line(
        3,
        "times that the solution was printed to file: blocks of the rows that line 3 of solution.inp keeps in memory",
        (Column("prints", whole=True),),
    ),
)


def _state_columns() -> tuple[Column, ...]:
    """Columns 2 to 35: the path is the name of the row of the state."""
    axes = "xyz"
    columns = [
        Column(f"u{7 + k}", "m/s", f"U{7 + k}", meaning=f"helicopter's velocity over the ship, ship axes, {axes[k]}")
        for k in range(3)
    ]
    columns += [
        Column(f"u{10 + k}", "rad/s", f"U{10 + k}", meaning=f"helicopter's {name} rate, helicopter axes")
        for k, name in enumerate(("roll", "pitch", "yaw"))
    ]
    for i, name in enumerate(STATIONS):
        along, about = 13 + 2 * i, 14 + 2 * i
        slide = f"{name} wheel carriage's speed along o_z, or swing arm's rate about o_y"
        columns.append(Column(f"u{along}", "m/s or rad/s", f"U{along}", meaning=slide))
        columns.append(Column(f"u{about}", "rad/s", f"U{about}", meaning=f"{name} wheel carriage's rate about o_z"))
    columns += [
        Column(f"q{8 + k}", "m", f"Q{8 + k}", meaning=f"helicopter's position, ship axes, {axes[k]}") for k in range(3)
    ]
    columns += [
        Column(f"q{11 + k}", "", f"Q{11 + k}", meaning=f"helicopter's orientation relative to the ship, e{k}")
        for k in range(4)
    ]
    for i, name in enumerate(STATIONS):
        first = 15 + 5 * i
        columns.append(
            Column(f"q{first}", "m", f"Q{first}", meaning=f"{name} wheel carriage from its oleo frame along o_z")
        )
        columns += [
            Column(
                f"q{first + 1 + k}",
                "",
                f"Q{first + 1}+{k}",
                meaning=f"{name} oleo frame's orientation relative to the helicopter, e{k}",
            )
            for k in range(4)
        ]
    return tuple(columns)


def state_row(column: Column) -> int:
    """Row of the kernel's state that a column of STATE.OUT shows."""
    name, _, offset = column.path.partition("+")
    return int(State[name]) + int(offset or 0)


TIME: Final = Column("time", "s", meaning="time")
STATE: Final = (TIME, *_state_columns())
AUX: Final = (
    TIME,
    *(
        Column(f"F_P{axis}", "N", f"probe_f{axis}", meaning=f"securing probe's force, helicopter axes, {axis}")
        for axis in "xyz"
    ),
    *(
        Column(f"delta_y {name}", "m", f"{name}_tire_lateral_deflection", meaning=f"{name} tire's lateral deflection")
        for name in STATIONS
    ),
    *(Column(f"F_z {name}", "N", f"{name}_vertical_load", meaning=f"{name} tire's vertical load") for name in STATIONS),
)
