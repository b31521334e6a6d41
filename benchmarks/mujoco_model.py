"""A MuJoCo model of the benchmark's helicopter: same masses, geometry, gear and task, MuJoCo's own contact and joints.

It is what a practised user would build to get the traverse out of MuJoCo at good speed, and it errs to MuJoCo's
favour: spheres for tires (the cheapest exact contact with a box), linear springs for oleos, no tire carcass, no
friction in the struts. Axes as in the project: x forward, y starboard, z down. README.md says what is comparable.

Degrees of freedom: deck 6 (driven), helicopter 6, slides 3, castor 1, wheel axles 6, claw 2 (driven) and 1 free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.layout import STATION_COORDINATES, STATION_NAMES, State
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.vehicle import Helicopter, with_changes
from ssmash_gym.vehicle.geometry import rotation

GRAVITY_MPS2 = 9.81
DECK_MASS_KG = 1.0e8  # so heavy that the helicopter does not disturb the drive
CLAW_MASS_KG = 1.0e4
DAMPING_RATIO = 0.3  # of the struts about the working point
TRAVEL_M = 0.25  # of the struts either way from the working point
DRIVE_RAD_S = 30.0  # bandwidth of the deck drive: errors die within a tenth of a second


@dataclass(frozen=True)
class Station:
    """One landing gear station of the MuJoCo model, SI units.

    Args:
        name: Name of the station.
        position_m: Wheel axle at rest on the deck, relative to the body's centre of mass (x, y, z).
        carriage_mass_kg: Unsprung mass.
        static_load_n: Load on the deck at rest.
        stiffness_npm: Strut stiffness at the working point.
        damping_nspm: Strut damping.
        tire_radius_m: Outer radius of a tire.
        wheels_y_m: Lateral position of each wheel on the carriage.
        trail_m: Castor trail; None for a station that does not steer.
    """

    name: str
    position_m: tuple[float, float, float]
    carriage_mass_kg: float
    static_load_n: float
    stiffness_npm: float
    damping_nspm: float
    tire_radius_m: float
    wheels_y_m: tuple[float, ...]
    trail_m: float | None


@dataclass(frozen=True)
class Model:
    """Numbers of the MuJoCo model, SI units.

    Args:
        body_mass_kg: Sprung mass.
        inertia_kgm2: Ixx, Iyy, Izz, Ixy, Ixz, Iyz of the sprung mass.
        height_m: Height of the body's centre of mass over the deck at rest.
        stations: The three stations.
        probe_m: Probe tip from the body's centre of mass.
        probe_stiffness_npm: In-plane stiffness of the probe.
        friction: Tire-deck friction coefficient.
        steer_damping_nms: Damping of the castor.
    """

    body_mass_kg: float
    inertia_kgm2: tuple[float, float, float, float, float, float]
    height_m: float
    stations: tuple[Station, Station, Station]
    probe_m: tuple[float, float, float]
    probe_stiffness_npm: float
    friction: float
    steer_damping_nms: float


def station_xml(station: Station, model: Model) -> str:
    """Bodies of one station: carriage on a slide, castor if it steers, two wheels on their axles."""
    trail = station.trail_m or 0.0
    x, y, z = station.position_m[0] + trail, *station.position_m[1:]  # the castor's axis lies ahead of the axle
    sprung_load = station.static_load_n - station.carriage_mass_kg * GRAVITY_MPS2
    rest = sprung_load / station.stiffness_npm  # compression at rest: the spring's reference lies below by this much
    castor = ""
    if station.trail_m is not None:
        castor = f'<joint name="steer_{station.name}" type="hinge" axis="0 0 1" damping="{model.steer_damping_nms}"/>'
    wheel_mass = 0.2 * station.carriage_mass_kg  # the rest stays with the carriage
    wheel_inertia = 0.5 * wheel_mass * station.tire_radius_m**2
    wheels = "".join(
        f"""
        <body name="wheel_{station.name}_{k}" pos="{-trail} {y_wheel} 0">
          <joint type="hinge" axis="0 1 0"/>
          <inertial pos="0 0 0" mass="{wheel_mass}" diaginertia="{wheel_inertia} {wheel_inertia} {wheel_inertia}"/>
          <geom name="tire_{station.name}_{k}" class="tire" size="{station.tire_radius_m}"/>
        </body>"""
        for k, y_wheel in enumerate(station.wheels_y_m)
    )
    carriage = station.carriage_mass_kg - wheel_mass * len(station.wheels_y_m)
    return f"""
      <body name="carriage_{station.name}" pos="{x} {y} {z}">
        <joint name="slide_{station.name}" type="slide" axis="0 0 1" stiffness="{station.stiffness_npm}"
               springref="{rest}" damping="{station.damping_nspm}" limited="true"
               range="{-TRAVEL_M} {TRAVEL_M}"/>
        {castor}
        <inertial pos="{-trail} 0 0" mass="{carriage}" diaginertia="4 4 4"/>{wheels}
      </body>"""


def _deck_joints() -> str:
    """Three slides and yaw, pitch, roll: the deck's motion in the project's order of rotations."""
    axes = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
    slides = "".join(f'<joint name="deck_{name}" type="slide" axis="{axis}"/>' for name, axis in axes.items())
    hinges = (("yaw", "0 0 1"), ("pitch", "0 1 0"), ("roll", "1 0 0"))
    return slides + "".join(f'<joint name="deck_{n}" type="hinge" axis="{a}"/>' for n, a in hinges)


def _drives() -> str:
    """A position and a velocity servo on each deck joint, a velocity servo on each claw slide."""
    stiff, damp = DECK_MASS_KG * DRIVE_RAD_S**2, 2.0 * DECK_MASS_KG * DRIVE_RAD_S
    names = [f"deck_{n}" for n in ("x", "y", "z", "roll", "pitch", "yaw")]
    deck = "".join(f'<position joint="{n}" kp="{stiff}"/>' for n in names)
    rates = "".join(f'<velocity joint="{n}" kv="{damp}"/>' for n in names)
    claw = "".join(f'<velocity joint="claw_{n}" kv="{CLAW_MASS_KG * 100.0}"/>' for n in "xy")
    return deck + rates + claw


def mjcf(model: Model, substep_s: float) -> str:
    """The model as MJCF text."""
    ixx, iyy, izz, ixy, ixz, iyz = model.inertia_kgm2
    x_body, y_body = -model.probe_m[0], -model.probe_m[1]
    effective = model.body_mass_kg  # MuJoCo's direct contact stiffness is per effective mass
    probe = f"{-model.probe_stiffness_npm / effective:.6g} {-2.0 * np.sqrt(model.probe_stiffness_npm / effective):.6g}"
    loads = "".join(
        f'<contact subtree1="carriage_{s.name}" geom2="deck" data="force" reduce="netforce"/>' for s in model.stations
    )
    return f"""
