"""INITIALS, SOLUTION and PRESCRIBED: their numbers to the sections of a case, and back."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

from ssmash_gym.fields import UNIT_NORM_TOLERANCE
from ssmash_gym.thesis_files.layout import Line
from ssmash_gym.thesis_files.paths import get, put, with_lists
from ssmash_gym.thesis_files.reading import Row, Rows
from ssmash_gym.thesis_files.run_layout import DOFS, FROM_FILE, INITIALS, METHODS, SOLUTION

ROWS_IN_MEMORY: Final = 100.0  # line 3 of SOLUTION.INP where a case comes from elsewhere
STILL: Final = (0.0, 1.0)  # amplitude and period where no sinusoid moves the deck
ROUNDED: Final = 1.0e-3  # by which the norm of Euler parameters may be off 1 as printed; they are normalised then
WHOLE: Final = 1.0e-6  # share of a step by which a time span may be off whole steps
ANGLES: Final = ("roll_deg", "pitch_deg", "yaw_deg")


def start(initials: Rows) -> dict[str, Any]:
    """The section ``start`` of a case."""
    rows = [normalised(row) if len(row) == 4 else row for row in initials]
    return {"type": "state", **_by_paths(INITIALS, rows)["start"]}


def normalised(parameters: Row) -> Row:
    """Euler parameters that are rounded a little too much, normalised; others as they are, to be refused or not."""
    if not rounded(parameters):
        return parameters
    norm = math.hypot(*parameters)
    return tuple(number / norm for number in parameters)


def rounded(parameters: Row) -> bool:
    """Whether the norm of Euler parameters is off 1 by rounding, and by more than is taken as it is."""
    return UNIT_NORM_TOLERANCE < abs(math.hypot(*parameters) - 1.0) <= ROUNDED


def solution(rows: Rows) -> dict[str, Any]:
    """The section ``solution`` of a case.

    Lines 4 to 8 are arguments of the solver the thesis uses (Kahaner, Moler and Nash, SDRIV2): an error is allowed
    of line 7 times the value of a component, or times line 8 where the value is smaller. SciPy's solvers add an
    absolute tolerance instead, which therefore is the product of the two.
    """
    made: dict[str, Any] = _by_paths(SOLUTION, rows)["solution"]
    return {**made, "end_s": last_row(rows), "atol": made["rtol"] * made["atol"]}


def last_row(rows: Rows) -> float:
    """Time of the last row [s]: the end of line 1, or the last whole step of line 2 before it."""
    (begin, end), (step,) = rows[0], rows[1]
    steps = (end - begin) / step if step > 0.0 else 0.0
    odd = abs(steps - round(steps)) > WHOLE * max(steps, 1.0)
    return begin + math.floor(steps) * step if odd and steps > 1.0 else end


def claw(prescribed: Rows, file: str) -> dict[str, Any]:
    """The section ``claw`` of a case; `file` is the record, which is read if line 1 says so."""
    if prescribed[0][0] == FROM_FILE:
        return {"type": "file", "path": file}
    x, y, z = prescribed[1]
    return {"type": "still", "x_m": x, "y_m": y, "z_m": z}


def deck(prescribed: Rows, file: str) -> dict[str, Any]:
    """The section ``deck`` of a case; `file` is the record, which is read if line 3 says so."""
    if prescribed[2][0] == FROM_FILE:
        return {"type": "file", "path": file}
    angles = dict(zip(ANGLES, prescribed[5], strict=True))
    dof = DOFS[int(prescribed[3][0])]
    if dof == "off":
        return {"type": "fixed", **angles}
    amplitude, period = prescribed[4]
    key, other = (
        ("amplitude_deg", "amplitude_m") if dof in ("roll", "pitch", "yaw") else ("amplitude_m", "amplitude_deg")
    )
    return {"type": "sinusoid", "dof": dof, key: amplitude, other: None, "period_s": period, **angles}


def _by_paths(lines: Sequence[Line], rows: Sequence[Row]) -> dict[str, Any]:
    """Values of all columns that have a path."""
    tree: dict[str, Any] = {}
    for line, numbers in zip(lines, rows, strict=True):
        for column, number in zip(line.columns, numbers, strict=True):
            if column.path:
                put(tree, column.path, column.value(number))
    made: dict[str, Any] = with_lists(tree)
    return made


def initials_rows(document: Mapping[str, Any]) -> Rows:
    """Lines of INITIALS.INP of a case that starts in a given state."""
    return tuple(tuple(column.number(get(document, column.path)) for column in line.columns) for line in INITIALS)


def solution_rows(section: Mapping[str, Any]) -> Rows:
    """Lines of SOLUTION.INP; `section` has a method that the file knows."""
    number = {method: float(n) for n, method in METHODS.items()}[section["solver"]]
    span = (float(section["start_s"]), float(section["end_s"]))
    smallest = _factor(section["rtol"], section["atol"])
    step, accuracy = (float(section["output_step_s"]),), (float(section["rtol"]),)
    return span, step, (ROWS_IN_MEMORY,), (1.0,), (0.0,), (number,), accuracy, (smallest,)


def _factor(rtol: float, atol: float) -> float:
    """The number that gives `atol` when multiplied by `rtol`, exactly where there is one."""
    guess = atol / rtol
    near = (guess, math.nextafter(guess, math.inf), math.nextafter(guess, 0.0))
    return next((number for number in near if number * rtol == atol), guess)


def prescribed_rows(claw_section: Mapping[str, Any], deck_section: Mapping[str, Any]) -> Rows:
    """Lines of PRESCRIBED.INP; the sections are of types that the file knows."""
    from_file = claw_section["type"] == "file"
    point: Row = (0.0, 0.0, 0.0) if from_file else tuple(float(claw_section[key]) for key in ("x_m", "y_m", "z_m"))
    claw_lines: Rows = ((1.0 if from_file else 2.0,), point)
    if deck_section["type"] == "file":
        return (*claw_lines, (1.0,), (0.0,), STILL, (0.0, 0.0, 0.0))
    angles = tuple(float(deck_section[key]) for key in ANGLES)
    if deck_section["type"] == "fixed":
        return (*claw_lines, (2.0,), (0.0,), STILL, angles)
    dof = next(number for number, name in DOFS.items() if name == deck_section["dof"])
    amplitude = next(a for a in (deck_section["amplitude_deg"], deck_section["amplitude_m"]) if a is not None)
    moved = (float(amplitude), float(deck_section["period_s"]))
    return (*claw_lines, (2.0,), (float(dof),), moved, angles)
