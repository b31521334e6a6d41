"""A training run: one folder from which it can be understood, resumed and used."""

from __future__ import annotations

import json
import platform
import threading
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any, Final

import tyro
from rich.console import Console

import ssmash_gym
from ssmash_gym.document import write_yaml
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.training.agent import fingerprint, save_agent
from ssmash_gym.training.checkpoint import checkpoints, load_checkpoint, prune, save_checkpoint
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.ppo import make_environment, make_model, require_training

DEFAULT: Final = "ppo_traverse"
LIBRARIES: Final = ("numpy", "numba", "gymnasium", "stable-baselines3", "torch")


def train(
    config: Path | None = None,
    resume: Path | None = None,
    changes: Annotated[tuple[str, ...], tyro.conf.arg(name="set")] = (),
    out: Path | None = None,
) -> None:
    """Train an agent, or go on with a run that was stopped.

    Args:
        config: YAML file of the training, or a name in configs/training.
        resume: Run folder to go on with, from its newest checkpoint.
        changes: Keys to change, e.g. ``--set ppo.epochs=4 seed=1``.
        out: Run folder to make; ``runs/NAME-NUMBER`` by default.

    Raises:
        ConfigurationError: A mistake in the configuration; nothing has been written.
        ImportError: A library is missing; the sentence names the extra.
    """
    require_training()
    console = Console()
    if resume is not None:
        if config is not None or changes or out is not None:
            raise ConfigurationError("--resume goes on with a run as it was: leave out --config, --set and --out.")
        run = resume.resolve()
        learn(load_training(run_file(run, "training.yaml")), run, console, resumed=True)
        return
    settings = load_training(named(config), changes)
    run = out.resolve() if out is not None else free_folder(Path("runs"), settings.name)
    if run.exists() and any(run.iterdir()):
        raise ConfigurationError(f"--out {out} is refused: the folder is not empty; name a new one, or use --resume.")
    learn(settings, run, console)


def learn(
    settings: TrainingConfig,
    run: Path,
    console: Console,
    *,
    resumed: bool = False,
    stop: threading.Event | None = None,
) -> bool:
    """Train in a run folder until the end or until Ctrl-C.

    Args:
        settings: The configuration.
        run: The run folder.
        console: Where progress is shown.
        resumed: Go on from the newest checkpoint.
        stop: Asks for a stop after the running update when it is set, as Ctrl-C does.

    Returns:
        Whether the training reached its end.
    """
    from stable_baselines3.common.callbacks import CallbackList
    from stable_baselines3.common.logger import configure

    from ssmash_gym.training.callbacks import Bar, Curve, Keeper, Stages, stop_on_interrupt

    environment = make_environment(settings)
    settings.reward_at(settings.total_steps, environment.venv.core.task.reward)  # a mistake is told before the start
    model = make_model(settings, environment)
    logged = load_checkpoint(newest(run), model) if resumed else {}
    core = environment.venv.core
    about = describe(settings, core)
    write_run(run, settings, core, about)
    point_to(run)

    def save() -> None:
        folder = run / "checkpoints" / f"step_{model.num_timesteps:010d}"
        save_checkpoint(folder, model, settings, about | {"steps": model.num_timesteps})
        prune(run, settings.checkpoints.keep)

    stop = stop or threading.Event()
    bar = Bar(settings.total_steps, console)
    callback = CallbackList(
        [
            Keeper(settings.checkpoints.every_steps, save, stop),
            Stages(core, settings.reward_at),
            Curve(run / "curve.csv", bar),
        ]
    )
    model.set_logger(configure(str(run / "tensorboard"), ["tensorboard"]))
    for key, value in logged.items():
        model.logger.record(key, value)
    console.print(f"run folder {shown(run)}")
    remaining = max(settings.total_steps - model.num_timesteps, 0)
    with stop_on_interrupt(stop, console), bar.progress:
        model.learn(remaining, callback=callback, reset_num_timesteps=not resumed)
    finished = bool(model.num_timesteps >= settings.total_steps)
    if finished:
        save()
        card = about | {"steps": model.num_timesteps}
        save_agent(run / "agent", model, environment, settings, core.task, core.scenario, card)
        console.print(f"trained for {model.num_timesteps:,} steps: {shown(run / 'agent')}")
    else:
        console.print(f"stopped after checkpoint {newest(run).name}; go on with: train.py --resume {shown(run)}")
    environment.close()
    return finished


def describe(settings: TrainingConfig, core: Any) -> dict[str, Any]:
    """Where the run comes from: versions, seed, fingerprint of the resolved configuration."""
    return {
        "versions": {"ssmash_gym": ssmash_gym.__version__, "python": platform.python_version(), **library_versions()},
        "seed": settings.seed,
        "configuration": fingerprint(settings, core.task, core.scenario),
    }


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
        raise ConfigurationError(f"{run}: there is no checkpoint to go on from.")
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
