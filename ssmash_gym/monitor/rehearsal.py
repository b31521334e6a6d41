"""The secured helicopter of now, and copies of it that are driven through possible futures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs import limits
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.observations import chosen_terms
from ssmash_gym.envs.reading import Reading, columns_of, half_spread
from ssmash_gym.envs.scenario import EpisodeDraw, ScenarioConfig, load_scenario
from ssmash_gym.envs.starts import Starter
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.policies import Policy, baselines, find_agent, make_baseline, planners
from ssmash_gym.monitor.judging import JUDGED, NONE, SECURED, judged
from ssmash_gym.monitor.settings import SUBSTEP_S, Settings
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import DEFAULT_SPACING_S, MotionTable
from ssmash_gym.simulation.batch import Batch, Snapshot
from ssmash_gym.vehicle import Helicopter, load_helicopter

Columns = NDArray[np.int64]
PROBE_LOST: Final = "the probe of the secured helicopter has given way"
DIVERGED: Final = "the simulation of the secured helicopter has failed"


@dataclass(frozen=True)
class Scene:
    """What is simulated: helicopter, task, policy, and the one draw that all copies share."""

    helicopter: Helicopter
    policy: Policy
    scenario: ScenarioConfig
    draw: EpisodeDraw

    @property
    def task(self) -> TaskConfig:
        """The task as the policy has it."""
        return self.policy.task

    @classmethod
    def of(cls, settings: Settings) -> Scene:
        """Load everything by name.

        Raises:
            ConfigurationError: A name or a number is refused; one sentence.
        """
        task = load_task({"base": settings.task, "substep_s": SUBSTEP_S, "limits": dict(settings.limits)})
        policy = chosen_policy(settings.policy, task)
        if settings.horizon_s > policy.task.horizon_s + 1e-9:
            raise ConfigurationError(
                f"monitor: horizon_s = {settings.horizon_s:g} is refused: must be at most the {task.horizon_s:g} s of "
                "the task."
            )
        scenario = load_scenario(
            {
                "base": "flat",
                "start": {"yaw_deg": settings.yaw_deg, "lateral_m": settings.lateral_m},
                "wind": {"speed_mps": settings.wind_m_s, "from_deg": settings.wind_from_deg},
            }
        )
        draw = scenario.sample(np.random.default_rng(0))  # nothing is drawn: every quantity is one value
        return cls(load_helicopter(settings.helicopter), policy, scenario, draw)


def chosen_policy(name: str, task: TaskConfig) -> Policy:
    """A baseline, or a trained agent within the task.

    Raises:
        ConfigurationError: There is none, it plans on the running simulation, or it reads more than sensors.
    """
    plain = name.partition("@")[0]
    if plain in planners():
        raise ConfigurationError(f"monitor: policy = {name!r} is refused: a planner needs too long for every copy.")
    policy = make_baseline(name, task) if plain in baselines() else cast("Policy", find_agent(name).within(task))
    beyond = [term.name for term in chosen_terms(policy.task.observation) if term.forecast_of or term.oracle_of]
    if beyond or policy.task.residual is not None:
        what = beyond[0] if beyond else "a residual action"
        raise ConfigurationError(f"monitor: policy = {name!r} is refused: it needs {what}, which copies do not have.")
    return policy


class Shadow:
    """Secured helicopters that go through measured motions, claw held.

    Args:
        scene: What is simulated.
        count: How many, each with a deck of its own.
        threads: Workers.
    """

    def __init__(self, scene: Scene, count: int = 1, threads: int = 1) -> None:
        self._scene = scene
        self._starter = Starter(scene.helicopter, scene.task, scene.scenario)
        self._half_spread = half_spread(self._starter.helicopter)
        self.batch: Batch = self._starter.batch(count, threads)
        self._all = np.arange(count)
        self.begin()

    def begin(self) -> None:
        """Put all of them on a level deck at rest."""
        self._starter.start(self.batch, self._all, [self._scene.draw] * self._all.size)

    def advance(self, nodes: FloatArray, intervals: int) -> dict[str, FloatArray]:
        """Go through a piece of motion.

        Args:
            nodes: One piece for each, (count, n, 18), from now on.
            intervals: Control intervals that the piece lasts.

        Returns:
            Least margin within the piece of each limit that a secured helicopter can exceed, by name, (count,) each.
        """
        self.batch.set_motion([MotionTable(DEFAULT_SPACING_S, piece) for piece in nodes])
        self.batch.advance(None, intervals=intervals)
        telemetry, broken = columns_of(self.batch.telemetry, self._all)
        n, task = self._all.size, self._scene.task
        reading = Reading(
            task=task, telemetry=telemetry, steps=np.ones(n, np.int64), counted=np.ones(n, np.bool_),
            command=np.zeros((n, 2)), previous=np.zeros((n, 2)), held_before=np.zeros(n, np.int64),
            peak_before_N=np.zeros(n), broken=broken, half_spread_m=self._half_spread, limit_steps=task.horizon_steps,
        )  # fmt: skip
        margins = limits.margins(reading)
        return {name: margins[name] for name in SECURED}

    def lost(self, k: int = 0) -> str:
        """Why a helicopter is no longer secured; empty while it is."""
        if self.batch.diverged[k]:
            return DIVERGED
        return PROBE_LOST if self.batch.telemetry["probe_lost"][k] > 0.5 else ""

    def snapshot(self) -> Snapshot:
        """Their states, to make copies of."""
        return self.batch.snapshot()


class _Handover(Starter):
    """A starter whose episodes begin where others are now, with the decks that they are given."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene.helicopter, scene.task, scene.scenario)
        self._present: Snapshot | None = None
        self._nodes: FloatArray = np.zeros((0, 2, 18))

    def hand(self, present: Snapshot, of: Columns, nodes: FloatArray) -> None:
        """Say which helicopter each copy is of, and through which motion it goes, (k, n, 18)."""
        self._present, self._nodes = present.of_columns(of), nodes

    def start(self, batch: Batch, columns: Columns, draws: Sequence[EpisodeDraw]) -> None:
        """Put the copies where their helicopters are; their clocks start at the nodes of now."""
        assert self._present is not None
        batch.restore(self._present)
        batch.set_motion([MotionTable(DEFAULT_SPACING_S, nodes) for nodes in self._nodes], columns)


