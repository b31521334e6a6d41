"""A ship's response from a table of response amplitudes and phases: a user's own data behind the ship's interface.

The file's format is in `response_file`; what headings, axes and phases of the file mean is said when it is read:
`ResponseFile` names the choices (the guide "Your own data" explains them in one table). Everything is
turned into the package's conventions on reading, `response.Response`, before anything is interpolated.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from itertools import product
from pathlib import Path
from typing import Final, Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt
from pydantic import Field, ValidationInfo, field_validator

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning, shown
from ssmash_gym.fields import Part
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.response import TO_PACKAGE, ComplexArray, Response, ShipResponse
from ssmash_gym.ship.response_file import GRID, HEADINGS_DEG, ResponseGrid, read_grid, write_grid
from ssmash_gym.ship.response_input import checked_waves
from ssmash_gym.ship.sea import KNOT, encounter
from ssmash_gym.ship.waves import Waves

Axes = Literal["z_down_starboard", "z_up_port"]
Phase = Literal["lead", "lag"]
Heading = Literal["towards_starboard", "towards_port", "from_starboard", "from_port"]
WIDEST_DEG: Final = 45.0  # between neighbouring headings: a cosine is then interpolated within 1 %
FADE: Final = 4  # power of frequency with which the response falls off above the table (assumed)
UNCOVERED: Final = 0.10  # share of a sea's energy outside the table's frequencies from which a warning is due
MIRROR: Final = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])  # what a ship mirrored at its centre plane does
COMMENTS: Final = (
    "motion of the centre of gravity per metre of wave amplitude; phases lead the wave crest at the centre of gravity",
    "convention: z_down_starboard, phase: lead, heading: towards_starboard",
)


class ResponseFile(Part):
    """Section of a ship's file that names a response table and its conventions."""

    table: Path = Field(description="CSV or npz file; a relative path is taken from the ship's file")
    convention: Axes = Field("z_down_starboard", description="axes of the motions: x forward, z down or z up")
    phase: Phase = Field("lead", description="phases lead or lag the wave crest at the centre of gravity")
    heading: Heading = Field("towards_starboard", description="what a heading of 90 degrees means")
    symmetric: bool = Field(False, description="the table has one side; the other is its mirror image")

    @field_validator("table")
    @classmethod
    def _from_folder(cls, path: Path, info: ValidationInfo) -> Path:
        folder = (info.context or {}).get("folder")
        return path if folder is None else Path(folder) / path  # an absolute path stays as it is

    def read(self) -> ResponseTable:
        """The table.

        Raises:
            ConfigurationError: See `ResponseTable.read`.
        """
        return ResponseTable.read(
            self.table, convention=self.convention, phase=self.phase, heading=self.heading, symmetric=self.symmetric
        )


