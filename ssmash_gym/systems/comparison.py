"""The same manoeuvre through all systems: histories, a figure, a table of peaks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from ssmash_gym.cases import Case, History, run_case
from ssmash_gym.errors import ConfigurationError, SolverError
from ssmash_gym.systems.description import FULL, System, load_system, system_names
from ssmash_gym.systems.models import at_full_scale
from ssmash_gym.systems.overlay import apply, cannot, label

Progress = Callable[[float], None]
OVERTURNED_DEG: Final = 60.0  # of roll or pitch on the deck: beyond, the body would lie on it, which no model here has
LEAST_SHARED: Final = 0.5  # kN or deg of the full model: below it, a ratio to it says nothing


@dataclass(frozen=True)
class Peak:
    """One column of the table.

    Attributes:
        name: Its heading, unit included.
        of: The value of a history.
        needs_probe: Whether it says something only of a secured helicopter.
    """

    name: str
    of: Callable[[History], float]
    needs_probe: bool = False


def _yaw_deg(history: History) -> float:
    """Largest turn from the initial heading."""
    yaw = np.unwrap(history["yaw"])
    return float(np.degrees(np.max(np.abs(yaw - yaw[0]))))


def _least_main(history: History) -> float:
    lows = [np.min(history.peak_min(f"{side}_vertical_load")) for side in ("right", "left")]
    return float(1e-3 * min(lows))


PEAKS: Final = (
    Peak("probe in-plane [kN]", lambda h: 1e-3 * h.largest("probe_in_plane"), True),
    Peak("right tires, most [kN]", lambda h: 1e-3 * float(np.max(h.peak_max("right_vertical_load")))),
    Peak("main tires, least [kN]", _least_main),
    Peak("roll on the deck [deg]", lambda h: float(np.degrees(h.largest("roll")))),
    Peak("turn in yaw [deg]", _yaw_deg),
)


@dataclass(frozen=True)
class Comparison:
    """A case through several systems.

    Attributes:
        case: The case.
        histories: Of those that can do it, by name, in the order asked for; a scaled one is told at full scale.
        labels: What their curves are called: the name and what the system leaves out.
        refusals: One sentence of each system that cannot do it, or not to its end, by name.
    """

    case: Case
    histories: Mapping[str, History]
    labels: Mapping[str, str]
    refusals: Mapping[str, str]

    def peaks(self) -> dict[str, dict[str, float]]:
        """Every system's peaks by name; nan where a quantity means nothing to the system."""
        return {
            name: {
                peak.name: peak.of(history) if secured(history) or not peak.needs_probe else float("nan")
                for peak in PEAKS
            }
            for name, history in self.histories.items()
        }


def secured(history: History) -> bool:
    """Whether a probe holds the helicopter of a history."""
    return history.case.vehicle.probe.active


def overturned(history: History) -> int | None:
    """Row at which the helicopter has fallen over; None if it stays on its wheels."""
    tilt = np.degrees(np.maximum(np.abs(history["roll"]), np.abs(history["pitch"])))
    rows = np.flatnonzero(tilt > OVERTURNED_DEG)
    return int(rows[0]) if rows.size else None


def until(history: History, row: int) -> History:
    """A history up to a row, that row included."""
    tables = ("states", "outputs", "highs", "lows")
    cut = {name: getattr(history, name)[:, : row + 1] for name in tables}
    return replace(history, time_s=history.time_s[: row + 1], **cut)


def cases_of(case: Case, names: Iterable[str] | None = None) -> dict[str, Case]:
    """The case by every system that can do it at full scale, by the label of its curve."""
    chosen = [load_system(name) for name in (system_names() if names is None else names)]
    _check_names(chosen)
    found = {}
    for system in chosen:
        if system.scale == 1.0:
            with suppress(ConfigurationError):
                found[label(system, case)] = apply(system, case)
    return found


