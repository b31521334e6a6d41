"""Files of a response table: CSV with named columns, or npz with the same names as arrays.

A file holds amplitude and phase of each degree of freedom over a complete grid of ship speed, wave heading and wave
frequency. What its headings, axes and phases mean is not in the file: `response_table.ResponseTable` is told.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.files import whole_file
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.sources import DOFS

GRID: Final = ("speed_kn", "heading_deg", "omega_rad_s")
PER_DEGREE: Final = "_deg_per_m"
AMPLITUDES: Final = {
    **{f"{dof}_m_per_m": (k, 1.0) for k, dof in enumerate(DOFS) if k < 3},
    **{f"{dof}{PER_DEGREE}": (k, float(np.radians(1.0))) for k, dof in enumerate(DOFS) if k >= 3},
    **{f"{dof}_rad_per_m": (k, 1.0) for k, dof in enumerate(DOFS) if k >= 3},
}  # column: degree of freedom, factor to SI
PHASES: Final = {f"{dof}_phase_deg": k for k, dof in enumerate(DOFS)}
HEADINGS_DEG: Final = (-180.0, 360.0)
FASTEST_KN: Final = 60.0  # no displacement ship comes near; a speed above is in another unit
FEWEST: Final = 2  # frequencies


@dataclass(frozen=True, eq=False)
class ResponseGrid:
    """What a file says, in SI units but in the file's own conventions.

    Attributes:
        name: The file, for messages.
        speed_kn: Ship speeds [kn], (s,), ascending.
        heading_deg: Wave headings [deg], (h,), ascending, as they stand in the file.
        omega: Wave frequencies [rad/s], (w,), ascending.
        amplitude: Motion per metre of wave amplitude [m/m, rad/m], (s, h, w, 6); zero where the file has no column.
        phase: Phases [rad], (s, h, w, 6).
    """

    name: str
    speed_kn: FloatArray
    heading_deg: FloatArray
    omega: FloatArray
    amplitude: FloatArray
    phase: FloatArray


def read_grid(path: str | Path) -> ResponseGrid:
    """Read a response table's file; ``.npz`` by its arrays, any other as CSV.

    Args:
        path: The file.

    Raises:
        ConfigurationError: Missing, empty or unreadable; unknown or missing columns; a value that is no number or out
            of range (named by line and column); frequencies that do not rise; a grid that is not complete.
    """
    file = Path(path)
    try:
        empty = file.stat().st_size == 0
    except OSError as error:
        raise ConfigurationError(f"response table {file}: cannot be read ({error.strerror or error})") from error
    if empty:
        raise ConfigurationError(f"response table {file}: it is empty, expected are columns {', '.join(GRID)} and more")
    if file.suffix.lower() == ".npz":
        return _of_arrays(file)
    return _of_rows(file)


# --- columns -------------------------------------------------------------------------------------------------------


def _check_names(file: Path, kind: str, names: list[str]) -> None:
    """Every name known and given once, the grid complete, amplitude and phase in pairs, some motion at all."""
    known = [*GRID, *AMPLITUDES, *PHASES]
    for name in names:
        if name not in known:
            raise ConfigurationError(
                f"response table {file}: {kind} {shown(name)} is not known, allowed are {', '.join(known)}"
            )
        if names.count(name) > 1:
            raise ConfigurationError(f"response table {file}: {kind} {name} stands there twice, allowed is once")
    for name in GRID:
        if name not in names:
            raise ConfigurationError(f"response table {file}: {kind} {name} is missing")
    moving = [AMPLITUDES[name][0] for name in names if name in AMPLITUDES]
    if not moving:
        raise ConfigurationError(
            f"response table {file}: no {kind} holds a motion, allowed are one or more of {', '.join(AMPLITUDES)}"
        )
    for k, dof in enumerate(DOFS):
        if moving.count(k) > 1:
            raise ConfigurationError(f"response table {file}: {dof} stands there in two units, allowed is one")
        if (moving.count(k) == 1) != (f"{dof}_phase_deg" in names):
            raise ConfigurationError(
                f"response table {file}: {dof} has only one of amplitude and phase, needed are both"
            )


def _column_checks(name: str) -> tuple[float, float, str]:
    """Lowest and highest value of a column, and both in words."""
    if name == "speed_kn":
        return 0.0, FASTEST_KN, f"0 to {FASTEST_KN:g} kn"
    if name == "heading_deg":
        return *HEADINGS_DEG, f"{HEADINGS_DEG[0]:g} to {HEADINGS_DEG[1]:g} degrees"
    if name == "omega_rad_s":
        return float(np.nextafter(0.0, 1.0)), np.inf, "wave frequencies above 0 rad/s"
    if name in AMPLITUDES:
        return 0.0, np.inf, "amplitudes of 0 or more (a sign belongs to the phase)"
    return -np.inf, np.inf, "finite numbers"


# --- CSV -----------------------------------------------------------------------------------------------------------


def _of_rows(file: Path) -> ResponseGrid:
    """Grid of a CSV file: one row for each speed, heading and frequency."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"response table {file}: cannot be read as text ({error})") from error
    content = [
        (number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line.strip()[0] != "#"
    ]
    if not content:
        raise ConfigurationError(f"response table {file}: it has no line of column names")
    records = [[field.strip(' "\t') for field in line.split(",")] for _, line in content]
    names, rows = records[0], records[1:]
    lines = [number for number, _ in content[1:]]
    if len(names) == 1 and any(mark in names[0] for mark in "; \t"):
        raise ConfigurationError(
            f"response table {file}: no comma in the line of column names, {shown(names[0], 40)}; commas expected "
            "between columns, and a point in decimals"
        )
    _check_names(file, "column", names)
    if not rows:
        raise ConfigurationError(f"response table {file}: it has column names and no rows")
    values = np.array([_row(file, line, names, row) for line, row in zip(lines, rows, strict=True)])
    for k, name in enumerate(names):
        low, high, allowed = _column_checks(name)
        wrong = np.flatnonzero(~((values[:, k] >= low) & (values[:, k] <= high)))
        if len(wrong):
            raise ConfigurationError(
                f"response table {file}, line {lines[wrong[0]]}, column {name}: {values[wrong[0], k]:g} is refused, "
                f"allowed are {allowed}"
            )
    return _gridded(file, dict(zip(names, values.T, strict=True)), lines)


def _row(file: Path, line: int, names: list[str], row: list[str]) -> list[float]:
    if len(row) != len(names):
        raise ConfigurationError(
            f"response table {file}, line {line}: {len(row)} columns found, expected are {len(names)} as in the first "
            "line (commas expected between columns, and a point in decimals)"
        )
    values = []
    for name, field in zip(names, row, strict=True):
        try:
            value = float(field)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise ConfigurationError(
                f"response table {file}, line {line}, column {name}: expected a finite number, found {shown(field, 24)}"
            )
        values.append(value)
    return values


def _gridded(file: Path, column: Mapping[str, FloatArray], lines: list[int]) -> ResponseGrid:
    """Rows to arrays over the grid; every frequency must stand once, in rising order, at every heading and speed."""
    speed, heading, omega = (column[name] for name in GRID)
    places: dict[tuple[float, float], list[int]] = {}
    for row, key in enumerate(zip(speed.tolist(), heading.tolist(), strict=True)):
        block = places.setdefault(key, [])
        if block and omega[row] <= omega[block[-1]]:
            what = "stands there twice" if omega[row] in omega[block] else "comes after a higher one"
            raise ConfigurationError(
                f"response table {file}, line {lines[row]}: omega_rad_s = {omega[row]:g} {what} at "
                f"speed_kn = {key[0]:g}, heading_deg = {key[1]:g}, allowed are rising frequencies"
            )
        block.append(row)
    speeds, headings, omegas = np.unique(speed), np.unique(heading), np.unique(omega)
    _check_count(file, omegas)
    order = np.empty((len(speeds), len(headings), len(omegas)), dtype=np.int64)
    for i, u in enumerate(speeds.tolist()):
        for j, beta in enumerate(headings.tolist()):
            block = places.get((u, beta), [])
            absent = np.setdiff1d(omegas, omega[block])
            if len(absent):
                raise ConfigurationError(
                    f"response table {file}: a gap, there is no row for speed_kn = {u:g}, heading_deg = {beta:g}, "
                    f"omega_rad_s = {absent[0]:g}; needed is every frequency at every heading and speed"
                )
            order[i, j] = block
    arrays = {name: values[order] for name, values in column.items() if name not in GRID}
    return _grid(file, speeds, headings, omegas, arrays)


# --- npz -----------------------------------------------------------------------------------------------------------


def _of_arrays(file: Path) -> ResponseGrid:
    """Grid of an npz file: 1-D arrays of the grid, and arrays (speeds, headings, frequencies) of the rest."""
    try:
        with np.load(file, allow_pickle=False) as data:
            found = {name: np.asarray(data[name]) for name in data.files}
    except (OSError, ValueError, EOFError, KeyError, AttributeError, zipfile.BadZipFile) as error:
        raise ConfigurationError(f"response table {file}: cannot be read as npz ({error})") from error
    _check_names(file, "array", list(found))
    arrays = {name: _checked_array(file, name, values) for name, values in found.items()}
    for name in GRID:
        values = arrays[name]
        if values.ndim != 1 or len(values) == 0:
            raise ConfigurationError(
                f"response table {file}: array {name} has shape {values.shape}, allowed is one dimension of 1 or more"
            )
        steps = np.diff(values)
        if not (steps > 0.0).all():
            where = int(np.argmax(steps <= 0.0)) + 1
            raise ConfigurationError(
                f"response table {file}: array {name} has {values[where]:g} after {values[where - 1]:g}, allowed are "
                "rising values"
            )
    speeds, headings, omegas = (arrays.pop(name) for name in GRID)
    _check_count(file, omegas)
    shape = (len(speeds), len(headings), len(omegas))
    for name, values in arrays.items():
        if values.shape != shape:
            raise ConfigurationError(
                f"response table {file}: array {name} has shape {values.shape}, allowed is {shape}, speeds by headings "
                "by frequencies"
            )
    return _grid(file, speeds, headings, omegas, arrays)


def _checked_array(file: Path, name: str, values: np.ndarray[Any, Any]) -> FloatArray:
    if values.dtype.kind not in "fiu":
        raise ConfigurationError(f"response table {file}: array {name} holds {values.dtype}, allowed are numbers")
    numbers = values.astype(np.float64)
    low, high, allowed = _column_checks(name)
    wrong = ~(np.isfinite(numbers) & (numbers >= low) & (numbers <= high))
    if wrong.any():
        where = tuple(int(k) for k in np.argwhere(wrong)[0])
        raise ConfigurationError(
            f"response table {file}: array {name}{list(where)}: {numbers[where]:g} is refused, allowed are {allowed}"
        )
    return numbers


# --- both ----------------------------------------------------------------------------------------------------------


def _check_count(file: Path, omegas: FloatArray) -> None:
    if len(omegas) < FEWEST:
        raise ConfigurationError(
            f"response table {file}: omega_rad_s has {len(omegas)} value, allowed are {FEWEST} frequencies or more"
        )


def _grid(
    file: Path, speeds: FloatArray, headings: FloatArray, omegas: FloatArray, arrays: Mapping[str, FloatArray]
) -> ResponseGrid:
    shape = (len(speeds), len(headings), len(omegas), 6)
    amplitude, phase = np.zeros(shape), np.zeros(shape)
    for name, values in arrays.items():
        if name in AMPLITUDES:
            dof, factor = AMPLITUDES[name]
            amplitude[..., dof] = factor * values
        else:
            phase[..., PHASES[name]] = np.radians(values)
    return ResponseGrid(str(file), speeds, headings, omegas, amplitude, phase)


def write_grid(path: str | Path, grid: ResponseGrid, comments: tuple[str, ...] = ()) -> Path:
    """Write a response table's file, whole or not at all: npz by the name's ending, CSV otherwise.

    Args:
        path: The file; an existing one is replaced.
        grid: What to write; angles go out in degrees.
        comments: Lines for the head of a CSV file.

    Raises:
        ConfigurationError: The file cannot be written.
    """
    file = Path(path)
    columns: dict[str, FloatArray] = {}
    for name, (k, factor) in AMPLITUDES.items():
        if not name.endswith("_rad_per_m"):
            columns[name] = grid.amplitude[..., k] / factor
            columns[f"{DOFS[k]}_phase_deg"] = np.degrees(grid.phase[..., k])
    try:
        with whole_file(file) as temporary:
            if file.suffix.lower() == ".npz":
                with temporary.open("wb") as stream:
                    axes = dict(zip(GRID, (grid.speed_kn, grid.heading_deg, grid.omega), strict=True))
                    arrays: dict[str, Any] = {**axes, **columns}
                    np.savez_compressed(stream, **arrays)
            else:
                temporary.write_text(_csv_text(grid, columns, comments), encoding="utf-8")
    except OSError as error:
        raise ConfigurationError(f"response table {file}: cannot be written ({error.strerror or error})") from error
    return file


def _csv_text(grid: ResponseGrid, columns: Mapping[str, FloatArray], comments: tuple[str, ...]) -> str:
    axes = np.meshgrid(grid.speed_kn, grid.heading_deg, grid.omega, indexing="ij")
    table = np.stack([array.reshape(-1) for array in (*axes, *columns.values())], axis=1)
    lines = [*(f"# {comment}" for comment in comments), ",".join([*GRID, *columns])]
    lines += [",".join([*(f"{v:.12g}" for v in row[:3]), *(f"{v:.8g}" for v in row[3:])]) for row in table.tolist()]
    return "\n".join(lines) + "\n"
