"""Reference integration: SciPy's adaptive solvers on the very same right-hand side.

For verification and as a user's option. The claw's motion is that of the fixed-step drive (its commands change on
substep boundaries), taken between substeps as the parabola it is; everything else is integrated to tolerance.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.claw import advance_claw, place_claw
from ssmash_gym.dynamics.deck import COEFFICIENTS, gather_piece, prescribed_claw
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import (
    DECK_ROWS,
    ODE_ROWS,
    STATE_ROWS,
    ClawDrive,
    Mode,
    Par,
    State,
)

Array = NDArray[np.float64]
Method = Literal["DOP853", "LSODA", "RK45", "Radau", "BDF"]


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


class _Claw:
    """Claw history of the fixed-step drive over the whole run, and its place at any time in it."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        p = problem.parameters[:, None]
        history = int(np.ceil(problem.parameters[Par.CLAW_DELAY] / (problem.substeps * problem.dt) - 1e-9)) + 1
        command = np.zeros((2 * history, 1))
        step = uncompiled(advance_claw)
        y = problem.state[:, None].copy()
        rows = [y[State.CLAW_X : State.CLAW_VY + 1, 0].copy()]
        for values in problem.commands:
            command[2:] = command[:-2]
            command[:2, 0] = values
            for s in range(problem.substeps):
                after = y.copy()
                interval = problem.substeps * problem.dt
                step(y, p, command, history, s * problem.dt, interval, problem.dt, after)
                y = after
                rows.append(y[State.CLAW_X : State.CLAW_VY + 1, 0].copy())
        self.rows = np.array(rows)
        self.place = uncompiled(place_claw)
        self.prescribed = uncompiled(prescribed_claw)
        self.piece = uncompiled(gather_piece)
        self.ripple = int(np.any(problem.parameters[Par.RIPPLE_X : Par.RIPPLE_X + 2]))

    def write(self, t: float, deck: Array) -> None:
        """Claw rows of `deck` (DECK_ROWS, 1) at `t` seconds after the start of the run."""
        problem = self.problem
        time = problem.clock * problem.dt + t
        if problem.mode[Mode.CLAW] == ClawDrive.PRESCRIBED:
            spacing = problem.substeps_per_node * problem.dt
            k = min(int(time / spacing), problem.claw_nodes.shape[0] - 2)
            c = np.empty((3 * COEFFICIENTS, 1))
            self.piece(problem.claw_nodes[None], 0, k, 3, spacing, c, 0)
            self.prescribed(c, np.array([time - k * spacing]), deck)
            return
        y = np.zeros((STATE_ROWS, 1))
        y[State.CLAW_X : State.CLAW_VY + 1, 0] = self.state(t)
        self.place(y, problem.parameters[:, None], self.ripple, np.array([time]), deck)

    def state(self, t: float) -> Array:
        """Claw x, y, vx, vy at `t`: velocity linear, position parabolic within a substep."""
        s = t / self.problem.dt
        k = min(int(s), len(self.rows) - 2)
        a, b, f = self.rows[k], self.rows[k + 1], s - k
        velocity = a[2:] + f * (b[2:] - a[2:])
        return np.concatenate([a[:2] + 0.5 * f * self.problem.dt * (a[2:] + velocity), velocity])


def integrate(problem: Problem, method: Method = "DOP853", *, rtol: float = 1e-9, atol: float = 1e-10) -> Reference:
    """Integrate one helicopter with a SciPy solver and sample it at every substep boundary.

    Capture and loss of the probe are not events here: the status of the start is kept.

    Raises:
        RuntimeError: the solver gave up.
    """
    claw = _Claw(problem)
    spacing = problem.substeps_per_node * problem.dt
    full = problem.state[:, None].copy()
    parameters = problem.parameters[:, None]
    start = problem.clock * problem.dt
    gusts = np.zeros((1, 2, 3)) if problem.gust_nodes is None else problem.gust_nodes[None]

    def decks(t: float) -> Array:
        deck = engine.deck_rows(problem.nodes[None], start + t, spacing)
        claw.write(t, deck)
        piece = min(int((start + t) / spacing), gusts.shape[1] - 2)
        engine.write_wind(parameters, gusts, np.array([piece]), np.array([start + t - piece * spacing]), spacing, deck)
        return deck

    def rhs(t: float, y: Array) -> Array:
        full[:ODE_ROWS, 0] = y
        return np.asarray(engine.derivative(full, parameters, problem.mode, decks(t))[0][:, 0])

    times = np.arange(problem.commands.shape[0] * problem.substeps + 1) * problem.dt
    breaks = _segments(problem)
    states = np.empty((STATE_ROWS, times.size))
    states[:] = problem.state[:, None]
    evaluations = 0
    for first, last in itertools.pairwise(breaks):
        y0 = states[:ODE_ROWS, first]
        grid = times[first : last + 1]
        solution = solve_ivp(rhs, (grid[0], grid[-1]), y0, method, grid, rtol=rtol, atol=atol)
        if not solution.success:
            raise RuntimeError(f"{method} gave up at t = {solution.t[-1]:g} s: {solution.message}")
        states[:ODE_ROWS, first : last + 1] = solution.y
        evaluations += int(solution.nfev)
    states[State.CLAW_X : State.CLAW_VY + 1] = claw.rows.T
    return Reference(times, states, _outputs(problem, states, times, decks), evaluations)


def _segments(problem: Problem) -> list[int]:
    """Substeps at which the solver restarts: every change of command, or none while the claw stands still."""
    total = problem.commands.shape[0] * problem.substeps
    moving = np.any(problem.commands) or np.any(problem.state[State.CLAW_VX : State.CLAW_VY + 1])
    if not moving or problem.mode[Mode.CLAW] == ClawDrive.PRESCRIBED:
        return [0, total]
    return list(range(0, total + 1, problem.substeps))


def _outputs(problem: Problem, states: Array, times: Array, decks: Callable[[float], Array]) -> Array:
    """Kernel outputs at all samples."""
    rows = np.empty((DECK_ROWS, times.size))
    for k, t in enumerate(times):
        rows[:, k] = decks(float(t))[:, 0]
    parameters = np.repeat(problem.parameters[:, None], times.size, axis=1)
    return engine.derivative(states, parameters, problem.mode, rows)[1]