@dataclass(frozen=True, eq=False)
class Rehearsed:
    """How simulated traverses went, (k,) each.

    Attributes:
        first_s: Time of the first exceedance since the start [s]; infinite where there was none within the horizon.
        limit: Which limit that was, a place in `JUDGED`; `NONE` where there was none.
    """

    first_s: FloatArray
    limit: NDArray[np.int64]

    def exceeded(self, horizon_s: float) -> NDArray[np.bool_]:
        """Which have exceeded a limit within a horizon."""
        return np.asarray(self.first_s <= horizon_s + 1e-9)

    @property
    def most(self) -> str | None:
        """The limit that was exceeded first most often; None where none was."""
        met = self.limit[self.limit != NONE]
        return JUDGED[int(np.argmax(np.bincount(met)))] if met.size else None


class Copies:
    """Copies of secured helicopters, driven by a policy through given motions.

    Args:
        scene: What is simulated.
        count: How many copies at once.
        threads: Workers; results do not depend on it.
    """

    def __init__(self, scene: Scene, count: int, threads: int) -> None:
        self._policy = scene.policy
        self._draws = [scene.draw] * count
        self._handover = _Handover(scene)
        self._core = TraverseBatch(
            count, task=scene.task, scenario=scene.scenario, helicopter=scene.helicopter, threads=threads
        )
        self._core.starter = self._handover

    def drive(self, present: Snapshot, of: Columns, nodes: FloatArray, horizon_s: float) -> Rehearsed:
        """Start all copies now and drive each until it exceeds a limit, reaches the goal, or the horizon is over.

        Args:
            present: States of the secured helicopters.
            of: Which of them each copy is of, (k,).
            nodes: The motion of each from now on, (k, n, 18).
            horizon_s: How long to look [s].
        """
        core, count = self._core, self._core.n
        self._handover.hand(present, of, nodes)
        seeds: list[Any] = [0] * count
        observations = core.reset(seeds=seeds, draws=self._draws).copy()
        self._policy.reset(count)
        first_s, limit = np.full(count, np.inf), np.full(count, NONE)
        running = np.arange(count)
        for step in range(1, round(horizon_s / core.control_interval_s) + 1):
            actions = self._policy.act(observations)  # of all rows: a policy may remember each
            reading, _ = core.moved(actions[running], None if running.size == count else running)
            core.book.peak_probe_N[running] = reading.episode_peak_N
            margins = limits.margins(reading)
            conditions = limits.endings(reading, margins)
            failed = np.any([flags for name, flags in conditions.items() if limits.failed(name)], axis=0)
            which = judged(margins, failed, reading.counted)
            over = which != NONE
            first_s[running[over]], limit[running[over]] = step * core.control_interval_s, which[over]
            observations[running] = self._observed(reading, running)
            running = running[~(over | conditions[limits.GOAL])]
            if not running.size:
                break
        return Rehearsed(first_s, np.asarray(limit, dtype=np.int64))

    def _observed(self, reading: Reading, running: Columns) -> NDArray[np.float32]:
        scaled = self._core.observer.scaled(reading)
        if self._core.task.history is not None:
            self._core.sensors.read(running, scaled)
        return self._core.observer.observation(scaled)[0]
