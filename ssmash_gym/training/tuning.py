"""A search for good settings with Optuna: many short trainings, bad ones given up early, the best written as YAML.

The run folder holds the plan (``search.yaml``), the trials' database (``study.db``), a table (``trials.csv``), a folder
for each training (``trials/0000``) and the best settings (``best.yaml``), ready for ``train.py --config``.
"""

from __future__ import annotations

import csv
import shutil
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console

from ssmash_gym.document import write_yaml
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.files import whole_file, write_text
from ssmash_gym.training.agent import load_agent
from ssmash_gym.training.config import TrainingConfig
from ssmash_gym.training.seeds import TUNING, block, network_seed
from ssmash_gym.training.tuning_config import Objective, Range, SearchConfig, load_search

__all__ = ["SEARCH", "load_search", "search"]

SEARCH: Final = "search.yaml"
STUDY: Final = "study.db"
BEST: Final = "best.yaml"
TABLE: Final = "trials.csv"


class Stopped(Exception):
    """Ctrl-C: the running trial is left out and will be tried again."""


def search(plan: SearchConfig, run: Path, console: Console, stop: threading.Event | None = None) -> bool:
    """Search in a run folder, from the start or from where it was stopped, until the end or until Ctrl-C.

    Each trial draws from a random stream of its own, so a search that was stopped proposes what it would have proposed.

    Args:
        plan: The search.
        run: Its folder.
        console: Where progress is shown.
        stop: Asks for a stop when it is set, as Ctrl-C does.

    Returns:
        Whether all trials are done.

    Raises:
        ImportError: Optuna is missing; the sentence names the extra.
        ConfigurationError: A training cannot begin, e.g. for want of a GPU; the same trial is tried again on a resume.
    """
    require("optuna", 'the search needs optuna, which is not installed: pip install "ssmash_gym[tune]".')
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    write_text(run / SEARCH, write_yaml(plan.model_dump(mode="json")))
    study = optuna.create_study(
        storage=f"sqlite:///{(run / STUDY).as_posix()}",
        study_name=plan.name,
        pruner=optuna.pruners.MedianPruner(n_startup_trials=plan.pruning_after, n_warmup_steps=0),
        load_if_exists=True,
    )
    _requeue(study)
    stop = stop or threading.Event()
    console.print(f"search in {run}: {_done(study)} of {plan.trials} trials are done")
    try:
        while _done(study) < plan.trials:
            _one(study, plan, run, console, stop)
            report(study, plan, run)
    except Stopped:
        console.print(f"stopped after {_done(study)} of {plan.trials} trials; go on with: train.py --resume {run}")
        return False
    told = f"{study.best_value:.2f} kN: {run / BEST}" if (run / BEST).is_file() else "none: every trial failed"
    console.print(f"best of {plan.trials} trials: {told}")
    return True


def _one(study: Any, plan: SearchConfig, run: Path, console: Console, stop: threading.Event) -> None:
    """One trial, from the draw of its settings to its score."""
    import optuna

    study.sampler = optuna.samplers.TPESampler(
        n_startup_trials=plan.random_trials, seed=network_seed(plan.seed * 100_003 + _done(study))
    )
    trial = study.ask({key: distribution(entry) for key, entry in plan.space.items()})
    number = trial.number  # not the count of trials: one that is tried again was numbered when it was queued
    try:
        settings = plan.settings(trial.params)
    except ConfigurationError as mistake:  # a combination that is not allowed counts as a trial given up
        study.tell(trial, state=optuna.trial.TrialState.PRUNED)
        console.print(f"trial {number}: {mistake}")
        return
    folder = run / "trials" / f"{number:04d}"
    shutil.rmtree(folder, ignore_errors=True)
    try:
        score = _judged(trial, plan, settings, folder, stop)
    except optuna.TrialPruned:
        study.tell(trial, state=optuna.trial.TrialState.PRUNED)
        console.print(f"trial {number}: given up")
        return
    except (Stopped, KeyboardInterrupt):
        study.tell(trial, state=optuna.trial.TrialState.FAIL)
        study.enqueue_trial(trial.params)
        raise Stopped from None
    study.tell(trial, score)
    console.print(f"trial {number}: {score:.2f} kN")


