"""From the files' numbers to the complete plain document of a case, and back; marks and sidecar come later."""

from __future__ import annotations

import copy
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, get_args

import numpy as np
from pydantic import BaseModel

from ssmash_gym.cases import Case, prepared
from ssmash_gym.cases.claw import ClawFile, ClawPoints, StillClaw, claw_nodes
from ssmash_gym.cases.start import Given
from ssmash_gym.dynamics.layout import STATION_COORDINATES, STATIONS, State
from ssmash_gym.ship.shipmo import write_shipmo
from ssmash_gym.ship.sources import Fixed, MotionFile, Sinusoid
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.thesis_files import conditions, defaults
from ssmash_gym.thesis_files import helicopter as heli
from ssmash_gym.thesis_files.reading import Rows, read_table
from ssmash_gym.thesis_files.run_layout import CLAW, DECK, METHODS
from ssmash_gym.vehicle import Helicopter

RECORD_STEP_S: Final = 0.05  # of the records that are written for motions which the files cannot say otherwise
RECORD_MARGIN_S: Final = 1.0  # by which such a record of the deck is longer than the run
FALLBACK_SOLVER: Final = "automatic"  # for a solver that has no number
NAMES: Final = {"name": "", "title": "", "source": "", "reconstructed": ""}


# --- numbers to document -------------------------------------------------------------------------------------------


def from_numbers(
    numbers: Mapping[str, Rows], name: str, records: Mapping[str, str], given: set[str]
) -> tuple[dict[str, Any], dict[str, defaults.Default]]:
    """The complete document of what the files say.

    Args:
        numbers: Numbers of the files, by key.
        name: Name of case and helicopter, for which the files have no place.
        records: Path of the record of claw and deck, where there is one.
        given: Paths for which no default is to be taken, because a sidecar has the values.

    Returns:
        The plain document with every key, and the defaults of the helicopter in it, by their path in the document.
    """
    helicopter = heli.document(numbers["heli"], numbers["initials"])
    with np.errstate(all="ignore"):  # an absurd number is refused by the description, with its place
        taken = defaults.fill(helicopter, {path.removeprefix("helicopter.") for path in given})
    deck = conditions.deck(numbers["prescribed"], records.get("deck", ""))
    if deck["type"] == "file":
        deck.update({d.path.removeprefix("deck."): d.value for d in defaults.CASE if d.path.startswith("deck.")})
    solution = conditions.solution(numbers["solution"])
    solution["substep_s"] = defaults.substep(solution["output_step_s"])
    document = completed(
        Case,
        {
            "name": name,
            "helicopter": {"name": name, **helicopter},
            "start": conditions.start(numbers["initials"]),
            "deck": deck,
            "claw": conditions.claw(numbers["prescribed"], records.get("claw", "")),
            "solution": solution,
        },
    )
    document["helicopter"] = completed(Helicopter, document["helicopter"])
    return document, {f"helicopter.{path}": default for path, default in taken.items()}


def completed(model: type[BaseModel], document: Mapping[str, Any]) -> dict[str, Any]:
    """A plain document with the default of every key that it does not have, in the model's order."""
    made: dict[str, Any] = {}
    for key, field in model.model_fields.items():
        if key == "provenance":
            continue
        if key not in document:
            if field.is_required():
                continue
            default = field.get_default(call_default_factory=True)
            made[key] = _plain(default)
        else:
            made[key] = _completed_value(field.annotation, document[key])
    return made


def _completed_value(annotation: Any, value: Any) -> Any:
    models = models_of(annotation)
    if isinstance(value, list) and models and all(isinstance(entry, Mapping) for entry in value):
        return [_completed_value(annotation, entry) for entry in value]
    if not isinstance(value, Mapping) or not models:
        return value
    for model in models:
        field = model.model_fields.get("type")
        if len(models) == 1 or (field is not None and value.get("type") in get_args(field.annotation)):
            return completed(model, value)
    return value


