"""Manoeuvres 1A to 1D: spatial dynamics (section 3.2.1), a nose-wheel helicopter with locked wheels and steering.

The thesis compares its simulation with another one (Dynaface); the curves of neither are published as data, so that
what is left to compare with are sentences, the printed limits of the axes, and Table 3.1.
"""

from __future__ import annotations

from typing import Final

from ssmash_gym.analysis.validation import spatial_statements as say
from ssmash_gym.analysis.validation.figures import Figure, Panel, panel
from ssmash_gym.analysis.validation.manoeuvres import Manoeuvre
from ssmash_gym.analysis.validation.measures import inside_axes
from ssmash_gym.analysis.validation.statements import Statement

HEIGHT: Final = "Helicopter centre of gravity z position"
OLEOS: Final = "Oleo strut extensions"


def oleos(number: str, seconds: tuple[float, float], step: float, limits: tuple[float, float]) -> Figure:
    """The figure of the three oleo extensions, in the order of the thesis."""
    rows = (("right", "Right Main Gear"), ("nose", "Nose Gear"), ("left", "Left Main Gear"))
    panels = [panel(f"{name}_extension_m", "oleo extension [m]", limits, 0.1, title) for name, title in rows]
    return Figure(number, OLEOS, tuple(panels), seconds, step)


def angle(name: str, limits: tuple[float, float], step: float) -> tuple[str, tuple[Panel, ...]]:
    """Title and panel of a figure of one angle to the inertial frame."""
    return f"Helicopter {name} angle", (panel(f"{name}_N_deg", f"{name} angle [deg]", limits, step),)


def axes(figures: tuple[Figure, ...], chosen: str, **notes: str) -> tuple[Statement, ...]:
    """That the curves stay within the printed axes; notes by the first quantity of a figure."""
    return tuple(inside_axes(figure, chosen, notes.get(figure.panels[0].curves[0].quantity, "")) for figure in figures)


A: Final = (
    Figure("3.1", HEIGHT, (panel("z_N_m", "position [m]", (-2.7, -2.0), 0.1),), (0.0, 5.0), 0.5),
    oleos("3.2", (0.0, 5.0), 0.5, (0.5, 1.1)),
    Figure("3.3", *angle("pitch", (0.0, 0.9), 0.1), (0.0, 5.0), 0.5),
)
B: Final = (
    Figure("3.4", HEIGHT, (panel("z_N_m", "position [m]", (-3.0, -2.1), 0.1),), (0.0, 6.0), 1.0),
    oleos("3.5", (0.0, 5.0), 0.5, (0.5, 1.1)),
    Figure("3.6", *angle("roll", (-2.0, 12.0), 2.0), (0.0, 6.0), 1.0),
    Figure("3.7", *angle("pitch", (-0.6, 0.8), 0.2), (0.0, 6.0), 1.0),
)
C: Final = (
    Figure("3.8", *angle("roll", (-8.0, 8.0), 2.0), (0.0, 15.0), 5.0),
    oleos("3.9", (0.0, 15.0), 5.0, (0.6, 1.0)),
    Figure("3.10", *angle("pitch", (0.32, 0.46), 0.02), (0.0, 15.0), 5.0),
)
D: Final = (
    Figure("3.11", *angle("roll", (-40.0, 30.0), 10.0), (0.0, 30.0), 5.0),
    Figure("3.12", *angle("yaw", (-8.0, 10.0), 2.0), (0.0, 30.0), 5.0),
    Figure("3.13", *angle("pitch", (-2.5, 2.5), 0.5), (0.0, 30.0), 5.0),
    oleos("3.14", (0.0, 30.0), 5.0, (0.6, 1.1)),
)
SPATIAL: Final = (
    Manoeuvre(
        "1A",
        "Flat drop",
        A,
        (say.CLEARANCE, say.SETTLES, say.FOUR_PEAKS, say.SMALL_PITCH, say.SYMMETRY, *axes(A, say.FITTED)),
    ),
    Manoeuvre(
        "1B",
        "Inclined drop",
        B,
        (say.MORE_DYNAMIC, say.LEANS, say.NOSE_DOWN, say.SMALL_PITCH_1B,
         *axes(B, say.FITTED, z_N_m=say.HIGHER)),
    ),
    Manoeuvre(
        "1C",
        "Sinusoidal ship roll",
        C,
        (say.FROM_REST, say.AMPLITUDE, say.QUASI_STATIC, say.SMALL_COUPLING, *axes(C, say.FITTED)),
    ),
    Manoeuvre(
        "1D",
        "General ship motion",
        D,
        (say.SIX, say.FROM_REST, say.SEVERE, say.AS_SEVERE, say.YAW_RANGE, say.FULL_EXTENSION, say.LIFT_OFF,
         say.PROBE_HOLDS, *axes(D, say.RECORD)),
        loads=("auxiliary_vertical_load", "right_vertical_load", "left_vertical_load", "probe_in_plane"),
    ),
)  # fmt: skip
