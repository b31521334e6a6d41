"""How well a window's rule decides cells whose true probability is known, and what it saves over a fixed design.

    python tools/window_calibration.py [--cells 20000] [--seed 0] [--first 20] [--step 20] [--most 100]

Cells are synthetic: independent Bernoulli episodes. Rounds, intervals and verdicts are those of `ssmash window`
(`ssmash_gym.windows.plan`, `sequential`). Prints a table for docs/guide/windows.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest

from ssmash_gym.windows.config import WindowConfig, load_window
from ssmash_gym.windows.plan import Tally, rounds
from ssmash_gym.windows.sequential import BEYOND, UNDECIDED, WITHIN, Bounds, bounds

PROBABILITIES = (0.0, 0.01, 0.02, 0.05, 0.08, 0.1, 0.12, 0.15, 0.2, 0.3, 0.5, 0.9)
WHO = ("traverse", "synthetic")


@dataclass(frozen=True)
class Figures:
    """What the rule did to cells of one true probability; shares of the cells.

    Attributes:
        probability: The true one.
        covered: Intervals at the end that hold it.
        always: Cells whose intervals held it after every round.
        wrong: Decided, and on the wrong side.
        undecided: Not decided.
        episodes: Mean number of episodes.
        fixed_wrong, fixed_undecided: The same with the fixed design: `most` episodes each, one Wilson interval.
    """

    probability: float
    covered: float
    always: float
    wrong: float
    undecided: float
    episodes: float
    fixed_wrong: float
    fixed_undecided: float


def window(first: int, step: int, most: int, acceptance: float = 0.1, confidence: float = 0.95) -> WindowConfig:
    """A window with such an effort; its cells are synthetic."""
    effort = {"seeds": first, "step": step, "most": most}
    return load_window(
        {
            "seed": 0, "scenario": "ss5", "axes": {"speed_kn": [0.0]}, "limits": {"probe_in_plane_kN": 15.0},
            "acceptance": acceptance, "confidence": confidence, "effort": effort,
        }
    )  # fmt: skip


def calibrated(config: WindowConfig, probability: float, cells: int, rng: np.random.Generator) -> Figures:
    """Run the rule on synthetic cells of one probability.

    Args:
        config: Its effort, acceptance and confidence.
        probability: Of an exceedance, in each episode.
        cells: How many.
        rng: Draws the episodes.
    """
    most = config.effort.most
    exceeded = rng.random((cells, most)) < probability
    tally = Tally.blank(cells, most)
    counts, always = np.zeros(cells, np.int64), np.ones(cells, np.bool_)
    while True:
        wanted = rounds(config, {WHO: tally})[WHO]
        if np.array_equal(wanted, counts):
            break
        counts = wanted
        done = np.arange(most) < counts[:, None]
        tally = Tally(done, exceeded & done)
        found = bounds(tally.hits(counts), counts, config.confidence)
        always &= (found.low <= probability) & (probability <= found.high)
    verdicts = found.verdicts(config.acceptance)
    fixed = fixed_verdicts(exceeded.sum(axis=1), most, config)
    return Figures(
        probability,
        float(np.mean((found.low <= probability) & (probability <= found.high))),
        float(np.mean(always)),
        float(np.mean(wrong(verdicts, probability, config.acceptance))),
        float(np.mean(verdicts == UNDECIDED)),
        float(np.mean(counts)),
        float(np.mean(wrong(fixed, probability, config.acceptance))),
        float(np.mean(fixed == UNDECIDED)),
    )


def wrong(verdicts: np.ndarray, probability: float, acceptance: float) -> np.ndarray:
    """Which verdicts say the opposite of the truth."""
    return np.asarray(verdicts == (BEYOND if probability <= acceptance else WITHIN))


def fixed_verdicts(hits: np.ndarray, episodes: int, config: WindowConfig) -> np.ndarray:
    """Verdicts of a fixed number of episodes with Wilson's interval."""
    found = [binomtest(k, episodes).proportion_ci(config.confidence, method="wilson") for k in range(episodes + 1)]
    bounds = Bounds(*(np.array([getattr(one, side) for one in found])[hits] for side in ("low", "high")))
    return bounds.verdicts(config.acceptance)


def main(words: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, default in (("cells", 20000), ("seed", 0), ("first", 20), ("step", 20), ("most", 100)):
        parser.add_argument(f"--{name}", type=int, default=default)
    given = parser.parse_args(words)
    config = window(given.first, given.step, given.most)
    rng = np.random.default_rng(given.seed)
    print(f"{given.cells} cells each; acceptance {config.acceptance:g}, confidence {config.confidence:g}")
    heads = "true probability", "covered at the end %", "after every round %", "wrong %", "undecided %", "episodes"
    print("| " + " | ".join((*heads, "saved %", "fixed: wrong %", "fixed: undecided %")) + " |")
    print("|---|---|---|---|---|---|---|---|---|")
    for probability in PROBABILITIES:
        f = calibrated(config, probability, given.cells, rng)
        saved = 100.0 * (1.0 - f.episodes / config.effort.most)
        shares = [100.0 * x for x in (f.covered, f.always, f.wrong, f.undecided)]
        print(f"| {probability:g} | " + " | ".join(f"{x:.1f}" for x in shares) + f" | {f.episodes:.0f} | {saved:.0f} | "
              f"{100 * f.fixed_wrong:.1f} | {100 * f.fixed_undecided:.1f} |")  # fmt: skip


if __name__ == "__main__":
    main()
