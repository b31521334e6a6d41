"""Ships: their description in ``configs/ships/*.yaml``, and the response that it stands for.

A ship is either a hull (a database of ``ssmash_gym/ship/data`` or a file, scaled by Froude's law, with the loading,
the roll damping and the guards of its description) or a table of a user's own response amplitudes.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from ssmash_gym.assets import asset_path
from ssmash_gym.document import Mark, read_file, split
from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.fields import Part, Positive, Vector, refuse
from ssmash_gym.ship.hull import HullDatabase, load_hull
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.response import Guards, HullResponse, Loading, ShipResponse
from ssmash_gym.ship.response_table import ResponseFile
from ssmash_gym.ship.roll_damping import RollDamping
from ssmash_gym.ship.sea import KNOT

BASE_KEY: Final = "base"  # in a file or a mapping: the name or file of the ship that it changes
FILES: Final = (".yaml", ".yml")
SUMMARY_SPEEDS_KN: Final = (0.0, 10.0, 18.0)
SUMMARY_ROLL_RMS: Final = np.radians(3.0)  # the rolling for which the summary tells the damping
HULL_KEYS: Final = ("kg_m", "gm_m", "gyration", "roll_damping")


class Hull(Part):
    """Which hull, and how large."""

    database: str = Field(min_length=1, description="name of a hull database, or the path of one (.npz)")
    scale: Positive = Field(1.0, description="length over that of the database; everything follows by Froude's law")


class Gyration(Part):
    """Radii of gyration of the ship's mass about G, without added mass."""

    roll_over_beam: Positive = Field(description="kxx over the beam")
    pitch_over_length: Positive = Field(description="kyy over the length")
    yaw_over_length: Positive = Field(description="kzz over the length")


class ShipDescription(Part):
    """A ship, validated and frozen. Make one with `load_ship`.

    With `hull`, one of `kg_m` and `gm_m`, and `gyration` and `roll_damping` are needed; with `response`, none of them.
    """

    name: str = Field(min_length=1, description="name of the ship")
    description: str = Field("", description="what it stands for, and what must not be read into it")
    hull: Hull | None = Field(None, description="hull database and scale")
    response: ResponseFile | None = Field(None, description="a table of the ship's response instead of a hull")
    kg_m: Positive | None = Field(None, description="height of the centre of gravity G above the keel [m]")
    gm_m: Positive | None = Field(None, description="metacentric height [m], instead of kg_m")
    gyration: Gyration | None = Field(None, description="radii of gyration")
    roll_damping: RollDamping | None = Field(None, description="law of the equivalent linear roll damping")
    guards: Guards = Field(default_factory=Guards, description="guards of the linear theory near omega_e = 0")
    deck_point_m: Vector = Field(description="deck origin from G: x forward, y starboard, z down [m]")
    provenance: tuple[Mark, ...] = Field((), description="where each value comes from")

    @model_validator(mode="after")
    def _hull_or_table(self) -> Self:
        if (self.hull is None) == (self.response is None):
            raise refuse("hull", self.hull, "a ship needs either a hull or a response, one of the two")
        for key in HULL_KEYS:
            if self.response is not None and getattr(self, key) is not None:
                raise refuse(key, getattr(self, key), "a ship whose response is a table does not have it")
        if self.hull is not None:
            if (self.kg_m is None) == (self.gm_m is None):
                raise refuse("kg_m", self.kg_m, "a hull needs either kg_m or gm_m, one of the two")
            for key in HULL_KEYS[2:]:
                if getattr(self, key) is None:
                    raise refuse(key, None, "a hull needs it")
        return self

    @property
    def marks(self) -> dict[str, Mark]:
        """The marks by the dotted path of their value."""
        return {mark.path: mark for mark in self.provenance}


