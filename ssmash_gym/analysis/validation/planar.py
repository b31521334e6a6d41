"""Manoeuvres 2A to 2C: planar handling (section 3.2.2), a tail-wheel helicopter moved by the claw on a level deck.

The thesis compares its simulation with a full-scale vehicle (DLTV) that represents the S-70B. Neither the vehicle's
data nor any record is published: vehicle and claw are rebuilt, see the case files. What is left to compare with are
sentences and the printed limits of the axes.
"""

from __future__ import annotations

from typing import Final

from ssmash_gym.analysis.validation import planar_statements as say
from ssmash_gym.analysis.validation.figures import Curve, Figure, Panel, panel
from ssmash_gym.analysis.validation.manoeuvres import Manoeuvre
from ssmash_gym.analysis.validation.measures import inside_axes, span
from ssmash_gym.analysis.validation.statements import Runs, Statement

Range = tuple[float, float]
RESPONSES: Final = ("force", "angle", "deflection")
LOADS: Final = (
    "auxiliary_vertical_load", "right_vertical_load", "left_vertical_load", "probe_in_plane",
    "right_lateral_load", "left_lateral_load",
)  # fmt: skip


def claw(number: str, limits: Range, step: float, seconds: Range, every: float) -> Figure:
    """The figure of the claw's position."""
    curves = (Curve("claw_x_m", "x-position"), Curve("claw_y_m", "y-position"))
    return Figure(number, "RSD claw position", (Panel(curves, "position [m]", limits, step),), seconds, every)


def force(number: str, axis: str, limits: Range, step: float, seconds: Range, every: float) -> Figure:
    """A figure of the securing probe's force."""
    shown = panel(f"probe_{axis}_kN", "force [kN]", limits, step)
    return Figure(number, f"Securing probe {axis}-force", (shown,), seconds, every)


def deflections(number: str, limits: Range, step: float, seconds: Range, every: float) -> Figure:
    """The figure of the main tires' lateral deflections."""
    panels = tuple(
        panel(f"{side}_tire_deflection_mm", "deflection [mm]", limits, step, f"{side.title()} Main Tire")
        for side in ("right", "left")
    )
    return Figure(number, "Main landing gear tire lateral deflection", panels, seconds, every)


def loads(number: str, limits: Range, seconds: Range, every: float) -> Figure:
    """The figure of the main tires' vertical loads."""
    curves = (Curve("right_load_kN", "Right"), Curve("left_load_kN", "Left"))
    shown = Panel(curves, "vertical load [kN]", limits, 5.0)
    return Figure(number, "Main landing gear tire vertical load", (shown,), seconds, every)


def angle(number: str, name: str, limits: Range, step: float, seconds: Range, every: float) -> Figure:
    """A figure of one angle."""
    title = {"yaw": "Helicopter yaw angle", "steer": "Tail wheel steer angle"}[name]
    return Figure(number, title, (panel(f"{name}_deg", f"{name} angle [deg]", limits, step),), seconds, every)


def axes(figures: tuple[Figure, ...], chosen: str) -> tuple[Statement, ...]:
    """That the curves stay within the printed axes."""
    return tuple(inside_axes(figure, chosen) for figure in figures)


def reaches(figure: Figure) -> Statement:
    """The statement that the curves of a figure reach the first and the last interval of its printed axis.

    The thesis chose the axis for its own curves and those of the trials, so that some curve there does.
    """
    shown = figure.panels[0]
    names = [one.quantity for panel in figure.panels for one in panel.curves]
    low, high = shown.limits[0] + shown.step, shown.limits[1] - shown.step
    unit = shown.label.partition("[")[2].rstrip("]")

    def measure(runs: Runs) -> dict[str, float]:
        spans = [span(runs.default, name, *figure.seconds) for name in names]
        return {"least": min(least for least, _ in spans), "greatest": max(greatest for _, greatest in spans)}

    return Statement(
        thesis=f"{figure.title} as large as its printed axis suggests: beyond {low:g} and {high:g} {unit}",
        source=f"figure {figure.number}",
        measure=measure,
        words="{least:.3g} to {greatest:.3g} " + unit,
        holds=lambda n: n["least"] <= low and n["greatest"] >= high,
        basis="axis",
        chosen=say.REBUILT,
    )