def compare(case: Case, names: Iterable[str] | None = None, progress: Progress | None = None) -> Comparison:
    """Run a case through systems.

    Args:
        case: The case.
        names: Systems, or files of them; all by default. The full model comes first, asked for or not.
        progress: Called with the share done, 0 to 1.

    Raises:
        ConfigurationError: An unknown system, two different ones of one name, or the case itself is refused, by the
            full model too.
    """
    given = [load_system(name) for name in (FULL, *(system_names() if names is None else names))]
    _check_names(given)
    chosen = {system.name: system for system in given}
    histories, labels, refusals = {}, {}, {}
    for k, (name, system) in enumerate(chosen.items()):
        progressed = None if progress is None else _part(progress, k / len(chosen), 1.0 / len(chosen))
        try:
            history = run_case(apply(system, case), progressed)
        except (ConfigurationError, SolverError) as error:
            if name == FULL and isinstance(error, ConfigurationError):
                raise
            refusals[name] = cannot(system, case, error)
            continue
        histories[name], remark = told(system, case, history)
        labels[name] = label(system, case)
        if remark is not None:
            refusals[name] = remark
    return Comparison(case, histories, labels, refusals)


def _check_names(systems: Iterable[System]) -> None:
    """Refuse two different systems of one name.

    Raises:
        ConfigurationError: There are two.
    """
    known = {FULL: load_system(FULL)}
    for system in systems:
        if known.setdefault(system.name, system) != system:
            raise ConfigurationError(
                f"system {system.name}: name = {system.name!r} is refused: another system of the comparison has it; "
                "give the file another name, or a key name."
            )


def told(system: System, case: Case, history: History) -> tuple[History, str | None]:
    """What a system did with a case, in numbers of full scale and no further than it means something.

    Args:
        system: The system.
        case: The case, without the system.
        history: Of the case by the system, see `apply`.

    Returns:
        The history, and one sentence where it ends early: overturned, or diverged.
    """
    if system.scale != 1.0:
        full = system.model_copy(update={"scale": 1.0})
        history = at_full_scale(history, apply(full, case), system.scale)
    row = overturned(history)
    if row is not None:
        history = until(history, row)
        return history, f"{system.name} overturns at {history.time_s[-1]:.1f} s; nothing is shown beyond."
    return history, None if history.diverged is None else f"{system.name}: {history.diverged}."


def _part(progress: Progress, begun: float, share: float) -> Progress:
    """Progress of one run among several."""
    return lambda done: progress(begun + share * done)


def systems_table(case: Case | Comparison, names: Iterable[str] | None = None) -> str:
    """A table of peaks as Markdown: values, and in parentheses the difference to the full model.

    Args:
        case: A case, or what `compare` made of it.
        names: Systems, where a case is given; all by default.
    """
    done = case if isinstance(case, Comparison) else compare(case, names)
    peaks = done.peaks()
    full = peaks.get(FULL, {})
    head = ["system", *(peak.name for peak in PEAKS)]
    rows = [head, ["---", *("---:" for _ in PEAKS)]]
    for name, values in peaks.items():
        cells = [_cell(values[peak.name], full.get(peak.name, float("nan")), name == FULL) for peak in PEAKS]
        rows.append([done.labels[name], *cells])
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([*lines, *(f"\n{sentence}" for sentence in done.refusals.values())]) + "\n"


def _cell(value: float, full: float, is_full: bool) -> str:
    """One value, and how much more or less than in the full model it is."""
    if np.isnan(value):
        return "none"
    if is_full or np.isnan(full) or abs(full) < LEAST_SHARED:
        return f"{value:.2f}"
    return f"{value:.2f} ({100.0 * (value / full - 1.0):+.0f} %)"


def systems_figure(case: Case | Comparison, out_path: str | Path, names: Iterable[str] | None = None) -> None:
    """Draw the same manoeuvre through all systems into one PNG, whole or not at all (extra ``plot``).

    Args:
        case: A case, or what `compare` made of it.
        out_path: The picture.
        names: Systems, where a case is given; all by default.

    Raises:
        ImportError: Matplotlib is missing.
        ConfigurationError: An unknown system, or a file of the case cannot be read.
    """
    from ssmash_gym.errors import require
    from ssmash_gym.files import whole_file
    from ssmash_gym.systems.picture import NEEDS_MATPLOTLIB, draw_systems

    require("matplotlib", NEEDS_MATPLOTLIB)
    done = case if isinstance(case, Comparison) else compare(case, names)
    with whole_file(out_path) as temporary:
        draw_systems(temporary, done)
