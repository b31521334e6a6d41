"""Force-generating elements of a suspension: gas oleo (appendix A, lines 66-68), linear strut (63-65), end stop."""

from __future__ import annotations

import warnings
from typing import Final, Literal

from pydantic import Field, model_validator

from ssmash_gym.errors import ConfigurationWarning
from ssmash_gym.fields import NonNegative, Number, Part, Positive, refuse

SMOOTH_TOLERANCE: Final = 1.0e-3  # of the slope, for calling two regions continuously differentiable


class EndStop(Part):
    """Where the stroke ends, and what stops it. The thesis has none; without it nothing bounds the travel."""

    stroke_m: Positive = Field(description="Greatest compression from full droop, end stop reached [m]")
    stiffness_Npm: Positive = Field(description="Stiffness of the end stop [N/m]")
    damping_Nspm: NonNegative = Field(description="Damping of the end stop [N s/m]")


class LinearStrut(Part):
    """Linear spring and damper between full droop and the end stop (appendix A, lines 63-65)."""

    type: Literal["linear_strut"] = "linear_strut"
    stiffness_Npm: Positive = Field(description="Spring rate, 0 N at full droop [N/m]")
    damping_Nspm: NonNegative = Field(description="Damping rate [N s/m]")


class GasOleo(Part):
    """Gas oleo with five spring regions, staged damping, seal and bearing friction (appendix A, lines 66-68).

    Region 2 (up to ``x0``) and region 3 (up to ``x1``) follow from the gas. Regions 4 and 5 are cubics; where
    their first slope is not given (null) it is the one that makes the curve continuously differentiable.
    """

    type: Literal["gas_oleo"] = "gas_oleo"
    x0_m: Positive = Field(description="End of region 2, x_0 (column 1) [m]")
    x1_m: Positive = Field(description="End of region 3, x_1 (column 2) [m]")
    x2_m: Positive = Field(description="End of region 4, x_2 (column 3) [m]")
    extension_stiffness_Npm: Positive = Field(description="Spring rate past full droop, k (column 4) [N/m]")
    gas_pressure_Pa: Positive = Field(description="Gas pressure at full droop, absolute, P (column 5) [Pa]")
    gas_volume_m3: Positive = Field(description="Gas volume at full droop, V (column 6) [m3]")
    piston_area_m2: Positive = Field(description="Piston area, A (column 7) [m2]")
    gas_exponent: Positive = Field(description="Polytropic exponent of the gas, gamma (column 8) [1]")
    reference_pressure_Pa: NonNegative = Field(
        default=0.0, description="Pressure outside the piston, subtracted from the gas pressure; 0 in the thesis [Pa]"
    )
    e1_Npm: NonNegative | None = Field(default=None, description="Slope of region 4 at x_1, e_1 (column 9) [N/m]")
    e2_Npm: NonNegative | None = Field(default=None, description="Slope of region 5 at x_2, e_2 (column 10) [N/m]")
    f1_Npm2: Number = Field(default=0.0, description="Quadratic constant of region 4, f_1 (column 11) [N/m2]")
    f2_Npm2: Number = Field(default=0.0, description="Quadratic constant of region 5, f_2 (column 12) [N/m2]")
    g1_Npm3: Number = Field(default=0.0, description="Cubic constant of region 4, g_1 (column 13) [N/m3]")
    g2_Npm3: Number = Field(default=0.0, description="Cubic constant of region 5, g_2 (column 14) [N/m3]")
    c01_N: NonNegative = Field(default=0.0, description="Extension damping, constant c_0,1 (column 15) [N]")
    c02_Nspm: NonNegative = Field(description="Extension damping, linear c_0,2 (column 16) [N s/m]")
    c03_Ns2pm2: NonNegative = Field(description="Extension damping, quadratic c_0,3 (column 17) [N s2/m2]")
    c1_N: NonNegative = Field(default=0.0, description="First compression curve, constant c_1 (column 18) [N]")
    c2_Nspm: NonNegative = Field(description="First compression curve, linear c_2 (column 19) [N s/m]")
    c3_Ns2pm2: NonNegative = Field(description="First compression curve, quadratic c_3 (column 20) [N s2/m2]")
    c4_N: Number = Field(default=0.0, description="Second compression curve, constant c_4 (column 21) [N]")
    c5_Nspm: NonNegative = Field(default=0.0, description="Second compression curve, linear c_5 (column 22) [N s/m]")
    c6_Ns2pm2: NonNegative = Field(
        default=0.0, description="Second compression curve, quadratic c_6 (column 23) [N s2/m2]"
    )
    c7_N: Number = Field(default=0.0, description="Third compression curve, constant c_7 (column 24) [N]")
    c8_Nspm: NonNegative = Field(default=0.0, description="Third compression curve, linear c_8 (column 25) [N s/m]")
    c9_Ns2pm2: NonNegative = Field(
        default=0.0, description="Third compression curve, quadratic c_9 (column 26) [N s2/m2]"
    )
    relief_1_N: Positive = Field(
        default=1.0e9, description="First damping relief force, F_d,rel1; large means never (column 27) [N]"
    )
    relief_2_N: Positive = Field(
        default=1.0e9, description="Second damping relief force, F_d,rel2; large means never (column 28) [N]"
    )
    seal_drag_N: NonNegative = Field(description="Seal drag, F_seal (column 29) [N]")
    bearing_z_m: Number = Field(
        description="Lower shaft bearing from the oleo origin along o_z, r_Ob1 (column 30); unused on a swing arm [m]"
    )
    bearing_separation_m: Positive = Field(
        description="Distance of the shaft bearings at full droop, l_b20 (column 31); unused on a swing arm [m]"
    )
    bearing_friction: NonNegative = Field(
        description="Friction coefficient of the bearings, mu_bearing (column 32); unused on a swing arm [1]"
    )
    friction_decay_spm: Positive = Field(
        description="Decay constant of the friction's smoothing, beta (column 33) [s/m]"
    )

    def gas_force(self, x: float) -> tuple[float, float]:
        """Force of region 3 and its slope at compression ``x`` [N], [N/m], (2.208), (2.209)."""
        left = 1.0 - self.piston_area_m2 * x / self.gas_volume_m3
        gas = self.gas_pressure_Pa * self.piston_area_m2 * left**-self.gas_exponent
        slope = gas * self.gas_exponent * self.piston_area_m2 / (self.gas_volume_m3 * left)
        return gas - self.reference_pressure_Pa * self.piston_area_m2, slope

    @property
    def region4(self) -> tuple[float, float, float]:
        """Constants e, f, g of region 4 [N/m], [N/m2], [N/m3]."""
        e = self.gas_force(self.x1_m)[1] if self.e1_Npm is None else self.e1_Npm
        return e, self.f1_Npm2, self.g1_Npm3

    @property
    def region5(self) -> tuple[float, float, float]:
        """Constants e, f, g of region 5 [N/m], [N/m2], [N/m3]."""
        e = cubic_slope(self.region4, self.x2_m - self.x1_m) if self.e2_Npm is None else self.e2_Npm
        return e, self.f2_Npm2, self.g2_Npm3

    @model_validator(mode="after")
    def _sound(self) -> GasOleo:
        exhausted = self.gas_volume_m3 / self.piston_area_m2
        if self.x1_m >= exhausted:
            raise refuse(
                "x1_m", self.x1_m, f"region 3 must end before the gas volume is exhausted, at V/A = {exhausted:.6g} m"
            )
        if self.x0_m >= self.x1_m:
            raise refuse("x0_m", self.x0_m, f"it must be less than x1_m = {self.x1_m:g} m")
        if self.x2_m < self.x1_m:
            raise refuse("x2_m", self.x2_m, f"it must be at least x1_m = {self.x1_m:g} m")
        if self.relief_2_N < self.relief_1_N:
            raise refuse("relief_2_N", self.relief_2_N, f"it must be at least relief_1_N = {self.relief_1_N:g} N")
        self._warn_of_kinks()
        return self

    def _warn_of_kinks(self) -> None:
        smooth = (
            ("e1_Npm", "x1_m", self.region4[0], self.gas_force(self.x1_m)[1]),
            ("e2_Npm", "x2_m", self.region5[0], cubic_slope(self.region4, self.x2_m - self.x1_m)),
        )
        for key, where, given, wanted in smooth:
            if abs(given - wanted) > SMOOTH_TOLERANCE * max(abs(given), abs(wanted)):
                warnings.warn(
                    f"{key} = {given:.6g} N/m puts a kink into the oleo spring at {where}: the slope before it is "
                    f"{wanted:.6g} N/m (null takes that one)",
                    ConfigurationWarning,
                    stacklevel=2,
                )


def cubic_slope(constants: tuple[float, float, float], d: float) -> float:
    """Slope of ``e d + f d^2 + g d^3`` [N/m]."""
    e, f, g = constants
    return e + 2.0 * f * d + 3.0 * g * d * d
