"""One control interval of a block of helicopters: linearly implicit Heun substeps, claw, capture, peaks.

Two-stage Rosenbrock-W scheme with gamma = 1 - 1/sqrt(2) and C the diagonal secant slopes of the joint dissipation:
``a1 = (M(y) + g h C)^-1 f(y)``, ``y* = y + h a1``, ``a2 = (M(y*) + g h C)^-1 (f(y*) + 2 g h C a1)``,
``y <- y + h/2 (a1 + a2)``. Order 2 for any C, L-stable in what C covers; plain Heun for all other rows.
"""

from __future__ import annotations

import math
from typing import Any

from ssmash_gym.dynamics.channels import OUTPUT_ROWS, Out
from ssmash_gym.dynamics.claw import advance_claw
from ssmash_gym.dynamics.lane import any_lane, fabs, kernel, load, maximum, minimum, splat, sqrt, store, where
from ssmash_gym.dynamics.layout import (
    DECK_ROWS,
    ODE_ROWS,
    STATE_ROWS,
    STATION_COORDINATES,
    STATIONS,
    WORK_ROWS,
    Mode,
    State,
)
from ssmash_gym.dynamics.prescribed import (
    CLAW_PIECES,
    DECK_PIECES,
    GUST_PIECES,
    gather_pieces,
    prescribe,
)
from ssmash_gym.dynamics.probe import capture
from ssmash_gym.dynamics.system import attitude_outputs, rates

GAMMA = 1.0 - math.sqrt(0.5)
ABSURD = 1.0e6  # sum of the magnitudes of all integrated rows beyond which a state counts as diverged
FAR = math.inf
LARGEST = 1.0e308  # bound of the refused value that is kept


@kernel
def normalise(y: Any) -> None:
    """Bring the four sets of Euler parameters back to unit length."""
    for k in range(STATIONS + 1):
        row = State.Q11 + (0 if k == 0 else 5 + STATION_COORDINATES * (k - 1))
        e0 = load(y, row)
        e1 = load(y, row + 1)
        e2 = load(y, row + 2)
        e3 = load(y, row + 3)
        inverse = 1.0 / sqrt(maximum(e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3, 1.0e-30))
        store(y, row, e0 * inverse)
        store(y, row + 1, e1 * inverse)
        store(y, row + 2, e2 * inverse)
        store(y, row + 3, e3 * inverse)


@kernel
def record_peaks(o: Any, high: Any, low: Any) -> None:
    """Running extremes of all outputs."""
    for k in range(OUTPUT_ROWS):
        value = load(o, k)
        store(high, k, maximum(load(high, k), value))
        store(low, k, minimum(load(low, k), value))


