"""Severities of a frigate-like ship by an independent prototype of the seaway, to set the package's beside.

The prototype has the same method, main dimensions, metacentric height, gyradii and damping model; its hull,
hydrodynamics and waves are its own. The figures are means of 4 records of 600 s in short-crested Bretschneider seas:
they carry 3-4 % of sampling scatter.
"""

from __future__ import annotations

from typing import Final

# Attributes of `DeckRms`: RMS of roll [deg], pitch [deg], vertical velocity [m/s], vertical acceleration [g] and
# lateral specific force [g] of the deck point.
REFERENCE_SEVERITIES: Final = (
    "roll_deg",
    "pitch_deg",
    "vertical_velocity_m_s",
    "vertical_acceleration_g",
    "lateral_specific_force_g",
)
REFERENCE_HEADINGS: Final = (0, 45, 90, 135, 180)  # the waves travel to [deg]

# By sea state and speed [kn]: a row of severities for each heading.
REFERENCE: Final[dict[tuple[int, int], tuple[tuple[float, ...], ...]]] = {
    (4, 10): (
        (1.68, 0.34, 0.14, 0.008, 0.034), (1.86, 0.36, 0.23, 0.019, 0.043), (1.78, 0.46, 0.35, 0.034, 0.048),
        (0.89, 0.51, 0.35, 0.036, 0.033), (0.39, 0.50, 0.29, 0.029, 0.018),
    ),
    (4, 18): (
        (1.08, 0.31, 0.09, 0.004, 0.018), (1.32, 0.34, 0.21, 0.019, 0.029), (1.43, 0.45, 0.39, 0.043, 0.039),
        (0.75, 0.54, 0.43, 0.050, 0.030), (0.26, 0.52, 0.36, 0.043, 0.018),
    ),
    (5, 10): (
        (2.89, 0.63, 0.26, 0.014, 0.056), (3.05, 0.68, 0.40, 0.032, 0.071), (3.26, 0.77, 0.59, 0.056, 0.083),
        (1.69, 0.91, 0.59, 0.057, 0.056), (0.97, 1.00, 0.56, 0.053, 0.035),
    ),
    (5, 18): (
        (1.74, 0.53, 0.16, 0.007, 0.027), (2.45, 0.62, 0.36, 0.032, 0.050), (2.35, 0.80, 0.66, 0.070, 0.063),
        (1.41, 0.97, 0.74, 0.084, 0.052), (0.59, 1.04, 0.68, 0.078, 0.033),
    ),
    (6, 10): (
        (3.67, 0.99, 0.41, 0.020, 0.066), (4.34, 1.02, 0.59, 0.039, 0.091), (4.38, 1.04, 0.79, 0.063, 0.102),
        (3.08, 1.38, 0.85, 0.071, 0.082), (2.11, 1.43, 0.78, 0.064, 0.059),
    ),
    (6, 18): (
        (2.30, 1.00, 0.29, 0.011, 0.032), (3.18, 0.89, 0.50, 0.037, 0.061), (3.68, 1.07, 0.88, 0.081, 0.089),
        (2.28, 1.42, 0.99, 0.098, 0.070), (1.38, 1.68, 1.00, 0.099, 0.048),
    ),
}  # fmt: skip