<mujoco model="helicopter on a moving deck">
  <option timestep="{substep_s}" integrator="implicitfast" gravity="0 0 {GRAVITY_MPS2}" cone="pyramidal"/>
  <size njmax="100"/>
  <default>
    <default class="tire">
      <geom type="sphere" contype="1" conaffinity="2" condim="3" friction="{model.friction} 0 0"
            solref="0.09 0.2" solimp="0.9 0.9 0.01"/>
    </default>
  </default>
  <worldbody>
    <body name="deck" gravcomp="1">
      {_deck_joints()}
      <inertial pos="0 0 0" mass="{DECK_MASS_KG}" diaginertia="{DECK_MASS_KG} {DECK_MASS_KG} {DECK_MASS_KG}"/>
      <geom name="deck" type="box" size="30 8 0.5" pos="0 0 0.5" contype="2" conaffinity="1"/>
      <body name="claw" gravcomp="1">
        <joint name="claw_x" type="slide" axis="1 0 0"/>
        <joint name="claw_y" type="slide" axis="0 1 0"/>
        <inertial pos="0 0 0" mass="{CLAW_MASS_KG}" diaginertia="1e4 1e4 1e4"/>
        <body name="jaw" gravcomp="1">
          <joint name="claw_z" type="slide" axis="0 0 1" damping="100"/>
          <inertial pos="0 0 0" mass="20" diaginertia="1 1 1"/>
        </body>
      </body>
    </body>
    <body name="helicopter" pos="{x_body} {y_body} {-model.height_m}">
      <freejoint name="helicopter"/>
      <inertial pos="0 0 0" mass="{model.body_mass_kg}" fullinertia="{ixx} {iyy} {izz} {ixy} {ixz} {iyz}"/>
      {"".join(station_xml(s, model) for s in model.stations)}
    </body>
  </worldbody>
  <equality>
    <connect name="probe" body1="jaw" body2="helicopter" anchor="0 0 0" solref="{probe}" solimp="0.9 0.9 0.01"/>
  </equality>
  <actuator>{_drives()}</actuator>
  <sensor>
    <framepos objtype="xbody" objname="helicopter" reftype="xbody" refname="deck"/>
    <framequat objtype="xbody" objname="helicopter" reftype="xbody" refname="deck"/>
    <framelinvel objtype="xbody" objname="helicopter" reftype="xbody" refname="deck"/>
    <frameangvel objtype="xbody" objname="helicopter" reftype="xbody" refname="deck"/>
    {loads}
    <jointpos joint="claw_x"/><jointpos joint="claw_y"/>
    <jointpos joint="slide_{model.stations[0].name}"/><jointpos joint="slide_{model.stations[1].name}"/>
    <jointpos joint="slide_{model.stations[2].name}"/>
  </sensor>
