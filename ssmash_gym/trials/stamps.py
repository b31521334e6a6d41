"""What is known of one control step besides its physics: who commanded it, by what message, and when."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

NOBODY: Final = "none"  # nobody holds the claw: the command is 0
PERSON: Final = "person"
NO_MESSAGE: Final = -1


@dataclass(frozen=True)
class Stamp:
    """One control step as the server saw it. All times but `input_ms` are seconds since the episode's start.

    Attributes:
        driver: ``person``, ``scripted operator``, a policy's name, or ``none``: nobody holds the claw, command 0.
        device: ``keyboard``, ``gamepad``, ``stick``; empty where there is none.
        sequence: Number of the message that was used; -1 where none was.
        input_ms: The page's own clock at that message [ms]; nan where there is none.
        received_s: When it arrived at the server [s]; nan where there is none.
        planned_s: When the step was due [s].
        taken_s: When the input was read [s].
        late: Whether that was later than is allowed.
        shown_step: Newest step that the driver's page says it has drawn; -1 where it is not known.
    """

    driver: str = NOBODY
    device: str = ""
    sequence: int = NO_MESSAGE
    input_ms: float = math.nan
    received_s: float = math.nan
    planned_s: float = math.nan
    taken_s: float = math.nan
    late: bool = False
    shown_step: int = -1


def timing_of(stamps: Sequence[Stamp], interval_s: float, allowed_late_share: float) -> dict[str, Any]:
    """What the stamps of a trial say of its timing.

    Latency is `waited_ms`; messages that were overtaken by a newer one before a step have none.

    Args:
        stamps: One a control step.
        interval_s: Control interval [s].
        allowed_late_share: Share of late steps up to which the trial is valid.

    Returns:
        ``interval_s``, ``steps``, ``lost_steps`` (control intervals that fell into stalls), ``late_steps`` (with the
        lost ones), ``late_share`` (of all that were due), ``allowed_late_share``, ``valid``, and
        ``latency_ms`` with ``p50``, ``p95``, ``max`` (None without messages) and ``messages``.
    """
    lost = _lost_steps(stamps, interval_s)
    late = sum(stamp.late for stamp in stamps) + lost
    share = late / max(len(stamps) + lost, 1)
    return {
        "interval_s": interval_s,
        "steps": len(stamps),
        "late_steps": late,
        "lost_steps": lost,
        "late_share": share,
        "allowed_late_share": allowed_late_share,
        "valid": share <= allowed_late_share,
        "latency_ms": _latency(stamps),
    }


def _lost_steps(stamps: Sequence[Stamp], interval_s: float) -> int:
    """Control intervals by which time has slipped: after a stall the plan goes on later than it would have."""
    gaps = [after.planned_s - before.planned_s for before, after in itertools.pairwise(stamps)]
    return sum(int(gap / interval_s - 1.0 + 1e-6) for gap in gaps if gap > interval_s)


def waited_ms(stamp: Stamp, before: Stamp | None) -> float | None:
    """Time from a message's arrival to the control step that used it first [ms].

    Args:
        stamp: Of the step.
        before: Of the step before it; None for the first one.

    Returns:
        None where the step used no new message: one that was there already, such as a key held down since before the
        start or while a policy drove, has not been waiting for the server.
    """
    if stamp.sequence == NO_MESSAGE or before is None or not stamp.received_s > before.taken_s:
        return None
    return 1e3 * (stamp.taken_s - stamp.received_s)


def _latency(stamps: Sequence[Stamp]) -> dict[str, Any]:
    """Percentiles of the time from a message's arrival to its first use [ms]."""
    found = [waited_ms(stamp, before) for before, stamp in itertools.pairwise(stamps)]
    known = [wait for wait in found if wait is not None]
    figures: dict[str, Any] = {"p50": None, "p95": None, "max": None, "messages": len(known)}
    if known:
        p50, p95 = np.percentile(known, [50.0, 95.0])
        figures |= {"p50": float(p50), "p95": float(p95), "max": max(known)}
    return figures
