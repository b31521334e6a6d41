"""Reference integration: SciPy's adaptive solvers on the very same right-hand side.

For verification and as a user's option. The claw's motion is that of the fixed-step drive (its commands change on
substep boundaries), taken between substeps as the parabola it is; everything else is integrated to tolerance. The
thesis' program offers Adams, Gear, and a method that changes between them by itself (SOLUTION.INP, line 6: 1, 2, 3);
here these are ``Adams``, ``Gear`` and ``LSODA``.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import BDF, DOP853, LSODA, RK45, OdeSolver, Radau, ode

from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.aero import place_wind
from ssmash_gym.dynamics.claw import advance_claw, place_claw
from ssmash_gym.dynamics.deck import COEFFICIENTS, deck_kinematics, gather_piece, prescribed_claw
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import DECK_ROWS, ODE_ROWS, STATE_ROWS, ClawDrive, Mode, Par, State
from ssmash_gym.dynamics.prescribed import CLAW_CHANNELS, DECK_CHANNELS, GUST_CHANNELS
from ssmash_gym.errors import SolverError

Array = NDArray[np.float64]
RightHandSide = Callable[[float, Array], Array]
Method = Literal["DOP853", "LSODA", "RK45", "Radau", "BDF", "Adams", "Gear"]
_SOLVERS: Final[dict[Method, Callable[..., OdeSolver[np.float64]]]] = {
    "DOP853": DOP853,
    "LSODA": LSODA,
    "RK45": RK45,
    "Radau": Radau,
    "BDF": BDF,
}
_VODE: Final[dict[Method, Literal["adams", "bdf"]]] = {"Adams": "adams", "Gear": "bdf"}
MOST_STEPS: Final = 20_000  # of a multistep method from one sample to the next
SPARE_EVALUATIONS: Final = 100_000  # what a run may use, beside
EVALUATIONS_PER_S: Final = 500_000  # so many for each simulated second behind it; a sound run needs a tenth


@dataclass(frozen=True)
class Reference:
    """History of one helicopter at the substep boundaries.

    Attributes:
        time_s: (m,); states: (STATE_ROWS, m); outputs: (OUTPUT_ROWS, m); evaluations: right-hand sides used.
    """

    time_s: Array
    states: Array
    outputs: Array
    evaluations: int


@dataclass(frozen=True)
class Problem:
    """One helicopter to integrate: tables as in `engine.advance`, for a single column.

    Attributes:
        state: (STATE_ROWS,); parameters: (PARAMETER_ROWS,); mode: (MODES,); nodes: (nodes, 18) deck motion;
        claw_nodes: (nodes, 9), used when the claw is prescribed; commands: (intervals, 2) normalised; substeps of
        `dt` in an interval; substeps_per_node; clock: substeps since the start of the tables; gust_nodes: (nodes, 3)
        gust speed [m/s] and its two rates, None for no gust.
    """

    state: Array
    parameters: Array
    mode: NDArray[np.int64]
    nodes: Array
    claw_nodes: Array
    commands: Array
    dt: float
    substeps: int
    substeps_per_node: int
    clock: int = 0
    gust_nodes: Array | None = None


class _Decks:
    """What is prescribed to the helicopter (deck, wind, claw) at any time of the run."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.start_s = problem.clock * problem.dt
        self.spacing_s = problem.substeps_per_node * problem.dt
        self.claw_rows = _claw_rows(problem)
        gusts = np.zeros((2, 3 * GUST_CHANNELS)) if problem.gust_nodes is None else problem.gust_nodes
        self.gusts = _coefficients(gusts, GUST_CHANNELS, self.spacing_s)
        self.claws = _coefficients(problem.claw_nodes, CLAW_CHANNELS, self.spacing_s)
        self.gusty = int(np.any(problem.parameters[Par.GUST : Par.GUST + 3]))
        self.ripple = int(np.any(problem.parameters[Par.RIPPLE_X : Par.RIPPLE_X + 2]))

    def at(self, t: float) -> Array:
        """`Deck` rows (DECK_ROWS, 1) at `t` seconds after the start of the run."""
        deck = engine.deck_rows(self.problem.nodes[None], self.start_s + t, self.spacing_s)
        self._complete(np.float64(t), deck[:, 0], self.problem.parameters)
        return deck

    def over(self, times: Array) -> Array:
        """`Deck` rows (DECK_ROWS, m) at the times (m,) [s]."""
        decks = np.zeros((DECK_ROWS, times.size))
        c, since = self._passed(times, _coefficients(self.problem.nodes, DECK_CHANNELS, self.spacing_s))
        uncompiled(deck_kinematics)(c, since, decks)
        self._complete(times, decks, self.problem.parameters[:, None])
        return decks

    def _complete(self, times: Array | np.float64, decks: Array, parameters: Array) -> None:
        """Write claw and wind rows of `decks` (DECK_ROWS, m) at times (m,), or (DECK_ROWS,) at one."""
        if self.problem.mode[Mode.CLAW] == ClawDrive.PRESCRIBED:
            uncompiled(prescribed_claw)(*self._passed(times, self.claws), decks)
        else:
            y = np.zeros((STATE_ROWS, *times.shape))
            y[State.CLAW_X : State.CLAW_VY + 1] = self.claw(times)
            uncompiled(place_claw)(y, parameters, self.ripple, self.start_s + times, decks)
        uncompiled(place_wind)(parameters, self.gusty, *self._passed(times, self.gusts), decks)

    def _passed(self, times: Array | np.float64, coefficients: Array) -> tuple[Array, Array]:
        """Coefficients of the pieces that the times lie in (the last one goes on), and the times since their nodes."""
        time = self.start_s + times
        pieces = np.minimum((time / self.spacing_s).astype(np.int64), coefficients.shape[1] - 1)
        return coefficients[:, pieces], time - pieces * self.spacing_s

    def claw(self, times: Array | np.float64) -> Array:
        """Claw x, y, vx, vy (4, m), or (4,) at one time: velocity linear, position parabolic within a substep."""
        s = times / self.problem.dt
        k = np.minimum(s.astype(np.int64), self.claw_rows.shape[1] - 2)
        a, b, f = self.claw_rows[:, k], self.claw_rows[:, k + 1], s - k
        velocity = a[2:] + f * (b[2:] - a[2:])
        return np.concatenate([a[:2] + 0.5 * f * self.problem.dt * (a[2:] + velocity), velocity])


