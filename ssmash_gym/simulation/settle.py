"""Equilibrium on the deck as it stands: found, not guessed.

1. The helicopter is lowered until its wheels touch and relaxes with x, y, yaw and the steer angles held.
2. Newton's method on height, roll, pitch and the three strokes makes that rest exact.
3. On a sloping deck, with a deflected probe or in the wind, Newton's method on all twelve motions lets tires and
   probe take the rest up: wheels stand, so that their tires deflect by what the carriages move over the deck.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics import engine, vectors
from ssmash_gym.dynamics.channels import Out
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import (
    SPEEDS,
    STATION_COORDINATES,
    STATION_ROWS,
    STATIONS,
    TIRE_PAR,
    TIRE_ROWS,
    ClawDrive,
    Deck,
    Mode,
    Par,
    Sta,
    State,
    StationKind,
    Tir,
)

if TYPE_CHECKING:
    from ssmash_gym.simulation.batch import Batch

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
_rotation = uncompiled(vectors.rotation)
_apply = uncompiled(vectors.apply)
_HELD = (0, 1, 5, 7, 9, 11)  # u7, u8, u12 and the steer rates: what stays put while the helicopter is lowered
_VERTICAL = np.array([2, 3, 4, 6, 8, 10])  # u9, u10, u11 and the three strokes
_ALL = np.arange(SPEEDS)
_AT_REST = 1e-7  # largest acceleration of a column that needs no further step [m/s2, rad/s2]
_TRIES = 4  # of lying down; one is enough for a level start
_PART = 128  # columns worked on together: bounds the memory
_RELAX_S = 0.02  # between two removals of kinetic energy
_KEEP = 0.5  # share of the speeds kept at each


def settle(batch: Batch, columns: Columns) -> Array:
    """Bring the columns to rest; returns the largest remaining acceleration of each, (n,).

    A captured probe keeps its place in the claw while the helicopter lies down, whatever its attitude becomes.
    """
    captured = batch.state[State.PROBE_CAPTURED, columns] * batch.parameters[Par.PROBE_ACTIVE, columns] > 0.5
    before = probe_point(batch, columns)
    lie_down(batch, columns)
    batch.state[State.Q8 : State.Q9 + 1, columns] += np.where(captured, before - probe_point(batch, columns), 0.0)
    find_rest(batch, columns)
    return remaining(batch, columns)


def place(batch: Batch, columns: Columns, x: Array, y: Array) -> Array:
    """Settle with the probe let go, move the probe point over (x, y), bring the claw to it, let it hold again.

    What the wheels leave to a captured probe, on a sloping deck, then deflects it.
    """
    active = batch.parameters[Par.PROBE_ACTIVE, columns].copy()
    batch.parameters[Par.PROBE_ACTIVE, columns] = 0.0
    try:
        settle(batch, columns)
    finally:
        batch.parameters[Par.PROBE_ACTIVE, columns] = active
    wanted = np.array([np.broadcast_to(x, columns.shape), np.broadcast_to(y, columns.shape)])
    batch.state[State.Q8 : State.Q9 + 1, columns] += wanted - probe_point(batch, columns)
    batch.state[State.CLAW_X, columns] = x
    batch.state[State.CLAW_Y, columns] = y
    batch.state[State.CLAW_VX : State.CLAW_VY + 1, columns] = 0.0
    find_rest(batch, columns)
    batch.evaluate(columns)
    return remaining(batch, columns)


def probe_point(batch: Batch, columns: Columns) -> Array:
    """Where the probe's axis meets the claw plane, x and y in S [m], (2, n)."""
    outputs = batch.derivative(batch.state[:, columns], batch.parameters[:, columns], still_decks(batch, columns))[1]
    return outputs[Out.PROBE_X : Out.PROBE_Y + 1]


def lie_down(batch: Batch, columns: Columns) -> None:
    """Lower the columns onto rolling wheels, probe let go; then height, roll, pitch and strokes exactly at rest."""
    claw = batch.state[State.CLAW_X : State.CLAW_VY + 1, columns].copy()
    lower(batch, columns)
    held = [Par.LOCK + k for k in _HELD]
    free = [Par.STATION + i * STATION_ROWS + Sta.ROLL_LOCK for i in range(STATIONS)]
    free += [int(Par.PROBE_ACTIVE), *range(Par.GUST, Par.GUST + 3)]
    rows = np.ix_(np.array(held + free), columns)
    kept = batch.parameters[rows]
    batch.parameters[rows] = np.repeat([1.0, 0.0], [len(held), len(free)])[:, None]
    try:
        uneasy = columns
        for _ in range(_TRIES):
            relax(batch, uneasy, seconds=1.6)
            newton(batch, uneasy, _VERTICAL)
            uneasy = uneasy[remaining(batch, uneasy) > _AT_REST]
            if not uneasy.size:
                break
    finally:
        batch.parameters[rows] = kept
        batch.state[State.CLAW_X : State.CLAW_VY + 1, columns] = claw


