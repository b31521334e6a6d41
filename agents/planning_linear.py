"""Plans improved by a linear model of what their knots do, fitted to rehearsed samples.

Probe forces and the final pose answer small changes of the claw's speed nearly linearly. So a few dozen rehearsals with
random knots tell how each force at each instant depends on the knots before it (ridge regression with an influence
that fades with time), and the plan of least peak is then a small convex problem: least squares, weighted again and
again by the loads that are left. Rehearsals, not the model, decide which of the proposed plans is taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.planning_law import AXES
from ssmash_gym.agents.planning_rehearsal import Outcome
from ssmash_gym.agents.planning_search import Span

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LinearSearch:
    """Settings of the search; all are assumed, the tried ones stand in docs/guide/planning.md.

    Attributes:
        samples: Rehearsed samples of an iteration.
        load_memory: Iterations whose samples tell how forces depend on the knots.
        spread_m_s: Standard deviation of a sampled knot along and across the track [m/s].
        load_fades_s: Time in which the influence of a knot on the probe force fades [s].
        pose_fades_s: The same of the pose at the end [s].
        ridge: Variance of what the linear model leaves out, in units of one knot's part.
        dampings: Penalties on the size of a step, in kN2 for a knot of one standard deviation: one proposal each.
        shares: Of each proposal, the shares that are rehearsed.
        aim: Weight of the pose at its tolerance [kN].
        rounds: Weighted least squares problems that lead to a proposal.
    """

    samples: int = 40
    load_memory: int = 2
    spread_m_s: tuple[float, float] = (0.012, 0.006)
    load_fades_s: float = 3.0
    pose_fades_s: float = 10.0
    ridge: float = 1.0
    dampings: tuple[float, ...] = (2.0, 0.3, 0.05)
    shares: tuple[float, ...] = (1.0, 0.4)
    aim: float = 15.0
    rounds: int = 16


@dataclass(frozen=True)
class Model:
    """Forces [kN] and pose ratios as linear functions of p knot changes in standard deviations, for n helicopters.

    Attributes:
        force: In the plan itself, (n, m, 2); force_slope: (n, m, 2, p).
        pose: (n, j, 3); pose_slope: (n, j, 3, p).
    """

    force: Array
    force_slope: Array
    pose: Array
    pose_slope: Array


@dataclass(frozen=True)
class _Samples:
    """Rehearsed samples of one iteration.

    Attributes:
        drawn: Knot changes in standard deviations, (samples, p).
        force: What they changed of the forces [kN], (m, n, 2, samples); pose: of the pose ratios, (j, n, 3, samples).
    """

    drawn: Array
    force: Array
    pose: Array


class LinearSteps:
    """The linear search in one span of time: ask for `samples`, rehearse them, ask for `proposals`, and so on.

    Args:
        search: Settings.
        span: What is planned.
    """

    def __init__(self, search: LinearSearch, span: Span) -> None:
        self._search = search
        self._span = span
        self._free = np.flatnonzero(span.free)
        self._knot_s = np.repeat(span.knot_s, AXES)[self._free]
        self._spread = np.tile(search.spread_m_s, span.knots.size)[self._free]
        self._gap_s = span.knot_s[1] - span.knot_s[0]
        self._instants = np.flatnonzero(span.counted)
        self._drawn: Array = np.zeros((0, self._free.size))
        self._memory: list[_Samples] = []

    def samples(self, drawn: Array) -> Array:
        """Changes to rehearse, the last one none at all, (samples + 1, knots, 2) [m/s].

        Args:
            drawn: Standard normal noise, (samples, knots, 2).
        """
        self._drawn = drawn.reshape(len(drawn), -1)[:, self._free]
        return np.concatenate([self._spelt_out(self._drawn), np.zeros((1, self._span.knots.size, AXES))])

    def proposals(self, outcome: Outcome) -> Array:
        """Changes of the plan that the rehearsals of `samples` suggest, (proposals, n, knots, 2) [m/s]."""
        force = 1e-3 * np.stack([outcome.force_x_N, outcome.force_y_N], axis=-1)[self._instants]
        pose = self._span.ratios(outcome)
        self._memory.append(_Samples(self._drawn, _deviations(force), _deviations(pose)))
        plain_force, plain_pose = (np.moveaxis(values[:, -1], 1, 0) for values in (force, pose))
        model = Model(plain_force, self._force_slope(), plain_pose, self._pose_slope())
        found = []
        for damping in self._search.dampings:
            step = self._least_peak(model, damping)
            found += [self._spelt_out(share * step) for share in self._search.shares]
        return np.stack(found)

    def _spelt_out(self, steps: Array) -> Array:
        """Changes of all knots (..., knots, 2) [m/s] from those of the free ones (..., p) in standard deviations."""
        full = np.zeros((*steps.shape[:-1], 2 * self._span.knots.size))
        full[..., self._free] = steps * self._spread
        return full.reshape(*steps.shape[:-1], self._span.knots.size, 2)

    def _gain(self, drawn: Array, start_s: float, end_s: float, fades_s: float) -> Array:
        """What turns samples' deviations between two times into slopes, (p, samples): Bayesian linear regression."""
        acting = self._knot_s - self._gap_s < end_s
        prior = np.where(acting, np.exp(-np.maximum(start_s - self._knot_s, 0.0) / fades_s), 0.0)
        weighted = drawn * prior
        normal = weighted @ drawn.T + self._search.ridge * np.eye(len(drawn))
        return np.asarray(np.linalg.solve(normal, weighted).T)

    def _force_slope(self) -> Array:
        """How the forces depend on the knots, from the newest samples, (n, m, 2, p)."""
        recent = self._memory[-self._search.load_memory :]
        drawn = np.concatenate([samples.drawn for samples in recent])
        deviations = np.concatenate([samples.force for samples in recent], axis=-1)
        block = np.floor(self._span.time_s[self._instants] / self._gap_s - 1e-9).astype(np.int64)
        slopes = np.zeros((*deviations.shape[:-1], self._free.size))
        for b in np.unique(block):
            gain = self._gain(drawn, b * self._gap_s, (b + 1) * self._gap_s, self._search.load_fades_s)
            slopes[block == b] = deviations[block == b] @ gain.T
        return np.swapaxes(slopes, 0, 1)

    def _pose_slope(self) -> Array:
        """How the pose depends on the knots, from all samples, (n, j, 3, p): it changes less from plan to plan."""
        drawn = np.concatenate([samples.drawn for samples in self._memory])
        deviations = np.concatenate([samples.pose for samples in self._memory], axis=-1)
        ends = self._span.time_s[self._span.judged]
        gain = self._gain(drawn, float(ends[0]), float(ends[-1]), self._search.pose_fades_s)
        return np.swapaxes(deviations @ gain.T, 0, 1)

    def _least_peak(self, model: Model, damping: float) -> Array:
        """Step of least peak in the linear model, (n, p): least squares weighted by the loads that are left."""
        n, _, _, p = model.force_slope.shape
        pose_slope = self._search.aim * model.pose_slope.reshape(n, -1, p)
        pose = self._search.aim * model.pose.reshape(n, -1, 1)
        fixed = np.swapaxes(pose_slope, 1, 2) @ pose_slope + damping * np.eye(p)
        wanted = np.swapaxes(pose_slope, 1, 2) @ pose
        slope = model.force_slope.reshape(n, -1, p)
        force = model.force.reshape(n, -1, 1)
        step = np.zeros((n, p, 1))
        for k in range(self._search.rounds):
            left = (force + slope @ step).reshape(n, -1, 2)
            load = np.sqrt(left[..., 0] ** 2 + left[..., 1] ** 2)
            power = min(1.0 + 0.5 * k, self._span.cost.power)
            share = (load / np.maximum(load.max(axis=1, keepdims=True), 1e-9)) ** power
            weighted = np.repeat(share, 2, axis=1)[..., None] * slope
            normal = np.swapaxes(weighted, 1, 2) @ slope + fixed
            better = -np.linalg.solve(normal, np.swapaxes(weighted, 1, 2) @ force + wanted)
            step = step + (better - step) / (1.0 if k == 0 else 1.0 + power)  # a Newton step of the power's problem
        return np.asarray(step[..., 0])


def _deviations(values: Array) -> Array:
    """What samples changed, (m, n, axes, samples), of values (m, samples + 1, n, axes); the last is the plan itself."""
    samples = values.shape[1] - 1
    return np.ascontiguousarray(np.moveaxis(values[:, :samples] - values[:, samples:], 1, -1))