def _coefficients(nodes: Array, channels: int, spacing_s: float) -> Array:
    """Coefficients of all pieces of one table (nodes, 3 channels), (6 channels, pieces)."""
    pieces = np.arange(nodes.shape[0] - 1)
    c = np.empty((channels * COEFFICIENTS, pieces.size))
    uncompiled(gather_piece)(nodes[None], np.zeros_like(pieces), pieces, channels, spacing_s, c, slice(None))
    return c


def _claw_rows(problem: Problem) -> Array:
    """Claw x, y, vx, vy (4, substeps + 1) of the fixed-step drive over the whole run."""
    start = problem.state[State.CLAW_X : State.CLAW_VY + 1]
    if not _claw_moves(problem):
        return np.repeat(start[:, None], problem.commands.shape[0] * problem.substeps + 1, axis=1)
    p = problem.parameters[:, None]
    interval = problem.substeps * problem.dt
    history = int(np.ceil(problem.parameters[Par.CLAW_DELAY] / interval - 1e-9)) + 1
    command = np.zeros((2 * history, 1))
    step = uncompiled(advance_claw)
    y = problem.state[:, None].copy()
    rows = [start.copy()]
    for values in problem.commands:
        command[2:] = command[:-2]
        command[:2, 0] = values
        for s in range(problem.substeps):
            after = y.copy()
            step(y, p, command, history, s * problem.dt, interval, problem.dt, after)
            y = after
            rows.append(y[State.CLAW_X : State.CLAW_VY + 1, 0].copy())
    return np.array(rows).T


def _claw_moves(problem: Problem) -> bool:
    """Whether the drive is told to move the claw, or finds it moving."""
    return bool(np.any(problem.commands) or np.any(problem.state[State.CLAW_VX : State.CLAW_VY + 1]))


class _GaveUp(Exception):
    """A solver cannot go on, and why."""


# What SciPy's solvers end with when the numbers are no longer sound.
_SIGNS: Final = (_GaveUp, ArithmeticError, ValueError, np.linalg.LinAlgError)


class _Watch:
    """The right-hand side, counted; tells how far the run has come and stops one that gets nowhere."""

    def __init__(self, rhs: RightHandSide, end_s: float, progress: Callable[[float], None] | None) -> None:
        self.rhs, self.end_s, self.progress = rhs, end_s, progress
        self.evaluations = 0
        self.reached_s = 0.0
        self.told = 0.0
        self.spent = ""

    def __call__(self, t: float, y: Array) -> Array:
        self.evaluations += 1
        if self.evaluations > SPARE_EVALUATIONS + EVALUATIONS_PER_S * self.reached_s:
            self.spent = self.spent or f"{self.evaluations - 1} right-hand sides are used up"
            raise _GaveUp(self.spent)
        return self.rhs(t, y)

    def reach(self, t: float) -> None:
        """Note that the run has come to time `t` [s]."""
        self.reached_s = max(self.reached_s, t)
        if self.progress is not None and self.reached_s >= self.told + 0.005 * self.end_s:
            self.told = self.reached_s
            self.progress(min(self.reached_s / self.end_s, 1.0))


