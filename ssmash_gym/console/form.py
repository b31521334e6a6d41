"""The form of the page: schemas and values of the typed descriptions, what a changed form means, and its YAML.

Schemas are pydantic's own. A form starts from named files (`Bases`) and holds changes to them, as everything else in
the package that takes changes does: task and scenario key by key (`ssmash_gym.envs.loading.merged`), the helicopter by
dotted path (`ssmash_gym.vehicle.with_changes`), a ship as ``scenario.motion.ship: {base: frigate, gm_m: 1.2}``.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Final, Self

from pydantic import BaseModel

from ssmash_gym.document import write_yaml
from ssmash_gym.envs import loading
from ssmash_gym.envs.given import as_helicopter
from ssmash_gym.envs.loading import BASE_KEY
from ssmash_gym.envs.ranges import Constant
from ssmash_gym.envs.scenario import ScenarioConfig, load_scenario
from ssmash_gym.envs.seaways import SeawayMotions
from ssmash_gym.envs.starts import Starter
from ssmash_gym.envs.task import OF_AN_AGENT, TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.ship.sea import SEA_STATES
from ssmash_gym.ship.ships import ShipDescription, load_ship, ship_names
from ssmash_gym.vehicle import Helicopter, helicopter_names
from ssmash_gym.vehicle.catalogue import document_of

SECTIONS: Final = ("scenario", "task", "helicopter")
FILES: Final = {name: f"{name}.yaml" for name in SECTIONS}
_OWN: Final = {"task": OF_AN_AGENT, "helicopter": ("provenance",), "ship": ("provenance",)}  # nothing to fill in


@dataclass(frozen=True)
class Bases:
    """What a form changes: names in the catalogue, or files that the person at the command line has named."""

    scenario: str = "ss5"
    task: str = "traverse"
    helicopter: str = "generic_tricycle"

    @classmethod
    def read(cls, given: Any, also: Bases) -> Self:
        """Bases as the page names them; what it leaves out is taken from `also`.

        Args:
            given: Mapping of names.
            also: Names or files that are allowed beside the catalogue's: those that the console was started with.

        Raises:
            ConfigurationError: It is no mapping of known names; a page cannot name files.
        """
        known = {field.name: getattr(also, field.name) for field in fields(cls)}
        for key, name in _mapping("base", given).items():
            if key not in known:
                raise ConfigurationError(f"base: there is no key {key}; allowed here are {', '.join(known)}.")
            allowed = sorted({*_catalogue()[key], known[key]})
            if name not in allowed:
                raise ConfigurationError(f"base: {key} = {shown(name)} is refused: give one of {', '.join(allowed)}.")
            known[key] = name
        return cls(**known)


def form_of(bases: Bases) -> dict[str, Any]:
    """Everything that a page needs for drawing the form, ready for JSON.

    Returns:
        ``base`` (names), ``names`` (catalogue by kind), ``schemas`` (by section, and ``ship``) and ``values`` (by
        section and name: what each catalogue file resolves to).

    Raises:
        ConfigurationError: A base does not load.
    """
    names = {kind: list(found) for kind, found in _catalogue().items()}
    for kind in SECTIONS:
        if getattr(bases, kind) not in names[kind]:
            names[kind].append(getattr(bases, kind))
    values = {kind: {name: _values(kind, name) for name in found} for kind, found in names.items()}
    return {"base": asdict(bases), "names": names, "schemas": schemas(), "values": values}


def schemas() -> dict[str, Any]:
    """JSON schemas of scenario, task, helicopter and ship; the scenario's ship points to the ship's (``x-form``)."""
    models: dict[str, type[BaseModel]] = {
        "scenario": ScenarioConfig, "task": TaskConfig, "helicopter": Helicopter, "ship": ShipDescription,
    }  # fmt: skip
    found = {kind: model.model_json_schema() for kind, model in models.items()}
    for kind, keys in _OWN.items():
        for key in keys:
            del found[kind]["properties"][key]
    seaway = found["scenario"]["$defs"][SeawayMotions.__name__]["properties"]
    seaway["ship"] |= {"x-form": "ship", "description": "a ship of the catalogue, perhaps with changes"}
    seaway["sea_state"] |= {"x-choices": list(SEA_STATES)}
    return found


def checked(base: Any, changes: Any, also: Bases | None = None, *, files: bool = True) -> Condition:
    """What a filled-in form stands for.

    Args:
        base: Names of scenario, task and helicopter, as the page sends them.
        changes: Mapping with ``scenario`` and ``task`` (nested) and ``helicopter`` (by dotted path).
        also: What the console was started with: allowed as a base beside the catalogue.
        files: Whether the changes may name further files (records, ships, tables): only of one's own machine.

    Returns:
        The condition, checked like one of a study, and called like its scenario.

    Raises:
        ConfigurationError: A name, a key or a value is refused; one sentence.
    """
    bases = Bases.read(base, also or Bases())
    given = {kind: _mapping(f"changes: {kind}", part) for kind, part in _mapping("changes", changes).items()}
    for kind in given:
        if kind not in SECTIONS:
            raise ConfigurationError(f"changes: there is no key {kind}; allowed here are {', '.join(SECTIONS)}.")
        if BASE_KEY in given[kind]:
            raise ConfigurationError(f"changes: {kind}.{BASE_KEY} is refused: the base is named beside the changes.")
    if not files:
        _without_files(given)
    scenario, task, helicopter = ({BASE_KEY: getattr(bases, kind), **given.get(kind, {})} for kind in SECTIONS)
    name = Path(bases.scenario).stem + (", changed" if any(given.values()) else "")
    condition = Condition(name, "", load_task(task), load_scenario(scenario), as_helicopter(helicopter))
    Starter(condition.helicopter, condition.task, condition.scenario)
    return condition


def yaml_files(condition: Condition) -> dict[str, str]:
    """The condition as files of the command line.

    Returns:
        Text by file name: ``scenario.yaml``, ``task.yaml``, ``helicopter.yaml``. They load back to the same
        `Condition.configuration`; the helicopter keeps the marks of the values that were not changed.
    """
    documents = {
        "scenario": _written(condition.scenario),
        "task": _written(condition.task),
        "helicopter": document_of(condition.helicopter),
    }
    return {FILES[kind]: write_yaml(document) for kind, document in documents.items()}


def _written(section: BaseModel) -> dict[str, Any]:
    """A section as a person writes it: only what was given, a constant range as its bare number."""
    found: dict[str, Any] = _plain(section, section.model_dump(mode="json", exclude_unset=True))
    return found


def _plain(value: Any, dumped: Any) -> Any:
    if isinstance(value, Constant):
        return value.constant
    if isinstance(value, BaseModel):
        return {key: _plain(getattr(value, key), child) for key, child in dumped.items()}
    return dumped


@functools.cache
def _catalogue() -> dict[str, list[str]]:
    return {
        "scenario": loading.names("scenarios"),
        "task": loading.names("tasks"),
        "helicopter": helicopter_names(),
        "ship": ship_names(),
    }


def _values(kind: str, name: str) -> dict[str, Any]:
    """A file's values with all defaults, as the page shows them."""
    found: BaseModel
    if kind == "ship":
        found = load_ship(name).description
    elif kind == "helicopter":
        found = as_helicopter(name)
    else:
        found = load_scenario(name) if kind == "scenario" else load_task(name)
    values: dict[str, Any] = found.model_dump(mode="json", exclude=set(_OWN.get(kind, ())))
    return values


def _mapping(what: str, given: Any) -> dict[str, Any]:
    if given is None:
        return {}
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise ConfigurationError(f"{what}: {shown(given)} is refused: must be a mapping.")
    return dict(given)


def _without_files(changes: Mapping[str, Any]) -> None:
    """Refuse changes that name files: a page that is opened from elsewhere must not make this machine read them."""
    motion = changes.get("scenario", {}).get("motion")
    if not isinstance(motion, Mapping):
        return
    ship = motion.get("ship")
    named = ship.get(BASE_KEY, "") if isinstance(ship, Mapping) else ship
    if "paths" in motion or (named and named not in ship_names()) or (isinstance(ship, Mapping) and _of_files(ship)):
        raise ConfigurationError(
            "scenario: motion names a file, which is refused here: records, ships and tables of one's own are given "
            "at the command line."
        )


def _of_files(ship: Mapping[str, Any]) -> bool:
    return "response" in ship or (isinstance(ship.get("hull"), Mapping) and "database" in ship["hull"])
