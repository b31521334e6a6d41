"""A film of one episode."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.errors import require
from ssmash_gym.evaluation.policies import Policy
from ssmash_gym.files import whole_file


def require_rendering() -> None:
    """Check that films can be made.

    Raises:
        ImportError: A library is missing; the sentence names the extra.
    """
    for name in ("pygame", "imageio_ffmpeg"):
        require(name, f'a film needs {name}: pip install "ssmash_gym[render]", or say --no-film.')


def film_episode(
    policy: Policy, scenario: ScenarioConfig, seed: int, path: Path, *, speed: float = 2.0
) -> dict[str, Any]:
    """Film one episode as MP4; it is bit for bit the one of the evaluation with that seed.

    Args:
        policy: What drives the claw.
        scenario: What the episode is drawn from.
        seed: Of the episode.
        path: File to write.
        speed: How much faster than in reality it plays.

    Returns:
        The episode's metrics.

    Raises:
        ImportError: The extra ``render`` is missing.
    """
    require_rendering()
    import imageio_ffmpeg

    from ssmash_gym.envs.traverse import TraverseEnv

    env = TraverseEnv(task=policy.task, scenario=scenario, render_mode="rgb_array")
    observation, info = env.reset(seed=seed)
    policy.reset(1)
    frame = np.asarray(env.render())
    rate = speed / policy.task.control_interval_s
    with whole_file(path.with_suffix(".mp4")) as temporary:
        film = temporary.with_suffix(".film.mp4")  # the encoder goes by the name
        writer = imageio_ffmpeg.write_frames(
            str(film), (frame.shape[1], frame.shape[0]), fps=rate, macro_block_size=2, ffmpeg_log_level="error"
        )
        try:
            writer.send(None)
            writer.send(np.ascontiguousarray(frame))
            over = False
            while not over:
                observation, _, terminated, truncated, info = env.step(policy.act(observation[None])[0])
                over = terminated or truncated
                writer.send(np.ascontiguousarray(env.render()))
            writer.close()
            film.replace(temporary)
        finally:
            film.unlink(missing_ok=True)
            env.close()
    return dict(info["episode_metrics"])
