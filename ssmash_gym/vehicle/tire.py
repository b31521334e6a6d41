"""A tire (appendix A, lines 56-61)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from ssmash_gym.fields import NonNegative, Number, Part, Positive, Vector, refuse


class LinearTire(Part):
    """Constants of the linear spring-damper tire, the alternative to Smiley and Horne's equations."""

    vertical_stiffness_Npm: Positive = Field(description="Vertical stiffness [N/m]")
    longitudinal_stiffness_Npm: Positive = Field(description="Longitudinal stiffness of a locked wheel, K_x [N/m]")
    lateral_stiffness_Npm: Positive = Field(description="Lateral stiffness, K_y [N/m]")
    twist_stiffness_Nmprad: Positive = Field(description="Torsional stiffness, K_psi [N m/rad]")
    relaxation_length_m: Positive = Field(description="Relaxation length of lateral deflection and twist, sigma [m]")


class Tire(Part):
    """One tire. Its damping and friction serve both tire models."""

    position_m: Vector = Field(description="Tire centre from the carriage's c.g., W axes, r_WT (columns 1-3) [m]")
    diameter_m: Positive = Field(description="Unloaded diameter, d_t (column 4) [m]")
    width_m: Positive = Field(description="Nominal width, w_t (column 5) [m]")
    axle_radius_m: NonNegative = Field(description="Axle radius, r_axle (column 6) [m]")
    pressure_Pa: Positive = Field(description="Inflation pressure unloaded, gauge, P_o (column 7) [Pa]")
    rated_pressure_Pa: Positive = Field(description="Rated inflation pressure, gauge, P_r (column 8) [Pa]")
    type: Literal["I", "III", "VII"] = Field(description="Standard type designation (column 9)")
    friction_coefficient: NonNegative = Field(description="Greatest friction with the deck, mu (column 10) [1]")
    rolling_resistance: NonNegative = Field(description="Rolling resistance coefficient, mu_rr (column 11) [1]")
    axle_friction: NonNegative = Field(description="Axle friction coefficient, mu_axle (column 12) [1]")
    vertical_constant: Positive = Field(description="Vertical deflection constant, C_tz (column 13) [1]")
    damping_x_Nspm: NonNegative = Field(description="Longitudinal damping, C_x (column 14) [N s/m]")
    damping_y_Nspm: NonNegative = Field(description="Lateral damping, C_y (column 15) [N s/m]")
    damping_z_Nspm: NonNegative = Field(description="Vertical damping, C_z (column 16) [N s/m]")
    rolling_decay_spm: Positive = Field(description="Decay constant of rolling and axle friction, beta [s/m]")
    minimum_relaxation_m: Positive = Field(
        description="Least relaxation length of the lateral deflection, sigma_min [m]"
    )
    bottoming_deflection_m: Positive = Field(description="Vertical deflection at which the rim is reached [m]")
    bottoming_stiffness_Npm: NonNegative = Field(description="Vertical stiffness added beyond that [N/m]")
    pull_back_rate_ps: Positive = Field(
        description="Rate at which deflections return to the friction limit, k_pull [1/s]"
    )
    pitch_moment_coefficient: Number = Field(
        description="Signed coefficient of M_y = c d_x F_z on a locked wheel, (2.159) [1]"
    )
    linear: LinearTire | None = Field(
        default=None, description="Constants of the linear tire model, if it is to be used"
    )

    @model_validator(mode="after")
    def _sound(self) -> Tire:
        radius = 0.5 * self.diameter_m
        if self.axle_radius_m >= radius:
            raise refuse("axle_radius_m", self.axle_radius_m, f"it must be less than the tire radius {radius:g} m")
        if self.bottoming_deflection_m >= radius:
            raise refuse(
                "bottoming_deflection_m",
                self.bottoming_deflection_m,
                f"it must be less than the tire radius {radius:g} m",
            )
        return self
