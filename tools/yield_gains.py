"""Prints what gains of the baseline `yield` make of it: success and peak probe load, beside the trapezoid's.

python tools/yield_gains.py
"""

from __future__ import annotations

import numpy as np
import polars as pl
import ssmash_gym.agents.baselines as baselines

from ssmash_gym.envs import load_scenario, load_task
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.policies import make_baseline

SEEDS = range(700_000, 700_096)  # neither training's nor an evaluation's
GAINS = (  # k_y [m/s per N], k_c [1/s], k_psi [m/s per rad]
    (8e-6, 0.3, 0.3), (5e-6, 0.15, 0.15), (4e-6, 0.2, 0.15), (2e-6, 0.1, 0.05), (4e-6, 0.5, 0.3), (4e-6, 0.6, 0.25),
    (3e-6, 0.3, 0.15), (3e-6, 0.35, 0.2), (3e-6, 0.4, 0.2), (3e-6, 0.4, 0.3), (2.5e-6, 0.3, 0.15), (2.5e-6, 0.3, 0.2),
    (2e-6, 0.2, 0.1), (2e-6, 0.3, 0.1), (1.5e-6, 0.15, 0.05),
)  # fmt: skip


def row(name: str, frame: pl.DataFrame) -> str:
    """One line of the table."""
    peak = frame["scored_peak_kN"].to_numpy()
    return f"| {name} | {frame['success'].mean():.2f} | {np.percentile(peak, 95):.1f} | {np.mean(peak):.1f} |"


def main() -> None:
    task, scenario = load_task(), load_scenario("training")
    print("| k_y, k_c, k_psi | success | peak P95 kN | mean kN |\n|---|---|---|---|")
    print(row("trapezoid", run_episodes(make_baseline("trapezoid", task), scenario, SEEDS)))
    for gains in GAINS:
        baselines.YIELD_M_S_PER_N, baselines.CENTRING_PER_S, baselines.STRAIGHTENING_M_S_PER_RAD = gains
        print(row("{:g}, {:g}, {:g}".format(*gains), run_episodes(make_baseline("yield", task), scenario, SEEDS)))


if __name__ == "__main__":
    main()
