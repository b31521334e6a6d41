"""A suspension station: carriage, mount, spring element, tires (appendix A, lines 5-36 and 56-68)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ssmash_gym.fields import EulerParameters, Inertia, NonNegative, Part, Positive, Vector, refuse
from ssmash_gym.vehicle.checks import check_oleo, check_swing_arm
from ssmash_gym.vehicle.oleo import EndStop, GasOleo, LinearStrut
from ssmash_gym.vehicle.tire import Tire


class SwingArm(Part):
    """Where the spring element of a swing arm is mounted."""

    helicopter_point_m: Vector = Field(description="Mount on the helicopter, H axes, r_HP1 (lines 26-28) [m]")
    arm_point_m: Vector = Field(description="Mount on the arm, O axes, r_OP2 (lines 29-31) [m]")


class Station(Part):
    """One suspension station.

    Frame O sits at the mount: a prismatic station slides along ``o_z`` and steers about it, a swing arm turns
    about ``o_y``. Frame W sits at the carriage's c.g. and is parallel to O.
    """

    kind: Literal["prismatic", "swing_arm"] = Field(description="Suspension type (line 32)")
    steering: Literal["locked", "free"] = Field(description="Steering lock (line 33)")
    rolling: Literal["locked", "free"] = Field(description="Rolling lock of the axle (line 34)")
    mass_kg: Positive = Field(description="Mass of the wheel carriage, m_W (lines 5, 9, 13) [kg]")
    inertia_kgm2: Inertia = Field(
        description="Inertia tensor of the carriage about its c.g., W axes, I_W (lines 6-8, 10-12, 14-16) [kg m2]"
    )
    mount_m: Vector = Field(description="Mounting point, H axes, r_HO (lines 17-19) [m]")
    droop_m: Vector = Field(
        description="From the mount to the carriage's c.g. at full droop, O axes, r_OW (lines 20-22) [m]"
    )
    orientation: EulerParameters = Field(description="Euler parameters O to H at full droop (lines 23-25) [1]")
    arm: SwingArm | None = Field(default=None, description="Mounts of the spring element; a swing arm alone has them")
    steer_friction_m: NonNegative = Field(
        description="Effective steer friction coefficient, mu_steer,eff (line 35) [m]"
    )
    steer_damping_Nmspr: NonNegative = Field(description="Steer damping (line 36) [N m s/rad]")
    steer_decay_spr: Positive = Field(description="Decay constant of the steer friction, beta [s/rad]")
    spring: Annotated[GasOleo | LinearStrut, Field(discriminator="type")] = Field(
        description="Force-generating element (lines 62-68)"
    )
    end_stop: EndStop = Field(description="End of the stroke")
    tires: Annotated[tuple[Tire, ...], Field(min_length=1, max_length=2)] = Field(
        description="One tire or two (lines 56-61)"
    )

    @model_validator(mode="after")
    def _sound(self) -> Station:
        if self.kind == "swing_arm":
            if self.steering == "free":
                raise refuse(
                    "steering",
                    self.steering,
                    "a swing arm must have its steering locked, turning about both axes has no consistent geometry",
                )
            if self.arm is None:
                raise refuse("arm", None, "a swing arm needs the two mounts of its spring element")
            check_swing_arm(self)
        elif self.arm is not None:
            raise refuse("kind", self.kind, "only a swing_arm may have an arm; leave the key arm out")
        elif self.droop_m[2] <= 0.0:
            raise refuse(
                "droop_m", self.droop_m, "the carriage must lie below the mount: its z component must be positive"
            )
        if isinstance(self.spring, GasOleo):
            check_oleo(self.spring, self.end_stop.stroke_m)
        return self
