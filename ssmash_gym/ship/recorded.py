"""A recorded deck motion made smooth: positions, rates and accelerations that are each other's derivatives."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, cast

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.kinematics import (
    EULER_ORDERS,
    EulerOrder,
    FloatArray,
    angles_from_rotation,
    angular_acceleration,
    angular_velocity,
    axis_rotation,
    rotation,
)
from ssmash_gym.ship.motion import Motion, Signal
from ssmash_gym.ship.shipmo import COLUMNS, Rates, ShipmoRecord

DEGREE: Final = 5  # of the spline through the samples: accelerations are smooth, not a chain of straight lines
DETREND: Final = True  # unless a configuration says otherwise: a deck table is in the steadily translating mean frame
MARGIN: Final = 3  # samples at each end left out of the comparison: a spline's derivatives are weakest there
NOTICEABLE: Final = 0.02  # share of a column's own size from which a discrepancy is worth a warning
OPPOSITE: Final = 1.8  # share from which the column is nearly the derivative with its sign turned (2 where it is)
NEGLIGIBLE: Final = 1e-6  # rad/s, rad/s2, m/s2: a column smaller than this is zero


@dataclass(frozen=True)
class Discrepancy:
    """How far a column of the file is from the derivative of what the file says elsewhere.

    Attributes:
        name: The column.
        unit: Its unit, SI.
        rms: Root mean square of the difference.
        scale: Root mean square of the larger of the two.
    """

    name: str
    unit: str
    rms: float
    scale: float

    @property
    def share(self) -> float:
        """`rms` over `scale`; zero for a column that is zero."""
        return self.rms / self.scale if self.scale > NEGLIGIBLE else 0.0

    @property
    def remark(self) -> str:
        """What is to be said of it: nothing, that it is noticeable, or that the sign is probably the other one."""
        if self.share <= NOTICEABLE:
            return ""
        return "sign?" if self.share > OPPOSITE else f"more than {NOTICEABLE:.0%}"


class RecordedMotion(Motion):
    """Deck motion through the samples of a SHIPMO record.

    Angles are interpolated by a spline of degree 5 (C4), velocities likewise, and positions are the integral of the
    velocities from zero at the first row. All rates and accelerations are derivatives of these; the file's own
    columns 8-16 are compared with them (`discrepancies`, `report`) and otherwise not used. Time 0 is the first row.

    Args:
        record: The file's columns.
        rates: What columns 8-10 and 14-16 hold.
        order: Sequence of the file's angles; they are turned into the z-y-x sequence.
        detrend: Give the motion in the record's own steadily translating mean frame, x along the mean heading: the mean
            yaw is taken off, velocities and accelerations are turned into that heading, and the straight line (least
            squares) is removed from each position and its slope from the velocity (the mean ship speed and the drift
            of integrated noise). Otherwise nothing is removed, and the axes are the file's.

    Attributes:
        discrepancies: One entry for each of the columns 8-16.
    """

    def __init__(
        self, record: ShipmoRecord, rates: Rates = "body", order: EulerOrder = "zyx", *, detrend: bool = DETREND
    ):
        from scipy.interpolate import make_interp_spline  # here, so that importing the package stays quick

        time = record.step_s * np.arange(len(record.angles), dtype=np.float64)
        given: FloatArray = np.unwrap(record.angles, axis=0)
        angles = _in_zyx(given, order)
        if detrend:
            heading = float(np.mean(angles[:, 2]))
            angles = angles - np.array([0.0, 0.0, heading])
            R_ahead = axis_rotation(2, np.array(-heading))  # the file's N axes to those along the mean heading
            record = replace(record, velocity=record.velocity @ R_ahead.T, acceleration=record.acceleration @ R_ahead.T)
        self.name = record.name
        self._duration = float(time[-1])
        self._step = record.step_s
        self._angles = make_interp_spline(time, angles, k=DEGREE)
        self._velocity = make_interp_spline(time, record.velocity, k=DEGREE)
        self._position = self._velocity.antiderivative()
        line = np.polynomial.polynomial.polyfit(time, self._position(time), 1)  # (2, 3): offset, slope
        self._removed = line if detrend else np.zeros_like(line)
        self._mean = np.concatenate([line[0] - self._removed[0], np.mean(angles, axis=0)])
        self._drift = np.concatenate([line[1] - self._removed[1], np.zeros(3)])
        self._convention = f"rates: {rates}" + (f", euler_order: {order}" if order != "zyx" else "")
        turn, turn_rate = _turning(time, given, rates, order)
        expected = np.concatenate([turn, np.asarray(self._velocity(time, 1)), turn_rate], axis=1)
        self.discrepancies = _compare(record, expected)
        self._better = None if self.consistent else _better(record, time, given, _worst(self.discrepancies[:3]))

    @property
    def mean(self) -> FloatArray:
        """Mean pose (6,) [m, rad]: mean angles, and the positions' straight line at t = 0."""
        return self._mean

    @property
    def drift(self) -> FloatArray:
        """Slope of the positions' straight line (6,) [m/s]: the mean speed of the record."""
        return self._drift

    @property
    def duration_s(self) -> float:
        """Time from the first row to the last [s]."""
        return self._duration

    @property
    def step_s(self) -> float:
        """Time between the rows of the record [s]."""
        return self._step

    def signal(self, t: npt.ArrayLike) -> Signal:
        """Six channels and their exact derivatives at times `t` [s] within the record, (n,): three arrays (n, 6)."""
        time = np.atleast_1d(np.asarray(t, dtype=np.float64))
        slack = 1e-6 * self._step
        outside = ~((time >= -slack) & (time <= self._duration + slack))
        if outside.any():
            raise ConfigurationError(
                f"motion file {self.name}: time {float(time[outside][0]):g} s was asked for, allowed is 0 to "
                f"{self._duration:g} s, the length of the record"
            )
        offset, slope = self._removed
        position = self._position(time) - offset - np.outer(time, slope)
        return Signal(
            np.concatenate([position, self._angles(time)], axis=1),
            np.concatenate([self._velocity(time) - slope, self._angles(time, 1)], axis=1),
            np.concatenate([self._velocity(time, 1), self._angles(time, 2)], axis=1),
        )

    @property
    def consistent(self) -> bool:
        """Whether every column agrees with the derivatives within a few percent of its size."""
        return _worst(self.discrepancies) <= NOTICEABLE

    def report(self) -> str:
        """The comparison as text: a line for each of the columns 8-16, and a hint where another convention fits.

        Lines of columns that are off by more than 2 % of their size are marked.
        """
        lines = [
            f"motion file {self.name}: columns against the derivatives of angles and velocities ({self._convention})"
        ]
        lines += [
            f"  {d.name}: RMS difference {d.rms:.3g} of {d.scale:.3g} {d.unit} ({100.0 * d.share:.1f} %)"
            + (f"  <- {d.remark}" if d.remark else "")
            for d in self.discrepancies
        ]
        if self._better is not None:
            lines.append(f"  columns 8-10 agree better with {self._better}")
        return "\n".join(lines)


