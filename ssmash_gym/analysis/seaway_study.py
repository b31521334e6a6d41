"""How good the seaway is: severity against the spectral integral, scatter, reference figures, derivatives, cost.

``python -m ssmash_gym.analysis.seaway_study`` prints the tables that docs/theory/seaway.md quotes;
``--parts cells`` and so on choose some of them.
"""

from __future__ import annotations

import itertools
import math
import timeit
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Final, Literal

import numpy as np
import tyro
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from ssmash_gym.analysis.reference_figures import REFERENCE, REFERENCE_HEADINGS, REFERENCE_SEVERITIES
from ssmash_gym.ship import (
    SEA_STATES,
    DeckRms,
    Motion,
    MotionTable,
    SeawayMotion,
    Spectrum,
    Spreading,
    draw_seaway,
    spectral_deck_rms,
)
from ssmash_gym.ship.sea import KNOT
from ssmash_gym.ship.ships import Ship, load_ship

Array = NDArray[np.float64]
Part = Literal["cells", "scatter", "reference", "derivatives", "cost"]

# The severities that a cell is judged by, and their short names.
SEVERITIES: Final = dict(
    zip(REFERENCE_SEVERITIES, ("roll [deg]", "pitch [deg]", "v_z [m/s]", "a_z [g]", "f_y [g]"), strict=True)
)


@dataclass(frozen=True)
class Cell:
    """One sea state, heading [deg] and speed [kn]."""

    sea_state: int
    heading_deg: float
    speed_kn: float

    def spectral(self, ship: Ship) -> Array:
        """Severities by the spectral integral, in the order of `SEVERITIES`."""
        spectrum = Spectrum(*SEA_STATES[self.sea_state])
        return values(
            spectral_deck_rms(ship, spectrum, Spreading(), math.radians(self.heading_deg), self.speed_kn * KNOT)
        )

    def draw(self, ship: Ship, seed: int, components: int = 96) -> SeawayMotion:
        """One sea of this cell; the same seed shares its random numbers over the cells."""
        return draw_seaway(
            ship,
            Spectrum(*SEA_STATES[self.sea_state]),
            Spreading(),
            math.radians(self.heading_deg),
            self.speed_kn * KNOT,
            np.random.default_rng(seed),
            components=components,
        )


def values(rms: DeckRms) -> Array:
    """The severities of a deck in the order of `SEVERITIES`."""
    return np.array([getattr(rms, key) for key in SEVERITIES])


@dataclass(frozen=True)
class Spread:
    """Severities of several draws of one cell, relative to the spectral integral.

    Attributes:
        cell: The cell.
        error: Largest error of any draw, (severities,).
        scatter: Standard deviation over the draws over their mean, (severities,).
    """

    cell: Cell
    error: Array
    scatter: Array


def spread_of(ship: Ship, cell: Cell, seeds: int, components: int = 96) -> Spread:
    """How far draws of a cell are from the spectral integral and from one another.

    Args:
        ship: The ship.
        cell: The cell.
        seeds: Number of draws, 2 or more.
        components: Waves a draw.
    """
    drawn = np.array([values(cell.draw(ship, seed, components).deck) for seed in range(seeds)])
    error = np.max(np.abs(drawn / cell.spectral(ship) - 1.0), axis=0)
    return Spread(cell, error, np.std(drawn, axis=0, ddof=1) / np.mean(drawn, axis=0))


def record_scatter(ship: Ship, cell: Cell, seeds: int, duration_s: float = 600.0) -> tuple[Array, Array]:
    """Severities of finite records: standard deviation over the seeds and mean, both over the long-run value.

    Args:
        ship: The ship.
        cell: The cell.
        seeds: Number of records.
        duration_s: Length of a record [s].
    """
    ratio = []
    for seed in range(seeds):
        motion = cell.draw(ship, seed)
        ratio.append(values(Motion.deck_rms(motion, duration_s)) / values(motion.deck))
    return np.std(ratio, axis=0, ddof=1), np.mean(ratio, axis=0)


