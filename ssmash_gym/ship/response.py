"""The ship's linear response to regular wave components at forward speed.

The equations of motion stand about O = (centre of buoyancy, centre plane, waterline) in the frame of the hull's
boundary-element database: x forward, y port, z up, ``e^{-i omega_e t}``, with the *signed* encounter frequency
``omega_e = omega - k U cos(heading)``, which is never folded:

    [-omega_e^2 M - T(omega_e) + C] X = F_FK + F_D,    T = omega_e^2 A + i omega_e B.

`HullResponse` solves the longitudinal set (surge, heave, pitch) and the lateral set (sway, roll, yaw) in closed form.
`package_frame` carries the result to the centre of gravity G, to the package's axes (z down) and to ``e^{+i}``: the
one place where the two conventions meet.

Source: Salvesen, Tuck & Faltinsen, Ship motions and sea loads, Trans. SNAME 78 (1970). Against a boundary-element
solution with the forward speed in it (tests/data/forward_speed.json), heave, pitch and roll agree within 17 % at 10 and
18 kn up to 0.6 rad/s.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple, Protocol

import numpy as np
from pydantic import Field

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.fields import NonNegative, Part, Positive
from ssmash_gym.ship.cramer import ComplexArray as ComplexArray
from ssmash_gym.ship.cramer import determinant, solve3
from ssmash_gym.ship.hull import TRIOS, HullDatabase
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.response_input import checked, checked_waves
from ssmash_gym.ship.roll_damping import RollDamping, critical_damping, linearised
from ssmash_gym.ship.sea import encounter

ROLL: Final = 3
UNRESTORED: Final = (0, 1, 5)  # surge, sway, yaw: no restoring force but the soft restraint
TO_PACKAGE: Final = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])  # z up, y port -> z down, y starboard


class Trio(NamedTuple):
    """Three degrees of freedom that a port/starboard-symmetric hull couples; the last one turns the hull.

    At speed the turned hull meets the stream sideways on: pitch then acts as heave does, and yaw as sway does.
    """

    number: int  # in `hull.TRIOS`
    like: int  # which of the three the turning acts like at speed
    sign: float  # of the turning's motion along that one, forward of O

    @property
    def dofs(self) -> slice:
        """Its degrees of freedom."""
        return TRIOS[self.number]


LONGITUDINAL: Final = Trio(0, 1, -1.0)  # surge, heave, pitch: bow down +, heave up +
LATERAL: Final = Trio(1, 0, 1.0)  # sway, roll, yaw: bow to port +, sway to port +


@dataclass(frozen=True, eq=False)
class Response:
    """Response to n wave components.

    Attributes:
        omega_e: Encounter frequency, signed [rad/s], (n,).
        transfer: H (n, 6), complex: with the elevation ``sum a cos(omega_e t + phase)`` (up positive) at G's mean
            place, channel j of G's motion is ``Re sum a H_j exp(i (omega_e t + phase))`` [m/m, rad/m]: surge forward,
            sway to starboard, heave down, roll starboard down, pitch bow up, yaw bow to starboard.
        roll_damping: Share of critical roll damping that was used; NaN where the response is a table.
        converged: Whether its iteration closed in; `HullResponse` warns where it did not.
    """

    omega_e: FloatArray
    transfer: ComplexArray
    roll_damping: float
    converged: bool


class ShipResponse(Protocol):
    """What a ship's motion is made from: the response of G to wave components."""

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
        """Response to regular waves.

        Args:
            omega: Wave frequencies [rad/s], (n,), positive.
            heading: Directions the waves travel relative to the ship's heading [rad], (n,) or one for all: 0
                following, pi / 2 towards starboard, pi head.
            amplitude: Wave amplitudes [m], (n,); they set the roll rate and so the roll damping.
            speed_mps: The ship's speed [m/s], 0 or more.
            roll_damping_factor: Multiplies the roll damping ratio.
            gm_factor: Multiplies the metacentric height; the inertia stays.

        Raises:
            ConfigurationError: A value that is not allowed.
        """
        ...


