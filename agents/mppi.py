"""Model-predictive control by sampling (MPPI): plans sampled anew all the time, rehearsed on a forecast of the deck.

It knows the present state and the parameters of the simulated helicopter exactly, as a fork of the simulation does
(`nominal` takes the helicopter as described instead), and of the deck's motion the past alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.baselines import Readout
from ssmash_gym.agents.planning_forecast import ArForecast
from ssmash_gym.agents.planning_law import Law, Seen
from ssmash_gym.agents.planning_policy import Observations, Planner
from ssmash_gym.agents.planning_rehearsal import Rehearsal
from ssmash_gym.agents.planning_search import Cost, Span, noise, weights

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.ship.forecast import ordered_sum

Array = NDArray[np.float64]
Columns = NDArray[np.int64]


@dataclass(frozen=True)
class MppiSettings:
    """How the planner plans; all numbers are assumed, the tried ones stand in docs/guide/planning.md.

    Attributes:
        law: What plans are added to.
        cost: What plans cost.
        samples: Plans rehearsed each time, the last plan among them.
        spread_m_s: Standard deviation of a sampled knot along and across the track [m/s].
        sharpness: Of the weights: the worst sample has exp(-sharpness) times the weight of the best.
        window_s: How long after a knot begins to act loads are counted for it [s].
        horizon_s: How far a rehearsal goes [s].
        replan_s: Time between two plans [s].
        substep_s: Of the rehearsals [s].
        nominal: Rehearse with the helicopter as described instead of the simulated one.
        together: Helicopters planned at once, for the memory's sake; results do not depend on it.
        seed: Of the samples.
    """

    law: Law = field(default_factory=Law)
    cost: Cost = field(default_factory=lambda: Cost(margin=0.4))
    samples: int = 40
    spread_m_s: tuple[float, float] = (0.04, 0.015)
    sharpness: float = 10.0
    window_s: float = 3.5
    horizon_s: float = 5.0
    replan_s: float = 0.5
    substep_s: float = 0.005
    nominal: bool = False
    together: int = 32
    seed: int = 0


class Mppi(Planner):
    """Replans every `replan_s`: each knot becomes the weighted mean of its samples.

    Args:
        task: The task it is to be used in.
        settings: How it plans.

    Raises:
        ConfigurationError: The task's observation lacks a term that is read.
    """

    name = "mppi"

    def __init__(self, task: TaskConfig, settings: MppiSettings | None = None) -> None:
        self.settings = settings or MppiSettings()
        super().__init__(task, self.settings.law, max(1, round(self.settings.replan_s / task.control_interval_s)))
        self._readout = Readout(task, ("probe_fy", "yaw", "claw_x", "claw_y"))
        self._rehearsal: Rehearsal
        self._future: ArForecast

    def prepare(self, core: TraverseBatch) -> None:
        """Make what rehearsals need."""
        self._rehearsal = Rehearsal(core, self.drive, self.settings.substep_s, nominal=self.settings.nominal)
        self._future = ArForecast(core, self.settings.horizon_s)

    def begin(self, rows: Columns) -> None:
        """New episodes begin in these rows."""
        self._future.begin(rows)

    def seen(self, observations: Observations) -> Seen:
        """What the law reads: the observation, noise and delay included."""
        told = [self._readout(observations, term) for term in ("probe_fy", "yaw", "claw_x", "claw_y")]
        return Seen(*told)

    def improved(self, rows: Columns, step: int, plans: Array) -> Array:
        """Plans of the listed helicopters, (n, knots, 2)."""
        together = self.settings.together
        parts = [slice(first, first + together) for first in range(0, rows.size, together)]
        return np.concatenate([self._sampled(rows[part], step, plans[part]) for part in parts])

    def _sampled(self, rows: Columns, step: int, plans: Array) -> Array:
        settings = self.settings
        intervals = round(settings.horizon_s / self.task.control_interval_s)
        span = Span(self.drive, settings.cost, step, min(intervals, self.task.horizon_steps - step))
        changes = noise((settings.seed, step), settings.samples, span.knots.size) * settings.spread_m_s * span.free
        changes[-1] = 0.0
        tried = np.repeat(plans[None], settings.samples, axis=0)
        tried[:, :, span.knots] += changes[:, None]
        steps = np.full(rows.size, step)
        outcome = self._rehearsal.run(rows, *self._future.nodes(rows), tried, steps, span.intervals)
        share = weights(span.of_knots(outcome, settings.window_s), settings.sharpness)  # (samples, knots, n)
        mean = ordered_sum(share[..., None] * changes[:, :, None])  # (knots, n, 2)
        better = plans.copy()
        better[:, span.knots] += np.moveaxis(mean, 0, 1)
        return better
