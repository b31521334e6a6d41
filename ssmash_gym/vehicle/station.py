"""A suspension station: carriage, mount, spring element, tires (appendix A, lines 5-36 and 56-68)."""

from __future__ import annotations

import math
from typing import Annotated, Final, Literal

from pydantic import Field, model_validator

from ssmash_gym.fields import EulerParameters, Inertia, NonNegative, Part, Positive, Vector, refuse
from ssmash_gym.vehicle.checks import check_oleo, check_swing_arm
from ssmash_gym.vehicle.oleo import EndStop, GasOleo, LinearStrut
from ssmash_gym.vehicle.tire import Tire

WIDEST_PLAY_RAD: Final = 0.35  # 20 deg: the kernel's angle is 1 % too large there
FASTEST_STOP_RADPS: Final = 250.0  # of the carriage against the stop of its play: 0.5 / substep at 2 ms
LEAST_STOP_DAMPING: Final = 0.05  # of that oscillation, over the critical one
ROUNDING: Final = 1.0e-9  # of the two limits


class SwingArm(Part):
    """Where the spring element of a swing arm is mounted."""

    helicopter_point_m: Vector = Field(description="Mount on the helicopter, H axes, r_HP1 (lines 26-28) [m]")
    arm_point_m: Vector = Field(description="Mount on the arm, O axes, r_OP2 (lines 29-31) [m]")


class SteerPlay(Part):
    """Free play of a locked steering: the wheels turn freely within it, against a spring and a damper beyond.

    Friction and damping about the steer axis act as in a free steering. The explicit fixed step feeds an undamped
    oscillation of the wheels against the stop, the more the higher its circular frequency is: of a wheel in the air,
    without any friction, the rate grows by a third to twofold in 4 s at 125 rad/s and 2 ms, and without bound at 250
    rad/s. With 5 % of the critical damping it dies away at both. A station therefore refuses a stop beyond
    `FASTEST_STOP_RADPS` or with less than `LEAST_STOP_DAMPING`. At a substep beyond 2 ms the frequency must be lower,
    0.5 / substep; nothing checks that.
    """

    play_rad: Annotated[NonNegative, Field(le=WIDEST_PLAY_RAD)] = Field(
        description="Free play to either side of the lock [rad]"
    )
    stop_stiffness_Nmprad: Positive = Field(description="Stiffness of the lock beyond the play [N m/rad]")
    stop_damping_Nmspr: NonNegative = Field(description="Damping of the lock beyond the play [N m s/rad]")


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
    steer_play: SteerPlay | None = Field(
        default=None, description="Free play about the lock; for a prismatic station with locked steering only"
    )
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
        if self.steer_play is not None and (self.kind != "prismatic" or self.steering != "locked"):
            raise refuse(
                "steer_play",
                self.steer_play.play_rad,
                "only a prismatic station with locked steering may have free play; leave the key steer_play out",
            )
        if self.steer_play is not None:
            _check_stop(self.steer_play, self.inertia_kgm2[2][2])
        if isinstance(self.spring, GasOleo):
            check_oleo(self.spring, self.end_stop.stroke_m)
        return self


def _check_stop(play: SteerPlay, inertia_kgm2: float) -> None:
    """Refuse a stop against which the fixed step would feed the wheels' oscillation.

    Args:
        play: Play and stop.
        inertia_kgm2: Of the carriage about its own upright axis, the least that the stop can find [kg m2].

    Raises:
        PydanticCustomError: It is too stiff, or too little damped.
    """
    stiffest = FASTEST_STOP_RADPS**2 * inertia_kgm2
    if play.stop_stiffness_Nmprad > (1.0 + ROUNDING) * stiffest:
        raise refuse(
            "steer_play.stop_stiffness_Nmprad",
            play.stop_stiffness_Nmprad,
            f"with the carriage's Izz of {inertia_kgm2:g} kg m2 it must be at most {stiffest:.6g} N m/rad, since the "
            f"step resolves no oscillation beyond {FASTEST_STOP_RADPS:g} rad/s",
        )
    least = 2.0 * LEAST_STOP_DAMPING * math.sqrt(play.stop_stiffness_Nmprad * inertia_kgm2)
    if play.stop_damping_Nmspr < (1.0 - ROUNDING) * least:
        raise refuse(
            "steer_play.stop_damping_Nmspr",
            play.stop_damping_Nmspr,
            f"with this stiffness and the carriage's Izz of {inertia_kgm2:g} kg m2 it must be at least "
            f"{least:.6g} N m s/rad, {100.0 * LEAST_STOP_DAMPING:g} % of the critical damping, or the wheels' "
            "oscillation against the stop would grow by the step's own error",
        )
