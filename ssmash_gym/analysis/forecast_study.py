"""How far ahead a deck's motion can be foreseen from its past, and how often it is quiet.

``python -m ssmash_gym.analysis.forecast_study`` prints the tables that docs/guide/quiescence.md quotes: the error of
the autoregressive forecaster at each lead beside that of persistence, for readings with 1 % noise and with the noise
of the environment's sensors, and the quiet windows that the oracle finds. Sea state 5, 10 kn, the default ship.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.observations import TERMS
from ssmash_gym.ship.forecast import ORDER, ArModel, persistence
from ssmash_gym.ship.motion import GRAVITY, MotionTable, pose_of
from ssmash_gym.ship.quiescence import ILLUSTRATIVE, statistics, windows
from ssmash_gym.ship.seaway import Seaway

Array = NDArray[np.float64]
Read = Callable[[MotionTable, Array], Array]
RATE_HZ: Final = 5
FIT_S: Final = 180.0
TEST_S: Final = 420.0
WINDOWS_S: Final = 1800.0
NOISE: Final = 0.01  # of the readings, share of each quantity's own deviation
LEADS_S: Final = (1, 2, 3, 5, 7, 10, 15)
HEADINGS_DEG: Final = (45.0, 90.0, 135.0)
QUANTITIES: Final[Mapping[str, Read]] = {
    "deck_roll": lambda table, t: table.at(t).position[:, 3],
    "deck_fy": lambda table, t: pose_of(table.at(t)).specific_force_S(GRAVITY)[:, 1],
    "deck_fz": lambda table, t: pose_of(table.at(t)).specific_force_S(GRAVITY)[:, 2],
    "vertical velocity": lambda table, t: table.at(t).rate[:, 2],
    "lateral acceleration": lambda table, t: table.at(t).acceleration[:, 1],
}


def sea(heading_deg: float, seed: int, duration_s: float) -> MotionTable:
    """A record of the deck in sea state 5 at 10 kn; waves travel to `heading_deg` relative to the ship [deg]."""
    section = Seaway(sea_state=5, heading_deg=heading_deg, speed_kn=10.0, components=256)
    return section.realise(np.random.default_rng(seed)).bake(duration_s)


def errors(table: MotionTable, names: Sequence[str], noise: Sequence[float] | None, seed: int) -> tuple[Array, Array]:
    """Errors of the forecasts and of persistence over a record, the first `FIT_S` of which are used for the fit.

    Args:
        table: The record, `FIT_S` + `TEST_S` long or longer.
        names: Of `QUANTITIES`.
        noise: Standard deviation of each reading, SI; None takes the share `NOISE` of the quantity's own. Errors are
            against the truth without noise.
        seed: Of the noise.

    Returns:
        Twice (leads, quantities): root mean square error over the truth's deviation; 1 is no skill.
    """
    count, fitted = round((FIT_S + TEST_S) * RATE_HZ), round(FIT_S * RATE_HZ)
    t = np.arange(count) / RATE_HZ
    truth = np.stack([QUANTITIES[name](table, t) for name in names], axis=1)
    level = NOISE * np.std(truth, axis=0) if noise is None else np.asarray(noise)
    readings = truth + level * np.random.default_rng(seed).standard_normal(truth.shape)
    leads = [lead * RATE_HZ for lead in LEADS_S]
    model = ArModel.fit(readings[:fitted])
    return (
        _errors(readings[fitted:], truth[fitted:], leads, model.weights(leads), model.mean),
        _errors(readings[fitted:], truth[fitted:], leads, persistence(ORDER, leads, len(names)), model.mean),
    )


def _errors(readings: Array, truth: Array, leads: list[int], weights: Array, mean: Array) -> Array:
    past = np.lib.stride_tricks.sliding_window_view(readings - mean, ORDER, axis=0)[..., ::-1]
    told = mean + np.einsum("ncp,lpc->lnc", past, weights)
    off = [told[k, :-lead] - truth[ORDER - 1 + lead :] for k, lead in enumerate(leads)]
    return np.asarray(np.stack([np.sqrt(np.mean(e**2, axis=0)) for e in off]) / np.std(truth, axis=0))


def skill(
    heading_deg: float, seeds: int, names: Sequence[str] = tuple(QUANTITIES), noise: Sequence[float] | None = None
) -> tuple[Array, Array]:
    """`errors`, root mean square over seas drawn with seeds 0, 1, ...: forecasts and persistence."""
    found = [errors(sea(heading_deg, seed, FIT_S + TEST_S), names, noise, seed) for seed in range(seeds)]
    squares = np.mean(np.square(np.array(found)), axis=0)
    return np.sqrt(squares[0]), np.sqrt(squares[1])


def quiet(heading_deg: float, seeds: int) -> dict[str, float]:
    """Windows within the illustrative limits in half-hour records of one heading, averaged over seeds 0, 1, ..."""
    found = []
    for seed in range(seeds):
        table = sea(heading_deg, seed, WINDOWS_S)
        s = statistics(windows(table, ILLUSTRATIVE), WINDOWS_S)
        every = statistics(windows(table, ILLUSTRATIVE, shortest_s=0.0), WINDOWS_S)
        found.append((every.fraction, s.fraction, s.count, s.median_s, s.spacing_s))
    keys = ("within limits", "in windows of 6 s or more", "windows in 30 min", "median [s]", "spacing [s]")
    return dict(zip(keys, np.mean(found, axis=0).tolist(), strict=True))


def main(seeds: int = 8) -> None:
    """Print the study."""
    from rich.console import Console
    from rich.table import Table

    console = Console(width=150)
    measured = [name for name in QUANTITIES if name in TERMS]
    kinds: dict[str, tuple[list[str], list[float] | None]] = {
        f"{100.0 * NOISE:g} % noise": (list(QUANTITIES), None),
        "the sensors' nominal noise": (measured, [TERMS[name].noise for name in measured]),
    }
    for kind, (names, noise) in kinds.items():
        table = Table("lead [s]", *(f"{lead}" for lead in LEADS_S), title=f"error / deviation, {kind}, 45/90/135 deg")
        told = [skill(heading, seeds, names, noise) for heading in HEADINGS_DEG]
        for row, of in enumerate(("", " by persistence")):
            for column, name in enumerate(names):
                cells = ["/".join(f"{both[row][k, column]:.2f}" for both in told) for k in range(len(LEADS_S))]
                table.add_row(name + of, *cells)
        console.print(table)
    table = Table("heading [deg]", *quiet(0.0, 1), title="sea state 5, 10 kn, illustrative limits")
    for heading in (0.0, 45.0, 90.0, 135.0, 180.0):
        table.add_row(f"{heading:g}", *(f"{value:.2f}" for value in quiet(heading, seeds).values()))
    console.print(table)


if __name__ == "__main__":
    main()
