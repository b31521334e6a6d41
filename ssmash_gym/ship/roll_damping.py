"""Roll damping: a law for the equivalent linear damping ratio, and its stochastic linearisation.

A ship's roll is damped by bilge keels, hull lift at speed, eddies, friction and waves, mostly in proportion to speed
or to the roll rate itself. The law gathers them into a share of critical damping,

    zeta4 = z0 + z_speed Fn + z_rate sqrt(8 / pi) sigma_phidot sqrt(L / g),

with the Froude number ``Fn = U / sqrt(g L)`` and the root mean square of the roll rate ``sigma_phidot``. All three
coefficients are free of dimensions, so a ship and its Froude-scaled copy share them. ``sqrt(8 / pi) sigma`` replaces
the quadratic term of a Gaussian roll rate by the linear one that dissipates as much power (stochastic linearisation).

Sources: the components' formulas, Ikeda, Himeno & Tanaka 1978 and ITTC 7.5-02-07-04.5; the linearisation, e.g. Kaplan
1966. The coefficients of a ship stand in its file in ``configs/ships``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from pydantic import Field

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.fields import NonNegative, Part

GAUSSIAN: Final = math.sqrt(8.0 / math.pi)  # E|x|^3 / E x^2 of a Gaussian, in units of its standard deviation
ITERATIONS: Final = 60  # the slowest case, purely quadratic damping, halves its error each time
TOLERANCE: Final = 1.0e-10  # relative, of the damping ratio


class RollDamping(Part):
    """Coefficients of the law of the equivalent linear damping ratio (share of critical; no dimensions)."""

    z0: NonNegative = Field(description="at rest and for small rolling")
    z_speed: NonNegative = Field(description="per unit of Froude number")
    z_rate: NonNegative = Field(description="per unit of sqrt(8/pi) times the RMS of the roll rate times sqrt(L/g)")

    def ratio(self, froude: float, sigma_rate: float, sqrt_l_over_g: float) -> float:
        """Equivalent linear damping ratio, a share of critical damping.

        Args:
            froude: Froude number on the ship's length.
            sigma_rate: RMS of the roll rate [rad/s].
            sqrt_l_over_g: ``sqrt(L / g)`` of the ship [s].
        """
        return self.z0 + self.z_speed * froude + self.z_rate * GAUSSIAN * sigma_rate * sqrt_l_over_g


def critical_damping(stiffness: float, inertia: float) -> float:
    """Damping coefficient of the aperiodic limit, ``2 sqrt(C44 (M44 + A44))`` [N m s].

    Args:
        stiffness: C44 [N m].
        inertia: M44 + A44 [kg m2].

    Raises:
        ConfigurationError: The stiffness is not positive: the ship would not float upright.
    """
    if not stiffness > 0.0:
        raise ConfigurationError(f"roll stiffness is {stiffness:g} N m, allowed is more than 0: raise GM or lower KG")
    return 2.0 * math.sqrt(stiffness * inertia)


def linearised(ratio_of: Callable[[float], float], sigma_of: Callable[[float], float]) -> tuple[float, bool]:
    """The damping ratio that agrees with the rolling it leaves, by fixed-point iteration.

    The rate falls with the damping and the damping grows with the rate, so there is exactly one such ratio, and the
    iteration closes in on it from both sides.

    Args:
        ratio_of: Damping ratio of an RMS roll rate [rad/s].
        sigma_of: RMS roll rate [rad/s] that a damping ratio leaves.

    Returns:
        The ratio, and whether the last step changed it by less than 1e-10 of itself.
    """
    ratio = ratio_of(0.0)
    for _ in range(ITERATIONS):
        previous = ratio
        ratio = ratio_of(sigma_of(previous))
        if abs(ratio - previous) <= TOLERANCE * ratio:
            return ratio, True
    return ratio, False
