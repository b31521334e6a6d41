"""From a name, a file or a mapping to a validated, frozen section; partial overrides keep their siblings."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from ssmash_gym.assets import asset_path
from ssmash_gym.document import read_file
from ssmash_gym.envs.ranges import RANGE_KEYS
from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.sections import Model, validated
from ssmash_gym.ship.ships import from_folder

BASE_KEY: Final = "base"  # in a mapping: the name or file that it changes


def names(folder: str) -> list[str]:
    """Names of the files that ship in ``configs/<folder>``."""
    return sorted(path.stem for path in asset_path("configs", folder).glob("*.yaml"))


def load(model: type[Model], folder: str, given: str | Path | Mapping[str, Any] | Model, default: str) -> Model:
    """Load a section.

    Args:
        model: What to make of it.
        folder: Where its named files lie, below ``configs``.
        given: A name, the path of a YAML file, a ready-made section, or a mapping. A mapping changes the keys it
            names, at any depth, of the file that its key ``base`` names (`default` without that key).
        default: Name of the file that a mapping without ``base`` changes.

    Raises:
        ConfigurationError: Unknown name or key, or a value that is not allowed; one sentence.
    """
    if isinstance(given, model):
        return given
    if isinstance(given, Mapping):
        changes = dict(given)
        document, source = read(folder, changes.pop(BASE_KEY, default))
        return validated(model, merged(document, changes), source)
    if not isinstance(given, str | Path):
        raise ConfigurationError(
            f"{folder}: {shown(given)} is refused: give a name, the path of a YAML file, or a mapping."
        )
    document, source = read(folder, given)
    return validated(model, document, source)


def read(folder: str, name_or_path: str | Path) -> tuple[dict[str, Any], str]:
    """Read a named file or a path; returns the document and its name in messages.

    Raises:
        ConfigurationError: There is no such file.
    """
    path = Path(name_or_path)
    if path.suffix.lower() in (".yaml", ".yml", ".json"):
        if not path.is_file():
            raise ConfigurationError(f"{path}: there is no such file.")
    elif str(name_or_path) in names(folder):
        path = asset_path("configs", folder, f"{name_or_path}.yaml")
    else:
        raise ConfigurationError(
            f"{folder}: there is none called {shown(str(name_or_path))}: give one of {', '.join(names(folder))}, or "
            "the path of a YAML file."
        )
    document = read_file(path)
    return resolved(document, path.parent), f"{folder} {path.stem}"


def resolved(document: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Make the paths of recorded motions and of a ship's files absolute, taken from the file's folder."""
    motion = document.get("motion")
    if not isinstance(motion, dict):
        return document
    ship = motion.get("ship")
    if isinstance(ship, dict):
        motion["ship"] = from_folder(ship, folder.resolve())
    elif str(ship).endswith((".yaml", ".yml")):
        motion["ship"] = str((folder / str(ship)).resolve())
    if isinstance(motion.get("paths"), list):
        motion["paths"] = [str((folder / str(path)).resolve()) for path in motion["paths"]]
    return document


def merged(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The document with the changes laid over it: mappings merge key by key, everything else is replaced.

    A mapping is replaced as a whole where the change is a range (`ssmash_gym.envs.ranges`), of another ``type`` or on
    another ``base``.
    """
    result = dict(document)
    for key, value in changes.items():
        old = result.get(key)
        if isinstance(value, Mapping) and isinstance(old, Mapping) and not _replaces(old, value):
            result[key] = merged(old, value)
        else:
            result[key] = value
    return result


def _replaces(old: Mapping[str, Any], new: Mapping[str, Any]) -> bool:
    ranges = bool(RANGE_KEYS & set(new)) or bool(RANGE_KEYS & set(old))
    return ranges or any(key in new and new[key] != old.get(key) for key in ("type", BASE_KEY))
