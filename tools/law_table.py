"""Prints what the scripted policies make of sea state 5 for each delay of the drive, as a table for the guide.

python tools/law_table.py --episodes 256

The seeds are a block of the purpose TUNING that no search has met. Landing yaw is drawn within 8 degrees, or zero.
"""

from __future__ import annotations

import argparse

import numpy as np
from ssmash_gym.agents.baselines import BASELINES

from ssmash_gym.envs import load_scenario, load_task
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.policies import make_baseline
from ssmash_gym.evaluation.statistics import bootstrap, p95, share
from ssmash_gym.training.seeds import TUNING, block

TABLE_SEEDS = 4  # number of the block
UNMOVED = ("hold", "trapezoid", "operator")  # have no gains for a delay


def line(name: str, delay_s: float, straight: bool, options: argparse.Namespace) -> str:
    """A row of the table."""
    start = {"start": {"yaw_deg": 0.0}} if straight else {}
    task = load_task({"claw": {"delay_s": delay_s}})
    scenario = load_scenario({"base": options.scenario, **start})
    seeds = block(TABLE_SEEDS, TUNING, options.episodes)
    frame = run_episodes(make_baseline(name, task), scenario, seeds, threads=options.threads)
    peak = frame["scored_peak_kN"].to_numpy()
    load, reached = bootstrap(peak, p95), share(frame["success"].to_numpy().astype(float))
    times = frame["time_s"].to_numpy()[frame["success"].to_numpy()]
    landed = "0" if straight else "+-8"
    return (
        f"| `{name}` | {landed} | {delay_s:g} | {100 * reached.value:.1f} ({100 * reached.low:.0f} to "
        f"{100 * reached.high:.0f}) | {load.value:.1f} ({load.low:.1f} to {load.high:.1f}) | {np.mean(peak):.1f} | "
        f"{np.median(times) if times.size else 60.0:.1f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policies", nargs="+", default=list(BASELINES), choices=list(BASELINES))
    parser.add_argument("--scenario", default="ss5")
    parser.add_argument("--episodes", type=int, default=256)
    parser.add_argument("--delays", nargs="+", type=float, default=[0.0, 0.1, 0.2])
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    print("| policy | landing yaw deg | delay s | success % | peak P95 kN | mean kN | median time s |")
    print("|---|---|---|---|---|---|---|", flush=True)
    for name in options.policies:
        for delay_s in options.delays if name not in UNMOVED else [0.1]:
            print(line(name, delay_s, False, options), flush=True)
        print(line(name, 0.1, True, options), flush=True)


if __name__ == "__main__":
    main()
