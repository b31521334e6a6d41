"""What a monitor is told before it starts; every number is checked once and goes into the header."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Final

from ssmash_gym.errors import refusal
from ssmash_gym.ship.forecast import ORDER
from ssmash_gym.ship.quiescence import ILLUSTRATIVE

SPACING_S: Final = 0.2  # of the samples that are forecast: 5 Hz
ANSWER_S: Final = 1.0  # time between answers; a whole number of samples, deck nodes and control intervals
SUBSTEP_S: Final = 0.005  # of the simulated copies: peak probe loads within 0.1 % of those at the task's 2 ms


@dataclass(frozen=True)
class Settings:
    """Settings of a monitor.

    Attributes:
        helicopter: Name or file.
        task: Name or file: its limits, its track, its claw.
        limits: Changes to the task's limits, by key.
        policy: Who would drive: a baseline, a trained agent that ships with the package, or an agent's folder.
        copies: Futures, and so simulated traverses, for each answer.
        horizon_s: How long each traverse is simulated [s].
        seed: Of the futures.
        yaw_deg: Heading of the secured helicopter relative to the track [deg].
        lateral_m: Claw from the centre line, starboard positive [m].
        wind_m_s: Steady wind over the deck [m/s].
        wind_from_deg: Where it comes from, from the bow over starboard [deg].
        deck_limits: Limits of the deck's motion at any instant, as in `ship.quiescence`; assumed.
        quiet_share: Share of the futures that must stay within the deck limits for a window to be foreseen.
        past_s: Longest past that a forecast is fitted on [s].
        least_past_s: Past without a gap that is needed for an answer [s].
        longest_gap_s: Longest time between two usable samples that is bridged [s].
        stuck_s: Time after which a channel that repeats one number counts as stuck [s].
        silence_s: Wall-clock time without a usable sample after which a live input counts as silent [s].
        threads: Workers; answers do not depend on it.

    Raises:
        ConfigurationError: A number is out of its range; one sentence.
    """

    helicopter: str = "generic_tricycle"
    task: str = "traverse"
    limits: Mapping[str, float] = field(default_factory=dict)
    policy: str = "linear"
    copies: int = 64
    horizon_s: float = 45.0
    seed: int = 0
    yaw_deg: float = 0.0
    lateral_m: float = 0.0
    wind_m_s: float = 0.0
    wind_from_deg: float = 0.0
    deck_limits: Mapping[str, float] = field(default_factory=lambda: dict(ILLUSTRATIVE))
    quiet_share: float = 0.5
    past_s: float = 180.0
    least_past_s: float = 60.0
    longest_gap_s: float = 0.5
    stuck_s: float = 3.0
    silence_s: float = 2.0
    threads: int = 2

    def __post_init__(self) -> None:
        """Check the ranges."""
        fit_s = 2 * ORDER * SPACING_S
        for name, low, high in (
            ("copies", 2, 4096),
            ("horizon_s", 1.0, 60.0),
            ("seed", 0, 2**53),
            ("yaw_deg", -90.0, 90.0),
            ("lateral_m", -10.0, 10.0),
            ("wind_m_s", 0.0, 50.0),
            ("wind_from_deg", -360.0, 360.0),
            ("quiet_share", 0.01, 1.0),
            ("least_past_s", fit_s, 3600.0),
            ("past_s", self.least_past_s, 3600.0),
            ("longest_gap_s", 0.01, 2.0),
            ("stuck_s", 0.5, 60.0),
            ("silence_s", 0.5, 60.0),
            ("threads", 1, 256),
        ):
            value = getattr(self, name)
            if isinstance(value, bool) or not (math.isfinite(value) and low <= value <= high):
                raise refusal("monitor", name, value, f"must be from {low:g} to {high:g}")

    @property
    def answered_from(self) -> dict[str, Any]:
        """All that an answer depends on, as plain numbers: the threads are left out."""
        return {key: value for key, value in asdict(self).items() if key != "threads"}