@dataclass(frozen=True, eq=False)
class Ship:
    """A ship that is ready to be put into waves.

    Attributes:
        description: What it was made from.
        response: Response of its centre of gravity G to waves.
        deck_point_m: Deck origin from G, S axes (x forward, y starboard, z down) [m], (3,), read-only.
        changed: Dotted keys in which it differs from the ship whose name it bears; none where it has a name of its own.
    """

    description: ShipDescription
    response: ShipResponse
    deck_point_m: FloatArray
    changed: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the ship; a changed ship without a name of its own has that of its base (see `label`)."""
        return self.description.name

    @property
    def label(self) -> str:
        """Name for printouts and pictures, e.g. ``frigate, changed: kg_m, deck_point_m``."""
        return f"{self.name}, changed: {', '.join(self.changed)}" if self.changed else self.name

    def summary(self) -> str:
        """The ship in a few lines: displacement, metacentric height, natural periods, roll damping, deck origin."""
        x, y, z = self.deck_point_m
        lines = [
            self.label,
            f"  deck origin    {abs(x):g} m {'forward' if x > 0.0 else 'aft'}, {abs(y):g} m to "
            f"{'port' if y < 0.0 else 'starboard'}, {-z:g} m above the centre of gravity",
        ]
        if isinstance(self.response, HullResponse):
            lines[1:1] = _hull_lines(self.response)
        elif self.description.response is not None:
            lines.insert(1, f"  response       table {self.description.response.table}")
        return "\n".join(lines)


def ship_names() -> list[str]:
    """Names of the ships that come with the package."""
    return sorted(path.stem for path in asset_path("configs", "ships").glob("*.yaml"))


def load_ship(given: str | Path | Mapping[str, Any] | Ship) -> Ship:
    """Load a ship; the same description gives the same object.

    Args:
        given: A name of `ship_names`, the path of a YAML file, a mapping with the keys of `ShipDescription`, or a ship.
            File and mapping may have the key ``base``, the name or file of a ship (with or without a base of its own)
            of which the other keys change something. Paths are taken from the folder of the file they stand in.

    Raises:
        ConfigurationError: There is no such name or file, bases go in a circle, or the description is refused; one
            sentence that names the file, the key, the value and what is allowed.
    """
    if isinstance(given, Ship):
        return given
    if isinstance(given, Mapping):
        return _ship_of(*_of_mapping(given))
    if isinstance(given, str | Path):
        return _ship_of(*_read(_stamped(_path_of(given, "ships"))))
    raise ConfigurationError(f"ships: {shown(given)} is refused: give a name, the path of a YAML file, or a mapping.")


def from_folder(description: Mapping[str, Any], folder: str | Path) -> dict[str, Any]:
    """A copy of a ship's mapping in which the paths of other files (base, table, hull database) start from a folder.

    Args:
        description: With the keys of `ShipDescription` and perhaps ``base``, marks and all; it may be at fault.
        folder: Folder of the file in which it stands; absolute paths stay as they are.
    """
    result = dict(description)
    if BASE_KEY in result:
        result[BASE_KEY] = _within(folder, result[BASE_KEY], FILES)
    for name, key, endings in (("response", "table", ()), ("hull", "database", (".npz",))):
        section = result.get(name)
        if isinstance(section, Mapping) and key in section:
            result[name] = {**section, key: _within(folder, section[key], endings)}
    return result


def _ship_of(description: ShipDescription, changed: tuple[str, ...]) -> Ship:
    """The ship that a description stands for; built anew when the file of its table or hull has changed."""
    file = Path(description.hull.database) if description.hull is not None else None
    if description.response is not None:
        file = description.response.table
    return _built(description, changed, file.stat().st_mtime_ns if file is not None and file.is_file() else 0)


@functools.lru_cache(maxsize=32)
def _built(description: ShipDescription, changed: tuple[str, ...], time: int) -> Ship:
    """The ship that a description stands for."""
    point = np.array(description.deck_point_m)
    point.flags.writeable = False
    if description.response is not None:
        return Ship(description, description.response.read(), point, changed)
    gyration, damping = description.gyration, description.roll_damping
    assert description.hull is not None and gyration is not None and damping is not None  # validated
    hull = _hull(description.hull.database, description.hull.scale, time)
    height = _height_of_G(description, hull)
    radii = (
        gyration.roll_over_beam * hull.beam_m,
        gyration.pitch_over_length * hull.length_m,
        gyration.yaw_over_length * hull.length_m,
    )
    try:
        response = HullResponse(hull, Loading(height, radii), damping, description.guards)
    except ConfigurationError as error:
        raise ConfigurationError(f"ship {description.name}: {error}") from None
    return Ship(description, response, point, changed)


@functools.lru_cache(maxsize=8)
def _hull(database: str, scale: float, _time: int) -> HullDatabase:
    hull = load_hull(database)
    return hull if scale == 1.0 else hull.scaled(scale)


def _height_of_G(description: ShipDescription, hull: HullDatabase) -> float:
    """Height of G above the keel [m], from the description's KG or GM."""
    if description.kg_m is not None:
        return description.kg_m
    assert description.gm_m is not None  # validated
    return hull.draught_m + hull.z_B + hull.I_T / hull.volume_m3 - description.gm_m


