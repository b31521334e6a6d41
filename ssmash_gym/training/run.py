"""A training run: one folder from which it can be understood, resumed and used."""

from __future__ import annotations

import json
import platform
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any, Final

import tyro
from rich.console import Console

import ssmash_gym
from ssmash_gym.document import write_yaml
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.training.agent import Agent, fingerprint, load_agent, save_agent
from ssmash_gym.training.algorithms import make_environment, make_model, require_training
from ssmash_gym.training.checkpoint import checkpoints, layers, load_checkpoint, prune, save_checkpoint
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.evolution import Outcome, Verdict, check_evolution, evolve
from ssmash_gym.training.network import take_last_layer
from ssmash_gym.training.sections import Evolution

DEFAULT: Final = "ppo_traverse"
STOPPED: Final = 130  # what a shell expects of a program that Ctrl-C has ended
LIBRARIES: Final = ("numpy", "numba", "gymnasium", "stable-baselines3", "sb3-contrib", "torch")


def train(
    config: Path | None = None,
    resume: Path | None = None,
    changes: Annotated[tuple[str, ...], tyro.conf.arg(name="set")] = (),
    out: Path | None = None,
    tune: Path | None = None,
) -> None:
    """Train an agent, go on with a run that was stopped, or search for good settings.

    Args:
        config: YAML file of the training, or a name in configs/training; ppo_traverse by default.
        resume: Run folder to go on with, from its newest checkpoint; or the folder of a search.
        changes: Keys to change, e.g. ``--set ppo.epochs=4 seed=1``.
        out: Run folder to make; ``runs/NAME-NUMBER`` by default.
        tune: YAML file of a search, or a name in configs/training: many short trainings, the best settings are kept.

    Raises:
        ConfigurationError: A mistake in the configuration; nothing has been written.
        ImportError: A library is missing; the sentence names the extra.
        SystemExit: It was stopped by Ctrl-C, with what a shell expects of that.
    """
    from ssmash_gym.training.tuning import load_search, search

    require_training()
    console = Console()
    if resume is not None:
        if config is not None or tune is not None or changes or out is not None:
            raise ConfigurationError(
                "--resume goes on with a run as it was: leave out --config, --tune, --set and --out."
            )
        reached = go_on(resume.resolve(), console)
    elif tune is not None:
        if config is not None:
            raise ConfigurationError("--tune FILE names the training it starts from itself: leave out --config.")
        plan = load_search(str(tune), changes)
        reached = search(plan, new_folder(out, plan.name), console)
    else:
        settings = load_training(named(config), changes)
        refuse_cloning(settings)
        require_training(settings.algorithm)
        reached = learn(settings, new_folder(out, settings.name), console)
    if not reached:
        raise SystemExit(STOPPED)


def refuse_cloning(settings: TrainingConfig) -> None:
    """Refuse a training that needs recorded trials.

    Raises:
        ConfigurationError: It is one.
    """
    if settings.algorithm == "cloning":
        raise ConfigurationError("algorithm = 'cloning' is refused here: `ssmash clone` learns from recorded trials.")


def go_on(run: Path, console: Console) -> bool:
    """Go on with a run or a search that was stopped; returns whether its end was reached.

    Raises:
        ConfigurationError: The folder holds neither.
    """
    from ssmash_gym.training.tuning import SEARCH, load_search, search

    if (run / SEARCH).is_file():
        return search(load_search(run / SEARCH), run, console)
    return learn(load_training(run_file(run, "training.yaml")), run, console, resumed=True)


def new_folder(out: Path | None, name: str) -> Path:
    """The run folder that is asked for, or the next free one.

    Raises:
        ConfigurationError: It is not empty.
    """
    run = out.resolve() if out is not None else free_folder(Path("runs"), name)
    if run.exists() and any(run.iterdir()):
        raise ConfigurationError(f"--out {out} is refused: the folder is not empty; name a new one, or use --resume.")
    return run