class ResponseTable:
    """Response by interpolation in a table: cubic on complex values in heading and frequency, linear in speed.

    Between two speeds the amplitude is linear in speed and the phase is that of the complex blend.

    Below the table's frequencies the end value is held; above them it falls off with the fourth power of frequency
    (both assumed; a warning says so where a tenth of a sea's energy or more lies outside). Speeds outside the table
    are refused.

    Attributes:
        name: The file, for messages.
        speed_kn: Ship speeds [kn], (s,), ascending.
        heading_deg: Directions the waves travel relative to the ship's heading [deg] in [0, 360), (h,), ascending.
        omega: Wave frequencies [rad/s], (w,), ascending.
        transfer: Transfer functions of `Response` at the nodes, (s, h, w, 6) [m/m, rad/m].

    Args:
        grid: A file's content.
        convention: Axes of the motions, see `ResponseFile`.
        phase: Whether phases lead or lag the wave crest at the centre of gravity.
        heading: What a heading of 90 degrees means.
        symmetric: Headings are on one side only; the other side is the mirror image.

    Raises:
        ConfigurationError: Unknown conventions, or headings that do not go round.
    """

    def __init__(
        self,
        grid: ResponseGrid,
        *,
        convention: Axes = "z_down_starboard",
        phase: Phase = "lead",
        heading: Heading = "towards_starboard",
        symmetric: bool = False,
    ) -> None:
        given = {"convention": convention, "phase": phase, "heading": heading}
        for (key, value), kind in zip(given.items(), (Axes, Phase, Heading), strict=True):
            if value not in get_args(kind):
                raise ConfigurationError(
                    f"response table {grid.name}: {key} is {value!r}, allowed are {', '.join(get_args(kind))}"
                )
        self.name = grid.name
        self.speed_kn, self.omega = grid.speed_kn, grid.omega
        travel = travel_deg(grid.heading_deg, heading)
        omega_e = encounter(
            self.omega, np.radians(travel)[:, np.newaxis], KNOT * self.speed_kn[:, np.newaxis, np.newaxis]
        )
        transfer = grid.amplitude * np.exp(1j * _turn(phase, omega_e)[..., np.newaxis] * grid.phase)
        if convention == "z_up_port":
            transfer = transfer * TO_PACKAGE
        self.heading_deg, self.transfer = _all_round(grid.name, travel, transfer, symmetric)
        self._nodes = _with_slopes(self.heading_deg, self.omega, self.transfer)

    @classmethod
    def read(
        cls,
        path: str | Path,
        *,
        convention: Axes = "z_down_starboard",
        phase: Phase = "lead",
        heading: Heading = "towards_starboard",
        symmetric: bool = False,
    ) -> ResponseTable:
        """Read a table from CSV or npz, see `response_file.read_grid`; arguments as of the class.

        Raises:
            ConfigurationError: A file that is missing, empty or malformed (named by line and column), or headings
                that do not go round.
        """
        grid = read_grid(path)
        return cls(grid, convention=convention, phase=phase, heading=heading, symmetric=symmetric)

    def respond(
        self,
        omega: FloatArray,
        heading: FloatArray,
        amplitude: FloatArray,
        speed_mps: float,
        *,
        roll_damping_factor: float = 1.0,
        gm_factor: float = 1.0,
    ) -> Response:
        """Response of the centre of gravity to regular waves, see `ShipResponse.respond`.

        Raises:
            ConfigurationError: A speed outside the table, a factor other than 1, or a value that is not allowed.
        """
        omega, heading, amplitude = checked_waves(omega, heading, amplitude)
        for key, factor in (("roll_damping_factor", roll_damping_factor), ("gm_factor", gm_factor)):
            if factor != 1.0:
                raise ConfigurationError(
                    f"response table {self.name}: {key} is {factor!r}, allowed is 1: a table cannot be given another "
                    "roll damping or metacentric height"
                )
        first, share = self._speed(speed_mps)
        self._warn_outside(omega, amplitude)
        transfer = self._at(omega, heading, first)
        if share > 0.0:
            transfer = _between(transfer, self._at(omega, heading, first + 1), share)
        fall = np.maximum(omega / self.omega[-1], 1.0) ** -FADE
        return Response(
            omega_e=encounter(omega, heading, speed_mps),
            transfer=transfer * fall[:, np.newaxis],
            roll_damping=float("nan"),
            converged=True,
        )

    def _speed(self, speed_mps: float) -> tuple[int, float]:
        """Index of the table's speed at or below, and the share of the way to the next one."""
        speed, table = float(speed_mps) / KNOT, self.speed_kn
        if not table[0] - 1e-6 <= speed <= table[-1] + 1e-6:
            allowed = f"{table[0]:g}" if len(table) == 1 else f"{table[0]:g} to {table[-1]:g}"
            raise ConfigurationError(
                f"response table {self.name}: the speed is {speed:g} kn, allowed is {allowed} kn, what the table covers"
            )
        if len(table) == 1:
            return 0, 0.0
        first = int(np.clip(np.searchsorted(table, speed, side="right") - 1, 0, len(table) - 2))
        return first, float(np.clip((speed - table[first]) / (table[first + 1] - table[first]), 0.0, 1.0))

    def _at(self, omega: FloatArray, heading: FloatArray, speed: int) -> ComplexArray:
        """Transfer function (n, 6) at one of the table's speeds: cubic pieces in heading and frequency."""
        ring = np.append(self.heading_deg, self.heading_deg[0] + 360.0)
        beta = ring[0] + (np.degrees(heading) - ring[0]) % 360.0
        across = _hermite(ring, beta)
        along = _hermite(self.omega, np.clip(omega, self.omega[0], self.omega[-1]))
        transfer = np.zeros((len(omega), 6), dtype=np.complex128)
        nodes = self._nodes[:, :, speed]
        for (row, of_row), (column, of_column) in product(across, along):
            corner = nodes[:, :, row % len(self.heading_deg), column]
            for i, m in product(range(2), repeat=2):
                transfer += (of_row[i] * of_column[m])[:, np.newaxis] * corner[i, m]
        return transfer

    def _warn_outside(self, omega: FloatArray, amplitude: FloatArray) -> None:
        """Say so when much of a sea's energy is where the table has no values."""
        energy = amplitude * amplitude
        outside = (omega < self.omega[0]) | (omega > self.omega[-1])
        if outside.any() and float(np.sum(energy[outside])) > UNCOVERED * float(np.sum(energy)):
            warnings.warn(
                f"response table {self.name}: more than {UNCOVERED:.0%} of the sea's energy is outside the table's "
                f"frequencies, {self.omega[0]:g} to {self.omega[-1]:g} rad/s, where the response is assumed",
                ConfigurationWarning,
                stacklevel=3,
            )


