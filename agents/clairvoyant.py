"""The clairvoyant reference: the whole episode planned at its start on the true future of the deck and the wind.

It tells what can be reached by one who knows everything: an upper estimate of any agent's performance, found by a
search that is not exhaustive, and so not a bound. It is no policy for a ship.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.planning_forecast import TrueFuture
from ssmash_gym.agents.planning_law import Law
from ssmash_gym.agents.planning_linear import LinearSearch, LinearSteps
from ssmash_gym.agents.planning_policy import Planner
from ssmash_gym.agents.planning_rehearsal import Outcome, Rehearsal
from ssmash_gym.agents.planning_search import Cost, Span, noise, weights

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.ship.forecast import ordered_sum

Array = NDArray[np.float64]
Columns = NDArray[np.int64]


@dataclass(frozen=True)
class ClairvoyantSettings:
    """How the reference plans; all numbers are assumed.

    Attributes:
        law: What plans are added to.
        cost: What plans cost.
        search: The linear search.
        iterations: Steps of the search.
        window_s: Proposals are joined knot by knot, by what they did so long after the knot began to act [s].
        sharpness: Of the weights in that: the worst proposal has exp(-sharpness) times the weight of the best.
        substep_s: Of the rehearsals [s]: 5 ms give the peaks of 2 ms within 0.2 %.
        together: Helicopters planned at once, for the memory's sake; results do not depend on it.
        seed: Of the samples.
    """

    law: Law = field(default_factory=lambda: Law(spacing_s=0.75))
    cost: Cost = field(default_factory=Cost)
    search: LinearSearch = field(default_factory=LinearSearch)
    iterations: int = 6
    window_s: float = 4.0
    sharpness: float = 20.0
    substep_s: float = 0.005
    together: int = 16
    seed: int = 0


class Clairvoyant(Planner):
    """Plans once, at the start, with the true future; then drives that plan.

    Args:
        task: The task it is to be used in.
        settings: How it plans.
    """

    name = "clairvoyant"

    def __init__(self, task: TaskConfig, settings: ClairvoyantSettings | None = None) -> None:
        self.settings = settings or ClairvoyantSettings()
        super().__init__(task, self.settings.law, replan_every=0)
        self._rehearsal: Rehearsal
        self._future: TrueFuture

    def prepare(self, core: TraverseBatch) -> None:
        """Make what rehearsals need."""
        self._rehearsal = Rehearsal(core, self.drive, self.settings.substep_s)
        self._future = TrueFuture(core, self.task.horizon_s)

    def begin(self, rows: Columns) -> None:
        """New episodes begin in these rows."""

    def improved(self, rows: Columns, step: int, plans: Array) -> Array:
        """Plans of the listed helicopters, (n, knots, 2)."""
        together = self.settings.together
        parts = [slice(first, first + together) for first in range(0, rows.size, together)]
        return np.concatenate([self._searched(rows[part], step, plans[part]) for part in parts])

    def _searched(self, rows: Columns, step: int, plans: Array) -> Array:
        settings, dt = self.settings, self.task.control_interval_s
        end = round((settings.law.arrival_s + self.task.goal.hold_s) / dt) + 4
        span = Span(self.drive, settings.cost, step, min(end, self.task.horizon_steps) - step)
        nodes = self._future.nodes(rows)
        steps = np.full(rows.size, step)
        search = LinearSteps(settings.search, span)
        best, least = plans, np.full(rows.size, np.inf)
        for k in range(settings.iterations):
            drawn = noise((settings.seed, step, k), settings.search.samples, span.knots.size)
            tried = _changed(plans, span, search.samples(drawn)[:, None])
            sampled = self._rehearsal.run(rows, *nodes, tried, steps, span.intervals)
            best, least = _kept(best, least, tried[-1:], span.total_kN(sampled)[-1:])
            tried = np.concatenate([tried[-1:], _changed(plans, span, search.proposals(sampled))])
            proposed = self._rehearsal.run(rows, *nodes, tried, steps, span.intervals)
            best, least = _kept(best, least, tried, span.total_kN(proposed))
            plans = self._joined(span, tried, proposed)
        if settings.iterations:
            total = span.total_kN(self._rehearsal.run(rows, *nodes, plans[None], steps, span.intervals))
            best, least = _kept(best, least, plans[None], total)
        return best

    def _joined(self, span: Span, tried: Array, outcome: Outcome) -> Array:
        """One plan from tried ones: each knot from those that did well in the seconds after it, (n, knots, 2)."""
        share = weights(span.of_knots(outcome, self.settings.window_s), self.settings.sharpness)
        joined = tried[0].copy()
        joined[:, span.knots] = ordered_sum(np.moveaxis(share, 1, 2)[..., None] * tried[:, :, span.knots])
        return joined


def _kept(best: Array, least: Array, tried: Array, total: Array) -> tuple[Array, Array]:
    """The best plans so far (n, knots, 2) with their costs (n,), once `tried` (copies, ...) has cost `total`."""
    rows = np.arange(least.size)
    chosen = np.argmin(total, axis=0)
    better = total[chosen, rows] < least
    return np.where(better[:, None, None], tried[chosen, rows], best), np.where(better, total[chosen, rows], least)


def _changed(plans: Array, span: Span, changes: Array) -> Array:
    """Plans (n, all knots, 2) with changes (copies, n or 1, knots of the span, 2) added: (copies, n, all knots, 2)."""
    tried = np.repeat(plans[None], len(changes), axis=0)
    tried[:, :, span.knots] += changes
    return tried
