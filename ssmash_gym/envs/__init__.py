"""The task: action, observation, reward, limits, scenario, picture.

``gymnasium.make("ssmash_gym:ssmash/Traverse-v0")`` makes the single environment, ``gymnasium.make_vec`` the native
batch, `ssmash_gym.envs.sb3.TraverseVecEnv` the same for Stable-Baselines3. One physics stands under all three.
"""

from __future__ import annotations

from ssmash_gym.envs.scenario import EpisodeDraw, ScenarioConfig, load_scenario
from ssmash_gym.envs.task import TaskConfig, load_task

__all__ = ["EpisodeDraw", "ScenarioConfig", "TaskConfig", "load_scenario", "load_task"]
