"""Policies by name: baselines, trained agents that ship with the package, and folders of trained agents."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.assets import asset_path
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.training.agent import ABOUT, Agent, load_agent


class Policy(Protocol):
    """What every policy can do, scripted or trained; always for a batch.

    Attributes:
        name: Of the policy, in tables.
        task: The task it is used in; its observation table says what `act` is given.
    """

    @property
    def name(self) -> str:
        """Name in tables."""

    @property
    def task(self) -> TaskConfig:
        """The task it is used in."""

    def reset(self, count: int) -> None:
        """Start `count` episodes."""

    def act(self, observations: NDArray[np.float32], starts: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """Normalised claw velocity commands.

        Args:
            observations: (n, k), as the task's observation table scales them.
            starts: (n,) rows in which a new episode starts; not needed after `reset`.

        Returns:
            Along and across the track, within -1 to 1, (n, 2).
        """


def attach(policy: Policy, batch: TraverseBatch) -> None:
    """Tell a policy of the simulation that it will act in, where it wants to know: planners do."""
    told = getattr(policy, "attach", None)
    if told is not None:
        told(batch)


def baselines() -> Mapping[str, Callable[[TaskConfig], Policy]]:
    """The scripted policies by name: each makes itself for a task."""
    registry = import_module("ssmash_gym.agents.baselines").BASELINES
    return cast("Mapping[str, Callable[[TaskConfig], Policy]]", registry)


def tuned_laws() -> tuple[str, ...]:
    """Names of the scripted policies whose gains were searched."""
    return cast("tuple[str, ...]", import_module("ssmash_gym.agents.baselines").TUNED)


def planners() -> Mapping[str, Callable[[TaskConfig], Policy]]:
    """The policies that look ahead on copies of the simulation, by name: each makes itself for a task."""
    registry = import_module("ssmash_gym.agents.planning").PLANNERS
    return cast("Mapping[str, Callable[[TaskConfig], Policy]]", registry)


def is_scripted(name: str) -> bool:
    """Whether a name, perhaps with ``@SPEED``, is that of a scripted policy or a planner."""
    plain = name.partition("@")[0]
    return plain in baselines() or plain in planners()


def make_baseline(name: str, task: TaskConfig) -> Policy:
    """A scripted policy or a planner; its commands are the claw's, whatever an agent's residual action corrects.

    Args:
        name: Of `baselines` or `planners`; ``NAME@SPEED`` drives along the track at so many m/s.
        task: The task it is to be used in.

    Raises:
        ConfigurationError: There is none of that name, or the task's observation lacks what it reads.
    """
    plain, at, speed = name.partition("@")
    make = baselines().get(plain)
    if make is None:  # planners are looked at second: they take longer to import
        make = planners().get(plain)
    if make is None:
        known = ", ".join((*baselines(), *planners()))
        raise ConfigurationError(f"there is no baseline {name!r}; there are {known}.")
    own = task.model_copy(update={"residual": None})
    return _at_speed(make, name, speed, own) if at else make(own)


def _at_speed(make: Callable[..., Policy], name: str, speed: str, task: TaskConfig) -> Policy:
    """The same baseline at another speed along the track, called by the whole name."""
    if "speed_m_s" not in signature(make).parameters:
        raise ConfigurationError(f"policy {name!r} is refused: {name.partition('@')[0]} has no speed to choose.")
    try:
        speed_m_s = float(speed)
    except ValueError:
        speed_m_s = math.nan
    if not 0.0 < speed_m_s <= task.claw.speed_along_m_s:
        raise ConfigurationError(
            f"policy {name!r} is refused: the speed must be a number above 0 and at most "
            f"{task.claw.speed_along_m_s:g} m/s, the claw's."
        )
    policy = make(task, speed_m_s=speed_m_s)
    policy.name = name  # type: ignore[misc]  # an attribute of the class otherwise
    return policy


def trained() -> dict[str, Path]:
    """The trained agents that ship with the package, by name."""
    try:
        root = asset_path("agents", "trained")
    except FileNotFoundError:
        return {}
    return {path.name: path for path in sorted(root.iterdir()) if (path / ABOUT).is_file()}


def find_agent(name_or_folder: str) -> Agent:
    """A trained agent: the name of one that ships with the package, its folder, a checkpoint, or a run folder.

    Raises:
        ConfigurationError: There is none, or its folder is not complete.
    """
    return load_agent(agent_folder(name_or_folder))


def agent_folder(name_or_folder: str) -> Path:
    """The folder of a trained agent, see `find_agent`.

    Raises:
        ConfigurationError: There is none.
    """
    shipped = trained()
    if name_or_folder in shipped:
        return shipped[name_or_folder]
    folder = Path(name_or_folder)
    if folder.is_file():  # the pointer `latest` where links are not allowed
        folder = folder.parent / folder.read_text(encoding="utf-8").strip()
    if (folder / ABOUT).is_file():
        return folder
    if (folder / "agent" / ABOUT).is_file():
        return folder / "agent"
    if (folder / "training.yaml").is_file():
        raise ConfigurationError(
            f"{folder}: this run has not been finished; name one of its checkpoints, or go on with train.py --resume."
        )
    if is_scripted(name_or_folder):
        raise ConfigurationError(f"{name_or_folder!r} is a scripted policy, no trained agent: name it in --against.")
    names = ", ".join([*shipped, *baselines()])
    raise ConfigurationError(f"there is no agent {name_or_folder!r}: give a run folder or one of {names}.")
