"""What a rehearsed plan is worth, and how sampled plans are drawn and joined."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.planning_law import AXES, Drive
from ssmash_gym.agents.planning_rehearsal import Outcome

from ssmash_gym.ship.forecast import ordered_sum

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cost:
    """What a plan costs, in kN: its peak load, and the goal's tolerances where they are missed. All are assumed.

    Attributes:
        power: Loads within a time are joined by their mean of this power: near the largest, but smooth.
        missed_kN: For yaw, lateral offset or way to go beyond `margin`, for each tolerance.
        margin: Share of the goal's tolerance that costs nothing.
        yaw_deg_per_s: By how much more yaw is allowed for each second before the schedule's arrival [deg/s].
        lateral_m_per_s: The same of the lateral offset [m/s].
        lag_m: How far the claw may be from its schedule under way [m].
        aiming_s: Knots so long before the tolerances are looked at, and later ones, are answerable for misses [s].
    """

    power: float = 8.0
    missed_kN: float = 6.0
    margin: float = 0.6
    yaw_deg_per_s: float = 0.06
    lateral_m_per_s: float = 0.004
    lag_m: float = 0.5
    aiming_s: float = 12.0


class Span:
    """A stretch of an episode's time that is planned: its intervals, and the knots that can change anything in it.

    Args:
        drive: The law that plans are added to.
        cost: What a plan costs.
        now: Control intervals since the start.
        intervals: How many are rehearsed.

    Attributes:
        time_s: Ends of the intervals, (intervals,); counted: which of them count for the peak (grace).
        knots: Places of the free knots in a plan; knot_s: their times; free: axes that may move, (knots, 2).
        judged: Intervals at whose end the tolerances are looked at; tolerances: yaw [rad], lateral [m], way to go [m]
            allowed there, (judged, 3).
    """

    def __init__(self, drive: Drive, cost: Cost, now: int, intervals: int) -> None:
        task, law = drive.task, drive.law
        self.cost = cost
        self.now = now
        self.intervals = intervals
        self.time_s: Array = (now + 1 + np.arange(intervals)) * task.control_interval_s
        self.counted = np.arange(now, now + intervals) >= task.grace_steps
        place = now * task.control_interval_s / law.spacing_s
        last = int(np.ceil((now + intervals) * task.control_interval_s / law.spacing_s))
        self.knots = np.arange(int(place), min(last, law.knots(task) - 1) + 1)
        self.knot_s: Array = self.knots * law.spacing_s
        settled = law.arrival_s + np.array([-1.5, 1.0])  # from here on the schedule alone holds the claw
        self.free = self.knot_s[:, None] < settled
        end = self.time_s >= law.arrival_s + 1.5 * task.control_interval_s
        end |= np.arange(intervals) >= intervals - 1
        self.judged = np.flatnonzero(end)[::-1][::3][::-1]  # every third, the last one among them
        early = np.maximum(law.arrival_s - self.time_s[self.judged], 0.0)
        goal = task.goal
        lag = np.where(early > 0.0, cost.lag_m, goal.x_tolerance_m)
        yaw = np.deg2rad(goal.yaw_tolerance_deg + cost.yaw_deg_per_s * early)
        self.tolerances: Array = np.stack([yaw, goal.y_tolerance_m + cost.lateral_m_per_s * early, lag], axis=1)

    def ratios(self, outcome: Outcome) -> Array:
        """Yaw, lateral offset and way to go over what is allowed, (judged, copies, n, 3)."""
        found = np.stack([outcome.yaw_rad, outcome.probe_y_m, outcome.lag_m], axis=-1)[self.judged]
        return np.asarray(found / self.tolerances[:, None, None, :])

    def missed_kN(self, outcome: Outcome) -> Array:
        """Cost of missing what is allowed, (copies, n)."""
        worst = np.abs(self.ratios(outcome)).max(axis=0)
        beyond = np.maximum(worst - self.cost.margin, 0.0)
        return np.asarray(self.cost.missed_kN * (beyond[..., 0] + beyond[..., 1] + beyond[..., 2]))

    def total_kN(self, outcome: Outcome) -> Array:
        """Peak load and misses, (copies, n)."""
        peak = np.where(self.counted[:, None, None], outcome.load_N, 0.0).max(axis=0)
        return np.asarray(1e-3 * peak + self.missed_kN(outcome))

    def of_knots(self, outcome: Outcome, window_s: float) -> Array:
        """Cost that each knot is answerable for: loads in the `window_s` after it began to act, and misses soon after.

        Returns:
            (copies, knots, n) [kN].
        """
        loads = np.where(self.counted[:, None, None], 1e-3 * outcome.load_N, 0.0) ** self.cost.power
        first = self.knot_s - (self.knot_s[1] - self.knot_s[0])
        found = []
        for start in first:
            within = loads[(self.time_s > start) & (self.time_s <= start + window_s)]
            mean = ordered_sum(within) / len(within) if len(within) else np.zeros(loads.shape[1:])
            found.append(mean ** (1.0 / self.cost.power))
        answerable = self.knot_s > self.time_s[self.judged[0]] - self.cost.aiming_s
        return np.asarray(np.stack(found, axis=1) + answerable[:, None] * self.missed_kN(outcome)[:, None])


def weights(costs: Array, sharpness: float) -> Array:
    """Weights of samples (copies, ...), 1 in sum over the copies: exponential in the cost's place in its range."""
    best, worst = costs.min(axis=0), costs.max(axis=0)
    scaled = np.exp(-sharpness * (costs - best) / np.maximum(worst - best, 1e-12))
    return np.asarray(scaled / ordered_sum(scaled))


def noise(key: tuple[int, ...], copies: int, knots: int) -> Array:
    """Standard normal noise (copies, knots, 2), the same for every helicopter, so that no result depends on a batch."""
    seed = np.random.SeedSequence(key)
    return np.random.Generator(np.random.PCG64(seed)).standard_normal((copies, knots, AXES))
