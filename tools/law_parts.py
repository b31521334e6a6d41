"""Prints what the parts of the baseline `linear` are worth on the identified model: `python tools/law_parts.py`.

The law with the gains of the file, with one term left out everywhere, and with other speeds along the track; nothing is
searched again. Figures are those of the model (tools/lateral_model.py), not of the simulation.
"""

from __future__ import annotations

import argparse

import numpy as np
from ssmash_gym.agents.laws_feedback import MORE
from ssmash_gym.agents.laws_gains import feedback_gains

from tools.lateral_model import Replay, identify, record
from tools.law_search import LAWS, PLACES, Flat, nested

SPEEDS = (0.85, 0.9, 1.1, 1.25)


def variants(base: Flat) -> dict[str, Flat]:
    """The law and its changes, by what was changed."""
    found = {"all": base}
    found |= {f"without {name}": base | {f"{place}.{name}": 0.0 for place in PLACES} for name in ("deck_fy", *MORE)}
    speeds = [name for name in base if name.endswith("speed_m_s")]
    return found | {f"speeds times {f:g}": base | {name: f * base[name] for name in speeds} for f in SPEEDS}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--delay", type=float, default=0.1, help="of the drive [s]")
    parser.add_argument("--episodes", type=int, default=96)
    options = parser.parse_args()
    recording = record(options.delay, options.episodes)
    replay, law = Replay(recording, identify(recording), options.delay), LAWS["linear"]
    gains = feedback_gains(options.delay, "linear")
    base = {f"schedule.{name}": value for name, value in vars(gains.schedule).items()}
    for place in PLACES:
        base |= {f"{place}.{name}": value for name, value in getattr(gains, place).items()}
    rows = variants(base)
    columns = {name: np.repeat([row[name] for row in rows.values()], options.episodes) for name in base}
    print("| | success % | peak P95 kN | mean of the largest tenth kN | median time s |\n|---|---|---|---|---|")
    for name, found in zip(rows, replay.run(law.make(replay.task, nested(columns)), len(rows)), strict=True):
        print(
            f"| {name} | {100 * found['success']:.0f} | {found['peak_p95_kN']:.1f} | "
            f"{found['peak_top_tenth_kN']:.1f} | {found['median_time_s']:.1f} |"
        )


if __name__ == "__main__":
    main()