def integrate(
    problem: Problem,
    method: Method = "DOP853",
    *,
    rtol: float = 1e-9,
    atol: float = 1e-10,
    max_step: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Reference:
    """Integrate one helicopter with a SciPy solver and sample it at every substep boundary.

    Capture and loss of the probe are not events here: the status of the start is kept.

    Args:
        problem: What to integrate.
        method: ``DOP853``, ``RK45`` (explicit Runge-Kutta), ``Radau`` (implicit Runge-Kutta), ``BDF``; of the
            multistep methods of the LSODE family ``Adams`` (variable order, functional iteration), ``Gear`` (backward
            differentiation, Newton iteration) and ``LSODA``, which changes between the two by itself.
        rtol: Relative tolerance of every integrated row.
        atol: Absolute tolerance of every integrated row, in its unit.
        max_step: Longest step [s]; None leaves it to the solver, which may then step over what is short.
        progress: Called now and then with the share of the run that is done, 0 to 1.

    Raises:
        SolverError: the solver gave up, or used far more right-hand sides than any sound run does.
    """
    decks = _Decks(problem)
    full = problem.state[:, None].copy()
    parameters = problem.parameters[:, None]

    def rhs(t: float, y: Array) -> Array:
        full[:ODE_ROWS, 0] = y
        return np.asarray(engine.derivative(full, parameters, problem.mode, decks.at(t))[0][:, 0])

    times = np.arange(problem.commands.shape[0] * problem.substeps + 1) * problem.dt
    states = np.empty((STATE_ROWS, times.size))
    states[:] = problem.state[:, None]
    watch = _Watch(rhs, float(times[-1]), progress)
    solve = _multistep if method in _VODE else _stepwise
    for first, last in itertools.pairwise(_segments(problem)):
        grid = times[first : last + 1]
        try:
            states[:ODE_ROWS, first : last + 1] = solve(
                watch, grid, states[:ODE_ROWS, first], method, rtol, atol, max_step
            )
        except _SIGNS as error:
            raise SolverError(f"{method} gave up at t = {watch.reached_s:g} s: {watch.spent or error}") from error
        if not np.all(np.isfinite(states)):
            raise SolverError(f"{method} gave up by t = {watch.reached_s:g} s: the state is no longer finite")
    states[State.CLAW_X : State.CLAW_VY + 1] = decks.claw_rows
    if progress is not None:
        progress(1.0)
    repeated = np.repeat(parameters, times.size, axis=1)
    outputs = engine.derivative(states, repeated, problem.mode, decks.over(times))[1]
    return Reference(times, states, outputs, watch.evaluations)


def _stepwise(
    watch: _Watch, grid: Array, start: Array, method: Method, rtol: float, atol: float, max_step: float | None
) -> Array:
    """Integrate by one of SciPy's solver classes; rows at the times of `grid`, (ODE_ROWS, m)."""
    longest = np.inf if max_step is None else max_step
    solver = _SOLVERS[method](watch, grid[0], start, grid[-1], rtol=rtol, atol=atol, max_step=longest)
    rows = np.empty((start.size, grid.size))
    done = 0
    while done < grid.size:
        message = solver.step()
        if solver.status == "failed":
            raise _GaveUp(message)
        watch.reach(solver.t)
        upto = int(np.searchsorted(grid, solver.t, side="right"))
        if upto > done:
            rows[:, done:upto] = solver.dense_output()(grid[done:upto])
            done = upto
    return rows


def _multistep(
    watch: _Watch, grid: Array, start: Array, method: Method, rtol: float, atol: float, max_step: float | None
) -> Array:
    """Integrate by VODE; rows at the times of `grid`, (ODE_ROWS, m). It steps beyond them and interpolates."""
    solver = ode(watch).set_integrator(
        "vode", method=_VODE[method], with_jacobian=method == "Gear", rtol=rtol, atol=atol, nsteps=MOST_STEPS,
        max_step=0.0 if max_step is None else max_step,
    )  # fmt: skip
    solver.set_initial_value(start, grid[0])
    rows = np.empty((start.size, grid.size))
    rows[:, 0] = start
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for k, t in enumerate(grid[1:], 1):
            rows[:, k] = solver.integrate(t)
            if not solver.successful():
                raise _GaveUp(told[-1].message if told else "no reason was given")
            watch.reach(t)
    return rows


def _segments(problem: Problem) -> list[int]:
    """Substeps at which the solver restarts: every change of command, or none while the claw stands still."""
    total = problem.commands.shape[0] * problem.substeps
    if not _claw_moves(problem) or problem.mode[Mode.CLAW] == ClawDrive.PRESCRIBED:
        return [0, total]
    return list(range(0, total + 1, problem.substeps))