def find_rest(batch: Batch, columns: Columns) -> None:
    """Newton's method on all twelve accelerations where they are not zero yet; standing tires follow the deck.

    A column that has no equilibrium keeps the better of its two states.
    """
    before = remaining(batch, columns)
    uneasy = np.flatnonzero(before > _AT_REST)
    for part in np.array_split(uneasy, -(-uneasy.size // _PART)) if uneasy.size else []:
        some = columns[part]
        start = batch.state[:, some]
        newton(batch, some, _ALL, tire_travel(batch, some))
        left = remaining(batch, some)
        worse = ~(left < before[part])
        batch.state[:, some[worse]] = start[:, worse]


def tire_travel(batch: Batch, columns: Columns) -> Array:
    """Stored tire deflections that standing tires take for a unit of each of the twelve motions, (18, 12, n)."""
    n, m = columns.size, SPEEDS
    decks = np.repeat(still_decks(batch, columns), m, axis=1)
    parameters = np.repeat(batch.parameters[:, columns], m, axis=1)
    state = np.repeat(batch.state[:, columns], m, axis=1)
    speed = 1e-4
    rates = []
    for sign in (1.0, -1.0):  # the difference leaves out what rolling relaxes, which is even in the speed
        state[:SPEEDS] = sign * speed * np.tile(np.eye(m), n)
        rates.append(batch.derivative(state, parameters, decks)[0][State.TIRE : State.CLAW_X])
    return ((rates[0] - rates[1]) / (2.0 * speed)).reshape(-1, n, m).transpose(0, 2, 1)


def lower(batch: Batch, columns: Columns) -> None:
    """Height at which the lowest wheel is about to touch, speeds and tire deflections zero."""
    batch.state[: State.Q8, columns] = 0.0
    batch.state[State.TIRE : State.CLAW_X, columns] = 0.0
    tires = ground_clearance(batch, columns)
    batch.state[State.Q10, columns] += tires - 0.005


def ground_clearance(batch: Batch, columns: Columns) -> Array:
    """Height of the lowest tire above the deck plane for the present attitude [m], (n,)."""
    state, p = batch.state[:, columns], batch.parameters[:, columns]
    R_SH = _rotation(*state[State.Q11 : State.Q11 + 4])
    lowest = np.full(columns.size, -np.inf)
    for i in range(STATIONS):
        row, base = State.Q15 + STATION_COORDINATES * i, Par.STATION + i * STATION_ROWS
        R_HO = _rotation(*state[row + 1 : row + 5])
        for k in range(batch.mode[Mode.TIRES + i]):
            tire = TIRE_PAR + (2 * i + k) * TIRE_ROWS
            r_OT_O = (
                p[base + Sta.DROOP] + p[tire + Tir.X],
                p[base + Sta.DROOP + 1] + p[tire + Tir.Y],
                state[row] + p[tire + Tir.Z],
            )
            r_OT_H = _apply(R_HO, r_OT_O)
            r_HT_H = tuple(p[base + Sta.MOUNT + a] + r_OT_H[a] for a in range(3))
            depth = _apply(R_SH, r_HT_H)[2] + 0.5 * p[tire + Tir.DIAMETER]
            lowest = np.maximum(lowest, state[State.Q10] + depth)
    return np.asarray(-lowest)


def relax(batch: Batch, columns: Columns, seconds: float) -> None:
    """Run on a still deck; every 20 ms kinetic energy and the tires' in-plane deflections are taken out."""
    still = np.zeros((batch.n, 2, batch.nodes.shape[2]))
    decks = batch.deck_rows(columns)
    still[columns, :, 3:6] = deck_angles(decks).T[:, None, :]
    mode = batch.mode.copy()
    mode[Mode.CLAW] = ClawDrive.COMMANDED
    clocks = np.zeros(batch.n, np.int64)
    dt = batch.timing.substep_s
    substeps = max(1, round(_RELAX_S / dt))
    outputs, highs, lows = (np.zeros((batch.telemetry.outputs.shape[0], batch.n)) for _ in range(3))
    commands = np.zeros((2, batch.n))
    claw_nodes, gust_nodes = np.zeros((batch.n, 2, 9)), np.zeros((batch.n, 2, 3))
    for _ in range(round(seconds / (substeps * dt))):
        engine.advance(
            batch.state, batch.parameters, commands, mode, still, claw_nodes, gust_nodes, clocks, columns, substeps,
            dt, substeps * 1000, outputs, highs, lows, batch.threads,
        )  # fmt: skip
        batch.state[:SPEEDS, columns] *= _KEEP
        batch.state[State.TIRE : State.CLAW_X, columns] = 0.0


def deck_angles(decks: Array) -> Array:
    """Roll, pitch, yaw rows of `Deck`, (3, n)."""
    return decks[Deck.ANGLES : Deck.ANGLES + 3]


def still_decks(batch: Batch, columns: Columns) -> Array:
    """`Deck` rows with the present attitude and no motion; the claw rests where it is, its drive's ripple left out.

    The wind is the mean one: a helicopter does not rest in a gust.
    """
    decks = batch.deck_rows(columns)
    if batch.mode[Mode.CLAW] == ClawDrive.COMMANDED:
        decks[Deck.C_CLAW_S : Deck.C_CLAW_S + 2] = batch.state[State.CLAW_X : State.CLAW_Y + 1, columns]
    decks[Deck.W_NS_S : Deck.C_CLAW_S] = 0.0
    decks[Deck.V_CLAW_S : Deck.V_CLAW_S + 3] = 0.0
    decks[Deck.WIND : Deck.WIND + 3] = batch.parameters[Par.WIND : Par.WIND + 3, columns]
    return decks


def remaining(batch: Batch, columns: Columns) -> Array:
    """Largest generalized acceleration left on a still deck for zero speeds, (n,)."""
    state = batch.state[:, columns].copy()
    state[:SPEEDS] = 0.0
    rates, _ = batch.derivative(state, batch.parameters[:, columns], still_decks(batch, columns))
    return np.asarray(np.max(np.abs(rates[:SPEEDS]), axis=0))


def newton(batch: Batch, columns: Columns, speeds: Columns, travel: Array | None = None, iterations: int = 15) -> None:
    """Zero the accelerations of the listed speeds by their coordinates; finite differences in one batched call.

    Args:
        batch: the batch.
        columns: its columns.
        speeds: which of the twelve; those that a lock holds stay where they are.
        travel: what the stored tire deflections do for a unit of each motion, as `tire_travel`; None leaves them.
        iterations: at most so many.
    """
    n, m = columns.size, speeds.size
    decks = np.repeat(still_decks(batch, columns), m + 1, axis=1)
    parameters = np.repeat(batch.parameters[:, columns], m + 1, axis=1)
    follow = None if travel is None else np.repeat(travel, m + 1, axis=2)
    free = 1.0 - batch.parameters[Par.LOCK + speeds][:, columns]
    batch.state[:SPEEDS, columns] = 0.0
    done = np.zeros(n, np.bool_)
    step = 1e-6
    steps = np.zeros((SPEEDS, n, m + 1))
    steps[speeds, :, 1 + np.arange(m)] = step
    for _ in range(iterations):
        base = batch.state[:, columns]
        trial = moved(np.repeat(base, m + 1, axis=1), steps.reshape(SPEEDS, -1), batch.mode, follow)
        rates, _ = batch.derivative(trial, parameters, decks)
        values = rates[speeds].reshape(m, n, m + 1)
        residual = values[:, :, 0].T
        jacobian = ((values[:, :, 1:] - values[:, :, :1]) / step).transpose(1, 0, 2) * free.T[:, None, :]
        change = np.zeros((SPEEDS, n))
        inverse = np.linalg.pinv(jacobian, rcond=1e-10)
        for j in range(m):  # term by term: the order of a library's sums may depend on the number of columns
            change[speeds] -= inverse[:, :, j].T * residual[:, j]
        change[:, done] = 0.0  # a column's result does not depend on how long its neighbours take
        largest = np.max(np.abs(change), axis=0)
        batch.state[:, columns] = moved(base, change / np.maximum(1.0, largest / 0.05), batch.mode, travel)
        done |= largest < 1e-12
        if done.all():
            return


def moved(state: Array, change: Array, mode: NDArray[np.int64], travel: Array | None) -> Array:
    """State after the motions `change` (12, n) along u7-u18: position in S, rotation about H axes, the joint pairs."""
    out = state.copy()
    out[State.Q8 : State.Q10 + 1] += change[:3]
    zero = np.zeros(state.shape[1])
    turn(out, State.Q11, (change[3], change[4], change[5]))
    for i in range(STATIONS):
        row = State.Q15 + STATION_COORDINATES * i
        first, second = change[6 + 2 * i], change[7 + 2 * i]
        if mode[Mode.STATION_KIND + i] == StationKind.PRISMATIC:
            out[row] += first
            turn(out, row + 1, (zero, zero, second))
        else:
            turn(out, row + 1, (zero, first, second))
    if travel is not None:
        for j in range(SPEEDS):
            out[State.TIRE : State.CLAW_X] += travel[:, j] * change[j]
    return out


def turn(state: Array, row: int, angles: tuple[Array, Array, Array]) -> None:
    """Compose Euler parameters with a rotation vector in the rotated frame, in place."""
    angle = np.sqrt(sum(a * a for a in angles))
    half = 0.5 * angle
    s = np.where(angle > 1e-300, np.sin(half) / np.maximum(angle, 1e-300), 0.5)
    d0, (d1, d2, d3) = np.cos(half), (s * a for a in angles)  # (2.3), (2.4)
    e0, e1, e2, e3 = state[row : row + 4].copy()
    state[row] = e0 * d0 - e1 * d1 - e2 * d2 - e3 * d3
    state[row + 1] = e0 * d1 + e1 * d0 + e2 * d3 - e3 * d2
    state[row + 2] = e0 * d2 - e1 * d3 + e2 * d0 + e3 * d1
    state[row + 3] = e0 * d3 + e1 * d2 - e2 * d1 + e3 * d0