def _hull_lines(response: HullResponse) -> list[str]:
    hull, period = response.hull, response.natural_period_s
    sigma = float(SUMMARY_ROLL_RMS) * 2.0 * np.pi / period["roll"]
    root = float(np.sqrt(hull.length_m / hull.gravity))
    ratios = [response.damping.ratio(response.froude(kn * KNOT), sigma, root) for kn in SUMMARY_SPEEDS_KN]
    rxx, ryy, rzz = response.loading.radii_m
    return [
        f"  hull           {hull.name}: {hull.length_m:.1f} m x {hull.beam_m:.2f} m x {hull.draught_m:.2f} m draught",
        f"  displacement   {response.mass_kg / 1000.0:.0f} t",
        f"  KG, GM         {response.loading.kg_m:.2f} m, {response.gm_m:.2f} m",
        f"  gyration       roll {rxx:.2f} m, pitch {ryy:.2f} m, yaw {rzz:.2f} m",
        f"  natural period roll {period['roll']:.2f} s, heave {period['heave']:.2f} s, pitch {period['pitch']:.2f} s",
        "  roll damping   "
        + ", ".join(f"{r:.3f} at {kn:g} kn" for r, kn in zip(ratios, SUMMARY_SPEEDS_KN, strict=True))
        + " of critical, for 3 deg RMS of roll",
    ]


# --- reading -------------------------------------------------------------------------------------------------------


def _path_of(given: str | Path, where: str) -> Path:
    path = Path(given)
    if path.suffix.lower() in FILES:
        if not path.is_file():
            raise ConfigurationError(f"{path}: there is no such ship file.")
        return path.resolve()
    named = asset_path("configs", "ships") / f"{given}.yaml"
    if path.name != str(given) or not named.is_file():
        raise ConfigurationError(
            f"{where}: there is none called {shown(str(given))}: give one of {', '.join(ship_names())}, or the path of "
            "a YAML file."
        )
    return named


def _within(folder: str | Path, value: Any, endings: Sequence[str]) -> Any:
    """A path that starts from a folder; what has none of the endings (where there are any) is a name and stays."""
    if isinstance(value, Mapping) and "value" in value:  # with its mark
        return {**value, "value": _within(folder, value["value"], endings)}
    if isinstance(value, str | Path) and (not endings or Path(value).suffix.lower() in endings):
        return str(Path(folder) / value)
    return value


@functools.lru_cache(maxsize=32)
def _file(path: Path, _time: int) -> dict[str, Any]:
    """The document in a file, its paths made absolute; read anew when the file has changed."""
    return from_folder(read_file(path), path.parent)


def _base_of(document: Mapping[str, Any], source: str) -> Path | None:
    """File of the ship that a document changes, if it changes one."""
    given = document.get(BASE_KEY)
    if given is None:
        return None
    if not isinstance(given, str | Path):
        raise ConfigurationError(f"{source}: base = {shown(given)} is refused: give the name or the file of a ship.")
    return _path_of(given, f"{source}: base")


