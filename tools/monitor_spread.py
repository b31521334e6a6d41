"""How wide the monitor's futures are, and where the truth lies among them: errors drawn one by one and in runs.

``python -m tools.monitor_spread`` prints a table in Markdown.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ssmash_gym.monitor.futures import RUN, DeckModel
from ssmash_gym.monitor.settings import SPACING_S
from ssmash_gym.ship import parse_motion
from tools.monitor_tables import row

HEADINGS_DEG: Final = (20.0, 60.0, 90.0, 135.0, 180.0)
SEEDS: Final = (100, 101, 102)
STARTS: Final = 6
COPIES: Final = 64
PAST: Final = 900  # samples: 180 s
AHEAD: Final = 201
LEADS_S: Final = (2.0, 5.0, 10.0, 20.0, 40.0)


def series_of(heading_deg: float, seed: int) -> Any:
    """Velocities and angles of a sea, (n, 6)."""
    sea = {"type": "seaway", "ship": "frigate", "sea_state": 5, "heading_deg": heading_deg, "speed_kn": 10.0}
    motion = parse_motion({**sea, "components": 256}).realise(np.random.default_rng(seed))
    signal = motion.sample(0.0, SPACING_S, PAST + STARTS * AHEAD)
    return np.concatenate([signal.rate[:, :3], signal.position[:, 3:]], axis=1)


def spread(run: int) -> tuple[Any, Any]:
    """Width of the futures over the past's deviation, and RMS distance of the truth in widths, (leads, 6) each."""
    places = [round(lead / SPACING_S) - 1 for lead in LEADS_S]
    wide, away = [], []
    for heading_deg in HEADINGS_DEG:
        for seed in SEEDS:
            series = series_of(heading_deg, seed)
            for start in range(STARTS):
                past, truth = np.split(series[start * AHEAD : PAST + (start + 1) * AHEAD], [PAST])
                futures = DeckModel.fit(past).sample(COPIES, AHEAD, np.random.default_rng(start), run)[1:, places]
                width = np.std(futures, axis=0)
                wide.append(width / np.std(past, axis=0))
                away.append((truth[places] - np.mean(futures, axis=0)) / width)
    return np.mean(wide, axis=0), np.sqrt(np.mean(np.square(away), axis=0))


def main() -> None:
    """Print the table: least and greatest of the six channels."""
    print(row("Lead [s]", *(f"{what}, runs of {run}" for run in (1, RUN) for what in ("width", "distance"))))
    print("|---|---|---|---|---|")
    found = [table for run in (1, RUN) for table in spread(run)]
    for k, lead in enumerate(LEADS_S):
        print(row(f"{lead:g}", *(f"{np.min(table[k]):.2f} to {np.max(table[k]):.2f}" for table in found)))


if __name__ == "__main__":
    main()
