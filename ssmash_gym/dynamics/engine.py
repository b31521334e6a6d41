"""The compiled kernels as seen from Python: one call a control interval, threads over groups of lanes.

The result of a column depends neither on its neighbours, nor on the batch size, nor on the number of threads: a
block of lanes computes each lane by itself, and blocks are handed to a thread pool (the kernels hold no lock).
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics import stepper
from ssmash_gym.dynamics.cache import enable_kernel_cache
from ssmash_gym.dynamics.lane import WIDTH
from ssmash_gym.dynamics.layout import DECK_ROWS, ODE_ROWS, OUTPUT_ROWS, Par

Array = NDArray[np.float64]

enable_kernel_cache(stepper.advance_columns)
enable_kernel_cache(stepper.rates_columns)
enable_kernel_cache(stepper.deck_columns)


@cache
def _pool(workers: int) -> ThreadPoolExecutor:
    """One pool a process and worker count; idle threads cost nothing."""
    return ThreadPoolExecutor(workers, thread_name_prefix="ssmash")


def available_threads() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def advance(
    state: Array,
    parameters: Array,
    commands: Array,
    mode: NDArray[np.int64],
    nodes: Array,
    claw_nodes: Array,
    clocks: NDArray[np.int64],
    columns: NDArray[np.int64],
    substeps: int,
    dt: float,
    substeps_per_node: int,
    outputs: Array,
    highs: Array,
    lows: Array,
    threads: int = 1,
) -> None:
    """Advance the listed columns in place by ``substeps * dt`` seconds.

    Args:
        state: (STATE_ROWS, N); advanced in place, as are `clocks` (N,), the substeps since each table's start.
        parameters: (PARAMETER_ROWS, N), SI.
        commands: (2 * history, N) normalised claw commands, newest first, rows x, y, x, y...
        mode: (MODES,) integers of the batch.
        nodes: (N, nodes, 18) deck motion; claw_nodes: (N, nodes, 9) prescribed claw (ignored when commanded).
        columns: helicopters to advance.
        outputs, highs, lows: (OUTPUT_ROWS, N), written: outputs at the end, extremes over all substeps.
        threads: workers; the result does not depend on it.
    """
    blocks = -(-columns.size // WIDTH)
    history = commands.shape[0] // 2
    ripple = int(np.any(parameters[_RIPPLE]))

    def run(first: int, last: int) -> None:
        room, lanes = _workspace(stepper.advance_room(parameters.shape[0], commands.shape[0]))
        stepper.advance_columns(
            state, parameters, commands, mode, nodes, claw_nodes, clocks, columns, first, last, history, substeps,
            dt, substeps_per_node, ripple, outputs, highs, lows, room, lanes,
        )  # fmt: skip

    workers = min(threads, blocks)
    if workers <= 1:
        run(0, blocks)
        return
    bounds = [blocks * k // workers for k in range(workers + 1)]
    for job in [_pool(workers).submit(run, a, b) for a, b in zip(bounds, bounds[1:], strict=False)]:
        job.result()


_RIPPLE = slice(int(Par.RIPPLE_X), int(Par.RIPPLE_X) + 2)


def _workspace(rows: int) -> tuple[Array, NDArray[np.int64]]:
    return np.zeros((rows, WIDTH)), np.zeros((2, WIDTH), np.int64)


def derivative(state: Array, parameters: Array, mode: NDArray[np.int64], decks: Array) -> tuple[Array, Array]:
    """Plain right-hand side: rates (ODE_ROWS, N) and outputs (OUTPUT_ROWS, N) for given `Deck` rows (DECK_ROWS, N)."""
    n = state.shape[1]
    rates = np.zeros((ODE_ROWS, n))
    outputs = np.zeros((OUTPUT_ROWS, n))
    room, lanes = _workspace(stepper.rates_room(parameters.shape[0]))
    stepper.rates_columns(state, parameters, mode, decks, rates, outputs, room, lanes)
    return rates, outputs


def deck_rows(nodes: Array, time_s: float, spacing_s: float) -> Array:
    """`Deck` rows (DECK_ROWS, N) of every helicopter's table at one time; the claw's rows are left zero."""
    decks = np.zeros((DECK_ROWS, nodes.shape[0]))
    piece = min(int(time_s / spacing_s), nodes.shape[1] - 2)
    room, lanes = _workspace(stepper.DECK_ROOM)
    stepper.deck_columns(nodes, piece, time_s - piece * spacing_s, spacing_s, decks, room, lanes)
    return decks