def responses(figures: tuple[Figure, ...]) -> tuple[Statement, ...]:
    """That the probe forces, angles and deflections use their printed axes."""
    return tuple(reaches(figure) for figure in figures if any(word in figure.title for word in RESPONSES))


T_A: Final = ((0.0, 40.0), 5.0)
T_B: Final = ((0.0, 90.0), 10.0)
T_C: Final = ((0.0, 80.0), 10.0)
A: Final = (
    claw("3.16", (-0.1, 0.7), 0.1, *T_A),
    force("3.17", "x", (-6.0, 12.0), 2.0, *T_A),
    force("3.18", "y", (-25.0, 10.0), 5.0, *T_A),
    angle("3.19", "yaw", (8.8, 10.0), 0.2, *T_A),
    deflections("3.20", (-10.0, 30.0), 10.0, *T_A),
    loads("3.21", (25.0, 35.0), *T_A),
)
B: Final = (
    claw("3.22", (0.0, 4.5), 0.5, *T_B),
    force("3.23", "x", (-4.0, 8.0), 2.0, *T_B),
    force("3.24", "y", (-16.0, 2.0), 2.0, *T_B),
    angle("3.25", "yaw", (0.0, 90.0), 10.0, *T_B),
    angle("3.26", "steer", (-100.0, 20.0), 20.0, *T_B),
    deflections("3.27", (-10.0, 20.0), 10.0, *T_B),
    loads("3.28", (25.0, 35.0), *T_B),
)
C: Final = (
    claw("3.29", (-0.2, 0.6), 0.1, *T_C),
    force("3.30", "x", (-20.0, 15.0), 5.0, *T_C),
    force("3.31", "y", (-40.0, 30.0), 10.0, *T_C),
    deflections("3.32", (-20.0, 40.0), 20.0, (-10.0, 80.0), 10.0),
    angle("3.33", "yaw", (10.0, 28.0), 2.0, *T_C),
    angle("3.34", "steer", (-180.0, 0.0), 20.0, *T_C),
    loads("3.35", (20.0, 40.0), *T_C),
)
PLANAR: Final = (
    Manoeuvre(
        "2A",
        "Traversing while yawed",
        A,
        (say.BACK_TO_START, say.YAW_MAINTAINED, say.FX_RISES, say.ONE_HERTZ, say.FX_FLUCTUATES, say.FY_GROWS,
         say.FY_RELEASED, say.DEFLECTION_STEADY, say.OUT_OF_PLANE, *axes(A, say.REBUILT), *responses(A)),
        loads=LOADS,
    ),
    Manoeuvre(
        "2B",
        "Helicopter yaw to 90 degrees",
        B,
        (say.YAW_REACHED, say.TAIL_FOLLOWS, say.FX_OSCILLATES, say.FX_POSITIVE, say.CLAW_PULLS, say.TIRES_ALIKE,
         say.OUT_OF_PLANE, say.TWIST_MATTERS_LITTLE, *axes(B, say.REBUILT), *responses(B)),
        loads=LOADS,
    ),
    Manoeuvre(
        "2C",
        "Tail steer to 180 degrees",
        C,
        (say.TAIL_FLIPS, say.PULL_FORWARD, say.YAW_RATE, say.DLTV_RELAXES, say.OUT_OF_PLANE, say.THESIS_HOLDS_ON,
         say.THESIS_RELAXES, say.TWIST_RELAXES, say.TAIL_STAYS, *axes(C, say.REBUILT), *responses(C)),
        loads=LOADS,
    ),
)  # fmt: skip
