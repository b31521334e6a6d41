"""What a record of deck motion holds: its quantities against time, their statistics, and spectra over frequency."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import GRAVITY, Motion, Signal, pose_of
from ssmash_gym.ship.sea import KNOT, Spreading, encounter
from ssmash_gym.ship.seaway import Seaway, SeawayMotion
from ssmash_gym.ship.seaway_statistics import deck_transfer, quadrature
from ssmash_gym.ship.ships import load_ship

BLOCK: Final = 4096  # instants that are sampled at once
FREQUENCIES: Final = 480  # of the long-run spectra
DIRECTIONS: Final = 96
PARTS: Final = 4  # of each cell of the spectral integral, which is spread over the frequencies that it covers
WELCH_S: Final = 120.0  # length of the pieces that a record's spectrum is averaged over
KERNEL_RADPS: Final = 0.012  # width of the smoothing of the long-run spectra, below that of a record's estimate


@dataclass(frozen=True)
class Quantity:
    """One quantity of the deck.

    Attributes:
        key: Its field in `DeckRms`, and its name in `Record.series`.
        label: In words.
        unit: Unit, with g the acceleration of free fall.
    """

    key: str
    label: str
    unit: str

    @property
    def column(self) -> str:
        """Name of the column of its spectral density."""
        return f"{self.key.replace('_m_s', '_mps')}_squared_s"


QUANTITIES: Final = (
    Quantity("roll_deg", "roll", "deg"),
    Quantity("pitch_deg", "pitch", "deg"),
    Quantity("heave_m", "heave", "m"),
    Quantity("vertical_velocity_m_s", "vertical velocity", "m/s"),
    Quantity("vertical_acceleration_g", "vertical acceleration", "g"),
    Quantity("lateral_acceleration_g", "lateral acceleration", "g"),
    Quantity("lateral_specific_force_g", "lateral specific force", "g"),
)


class Statistics(NamedTuple):
    """Mean; about it the root mean square, significant value (twice that) and largest departure."""

    mean: float
    rms: float
    significant: float
    largest: float


@dataclass(frozen=True, eq=False)
class Record:
    """A record of deck motion.

    Attributes:
        time_s: Instants from 0 on, evenly spaced [s], (n,).
        series: By the keys of `QUANTITIES`, each (n,), in their units; the vertical ones are positive down, the
            lateral ones to starboard, all as `DeckRms` has them.
        elevation_m: Height of the sea at the ship's mean place [m], up positive, (n,); None without a seaway.
    """

    time_s: FloatArray
    series: dict[str, FloatArray]
    elevation_m: FloatArray | None

    def statistics(self) -> dict[str, Statistics]:
        """The statistics of each quantity, by its key."""
        found = {}
        for key, values in self.series.items():
            mean, rms = float(np.mean(values)), float(np.std(values))
            found[key] = Statistics(mean, rms, 2.0 * rms, float(np.max(np.abs(values - mean))))
        return found


def sample_record(
    motion: Motion, duration_s: float, step_s: float, progress: Callable[[float], None] | None = None
) -> Record:
    """Sample a motion from t = 0 on.

    Args:
        motion: The motion.
        duration_s: Length [s]; the last instant is the last multiple of `step_s` within it.
        step_s: Time between instants [s].
        progress: Called now and then with the share that is done.
    """
    count = int(duration_s / step_s + 1e-9) + 1
    time = step_s * np.arange(count, dtype=np.float64)
    series = {quantity.key: np.empty(count) for quantity in QUANTITIES}
    elevation = np.empty(count) if isinstance(motion, SeawayMotion) else None
    for first in range(0, count, BLOCK):
        rows = slice(first, min(first + BLOCK, count))
        for key, values in deck_series(_sampled(motion, time[rows], step_s), motion.drift, time[rows]).items():
            series[key][rows] = values
        if elevation is not None and isinstance(motion, SeawayMotion):
            elevation[rows] = motion.elevation(time[rows])
        if progress is not None:
            progress(rows.stop / count)
    return Record(time, series, elevation)


def _sampled(motion: Motion, time: FloatArray, step_s: float) -> Signal:
    try:
        return motion.sample(float(time[0]), step_s, len(time))
    except ConfigurationError:  # a step too wide for a table to be interpolated; a record may have it
        return motion.signal(time)


def deck_series(signal: Signal, drift: FloatArray, time: FloatArray) -> dict[str, FloatArray]:
    """The quantities of `QUANTITIES` from the six channels of the deck point.

    Args:
        signal: Channels and derivatives, each (n, 6) [m, rad; per s, per s2].
        drift: Steady speed that is taken off the displacement (6,) [m/s, rad/s].
        time: Instants [s], (n,).
    """
    pose = pose_of(signal)
    starboard = np.einsum("nj,nj->n", pose.R_NS[:, :, 1], pose.a_NS_N)
    return {
        "roll_deg": np.degrees(signal.position[:, 3]),
        "pitch_deg": np.degrees(signal.position[:, 4]),
        "heave_m": signal.position[:, 2] - drift[2] * time,
        "vertical_velocity_m_s": pose.v_NS_N[:, 2],
        "vertical_acceleration_g": pose.a_NS_N[:, 2] / GRAVITY,
        "lateral_acceleration_g": starboard / GRAVITY,
        "lateral_specific_force_g": pose.specific_force_S(GRAVITY)[:, 1] / GRAVITY,
    }


@dataclass(frozen=True, eq=False)
class Spectra:
    """Spectral densities over encounter frequency, one-sided: the integral over frequency is the variance.

    Attributes:
        omega: Encounter frequencies, unsigned [rad/s], (n,).
        wave: Of the elevation at the ship's mean place [m2 s/rad], (n,); zero without a seaway.
        wave_at_rest: Of the elevation over *wave* frequency, as the spectrum's formula has it [m2 s/rad], (n,).
        deck: Of the deck's quantities [unit squared s/rad], each (n,), by the keys of `QUANTITIES`.
    """

    omega: FloatArray
    wave: FloatArray
    wave_at_rest: FloatArray
    deck: dict[str, FloatArray]


def long_run_spectra(source: Seaway, motion: SeawayMotion, omega: FloatArray) -> Spectra:
    """Spectra of a seaway from the spectral integral, smoothed by a narrow Gaussian.

    Where the waves run with the ship, many wave frequencies share one encounter frequency and the exact density is
    infinite there; the smoothing keeps it finite and leaves the variance as it is.

    Args:
        source: The section that the motion was drawn from.
        motion: The motion: its roll damping is the same.
        omega: Evenly spaced encounter frequencies from 0 on [rad/s], (n,).
    """
    spectrum, speed = source.sea(), source.speed_kn * KNOT
    wave_omega, angle, amplitude = quadrature(spectrum, Spreading(source.spreading), FREQUENCIES, DIRECTIONS)
    heading = np.radians(source.heading_deg) + angle
    response = load_ship(source.ship).response.respond(
        wave_omega,
        heading,
        amplitude,
        speed,
        roll_damping_factor=source.roll_damping_factor,
        gm_factor=source.gm_factor,
    )
    transfer = deck_transfer(response.omega_e, response.transfer, motion.point, motion.mean[3:5])
    s = 1j * response.omega_e
    per_wave = {
        "roll_deg": np.degrees(1.0) * transfer.roll,
        "pitch_deg": np.degrees(1.0) * transfer.pitch,
        "heave_m": transfer.vertical,
        "vertical_velocity_m_s": s * transfer.vertical,
        "vertical_acceleration_g": s * s * transfer.vertical / GRAVITY,
        "lateral_acceleration_g": transfer.lateral / GRAVITY,
        "lateral_specific_force_g": transfer.lateral_specific_force / GRAVITY,
    }
    energy = 0.5 * amplitude**2
    cell = float(np.ptp(wave_omega)) / (FREQUENCIES - 1) * ((np.arange(PARTS) + 0.5) / PARTS - 0.5)
    place = np.abs(encounter(wave_omega + cell[:, np.newaxis], heading, speed, GRAVITY))
    return Spectra(
        omega,
        _density(place, energy, omega),
        spectrum.density(omega),
        {key: _density(place, energy * (H.real**2 + H.imag**2), omega) for key, H in per_wave.items()},
    )


def write_spectra(path: str | Path, spectra: Spectra, comments: Sequence[str]) -> None:
    """Write spectra as CSV, one row a frequency; the head says what each column is.

    Args:
        path: The file.
        spectra: What is written.
        comments: Lines that head the file, each behind a ``#``.
    """
    met, at_rest = "elevation_over_encounter_m_squared_s", "elevation_over_wave_m_squared_s"
    columns = {"omega_radps": spectra.omega, met: spectra.wave, at_rest: spectra.wave_at_rest}
    columns |= {quantity.column: spectra.deck[quantity.key] for quantity in QUANTITIES}
    told = [
        "long-run spectral densities, one-sided: the integral of a column over omega_radps is the variance",
        f"omega_radps: frequency [rad/s]; of encounter for all columns but {at_rest}",
        f"{met}: sea at the ship's mean place, over encounter frequency [m^2 s/rad]",
        f"{at_rest}: sea, here omega_radps is the wave frequency at a place at rest [m^2 s/rad]",
        *(f"{q.column}: {q.label}, over encounter frequency [({q.unit})^2 s/rad]" for q in QUANTITIES),
    ]
    lines = [*(f"# {line}" for line in (*comments, *told)), ",".join(columns)]
    lines += [",".join(f"{value:.8g}" for value in row) for row in zip(*columns.values(), strict=True)]
    write_text(path, "\n".join(lines) + "\n")


def _density(place: FloatArray, energy: FloatArray, omega: FloatArray) -> FloatArray:
    """Density (n,) on an even grid, smoothed; what falls below 0 is turned back.

    Args:
        place: Frequencies that each cell's energy is spread over in equal parts [rad/s], (PARTS, m).
        energy: Energy of each cell, (m,).
        omega: The grid from 0 on [rad/s], (n,).
    """
    from scipy.ndimage import gaussian_filter1d

    step, last = float(omega[1] - omega[0]), len(omega) - 1
    lumps = np.zeros(last + 2)  # what is beyond the grid gathers behind its end
    for part in place / step:
        left = np.minimum(part.astype(np.int64), last)
        # Shared between the two neighbours: counting whole parts would leave a pattern of fuller and emptier bins.
        right = np.minimum(part - left, 1.0) * energy
        lumps += np.bincount(left, energy - right, last + 2) + np.bincount(left + 1, right, last + 2)
    density = lumps[: last + 1] / (PARTS * step)
    return np.asarray(gaussian_filter1d(density, KERNEL_RADPS / step, mode="reflect"), dtype=np.float64)


def record_spectrum(values: FloatArray, step_s: float) -> tuple[FloatArray, FloatArray]:
    """Spectral density of a record by Welch's method, scaled to the record's variance.

    Hann window over pieces of 120 s or less that overlap by half, padded to four times their length for a smooth line.
    Windows and pieces see more or less of the record than its whole: the scaling makes the integral the variance.

    Args:
        values: Evenly spaced values, (n,).
        step_s: Time between them [s].

    Returns:
        Frequencies [rad/s] and densities [unit squared s/rad].
    """
    from scipy.signal import welch

    length = min(len(values), max(8, round(WELCH_S / step_s)))
    hertz, density = welch(values, 1.0 / step_s, nperseg=length, nfft=4 * length, detrend="constant")
    omega = 2.0 * np.pi * hertz
    found = float(np.sum(density)) * float(omega[1] - omega[0])
    return omega, density * (float(np.var(values)) / found) if found > 0.0 else density
