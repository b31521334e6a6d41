"""After the gradient: evolution of the policy's last layer on what an episode is judged by.

The gradient learns with exploration in every command. That jitter is load by itself, hides what slow changes of speed
are worth, and its reward sums over time what is judged by its peak. Here whole policies are compared instead, without
exploration: the last layer's numbers are drawn from a normal distribution (CMA-ES), each candidate drives the same
seas, and the distribution moves to the better ones. The seas change every few generations, so that none is learned by
heart; the last mean is kept only if it does better than the start in seas that no generation has met.
"""

from __future__ import annotations

import csv
import hashlib
import json
import pickle
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

import ssmash_gym
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.limits import failed
from ssmash_gym.envs.scenario import ScenarioConfig, load_scenario
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.files import whole_file
from ssmash_gym.sections import validated
from ssmash_gym.training.agent import Agent
from ssmash_gym.training.network import Network
from ssmash_gym.training.sections import Evolution, Judgement
from ssmash_gym.training.seeds import EVOLUTION, block, generation_seed, network_seed

Array = NDArray[np.float64]
Metrics = Mapping[str, Any]
COLUMNS: Final = (
    "generation",
    "score_best",
    "score_median",
    "peak_mean_kN",
    "peak_p95_kN",
    "success",
    "time_s",
    "wall_s",
)
STATE: Final = "evolution.pickle"
CURVE: Final = "evolution.csv"
TOGETHER: Final = 640  # helicopters at once; no result depends on it


@dataclass(frozen=True)
class Verdict:
    """How a policy did in a set of seas; less is better.

    Attributes:
        score_kN: What is minimised.
        peak_mean_kN, peak_p95_kN, success, time_s: Mean and 95th percentile of the peaks, share, median time.
    """

    score_kN: float
    peak_mean_kN: float
    peak_p95_kN: float
    success: float
    time_s: float


def judged(episodes: Sequence[Metrics], rule: Judgement, ultimate_kN: float) -> Verdict:
    """One number for the episodes of a policy, and what it is made of.

    Args:
        episodes: The environment's metrics of each.
        rule: What counts how much.
        ultimate_kN: The peak that counts for a failed episode.
    """
    lost = np.array([failed(episode["reason"]) for episode in episodes])
    peaks = np.where(lost, ultimate_kN, [float(episode["peak_probe_kN"]) for episode in episodes])
    success = float(np.mean([episode["success"] for episode in episodes]))
    yaw = np.minimum(np.abs([float(episode["final_yaw_deg"]) for episode in episodes]), 4.0)
    median = float(np.median([float(episode["time_s"]) for episode in episodes]))
    tail = float(np.percentile(peaks, 95.0))
    score = float(np.mean(peaks**rule.power) ** (1.0 / rule.power)) + rule.tail * tail
    score += rule.success_kN * max(0.0, rule.success - success)
    score += rule.yaw_kN_per_deg * float(np.mean(np.maximum(yaw - rule.yaw_deg, 0.0)))
    score += rule.time_kN_per_s * max(0.0, median - rule.time_s)
    return Verdict(score, float(peaks.mean()), tail, success, median)