def learn(
    settings: TrainingConfig,
    run: Path,
    console: Console,
    *,
    resumed: bool = False,
    stop: threading.Event | None = None,
    watch: Callable[[dict[str, float]], None] = lambda line: None,
) -> bool:
    """Train in a run folder until the end or until Ctrl-C.

    Args:
        settings: The configuration.
        run: The run folder.
        console: Where progress is shown.
        resumed: Go on from the newest checkpoint.
        stop: Asks for a stop after the running update when it is set, as Ctrl-C does.
        watch: Called with each line of the curve.

    Returns:
        Whether the training reached its end.
    """
    environment = make_environment(settings)
    core = layers(environment)[0].core
    check_stages(settings, core)  # a mistake is told before the start
    if settings.evolution is not None:
        check_evolution(settings.evolution, core.task, settings.scenario_at(settings.total_steps, core.scenario))
    model = make_model(settings, environment)
    kept = settings.checkpoints.replay_buffer
    logged = load_checkpoint(newest(run), model, transitions=kept) if resumed else {}
    about = describe(settings, core)
    write_run(run, settings, core, about)
    point_to(run)

    def save() -> None:
        folder = run / "checkpoints" / f"step_{model.num_timesteps:010d}"
        save_checkpoint(folder, model, settings, about | {"steps": model.num_timesteps})
        prune(run, settings.checkpoints.keep)

    console.print(f"run folder {shown(run)}; networks on {model.device.type} (device: {settings.device})")
    remaining = max(settings.total_steps - model.num_timesteps, 0)
    course = Course(settings, run, console, stop or threading.Event(), watch, save, resumed)
    reached = remaining == 0 or follow(course, model, remaining, logged)
    if reached:
        if remaining:
            save()
        reached = finish(course, model, about | {"steps": model.num_timesteps})
    else:
        console.print(f"stopped after checkpoint {newest(run).name}; go on with: train.py --resume {shown(run)}")
    environment.close()
    return reached


def finish(course: Course, model: Any, about: dict[str, Any]) -> bool:
    """Write the agent, its last layer evolved where that is asked for; returns whether the end was reached.

    The newest checkpoint is the agent as the gradient left it, with the task and the scenario of the last stage.
    """
    settings, run, console = course.settings, course.run, course.console
    left = load_agent(newest(run))
    if settings.evolution is not None:
        outcome = evolved(course, settings.evolution, left)
        if outcome is None:
            console.print(f"stopped after a generation; go on with: train.py --resume {shown(run)}")
            return False
        take_last_layer(model.policy, outcome.network)
        about = about | {"evolution": outcome.record()}
        console.print(told_of(outcome), soft_wrap=True)
    save_agent(run / "agent", model, model.env, settings, left.task, left.scenario, about)
    console.print(f"trained for {model.num_timesteps:,} steps: {shown(run / 'agent')}")
    return True


def evolved(course: Course, section: Evolution, left: Agent) -> Outcome | None:
    """Evolve the agent that the gradient left, and tell how it goes; None if it was stopped."""
    from ssmash_gym.training.callbacks import stop_on_interrupt

    def tell(generation: int, best: Verdict) -> None:
        if generation % 5 == 0 or generation == section.generations:
            told = f"best of them: score {best.score_kN:.2f} kN, peak probe load {best.peak_mean_kN:.1f} kN"
            course.console.print(f"generation {generation:>4} of {section.generations}, {told}", soft_wrap=True)

    with stop_on_interrupt(course.stop, course.console, "generation"):
        return evolve(left, section, course.run, course.settings.environment.threads, course.stop, tell)


def told_of(outcome: Outcome) -> str:
    """An evolution's outcome in a sentence."""
    before, after = outcome.before, outcome.after
    scores = f"{before.score_kN:.2f} before, {after.score_kN:.2f} kN after, in seas that no generation has met"
    return f"evolution: score {scores}: {'kept' if outcome.kept else 'not kept, it is not better'}"


@dataclass(frozen=True)
class Course:
    """What goes with a training; `resumed` says whether it goes on from a checkpoint."""

    settings: TrainingConfig
    run: Path
    console: Console
    stop: threading.Event
    watch: Callable[[dict[str, float]], None]
    save: Callable[[], None]
    resumed: bool


