"""`ssmash export`: recorded trials, or episodes of a policy, as a Minari dataset for imitation learning.

Extra ``data``. Nothing is fetched from a network: a dataset is a folder of this machine.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import tyro
from rich.console import Console

import ssmash_gym
from ssmash_gym.envs.given import as_helicopter
from ssmash_gym.envs.loading import names
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.evaluation.conditions import Condition, written
from ssmash_gym.evaluation.policies import is_scripted
from ssmash_gym.progress import progress_bar
from ssmash_gym.registration import TRAVERSE_ID
from ssmash_gym.training.seeds import DEMONSTRATIONS, block
from ssmash_gym.trials.demonstrations import SENSORS, Demonstration, demonstration, demonstrations, perceived
from ssmash_gym.trials.scripted import OPERATOR, SCRIPTED_OPERATOR, policy_for, scripted_trial
from ssmash_gym.trials.verbs import listed_paths

ROOT: Final = "MINARI_DATASETS_PATH"  # Minari's own variable for the folder that holds all datasets
_ID: Final = re.compile(r"(?:[A-Za-z0-9_-]+/)*[A-Za-z0-9_-]+-v\d+")
Files = Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="[FILE|FOLDER ...]")]


def require_minari() -> None:
    """Check that datasets can be written and read.

    Raises:
        ImportError: A library is missing; the sentence names the extra.
    """
    for library in ("minari", "h5py", "PIL"):
        require(library, 'datasets need Minari: pip install "ssmash_gym[data]".')


def export(
    files: Files = (),
    /,
    to: str = "",
    folder: Path | None = None,
    observation: str = SENSORS,
    agent: str | None = None,
    policy: str | None = None,
    scenario: str | None = None,
    episodes: int = 50,
    seed: int = 0,
) -> None:
    """Write recorded trials, or episodes of an agent or a policy, as a Minari dataset.

    Each trial is simulated once more: observations are made then, actions are the commands as they were applied.

    Args:
        files: Files of trials, or folders of them; those that were broken off are left out.
        to: The dataset's name, NAME-vNUMBER, with namespaces before it if you like (ssmash/p01-v0).
        folder: That holds all datasets; Minari's own by default (MINARI_DATASETS_PATH, or below the home folder).
        observation: What is observed: sensors, full, forecast, or terms with commas.
        agent: Episodes of this agent (name or folder), instead of trials.
        policy: Episodes of this scripted policy, instead of trials.
        scenario: Of such episodes; ss5 by default.
        episodes: How many of them.
        seed: Chooses their block of seeds, one that no training has seen.

    Raises:
        ConfigurationError: A name, a file or a number is refused, or a trial does not replay; nothing is written.
        ImportError: The extra ``data`` is missing.
    """
    sources = [name for name, given in (("files", files), ("--agent", agent), ("--policy", policy)) if given]
    if len(sources) != 1:
        raise ConfigurationError(f"{' and '.join(sources) or 'nothing to export'}: name trials, --agent or --policy.")
    if scenario is not None and files:
        raise ConfigurationError(f"--scenario {scenario} is refused with trials: they have their own.")
    if episodes < 1 or seed < 0:
        raise ConfigurationError(f"--episodes {episodes} --seed {seed} is refused: at least 1 and 0.")
    require_minari()
    place = checked_place(to, folder)
    seen = observation if "," not in observation else tuple(word.strip() for word in observation.split(","))
    if files:
        condition, _, made = demonstrations(listed_paths(files), lambda task: perceived(task, seen))
    else:
        name = str(agent or policy)
        condition, made = of_policy(
            name, agent is not None, scenario or "ss5", block(seed, DEMONSTRATIONS, episodes), seen
        )
    write_dataset(to, place, made, condition, perceived(condition.task, seen))
    told = ", ".join(sorted({one.author for one in made}))
    steps = sum(len(one.rewards) for one in made)
    Console().print(f"{len(made)} episodes, {steps:,} steps, driven by {told}: dataset in {place}", markup=False,
                    soft_wrap=True)  # fmt: skip


def checked_place(to: str, folder: Path | None) -> Path:
    """Where a new dataset is to lie.

    Args:
        to: Its name.
        folder: That holds all datasets; None: Minari's own.

    Raises:
        ConfigurationError: The name is refused, or taken.
    """
    if not _ID.fullmatch(to):
        raise ConfigurationError(f"--to {to!r} is refused: a dataset is called NAME-vNUMBER, such as ssmash/p01-v0.")
    place = dataset_folder(to, folder)
    if place.exists():
        raise ConfigurationError(f"{place}: there is a dataset of this name already; choose another, or remove it.")
    return place


def dataset_folder(name: str, folder: Path | None) -> Path:
    """The folder of a dataset.

    Args:
        name: Of it.
        folder: That holds all datasets; None: Minari's own.
    """
    root = folder if folder is not None else os.environ.get(ROOT) or Path.home() / ".minari" / "datasets"
    return Path(root).resolve() / name


def of_policy(
    name: str, trained: bool, scenario: str, seeds: Sequence[int], observation: str | Sequence[str] = SENSORS
) -> tuple[Condition, list[Demonstration]]:
    """Episodes of a policy, recorded as trials are.

    Args:
        name: Of a scripted policy, or an agent's name or folder.
        trained: Whether it is an agent.
        scenario: What its episodes are drawn from: name or file.
        seeds: Of them.
        observation: A named set, or terms.

    Raises:
        ConfigurationError: A name is unknown, or the policy does not suit the task.
    """
    if trained == is_scripted(name):
        kind = "scripted policy, name it with --policy" if trained else "scripted policy of that name"
        raise ConfigurationError(f"{name!r} is refused: this is {'a' if trained else 'no'} {kind}.")
    called = scenario if scenario in names("scenarios") else Path(scenario).stem
    condition = Condition(called, "", load_task("traverse"), load_scenario(scenario), as_helicopter("generic_tricycle"))
    task = perceived(condition.task, observation)
    policy = policy_for(name, condition)
    author = f"agent {policy.name}" if trained else f"scripted policy {name}"
    author = SCRIPTED_OPERATOR if name == OPERATOR else author
    with progress_bar("episodes") as advance:
        made = []
        for k, seed in enumerate(seeds):
            advance(k / len(seeds), f"{name}, seed {seed}")
            made.append(demonstration(scripted_trial(condition, seed, policy), task, author))
    return condition, made


def environment_spec(condition: Condition, task: TaskConfig) -> Any:
    """What `gymnasium.make` needs to make the environment of a dataset, in plain numbers.

    Args:
        condition: What was simulated.
        task: As it is observed.
    """
    from gymnasium.envs.registration import EnvSpec

    from ssmash_gym.registration import ENTRY_POINTS

    parts = written(task, condition.scenario, condition.helicopter)
    return EnvSpec(TRAVERSE_ID, entry_point=ENTRY_POINTS[TRAVERSE_ID][0], kwargs=parts)


def write_dataset(
    name: str, place: Path, made: Sequence[Demonstration], condition: Condition, task: TaskConfig
) -> None:
    """Write a Minari dataset, whole or not at all.

    Args:
        name: Of it.
        place: Its folder, as of `checked_place`.
        made: The episodes.
        condition: What was simulated.
        task: As it is observed.
    """
    require_minari()
    import gymnasium
    import minari
    from minari.data_collector import EpisodeBuffer

    authors = sorted({one.author for one in made})
    clip, size = task.observation_clip, made[0].observations.shape[1]
    buffers = [_buffer(EpisodeBuffer, one) for one in made]
    root = place.parents[name.count("/")]
    root.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".ssmash-", dir=root) as temporary, datasets_in(Path(temporary)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of what is left out: addresses, and a link to code
            dataset = minari.create_dataset_from_buffers(
                name, buffers, env=environment_spec(condition, task), algorithm_name=", ".join(authors),
                author=", ".join(authors), description=_description(authors, condition),
                requirements=[f"ssmash_gym=={ssmash_gym.__version__}"], data_format="hdf5",
                action_space=gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float64),
                observation_space=gymnasium.spaces.Box(-clip, clip, (size,), np.float32),
            )  # fmt: skip
        dataset.storage.update_episode_metadata([_about(one) for one in made])
        place.parent.mkdir(parents=True, exist_ok=True)
        for told in Path(temporary).rglob("namespace_metadata.json"):
            kept = root / told.relative_to(temporary)
            if not kept.exists():
                shutil.copy(told, kept)
        (Path(temporary) / name).rename(place)


def _buffer(kind: Any, one: Demonstration) -> Any:
    steps = len(one.rewards)
    ends = [np.arange(1, steps + 1) == (steps if ended else 0) for ended in (one.terminated, one.truncated)]
    return kind(
        seed=one.seed, observations=one.observations, actions=one.actions, rewards=one.rewards, terminations=ends[0],
        truncations=ends[1],
    )  # fmt: skip


def _about(one: Demonstration) -> dict[str, Any]:
    """What is told of each episode beside its numbers."""
    kept = ("success", "peak_probe_kN", "time_s", "reason")
    return {"author": one.author, **{key: one.metrics[key] for key in kept}}


def _description(authors: Sequence[str], condition: Condition) -> str:
    return (
        f"Episodes of {TRAVERSE_ID} ({condition.name}), driven by {', '.join(authors)}. Actions are the claw's "
        "commands as they were applied. Loads are those of a model with assumed numbers. Configuration "
        f"{condition.configuration}."
    )


@contextmanager
def datasets_in(root: Path) -> Iterator[None]:
    """Let Minari look for its datasets in a folder."""
    before = os.environ.get(ROOT)
    os.environ[ROOT] = str(root)
    try:
        yield
    finally:
        if before is None:
            del os.environ[ROOT]
        else:
            os.environ[ROOT] = before


def read_dataset(name: str, folder: Path | None = None) -> Any:
    """A Minari dataset of this machine.

    Args:
        name: Of it.
        folder: That holds all datasets; None: Minari's own.

    Raises:
        ConfigurationError: There is none of that name, or it cannot be read.
        ImportError: The extra ``data`` is missing.
    """
    require_minari()
    from minari import MinariDataset

    place = dataset_folder(name, folder)
    if not (place / "data").is_dir():
        raise ConfigurationError(f"{place}: there is no dataset of this name on this machine.")
    try:
        return MinariDataset(place / "data")
    except (AssertionError, KeyError, OSError, ValueError) as error:
        raise ConfigurationError(f"{place}: this dataset cannot be read ({error}).") from None


def task_of(dataset: Any) -> tuple[TaskConfig, Condition]:
    """The task of a dataset as it is observed, and what was simulated.

    Raises:
        ConfigurationError: The dataset is of another environment.
    """
    spec = dataset.spec.env_spec
    if spec is None or spec.id != TRAVERSE_ID or not {"task", "scenario", "helicopter"} <= set(spec.kwargs):
        raise ConfigurationError(f"{dataset.spec.dataset_id}: this is no dataset of {TRAVERSE_ID} with its settings.")
    task = load_task(spec.kwargs["task"])
    scenario, helicopter = load_scenario(spec.kwargs["scenario"]), as_helicopter(spec.kwargs["helicopter"])
    return task, Condition(dataset.spec.dataset_id, "", task, scenario, helicopter)