class WithResponse(Protocol):
    """What a table can be written of: a ship."""

    @property
    def response(self) -> ShipResponse:
        """Response of its centre of gravity."""
        ...


def write_response_table(
    path: str | Path,
    ship: WithResponse,
    speeds_kn: Iterable[float],
    headings_deg: Iterable[float],
    omegas: Iterable[float],
    *,
    waves: Waves | None = None,
) -> Path:
    """Write a ship's response as a table that `ResponseTable.read` takes without further settings.

    A table is linear, and the roll of a hull is not: its damping grows with the roll rate. The table holds the
    response with the damping that goes with `waves`, or with that of very small rolling.

    Args:
        path: CSV file, or npz if its name ends so; an existing one is replaced.
        ship: What has a `response`.
        speeds_kn: Ship speeds [kn], rising.
        headings_deg: Directions the waves travel relative to the ship's heading [deg], rising: 0 following, 90
            towards starboard, 180 head.
        omegas: Wave frequencies [rad/s], rising.
        waves: The sea in which the roll damping is linearised, at each of the speeds.

    Returns:
        The path.

    Raises:
        ConfigurationError: Values that do not rise or are out of range, a speed that the ship's response does not
            have, or a file that cannot be written.
    """
    axes = []
    for name, values in zip(GRID, (speeds_kn, headings_deg, omegas), strict=True):
        axis = np.array(list(values), dtype=np.float64)
        if len(axis) == 0 or not np.isfinite(axis).all() or (np.diff(axis) <= 0.0).any():
            raise ConfigurationError(
                f"write_response_table: {name} is {shown(axis.tolist())}, allowed are rising numbers"
            )
        axes.append(axis)
    speed, heading, omega = axes
    if not (heading[0] >= HEADINGS_DEG[0] and heading[-1] <= HEADINGS_DEG[1]):
        raise ConfigurationError(
            f"write_response_table: heading_deg is {shown(heading.tolist())}, allowed are {HEADINGS_DEG[0]:g} to "
            f"{HEADINGS_DEG[1]:g} degrees"
        )
    shape = (len(heading), len(omega))
    beta, w = (array.reshape(-1) for array in np.meshgrid(np.radians(heading), omega, indexing="ij"))
    still = np.zeros(len(w))
    if waves is not None:  # the grid's waves have no height: they take the damping of those that have
        beta, w, still = (
            np.concatenate(pair) for pair in ((beta, waves.heading), (w, waves.omega), (still, waves.amplitude))
        )
    count = len(heading) * len(omega)
    responses = [ship.response.respond(w, beta, still, KNOT * u) for u in speed.tolist()]
    transfer = np.array([r.transfer[:count].reshape(*shape, 6) for r in responses])
    omega_e = np.array([r.omega_e[:count].reshape(shape) for r in responses])
    phase = _turn("lead", omega_e)[..., np.newaxis] * np.angle(transfer)
    grid = ResponseGrid(str(path), speed, heading, omega, np.abs(transfer), phase)
    return write_grid(path, grid, COMMENTS)


