"""What share of a step goes into the deck: `python -m benchmarks.deck_share`.

Times the engine, and by itself the part of it that says what is prescribed at each stage (pieces of the node tables
gathered, quintics, attitude and its rates, wind, claw), in alternation and on the same tables. Alone, that part has
nothing to overlap with, so the share is rather too large than too small.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.scenario import DURATION_S, SUBSTEP_S, Traverse
from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.lane import kernel, load, of_width
from ssmash_gym.dynamics.layout import DECK_ROWS, Mode, Par
from ssmash_gym.dynamics.prescribed import CLAW_PIECES, DECK_PIECES, GUST_PIECES, gather_pieces, prescribe
from ssmash_gym.ship.wind import Gust, blows_towards, wind_over_deck

SUBSTEPS = 500  # of a turn
ROOM = DECK_PIECES + CLAW_PIECES + GUST_PIECES + DECK_ROWS + 4
AIM = 0.2


@kernel
def deck_alone(
    y: Any,
    p: Any,
    mode: Any,
    nodes: Any,
    claw_nodes: Any,
    gust_nodes: Any,
    columns: Any,
    clock: Any,
    substeps: int,
    dt: float,
    spn: int,
    gusty: int,
    room: Any,
) -> None:
    """The calls of `stepper.advance_block` that read the deck, and none of the others; lanes (blocks, width)."""
    c, rest = room[0:DECK_PIECES], room[DECK_PIECES:]
    cc, rest = rest[0:CLAW_PIECES], rest[CLAW_PIECES:]
    cg, rest = rest[0:GUST_PIECES], rest[GUST_PIECES:]
    d, tau = rest[0:DECK_ROWS], rest[DECK_ROWS:]
    for b in range(columns.shape[0]):
        for lane in range(columns.shape[1]):
            tau[3, lane] = -1.0
        for half in range(2 * substeps + 1):
            second = half % 2
            if second == 0:
                gather_pieces(
                    nodes, claw_nodes, gust_nodes, columns[b], clock[b], spn, mode[Mode.CLAW], gusty, c, cc, cg, tau, dt
                )
            ahead = second * dt
            prescribe(y, p, mode, c, cc, cg, 0, gusty, load(tau, 0) + ahead, load(tau, 1) + ahead, d)
            if second == 1:
                for lane in range(columns.shape[1]):
                    clock[b, lane] += 1


def windy(count: int, gusty: bool) -> Traverse:
    """The job that is timed elsewhere too, in a wind from starboard, with gusts or without."""
    traverse = Traverse("generic_tricycle", count)
    batch = traverse.batch
    batch.parameters[Par.WIND : Par.WIND + 3] = wind_over_deck(12.0, 90.0, 5.0)[:, None]
    if gusty:
        batch.parameters[Par.GUST : Par.GUST + 3] = blows_towards(90.0)[:, None]
        draws = (Gust.draw(12.0, 0.1, np.random.default_rng(k)) for k in range(count))
        batch.set_gusts([gust.bake(DURATION_S + 1.0) for gust in draws])
    return traverse


def jobs(traverse: Traverse, gusty: bool) -> tuple[Callable[[], None], Callable[[], None]]:
    """One turn of the engine, and one of its deck alone, for `SUBSTEPS` of every helicopter from the start."""
    batch = traverse.batch
    start, columns, per_node = batch.snapshot(), np.arange(batch.n), batch.timing.substeps_per_node
    tables = (batch.nodes, batch._claw_nodes, batch.gust_nodes)
    outputs, highs, lows = (batch.telemetry.outputs.copy() for _ in range(3))
    width = engine.lane_width(batch.n)
    compiled = of_width(deck_alone, width)
    room, _ = engine._workspace(ROOM, width)
    y, p = (np.ascontiguousarray(table[:, :width]) for table in (batch.state, batch.parameters))
    blocks = columns.reshape(-1, width)

    def whole() -> None:
        state, clocks = start.arrays["state"].copy(), np.zeros(batch.n, np.int64)
        engine.advance(
            state, batch.parameters, batch._commands, batch.mode, *tables, clocks, columns, SUBSTEPS, SUBSTEP_S,
            per_node, outputs, highs, lows,
        )  # fmt: skip

    def deck() -> None:
        compiled(
            y, p, batch.mode, *tables, blocks, np.zeros_like(blocks), SUBSTEPS, SUBSTEP_S, per_node, int(gusty), room
        )

    return whole, deck


def seconds(job: Callable[[], None]) -> float:
    """Processor time of one turn [s]."""
    start = time.process_time()
    job()
    return time.process_time() - start


def measure(count: int, gusty: bool, repeats: int) -> dict[str, float]:
    """Nanoseconds a substep and helicopter of the whole engine and of its deck, and the deck's share.

    Args:
        count: Helicopters, a whole number of lanes.
        gusty: Whether they stand in gusts.
        repeats: Turns of each, in alternation; the best of each counts.
    """
    whole, deck = jobs(windy(count, gusty), gusty)
    whole()
    deck()
    pairs = np.array([(seconds(whole), seconds(deck)) for _ in range(repeats)])
    best = np.min(pairs, axis=0) / (SUBSTEPS * count) * 1e9
    share = {"best": best[1] / best[0], "median": float(np.median(pairs[:, 1] / pairs[:, 0]))}
    return {
        "engine_ns": round(float(best[0]), 1),
        "deck_ns": round(float(best[1]), 1),
        "share_of_best_turns": round(float(share["best"]), 4),
        "median_share": round(share["median"], 4),
    }


def main() -> None:
    """Measure and print: a line for each case, then JSON."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--repeats", type=int, default=40, help="turns of each job, in alternation (40)")
    options = parser.parse_args()
    found = {}
    for count in (engine.WIDTH, 64):
        for gusty in (False, True):
            name = f"{count} helicopters, {'gusts' if gusty else 'steady wind'}"
            found[name] = figures = measure(count, gusty, options.repeats)
            sys.stderr.write(
                f"{name}: the deck takes {100.0 * figures['share_of_best_turns']:.1f} % of a step "
                f"({figures['deck_ns']:.0f} of {figures['engine_ns']:.0f} ns; aim: under {100.0 * AIM:.0f} %)\n"
            )
    sys.stdout.write(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
