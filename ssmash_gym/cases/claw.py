"""How the claw of a case moves: it stands, goes through given points, or follows a file (RSD POS.INP)."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final, Literal, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ssmash_gym.cases.section import CaseSection
from ssmash_gym.columns import number_in, read_text, rows_of
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.fields import NonNegative, Number, Positive
from ssmash_gym.sections import FilePath
from ssmash_gym.ship.motion import smootherstep
from ssmash_gym.simulation.timing import NODE_SPACING_S

Array = NDArray[np.float64]
LEAST_GAP_S: Final = 1.0e-3  # between two points of a claw's history
FARTHEST_M: Final = 1000.0  # a claw's place in any direction
NOISE_LINES: Final = 16  # sines that make up the noise of a claw position
FINE_NODE_S: Final = 0.02  # spacing of the claw's nodes where it moves: up to 5 Hz within 1e-5 of its size
Place = Annotated[Number, Field(ge=-FARTHEST_M, le=FARTHEST_M)]
CLAW_COLUMNS: Final = ("time [s]", "x [m]", "y [m]", "z [m]")


class Noise(CaseSection):
    """Irregularity added to the claw's x and y position: random-phase sines of equal size in a band."""

    rms_m: NonNegative = Field(description="root mean square of each coordinate [m]")
    low_hz: Positive = Field(0.8, description="lower end of the band [Hz]")
    high_hz: Annotated[Positive, Field(le=5.0)] = Field(1.2, description="upper end of the band [Hz]")
    rise_s: Positive = Field(1.0, description="time over which it fades in [s]")

    @model_validator(mode="after")
    def _ordered(self) -> Noise:
        if self.high_hz <= self.low_hz:
            raise ValueError(f"high_hz = {self.high_hz:g} must be above low_hz = {self.low_hz:g}")
        return self

    def at(self, t: Array, rng: np.random.Generator) -> tuple[Array, Array, Array]:
        """Position x, y [m] and its two rates at times `t` (m,) [s], three arrays (m, 2)."""
        omega = 2.0 * math.pi * rng.uniform(self.low_hz, self.high_hz, (NOISE_LINES, 2))
        phase = rng.uniform(0.0, 2.0 * math.pi, (NOISE_LINES, 2))
        size = self.rms_m * math.sqrt(2.0 / NOISE_LINES)
        angle = t[:, None, None] * omega + phase
        q = size * np.sin(angle).sum(axis=1)
        v = size * (omega * np.cos(angle)).sum(axis=1)
        a = -size * (omega * omega * np.sin(angle)).sum(axis=1)
        f, df, ddf = (g[:, None] for g in smootherstep(t - t[0], self.rise_s))
        return f * q, f * v + df * q, f * a + 2.0 * df * v + ddf * q


class StillClaw(CaseSection):
    """The claw stands (PRESCRIBED.INP lines 1 and 2); null: where the probe is at the start."""

    type: Literal["still"] = "still"
    x_m: Place | None = Field(None, description="along the track, S axes [m]")
    y_m: Place | None = Field(None, description="across the track, S axes [m]")
    z_m: Annotated[Number, Field(le=0.0)] = Field(
        0.0, description="of the claw plane, S axes, negative over the deck [m]"
    )


class ClawPoints(CaseSection):
    """The claw goes through given points and stands before the first and after the last one."""

    type: Literal["points"] = "points"
    time_s: Annotated[tuple[Number, ...], Field(min_length=2)] = Field(description="times of the points [s]")
    x_m: tuple[Place, ...] = Field(description="along the track, S axes [m]")
    y_m: tuple[Place, ...] = Field(description="across the track, S axes [m]")
    z_m: Annotated[Number, Field(le=0.0)] = Field(0.0, description="of the claw plane, S axes [m]")
    relative_to: Literal["probe", "ship"] = Field("probe", description="origin: the probe at the start, or the ship's")
    interpolation: Literal["monotone", "spline"] = Field(
        "monotone", description="monotone: without overshoot, through few points; spline: cubic, through many"
    )
    noise: Noise | None = Field(None, description="irregularity added to x and y")

    @model_validator(mode="after")
    def _sound(self) -> ClawPoints:
        for key in ("x_m", "y_m"):
            if len(getattr(self, key)) != len(self.time_s):
                raise ValueError(f"{key} has {len(getattr(self, key))} numbers, time_s has {len(self.time_s)}")
        if any(b - a < LEAST_GAP_S for a, b in pairwise(self.time_s)):
            raise ValueError(f"time_s must increase by at least {LEAST_GAP_S:g} s from each point to the next")
        return self


class ClawFile(CaseSection):
    """The claw follows a record of four columns: time, x, y, z (RSD POS.INP)."""

    type: Literal["file"] = "file"
    path: FilePath = Field(description="the file")
    noise: Noise | None = Field(None, description="irregularity added to x and y")


Claw = Annotated[StillClaw | ClawPoints | ClawFile, Field(discriminator="type")]


def longest_node_s(claw: StillClaw | ClawPoints | ClawFile) -> float:
    """Longest spacing of nodes that the claw's motion allows [s]."""
    return NODE_SPACING_S if isinstance(claw, StillClaw) else FINE_NODE_S