def travel_deg(heading_deg: FloatArray, heading: Heading) -> FloatArray:
    """Direction of travel [deg] in [0, 360), 90 towards starboard, from a file's headings [deg], any shape."""
    sign = 1.0 if heading in ("towards_starboard", "from_starboard") else -1.0
    turn = 180.0 if heading in ("from_starboard", "from_port") else 0.0
    return np.asarray(np.mod(np.round(sign * heading_deg + turn, 9), 360.0), dtype=np.float64)


def _turn(phase: Phase, omega_e: FloatArray) -> FloatArray:
    """Sign that takes a file's phase to the argument of the transfer function.

    A lead is a lead in time. Waves that the ship overtakes have a negative encounter frequency, and there a lead in
    time is a negative argument.
    """
    return np.where(omega_e >= 0.0, 1.0, -1.0) * (1.0 if phase == "lead" else -1.0)


def _all_round(
    name: str, travel: FloatArray, transfer: ComplexArray, symmetric: bool
) -> tuple[FloatArray, ComplexArray]:
    """Headings (h,) [deg] once round in rising order, with their values (s, h, w, 6); mirrored where asked for."""
    if symmetric:
        starboard, port = (travel <= 180.0), (travel >= 180.0) | (travel == 0.0)
        if not (starboard.all() or port.all()):
            raise ConfigurationError(
                f"response table {name}: symmetric is true and the table has headings on both sides of the ship, "
                "allowed are headings on one side"
            )
        side = (travel != 0.0) & (travel != 180.0)
        travel = np.concatenate([travel, 360.0 - travel[side]])
        transfer = np.concatenate([transfer, transfer[:, side] * MIRROR], axis=1)
    order = np.argsort(travel, kind="stable")
    travel, transfer = travel[order], transfer[:, order]
    gaps = np.diff(np.append(travel, travel[0] + 360.0))
    if gaps.min() <= 0.0:
        raise ConfigurationError(
            f"response table {name}: heading_deg has the same direction twice (a full turn apart), allowed is once"
        )
    if gaps.max() > WIDEST_DEG + 1e-6:
        hint = "" if symmetric else "; symmetric: true fills one side from the other"
        raise ConfigurationError(
            f"response table {name}: heading_deg leaves a gap of {gaps.max():g} degrees on the way round, allowed are "
            f"{WIDEST_DEG:g} at most{hint}"
        )
    return travel, transfer


def _between(first: ComplexArray, second: ComplexArray, share: float) -> ComplexArray:
    """Blend of the responses at two speeds, (n, 6): amplitudes blend, and the phase is that of the complex blend.

    A resonance moves to another wave frequency as the ship goes faster. Blended as complex numbers alone, the flanks
    of the two resonances partly cancel: up to a fifth of the roll is then missing half-way between 0 and 5 kn.
    """
    blend = (1.0 - share) * first + share * second
    amplitude, size = (1.0 - share) * np.abs(first) + share * np.abs(second), np.abs(blend)
    return np.asarray(blend * (amplitude / np.where(size > 0.0, size, 1.0)), dtype=np.complex128)


def _with_slopes(heading: FloatArray, omega: FloatArray, values: ComplexArray) -> ComplexArray:
    """Values and slopes (2, 2, s, h, w, 6): [i, m] is the i-th derivative in heading, the m-th in frequency.

    Slopes are those of the parabola through a node and its neighbours.
    """
    along = np.gradient(values, omega, axis=2, edge_order=2 if len(omega) > 2 else 1)
    ring = np.concatenate([[heading[-1] - 360.0], heading, [heading[0] + 360.0]])

    def across(array: ComplexArray) -> ComplexArray:
        around = np.concatenate([array[:, -1:], array, array[:, :1]], axis=1)
        return np.asarray(np.gradient(around, ring, axis=1)[:, 1:-1], dtype=np.complex128)

    return np.array([[values, along], [across(values), across(along)]])


def _hermite(
    nodes: FloatArray, x: FloatArray
) -> tuple[tuple[npt.NDArray[np.int64], tuple[FloatArray, FloatArray]], ...]:
    """The two nodes about each x, each with the weights of its value and of its slope, (n,)."""
    left = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    h = nodes[left + 1] - nodes[left]
    u = (x - nodes[left]) / h
    v = 1.0 - u
    return (
        (left, (v * v * (1.0 + 2.0 * u), h * u * v * v)),
        (left + 1, (u * u * (1.0 + 2.0 * v), -h * u * u * v)),
    )
