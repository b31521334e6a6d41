"""A record of deck motion in words: the ship and its sea, and a table of what the record holds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from ssmash_gym import __version__
from ssmash_gym.analysis.motion_picture import LINE_S, has_line
from ssmash_gym.analysis.motion_record import QUANTITIES, Record, Spectra
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import GRAVITY, Motion
from ssmash_gym.ship.recorded import RecordedMotion
from ssmash_gym.ship.response import HullResponse
from ssmash_gym.ship.response_table import ResponseTable
from ssmash_gym.ship.sea import KNOT, comes_from_deg
from ssmash_gym.ship.seaway import Seaway, SeawayMotion
from ssmash_gym.ship.ships import load_ship

OBLIQUE_DEG: Final = 135.0  # heading at which a ship both rolls and pitches with the slope of long waves


def ship_label(source: Seaway) -> str:
    """The ship's name, and the keys in which it differs from the ship it starts from."""
    return load_ship(source.ship).label


def sea_words(source: Seaway) -> str:
    """The sea in one line."""
    sea = source.sea()
    shape = f"jonswap, gamma {sea.gamma:g}" if source.spectrum == "jonswap" else source.spectrum
    return f"Hs {sea.hs_m:g} m, Tp {sea.tp_s:.3g} s, {shape}, {source.spreading}, {source.components} waves"


def heading_words(source: Seaway) -> str:
    """The heading in both conventions."""
    travel = source.heading_deg % 360.0
    return (
        f"waves travel to {travel:g}° (0 following, 90 to starboard), come from {comes_from_deg(travel):g}° (0 ahead)"
    )


def title(source: Any) -> str:
    """Title of the picture."""
    if not isinstance(source, Seaway):
        return f"Deck motion: {source.type}"
    sea = source.sea()
    state = f"sea state {source.sea_state}" if source.sea_state is not None else f"waves of {sea.hs_m:g} m"
    return f"Deck motion: {ship_label(source)}, {source.speed_kn:g} kn, {state}"


def subtitle(source: Any, motion: Motion, remarks: Sequence[str]) -> list[str]:
    """Lines under the picture's title."""
    seaway = isinstance(source, Seaway)
    words = f"{sea_words(source)}; {heading_words(source)}" if seaway else "no sea belongs to this motion"
    return [words, *flags(motion, remarks)]


def flags(motion: Motion, remarks: Sequence[str]) -> list[str]:
    """What must be known before a record is trusted, a line each."""
    flag = motion.outside_validity
    return ([f"outside validity: {flag}"] if flag is not None else []) + [f"warning: {text}" for text in remarks]


def caption(record: Record, spectra: Spectra | None, seed: int) -> str:
    """Foot of the picture."""
    area = "" if spectra is None else "orange: long run from the spectrum (sea, dashed: over wave frequency); "
    line = f"blue: this record, {record.time_s[-1]:g} s at {record.time_s[1]:g} s, seed {seed}"
    own = "its spectrum scaled to its variance" if has_line(record, spectra) else f"no spectrum below {LINE_S:g} s"
    return f"{area}{line}, {own}; vertical down, lateral to starboard positive; ssmash_gym {__version__}"


def show(console: Console, source: Any, motion: Motion, record: Record, remarks: Sequence[str]) -> None:
    """Print what was made: the ship and the sea, the figures, the flag of validity and the warnings."""
    facts = Table(show_header=False, box=None, pad_edge=False)
    if isinstance(source, Seaway) and isinstance(motion, SeawayMotion):
        for name, words in seaway_facts(source, motion):
            facts.add_row(name, words)
    else:
        facts.add_row("motion", source.type)
    console.print(facts)
    if isinstance(motion, RecordedMotion):
        console.print(motion.report(), soft_wrap=True, markup=False, highlight=False)
    console.print(figures(motion, record))
    for flag in flags(motion, remarks):
        console.print(flag, style="bold yellow", soft_wrap=True, markup=False, highlight=False)


