"""Running the trials of the verification table, one as a case or many rests at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.analysis.verification.table import REFERENCE, PrintedRow, VerificationTable
from ssmash_gym.cases import Case, History, case_document, quantity, run_case
from ssmash_gym.cases.start import AT_REST
from ssmash_gym.document import write_yaml
from ssmash_gym.dynamics.layout import SPEEDS, STATION_COORDINATES, STATIONS, Par, State
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.ship.motion import MotionTable
from ssmash_gym.ship.sources import Fixed
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.claw import ClawLimits
from ssmash_gym.simulation.parameters import Modes
from ssmash_gym.simulation.settle import newton, remaining, tire_travel
from ssmash_gym.vehicle import Helicopter, document_of, load_helicopter

Array = NDArray[np.float64]
_EVERY: Final = np.arange(SPEEDS)
RAMP: Final = 4  # parts in which a deck tilts and a wind rises
DISPLACEMENTS: Final = ("x_m", "y_m")  # from the reference state; everything else is the value itself


@dataclass(frozen=True)
class Result:
    """One printed value beside the simulated one; `initial` is what the reference state has."""

    trial: str
    row: PrintedRow
    simulated: float
    initial: float

    @property
    def as_expected(self) -> bool | None:
        """Whether it goes the way the table expects in words; None where it says a number, "small" or nothing."""
        words = str(self.row.expected).split()
        change = self.simulated - self.initial
        for word, sign in (("positive", self.simulated), ("negative", -self.simulated), ("increase", change),
                           ("decrease", -change)):  # fmt: skip
            if word in words:
                return sign > 0.0
        return None

    @property
    def difference(self) -> float:
        """Simulated minus printed; minus the corrected value where there is one."""
        aim = self.row.aim
        return self.simulated - (self.row.printed if aim is None else aim)

    @property
    def passed(self) -> bool | None:
        """Whether the difference is within the tolerance; None where there is nothing right to compare with."""
        return None if self.row.aim is None else abs(self.difference) <= self.row.tolerance


@dataclass(frozen=True)
class Varied:
    """What a variation of a trial comes to."""

    trial: str
    label: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class Verification:
    """The whole table, run."""

    table: VerificationTable
    helicopter: str
    results: tuple[Result, ...]
    varied: tuple[Varied, ...]

    def of(self, trial: str, name: str) -> Result:
        """The result of one printed value.

        Raises:
            KeyError: There is none.
        """
        for result in self.results:
            if (result.trial, result.row.quantity) == (trial, name):
                return result
        raise KeyError(f"case {trial} has no row {name}")


def run_table(
    table: VerificationTable,
    helicopter: Helicopter | None = None,
    only: Sequence[str] | None = None,
    progress: Callable[[str], None] | None = None,
    name: str = "",
) -> Verification:
    """Run the trials and compare.

    Args:
        table: The table.
        helicopter: Another helicopter than the table's own.
        only: Trials to run; all by default.
        progress: Called with the name of what runs next.
        name: What the report calls the helicopter; the file of the table's own by default.

    Raises:
        ConfigurationError: A trial does not exist, or is refused.
    """
    chosen = list(table.trials) if only is None else list(only)
    for key in chosen:
        if key not in table.trials:
            raise ConfigurationError(f"--case {key} is refused: the cases are {', '.join(table.trials)}.")
    helicopter = load_helicopter(table.helicopter) if helicopter is None else helicopter
    tell = progress or (lambda _: None)
    document = document_of(helicopter)
    tell("the reference")
    reference = _run(table.trials[REFERENCE].case(helicopter, document))
    start = state_start(reference)
    results, varied = [], []
    for key in chosen:
        trial = table.trials[key]
        tell(f"case {key}")
        history = reference if key == REFERENCE else _run(trial.case(helicopter, document, start))
        names = [row.quantity for row in trial.file.rows]
        read, initial = read_values(history, names), read_values(reference, names)
        results += [
            Result(key, row, float(read[row.quantity][-1]), float(initial[row.quantity][-1])) for row in trial.file.rows
        ]
        for variation in trial.file.variations:
            tell(f"case {key}, {variation.label}")
            again = read_values(_run(trial.case(helicopter, document, start, variation)), names)
            varied.append(Varied(key, variation.label, {name: float(again[name][-1]) for name in names}))
    named = name or f"configs/helicopters/{table.helicopter}.yaml"
    return Verification(table, named, tuple(results), tuple(varied))


def write_cases(
    table: VerificationTable, helicopter: Helicopter, folder: Path, only: Sequence[str] | None = None
) -> None:
    """Write the trials as complete case files ``case_<number>.yaml``, helicopter and start included.

    Args:
        table: The table.
        helicopter: Their helicopter.
        folder: Where to; made if it is not there.
        only: Trials to write; all by default.
    """
    document = document_of(helicopter)
    start = state_start(_run(table.trials[REFERENCE].case(helicopter, document)))
    folder.mkdir(parents=True, exist_ok=True)
    for key in table.trials if only is None else only:
        case = table.trials[key].case(helicopter, document, start)
        write_text(folder / f"case_{key}.yaml", write_yaml(case_document(case)))


def _run(case: Case) -> History:
    history = run_case(case)
    if history.diverged is not None:
        raise ConfigurationError(f"{case.name}: {history.diverged}.")
    return history


def state_start(history: History) -> dict[str, Any]:
    """The last row of a history as the start of a case, at rest."""
    state = [float(value) for value in history.states[:, -1]]
    struts = [State.Q15 + STATION_COORDINATES * i for i in range(STATIONS)]
    return {
        "type": "state",
        "position_m": state[State.Q8 : State.Q10 + 1],
        "orientation": state[State.Q11 : State.Q14 + 1],
        "strut_m": [state[row] for row in struts],
        "strut_orientations": [state[row + 1 : row + STATION_COORDINATES] for row in struts],
    }


def read_values(history: History, names: Sequence[str], start: History | None = None) -> dict[str, Array]:
    """Quantities at the rows of a history, displacements from its first row or from that of `start`."""
    read = {}
    for name in names:
        values = quantity(name).of(history)
        read[name] = values - quantity(name).of(start or history)[0] if name in DISPLACEMENTS else values
    return read


def rests(cases: Sequence[Case], fleets: Sequence[Sequence[Helicopter]]) -> list[History]:
    """Rests of several cases with several helicopters each, in one batch.

    At rest on a level deck in still air first; then deck and wind come up in parts, and tires keep what the carriages
    have moved over the deck. That is where the run in time ends, too (tests/verification/test_identification.py).

    Args:
        cases: Trials on a fixed deck that come to rest, with the common start and claw.
        fleets: For each case its helicopters, changed already; all of one layout.

    Returns:
        For each case a history whose "times" are the helicopters.

    Raises:
        ConfigurationError: There is no rest.
    """
    everyone = [helicopter for fleet in fleets for helicopter in fleet]
    modes = Modes(**cases[0].model.model_dump())
    batch = Batch(everyone, modes=modes, claw=ClawLimits(height_m=0.0, delay_s=0.0))
    wind = batch.parameters[Par.WIND : Par.WIND + 3].copy()
    batch.parameters[Par.WIND : Par.WIND + 3] = 0.0
    left = batch.place(0.0, 0.0, 0.0)
    for share in np.arange(1, RAMP + 1) / RAMP:
        tables = [_tilted(case, share, batch.timing.node_spacing_s) for case in cases]
        batch.set_motion([table for table, fleet in zip(tables, fleets, strict=True) for _ in fleet])
        batch.parameters[Par.WIND : Par.WIND + 3] = np.sqrt(share) * wind
        _follow(batch)
    left = remaining(batch, batch.columns(None))
    if left.max() > AT_REST:
        raise ConfigurationError("no rest was found for one of the helicopters.")
    read = batch.evaluate()
    found, begin = [], 0
    for case, table, fleet in zip(cases, tables, fleets, strict=True):
        columns = slice(begin, begin + len(fleet))
        begin += len(fleet)
        states, outputs = read.state[:, columns].copy(), read.outputs[:, columns].copy()
        found.append(History(case, table, np.zeros(len(fleet)), states, outputs, outputs, outputs, 0, 0.0, None))
    return found


def _follow(batch: Batch) -> None:
    """Newton's method from the last rest to the next; tires deflect by the mean of their travel at both ends."""
    columns = np.flatnonzero(remaining(batch, batch.columns(None)) > AT_REST)
    if not columns.size:
        return
    begin = batch.state[:, columns].copy()
    travel = tire_travel(batch, columns)
    newton(batch, columns, _EVERY, travel)
    travel = 0.5 * (travel + tire_travel(batch, columns))
    batch.state[:, columns] = begin
    newton(batch, columns, _EVERY, travel)


def _tilted(case: Case, share: float, spacing_s: float) -> MotionTable:
    """A deck at rest at a share of the case's angles."""
    assert isinstance(case.deck, Fixed)
    deck = Fixed(roll_deg=share * case.deck.roll_deg, pitch_deg=share * case.deck.pitch_deg)
    return deck.bake(spacing_s, spacing_s)
