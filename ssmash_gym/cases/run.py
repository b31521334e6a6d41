"""Running a case: the compiled engine, or a SciPy solver on the same right-hand side, into one kind of history."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.cases.claw import StillClaw, claw_nodes, longest_node_s, plane_height
from ssmash_gym.cases.description import Case, case_document
from ssmash_gym.cases.start import AT_REST, Settled, place
from ssmash_gym.dynamics import reference
from ssmash_gym.dynamics.layout import ODE_ROWS, Par, State
from ssmash_gym.dynamics.stepper import ABSURD
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.motion import MotionTable
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.claw import ClawLimits
from ssmash_gym.simulation.parameters import Modes
from ssmash_gym.simulation.recording import telemetry_frame, write_recording
from ssmash_gym.simulation.telemetry import CHANNELS, channel
from ssmash_gym.simulation.timing import Timing

Array = NDArray[np.float64]
Progress = Callable[[float], None]
METHODS: Final[dict[str, reference.Method]] = {
    "adams": "Adams",
    "gear": "Gear",
    "automatic": "LSODA",
    "dop853": "DOP853",
    "rk45": "RK45",
    "radau": "Radau",
}


@dataclass(frozen=True, eq=False)
class History:
    """What a case did: one row at the start, then one every output step.

    Attributes:
        case: The case.
        deck: Nodes of the deck's motion; their time 0 is the first row's.
        time_s: Times of the rows (m,) [s].
        states: Rows `layout.State`, (STATE_ROWS, m).
        outputs: Rows `channels`, (OUTPUT_ROWS, m).
        highs: Largest outputs over the substeps since the row before, both ends included, (OUTPUT_ROWS, m).
        lows: Smallest outputs likewise.
        evaluations: Right-hand sides used by a SciPy solver; 0 for the engine.
        wall_s: Time the run took [s].
        diverged: What went wrong, in one sentence; None if nothing. The history ends before it.
    """

    case: Case
    deck: MotionTable
    time_s: Array
    states: Array
    outputs: Array
    highs: Array
    lows: Array
    evaluations: int
    wall_s: float
    diverged: str | None

    @property
    def solver(self) -> str:
        """What solved it."""
        return self.case.solution.solver

    def __getitem__(self, name: str) -> Array:
        """A telemetry channel at the rows, (m,), SI units.

        Raises:
            KeyError: There is no such channel.
        """
        c = channel(name)
        return np.array((self.outputs if c.has_peaks else self.states)[c.row])

    def peak_max(self, name: str) -> Array:
        """Largest value of a channel since the row before, (m,); that of the row for a state."""
        c = channel(name)
        return np.array((self.highs if c.has_peaks else self.states)[c.row])

    def peak_min(self, name: str) -> Array:
        """Smallest value of a channel since the row before, (m,)."""
        c = channel(name)
        return np.array((self.lows if c.has_peaks else self.states)[c.row])

    def largest(self, name: str) -> float:
        """Largest magnitude of a channel in the whole run."""
        return float(max(np.max(self.peak_max(name)), -np.min(self.peak_min(name))))

    def frame(self) -> pl.DataFrame:
        """Every channel against time, with its extremes since the row before."""
        tables = (self.states, self.outputs, self.highs, self.lows)
        return telemetry_frame(self.time_s, np.zeros(self.time_s.size), *tables, list(CHANNELS.values()))

    def write(self, path: str | Path) -> None:
        """Write a recording (Parquet) with the case inside, whole or not at all."""
        about = {"case": case_document(self.case), "seed": self.case.seed, "solver": self.solver}
        write_recording(path, self.frame(), list(CHANNELS.values()), {**about, "diverged": self.diverged})


def run_case(case: Case, progress: Progress | None = None) -> History:
    """Run a case.

    Args:
        case: The case.
        progress: Called now and then with the share done, 0 to 1.

    Raises:
        ConfigurationError: A file of the case cannot be read, a record is too short, or there is no rest to start from.
        SolverError: A SciPy solver gave up.
    """
    begun = time.perf_counter()
    batch = prepared(case)
    if case.solution.equilibrium:
        tables = _Tables(batch)
        tables.take()
        return tables.history(case, 0, time.perf_counter() - begun)
    if case.solution.solver == "engine":
        tables = _advance(case, batch, progress)
        return tables.history(case, 0, time.perf_counter() - begun)
    return _integrate(case, batch, progress, begun)


def prepared(case: Case) -> Batch:
    """The batch of one at the start of its case, deck and claw in their tables.

    Raises:
        ConfigurationError: A file of the case cannot be read, a record is too short, or there is no rest to start from.
    """
    solution = case.solution
    timing = Timing(
        substep_s=solution.substep_s,
        control_interval_s=solution.output_step_s if not solution.equilibrium else solution.substep_s,
        longest_node_s=solution.longest_node_s or longest_node_s(case.claw),
    )
    limits = ClawLimits(height_m=plane_height(case.claw), delay_s=0.0)
    batch = Batch(case.vehicle, 1, timing=timing, modes=Modes(**case.model.model_dump()), claw=limits)
    if case.patch is not None:
        batch.set_patch(case.patch.x_m, case.patch.y_m, case.patch.friction_factor, case.patch.edge_m)
    deck = _deck(case, batch)
    on_level = isinstance(case.start, Settled) and case.start.surface == "level"
    if not on_level:
        batch.set_motion([deck])
    place(batch, case.start, case.name)
    if on_level:
        batch.set_motion([deck])
    _drive(case, batch)
    if solution.equilibrium:
        _rest(case, batch)
    _hold(case, batch)
    batch.evaluate()
    return batch


def _rest(case: Case, batch: Batch) -> None:
    """Settle before anything is held: a rest needs every motion.

    Raises:
        ConfigurationError: There is none.
    """
    left = float(batch.settle()[0])
    if left > AT_REST:
        raise ConfigurationError(
            f"case {case.name}: solution.equilibrium = True is refused: there is no rest on this deck and claw, "
            f"{left:.2g} m/s2 are left."
        )


def _deck(case: Case, batch: Batch) -> MotionTable:
    """Nodes of the deck's motion over the run.

    Raises:
        ConfigurationError: The motion is a record shorter than the run.
    """
    motion = case.deck.realise(np.random.default_rng(case.seed))
    solution, spacing = case.solution, batch.timing.node_spacing_s
    asked = max(solution.end_s - solution.start_s, spacing)
    whole = motion.tabled_s(spacing, solution.start_s)
    if asked > whole + 1e-6:
        raise ConfigurationError(
            f"case {case.name}: solution.end_s = {solution.end_s:g} is refused: the deck's record lasts "
            f"{motion.duration_s:g} s, of which whole nodes of {spacing:g} s are used."
        )
    return motion.bake(min(asked, whole), spacing, ramp_s=case.ramp_s, start_s=solution.start_s)


def _hold(case: Case, batch: Batch) -> None:
    """Hold the listed speeds at zero from now on."""
    for name in case.held:
        row = State[name.upper()]
        batch.parameters[Par.LOCK + row] = 1.0
        batch.state[row] = 0.0


def _drive(case: Case, batch: Batch) -> None:
    """Put the claw where it stands, or give it its history."""
    claw = case.claw
    here = batch.state[State.CLAW_X : State.CLAW_Y + 1, 0]
    if isinstance(claw, StillClaw):
        given = (claw.x_m, claw.y_m)
        here[:] = [there if wanted is None else wanted for there, wanted in zip(here, given, strict=True)]
        return
    solution, spacing = case.solution, batch.timing.node_spacing_s
    nodes = claw_nodes(claw, here, solution.start_s, max(solution.end_s, solution.start_s), spacing, case.seed)
    batch.prescribe_claw(nodes[None])


class _Tables:
    """Rows of a history as the engine makes them."""

    def __init__(self, batch: Batch) -> None:
        self.batch = batch
        self.rows: list[tuple[float, Array, Array, Array, Array]] = []

    def take(self) -> None:
        """Keep the batch as it stands."""
        read = self.batch.telemetry
        kept = (read.state, read.outputs, read.highs, read.lows)
        state, outputs, highs, lows = (table[:, 0].copy() for table in kept)
        self.rows.append((float(self.batch.time_s[0]), state, outputs, highs, lows))

    def history(self, case: Case, evaluations: int, wall_s: float) -> History:
        """The history of what has been kept."""
        times, *columns = zip(*self.rows, strict=True)
        states, outputs, highs, lows = (np.stack(column, axis=1) for column in columns)
        clock = case.solution.start_s + np.array(times)
        told = _divergence(self.batch, case.solution.start_s)
        return History(case, _table(self.batch), clock, states, outputs, highs, lows, evaluations, wall_s, told)


def _table(batch: Batch) -> MotionTable:
    """The deck's motion as the batch has it."""
    return MotionTable(batch.timing.node_spacing_s, batch.nodes[0])


