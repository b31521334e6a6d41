"""Searches the numbers of the law `straighten` and prints them; its defaults in `agents/straighten.py` are the result.

python tools/straighten_search.py

Candidates proposed by Optuna's tree-structured Parzen estimator (seed 0, the first by hand) drive the same episodes of
the scenario `straighten`, with seeds of the purpose TUNING, which neither training nor an evaluation meets. What is
minimised is the mean of mean and 95th percentile of the peak probe loads [kN], plus 3 kN for each percent of successes
below 99 %. The best candidates then drive other TUNING seeds at the task's own substep; the search itself runs at 5 ms.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import Final

import numpy as np
import optuna
import polars as pl
from ssmash_gym.agents.straighten import Gains, Straighten

from ssmash_gym.envs import load_scenario, load_task
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.training.seeds import TUNING, block

RANGES: Final = {  # of each number: least, greatest, logarithmic or not
    "speed_m_s": (0.15, 0.28, False),
    "force_N": (8e3, 18e3, False),
    "force_per_rate_Nm2": (100e3, 400e3, True),
    "give_m_s_per_N": (0.8e-6, 4e-6, True),
    "give_aft_m_s_per_N": (0.3e-6, 3e-6, True),
    "reserve_m": (0.0, 0.5, False),
    "shortest_m": (0.3, 1.2, False),
    "back_up_rad": (0.05, 0.4, False),
    "retreat_m": (0.8, 3.0, False),
}
START: Final = {  # by hand
    "speed_m_s": 0.2, "force_N": 14e3, "force_per_rate_Nm2": 160e3, "give_m_s_per_N": 2e-6, "give_aft_m_s_per_N": 1e-6,
    "reserve_m": 0.3, "shortest_m": 0.6, "back_up_rad": 0.14, "retreat_m": 1.5,
}  # fmt: skip
ALLOWED_FAILURES: Final = 0.01
SEARCH_SUBSTEP_S: Final = 0.005


def score(rows: pl.DataFrame) -> float:
    """What the search minimises [kN]."""
    peaks = rows["scored_peak_kN"].to_numpy()
    share = float(rows["success"].to_numpy().mean())
    return float(0.5 * (peaks.mean() + np.percentile(peaks, 95.0)) + 300.0 * max(0.0, 1.0 - ALLOWED_FAILURES - share))


def driven(gains: Gains, task: TaskConfig, seeds: list[int]) -> pl.DataFrame:
    """Rows of the law's episodes."""
    return run_episodes(Straighten(task, gains), load_scenario("straighten"), seeds)


def line(gains: Gains, rows: pl.DataFrame) -> str:
    """A candidate in words."""
    peaks, numbers = rows["scored_peak_kN"].to_numpy(), ", ".join(f"{k}={v:.4g}" for k, v in asdict(gains).items())
    return (
        f"score {score(rows):6.2f}  success {rows['success'].to_numpy().mean():6.1%}  peak mean {peaks.mean():5.2f}, "
        f"P95 {np.percentile(peaks, 95.0):5.2f} kN  median {np.median(rows['time_s'].to_numpy()):4.1f} s  {numbers}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Search the numbers of the law 'straighten'.")
    parser.add_argument("--trials", type=int, default=16)
    parser.add_argument("--episodes", type=int, default=32)
    parser.add_argument("--chosen", type=int, default=3, help="candidates that drive the second block of seeds")
    given = parser.parse_args()
    coarse, task = load_task({"base": "straighten", "substep_s": SEARCH_SUBSTEP_S}), load_task("straighten")
    seeds = block(0, TUNING, 3 * given.episodes)
    found: list[tuple[float, Gains]] = []

    def objective(trial: optuna.Trial) -> float:
        numbers = {name: trial.suggest_float(name, a, b, log=log) for name, (a, b, log) in RANGES.items()}
        rows = driven(Gains(**numbers), coarse, seeds[: given.episodes])
        found.append((score(rows), Gains(**numbers)))
        print(line(Gains(**numbers), rows), flush=True)
        return found[-1][0]

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=0, n_startup_trials=12))
    study.enqueue_trial(START)
    study.optimize(objective, n_trials=given.trials)
    print("on other seeds:")
    for _, gains in sorted(found, key=lambda pair: pair[0])[: given.chosen]:
        print(line(gains, driven(gains, task, seeds[given.episodes :])), flush=True)


if __name__ == "__main__":
    main()