def models_of(annotation: Any) -> list[type[BaseModel]]:
    """The models that a value of an annotation may be of, or be made up of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in models_of(argument)]


def _plain(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    return [_plain(entry) for entry in value] if isinstance(value, tuple) else value


# --- case to numbers -----------------------------------------------------------------------------------------------


def plain(case: Case) -> dict[str, Any]:
    """The complete plain document of a case, its helicopter in full with the changes applied."""
    document = case.model_dump(mode="json", exclude={"provenance"})
    document["helicopter"] = case.vehicle.model_dump(mode="json", exclude={"provenance"})
    document["changes"] = {}
    return document


def numbers_of(document: Mapping[str, Any], records: Mapping[str, Rows]) -> dict[str, Rows]:
    """The numbers of a document in the form that the files can say, and of its records."""
    return {
        "heli": heli.rows(document["helicopter"]),
        "initials": conditions.initials_rows(document),
        "solution": conditions.solution_rows(document["solution"]),
        "prescribed": conditions.prescribed_rows(document["claw"], document["deck"]),
        **records,
    }


class Filing:
    """The numbers of a case, and its document in the form that the files can say.

    Attributes:
        document: The complete plain document with start, deck, claw and solver in the files' form.
        numbers: Numbers of the files, by key.
    """

    def __init__(self, case: Case) -> None:
        self.case = case
        self._batch: Batch | None = None
        document = copy.deepcopy(plain(case))
        document["helicopter"] = heli.filed(case.vehicle)
        document["start"] = self._start()
        records: dict[str, Rows] = {}
        document["claw"] = self._claw(document["claw"], records)
        document["deck"] = self._deck(document["deck"], records)
        if document["solution"]["solver"] not in METHODS.values():
            document["solution"]["solver"] = FALLBACK_SOLVER
        self.document = document
        self.numbers = numbers_of(document, records)

    @property
    def batch(self) -> Batch:
        """The case at its start; made once, and only where it is needed, for it takes the compiled engine."""
        if self._batch is None:
            self._batch = prepared(self.case)
        return self._batch

    def _start(self) -> dict[str, Any]:
        if isinstance(self.case.start, Given):
            return self.case.start.model_dump(mode="json")
        y = self.batch.state[:, 0]
        joints = [State.Q15 + STATION_COORDINATES * i for i in range(STATIONS)]
        return {
            "type": "state",
            "position_m": y[State.Q8 : State.Q10 + 1].tolist(),
            "orientation": y[State.Q11 : State.Q14 + 1].tolist(),
            "strut_m": [float(y[row]) for row in joints],
            "strut_orientations": [y[row + 1 : row + 5].tolist() for row in joints],
            "velocity_mps": y[State.U7 : State.U9 + 1].tolist(),
            "angular_velocity_radps": y[State.U10 : State.U12 + 1].tolist(),
            "strut_rates": y[State.U13 : State.U17 + 1 : 2].tolist(),
            "steer_rates_radps": y[State.U14 : State.U18 + 1 : 2].tolist(),
        }

    def _claw(self, section: dict[str, Any], records: dict[str, Rows]) -> dict[str, Any]:
        claw = self.case.claw
        if isinstance(claw, StillClaw):
            if claw.x_m is None or claw.y_m is None:
                here = self.batch.state[State.CLAW_X : State.CLAW_Y + 1, 0].tolist()
                pairs = zip(("x_m", "y_m"), here, strict=True)
                section.update({key: found if section[key] is None else section[key] for key, found in pairs})
            return section
        if isinstance(claw, ClawFile):
            records["claw"] = read_table(claw.path, CLAW)
            return section
        records["claw"] = self._claw_record(claw)
        return {"type": "file", "path": "", "noise": section["noise"]}

    def _claw_record(self, claw: ClawPoints) -> Rows:
        """The claw's way through its points, without noise, at `RECORD_STEP_S`."""
        solution = self.case.solution
        probe = self.batch.state[State.CLAW_X : State.CLAW_Y + 1, 0]
        quiet = claw.model_copy(update={"noise": None})
        nodes = claw_nodes(quiet, probe, solution.start_s, solution.end_s, RECORD_STEP_S, self.case.seed)
        times = solution.start_s + RECORD_STEP_S * np.arange(len(nodes))
        return tuple((float(t), *node[:3].tolist()) for t, node in zip(times, nodes, strict=True))

    def _deck(self, section: dict[str, Any], records: dict[str, Rows]) -> dict[str, Any]:
        deck = self.case.deck
        if isinstance(deck, Fixed | Sinusoid):
            return section
        if isinstance(deck, MotionFile):
            rows = read_table(deck.path, DECK)
            first = rows[0][0]
            records["deck"] = tuple((row[0] - first, *row[1:]) for row in rows) if first else rows
            return section
        motion = deck.realise(np.random.default_rng(self.case.seed))
        length = self.case.solution.end_s + RECORD_MARGIN_S
        with tempfile.TemporaryDirectory() as room:
            path = write_shipmo(Path(room) / "shipmo.inp", motion, RECORD_STEP_S, length)
            records["deck"] = read_table(path, DECK)
        return {"type": "file", "path": "", "rates": "body", "euler_order": "zyx", "detrend": False}
