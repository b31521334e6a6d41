"""Makes docs/images/traverse.png: a simulated moment of the standard traverse, driven by a baseline.

python tools/make_pictures.py
"""

from __future__ import annotations

from pathlib import Path

import gymnasium as gym
import matplotlib.image
from ssmash_gym.agents.baselines import BASELINES

import ssmash_gym  # noqa: F401  (registers the environment)
from ssmash_gym.files import whole_file

SECONDS = 26.0
SEED = 11


def main() -> None:
    env = gym.make("ssmash/Traverse-v0", render_mode="rgb_array", scenario="ss5")
    core = env.unwrapped
    policy = BASELINES["yield"](core.core.task)
    policy.reset(1)
    observation, _ = env.reset(seed=SEED)
    for _ in range(round(SECONDS / core.control_interval_s)):
        observation, *_ = env.step(policy.act(observation[None])[0])
    with whole_file(Path("docs/images/traverse.png")) as path:
        matplotlib.image.imsave(path, env.render(), format="png")
    env.close()


if __name__ == "__main__":
    main()
