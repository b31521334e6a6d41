"""The helicopter: everything that the simulation knows about it (Léveillé 2013, appendix A, HELI.INP).

SI units throughout. The coordinates are given from one reference point in the helicopter's axes (x forward,
y starboard, z down); the body's c.g. lies at `Helicopter.cg_offset_m` from it, at the point itself by default.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from ssmash_gym.document import Mark, Origin
from ssmash_gym.fields import Inertia, NonNegativeVector, Part, Positive, Vector, refuse
from ssmash_gym.vehicle.checks import check_reach
from ssmash_gym.vehicle.probe import Probe
from ssmash_gym.vehicle.station import Station


def _by_path(marks: tuple[Mark, ...]) -> tuple[Mark, ...]:
    """Give marks one order, so that helicopters compare by what they say."""
    return tuple(sorted(marks, key=lambda mark: mark.path))


class Aerodynamics(Part):
    """Wind forces on the body."""

    centre_of_pressure_m: Vector = Field(description="Centre of pressure, H axes, r_HCP (line 37) [m]")
    drag_areas_m2: NonNegativeVector = Field(description="Equivalent drag areas across x, y, z, A_eq (line 38) [m2]")
    wind_N_mps: Vector = Field(
        default=(0.0, 0.0, 0.0),
        description="Wind over the steadily moving ship, N axes, v_wind (line 39); a scenario overrides it [m/s]",
    )


class Surroundings(Part):
    """What the thesis takes for granted."""

    gravity_mps2: Positive = Field(description="Acceleration of gravity, g [m/s2]")
    air_density_kgpm3: Positive = Field(description="Air density, rho [kg/m3]")
    atmospheric_pressure_Pa: Positive = Field(description="Makes gauge tire pressures absolute, P_o,abs - P_o [Pa]")


class Stations(Part):
    """The three suspension stations; the auxiliary one is the nose or the tail gear."""

    auxiliary: Station = Field(description="Station 1: nose or tail gear")
    right: Station = Field(description="Station 2: starboard main gear")
    left: Station = Field(description="Station 3: port main gear")


class Helicopter(Part):
    """A helicopter, validated and frozen. Make one with `ssmash_gym.vehicle.load_helicopter`."""

    name: str = Field(min_length=1, description="Name of the configuration")
    description: str = Field(default="", description="What it stands for, and what must not be read into it")
    mass_kg: Positive = Field(description="Mass of the body without its wheel carriages, m_H (line 1) [kg]")
    inertia_kgm2: Inertia = Field(
        description="Inertia tensor of the body about its c.g., H axes, I_H; off-diagonals are tensor entries, that is "
        "minus the products of inertia (lines 2-4) [kg m2]"
    )
    cg_offset_m: Vector = Field(
        default=(0.0, 0.0, 0.0),
        description="Body c.g. from the reference point of this description's coordinates, H axes [m]",
    )
    tire_model: Literal["smiley_horne", "linear"] = Field(
        default="smiley_horne", description="Law of all tires: Smiley and Horne's equations, or a linear spring-damper"
    )
    stations: Stations = Field(description="Suspension stations")
    probe: Probe = Field(description="Securing probe")
    aerodynamics: Aerodynamics = Field(description="Wind forces")
    surroundings: Surroundings = Field(description="Gravity and air")
    provenance: Annotated[tuple[Mark, ...], AfterValidator(_by_path)] = Field(
        default=(), description="Where each value comes from, in the order of the paths"
    )

    @property
    def station_tuple(self) -> tuple[Station, Station, Station]:
        """The stations in their order: auxiliary, right, left."""
        return self.stations.auxiliary, self.stations.right, self.stations.left

    @property
    def total_mass_kg(self) -> float:
        """Mass of the body and its three carriages [kg]."""
        return self.mass_kg + sum(station.mass_kg for station in self.station_tuple)

    @property
    def marks(self) -> dict[str, Mark]:
        """The marks by the dotted path of their value."""
        return {mark.path: mark for mark in self.provenance}

    def value(self, path: str) -> Any:
        """Read a value by its dotted path, e.g. ``stations.right.tires.0.diameter_m``.

        Raises:
            KeyError: There is no such path.
        """
        found: Any = self
        for key in path.split("."):
            try:
                if isinstance(found, tuple):
                    found = found[int(key)]
                elif key in type(found).model_fields:
                    found = getattr(found, key)
                else:
                    raise KeyError(path)
            except (ValueError, IndexError, AttributeError):
                raise KeyError(path) from None
        return found

    def values_of_origin(self, origin: Origin) -> dict[str, Any]:
        """Every value with that mark, by dotted path; ``values_of_origin("assumed")`` lists what is only assumed."""
        return {mark.path: self.value(mark.path) for mark in self.provenance if mark.origin == origin}

    @model_validator(mode="after")
    def _sound(self) -> Helicopter:
        if self.tire_model == "linear":
            for name, station in zip(("auxiliary", "right", "left"), self.station_tuple, strict=True):
                for k, tire in enumerate(station.tires):
                    if tire.linear is None:
                        key = f"stations.{name}.tires.{k}.linear"
                        raise refuse(key, None, "the linear tire model needs its constants")
        check_reach(self)
        seen: set[str] = set()
        for mark in self.provenance:
            if mark.path in seen:
                raise refuse("provenance", mark.path, "a value may be marked only once")
            seen.add(mark.path)
            try:
                self.value(mark.path)
            except KeyError:
                raise refuse("provenance", mark.path, "there is no value of that path") from None
        return self