def _divergence(batch: Batch, start_s: float) -> str | None:
    """One sentence on a run that was stopped because its numbers were no longer sound."""
    if not batch.diverged[0]:
        return None
    when = start_s + float(batch.state[State.DIVERGED_CLOCK, 0]) * batch.timing.substep_s
    return _unsound(int(batch.state[State.DIVERGED, 0]) - 1, when)


def _unsound(row: int, when_s: float) -> str:
    """The sentence: which state, and when."""
    name = next((member.name for member in reversed(State) if member <= row), str(row))
    return f"the run diverged at {when_s:.3f} s: the next value of state {name} was not finite or absurd"


def _advance(case: Case, batch: Batch, progress: Progress | None) -> _Tables:
    """The whole run by the engine."""
    tables = _Tables(batch)
    tables.take()
    total = case.solution.rows
    for k in range(total):
        batch.advance()
        if batch.diverged[0]:
            break
        tables.take()
        if progress is not None and k % 50 == 0:
            progress(k / total)
    return tables


def _integrate(case: Case, batch: Batch, progress: Progress | None, begun: float) -> History:
    """The whole run by a SciPy solver, sampled at the engine's substeps."""
    solution, timing = case.solution, batch.timing
    problem = reference.Problem(
        state=batch.state[:, 0].copy(),
        parameters=batch.parameters[:, 0].copy(),
        mode=batch.mode,
        nodes=batch.nodes[0],
        claw_nodes=batch.claw_nodes[0],
        commands=np.zeros((solution.rows, 2)),
        dt=timing.substep_s,
        substeps=timing.substeps,
        substeps_per_node=timing.substeps_per_node,
    )
    # Left to themselves, solvers of high order step over what deck and claw do while the helicopter rests.
    longest = timing.node_spacing_s if _moves(batch) else math.inf
    solved = reference.integrate(
        problem, METHODS[solution.solver], rtol=solution.rtol, atol=solution.atol, max_step=longest, progress=progress
    )
    size = np.sum(np.abs(solved.states[:ODE_ROWS]), axis=0)
    unsound = np.flatnonzero(~(size < ABSURD))
    sound = int(unsound[0]) if unsound.size else size.size
    rows = np.arange(0, sound, timing.substeps)
    highs, lows = (_extremes(solved.outputs, rows, pick) for pick in (np.maximum, np.minimum))
    wall = time.perf_counter() - begun
    diverged = None
    if unsound.size:
        worst = int(np.argmax(np.abs(solved.states[:ODE_ROWS, sound])))
        diverged = _unsound(worst, solution.start_s + float(solved.time_s[sound]))
    tables = (solved.states[:, rows], solved.outputs[:, rows], highs, lows)
    clock = solution.start_s + solved.time_s[rows]
    return History(case, _table(batch), clock, *tables, solved.evaluations, wall, diverged)


def _moves(batch: Batch) -> bool:
    """Whether deck or claw move at all."""
    deck, claw = batch.nodes[0], batch.claw_nodes[0]
    return bool(np.any(deck[:, 6:]) or np.any(claw[:, 3:]) or np.ptp(claw[:, :3], axis=0).any())


def _extremes(outputs: Array, rows: NDArray[np.int64], pick: np.ufunc) -> Array:
    """Extremes between each row and the one before, both included, (OUTPUT_ROWS, rows)."""
    found = outputs[:, rows].copy()
    if rows.size > 1:
        over = pick.reduceat(outputs[:, :-1], rows[:-1], axis=1)
        found[:, 1:] = pick(over, outputs[:, rows[1:]])
    return found