def follow(course: Course, model: Any, remaining: int, logged: Mapping[str, float]) -> bool:
    """Let the model learn for the remaining steps; returns whether it reached the end."""
    from stable_baselines3.common.callbacks import CallbackList
    from stable_baselines3.common.logger import configure

    from ssmash_gym.training.callbacks import Bar, Curve, Keeper, Stages, stop_on_interrupt
    from ssmash_gym.training.costs import Multipliers

    settings = course.settings
    every = settings.steps_per_update
    staggered, priced = layers(model.env)
    bar = Bar(settings.total_steps, course.console)

    def show(line: dict[str, float]) -> None:
        bar(line)
        course.watch(line)

    keeper = Keeper(settings.checkpoints.every_steps, course.save, course.stop, every)
    curve = Curve(course.run / "curve.csv", show, every, priced)
    priced_anew = [] if priced is None else [Multipliers(priced, every)]
    callback = CallbackList([keeper, Stages(staggered.core, settings), curve, *priced_anew])
    model.set_logger(configure(str(course.run / "tensorboard"), ["tensorboard"]))
    for key, value in logged.items():
        model.logger.record(key, value)
    interval = 1 if settings.algorithm == "ppo" else None  # the curve writes the log of SAC and TQC
    with stop_on_interrupt(course.stop, course.console), bar.progress:
        model.learn(remaining, callback=callback, log_interval=interval, reset_num_timesteps=not course.resumed)
    return not keeper.left


def check_stages(settings: TrainingConfig, core: Any) -> None:
    """Refuse stages that could not be entered.

    Raises:
        ConfigurationError: A stage names an unknown key, a value that is not allowed, or delays and noise that the
            batch is not made for.
    """
    scenarios = []
    for stage in settings.stages:
        settings.reward_at(stage.from_step, core.task.reward)
        scenarios.append(settings.scenario_at(stage.from_step, core.scenario))
    if any(scenario != core.scenario for scenario in scenarios):
        trial = TraverseBatch(1, task=core.task, scenario=core.scenario)
        for scenario in scenarios:
            trial.change(scenario=scenario)


def describe(settings: TrainingConfig, core: Any) -> dict[str, Any]:
    """Where the run comes from: versions, seed, fingerprint of the resolved configuration."""
    return {
        "versions": versions(),
        "seed": settings.seed,
        "configuration": fingerprint(settings, core.task, core.scenario),
    }


def versions() -> dict[str, str]:
    """Versions of the package, of Python and of the libraries."""
    return {"ssmash_gym": ssmash_gym.__version__, "python": platform.python_version(), **library_versions()}


def library_versions() -> dict[str, str]:
    """Versions of the libraries that a result depends on."""
    found = {}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "-"
    return found


def write_run(run: Path, settings: TrainingConfig, core: Any, about: dict[str, Any]) -> None:
    """Write the resolved configuration into the run folder."""
    for name, section in (("training", settings), ("task", core.task), ("scenario", core.scenario)):
        write_text(run / f"{name}.yaml", write_yaml(section.model_dump(mode="json")))
    write_text(run / "run.json", json.dumps(about, indent=1) + "\n")


def named(config: Path | None) -> str:
    """The configuration as `load_training` takes it: the default one, a name, or a path."""
    return DEFAULT if config is None else str(config)


def run_file(run: Path, name: str) -> Path:
    """A file of a run folder.

    Raises:
        ConfigurationError: It is missing: the folder is no run.
    """
    if not (run / name).is_file():
        raise ConfigurationError(f"{run}: this is no run folder ({name} is missing).")
    return run / name


def newest(run: Path) -> Path:
    """The newest checkpoint of a run.

    Raises:
        ConfigurationError: There is none.
    """
    found = checkpoints(run)
    if not found:
        raise ConfigurationError(
            f"{run}: there is no checkpoint to go on from: give the folder of a run that has made one, not an agent's."
        )
    return found[-1]


def free_folder(root: Path, name: str) -> Path:
    """The next free run folder, ``root/name-1`` and so on."""
    number = 1
    while (root / f"{name}-{number}").exists():
        number += 1
    return (root / f"{name}-{number}").resolve()


def point_to(run: Path) -> None:
    """Let ``latest`` beside the run lead to it: a link, or a text file where links are not allowed."""
    latest = run.parent / "latest"
    try:
        if latest.is_symlink() or latest.is_file():
            latest.unlink()
        if not latest.exists():
            latest.symlink_to(run.name, target_is_directory=True)
    except OSError:
        write_text(latest, run.name + "\n")


def shown(path: Path) -> Path:
    """A path as a person would write it: relative where it lies below the working folder."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path