def seaway_facts(source: Seaway, motion: SeawayMotion) -> list[tuple[str, str]]:
    """Ship, sea, heading, damping and periods, as pairs of a name and words."""
    ship = load_ship(source.ship)
    facts = [
        ("ship", f"{ship_label(source)}, at {source.speed_kn:g} kn"),
        ("deck point", point_words(motion.point)),
        ("sea", ("" if source.sea_state is None else f"sea state {source.sea_state}: ") + sea_words(source)),
        ("heading", heading_words(source)),
    ]
    if source.heel_deg or source.trim_deg:
        facts.append(("mean attitude", f"heel {source.heel_deg:g} deg, trim {source.trim_deg:g} deg"))
    if isinstance(ship.response, HullResponse):
        periods = {**ship.response.natural_period_s}
        periods["roll"] /= math.sqrt(source.gm_factor)
        facts.append(("natural periods", ", ".join(f"{name} {value:.1f} s" for name, value in periods.items())))
    if isinstance(ship.response, ResponseTable):
        facts.append(("long waves", long_wave_words(ship.response, source.speed_kn)))
    if math.isfinite(motion.response.roll_damping):
        facts.append(("roll damping", f"{motion.response.roll_damping:.3f} of critical"))
    facts.append(("roll period", f"{motion.deck.roll_period_s:.1f} s (mean, in this sea)"))
    return facts


def point_words(point: FloatArray) -> str:
    """Where the deck point is, in words; `point` (3,) [m] forward, to starboard, down of the centre of gravity."""
    x, y, z = point.tolist()
    return (
        f"{abs(x):g} m {'forward' if x >= 0.0 else 'aft'}, {abs(y):g} m to {'starboard' if y >= 0.0 else 'port'}, "
        f"{abs(z):g} m {'above' if z <= 0.0 else 'below'} the centre of gravity"
    )


def long_wave_words(table: ResponseTable, speed_kn: float) -> str:
    """How a table's ship follows the surface of its longest waves, met at 135 degrees."""
    heave, roll, pitch = ratios = long_wave_ratios(table, speed_kn)
    told = f"heave {heave:.2f}, roll/slope {roll:.2f}, pitch/slope {pitch:.2f} at {table.omega[0]:g} rad/s"
    # A resonance not far above makes the roll larger and turns it a little; a wrong sign or phase turns it round.
    wrong = any(ratio != 0.0 and ratio.real <= abs(ratio.imag) for ratio in ratios)
    return f"{told} (1 in long waves{': a wrong sign, phase or heading?' if wrong else ''})"


def long_wave_ratios(table: ResponseTable, speed_kn: float) -> tuple[complex, complex, complex]:
    """Heave over elevation, roll and pitch over the waves' slope across and along, at a table's lowest frequency.

    In long waves a ship goes with the surface and each of them is 1.

    Args:
        table: The table.
        speed_kn: Ship's speed [kn], within the table's.
    """
    heading = np.radians([OBLIQUE_DEG])
    H = table.respond(table.omega[:1], heading, np.zeros(1), speed_kn * KNOT).transfer[0]
    slope = 1j * float(table.omega[0]) ** 2 / GRAVITY
    across, along = slope * math.sin(heading[0]), -slope * math.cos(heading[0])
    return complex(-H[2]), complex(H[3] / across), complex(H[4] / along)


def figures(motion: Motion, record: Record) -> Table:
    """Mean of the record, and RMS, significant and largest values about it, beside the long run of a seaway."""
    table = Table(
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 0, 0, 1),
        caption="RMS, significant (twice the RMS) and largest are about the mean",
    )
    table.add_column("deck point")
    seaway = isinstance(motion, SeawayMotion)
    for name in (("long-run RMS",) if seaway else ()) + ("mean", "RMS", "significant", "largest"):
        table.add_column(name, justify="right")
    long_run = motion.deck_rms() if seaway else None
    for quantity, found in zip(QUANTITIES, record.statistics().values(), strict=True):
        values = [] if long_run is None else [getattr(long_run, quantity.key)]
        values += found
        table.add_row(f"{quantity.label} \\[{quantity.unit}]", *(f"{round(value, 3) + 0.0:.3f}" for value in values))
    return table
