"""The securing probe (appendix A, lines 40-55)."""

from __future__ import annotations

from typing import Final

from pydantic import Field, StrictBool, model_validator

from ssmash_gym.fields import NonNegative, Part, Positive, Vector, refuse

LEAST_STEEPNESS: Final = 0.1  # least share of the probe's length that must point down


class Probe(Part):
    """The probe under the belly, and how it yields when the claw holds it."""

    active: StrictBool = Field(description="Whether the probe acts (line 40)")
    captured: StrictBool = Field(description="Whether the claw holds it at the start (line 41)")
    mount_m: Vector = Field(description="Point a where the probe is mounted, H axes, r_Ha (line 42) [m]")
    vector_m: Vector = Field(description="From the mount to the undeflected tip c, H axes, r_ac (line 43) [m]")
    small_stiffness_x_Npm: Positive = Field(description="Stiffness at small displacement, K_PS,x (line 44) [N/m]")
    small_stiffness_y_Npm: Positive = Field(description="Stiffness at small displacement, K_PS,y (line 45) [N/m]")
    large_stiffness_x_Npm: Positive = Field(description="Stiffness at large displacement, K_PL,x (line 46) [N/m]")
    large_stiffness_y_Npm: Positive = Field(description="Stiffness at large displacement, K_PL,y (line 47) [N/m]")
    transition_x_m: Positive = Field(description="Displacement between the two, D_PS,x (line 48) [m]")
    transition_y_m: Positive = Field(description="Displacement between the two, D_PS,y (line 49) [m]")
    damping_x_Nspm: NonNegative = Field(description="Damping, C_Px (line 50) [N s/m]")
    damping_y_Nspm: NonNegative = Field(description="Damping, C_Py (line 51) [N s/m]")
    damping_z_Nspm: NonNegative = Field(description="Axial damping, C_Pz (line 52) [N s/m]")
    transition_z_m: Positive = Field(description="Extension between the axial stiffnesses, D_PS,z (line 53) [m]")
    small_stiffness_z_Npm: NonNegative = Field(description="Axial stiffness at small extension, K_PS,z (line 54) [N/m]")
    large_stiffness_z_Npm: NonNegative = Field(description="Axial stiffness at large extension, K_PL,z (line 55) [N/m]")
    capture_radius_m: Positive = Field(description="Distance from the claw centre within which the claw captures [m]")
    ultimate_load_N: Positive = Field(description="Resultant load above which the probe is lost [N]")

    @model_validator(mode="after")
    def _points_down(self) -> Probe:
        x, y, z = self.vector_m
        length = (x * x + y * y + z * z) ** 0.5
        if z < LEAST_STEEPNESS * length or length == 0.0:
            raise refuse(
                "vector_m",
                self.vector_m,
                f"the probe must point down to the deck: its z component must be at least {LEAST_STEEPNESS:g} of its "
                "length, else it lies parallel to the deck",
            )
        return self
