"""`ssmash clone`: behaviour cloning, an agent that learns from recorded trials what their driver did.

An example of imitation learning on the trials that `ssmash trial` and `ssmash console` record; what comes out is an
agent's folder like that of a training run (``agent/``), and says by itself how well it imitates (``imitation.json``).
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import tyro
from rich.console import Console

from ssmash_gym.envs.observations import chosen_terms, observed_terms
from ssmash_gym.envs.task import History, TaskConfig
from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.policies import Policy, baselines, make_baseline
from ssmash_gym.evaluation.summary import policy_summary
from ssmash_gym.files import write_text
from ssmash_gym.progress import progress_bar
from ssmash_gym.training.agent import Agent, load_agent, write_agent
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.run import new_folder, versions
from ssmash_gym.training.seeds import EVALUATION, block
from ssmash_gym.trials.demonstrations import SENSORS, Demonstration, demonstrations, perceived
from ssmash_gym.trials.export import read_dataset, task_of
from ssmash_gym.trials.imitation import Fit, Settings, fit, split
from ssmash_gym.trials.scripted import OPERATOR, SCRIPTED_OPERATOR
from ssmash_gym.trials.verbs import listed_paths

REPORT: Final = "imitation.json"
# The teacher's own last command and what follows from it at once. A clone that sees them learns to repeat the command:
# it errs less on recorded episodes than any other, and then never starts, because nothing was commanded before.
OWN_COMMANDS: Final = ("last_command_x", "last_command_y", "claw_vx", "claw_vy")
BESIDE: Final = ("goal_held", "episode_peak", "time_left")  # tell how far an episode has come, not what to do
REMEMBERED: Final = ("to_go", "claw_y", "yaw")  # an operator acts on what was seen some tenths of a second before
READINGS: Final = 5
Files = Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="[FILE|FOLDER ...]")]


@dataclass(frozen=True)
class Lessons:
    """What a clone learns from.

    Attributes:
        made: The episodes.
        condition: What was simulated.
        task: As the clone observes it.
    """

    made: list[Demonstration]
    condition: Condition
    task: TaskConfig


def clone(
    files: Files = (),
    /,
    trials: Path | None = None,
    from_minari: str | None = None,
    folder: Path | None = None,
    out: Path | None = None,
    name: str = "clone",
    commands: bool = False,
    epochs: int = 60,
    seed: int = 0,
    episodes: int = 50,
    threads: int | None = None,
) -> None:
    """Train an agent on recorded trials by supervised learning, and say how well it imitates.

    Writes ``agent/`` (for --agent of the other verbs), ``curve.csv`` and ``imitation.json`` to --out.

    Args:
        files: Files of trials, or folders of them; those that were broken off are left out.
        trials: The same, one folder.
        from_minari: Learn from this Minari dataset instead (extra ``data``).
        folder: That holds all Minari datasets; Minari's own by default.
        out: Folder to make; ``runs/NAME-NUMBER`` by default.
        name: Of the agent.
        commands: Let the clone see its own last command too; see docs/guide/imitation.md for what comes of it.
        epochs: Passes over the samples, at most.
        seed: Of first weights, order, and choice of the seeds that are held back for validation.
        episodes: Unseen seas in which clone and teacher are compared; 0 leaves the comparison out.
        threads: Threads of the simulation; the results do not depend on them.

    Raises:
        ConfigurationError: A name, a file or a number is refused, or a trial does not replay; nothing is written.
        ImportError: A library is missing; the sentence names the extra.
    """
    require("torch", 'cloning needs PyTorch: pip install "ssmash_gym[train]".')
    paths = [*files, *([trials] if trials is not None else [])]
    if bool(paths) == (from_minari is not None):
        raise ConfigurationError("name recorded trials to learn from, or a dataset with --from-minari.")
    if epochs < 1 or seed < 0 or episodes < 0 or (threads is not None and threads < 1):
        raise ConfigurationError("--epochs and --threads must be at least 1, --seed and --episodes not negative.")
    run = new_folder(out, name)
    left_out = () if commands else (*OWN_COMMANDS, *BESIDE)
    lessons = of_trials(paths, left_out) if from_minari is None else of_dataset(from_minari, folder, left_out)
    settings = Settings(epochs=epochs, seed=seed)
    report = cloned(lessons, settings, run, name, episodes, threads)
    console = Console()
    for sentence in sentences(report):
        console.print(sentence, markup=False, soft_wrap=True)
    console.print(f"agent in {run / 'agent'}, figures in {run / REPORT}", markup=False, soft_wrap=True)


def of_trials(paths: Sequence[Path], left_out: Sequence[str]) -> Lessons:
    """Recorded trials as lessons: the sensors with some past readings, the complete trials only.

    Args:
        paths: Files, or folders of them.
        left_out: Terms of the sensors that the clone does not see.

    Raises:
        ConfigurationError: A file cannot be read, does not replay, or several configurations are mixed.
    """
    terms = [term.name for term in chosen_terms(SENSORS) if term.name not in left_out]

    def seen(task: TaskConfig) -> TaskConfig:
        return perceived(task, terms, History(terms=REMEMBERED, samples=READINGS, every_s=task.control_interval_s))

    condition, task, made = demonstrations(listed_paths(paths), seen)
    return Lessons(made, condition, task)


def of_dataset(name: str, folder: Path | None, left_out: Sequence[str]) -> Lessons:
    """A Minari dataset as lessons; it holds single observations, so the clone remembers nothing.

    Args:
        name: Of it.
        folder: That holds all datasets; None: Minari's own.
        left_out: Terms that the clone does not see.

    Raises:
        ConfigurationError: There is no such dataset, or it is of another environment.
        ImportError: The extra ``data`` is missing.
    """
    dataset = read_dataset(name, folder)
    seen, condition = task_of(dataset)
    names = [term.name for term in observed_terms(seen)]
    places = [k for k, term in enumerate(names) if term not in left_out]
    task = perceived(seen, [names[k] for k in places])
    told = list(dataset.storage.get_episode_metadata(range(dataset.total_episodes)))
    made = []
    for episode, about in zip(dataset.iterate_episodes(), told, strict=True):
        observations = np.ascontiguousarray(np.asarray(episode.observations)[:, places])
        made.append(Demonstration(
            observations, np.asarray(episode.actions, dtype=np.float64), np.asarray(episode.rewards),
            bool(episode.terminations[-1]), bool(episode.truncations[-1]), int(about["seed"]), str(about["author"]), {},
        ))  # fmt: skip
    return Lessons(made, condition, task)


def cloned(
    lessons: Lessons, settings: Settings, run: Path, name: str, episodes: int, threads: int | None = None
) -> dict[str, Any]:
    """Train, write the agent, compare it with its teacher, and write the report.

    Args:
        lessons: What it learns from.
        settings: Of the training.
        run: Folder to write.
        name: Of the agent.
        episodes: Unseen seas to compare in.
        threads: Of the simulation.

    Returns:
        The contents of ``imitation.json``.

    Raises:
        ConfigurationError: The name is refused, or all episodes are of one seed.
    """
    training, validation = split(lessons.made, settings)
    teachers = sorted({one.author for one in lessons.made})
    taught = sum(len(one.actions) for one in training)
    config = configuration(name, teachers, settings, lessons, taught)
    with progress_bar("cloning") as advance:
        found = fit(training, validation, settings, lambda share: advance(share, "cloning"))
    lesson = {
        "teachers": teachers,
        "episodes": {"training": len(training), "validation": len(validation)},
        "steps": {"training": taught, "validation": sum(len(one.actions) for one in validation)},
        "validation_seeds": sorted({one.seed for one in validation}),
        "settings": asdict(settings),
    }
    about = {
        "steps": taught,
        "versions": versions(),
        "seed": settings.seed,
        "cloned_from": {"teachers": teachers, "seeds": sorted({one.seed for one in lessons.made})},
    }
    write_agent(run / "agent", found.network, found.normaliser, config, lessons.task, lessons.condition.scenario, about)
    write_curve(run / "curve.csv", found)
    report = {
        **lesson,
        "best_epoch": found.best_epoch,
        "validation_error": found.errors,
        "configuration": lessons.condition.configuration,
        "unseen": compared(load_agent(run / "agent"), lessons, teachers, episodes, threads),
    }
    write_text(run / REPORT, json.dumps(report, indent=1) + "\n")
    return report


def configuration(
    name: str, teachers: Sequence[str], settings: Settings, lessons: Lessons, steps: int
) -> TrainingConfig:
    """The resolved configuration of a cloning, as an agent's folder holds it.

    Raises:
        ConfigurationError: The name is refused.
    """
    return load_training(
        {
            "name": name,
            "description": f"Behaviour cloning from recorded episodes of {', '.join(teachers)}.",
            "seed": settings.seed,
            "total_steps": steps,
            "algorithm": "cloning",
            "network": {"layers": list(settings.layers), "activation": "tanh"},
            "environment": {
                "task": lessons.task.model_dump(mode="json"),
                "scenario": lessons.condition.scenario.model_dump(mode="json"),
            },
        }
    )


def write_curve(path: Path, found: Fit) -> None:
    """Write the errors after each pass as CSV, in variances of the commands."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(found.curve[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(found.curve)
    write_text(path, text.getvalue())