class Arena:
    """A set of seas in which policies that differ in their last layer are compared.

    Args:
        agent: The policy; its task is the task.
        scenario: What the seas are drawn from.
        seeds: One a sea.
        threads: Workers; results do not depend on them.
        most: Policies that are compared at once, at most.
    """

    def __init__(
        self, agent: Agent, scenario: ScenarioConfig, seeds: Sequence[int], threads: int, most: int = TOGETHER
    ) -> None:
        self.agent = agent
        self.seas = len(seeds)
        self.copies = max(1, min(TOGETHER // self.seas, most))
        first = TraverseBatch(self.seas, task=agent.task, scenario=scenario, threads=threads)
        first.reset(seeds=list(seeds))
        self._core = first.fork(self.copies)
        self._start = self._core.snapshot()

    def episodes(self, networks: Sequence[Network]) -> list[list[Metrics]]:
        """The metrics of each sea, for each network."""
        found: list[list[Metrics]] = []
        for first in range(0, len(networks), self.copies):
            found += self._together(networks[first : first + self.copies])
        return found

    def _together(self, networks: Sequence[Network]) -> list[list[Metrics]]:
        core = self._core
        core.restore(self._start)
        ended: dict[int, Metrics] = {}
        running = np.arange(core.n)
        running = running[running % self.copies < len(networks)]
        while running.size:
            observed = self.agent.normaliser(core.last[running])
            actions = np.empty((running.size, 2), dtype=np.float32)
            for k, network in enumerate(networks):  # column i of the batch is copy i % copies of sea i // copies
                mine = running % self.copies == k
                actions[mine] = network(observed[mine])
            result = core.step(np.clip(actions, -1.0, 1.0), running)
            ended |= {column: ending["episode_metrics"] for column, ending in result.endings.items()}
            running = running[~(result.terminated | result.truncated)]
        return [[ended[sea * self.copies + k] for sea in range(self.seas)] for k in range(len(networks))]


def numbers(network: Network) -> Array:
    """The last layer's numbers, in one row."""
    return np.concatenate([network.weights[-1].ravel(), network.biases[-1]]).astype(np.float64)


def with_numbers(network: Network, row: Array) -> Network:
    """The same network with another last layer."""
    shape = network.weights[-1].shape
    weight = row[: shape[0] * shape[1]].reshape(shape).astype(np.float32)
    bias = row[shape[0] * shape[1] :].astype(np.float32)
    return replace(network, weights=(*network.weights[:-1], weight), biases=(*network.biases[:-1], bias))


@dataclass
class Progress:
    """Where an evolution stands; pickled after each generation.

    Attributes:
        key: Of the `Arenas`: what is evolved, in which seas, and how it is judged.
        search: The CMA-ES; all of it but its generator is kept, since its own pickle drops half of the covariance.
        generation, wall_s, lines: Generations that have ended, their time, and a line of the curve each.
    """

    key: str
    search: Any
    generation: int
    wall_s: float
    lines: list[dict[str, float]]

    def __getstate__(self) -> dict[str, Any]:
        kept = {name: value for name, value in vars(self.search).items() if name != "_rng"}
        return {**vars(self), "search": (type(self.search), kept)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        kind, kept = state["search"]
        vars(self).update(state)
        self.search = kind(mean=kept["_mean"], sigma=1.0, population_size=4)
        vars(self.search).update(kept)


@dataclass(frozen=True)
class Outcome:
    """What an evolution has come to.

    Attributes:
        network: The one to keep: the last mean, or the first network where that does better.
        kept: Whether it is the evolved one.
        generations: How many there were.
        before, after: Verdicts on the first network and on the last mean, in the unseen seas.
    """

    network: Network
    kept: bool
    generations: int
    before: Verdict
    after: Verdict

    def record(self) -> dict[str, Any]:
        """For ``agent.json``."""
        return {
            "generations": self.generations,
            "kept": self.kept,
            "before": asdict(self.before),
            "after": asdict(self.after),
        }


def evolve(
    agent: Agent,
    section: Evolution,
    run: Path,
    threads: int,
    stop: threading.Event,
    tell: Callable[[int, Verdict], None] = lambda generation, verdict: None,
) -> Outcome | None:
    """Evolve an agent's last layer, in a run folder from which it goes on after a stop.

    Args:
        agent: As the gradient left it.
        section: How.
        run: Folder of ``evolution.pickle`` and ``evolution.csv``.
        threads: Of the simulation.
        stop: Asks for a stop after the running generation.
        tell: Called after each generation with its number and the verdict on the best candidate.

    Returns:
        What it has come to; None if it was stopped.

    Raises:
        ImportError: CMA-ES is missing; the sentence names the extra.
        ConfigurationError: The scenario is refused, or the file of a stopped evolution cannot be read or was made
            with another policy, other seas or settings, or another version of the package.
    """
    require_evolution()
    arenas = Arenas(agent, section, threads)
    state = _resumed(run / STATE, arenas) if (run / STATE).is_file() else _begun(arenas)
    while state.generation < section.generations:
        if stop.is_set():
            return None
        begun = time.perf_counter()
        state.search.reseed_rng(generation_seed(agent.training.seed, state.generation))  # a pickle holds no generator
        with _one_thread():
            drawn = [state.search.ask() for _ in range(section.population)]
        candidates = [with_numbers(agent.network, row) for row in drawn]
        arena = arenas.of_generation(state.generation)
        verdicts = [arenas.verdict(episodes) for episodes in arena.episodes(candidates)]
        with _one_thread():
            state.search.tell([(row, v.score_kN) for row, v in zip(drawn, verdicts, strict=True)])
        state.generation += 1
        state.wall_s += time.perf_counter() - begun
        best = min(verdicts, key=lambda v: v.score_kN)
        state.lines.append(_line(state, best, verdicts))
        _write(run, state)
        tell(state.generation, best)
    last = with_numbers(agent.network, state.search.mean)
    before, after = (arenas.verdict(e) for e in arenas.unseen().episodes([agent.network, last]))
    kept = after.score_kN < before.score_kN
    return Outcome(last if kept else agent.network, kept, state.generation, before, after)


class Arenas:
    """The seas of an evolution: sets that take turns, and one that no generation meets.

    Args:
        agent: The policy.
        section: How many, and drawn from what.
        threads: Of the simulation.
    """

    def __init__(self, agent: Agent, section: Evolution, threads: int) -> None:
        self.section, self.threads = section, threads
        task, self.scenario = judged_in(section, agent.task, agent.scenario)
        self.agent = replace(agent, task=task)
        most = section.sets * section.episodes
        self.seeds = block(agent.training.seed, EVOLUTION, most + section.unseen)
        self._made: dict[int, Arena] = {}

    def of_generation(self, generation: int) -> Arena:
        """The seas of a generation."""
        turn = (generation // self.section.turn) % self.section.sets
        if turn not in self._made:
            first = turn * self.section.episodes
            seeds = self.seeds[first : first + self.section.episodes]
            self._made[turn] = self._arena(seeds, self.section.population)
        return self._made[turn]

    @property
    def key(self) -> str:
        """Hash of all that decides the result, the package's version too; the number of generations is left out."""
        network, normaliser = self.agent.network, self.agent.normaliser
        weights = b"".join(array.tobytes() for array in network.arrays().values())
        policy = [network.sizes, network.activation, network.squash, asdict(normaliser)]
        how = self.section.model_dump(mode="json", exclude={"generations", "scenario"})
        seas = [self.agent.task.model_dump(mode="json"), self.scenario.model_dump(mode="json"), self.seeds]
        told = json.dumps([ssmash_gym.__version__, policy, how, seas], sort_keys=True)
        return hashlib.sha256(weights + told.encode()).hexdigest()

    def unseen(self) -> Arena:
        """The seas that decide in the end."""
        self._made.clear()
        return self._arena(self.seeds[self.section.sets * self.section.episodes :], 2)

    def verdict(self, episodes: Sequence[Metrics]) -> Verdict:
        """Of episodes, by the configuration's rule."""
        return judged(episodes, self.section.judgement, self.agent.task.limits.probe_ultimate_kN)

    def _arena(self, seeds: Sequence[int], most: int) -> Arena:
        return Arena(self.agent, self.scenario, seeds, self.threads, most)


def judged_in(section: Evolution, task: TaskConfig, scenario: ScenarioConfig) -> tuple[TaskConfig, ScenarioConfig]:
    """Task and scenario in which an evolution judges.

    Args:
        section: Its settings.
        task: The training's.
        scenario: The training's last one.

    Raises:
        ConfigurationError: The scenario or the step is refused.
    """
    if section.substep_s is not None:
        task = validated(TaskConfig, task.model_dump() | {"substep_s": section.substep_s}, "training: evolution")
    return task, scenario if section.scenario is None else load_scenario(section.scenario)


def check_evolution(section: Evolution, task: TaskConfig, scenario: ScenarioConfig) -> None:
    """Refuse an evolution that could not begin, before the gradient takes its time.

    Raises:
        ConfigurationError: Its scenario or step is refused.
        ImportError: CMA-ES is missing; the sentence names the extra.
    """
    require_evolution()
    try:
        judging, seas = judged_in(section, task, scenario)
        TraverseBatch(1, task=judging, scenario=seas)
    except ConfigurationError as error:
        raise ConfigurationError(f"training: evolution is refused: {error}") from None


def require_evolution() -> None:
    """Check that CMA-ES is there.

    Raises:
        ImportError: It is missing; the sentence names the extra.
    """
    for library in ("cmaes", "threadpoolctl"):
        require(library, f'evolution needs {library}, which is not installed: pip install "ssmash_gym[train]".')


def _one_thread() -> AbstractContextManager[Any]:
    """Linear algebra on one thread: the last bits of an eigenvalue depend on how many share the work."""
    from threadpoolctl import threadpool_limits

    return cast("AbstractContextManager[Any]", threadpool_limits(1, user_api="blas"))


def _begun(arenas: Arenas) -> Progress:
    from cmaes import CMA

    agent, section = arenas.agent, arenas.section
    search = CMA(
        mean=numbers(agent.network), sigma=section.spread, population_size=section.population,
        seed=network_seed(agent.training.seed),
    )  # fmt: skip
    return Progress(arenas.key, search, 0, 0.0, [])


def _resumed(path: Path, arenas: Arenas) -> Progress:
    try:
        state = pickle.loads(path.read_bytes())
    except Exception as error:  # a pickle can fail in any way
        raise ConfigurationError(f"{path}: the evolution's state cannot be read ({error}).") from None
    if not isinstance(state, Progress) or state.key != arenas.key:
        raise ConfigurationError(
            f"{path}: this evolution is of another policy, of other seas or settings, or of another version of "
            "ssmash_gym; remove the file to begin anew."
        )
    return state


def _line(state: Progress, best: Verdict, verdicts: Sequence[Verdict]) -> dict[str, float]:
    median = float(np.median([v.score_kN for v in verdicts]))
    values = (state.generation, best.score_kN, median, best.peak_mean_kN, best.peak_p95_kN, best.success, best.time_s)
    return dict(zip(COLUMNS, (*values, state.wall_s), strict=True))


def _write(run: Path, state: Progress) -> None:
    """The state and the curve; a stop between the two costs no more than a line of the curve."""
    with whole_file(run / STATE) as path:
        path.write_bytes(pickle.dumps(state))
    with whole_file(run / CURVE) as path, path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows({key: f"{value:.6g}" for key, value in line.items()} for line in state.lines)