def derivative_errors(motion: Motion, duration_s: float = 120.0) -> dict[str, float]:
    """Largest difference between the table's velocities and finite differences of it, over the RMS of each.

    Args:
        motion: The motion; its table is baked at the default spacing.
        duration_s: Length of the table [s].
    """
    table = motion.bake(duration_s)
    t = np.arange(2.0, duration_s - 2.0, 0.37)
    t = t[np.abs(t / table.spacing_s - np.round(t / table.spacing_s)) > 0.1]  # the stencil stays within a piece
    pose = table.pose(t)
    turning = np.einsum("nji,njk->nik", pose.R_NS, _slope(table, t, lambda p: p.R_NS))
    found = {
        "velocity": (pose.v_NS_N, _slope(table, t, lambda p: p.r_NS_N)),
        "acceleration": (pose.a_NS_N, _slope(table, t, lambda p: p.v_NS_N)),
        "angular velocity": (pose.w_NS_S, np.stack([turning[:, 2, 1], turning[:, 0, 2], turning[:, 1, 0]], axis=1)),
        "angular acceleration": (pose.wdot_NS_S, _slope(table, t, lambda p: p.w_NS_S)),
    }
    errors = {
        name: float(np.max(np.abs(value - slope) / np.sqrt(np.mean(value**2, axis=0))))
        for name, (value, slope) in found.items()
    }
    exact, read = motion.signal(t), table.at(t)
    for name, a, b in zip(("position", "rate", "acceleration"), exact, read, strict=True):
        errors[f"interpolated {name}"] = float(np.max(np.abs(a - b) / np.std(a, axis=0)))
    return errors


def _slope(table: MotionTable, t: Array, part: Callable[..., Array], step: float = 2e-3) -> Array:
    """Fourth-order central difference of one part of the pose."""
    far, near = (part(table.pose(t + k * step)) - part(table.pose(t - k * step)) for k in (2, 1))
    return (8.0 * near - far) / (12.0 * step)


def costs(ship: Ship, cell: Cell, repeats: int = 9) -> dict[str, float]:
    """Least times [ms] of drawing a sea and of baking 120 s of it at the default spacing."""
    motion = cell.draw(ship, 0)
    jobs: dict[str, Callable[[], object]] = {
        "draw": lambda: cell.draw(ship, 0),
        "bake 120 s": lambda: motion.bake(120.0),
        "draw and bake": lambda: cell.draw(ship, 0).bake(120.0),
        "severity of the drawn sea": lambda: SeawayMotion(motion.waves, motion.response, motion.point).deck,
    }
    return {name: 1e3 * min(timeit.repeat(job, number=10, repeat=repeats)) / 10 for name, job in jobs.items()}


def print_cells(console: Console, ship: Ship, seeds: int, step_deg: float) -> None:
    """Every sea state, heading and speed against the spectral integral; the worst cell of each severity."""
    grid = itertools.product((3, 4, 5, 6), np.arange(0.0, 360.0, step_deg), (0.0, 5.0, 10.0, 15.0, 20.0))
    spreads = [spread_of(ship, Cell(int(s), float(h), float(u)), seeds) for s, h, u in grid]
    table = Table(
        "severity", "worst error [%]", "at SS, deg, kn", "RMS error [%]", "worst scatter [%]", "at SS, deg, kn",
        title=f"{len(spreads)} cells, {seeds} draws each: long-run RMS against the spectral integral",
    )  # fmt: skip
    for k, name in enumerate(SEVERITIES.values()):
        errors, scatters = ([getattr(spread, part)[k] for spread in spreads] for part in ("error", "scatter"))
        worst, wide = spreads[int(np.argmax(errors))].cell, spreads[int(np.argmax(scatters))].cell
        table.add_row(
            name, f"{100.0 * max(errors):.2f}", _where(worst),
            f"{100.0 * float(np.sqrt(np.mean(np.square(errors)))):.2f}", f"{100.0 * max(scatters):.3f}", _where(wide),
        )  # fmt: skip
    console.print(table)


def _where(cell: Cell) -> str:
    return f"{cell.sea_state}, {cell.heading_deg:g}, {cell.speed_kn:g}"


