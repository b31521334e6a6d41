"""What the helicopter is: a typed, validated description, and a catalogue of two."""

from __future__ import annotations

from ssmash_gym.document import Mark, Origin
from ssmash_gym.vehicle.catalogue import (
    document_of,
    helicopter_from,
    helicopter_names,
    load_helicopter,
    save_helicopter,
    with_changes,
)
from ssmash_gym.vehicle.description import (
    Aerodynamics,
    Helicopter,
    Stations,
    Surroundings,
)
from ssmash_gym.vehicle.oleo import EndStop, GasOleo, LinearStrut
from ssmash_gym.vehicle.probe import Probe
from ssmash_gym.vehicle.station import Station, SteerPlay, SwingArm
from ssmash_gym.vehicle.tire import LinearTire, Tire

__all__ = [
    "Aerodynamics",
    "EndStop",
    "GasOleo",
    "Helicopter",
    "LinearStrut",
    "LinearTire",
    "Mark",
    "Origin",
    "Probe",
    "Station",
    "Stations",
    "SteerPlay",
    "Surroundings",
    "SwingArm",
    "Tire",
    "document_of",
    "helicopter_from",
    "helicopter_names",
    "load_helicopter",
    "save_helicopter",
    "with_changes",
]
