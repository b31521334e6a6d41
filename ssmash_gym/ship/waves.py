"""A sea becomes a few dozen long-crested waves, drawn where they matter to the ship.

A grid over frequency and direction holds the sea's energy (`sea_grid`). The ship's response on the grid says where
the energy of its motions lies; the waves are drawn in proportion to that importance and weigh in inverse proportion
(`draw_waves`), so every draw stands for the same sea, and narrow resonances are never missed. What is left of the
scatter is taken out by small changes of the energies (`calibrated`): the long-run severity is that of the grid,
whatever the seed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.elimination import solved
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.sea import HIGHEST, LOWEST, Spectrum, Spreading

GOLDEN: Final = 0.5 * (math.sqrt(5.0) - 1.0)  # successive multiples of it, modulo 1, fill an interval evenly
FREQUENCIES: Final = 60  # rows of the grid
DIRECTIONS: Final = 10  # cells a row
STRIDE: Final = 7  # order in which a row's cells take their frequencies; no common divisor with `DIRECTIONS`
KNEE: Final = 0.5  # three quarters of the rows lie in this first share of the band, where ships resonate
FINE: Final = 24  # directions from which waves are drawn
LARGEST_FACTOR: Final = 5.0  # on a wave's energy in `calibrated`
SOFTNESS: Final = 1e-4  # error of a sum, relative, for each unit of its multiplier
ROUNDS: Final = 24  # of Newton's method, at most; three are usual, twelve enough for 96 waves
HALVINGS: Final = 10  # of one of its steps, at most
CLOSE: Final = 1e-5  # relative error of a sum at which it ends
ARMIJO: Final = 1e-4  # share of the descent promised by the slope that a step must bring
ROUNDING: Final = 1e-14  # relative, of the function that is minimised


@dataclass(frozen=True, eq=False)
class Waves:
    """Long-crested waves; the elevation at the origin is ``sum_i amplitude_i cos(omega_i t + phase_i)``, up positive.

    Attributes:
        omega: Wave frequencies [rad/s], (n,), ascending.
        heading: Direction of travel relative to the ship's heading [rad], (n,); 0 following, pi/2 towards starboard.
        amplitude: Amplitudes [m], (n,).
        phase: Phases [rad], (n,).
    """

    omega: FloatArray
    heading: FloatArray
    amplitude: FloatArray
    phase: FloatArray


@dataclass(frozen=True, eq=False)
class SeaGrid:
    """Energy of a sea in cells over frequency and direction.

    Attributes:
        spectrum: Spectrum of the elevation.
        spreading: Distribution of directions.
        edges: Edges of the rows [rad/s], (f + 1,).
        shift: Place of a row's directions within their even spacing, in [0, 1), (f,).
        omega: Frequencies [rad/s], (f, d).
        angle: Directions from the main one [rad], (f, d).
        energy: Variance of the elevation in each cell [m2], (f, d).
    """

    spectrum: Spectrum
    spreading: Spreading
    edges: FloatArray
    shift: FloatArray
    omega: FloatArray
    angle: FloatArray
    energy: FloatArray


def sea_grid(spectrum: Spectrum, spreading: Spreading) -> SeaGrid:
    """The grid of a sea: from half the peak frequency to `HIGHEST`, and all directions of the spreading.

    The directions of a row are evenly spaced and move on by the golden ratio of the spacing from row to row, and the
    cells of a row have their frequencies at different places within it: no two cells share a frequency or a direction.
    So 600 cells integrate a resonance, narrow in both, as well as some thousand of a rectangular grid would. A
    long-crested sea has one direction and as many rows.
    """
    spread = spreading.name != "long_crested"
    rows, columns = (FREQUENCIES, DIRECTIONS) if spread else (FREQUENCIES * DIRECTIONS, 1)
    low, many = LOWEST * spectrum.peak, 3 * rows // 4
    knee = low + KNEE * (HIGHEST - low)
    edges = np.concatenate([np.linspace(low, knee, many + 1), np.linspace(knee, HIGHEST, rows - many + 1)[1:]])
    number = np.arange(columns)
    width = np.diff(edges)[:, np.newaxis]
    omega = edges[:-1, np.newaxis] + width * ((0.5 + STRIDE * number % columns) / columns)
    energy = spectrum.density(omega) * width
    shift = np.asarray((0.5 + GOLDEN * np.arange(rows)) % 1.0, dtype=np.float64)
    angle = np.zeros_like(omega)
    if spread:
        angle = -0.5 * math.pi + math.pi / columns * (shift[:, np.newaxis] + number)
        energy = energy * spreading.density(angle)
    if spectrum.variance > 0.0:
        energy = energy * (
            float(spectrum.energy(low, HIGHEST)) / np.sum(energy)
        )  # the quadrature's error, parts of 1e-3
    return SeaGrid(spectrum, spreading, edges, shift, omega, angle, energy)


def draw_waves(
    grid: SeaGrid, importance: FloatArray, heading: float, components: int, rng: np.random.Generator
) -> Waves:
    """Draw the waves of one sea.

    Frequencies are stratified: the importance is cut into `components` equal parts over frequency, and each part has
    one frequency at a random place. Directions follow the importance at that frequency, at shares of the golden-ratio
    sequence from a random start, so that any stretch of frequencies has all the directions that matter. A wave's
    energy is the sea's density over the density of the draw, so that sums over the waves are unbiased.

    The generator gives, in this order and for every sea, ship, heading and speed alike: `components` places, one start
    of the directions, `components` phases. Draws from generators in the same state share them.

    Args:
        grid: The sea.
        importance: Positive weight of each cell, (f, d), in any unit.
        heading: Main direction of travel relative to the ship's heading [rad].
        components: Number of waves, 1 or more.
        rng: Generator.

    Raises:
        ConfigurationError: A heading that is not a finite number, or no component.
    """
    if not math.isfinite(heading):
        raise ConfigurationError(f"heading is {heading!r}, allowed is a finite number [rad]")
    if components < 1:
        raise ConfigurationError(f"components is {components!r}, allowed is a whole number of 1 or more")
    jitter = rng.random(components)
    start = rng.random()
    phase = 2.0 * math.pi * rng.random(components)

    number = np.arange(components)
    share = np.sum(importance, axis=1)
    below = np.concatenate([[0.0], np.cumsum(share)])
    place = (number + jitter) / components * below[-1]
    row = np.clip(np.searchsorted(below, place, side="right") - 1, 0, len(share) - 1)
    width = np.diff(grid.edges)[row]
    omega = grid.edges[row] + np.clip((place - below[row]) / share[row], 0.0, 1.0) * width
    likely = share[row] / (below[-1] * width)  # density of the draw over frequency
    energy = grid.spectrum.density(omega) / (components * likely)
    angle = np.zeros(components)
    if grid.angle.shape[1] > 1:
        fine = _fine_directions(grid, importance)[row]
        edges = np.concatenate([np.zeros((components, 1)), np.cumsum(fine, axis=1)], axis=1)
        aim = (start + GOLDEN * number) % 1.0 * edges[:, -1]
        cell = np.clip(np.sum(edges <= aim[:, np.newaxis], axis=1) - 1, 0, FINE - 1)
        step = math.pi / FINE
        angle = -0.5 * math.pi + step * (cell + (aim - edges[number, cell]) / fine[number, cell])
        energy *= grid.spreading.density(angle) * step * edges[:, -1] / fine[number, cell]
    return Waves(omega, heading + angle, np.sqrt(2.0 * energy), phase)


def _fine_directions(grid: SeaGrid, importance: FloatArray) -> FloatArray:
    """Importance over `FINE` even directions for each frequency, (f, FINE): from its row and the two beside it.

    The rows' own directions interlace, so three of them together resolve what one does not. The directions close on
    themselves, for the spreading is nothing at either end.
    """
    rows, columns = importance.shape
    place = (0.5 + np.arange(FINE)) * (columns / FINE) - grid.shift[:, np.newaxis]
    left = np.floor(place).astype(np.int64)
    along = place - left
    row = np.arange(rows)[:, np.newaxis]
    density = importance[row, left % columns] * (1.0 - along) + importance[row, (left + 1) % columns] * along
    padded = np.concatenate([density[:1], density, density[-1:]])
    return np.asarray(padded[:-2] + padded[1:-1] + padded[2:], dtype=np.float64)


def calibrated(energy: FloatArray, powers: FloatArray, targets: FloatArray) -> tuple[FloatArray, float]:
    """Energies near the given ones whose sums are the targets: ``sum_i energy_i powers_ij = targets_j``.

    Each energy is multiplied by a factor between 0 and `LARGEST_FACTOR`, the logit of calibration estimation (Deville &
    Sarndal 1992, "Calibration estimators in survey sampling", J. Am. Stat. Assoc. 87): a rising function of a
    combination of the powers, ``factor_i = F(sum_j lambda_j powers_ij)`` with ``F(0) = F'(0) = 1``. The multipliers
    lambda minimise a convex function, by Newton's method with halved steps where a full one does not lower it. A few
    waves cannot meet every set of sums; so the function has `SOFTNESS` times half the square of lambda in it, which
    misses sums a little rather than let the multipliers run away. Sums and solution are elementwise, so no bit depends
    on threads.

    Args:
        energy: Energies (n,) [m2].
        powers: Non-negative powers per energy (n, m).
        targets: Sums to be met (m,), positive; the energies' sum is about the first.

    Returns:
        Energies (n,), and the largest relative error of a sum that is left.
    """
    shares = energy / targets[0]
    relative = np.ascontiguousarray((powers * (targets[0] / targets)).T)  # (m, n); the sums are to be 1
    multipliers = np.zeros(len(targets))
    factors, value = _dual(shares, relative, multipliers)
    for _ in range(ROUNDS):
        gradient = np.sum(relative * (shares * factors), axis=1) - 1.0 + SOFTNESS * multipliers
        if np.max(np.abs(gradient)) < CLOSE:
            break
        slopes = shares * factors * (LARGEST_FACTOR - factors) / (LARGEST_FACTOR - 1.0)
        matrix = np.einsum("ji,ki->jk", relative * slopes, relative)
        matrix[np.diag_indices_from(matrix)] += SOFTNESS
        step = -solved(matrix[..., np.newaxis], gradient[:, np.newaxis])[:, 0]
        descent = float(np.sum(gradient * step))
        length = 1.0
        for _ in range(HALVINGS):
            tried = _dual(shares, relative, multipliers + length * step)
            if tried[1] <= value + ARMIJO * length * descent + ROUNDING * abs(value):
                break
            length *= 0.5
        multipliers = multipliers + length * step
        factors, value = tried
    error = np.sum(relative * (shares * factors), axis=1) - 1.0
    return energy * factors, float(np.max(np.abs(error)))


def _dual(shares: FloatArray, relative: FloatArray, multipliers: FloatArray) -> tuple[FloatArray, float]:
    """Factors (n,) of the energies for given multipliers, and the convex function that those are to minimise."""
    odds = LARGEST_FACTOR - 1.0
    exponent = np.sum(relative * multipliers[:, np.newaxis], axis=0) * (LARGEST_FACTOR / odds)
    above = np.logaddexp(math.log(odds), exponent)  # log(odds + e^x), whatever the size of x
    value = odds * float(np.sum(shares * (above - math.log(LARGEST_FACTOR))))
    value += float(np.sum(multipliers * (0.5 * SOFTNESS * multipliers - 1.0)))
    return LARGEST_FACTOR * np.exp(exponent - above), value