def print_scatter(console: Console, ship: Ship, seeds: int) -> None:
    """Scatter of ten-minute records about the long-run values."""
    table = Table(
        "SS, deg, kn", *SEVERITIES.values(), title=f"scatter of 600 s records, {seeds} seeds [%] (mean ratio)"
    )
    for cell in (Cell(5, 90, 10), Cell(5, 45, 10), Cell(5, 180, 18), Cell(6, 135, 18), Cell(6, 0, 18)):
        scatter, mean = record_scatter(ship, cell, seeds)
        table.add_row(_where(cell), *(f"{100.0 * s:.1f} ({m:.3f})" for s, m in zip(scatter, mean, strict=True)))
    console.print(table)


def print_reference(console: Console, ship: Ship) -> None:
    """The long-run severities beside the reference figures."""
    table = Table("SS, deg, kn", *SEVERITIES.values(), "zeta4", title="long-run RMS / reference figure = ratio")
    ratios = []
    for (sea_state, speed), rows in REFERENCE.items():
        for heading, row in zip(REFERENCE_HEADINGS, rows, strict=True):
            cell = Cell(sea_state, heading, speed)
            motion = cell.draw(ship, 0)
            found = values(motion.deck)
            ratios.append(found / row)
            texts = (f"{a:.3f} / {b:.3f} = {a / b:.2f}" for a, b in zip(found, row, strict=True))
            table.add_row(_where(cell), *texts, f"{motion.response.roll_damping:.3f}")
    ratio = np.array(ratios)
    table.add_section()
    table.add_row("least", *(f"{r:.2f}" for r in np.min(ratio, axis=0)), "")
    table.add_row("greatest", *(f"{r:.2f}" for r in np.max(ratio, axis=0)), "")
    outside = np.sum(np.abs(ratio - 1.0) > 0.15, axis=0)
    table.add_row("beyond 15 %", *(f"{n} of {len(ratio)}" for n in outside), "")
    console.print(table)


def print_derivatives(console: Console, ship: Ship) -> None:
    """Consistency of the table's derivatives in sea state 6."""
    cells = (Cell(6, 60, 10), Cell(6, 135, 18), Cell(6, 0, 18))
    found = [derivative_errors(cell.draw(ship, 0)) for cell in cells]
    table = Table("relative error", *(_where(cell) for cell in cells), title="finite differences of the table")
    for name in found[0]:
        table.add_row(name, *(f"{errors[name]:.1e}" for errors in found))
    console.print(table)


def print_costs(console: Console, ship: Ship) -> None:
    """Time of a draw and of its table."""
    table = Table("part", "ms", title="cost, SS5, 60 deg, 10 kn, 96 waves")
    for name, milliseconds in costs(ship, Cell(5, 60, 10)).items():
        table.add_row(name, f"{milliseconds:.2f}")
    console.print(table)


@dataclass(frozen=True)
class Options:
    """What to print."""

    ship: str = "frigate"
    """Name or file of the ship."""
    parts: tuple[Part, ...] = ("cells", "scatter", "reference", "derivatives", "cost")
    """Tables to print."""
    seeds: Annotated[int, tyro.conf.arg(help="Draws a cell.")] = 5
    records: Annotated[int, tyro.conf.arg(help="Records for the scatter.")] = 40
    step_deg: Annotated[float, tyro.conf.arg(help="Step of the headings of the cells.")] = 30.0


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the study."""
    options = tyro.cli(Options, args=arguments, description=__doc__)
    console, ship = Console(width=170), load_ship(options.ship)
    jobs: dict[Part, Callable[[], None]] = {
        "cells": lambda: print_cells(console, ship, options.seeds, options.step_deg),
        "scatter": lambda: print_scatter(console, ship, options.records),
        "reference": lambda: print_reference(console, ship),
        "derivatives": lambda: print_derivatives(console, ship),
        "cost": lambda: print_costs(console, ship),
    }
    for part in options.parts:
        jobs[part]()


if __name__ == "__main__":
    main()
