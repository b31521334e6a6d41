"""Who takes part in a study: scripted policies, planners, and agents with one or several training seeds."""

from __future__ import annotations

import functools
import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import ssmash_gym
from ssmash_gym.assets import asset_path
from ssmash_gym.document import listed
from ssmash_gym.envs.task import PERCEIVED, TaskConfig, observed_as
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import digest
from ssmash_gym.evaluation.policies import Policy, agent_folder, baselines, is_scripted, make_baseline
from ssmash_gym.evaluation.study import NAME
from ssmash_gym.training.agent import NORMALISER, WEIGHTS, Agent, load_agent

AGENT: Final = "agent"
SCRIPTED: Final = "scripted"
PLANNER: Final = "planner"
PLANNERS: Final = ("planning", "mppi", "clairvoyant")  # beginnings of the names of their sources
PHYSICS: Final = ("dynamics", "envs", "ship", "simulation", "vehicle")  # parts of the package that make an episode


@dataclass(frozen=True)
class Entrant:
    """One policy of a study, of one training seed.

    Attributes:
        name: In rows and tables; several training seeds of one agent share it.
        training_seed: None for what was not trained.
        kind: ``agent``, ``scripted`` or ``planner``.
        identity: Hash of what it does: weights, or sources and tuned numbers.
        make: Makes the policy for a task.
        about: Where it comes from, for ``study.json``.
    """

    name: str
    training_seed: int | None
    kind: str
    identity: str
    make: Callable[[TaskConfig], Policy]
    about: Mapping[str, Any] = field(default_factory=dict)


def scripted_entrant(name: str, task: TaskConfig) -> Entrant:
    """A scripted policy or a planner by name.

    Args:
        name: As of `make_baseline`.
        task: To try it in.

    Raises:
        ConfigurationError: There is none of that name.
    """
    make_baseline(name, task)
    kind = SCRIPTED if name.partition("@")[0] in baselines() else PLANNER
    identity = digest(name, ssmash_gym.__version__, _made_of(kind))
    return Entrant(name, None, kind, identity, functools.partial(make_baseline, name))


def entrant(word: str, task: TaskConfig) -> Entrant:
    """A scripted policy or a planner by name, or else a trained agent as `agent_entrants` takes it.

    Args:
        word: Name, or an agent's folder.
        task: To try a scripted one in.

    Raises:
        ConfigurationError: There is none of that name, or it does not suit the task.
    """
    return scripted_entrant(word, task) if is_scripted(word) else agent_entrants([word])[0]


def agent_entrants(words: Sequence[str]) -> list[Entrant]:
    """Agents as the command line names them.

    Args:
        words: ``NAME=FOLDER,FOLDER``, one folder a training seed; or a folder, a run or a shipped agent, which keeps
            its own name.

    Raises:
        ConfigurationError: There is no such agent, or two have the same name and training seed.
    """
    found: list[Entrant] = []
    for word in words:
        called, given, folders = word.partition("=")
        if not given or Path(word).exists():
            called, folders = "", word
        names = [folders] if Path(folders).exists() else listed(folders)
        found += [_agent(agent_folder(name), called) for name in names]
    taken: set[tuple[str, int | None]] = set()
    for one in found:
        if (one.name, one.training_seed) in taken:
            raise ConfigurationError(
                f"--agent: {one.name} of training seed {one.training_seed} is named twice: give different agents "
                "different names (NAME=FOLDER)."
            )
        taken.add((one.name, one.training_seed))
    return found


def _agent(folder: Path, called: str) -> Entrant:
    agent = load_agent(folder)
    agent = replace(agent, name=called) if called else agent
    if not re.match(NAME, agent.name):
        raise ConfigurationError(f"--agent: the name {agent.name!r} is refused: letters, digits and _ . @ + - only.")
    files = [(folder / name).read_bytes() for name in (WEIGHTS, NORMALISER)]
    own = {key: value for key, value in agent.task.model_dump(mode="json").items() if key in PERCEIVED}
    identity = digest([hashlib.sha256(content).hexdigest() for content in files], own, ssmash_gym.__version__)
    told = ("name", "configuration", "steps", "versions", "cloned_from")
    about = {key: agent.about[key] for key in told if key in agent.about}
    return Entrant(agent.name, agent.training.seed, AGENT, identity, functools.partial(_within, agent), about)


def _within(agent: Agent, task: TaskConfig) -> Policy:
    """The agent in a task that it perceives in its own way."""
    return agent.within(observed_as(task, agent.task))


def _made_of(kind: str) -> list[str]:
    """Hashes of the files that scripted policies, or planners, are made of: their sources and the tuned numbers.

    All of a kind share them: which modules one policy goes through is not told by its class, and a wrong guess would
    mix rows. Sources of planners do not touch the scripted policies.
    """
    sources = asset_path("agents").glob("*.py")
    return _hashes([*(path for path in sources if kind == PLANNER or not path.name.startswith(PLANNERS)), *_data()])


def _data() -> list[Path]:
    """The files of tuned numbers that ship beside the scripted policies."""
    folder = asset_path("agents") / "data"
    return [path for path in folder.rglob("*") if path.is_file()] if folder.is_dir() else []


def _hashes(paths: Sequence[Path]) -> list[str]:
    return [_hash(path) for path in sorted(paths, key=lambda path: path.name)]


@functools.cache
def _hash(path: Path) -> str:
    """Hash of a file as it is when first asked for: what is edited later does not run in this process."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


@functools.cache
def code() -> str:
    """Hash of all sources that an episode goes through, as they are when first asked for."""
    package = Path(ssmash_gym.__file__).parent
    sources = [path for part in PHYSICS for path in sorted((package / part).rglob("*.py"))]
    return digest(_hashes([*sources, *asset_path("agents").glob("*.py"), *_data()]))
