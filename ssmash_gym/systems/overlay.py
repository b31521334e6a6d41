"""A system laid over a case: what is left of the case, and whether that is still an answer to it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ssmash_gym.cases import Case, case_document, case_from, prepared
from ssmash_gym.cases.claw import ClawPoints, StillClaw, claw_nodes, longest_node_s
from ssmash_gym.cases.description import SPEEDS
from ssmash_gym.cases.start import Settled
from ssmash_gym.dynamics.layout import State
from ssmash_gym.errors import ConfigurationError, SolverError
from ssmash_gym.ship.sources import Fixed
from ssmash_gym.systems.description import System
from ssmash_gym.systems.models import scaled_case, why_not_scaled
from ssmash_gym.systems.plane import level_axes
from ssmash_gym.systems.rigid_suspension import suspension_in_tires
from ssmash_gym.systems.scaling import ratio
from ssmash_gym.vehicle import Helicopter, document_of, with_changes


def apply(system: System, case: Case) -> Case:
    """The case as the system would run it.

    Args:
        system: The system.
        case: The case, left as it is.

    Raises:
        ConfigurationError: The system cannot do this case; one sentence, that of `why_not`.
    """
    refused = _says_nothing(system, case)
    if refused is not None:
        raise ConfigurationError(refused)
    try:
        return _overlaid(system, case)
    except ConfigurationError as error:
        raise ConfigurationError(cannot(system, case, error)) from None


def cannot(system: System, case: Case, error: ConfigurationError | SolverError) -> str:
    """One sentence on a case that a system cannot do, of what was raised over it."""
    told = " ".join(str(error).split()).rstrip(".")
    told = told.removeprefix(f"{_beginning(system, case)} ").removeprefix(f"{_source(system, case)}: ")
    scale = ratio(system.scale, ":")
    told = told.replace(f"case {case.name} scaled {scale}: ", f"scaled {scale}, ", 1)
    return f"{_beginning(system, case)} {told}."


def _beginning(system: System, case: Case) -> str:
    return f"{system.name} cannot do case {case.name}:"


def _source(system: System, case: Case) -> str:
    return f"case {case.name} as {system.name}"


def _overlaid(system: System, case: Case) -> Case:
    """The case with the settings of the system."""
    document = case_document(case)
    changes: dict[str, Any] = dict(system.changes)
    if system.probe == "off":
        changes["probe.active"] = False
    helicopter = derived(system, case)
    if helicopter != case.vehicle:  # what is derived holds for the helicopter with the case's own changes
        document["helicopter"], document["changes"] = document_of(helicopter), {}
    kept = {key: value for key, value in document["changes"].items() if key not in changes}
    document["changes"] = {**kept, **changes}  # applied in this order
    document["held"] = [name for name in SPEEDS if name in (*case.held, *system.held)]
    document["model"] = {**document["model"], **system.model}
    if system.deck == "level":
        document |= {"deck": {"type": "fixed"}, "ramp_s": 0.0}
    if system.claw == "still":
        document["claw"] = stilled(case)
    applied = case_from(document, _source(system, case))
    return scaled_case(applied, system.scale) if system.scale != 1.0 else applied


def derived(system: System, case: Case) -> Helicopter:
    """The case's helicopter with what the system derives from it: levelled axes, the suspension put into its tires."""
    helicopter = case.vehicle
    if system.axes == "level":
        steer_deg = case.start.steer_deg if isinstance(case.start, Settled) else 0.0
        helicopter = with_changes(helicopter, level_axes(helicopter, steer_deg))
    if system.suspension == "in_tires":
        helicopter = with_changes(helicopter, suspension_in_tires(helicopter))
    return helicopter


def stilled(case: Case) -> dict[str, Any]:
    """A claw that stays where that of the case is when the run starts, as a section of a case.

    Raises:
        ConfigurationError: The claw's file cannot be read.
    """
    claw, solution = case.claw, case.solution
    if isinstance(claw, StillClaw):
        return claw.model_dump(mode="json")
    spacing = solution.longest_node_s or longest_node_s(claw)
    end_s = max(solution.end_s, solution.start_s)
    x, y, z = claw_nodes(claw, np.zeros(2), solution.start_s, end_s, spacing, case.seed)[0, :3].tolist()
    if isinstance(claw, ClawPoints) and claw.relative_to == "probe":
        if x == y == 0.0:  # at the probe, wherever the system has it
            return {"type": "still", "z_m": z}
        x, y = x + _probe_at_start(case)[0], y + _probe_at_start(case)[1]
    return {"type": "still", "x_m": x, "y_m": y, "z_m": z}


