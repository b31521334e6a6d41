"""The compiled kernels as seen from Python: one call a control interval, threads over groups of lanes.

The result of a column depends neither on its neighbours, nor on the batch size, nor on the number of threads: a
block of lanes computes each lane by itself, and blocks are handed to a thread pool (the kernels hold no lock).
Where the processor has the instructions, larger batches run on wider lanes than small ones: the bits are the same.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics import prescribed, stepper
from ssmash_gym.dynamics.aero import place_wind
from ssmash_gym.dynamics.cache import enable_kernel_cache
from ssmash_gym.dynamics.channels import OUTPUT_ROWS
from ssmash_gym.dynamics.compiler import CACHE_LINE, has_wide_vectors
from ssmash_gym.dynamics.deck import gather_piece
from ssmash_gym.dynamics.lane import WIDTH, of_width, uncompiled
from ssmash_gym.dynamics.layout import DECK_ROWS, ODE_ROWS, Par

Array = NDArray[np.float64]

# Numbers in a lane for batches of more than `WIDTH` helicopters. Where a lane of 8 takes two instructions each time,
# it is slower than two of 4.
WIDE: Final = 8 if has_wide_vectors() else WIDTH


def lane_width(n: int) -> int:
    """Numbers in a lane for a batch of n helicopters: by the batch, so that it needs one set of kernels only."""
    return WIDE if n > WIDTH else WIDTH


@cache
@cache
def _kernel(function: Any, width: int) -> Any:
    """A kernel on lanes of this width; compiled, or loaded from disk, when it is first called."""
    kernel = of_width(function, width)
    enable_kernel_cache(kernel)
    return kernel


@cache
def _pool(workers: int) -> ThreadPoolExecutor:
    """One pool a process and worker count; idle threads cost nothing."""
    return ThreadPoolExecutor(workers, thread_name_prefix="ssmash")


if hasattr(os, "register_at_fork"):  # a forked child inherits the pool without its threads
    os.register_at_fork(after_in_child=_pool.cache_clear)


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
    gust_nodes: Array,
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
        state: Rows `layout.State`, (STATE_ROWS, N); advanced in place.
        parameters: Rows `layout.Par`, `layout.Sta`, `layout.Tir`, (PARAMETER_ROWS, N), SI.
        commands: Normalised claw commands, newest first, rows x, y, x, y..., (2 * history, N).
        mode: Integers of the batch, `layout.Mode`, (MODES,).
        nodes: Deck motion, (N, nodes, 18).
        claw_nodes: Prescribed claw, (N, nodes, 9); ignored when the claw is commanded.
        gust_nodes: Gust speed [m/s] and its two rates, (N, nodes, 3); ignored where no column has a gust (`Par.GUST`).
        clocks: Substeps since each table's start, (N,); advanced in place.
        columns: Helicopters to advance.
        substeps: How many.
        dt: Length of a substep [s].
        substeps_per_node: Substeps from one node of the tables to the next.
        outputs: Written: outputs at the end, (OUTPUT_ROWS, N).
        highs: Written: largest values over all substeps, (OUTPUT_ROWS, N).
        lows: Written: smallest values over all substeps, (OUTPUT_ROWS, N).
        threads: Workers; the result does not depend on it.
    """
    width = lane_width(state.shape[1])
    kernel = _kernel(stepper.advance_columns, width)
    blocks = -(-columns.size // width)
    history = commands.shape[0] // 2
    ripple = int(parameters[_RIPPLE].any())
    gusty = int(parameters[_GUST].any())

    def run(first: int, last: int) -> None:
        room, lanes = _workspace(stepper.advance_room(parameters.shape[0], commands.shape[0]), width)
        kernel(
            state, parameters, commands, mode, nodes, claw_nodes, gust_nodes, clocks, columns, first, last, history,
            substeps, dt, substeps_per_node, ripple, gusty, outputs, highs, lows, room, lanes,
        )  # fmt: skip

    workers = min(threads, blocks)
    if workers <= 1:
        run(0, blocks)
        return
    bounds = [blocks * k // workers for k in range(workers + 1)]
    for job in [_pool(workers).submit(run, a, b) for a, b in pairwise(bounds)]:
        job.result()


_RIPPLE = slice(int(Par.RIPPLE_X), int(Par.RIPPLE_X) + 2)
_GUST = slice(int(Par.GUST), int(Par.GUST) + 3)


def _workspace(rows: int, width: int) -> tuple[Array, NDArray[np.int64]]:
    """Room for a block, and its integers; no row straddles two cache lines."""
    spare = CACHE_LINE // 8
    room = np.zeros(rows * width + spare)
    start = (-room.ctypes.data % CACHE_LINE) // 8
    return room[start : start + rows * width].reshape(rows, width), np.zeros((2, width), np.int64)


def derivative(
    state: Array, parameters: Array, mode: NDArray[np.int64], decks: Array, width: int = WIDTH
) -> tuple[Array, Array]:
    """Plain right-hand side of every column.

    Args:
        state: Rows `layout.State`, (STATE_ROWS, N).
        parameters: Rows `layout.Par`, `layout.Sta`, `layout.Tir`, (PARAMETER_ROWS, N), SI.
        mode: Integers of the batch, `layout.Mode`, (MODES,).
        decks: Rows `layout.Deck`, (DECK_ROWS, N).
        width: Numbers in a lane, for speed only: beside `advance`, its `lane_width` saves most of the compilation.

    Returns:
        Rates (ODE_ROWS, N) and outputs (OUTPUT_ROWS, N).
    """
    n = state.shape[1]
    # One layout in memory: Numba compiles a kernel anew for every combination of layouts.
    state, parameters, decks = (np.ascontiguousarray(table) for table in (state, parameters, decks))
    rates = np.zeros((ODE_ROWS, n))
    outputs = np.zeros((OUTPUT_ROWS, n))
    room, lanes = _workspace(stepper.rates_room(parameters.shape[0]), width)
    _kernel(stepper.rates_columns, width)(state, parameters, mode, decks, rates, outputs, room, lanes)
    return rates, outputs


def deck_rows(nodes: Array, time_s: float, spacing_s: float) -> Array:
    """`Deck` rows (DECK_ROWS, N) of every helicopter's table at one time; claw and wind are left zero."""
    decks = np.zeros((DECK_ROWS, nodes.shape[0]))
    piece = min(int(time_s / spacing_s), nodes.shape[1] - 2)
    room, lanes = _workspace(prescribed.DECK_ROOM, WIDTH)
    _kernel(prescribed.deck_columns, WIDTH)(nodes, piece, time_s - piece * spacing_s, spacing_s, decks, room, lanes)
    return decks


def write_wind(
    parameters: Array, gust_nodes: Array, pieces: NDArray[np.int64], since_s: Array, spacing_s: float, decks: Array
) -> None:
    """Wind rows of decks, gusts included.

    Args:
        parameters: (PARAMETER_ROWS, N).
        gust_nodes: Gust speed [m/s] and its two rates, (N, nodes, 3).
        pieces: Node that each column has last passed, (N,); the last piece goes on.
        since_s: Time since that node [s], (N,).
        spacing_s: Time between nodes [s].
        decks: Written: rows `Deck.WIND`, (DECK_ROWS, N).
    """
    gusty = int(parameters[_GUST].any())
    c = np.zeros((prescribed.GUST_PIECES, pieces.size))
    if gusty:
        held = np.minimum(pieces, gust_nodes.shape[1] - 2)
        uncompiled(gather_piece)(
            gust_nodes, np.arange(pieces.size), held, prescribed.GUST_CHANNELS, spacing_s, c, slice(None)
        )
    uncompiled(place_wind)(parameters, gusty, c, since_s, decks)
