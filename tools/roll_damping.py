"""Roll damping of the frigate-like hull by the simplified Ikeda method (Kawahara et al. 2009), and a law fitted to it.

Prints the components of the equivalent linear damping as shares of critical, for three speeds and three amplitudes,
and the coefficients ``z0, z_speed, z_rate`` of `ssmash_gym.ship.roll_damping.RollDamping` that go into
configs/ships/frigate.yaml. Needs the package rolldecay-estimators, which ssmash_gym itself never imports:

    pip install rolldecay-estimators==0.6.0
    python tools/roll_damping.py

What is assumed: bilge keels of 0.3 L x 0.6 m, and a midship coefficient of 0.82 (the hull's own is 0.80, that of the
public hull DTMB 5415 is 0.816; the method was made for 0.90 to 0.99). Hull lift is where this matters: the library
continues a cubic fit of Ikeda's coefficient K over the midship coefficient far outside its data, to K = 1.4, while
Ikeda's own table (Himeno 1981; ITTC 7.5-02-07-04.5) has K = 0 up to 0.92, 0.1 up to 0.97 and 0.3 up to 0.99. The law
keeps the larger lift, by judgement, as standing for rudders, skeg and shaft brackets, which the method does not count.
The last lines print the hull lift with Ikeda's own K, and the law that would follow from it.
"""

from __future__ import annotations

import argparse
import importlib.util
import math
import sys
from typing import Any, Final

import numpy as np
import scipy.integrate
from numpy.typing import NDArray

SPEEDS_KN: Final = (0.0, 10.0, 18.0)
AMPLITUDES_DEG: Final = (2.0, 5.0, 10.0)
COMPONENTS: Final = ("total", "friction", "wave", "eddy", "bilge keels", "lift")
KNOT: Final = 1852.0 / 3600.0
KEEL_LENGTH: Final = 0.3  # over the ship's length, assumed
KEEL_BREADTH_M: Final = 0.6  # assumed
IKEDA_K: Final = 0.0  # hull lift, midship coefficient up to 0.92 (Himeno 1981; ITTC 7.5-02-07-04.5)
LIFT: Final = COMPONENTS.index("lift")
MISSING: Final = (
    "tools/roll_damping.py needs the package rolldecay-estimators, which is not installed: "
    "pip install rolldecay-estimators==0.6.0"
)


def library() -> Any:
    """The module with the method's formulas, made to work with a SciPy that has no ``simps`` any more."""
    if not hasattr(scipy.integrate, "simps"):
        scipy.integrate.simps = scipy.integrate.simpson
    from rolldecayestimators import simplified_ikeda

    return simplified_ikeda


def components(ship: Any, speed_mps: float, amplitude_deg: float, midship: float) -> NDArray[np.float64]:
    """Shares of critical damping (6,), in the order of `COMPONENTS`, at the ship's natural roll period."""
    response = ship.response
    hull, omega = response.hull, 2.0 * math.pi / response.natural_period_s["roll"]
    block = hull.volume_m3 / (hull.length_m * hull.beam_m * hull.draught_m)
    parts = library().calculate_roll_damping(
        LPP=hull.length_m,
        Beam=hull.beam_m,
        CB=block,
        CMID=midship,
        OG=-response.z_G,
        PHI=amplitude_deg,
        BKL=KEEL_LENGTH * hull.length_m,
        BKB=KEEL_BREADTH_M,
        OMEGA=omega,
        DRAFT=hull.draught_m,
        V=speed_mps,
        verify_input=False,
        rho=hull.water_density,
    )
    dimension = hull.water_density * hull.volume_m3 * hull.beam_m**2 / math.sqrt(hull.beam_m / (2.0 * hull.gravity))
    return np.array([float(np.squeeze(part)) for part in parts]) * dimension / response.critical_roll_damping


