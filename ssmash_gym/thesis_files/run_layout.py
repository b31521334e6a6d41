"""The input files of a run: INITIALS, SOLUTION, PRESCRIBED, RSD POS and SHIPMO (Léveillé 2013, appendix A)."""

from __future__ import annotations

from typing import Final

from ssmash_gym.ship.shipmo import COLUMNS, FEWEST_ROWS
from ssmash_gym.thesis_files.heli_layout import HELI
from ssmash_gym.thesis_files.layout import (
    STATIONS,
    Column,
    InputFile,
    Line,
    Table,
    euler_parameters,
    per_station,
    vector,
)

METHODS: Final = {1: "adams", 2: "gear", 3: "automatic"}
DOFS: Final = {0: "off", 1: "roll", 2: "pitch", 3: "yaw", 4: "surge", 5: "sway", 6: "heave"}
FROM_FILE: Final = 1

INITIALS: Final = (
    Line(1, "helicopter's c.g. from the ship frame's origin, ship axes", vector("start.position_m", "m")),
    Line(2, "helicopter's orientation relative to the ship", euler_parameters("start.orientation")),
    Line(3, "distance from oleo frame to wheel carriage along o_z", per_station("start.strut_m", "m")),
    *(
        Line(
            4 + i,
            f"orientation of the {name} oleo or swing arm relative to the helicopter",
            euler_parameters(f"start.strut_orientations.{i}"),
        )
        for i, name in enumerate(STATIONS)
    ),
    Line(7, "helicopter's velocity relative to the ship, ship axes", vector("start.velocity_mps", "m/s")),
    Line(
        8,
        "helicopter's angular velocity relative to the ship, helicopter axes",
        vector("start.angular_velocity_radps", "rad/s"),
    ),
    Line(
        9,
        "speed of the wheel carriage along o_z, or rate of the swing arm about o_y",
        per_station("start.strut_rates", "m/s or rad/s"),
    ),
    Line(10, "rate of the wheel carriage about o_z", per_station("start.steer_rates_radps", "rad/s")),
)

SOLUTION: Final = (
    Line(
        1,
        "time span of the solution",
        (Column("start", "s", "solution.start_s", least=0.0), Column("end", "s", "solution.end_s", least=0.0)),
    ),
    Line(
        2, "time step between calls to the integrator: between rows", (Column("step", "s", "solution.output_step_s"),)
    ),
    Line(3, "rows of the solution kept in memory before they are printed", (Column("rows", whole=True, least=1.0),)),
    Line(
        4,
        "integration status",
        (Column("status", choices={1: "past the time of the row, interpolated", -1: "up to the time of the row"}),),
    ),
    Line(5, "number of equations whose roots are wanted", (Column("roots", choices={0: "none"}),)),
    Line(6, "integration method", (Column("method", "", "solution.solver", METHODS),)),
    Line(7, "relative accuracy of all components", (Column("accuracy", "", "solution.rtol"),)),
    Line(8, "smallest physically meaningful value of a component", (Column("value", "", "solution.atol"),)),
)

PRESCRIBED: Final = (
    Line(1, "where the claw's position comes from", (Column("claw", choices={1: "from file", 2: "constant"}),)),
    Line(2, "constant position of the claw, ship axes", vector("claw", "m"), "line 1 is 2"),
    Line(3, "where the ship's motion comes from", (Column("ship", choices={1: "from file", 2: "specified here"}),)),
    Line(4, "degree of freedom of the sinusoidal ship motion", (Column("motion", choices=DOFS),), "line 3 is 2"),
    Line(
        5,
        "amplitude and period of the sinusoidal ship motion",
        (Column("amplitude", "deg or m"), Column("period", "s")),
        "line 4 is not 0",
    ),
    Line(
        6,
        "ship's orientation, about which the sinusoid moves: roll, pitch, yaw",
        tuple(Column(name, "deg") for name in "xyz"),
        "line 3 is 2",
    ),
)

CLAW: Final = Table(
    (
        Column("time", "s", meaning="time"),
        *(Column(name, "m", meaning=f"claw's position, ship axes, {name}") for name in "xyz"),
    ),
    fewest_rows=2,
)
DECK: Final = Table(
    tuple(
        Column(name, unit.rstrip("]"), meaning=words)
        for (name, text) in COLUMNS
        for words, _, unit in [text.partition(" [")]
    ),
    fewest_rows=FEWEST_ROWS,
    named=True,
)

FILES: Final = {
    key: InputFile(name, names, content, meaning)
    for key, name, names, content, meaning in (
        ("heli", "heli.inp", ("heli.inp",), HELI, "the helicopter"),
        ("initials", "initials.inp", ("initials.inp",), INITIALS, "where it starts"),
        ("solution", "solution.inp", ("solution.inp",), SOLUTION, "time span, output, integrator"),
        ("prescribed", "prescribed.inp", ("prescribed.inp",), PRESCRIBED, "motion of ship and claw"),
        (
            "claw",
            "rsd_pos.inp",
            ("rsd_pos.inp", "rsdmo.inp", "rsd pos.inp", "rsdpos.inp"),
            CLAW,
            "motion of the claw, read if line 1 of prescribed.inp is 1",
        ),
        ("deck", "shipmo.inp", ("shipmo.inp",), DECK, "motion of the deck, read if line 3 of prescribed.inp is 1"),
    )
}