def compared(
    agent: Agent, lessons: Lessons, teachers: Sequence[str], episodes: int, threads: int | None
) -> dict[str, Any]:
    """Figures of clone and teacher in seas that the clone has not learned from; only scripted teachers can be asked.

    Args:
        agent: The clone.
        lessons: What it has learned from.
        teachers: Who drove.
        episodes: How many seas; none: no figures.
        threads: Of the simulation.
    """
    if not episodes:
        return {}
    known = {one.seed for one in lessons.made}
    seeds = [seed for seed in block(0, EVALUATION, episodes + len(known)) if seed not in known][:episodes]
    condition = lessons.condition
    drivers: dict[str, Policy] = {agent.name: agent}
    for teacher in teachers:
        policy = OPERATOR if teacher == SCRIPTED_OPERATOR else teacher.rpartition(" ")[2]
        if policy in baselines() and not teacher.startswith("participant"):
            drivers[teacher] = make_baseline(policy, condition.task.model_copy(update={"observation": SENSORS}))
    figures = {}
    with progress_bar("episodes") as advance:
        for k, (name, driver) in enumerate(drivers.items()):
            advance(k / len(drivers), f"{name} in unseen seas")
            rows = run_episodes(driver, condition.scenario, seeds, helicopter=condition.helicopter, threads=threads)
            figures[name] = policy_summary(rows)
    return {"episodes": episodes, "seeds": seeds, "drivers": figures}


def sentences(report: dict[str, Any]) -> list[str]:
    """What the report says."""
    errors, counts = report["validation_error"], report["episodes"]
    explained = " and ".join(
        f"{100.0 * one['explained']:.0f} % {axis}" if one["explained"] is not None else f"nothing to explain {axis}"
        for axis, one in errors.items()
    )
    told = [
        f"Learned from {counts['training']} episodes of {', '.join(report['teachers'])}; in {counts['validation']} "
        f"others it explains {explained} of the commands' variance."
    ]
    for name, one in report["unseen"].get("drivers", {}).items():
        peak = one["peak_probe_kN"]
        told.append(
            f"{name} in {one['episodes']} unseen seas: success {100.0 * one['success_rate']:.0f} %, peak load "
            f"{peak['mean']:.1f} kN in the mean, {peak['p95']:.1f} kN at the 95th percentile, median time "
            f"{one['time_s']['median']:.1f} s."
        )
    return told