def lift_by_ikeda(ship: Any, speed_mps: float) -> float:
    """Hull lift with Ikeda's own coefficient, as a share of critical damping."""
    response = ship.response
    hull, depth = response.hull, response.hull.draught_m
    slope = 2.0 * math.pi * depth / hull.length_m + IKEDA_K * (4.1 * hull.beam_m / hull.length_m - 0.045)
    l_0, l_R, below = 0.3 * depth, 0.5 * depth, -response.z_G
    arm = l_0 * l_R * (1.0 - 1.4 * below / l_R + 0.7 * below**2 / (l_0 * l_R))
    damping = 0.5 * hull.water_density * speed_mps * hull.length_m * depth * slope * arm
    return damping / response.critical_roll_damping


def fitted(ship: Any, totals: NDArray[np.float64]) -> NDArray[np.float64]:
    """``z0, z_speed, z_rate`` (3,) by least squares over all speeds and amplitudes.

    A quadratic damping is worth ``8 / (3 pi)`` times the amplitude of the roll rate in regular rolling, which is what
    ``sqrt(8 / pi)`` times its RMS is in irregular rolling.
    """
    response = ship.response
    omega, root = (
        2.0 * math.pi / response.natural_period_s["roll"],
        math.sqrt(response.hull.length_m / response.hull.gravity),
    )
    rows = [
        [1.0, response.froude(knots * KNOT), 8.0 / (3.0 * math.pi) * omega * math.radians(amplitude) * root]
        for knots in SPEEDS_KN
        for amplitude in AMPLITUDES_DEG
    ]
    return np.asarray(np.linalg.lstsq(np.array(rows), totals.ravel(), rcond=None)[0])


def main() -> int:
    """Print the table and the coefficients."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ship", default="frigate", help="name or file of the ship")
    parser.add_argument("--midship", type=float, default=0.82, help="midship coefficient for the method")
    arguments = parser.parse_args()
    if importlib.util.find_spec("rolldecayestimators") is None:
        sys.exit(MISSING)
    from ssmash_gym.errors import ConfigurationError
    from ssmash_gym.ship.response import HullResponse
    from ssmash_gym.ship.ships import load_ship

    try:
        ship = load_ship(arguments.ship)
    except ConfigurationError as error:
        sys.exit(f"--ship: {error}")
    if not isinstance(ship.response, HullResponse):
        sys.exit(f"--ship {arguments.ship} is refused: it has a table of responses, the method needs a hull.")
    print(ship.summary())
    report(ship, arguments.midship)
    return 0


def report(ship: Any, midship: float) -> None:
    """Print the components beside the law, its coefficients, and both with Ikeda's own lift."""
    print("\n| kn | amplitude deg | " + " | ".join(COMPONENTS) + " | law |\n|" + "---|" * (3 + len(COMPONENTS)))
    table = np.array([[components(ship, kn * KNOT, a, midship) for a in AMPLITUDES_DEG] for kn in SPEEDS_KN])
    z = fitted(ship, table[..., 0])
    omega, hull = 2.0 * math.pi / ship.response.natural_period_s["roll"], ship.response.hull
    for i, kn in enumerate(SPEEDS_KN):
        for j, amplitude in enumerate(AMPLITUDES_DEG):
            rate = 8.0 / (3.0 * math.pi) * omega * math.radians(amplitude) * math.sqrt(hull.length_m / hull.gravity)
            law = z[0] + z[1] * ship.response.froude(kn * KNOT) + z[2] * rate
            cells = " | ".join(f"{value:.4f}" for value in table[i, j])
            print(f"| {kn:g} | {amplitude:g} | {cells} | {law:.4f} |")
    print(f"\nz0: {z[0]:.4f}, z_speed: {z[1]:.4f}, z_rate: {z[2]:.4f}")
    lift = np.array([[lift_by_ikeda(ship, kn * KNOT)] for kn in SPEEDS_KN])
    for kn, share in zip(SPEEDS_KN[1:], lift[1:, 0], strict=True):
        print(f"hull lift at {kn:g} kn with Ikeda's K = {IKEDA_K:g}: {share:.4f}")
    z = fitted(ship, table[..., 0] - table[..., LIFT] + lift)
    print(f"the law with that lift: z0: {z[0]:.4f}, z_speed: {z[1]:.4f}, z_rate: {z[2]:.4f}")


if __name__ == "__main__":
    sys.exit(main())