class Guards(Part):
    """Where linear potential theory has no answer of its own; none of it matters at the frequencies that load a deck.

    Without them the response grows without bound as the encounter frequency goes to zero in following seas.
    """

    encounter_floor_radps: Positive = Field(0.15, description="least |omega_e| in the terms U/omega_e, U^2/omega_e^2")
    restraint_period_s: Positive = Field(120.0, description="of the soft spring on surge, sway, yaw (the helmsman)")
    restraint_damping: NonNegative = Field(0.30, description="of that spring, share of critical")
    high_pass_radps: Positive = Field(0.20, description="r^4/(1+r^4), r = |omega_e| over this, on surge, sway, yaw")


@dataclass(frozen=True)
class Loading:
    """Where the ship's mass is: height of G above the keel and radii of gyration about G (roll, pitch, yaw) [m]."""

    kg_m: float
    radii_m: tuple[float, float, float]


class HullResponse:
    """Response from a hull's zero-speed database, with everything else applied at run time.

    The hull floats on an even keel, so G stands above or below O; products of inertia are neglected.

    Args:
        hull: The database.
        loading: Height of G and radii of gyration.
        damping: Law of the roll damping, on top of the radiation damping of the database (about 0.001 of critical).
        guards: See `Guards`.

    Raises:
        ConfigurationError: G is so high that the ship would not float upright.
    """

    def __init__(
        self, hull: HullDatabase, loading: Loading, damping: RollDamping, guards: Guards | None = None
    ) -> None:
        self.hull = hull
        self.loading = loading
        self.damping = damping
        self.guards = Guards() if guards is None else guards
        if not self.gm_m > 0.0:
            raise ConfigurationError(
                f"hull {hull.name}: kg_m is {loading.kg_m:g}, allowed is less than {loading.kg_m + self.gm_m:.2f} m, "
                "the height of the metacentre: the ship would not float upright"
            )

    @property
    def mass_kg(self) -> float:
        """Displacement [kg]."""
        return self.hull.water_density * self.hull.volume_m3

    @property
    def z_G(self) -> float:
        """Height of G above the waterline [m]."""
        return self.loading.kg_m - self.hull.draught_m

    @property
    def gm_m(self) -> float:
        """Metacentric height [m]: ``z_B + I_T / V - z_G``."""
        return self.hull.z_B + self.hull.I_T / self.hull.volume_m3 - self.z_G

    @cached_property
    def inertia(self) -> FloatArray:
        """Rigid-body inertia about O (6, 6) [kg, kg m, kg m2], x forward, y port, z up."""
        m, z = self.mass_kg, self.z_G
        rxx, ryy, rzz = self.loading.radii_m
        M = np.diag([m, m, m, m * (rxx**2 + z**2), m * (ryy**2 + z**2), m * rzz**2])
        M[0, 4] = M[4, 0] = m * z
        M[1, 3] = M[3, 1] = -m * z
        return M

    @cached_property
    def stiffness(self) -> FloatArray:
        """Hydrostatic stiffness about O (6, 6) [N/m, N, N m]; the soft restraint is not in it."""
        hull, C = self.hull, np.zeros((6, 6))
        weight = self.mass_kg * hull.gravity
        per_metre = hull.water_density * hull.gravity
        C[2, 2] = per_metre * hull.A_wp
        C[2, 4] = C[4, 2] = -per_metre * hull.S_x
        C[3, 3] = weight * self.gm_m
        C[4, 4] = weight * (hull.z_B - self.z_G) + per_metre * hull.I_L
        return C

    @cached_property
    def restraint(self) -> tuple[FloatArray, FloatArray]:
        """Soft spring (6, 6) and damper (6, 6) about O that act on surge, sway and yaw.

        Spring and damper are proportional to the inertia of ship and water, so that they pull where the inertia is
        and neither roll nor pitch the ship: only columns 0, 1 and 5 are filled.
        """
        rate = 2.0 * math.pi / self.guards.restraint_period_s
        inertia = np.zeros((6, 6))
        inertia[:, UNRESTORED] = (self.inertia + self.hull.radiation(np.array([rate]))[0][0])[:, UNRESTORED]
        return rate**2 * inertia, 2.0 * self.guards.restraint_damping * rate * inertia

    @cached_property
    def natural_period_s(self) -> dict[str, float]:
        """Natural periods [s] of heave, roll and pitch, each alone about G, undamped, at zero speed."""
        return {name: 2.0 * math.pi / self._natural(k)[0] for name, k in (("heave", 2), ("roll", ROLL), ("pitch", 4))}

    @cached_property
    def critical_roll_damping(self) -> float:
        """Critical damping of the nominal ship's roll [N m s], whatever the GM factor: unit of the damping ratio."""
        return critical_damping(float(self.stiffness[ROLL, ROLL]), self._natural(ROLL)[1])

    def froude(self, speed_mps: float) -> float:
        """Froude number on the database's length."""
        return speed_mps / math.sqrt(self.hull.gravity * self.hull.length_m)

    def _natural(self, k: int) -> tuple[float, float]:
        """Natural frequency [rad/s] and inertia of one mode alone about G, with the added mass of that frequency."""
        arm = {ROLL: (1, self.z_G), 4: (0, -self.z_G)}.get(
            k
        )  # turning about G moves O sideways or along by arm * angle
        omega, inertia = 0.6, 1.0
        for _ in range(50):
            total = self.inertia + self.hull.radiation(np.array([omega]))[0][0]
            inertia = float(total[k, k])
            if arm is not None:
                j, lever = arm
                inertia += float(2.0 * lever * total[j, k] + lever**2 * total[j, j])
            omega = 0.5 * (omega + math.sqrt(float(self.stiffness[k, k]) / inertia))
        return omega, inertia

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
        """Response of G to regular waves, see `ShipResponse.respond`.

        Raises:
            ConfigurationError: A value that is not allowed.
        """
        omega, heading, amplitude = checked_waves(omega, heading, amplitude)
        speed = checked("speed_mps", speed_mps)
        factor = checked("roll_damping_factor", roll_damping_factor)
        gm = checked("gm_factor", gm_factor, above_zero=True)

        omega_e = encounter(omega, heading, speed, self.hull.gravity)
        radiation = self.hull.radiation_trios(omega_e)
        FK, FD = self.hull.excitation(omega, -heading)
        excitation = FK, FD * self._diffraction_at_speed(omega, omega_e, radiation)
        Z, F = self._equations(LONGITUDINAL, omega, omega_e, speed, radiation, excitation)
        surge, heave, pitch = solve3(Z, F)
        Z, F = self._equations(LATERAL, omega, omega_e, speed, radiation, excitation)
        Z[1, 1] += (gm - 1.0) * self.stiffness[ROLL, ROLL]
        s = np.asarray(-1j * omega_e, dtype=np.complex128)  # d/dt
        zeta, converged = self._damping(Z, F, s, amplitude, self.froude(speed), factor)
        if not converged:
            warnings.warn(
                f"hull {self.hull.name}: the roll damping of this sea was not found to ten digits, {zeta:.4g} of "
                "critical is used",
                ConfigurationWarning,
                stacklevel=2,
            )
        Z[1, 1] += s * (zeta * self.critical_roll_damping)
        sway, roll, yaw = solve3(Z, F)

        X = np.stack([surge, sway, heave, roll, pitch, yaw], axis=1)
        return Response(omega_e, package_frame(X, omega_e, self.z_G, self.guards.high_pass_radps), zeta, converged)

    def _equations(
        self,
        trio: Trio,
        omega: FloatArray,
        omega_e: FloatArray,
        speed: float,
        radiation: FloatArray,
        excitation: tuple[ComplexArray, ComplexArray],
    ) -> tuple[ComplexArray, ComplexArray]:
        """Coefficients (3, 3, n) and right-hand sides (3, n) of one trio about O; x forward, y port, z up.

        Forward speed enters by Ogilvie and Tuck's theorem, as in Salvesen, Tuck & Faltinsen 1970. With
        ``nu = i U / omega_e``, pitch's radiation column gains nu times heave's and its row loses nu times heave's;
        yaw's and sway's the other way round. Written out these are the familiar ``A35 = A35_0 - U B33 / omega_e^2``,
        ``B35 = B35_0 + U A33`` and so on. The row holds for diffraction, too.
        """
        A, B = radiation[:, trio.number]
        FK, FD = (np.ascontiguousarray(part[:, trio.dofs].T) for part in excitation)
        square = omega_e * omega_e
        T = square * A + 1j * omega_e * B
        held = np.copysign(np.maximum(np.abs(omega_e), self.guards.encounter_floor_radps), omega_e)
        nu = -trio.sign * 1j * speed / held
        T[:, 2] += nu * T[:, trio.like]
        T[2] -= nu * T[trio.like]
        FD[2] -= nu * FD[trio.like]
        Z = self._trio(self.stiffness + self.restraint[0], trio) - square * self._trio(self.inertia, trio)
        return Z - 1j * omega_e * self._trio(self.restraint[1], trio) - T, FK + FD

    def _diffraction_at_speed(self, omega: FloatArray, omega_e: FloatArray, radiation: FloatArray) -> ComplexArray:
        """Factor (n, 6) on the zero-speed diffraction force of each mode.

        The wave drives the diffracted flow at the wave frequency, but that flow radiates, and its pressure varies, at
        the encounter frequency. By Haskind's relation the force in a mode is made from the potential of radiation in
        that mode at the encounter frequency (as in Salvesen, Tuck & Faltinsen's sectional forces), so it grows as the
        mode's own radiation impedance ``omega A + i B`` does between the two frequencies. 1 at zero speed.
        """
        each = np.arange(3)
        A, B = radiation[:, :, each, each]
        A_w, B_w = self.hull.own_radiation(omega)
        ratio = (omega_e * A + 1j * B) / (omega * A_w + 1j * B_w)
        return np.asarray(ratio.transpose(2, 1, 0).reshape(-1, 6), dtype=np.complex128)  # the trios interlace

    @staticmethod
    def _trio(matrix: FloatArray, trio: Trio) -> FloatArray:
        return matrix[trio.dofs, trio.dofs, np.newaxis]

    def _damping(
        self,
        Z: ComplexArray,
        F: ComplexArray,
        s: ComplexArray,
        amplitude: FloatArray,
        froude: float,
        factor: float,
    ) -> tuple[float, bool]:
        """Damping ratio that agrees with the roll rate of these waves, and whether the iteration closed in.

        Roll damping enters one coefficient only, so by Cramer's rule roll is ``N / (D + b s M)`` with its numerator
        N, the determinant D and the minor M free of the damping b: each iteration costs a few array operations.
        """
        numerator = determinant(np.stack([Z[:, 0], F, Z[:, 2]], axis=1))
        minor = Z[0, 0] * Z[2, 2] - Z[0, 2] * Z[2, 0]
        still, moving = determinant(Z), s * minor * self.critical_roll_damping
        power = 0.5 * squared(s * numerator * amplitude)
        constant, linear, square = squared(still), 2.0 * (still * np.conj(moving)).real, squared(moving)
        sqrt_l_over_g = math.sqrt(self.hull.length_m / self.hull.gravity)

        def sigma(ratio: float) -> float:
            return math.sqrt(float(np.sum(power / (constant + ratio * (linear + ratio * square)))))

        return linearised(lambda rms: factor * self.damping.ratio(froude, rms, sqrt_l_over_g), sigma)