def _probe_at_start(case: Case) -> tuple[float, float]:
    """Probe point at the start of a case, x and y, S axes [m]."""
    if isinstance(case.start, Settled):
        return case.start.x_m, case.start.y_m
    x, y = prepared(case.changed({"claw": {"type": "still"}})).state[State.CLAW_X : State.CLAW_Y + 1, 0]
    return float(x), float(y)


def drivers(case: Case) -> dict[str, str]:
    """What keeps a case from being a helicopter at rest, in words by kind: deck, claw, start, wind."""
    found = {}
    if not isinstance(case.deck, Fixed):
        found["deck"] = "the deck moves"
    elif case.deck.roll_deg != 0.0 or case.deck.pitch_deg != 0.0:
        found["deck"] = "the deck is inclined"
    if not isinstance(case.claw, StillClaw):
        found["claw"] = "the claw moves"
    if case.start.type != "settled":
        found["start"] = "the helicopter drops" if case.start.type == "drop" else "the helicopter starts off its rest"
    helicopter = case.vehicle
    if any(helicopter.aerodynamics.wind_N_mps) and any(helicopter.aerodynamics.drag_areas_m2):
        found["wind"] = "the wind blows"
    return found


def left_out(system: System, case: Case) -> dict[str, str]:
    """What the system leaves out of a case's drivers, in words by kind; see `drivers`."""
    found = drivers(case)
    words = {}
    if system.deck == "level" and "deck" in found:
        words["deck"] = "deck levelled"
    if "claw" in found and system.claw == "still":
        words["claw"] = "claw held still"
    elif "claw" in found and system.probe == "off":
        words["claw"] = "no probe for the claw to move"
    if "wind" in found and not _feels_wind(system, case):
        words["wind"] = "no wind"
    return words


def why_not(system: System, case: Case) -> str | None:
    """Why the system cannot do a case, in one sentence; None if it can.

    It cannot where a start is asked for that its held speeds rule out; where it leaves out everything that moves the
    helicopter, since what it would draw would be a straight line that says nothing about the case; and where the case
    with its settings is refused.
    """
    try:
        apply(system, case)
    except ConfigurationError as error:
        return str(error)
    return None


def _says_nothing(system: System, case: Case) -> str | None:
    """Why a run of the case by the system would say nothing about the case, in one sentence; None if it would."""
    if case.start.type not in system.starts:
        return (
            f"{_beginning(system, case)} start.type = {case.start.type} is none that it can take "
            f"({', '.join(system.starts)})."
        )
    found, out = drivers(case), left_out(system, case)
    if found and set(found) == set(out):
        return (
            f"{_beginning(system, case)} {' and '.join(found.values())}, and with "
            f"{' and '.join(out.values())} nothing of it is left."
        )
    refused = why_not_scaled(case) if system.scale != 1.0 else None
    return refused and f"{_beginning(system, case)} {refused}."


def label(system: System, case: Case) -> str:
    """What a curve of the system is called: its name, and what it leaves out of the case."""
    words = list(left_out(system, case).values())
    if system.probe == "off" and case.vehicle.probe.active:
        words.append("not secured")
    if system.scale != 1.0:
        words.append(f"{ratio(system.scale, ':')}, scaled back")
    return f"{system.name} ({', '.join(words)})" if words else system.name


def _feels_wind(system: System, case: Case) -> bool:
    """Whether the system's changes leave the helicopter a wind and an area for it."""
    aerodynamic = {key: value for key, value in system.changes.items() if key.startswith("aerodynamics.")}
    aerodynamics = with_changes(case.vehicle, aerodynamic).aerodynamics
    return any(aerodynamics.wind_N_mps) and any(aerodynamics.drag_areas_m2)