def _in_zyx(angles: FloatArray, order: EulerOrder) -> FloatArray:
    """Continuous z-y-x angles (n, 3) [rad] of the attitudes that the file's angles describe."""
    if order == "zyx":
        return angles
    return np.asarray(np.unwrap(angles_from_rotation(rotation(angles, order)), axis=0), dtype=np.float64)


def _turning(time: FloatArray, angles: FloatArray, rates: Rates, order: EulerOrder) -> tuple[FloatArray, FloatArray]:
    """What columns 8-10 [rad/s] and 14-16 [rad/s2] should hold, each (n, 3), if the file's angles are right."""
    from scipy.interpolate import make_interp_spline

    used = angles if rates == "euler" else _in_zyx(angles, order)
    spline = make_interp_spline(time, used, k=DEGREE)
    qd, qdd = np.asarray(spline(time, 1)), np.asarray(spline(time, 2))
    if rates == "euler":  # of the angles as they stand in the file, whatever their sequence
        return qd, qdd
    return angular_velocity(used, qd), angular_acceleration(used, qd, qdd)


def _better(record: ShipmoRecord, time: FloatArray, angles: FloatArray, found: float) -> str | None:
    """The setting of rates and euler_order, as text, with which columns 8-10 fit at least twice as well, if any."""
    fits = {}
    for rates, order in [("euler", "zyx"), *(("body", order) for order in EULER_ORDERS)]:
        turn, _ = _turning(time, angles, cast(Rates, rates), cast(EulerOrder, order))
        text = "rates: euler" if rates == "euler" else f"rates: body, euler_order: {order}"
        rms, size = _differences(record.rates, turn)
        fits[text] = float(np.max(np.where(size > NEGLIGIBLE, rms / np.maximum(size, NEGLIGIBLE), 0.0)))
    best = min(fits, key=lambda text: fits[text])
    return best if fits[best] < 0.5 * found else None


def _compare(record: ShipmoRecord, expected: FloatArray) -> tuple[Discrepancy, ...]:
    """One entry for each of the columns 8-16."""
    found = np.concatenate([record.rates, record.acceleration, record.rate_derivatives], axis=1)
    rms, size = _differences(found, expected)
    units = ("rad/s", "m/s2", "rad/s2")
    return tuple(
        Discrepancy(COLUMNS[7 + k][1].split(" [")[0], units[k // 3], float(rms[k]), float(size[k])) for k in range(9)
    )


def _differences(found: FloatArray, expected: FloatArray) -> tuple[FloatArray, FloatArray]:
    """RMS of the difference and of the larger of the two, column by column, without the first and last few rows."""
    inner = slice(MARGIN, -MARGIN) if len(found) > 4 * MARGIN else slice(None)
    size = np.sqrt(np.mean(np.stack([found[inner], expected[inner]]) ** 2, axis=1)).max(axis=0)
    return np.sqrt(np.mean((found[inner] - expected[inner]) ** 2, axis=0)), size


def _worst(discrepancies: tuple[Discrepancy, ...]) -> float:
    return max(d.share for d in discrepancies)