</mujoco>"""


@dataclass(frozen=True)
class Rest:
    """A helicopter at rest on a level deck, as the engine finds it.

    Args:
        height_m: Height of the body's centre of mass.
        axles_m: Mean wheel centre of each station from the body's centre of mass, H axes, (3, 3).
        loads_n: Vertical load of each station, (3,).
    """

    height_m: float
    axles_m: NDArray[np.float64]
    loads_n: NDArray[np.float64]


def rest(helicopter: Helicopter) -> Rest:
    """Settle one helicopter and read where its wheels are."""
    batch = Batch(helicopter)
    batch.place(0.0, 0.0, 0.0)
    axles = []
    for i, station in enumerate(helicopter.station_tuple):
        row = State.Q15 + STATION_COORDINATES * i
        wheel = np.mean([tire.position_m for tire in station.tires], axis=0)
        carriage = np.array([*station.droop_m[:2], batch.state[row, 0]])
        axles.append(np.array(station.mount_m) + rotation(batch.state[row + 1 : row + 5, 0]) @ (carriage + wheel))
    loads = [batch.telemetry[f"{name}_vertical_load"][0] for name in STATION_NAMES]
    return Rest(-float(batch.state[State.Q10, 0]), np.array(axles), np.array(loads))


def model_of(helicopter: Helicopter) -> Model:
    """The MuJoCo model's numbers: geometry and loads at rest, struts linearised there by a change of mass."""
    now = rest(helicopter)
    light, heavy = (rest(with_changes(helicopter, {"mass_kg": f * helicopter.mass_kg})) for f in (0.97, 1.03))
    travel = light.axles_m[:, 2] - heavy.axles_m[:, 2]  # a heavier body sinks: its wheels move up in it
    stiffness = (heavy.loads_n - light.loads_n) / travel
    stations = []
    for i, (name, station) in enumerate(zip(STATION_NAMES, helicopter.station_tuple, strict=True)):
        tires = station.tires
        sprung_kg = now.loads_n[i] / GRAVITY_MPS2 - station.mass_kg
        stations.append(
            Station(
                name=name,
                position_m=tuple(now.axles_m[i]),
                carriage_mass_kg=station.mass_kg,
                static_load_n=float(now.loads_n[i]),
                stiffness_npm=float(stiffness[i]),
                damping_nspm=float(2.0 * DAMPING_RATIO * np.sqrt(stiffness[i] * sprung_kg)),
                tire_radius_m=0.5 * tires[0].diameter_m,
                wheels_y_m=tuple(tire.position_m[1] for tire in tires),
                trail_m=-(station.droop_m[0] + tires[0].position_m[0]) if station.steering == "free" else None,
            )
        )
    inertia = np.array(helicopter.inertia_kgm2)
    auxiliary, right, left = stations
    return Model(
        body_mass_kg=helicopter.mass_kg,
        inertia_kgm2=tuple(inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]),
        height_m=now.height_m,
        stations=(auxiliary, right, left),
        probe_m=tuple(np.add(helicopter.probe.mount_m, helicopter.probe.vector_m)),
        probe_stiffness_npm=helicopter.probe.small_stiffness_x_Npm,
        friction=helicopter.stations.right.tires[0].friction_coefficient,
        steer_damping_nms=helicopter.stations.auxiliary.steer_damping_Nmspr,
    )


def controls(deck: NDArray[np.float64], claw_speed_mps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Drive commands of every substep.

    Args:
        deck: (n, 12) deck position and roll, pitch, yaw [m, rad], then their rates.
        claw_speed_mps: (n, 2) claw velocity.

    Returns:
        (n, 14) controls in the order of the model's actuators.
    """
    return np.concatenate([deck, claw_speed_mps], axis=1)