def plane_height(claw: StillClaw | ClawPoints | ClawFile) -> float:
    """Height of the claw plane over the deck at the start [m].

    Raises:
        ConfigurationError: The claw's file cannot be read, or it begins below the deck.
    """
    if not isinstance(claw, ClawFile):
        return 0.0 - claw.z_m
    height = 0.0 - float(read_claw_file(claw.path)[0, 3])
    if height < 0.0:
        raise ConfigurationError(
            f"claw file {claw.path}: its first z = {-height:g} m is refused: the claw must not lie below the "
            "deck, z is positive downwards."
        )
    return height


def read_claw_file(path: Path) -> Array:
    """Read a record of the claw, (n, 4): time [s], x, y, z [m], S axes.

    Columns are separated by blanks, tabs, commas or semicolons; lines that start with ``#``, ``%`` or ``!`` and blank
    ones are passed over.

    Raises:
        ConfigurationError: No such file, a malformed row (named by line and column), or times that do not increase.
    """
    try:
        text = read_text(path)
    except OSError as error:
        raise ConfigurationError(f"claw file {path}: cannot be read ({error.strerror or error}).") from None
    rows: list[list[float]] = []
    for number, fields in rows_of(text):
        rows.append(_claw_row(path, number, fields))
        if len(rows) > 1 and rows[-1][0] - rows[-2][0] < LEAST_GAP_S:
            raise ConfigurationError(
                f"claw file {path}, line {number}, column 1: time {rows[-1][0]:g} s is refused: it must be at least "
                f"{LEAST_GAP_S:g} s after that of the row before, {rows[-2][0]:g} s."
            )
    if len(rows) < 2:
        raise ConfigurationError(f"claw file {path}: {len(rows)} rows found, expected 2 or more of 4 columns.")
    return np.array(rows)


def _claw_row(path: Path, number: int, fields: list[str]) -> list[float]:
    if len(fields) != len(CLAW_COLUMNS):
        raise ConfigurationError(
            f"claw file {path}, line {number}: {len(fields)} columns found, expected {len(CLAW_COLUMNS)}: "
            f"{', '.join(CLAW_COLUMNS)}."
        )
    row = []
    for column, field in enumerate(fields, start=1):
        value = number_in(field)
        if value is None or not math.isfinite(value) or (column > 1 and abs(value) > FARTHEST_M):
            raise ConfigurationError(
                f"claw file {path}, line {number}, column {column}: expected {CLAW_COLUMNS[column - 1]} as a "
                f"number{f' within {FARTHEST_M:g} m' if column > 1 else ''}, found {field[:24]!r}."
            )
        row.append(value)
    return row


def claw_nodes(
    claw: ClawPoints | ClawFile, probe_S: Array, start_s: float, end_s: float, spacing_s: float, seed: int
) -> Array:
    """Nodes of the claw's motion from `start_s` to past `end_s`.

    Args:
        claw: How it moves.
        probe_S: Probe point at the start, x and y, S axes (2,) [m].
        start_s: Start of the run on the claw's clock [s].
        end_s: Its end [s].
        spacing_s: Time between nodes [s].
        seed: Of the noise.

    Returns:
        (nodes, 9): x, y, z [m], their rates and accelerations.

    Raises:
        ConfigurationError: The file cannot be read.
    """
    if isinstance(claw, ClawFile):
        record = read_claw_file(claw.path)
        time, points, origin, smooth = record[:, 0], record[:, 1:4], np.zeros(3), True
    else:
        time = np.array(claw.time_s)
        points = np.stack([claw.x_m, claw.y_m, np.full(time.size, claw.z_m)], axis=1)
        origin = np.array([*probe_S, 0.0]) if claw.relative_to == "probe" else np.zeros(3)
        smooth = claw.interpolation == "spline"
    t: Array = start_s + spacing_s * np.arange(math.ceil((end_s - start_s) / spacing_s) + 2, dtype=np.float64)
    halts = (isinstance(claw, ClawPoints) or start_s < time[0], isinstance(claw, ClawPoints) or end_s > time[-1])
    curve = _curve(time, points, smooth, halts)
    inside = np.clip(t, time[0], time[-1])
    rate, acceleration = curve(inside, 1), curve(inside, 2)
    acceleration[(t < time[0]) | (t > time[-1])] = 0.0
    position = curve(inside) + (t - inside)[:, None] * rate  # past the end of a record the claw goes straight on
    nodes = np.concatenate([position + origin, rate, acceleration], axis=1)
    if claw.noise is not None:
        for k, part in enumerate(claw.noise.at(t, np.random.default_rng(seed))):
            nodes[:, 3 * k : 3 * k + 2] += part
    return np.asarray(nodes, dtype=np.float64)


def _curve(time: Array, points: Array, smooth: bool, halts: tuple[bool, bool]) -> Callable[..., Array]:
    """A curve through points (n, 3) at times (n,): a spline, or one that overshoots none; it may halt at its ends."""
    from scipy.interpolate import CubicHermiteSpline, CubicSpline, PchipInterpolator

    free = "not-a-knot" if time.size > 3 else "natural"
    if smooth:
        ends: Any = tuple((1, np.zeros(3)) if halt else free for halt in halts)
        return cast(Callable[..., Array], CubicSpline(time, points, bc_type=ends))
    slopes = PchipInterpolator(time, points).derivative()(time)
    for end in (0, -1):
        if halts[end]:
            slopes[end] = 0.0
    return cast(Callable[..., Array], CubicHermiteSpline(time, points, slopes))
