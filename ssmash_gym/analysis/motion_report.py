"""A record of deck motion in words: the ship and its sea, and a table of what the record holds."""

from __future__ import annotations

import math
from typing import Any

from rich.console import Console
from rich.table import Table

from ssmash_gym import __version__
from ssmash_gym.analysis.motion_record import QUANTITIES, Record
from ssmash_gym.ship.motion import Motion
from ssmash_gym.ship.recorded import RecordedMotion
from ssmash_gym.ship.response import HullResponse
from ssmash_gym.ship.sea import comes_from_deg
from ssmash_gym.ship.seaway import Seaway, SeawayMotion
from ssmash_gym.ship.ships import load_ship


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
    return f"Deck motion: {load_ship(source.ship).name}, {source.speed_kn:g} kn, {state}"


def subtitle(source: Any, motion: Motion) -> str:
    """Line under the picture's title."""
    if not isinstance(source, Seaway):
        return f"a motion of type {source.type}: no sea belongs to it"
    flag = motion.outside_validity
    return f"{sea_words(source)}; {heading_words(source)}" + (f"\noutside validity: {flag}" if flag else "")


def caption(motion: Motion, record: Record, seed: int) -> str:
    """Foot of the picture."""
    seaway = isinstance(motion, SeawayMotion)
    area = "orange: long run from the spectrum (sea, dashed: over wave frequency); " if seaway else ""
    line = f"blue: this record, {record.time_s[-1]:g} s at {record.time_s[1]:g} s, seed {seed}"
    return f"{area}{line}; vertical down, lateral to starboard positive; ssmash_gym {__version__}"


def show(console: Console, source: Any, motion: Motion, record: Record) -> None:
    """Print what was made: the ship and the sea, the figures, and the flag of validity."""
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
    if motion.outside_validity is not None:
        console.print(f"[bold yellow]outside validity[/]: {motion.outside_validity}", soft_wrap=True)


def seaway_facts(source: Seaway, motion: SeawayMotion) -> list[tuple[str, str]]:
    """Ship, sea, heading, damping and periods, as pairs of a name and words."""
    ship = load_ship(source.ship)
    x, y, z = motion.point
    lengthwise = f"{x:g} m forward" if x >= 0.0 else f"{-x:g} m aft"
    facts = [
        ("ship", f"{ship.name} at {source.speed_kn:g} kn"),
        ("deck point", f"{lengthwise}, {y:g} m to starboard, {-z:g} m above the centre of gravity"),
        ("sea", ("" if source.sea_state is None else f"sea state {source.sea_state}: ") + sea_words(source)),
        ("heading", heading_words(source)),
    ]
    if source.heel_deg or source.trim_deg:
        facts.append(("mean attitude", f"heel {source.heel_deg:g} deg, trim {source.trim_deg:g} deg"))
    if isinstance(ship.response, HullResponse):
        periods = {**ship.response.natural_period_s}
        periods["roll"] /= math.sqrt(source.gm_factor)
        facts.append(("natural periods", ", ".join(f"{name} {value:.1f} s" for name, value in periods.items())))
    if math.isfinite(motion.response.roll_damping):
        facts.append(("roll damping", f"{motion.response.roll_damping:.3f} of critical"))
    facts.append(("roll period", f"{motion.deck.roll_period_s:.1f} s (mean, in this sea)"))
    return facts


def figures(motion: Motion, record: Record) -> Table:
    """RMS, significant and largest values of the record, beside the long run of a seaway."""
    table = Table(caption="about the mean; significant: twice the RMS")
    table.add_column("deck point")
    seaway = isinstance(motion, SeawayMotion)
    for name in (("long-run RMS",) if seaway else ()) + ("RMS", "significant", "largest"):
        table.add_column(name, justify="right")
    long_run = motion.deck_rms() if seaway else None
    for quantity, found in zip(QUANTITIES, record.statistics().values(), strict=True):
        values = [] if long_run is None else [getattr(long_run, quantity.key)]
        values += [found.rms, found.significant, found.largest]
        table.add_row(f"{quantity.label} \\[{quantity.unit}]", *(f"{value:.3f}" for value in values))
    return table
