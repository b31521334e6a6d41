"""What is prescribed at an instant: deck, wind and claw, each from its node table.

All tables of a helicopter share node spacing and clock. The pieces between two nodes are gathered when a lane has
passed a node, and only evaluated in between.
"""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.aero import place_wind
from ssmash_gym.dynamics.claw import place_claw
from ssmash_gym.dynamics.deck import COEFFICIENTS, deck_kinematics, gather_piece, prescribed_claw
from ssmash_gym.dynamics.lane import kernel, load
from ssmash_gym.dynamics.layout import DECK_ROWS, ClawDrive, Deck, Mode

DECK_CHANNELS = 6
CLAW_CHANNELS = 3
GUST_CHANNELS = 1
DECK_PIECES = DECK_CHANNELS * COEFFICIENTS  # rows of a block that hold the pieces
CLAW_PIECES = CLAW_CHANNELS * COEFFICIENTS
GUST_PIECES = GUST_CHANNELS * COEFFICIENTS


@kernel
def gather_pieces(
    nodes: Any,
    claw_nodes: Any,
    gust_nodes: Any,
    columns: Any,
    clock: Any,
    spn: int,
    claw: int,
    gusty: int,
    c: Any,
    cc: Any,
    cg: Any,
    tau: Any,
    dt: float,
) -> None:
    """Refresh the polynomial pieces of the lanes that have just passed a node, and each lane's time since its node."""
    spacing = spn * dt
    for lane in range(columns.shape[0]):
        since = clock[lane] % spn
        tau[0, lane] = since * dt
        tau[1, lane] = clock[lane] * dt
        tau[2, lane] = float(clock[lane])
        if since == 0 or tau[3, lane] < 0.0:
            piece = clock[lane] // spn
            last = nodes.shape[1] - 2
            gather_piece(nodes, columns[lane], min(piece, last), DECK_CHANNELS, spacing, c, lane)
            if claw == ClawDrive.PRESCRIBED:
                last = claw_nodes.shape[1] - 2
                gather_piece(claw_nodes, columns[lane], min(piece, last), CLAW_CHANNELS, spacing, cc, lane)
            if gusty:
                last = gust_nodes.shape[1] - 2
                gather_piece(gust_nodes, columns[lane], min(piece, last), GUST_CHANNELS, spacing, cg, lane)
            tau[3, lane] = 1.0


@kernel
def prescribe(
    y: Any, p: Any, mode: Any, c: Any, cc: Any, cg: Any, ripple: int, gusty: int, t: Any, time: Any, d: Any
) -> None:
    """Deck, wind and claw at one instant: `t` since the node, `time` since the start of the table."""
    deck_kinematics(c, t, d)
    place_wind(p, gusty, cg, t, d)
    if mode[Mode.CLAW] == ClawDrive.PRESCRIBED:
        prescribed_claw(cc, t, d)
    else:
        place_claw(y, p, ripple, time, d)


@kernel
def deck_columns(nodes: Any, piece: int, tau: float, spacing: float, decks: Any, room: Any, lanes: Any) -> None:
    """`Deck` rows (claw and wind left alone) of every column at `tau` seconds after node `piece`.

    `room` is (DECK_ROOM, width), `lanes` (2, width).
    """
    width = room.shape[1]
    c, rest = room[0:DECK_PIECES], room[DECK_PIECES:]
    d, t = rest[0:DECK_ROWS], rest[DECK_ROWS:]
    block = lanes[0]
    n = decks.shape[1]
    for b in range((n + width - 1) // width):
        live = min(width, n - b * width)
        for lane in range(width):
            block[lane] = b * width + min(lane, live - 1)
            gather_piece(nodes, block[lane], piece, DECK_CHANNELS, spacing, c, lane)
            t[0, lane] = tau
        deck_kinematics(c, load(t, 0), d)
        for k in range(DECK_ROWS):
            if k < CLAW_FIRST or CLAW_LAST < k < WIND_FIRST:
                for lane in range(live):
                    decks[k, block[lane]] = d[k, lane]


DECK_ROOM = DECK_PIECES + DECK_ROWS + 1
CLAW_FIRST = int(Deck.C_CLAW_S)
CLAW_LAST = int(Deck.V_CLAW_S) + 2
WIND_FIRST = int(Deck.WIND)