@kernel
def total_size(trial: Any) -> Any:
    """Sum of the magnitudes of all integrated rows; four sums at a time, for short chains."""
    a = fabs(load(trial, 0))
    b = fabs(load(trial, 1))
    c = fabs(load(trial, 2))
    d = fabs(load(trial, 3))
    for k in range(1, ODE_ROWS // 4):
        a = a + fabs(load(trial, 4 * k))
        b = b + fabs(load(trial, 4 * k + 1))
        c = c + fabs(load(trial, 4 * k + 2))
        d = d + fabs(load(trial, 4 * k + 3))
    return (a + b) + (c + d)


@kernel
def accept(y: Any, trial: Any, clock: Any) -> None:
    """Take the trial state where it is sound; hold the last sound state, and say so, where it is not.

    A NaN fails the comparison, so it can never be accepted.
    """
    sound = total_size(trial) < ABSURD
    held = load(y, State.DIVERGED) > 0.5
    take = sound & ~held
    if any_lane(~take):
        report(y, trial, ~sound & ~held, clock)
        for k in range(State.PROBE_CAPTURED):
            store(trial, k, where(take, load(trial, k), load(y, k)))
    for k in range(State.PROBE_CAPTURED):
        store(y, k, load(trial, k))


@kernel
def report(y: Any, trial: Any, broken: Any, clock: Any) -> None:
    """Note the first row that is not finite or absurd, when, and its value, for the lanes that have just diverged.

    The value is kept within +-`LARGEST`, and a NaN as 0, so that the state never holds anything but numbers.
    """
    code = splat(0.0)
    value = load(trial, 0)
    for m in range(ODE_ROWS):
        k = ODE_ROWS - 1 - m
        refused = load(trial, k)
        sound = fabs(refused) < ABSURD / ODE_ROWS
        code = where(sound, code, k + 1.0)
        value = where(sound, value, refused)
    value = where(
        value > LARGEST, LARGEST, where(value < -LARGEST, -LARGEST, where(fabs(value) <= LARGEST, value, 0.0))
    )
    store(y, State.DIVERGED, where(broken, maximum(code, 1.0), load(y, State.DIVERGED)))
    store(y, State.DIVERGED_CLOCK, where(broken, clock, load(y, State.DIVERGED_CLOCK)))
    store(y, State.DIVERGED_VALUE, where(broken, value, load(y, State.DIVERGED_VALUE)))


@kernel
def update_capture(y: Any, p: Any, o: Any) -> None:
    """Capture and loss of the probe, from the outputs at the start of the substep."""
    fx = load(o, Out.PROBE_FX)
    fy = load(o, Out.PROBE_FY)
    fz = load(o, Out.PROBE_FZ)
    status = capture(
        p,
        load(o, Out.PROBE_DX),
        load(o, Out.PROBE_DY),
        load(o, Out.PROBE_REACH),
        sqrt(fx * fx + fy * fy + fz * fz),
        load(y, State.PROBE_CAPTURED),
        load(y, State.PROBE_LOST),
    )
    store(y, State.PROBE_CAPTURED, status[0])
    store(y, State.PROBE_LOST, status[1])


@kernel
def start_second_stage(y: Any, first: Any, stage: Any, h: float) -> None:
    """``stage = y + h k1``; rows outside the integration are carried over."""
    for k in range(ODE_ROWS):
        store(stage, k, load(y, k) + h * load(first, k))
    for k in range(ODE_ROWS, State.DIVERGED):
        store(stage, k, load(y, k))


@kernel
def start_block(high: Any, low: Any, tau: Any) -> None:
    """No piece has been gathered yet, and no extreme met."""
    for lane in range(tau.shape[1]):
        tau[3, lane] = -1.0
    for k in range(OUTPUT_ROWS):
        for lane in range(tau.shape[1]):
            high[k, lane] = -FAR
            low[k, lane] = FAR


@kernel
def advance_block(
    y: Any,
    p: Any,
    commands: Any,
    mode: Any,
    nodes: Any,
    claw_nodes: Any,
    gust_nodes: Any,
    columns: Any,
    clock: Any,
    history: int,
    substeps: int,
    dt: float,
    spn: int,
    ripple: int,
    gusty: int,
    o: Any,
    high: Any,
    low: Any,
    scratch: Any,
) -> None:
    """Advance the lanes of one block by `substeps` of `dt` and leave outputs at the end and extremes over the way.

    One loop over all stages (two a substep, and a last first stage for the outputs at the end), so that the
    right-hand side has one call site. `scratch` is (rows, lanes) and holds everything the block needs.
    """
    first, rest = scratch[0:ODE_ROWS], scratch[ODE_ROWS:]
    later, rest = rest[0:ODE_ROWS], rest[ODE_ROWS:]
    stage, rest = rest[0:STATE_ROWS], rest[STATE_ROWS:]
    d, rest = rest[0:DECK_ROWS], rest[DECK_ROWS:]
    w, rest = rest[0:WORK_ROWS], rest[WORK_ROWS:]
    c, rest = rest[0:DECK_PIECES], rest[DECK_PIECES:]
    cc, rest = rest[0:CLAW_PIECES], rest[CLAW_PIECES:]
    cg, tau = rest[0:GUST_PIECES], rest[GUST_PIECES:]
    start_block(high, low, tau)
    interval = substeps * dt
    gh = GAMMA * dt
    for half in range(2 * substeps + 1):
        second = half % 2
        if second == 0:
            x = y
            dy = first
            gather_pieces(
                nodes, claw_nodes, gust_nodes, columns, clock, spn, mode[Mode.CLAW], gusty, c, cc, cg, tau, dt
            )
        else:
            x = stage
            dy = later
            start_second_stage(y, first, stage, dt)
            advance_claw(y, p, commands, history, (half // 2) * dt, interval, dt, stage)
        ahead = second * dt
        prescribe(x, p, mode, c, cc, cg, ripple, gusty, load(tau, 0) + ahead, load(tau, 1) + ahead, d)
        rates(x, p, d, mode, first, dy, o, w, gh, second)
        if second == 0:
            attitude_outputs(x, d, o)
            record_peaks(o, high, low)
            if half < 2 * substeps:
                update_capture(y, p, o)
        else:
            finish_step(y, first, dy, stage, load(tau, 2), dt)
            for lane in range(columns.shape[0]):
                clock[lane] += 1


@kernel
def finish_step(y: Any, first: Any, dy: Any, stage: Any, clock: Any, h: float) -> None:
    """``y + h/2 (k1 + k2)`` into `stage`, normalised, and taken where it is sound; the claw has moved already."""
    for k in range(ODE_ROWS):
        store(stage, k, load(y, k) + (0.5 * h) * (load(first, k) + load(dy, k)))
    normalise(stage)
    accept(y, stage, clock)


SCRATCH_ROWS = 2 * ODE_ROWS + STATE_ROWS + DECK_ROWS + WORK_ROWS + DECK_PIECES + CLAW_PIECES + GUST_PIECES + 4


@kernel
def advance_columns(
    state: Any,
    parameters: Any,
    commands: Any,
    mode: Any,
    nodes: Any,
    claw_nodes: Any,
    gust_nodes: Any,
    clocks: Any,
    columns: Any,
    first: int,
    last: int,
    history: int,
    substeps: int,
    dt: float,
    spn: int,
    ripple: int,
    gusty: int,
    outputs: Any,
    highs: Any,
    lows: Any,
    room: Any,
    lanes: Any,
) -> None:
    """Blocks `first` to `last` of the listed columns: gather a block's columns, advance, scatter.

    All tables are (row, helicopter). `room` (`advance_room` rows, width) and `lanes` (2, width) are the caller's
    workspace. A short last block repeats its last column, whose copy is thrown away.
    """
    width = room.shape[1]
    y, rest = room[0:STATE_ROWS], room[STATE_ROWS:]
    o, rest = rest[0:OUTPUT_ROWS], rest[OUTPUT_ROWS:]
    high, rest = rest[0:OUTPUT_ROWS], rest[OUTPUT_ROWS:]
    low, rest = rest[0:OUTPUT_ROWS], rest[OUTPUT_ROWS:]
    scratch, rest = rest[0:SCRATCH_ROWS], rest[SCRATCH_ROWS:]
    p, u = rest[0 : parameters.shape[0]], rest[parameters.shape[0] :]
    block = lanes[0]
    clock = lanes[1]
    for b in range(first, last):
        live = min(width, columns.shape[0] - b * width)
        for lane in range(width):
            block[lane] = columns[b * width + min(lane, live - 1)]
            clock[lane] = clocks[block[lane]]
        gather_columns(state, block, y)
        gather_columns(parameters, block, p)
        gather_columns(commands, block, u)
        advance_block(
            y, p, u, mode, nodes, claw_nodes, gust_nodes, block, clock, history, substeps, dt, spn, ripple, gusty,
            o, high, low, scratch,
        )  # fmt: skip
        scatter_columns(y, block, live, state)
        scatter_columns(o, block, live, outputs)
        scatter_columns(high, block, live, highs)
        scatter_columns(low, block, live, lows)
        for lane in range(live):
            clocks[block[lane]] = clock[lane]


def advance_room(parameters: int, commands: int) -> int:
    """Rows of workspace that `advance_columns` needs for tables of so many rows."""
    return STATE_ROWS + 3 * OUTPUT_ROWS + SCRATCH_ROWS + parameters + commands


@kernel
def gather_columns(table: Any, block: Any, into: Any) -> None:
    """Copy the listed columns of a (row, helicopter) table into a block."""
    for k in range(table.shape[0]):
        for lane in range(block.shape[0]):
            into[k, lane] = table[k, block[lane]]


@kernel
def scatter_columns(block_table: Any, block: Any, live: int, table: Any) -> None:
    """Copy the first `live` columns of a block back."""
    for k in range(table.shape[0]):
        for lane in range(live):
            table[k, block[lane]] = block_table[k, lane]


@kernel
def rates_columns(
    state: Any, parameters: Any, mode: Any, decks: Any, derivative: Any, outputs: Any, room: Any, lanes: Any
) -> None:
    """The plain right-hand side of every column for given `Deck` rows: references, settling, the oracle.

    `room` (`rates_room` rows, width) and `lanes` (2, width) are the caller's workspace.
    """
    width = room.shape[1]
    y, rest = room[0:STATE_ROWS], room[STATE_ROWS:]
    d, rest = rest[0:DECK_ROWS], rest[DECK_ROWS:]
    dy, rest = rest[0:ODE_ROWS], rest[ODE_ROWS:]
    o, rest = rest[0:OUTPUT_ROWS], rest[OUTPUT_ROWS:]
    w, p = rest[0:WORK_ROWS], rest[WORK_ROWS:]
    block = lanes[0]
    n = state.shape[1]
    for b in range((n + width - 1) // width):
        live = min(width, n - b * width)
        for lane in range(width):
            block[lane] = b * width + min(lane, live - 1)
        gather_columns(state, block, y)
        gather_columns(parameters, block, p)
        gather_columns(decks, block, d)
        rates(y, p, d, mode, dy, dy, o, w, 0.0, 0)
        attitude_outputs(y, d, o)
        scatter_columns(dy, block, live, derivative)
        scatter_columns(o, block, live, outputs)


def rates_room(parameters: int) -> int:
    """Rows of workspace that `rates_columns` needs."""
    return STATE_ROWS + DECK_ROWS + ODE_ROWS + OUTPUT_ROWS + WORK_ROWS + parameters