def package_frame(X: ComplexArray, omega_e: FloatArray, z_G: float, high_pass_radps: float) -> ComplexArray:
    """From motions of O in the database's frame to motions of G in the package's: the one place.

    G stands z_G above O; then the axes turn (y to starboard, z down), ``e^{-i}`` becomes ``e^{+i}`` (the conjugate),
    and surge, sway and yaw lose what is slower than the high-pass frequency.

    Args:
        X: Motions of O, (n, 6), complex [m/m, rad/m], x forward, y port, z up, ``e^{-i omega_e t}``.
        omega_e: Signed encounter frequency [rad/s], (n,).
        z_G: Height of G above O [m].
        high_pass_radps: Frequency of the high-pass [rad/s].

    Returns:
        Transfer function of `Response`, (n, 6).
    """
    G = X.copy()
    G[:, 0] += z_G * X[:, 4]
    G[:, 1] -= z_G * X[:, 3]
    r4 = (omega_e / high_pass_radps) ** 4
    H = np.conj(G) * TO_PACKAGE
    H[:, UNRESTORED] *= (r4 / (1.0 + r4))[:, np.newaxis]
    return np.asarray(H, dtype=np.complex128)


def squared(value: ComplexArray) -> FloatArray:
    """Squared magnitudes, any shape."""
    return np.asarray(value.real * value.real + value.imag * value.imag, dtype=np.float64)