Stamps = tuple[tuple[Path, int], ...]  # files, each with the time of its last change


def _stamped(path: Path, above: tuple[Path, ...] = ()) -> Stamps:
    """A ship's file and its bases, the changing one first."""
    if path in above:
        circle = " on ".join(file.name for file in (*above[above.index(path) :], path))
        raise ConfigurationError(f"{above[-1]}: base = {shown(str(path))} is refused: bases in a circle, {circle}.")
    stamp = (path, path.stat().st_mtime_ns)
    base = _base_of(_file(*stamp), str(path))
    return (stamp,) if base is None else (stamp, *_stamped(base, (*above, path)))


@functools.lru_cache(maxsize=32)
def _read(stamps: Stamps) -> tuple[ShipDescription, tuple[str, ...]]:
    """The description in a file on its bases, and in what it differs from the ship that it is named after."""
    return _described([_file(*stamp) for stamp in stamps], str(stamps[0][0]))


def _of_mapping(given: Mapping[str, Any]) -> tuple[ShipDescription, tuple[str, ...]]:
    """The same of a mapping."""
    base = _base_of(given, "ship")
    if base is None:
        return _described([given], "ship")
    return _described([given, *(_file(*stamp) for stamp in _stamped(base))], f"ship {base.stem} with changes")


def _described(documents: Sequence[Mapping[str, Any]], source: str) -> tuple[ShipDescription, tuple[str, ...]]:
    """The description of a document and its bases (the changing one first), marks and all, and what was changed."""
    document: dict[str, Any] = {}
    changed: tuple[str, ...] = ()
    for changes in reversed(documents):
        document = _with_changes(document, {key: value for key, value in changes.items() if key != BASE_KEY})
        changed = () if "name" in changes else tuple(dict.fromkeys((*changed, *_leaves(changes))))
        changed = tuple(key for key in changed if key.split(".")[0] in document)  # gm_m after kg_m stands alone
    plain, marks = split(document, source)
    try:
        return ShipDescription.model_validate({**plain, "provenance": marks}), changed
    except ValidationError as error:
        raise ConfigurationError(_sentence(error, source)) from None


def _with_changes(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A ship's document with changes laid over it; KG and GM are two ways of saying the same thing."""
    result = dict(document)
    for one, other in (("kg_m", "gm_m"), ("gm_m", "kg_m")):
        if one in changes and other not in changes:
            result.pop(other, None)
    return _merged(result, changes)


def _merged(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The document with the changes laid over it: sections merge key by key, values are replaced with their marks."""
    result = dict(document)
    for key, value in changes.items():
        old = result.get(key)
        section = isinstance(old, Mapping) and "value" not in old
        result[key] = _merged(old, value) if isinstance(value, Mapping) and section and old is not None else value
    return result


def _leaves(changes: Mapping[str, Any], path: str = "") -> Iterator[str]:
    """Dotted keys of the values in a document of changes, but for those that only describe it."""
    for key, value in changes.items():
        if isinstance(value, Mapping) and "value" not in value:
            yield from _leaves(value, f"{path}{key}.")
        elif path or key not in (BASE_KEY, "name", "description"):
            yield f"{path}{key}"


def _sentence(error: ValidationError, source: str) -> str:
    """The first mistake in one sentence: source, key, value and what is allowed."""
    first = error.errors(include_url=False)[0]
    key = ".".join(str(part) for part in first["loc"])
    if first["type"] == "missing":
        return f"{source}: {key} is missing."
    if first["type"] == "refused":
        context = first["ctx"]
        key = ".".join(part for part in (key, context["key"]) if part)
        return f"{source}: {key} = {shown(context['value'])} is refused: {context['allowed']}."
    message = first["msg"]
    return f"{source}: {key} = {shown(first['input'])} is refused: {message[:1].lower()}{message[1:]}."
