"""A case at model scale, and what a model does told at full scale (Froude scaling)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.cases import Case, History, case_document, case_from
from ssmash_gym.cases.claw import ClawFile, longest_node_s, read_claw_file
from ssmash_gym.dynamics.channels import Out, StaOut
from ssmash_gym.dynamics.layout import (
    STATE_ROWS,
    STATION_COORDINATES,
    STATIONS,
    TIRE_STATES,
    TIRES,
    State,
)
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.motion import MotionTable
from ssmash_gym.simulation.timing import NODE_SPACING_S
from ssmash_gym.systems.scaling import PURE, check_scale, exponent, ratio, scaled, scaled_node
from ssmash_gym.vehicle import Helicopter, document_of

Array = NDArray[np.float64]
BEYOND: Final = (
    8  # points that a claw's record is prolonged by; what its end does wears off by 0.27 from each to the next
)
BEYOND_S: Final = 0.05  # longest time between them
LONGEST_SUBSTEP_S: Final = 0.005  # that the engine takes
# Numbers of a case without a unit.
_PURE: Final = PURE | {"components", "strut_orientations", "friction_factor", "strut_rates"}  # the last: `_strut_rates`
_SCALED: Final = ("start", "deck", "claw", "patch", "probe_turn")  # sections whose keys carry their units
_BY_FORMULA: Final = ("fixed", "sinusoid", "irregular")  # decks whose numbers say all


def why_not_scaled(case: Case) -> str | None:
    """Why a case cannot be run at another scale, as the end of a sentence; None if it can."""
    if case.deck.type in _BY_FORMULA:
        return None
    return (
        f"deck.type = {case.deck.type!r} takes its motion from a ship or a record of full size, and decks that can be "
        f"scaled are {', '.join(_BY_FORMULA)}"
    )


def scaled_case(case: Case, scale: float) -> Case:
    """A case at another length scale: helicopter, deck, claw, start, times and steps.

    A claw that follows a file becomes the spline through the file's scaled points. The tolerances of the adaptive
    solvers stay, the absolute one times the scale. The nodes of deck and claw lie at corresponding times.

    Args:
        case: The case, left as it is.
        scale: Length of the model over that of the original.

    Raises:
        ConfigurationError: The scale makes no sense, or the deck's motion cannot be scaled.
    """
    scale = check_scale(scale)
    refused = why_not_scaled(case)
    if refused is not None:
        raise ConfigurationError(f"case {case.name} cannot be run at another scale: {refused}.")
    if scale == 1.0:
        return case
    document = case_document(case.model_copy(update={"provenance": ()}))
    document |= {key: scaled_node(document[key], scale, pure=_PURE) for key in _SCALED if key != "claw"}
    if case.start.type == "state":
        document["start"]["strut_rates"] = _strut_rates(case, scale)
    document["claw"] = _claw(case, document["claw"], scale)
    document["solution"] = _solution(case, scale)
    document["ramp_s"] = case.ramp_s * math.sqrt(scale)
    document["helicopter"], document["changes"] = document_of(scaled(case.vehicle, scale)), {}
    document["name"] = f"{case.name}_{ratio(scale)}"
    document["title"] = f"{case.title or case.name}, {ratio(scale, ':')}"
    return case_from(document, f"case {case.name} scaled {ratio(scale, ':')}")


def _claw(case: Case, section: dict[str, Any], scale: float) -> dict[str, Any]:
    if not isinstance(case.claw, ClawFile):
        return dict(scaled_node(section, scale, pure=_PURE))
    record = read_claw_file(case.claw.path)
    if np.ptp(record[:, 3]) > 0.0:
        raise ConfigurationError(
            f"case {case.name} cannot be run at another scale: the claw file {case.claw.path} moves the claw plane "
            "(z), which points of a case cannot."
        )
    record = _prolonged(record, case.solution.start_s, case.solution.end_s)
    points = {
        "type": "points",
        "time_s": record[:, 0].tolist(),
        "x_m": record[:, 1].tolist(),
        "y_m": record[:, 2].tolist(),
        "z_m": float(record[0, 3]),
        "relative_to": "ship",
        "interpolation": "spline",
        "noise": section["noise"],
    }
    return dict(scaled_node(points, scale, pure=_PURE))


def _prolonged(record: Array, start_s: float, end_s: float) -> Array:
    """A claw's record (n, 4) with points beyond both ends of a run that lies within it.

    A claw that goes through points halts at the first and the last, one that follows a record does so only where the
    run begins before it or ends after it. The points beyond lie on the record's own spline, and never come to be.
    """
    from scipy.interpolate import CubicSpline

    time = record[:, 0]
    halts = start_s < time[0], end_s > time[-1]
    kind = "not-a-knot" if time.size > 3 else "natural"
    ends: Any = [(1, np.zeros(3)) if halt else kind for halt in halts]
    curve = CubicSpline(time, record[:, 1:], bc_type=ends)
    count = np.arange(1, BEYOND + 1)
    before = time[0] - min(time[1] - time[0], BEYOND_S) * count[::-1] if not halts[0] else np.empty(0)
    after = time[-1] + min(time[-1] - time[-2], BEYOND_S) * count if not halts[1] else np.empty(0)
    found = [np.column_stack([t, curve(t)]) for t in (before, after)]
    return np.concatenate([found[0], record, found[1]])


def _solution(case: Case, scale: float) -> dict[str, Any]:
    """Times by the root of the scale; rows and, where the engine can take them, substeps correspond one to one."""
    given = case.solution
    root = math.sqrt(scale)
    step = given.output_step_s * root
    count = max(round(given.output_step_s / given.substep_s), math.ceil(step / LONGEST_SUBSTEP_S - 1e-9))
    return {
        **given.model_dump(mode="json"),
        "start_s": given.start_s * root,
        "end_s": given.end_s * root,
        "output_step_s": step,
        "substep_s": step / count,
        "longest_node_s": min((given.longest_node_s or longest_node_s(case.claw)) * root, NODE_SPACING_S),
        "atol": given.atol * min(scale, 1.0),
    }


def _strut_rates(case: Case, scale: float) -> list[float]:
    """Rates of slides [m/s] and of arms [rad/s]."""
    assert case.start.type == "state"
    stations = case.vehicle.station_tuple
    powers = [0.5 if station.kind == "prismatic" else -0.5 for station in stations]
    return [rate * scale**power for rate, power in zip(case.start.strut_rates, powers, strict=True)]


# --- back to full scale ---------------------------------------------------------------------------------------


def at_full_scale(history: History, case: Case, scale: float) -> History:
    """What a model did, told in the numbers of the original.

    Args:
        history: Of the model.
        case: The original case: the history is said to be its.
        scale: Length scale of the model.
    """
    outputs = scale ** -output_exponents()[:, None]
    states = scale ** -state_exponents(case.vehicle)[:, None]
    root = math.sqrt(scale)
    lengths = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    nodes = np.concatenate([scale ** -(lengths - 0.5 * order) for order in range(3)])
    return replace(
        history,
        case=case,
        deck=MotionTable(history.deck.spacing_s / root, history.deck.nodes * nodes),
        time_s=history.time_s / root,
        states=history.states * states,
        outputs=history.outputs * outputs,
        highs=history.highs * outputs,
        lows=history.lows * outputs,
    )


def output_exponents() -> Array:
    """Exponent of the length scale for every output row, from the units of the channels, (OUTPUT_ROWS,)."""
    stations = [_printed(channel.unit) for channel in StaOut]
    return np.array([*(_printed(channel.unit) for channel in Out), *stations * STATIONS])


def state_exponents(helicopter: Helicopter) -> Array:
    """Exponent of the length scale for every state row, (STATE_ROWS,); Euler parameters and flags stay."""
    powers = np.zeros(STATE_ROWS)
    powers[State.U7 : State.U9 + 1] = 0.5
    powers[State.U10 : State.U18 + 1] = -0.5
    for i, station in enumerate(helicopter.station_tuple):
        powers[State.U13 + 2 * i] = 0.5 if station.kind == "prismatic" else -0.5
        powers[State.Q15 + STATION_COORDINATES * i] = 1.0
    powers[State.Q8 : State.Q10 + 1] = 1.0
    for k in range(TIRES):
        powers[State.TIRE + TIRE_STATES * k : State.TIRE + TIRE_STATES * k + 2] = 1.0
    powers[State.CLAW_X : State.CLAW_Y + 1] = 1.0
    powers[State.CLAW_VX : State.CLAW_VY + 1] = 0.5
    return powers


def _printed(unit: str) -> float:
    """Exponent of a channel's unit as it is printed: ``m/s2``, ``N m``, ``1``."""
    if unit == "1":
        return 0.0
    return exponent("channel_" + unit.replace(" ", "").replace("/", "p"))