def _judged(trial: Any, plan: SearchConfig, settings: TrainingConfig, folder: Path, stop: threading.Event) -> float:
    """Train with a trial's settings and score the agent.

    Raises:
        optuna.TrialPruned: The curve was worse than the others'.
        Stopped: Ctrl-C.
    """
    import optuna

    from ssmash_gym.training.run import learn

    halt = _Halt(stop)
    watch = Watch(trial, plan, settings.total_steps, halt)
    finished = learn(settings, folder, Console(quiet=True), stop=halt, watch=watch)
    shutil.rmtree(folder / "checkpoints", ignore_errors=True)
    if not finished:
        if watch.pruned:
            raise optuna.TrialPruned
        stop.set()
        raise Stopped
    return score(folder / "agent", plan.objective)


class _Halt(threading.Event):
    """The stop of one training: asked for by its pruning, or by the whole search's stop."""

    def __init__(self, outer: threading.Event) -> None:
        super().__init__()
        self._outer = outer

    def is_set(self) -> bool:
        return super().is_set() or self._outer.is_set()


class Watch:
    """Tells a trial's curve to the study, and halts a training that is worse than the others were.

    The value is the objective as the training's own episodes show it (with exploration, in the training's seas).

    Args:
        trial: The trial.
        plan: The search.
        total: Steps of the training.
        halt: Stops it.

    Attributes:
        pruned: Whether it was halted.
    """

    def __init__(self, trial: Any, plan: SearchConfig, total: int, halt: threading.Event) -> None:
        self._trial, self._plan, self._total, self._halt = trial, plan, total, halt
        self._lines: list[dict[str, float]] = []
        self._told = 0
        self.pruned = False

    def __call__(self, line: dict[str, float]) -> None:
        """Take a line of the curve."""
        if line["episodes"]:
            self._lines.append(line)
        part = int(self._plan.reports * line["steps"] / self._total)
        if part <= self._told or part >= self._plan.reports or not self._lines:
            return
        self._told = part
        peak, success = (
            float(np.average([one[key] for one in self._lines], weights=[one["episodes"] for one in self._lines]))
            for key in ("peak_probe_kN_p95", "success_rate")
        )
        self._lines = []
        self._trial.report(penalised(peak, success, self._plan.objective), part)
        if self._trial.should_prune():
            self.pruned = True
            self._halt.set()


def score(folder: Path, objective: Objective) -> float:
    """The objective of a trained agent [kN]."""
    from ssmash_gym.evaluation.episodes import run_episodes

    agent = load_agent(folder)
    seeds = block(objective.seed, TUNING, objective.episodes)
    found = run_episodes(agent, load_scenario(objective.scenario), seeds)
    peak = float(np.percentile(found["scored_peak_kN"].to_numpy(), 95.0))
    return penalised(peak, float(found["success"].to_numpy().mean()), objective)


def penalised(peak_kN: float, success: float, objective: Objective) -> float:
    """A 95th percentile of peak loads with the penalty for missing successes [kN]."""
    return peak_kN + objective.penalty_kN * max(0.0, objective.success - success)


def distribution(entry: Range) -> Any:
    """A range as Optuna takes it."""
    import optuna

    if entry.choices:
        return optuna.distributions.CategoricalDistribution(entry.choices)
    assert entry.low is not None and entry.high is not None
    if entry.whole:
        return optuna.distributions.IntDistribution(int(entry.low), int(entry.high), log=entry.log)
    return optuna.distributions.FloatDistribution(entry.low, entry.high, log=entry.log)


def _requeue(study: Any) -> None:
    """Trials that were running when the process died are tried again, with the same values."""
    import optuna

    for trial in study.get_trials(states=[optuna.trial.TrialState.RUNNING]):
        study.tell(trial.number, state=optuna.trial.TrialState.FAIL)
        study.enqueue_trial(trial.params)


def _done(study: Any) -> int:
    """Trials that were judged or given up."""
    import optuna

    states = [optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.PRUNED]
    return len(study.get_trials(deepcopy=False, states=states))


def report(study: Any, plan: SearchConfig, run: Path) -> None:
    """Write the table of trials and the best settings so far."""
    import optuna

    trials = study.get_trials(deepcopy=False)
    with whole_file(run / TABLE) as path, path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["trial", "state", "objective_kN", "reports", *plan.space])
        for trial in trials:
            value = "" if trial.value is None else f"{trial.value:.6g}"
            told = len(trial.intermediate_values)
            writer.writerow([trial.number, trial.state.name, value, told, *map(trial.params.get, plan.space)])
    if any(trial.state == optuna.trial.TrialState.COMPLETE for trial in trials):
        best: Mapping[str, Any] = plan.document(study.best_params)
        head = f"# Trial {study.best_trial.number} of {plan.name}: {study.best_value:.4g} kN\n"
        write_text(run / BEST, head + write_yaml(dict(best)))
