"""The one interface of every deck motion: a motion in time, baked into a table of nodes.

The table holds position, rate and acceleration of six channels at evenly spaced nodes; between nodes a quintic
Hermite piece through both ends' three values is evaluated. The piece is C2 across nodes, and the rates and
accelerations it reports are the derivatives of the position it reports, which the equations of motion rely on.

Channels, in this order: x, y, z of the deck origin in the steadily translating mean frame N (z down) [m], and
roll, pitch, yaw of the ship (z-y-x sequence) [rad]. The deck origin is the ship-frame origin: the named deck point
on the track's centre line at deck level.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Final, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.kinematics import FloatArray, angular_acceleration, angular_velocity, rotation

CHANNELS: Final = ("x", "y", "z", "roll", "pitch", "yaw")
N_CHANNELS: Final = len(CHANNELS)
# Errors of a sea's motion at this spacing, in units of its standard deviation: 3e-8 in position, 2e-5 in acceleration.
DEFAULT_SPACING_S: Final = 0.25
GRAVITY: Final = 9.81  # [m/s2]
RMS_DURATION_S: Final = 600.0  # of a sampled severity: a ten-minute record at four samples a second
RMS_SPACING_S: Final = 0.25
TIME_SLACK: Final = (
    1e-6  # share of a spacing by which a time may pass the table's ends (rounding of the caller's clock)
)


class Signal(NamedTuple):
    """Six channels and their time derivatives, each (..., 6) [m, rad; and per s, per s2]."""

    position: FloatArray
    rate: FloatArray
    acceleration: FloatArray


@dataclass(frozen=True, eq=False)
class DeckPose:
    """The ship frame as the equations of motion need it, at one instant (...) = () or at many (...) = (n,).

    Attributes:
        R_NS: S components to N components, (..., 3, 3).
        w_NS_S: Angular velocity, S axes [rad/s], (..., 3); Léveillé 2013 (2.20).
        wdot_NS_S: Its time derivative, S axes [rad/s2], (..., 3).
        r_NS_N: Position of the deck origin, N axes [m], (..., 3); (2.9).
        v_NS_N: Its velocity over the mean frame, N axes [m/s], (..., 3); (2.19).
        a_NS_N: Its acceleration, N axes [m/s2], (..., 3).
    """

    R_NS: FloatArray
    w_NS_S: FloatArray
    wdot_NS_S: FloatArray
    r_NS_N: FloatArray
    v_NS_N: FloatArray
    a_NS_N: FloatArray

    def specific_force_S(self, gravity: float) -> FloatArray:
        """What an accelerometer at the deck origin reads: ``R_NS^T (a - g)``, S axes [m/s2], (..., 3).

        Args:
            gravity: Acceleration of free fall [m/s2], along +z of N.
        """
        free_fall = np.array([0.0, 0.0, gravity])
        return np.asarray(np.einsum("...ji,...j->...i", self.R_NS, self.a_NS_N - free_fall), dtype=np.float64)


def pose_of(signal: Signal) -> DeckPose:
    """Attitude and velocities of the ship frame from the six channels and their derivatives."""
    q, qd, qdd = signal
    angles, rates, accelerations = q[..., 3:], qd[..., 3:], qdd[..., 3:]
    return DeckPose(
        R_NS=rotation(angles),
        w_NS_S=angular_velocity(angles, rates),
        wdot_NS_S=angular_acceleration(angles, rates, accelerations),
        r_NS_N=q[..., :3],  # (2.9)
        v_NS_N=qd[..., :3],  # (2.19)
        a_NS_N=qdd[..., :3],
    )


@dataclass(frozen=True, eq=False)
class NodeTable:
    """Nodes of some channels with their two derivatives; node k stands at ``t = k * spacing_s``.

    Attributes:
        spacing_s: Time between nodes [s].
        nodes: Read-only float64 (n_nodes, 3 * CHANNEL_COUNT): the channels, then their first, then their second time
            derivatives.

    Raises:
        ConfigurationError: The spacing is not positive, or the nodes are not finite numbers of that shape.
    """

    NAME: ClassVar[str]
    CHANNEL_COUNT: ClassVar[int]

    spacing_s: float
    nodes: FloatArray

    def __post_init__(self) -> None:
        nodes = np.array(self.nodes, dtype=np.float64, order="C")
        if nodes.ndim != 2 or nodes.shape[0] < 2 or nodes.shape[1] != 3 * self.CHANNEL_COUNT:
            raise ConfigurationError(
                f"{self.NAME}: nodes has shape {nodes.shape}, allowed is (2 or more, {3 * self.CHANNEL_COUNT})"
            )
        if not np.isfinite(nodes).all():
            row = int(np.argwhere(~np.isfinite(nodes))[0, 0])
            raise ConfigurationError(f"{self.NAME}: node {row} holds a value that is not finite")
        nodes.flags.writeable = False
        object.__setattr__(self, "spacing_s", positive(self.NAME, "spacing_s", self.spacing_s))
        object.__setattr__(self, "nodes", nodes)

    def __reduce__(self) -> tuple[Any, ...]:
        # NumPy forgets the read-only flag when an array is pickled or copied: build the table anew instead.
        return (type(self), (self.spacing_s, self.nodes))

    @property
    def duration_s(self) -> float:
        """Time of the last node [s]."""
        return (len(self.nodes) - 1) * self.spacing_s

    def interpolated(self, t: npt.ArrayLike) -> Signal:
        """Channels and their two derivatives at times `t` [s] in [0, duration_s], (...): three (..., CHANNEL_COUNT).

        Raises:
            ConfigurationError: A time outside the table.
        """
        time = np.asarray(t, dtype=np.float64)
        h = self.spacing_s
        slack = TIME_SLACK * h
        outside = ~((time >= -slack) & (time <= self.duration_s + slack))
        if outside.any():
            bad = float(time[outside].flat[0])
            raise ConfigurationError(f"{self.NAME}: time {bad:g} s is outside the table, 0 to {self.duration_s:g} s")
        piece = np.clip(np.floor(time / h).astype(np.int64), 0, len(self.nodes) - 2)
        return hermite(self.nodes[piece], self.nodes[piece + 1], h, (time - piece * h)[..., np.newaxis])


class MotionTable(NodeTable):
    """Nodes of a deck motion: the six channels of `CHANNELS` [m, rad], nodes (n_nodes, 18)."""

    NAME = "motion table"
    CHANNEL_COUNT = N_CHANNELS

    def at(self, t: npt.ArrayLike) -> Signal:
        """Position, rate and acceleration of the six channels.

        Args:
            t: Times [s] in [0, duration_s], shape (...).

        Returns:
            Three arrays (..., 6).

        Raises:
            ConfigurationError: A time outside the table.
        """
        return self.interpolated(t)

    def pose(self, t: npt.ArrayLike) -> DeckPose:
        """Attitude, angular velocity and linear motion of the ship frame at times `t` [s], shape (...)."""
        return pose_of(self.at(t))


def hermite(first: FloatArray, last: FloatArray, h: float, t: FloatArray) -> Signal:
    """Quintic piece between two nodes, and its derivatives.

    Args:
        first: Node at the piece's start, (..., 18) [m, rad, s], or three values of any other number of channels.
        last: Node at its end, (..., 18).
        h: Time between them [s].
        t: Time since the first [s], broadcast against (..., 6).

    Returns:
        Position, rate and acceleration, each (..., 6).
    """
    n = first.shape[-1] // 3
    q0, v0, a0 = (first[..., k * n : (k + 1) * n] for k in range(3))
    q1, v1, a1 = (last[..., k * n : (k + 1) * n] for k in range(3))
    # What a parabola from the first node leaves to be made up at the last one, in units of position.
    dq = q1 - q0 - v0 * h - 0.5 * a0 * h * h
    dv = (v1 - v0 - a0 * h) * h
    da = (a1 - a0) * h * h
    c2 = 0.5 * a0
    c3 = (10.0 * dq - 4.0 * dv + 0.5 * da) / (h * h * h)
    c4 = (-15.0 * dq + 7.0 * dv - da) / (h * h * h * h)
    c5 = (6.0 * dq - 3.0 * dv + 0.5 * da) / (h * h * h * h * h)
    return Signal(
        position=q0 + t * (v0 + t * (c2 + t * (c3 + t * (c4 + t * c5)))),
        rate=v0 + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * (5.0 * c5)))),
        acceleration=2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * (20.0 * c5))),
    )


@dataclass(frozen=True)
class DeckRms:
    """How severe a deck motion is: root mean squares about the mean, of the deck origin.

    Attributes:
        roll_deg: Roll [deg].
        pitch_deg: Pitch [deg].
        heave_m: Vertical displacement of the deck origin [m].
        vertical_velocity_m_s: Its vertical velocity, N axes [m/s].
        vertical_acceleration_g: Its vertical acceleration, N axes [9.81 m/s2].
        lateral_acceleration_g: Its acceleration to starboard, S axes [9.81 m/s2].
        lateral_specific_force_g: Its specific force to starboard, S axes [9.81 m/s2]: the acceleration less the
            component of gravity, what a load on the deck feels.
        roll_period_s: Mean period of roll, ``2 pi`` times the ratio of the RMS of roll and roll rate [s]; nan where the
            deck does not roll.
    """

    roll_deg: float
    pitch_deg: float
    heave_m: float
    vertical_velocity_m_s: float
    vertical_acceleration_g: float
    lateral_acceleration_g: float
    lateral_specific_force_g: float
    roll_period_s: float


class MotionSource(Protocol):
    """What a configuration section becomes: a motion, perhaps still to be drawn."""

    def realise(self, rng: np.random.Generator | None = None) -> Motion:
        """The motion itself; sources without chance ignore `rng`, the others need it."""
        ...

    def bake(self, duration_s: float, spacing_s: float, *, ramp_s: float = 0.0, start_s: float = 0.0) -> MotionTable:
        """The table of the realised motion, see `Motion.bake`."""
        ...


class Motion(ABC):
    """A deck motion that is known at every time of its record.

    A new source implements `signal` for the deck origin, and `mean` where it has one.
    """

    @property
    def mean(self) -> FloatArray:
        """Mean pose (6,) [m, rad] about which the deck moves; a ramp leaves it alone."""
        return np.zeros(N_CHANNELS)

    @property
    def drift(self) -> FloatArray:
        """Steady speed (6,) [m/s, rad/s] of the mean pose, `mean` being its value at t = 0; zero but for records."""
        return np.zeros(N_CHANNELS)

    @property
    def duration_s(self) -> float:
        """Length of the motion from t = 0 on [s]; infinite for motions given by a formula."""
        return math.inf

    def tabled_s(self, spacing_s: float, start_s: float = 0.0) -> float:
        """Time from `start_s` on that a table of whole spacings can cover [s]; infinite for an endless motion."""
        if not math.isfinite(self.duration_s):
            return math.inf
        return spacing_s * math.floor((self.duration_s - start_s) / spacing_s + TIME_SLACK)

    @abstractmethod
    def signal(self, t: npt.ArrayLike) -> Signal:
        """Six channels and their exact derivatives at times `t` [s], shape (n,): three arrays (n, 6) [m, rad, s]."""

    def sample(self, start_s: float, spacing_s: float, count: int) -> Signal:
        """`signal` at ``start_s + k * spacing_s``, k = 0 ... count - 1; overridden where even spacing is cheaper."""
        return self.signal(start_s + spacing_s * np.arange(count))

    def realise(self, rng: np.random.Generator | None = None) -> Motion:
        """This motion: nothing is left to be drawn."""
        return self

    @property
    def outside_validity(self) -> str | None:
        """One sentence where the motion passes what its model is valid for; None otherwise, and for plain signals."""
        return None

    def deck_rms(self, duration_s: float = RMS_DURATION_S) -> DeckRms:
        """Severity of the motion, here by sampling; a seaway knows its long-run values exactly.

        Args:
            duration_s: Time from t = 0 to sample [s]; less where the motion is shorter.

        Raises:
            ConfigurationError: A duration that is not positive.
        """
        duration = min(positive("deck_rms", "duration_s", duration_s), self.duration_s)
        time = np.linspace(0.0, duration, max(2, round(duration / RMS_SPACING_S) + 1))
        signal = self.signal(time)
        pose = pose_of(signal)
        swing = np.std(signal.position - time[:, np.newaxis] * self.drift, axis=0)
        roll_rate = float(np.std(signal.rate[:, 3]))
        lateral = np.einsum("nj,nj->n", pose.R_NS[:, :, 1], pose.a_NS_N)
        return DeckRms(
            roll_deg=math.degrees(swing[3]),
            pitch_deg=math.degrees(swing[4]),
            heave_m=float(swing[2]),
            vertical_velocity_m_s=float(np.std(pose.v_NS_N[:, 2])),
            vertical_acceleration_g=float(np.std(pose.a_NS_N[:, 2])) / GRAVITY,
            lateral_acceleration_g=float(np.std(lateral)) / GRAVITY,
            lateral_specific_force_g=float(np.std(pose.specific_force_S(GRAVITY)[:, 1])) / GRAVITY,
            roll_period_s=2.0 * math.pi * float(swing[3]) / roll_rate if roll_rate > 0.0 else math.nan,
        )

    def bake(
        self,
        duration_s: float,
        spacing_s: float = DEFAULT_SPACING_S,
        *,
        ramp_s: float = 0.0,
        start_s: float = 0.0,
    ) -> MotionTable:
        """Table of nodes of this motion.

        With a ramp, the motion about the mean pose is multiplied by a factor that goes from 0 to 1 in `ramp_s`
        with rate and acceleration zero at both ends; the derivatives follow by the product rule. The mean pose
        (static heel and trim, the position offset, a record's steady speed) is there from the start: a ramped
        table begins at rest in the mean pose, and a fixed deck is the same with and without a ramp.

        Args:
            duration_s: Time the table must cover [s]; rounded up to whole spacings.
            spacing_s: Time between nodes [s].
            ramp_s: Length of the ramp from the table's start [s]; 0 for none.
            start_s: Time of the motion at the table's start [s].

        Returns:
            The table; its time 0 is the motion's time `start_s`.

        Raises:
            ConfigurationError: A duration or spacing that is not positive, a negative ramp, or more time than the
                motion lasts.
        """
        duration = positive("bake", "duration_s", duration_s)
        h = positive("bake", "spacing_s", spacing_s)
        if not (math.isfinite(ramp_s) and ramp_s >= 0.0):
            raise ConfigurationError(f"bake: ramp_s is {ramp_s!r}, allowed are finite numbers of 0 s or more")
        if not math.isfinite(start_s):
            raise ConfigurationError(f"bake: start_s is {start_s!r}, allowed are finite numbers [s]")
        pieces = max(1, math.ceil(duration / h - TIME_SLACK))
        end = start_s + pieces * h
        if math.isfinite(self.duration_s) and (start_s < 0.0 or end > self.duration_s + TIME_SLACK * h):
            raise ConfigurationError(
                f"bake: a table from {start_s:g} to {end:g} s (whole spacings of {h:g} s) was asked for, "
                f"allowed is 0 to {self.duration_s:g} s, the length of the motion"
            )
        signal = self.sample(start_s, h, pieces + 1)
        if ramp_s > 0.0:
            signal = self._ramped(signal, h, ramp_s, start_s)
        return MotionTable(h, np.concatenate(signal, axis=1))

    def _ramped(self, signal: Signal, h: float, ramp_s: float, start_s: float) -> Signal:
        """The motion about the mean pose times the ramp, by the product rule; (n, 6) in, (n, 6) out."""
        t = h * np.arange(len(signal.position), dtype=np.float64)[:, np.newaxis]
        r, rd, rdd = smootherstep(t, ramp_s)
        steady = self.mean + self.drift * (start_s + t)
        q = signal.position - steady
        qd = signal.rate - self.drift
        return Signal(
            position=steady + r * q,
            rate=self.drift + r * qd + rd * q,
            acceleration=r * signal.acceleration + 2.0 * rd * qd + rdd * q,
        )


def smootherstep(t: FloatArray, length_s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Factor ``u^3 (10 - 15 u + 6 u^2)`` with ``u = t / length_s`` held in [0, 1], and its two time derivatives.

    Rate and acceleration are zero at both ends, so the factor is C2 for all times.

    Args:
        t: Times [s], any shape.
        length_s: Length of the ramp [s], positive.

    Returns:
        Factor [-], rate [1/s], acceleration [1/s2], shaped as `t`.
    """
    u = np.clip(t / length_s, 0.0, 1.0)
    factor = u * u * u * (10.0 + u * (-15.0 + 6.0 * u))
    rate = 30.0 * (u * (1.0 - u)) ** 2 / length_s
    acceleration = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / length_s**2
    return factor, rate, acceleration


def positive(where: str, key: str, value: float) -> float:
    """`value` as a float; refused with one sentence unless it is finite and above zero."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise ConfigurationError(f"{where}: {key} is {value!r}, allowed are finite numbers above 0")
    if not (math.isfinite(value) and value > 0.0):
        raise ConfigurationError(f"{where}: {key} is {value!r}, allowed are finite numbers above 0")
    return float(value)
