"""Planners by name, as the baselines are: each makes itself for a task.

A planner forks the running simulation and so has to be given it: `attach(batch)` before `reset`. `mppi` knows the past
of the deck; `clairvoyant` knows its future, and is a reference, not a policy for a ship.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from ssmash_gym.agents.clairvoyant import Clairvoyant
from ssmash_gym.agents.mppi import Mppi
from ssmash_gym.agents.planning_policy import Planner

from ssmash_gym.envs.task import TaskConfig

PLANNERS: Final[dict[str, Callable[[TaskConfig], Planner]]] = {planner.name: planner for planner in (Mppi, Clairvoyant)}
