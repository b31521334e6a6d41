"""Films: one episode, and the same sea driven by several policies side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.pictures import Film
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.evaluation.film_grid import Grid, Panel
from ssmash_gym.evaluation.page_style import Style, styles
from ssmash_gym.evaluation.policies import Policy, attach
from ssmash_gym.files import whole_files
from ssmash_gym.vehicle import Helicopter

MOST: Final = 6  # panels of a film: more could not be read
LAST_S: Final = 2.0  # of the film: the last picture stays so long
LARGEST_BYTES: Final = 4_000_000  # of a film side by side: it goes into a page
QUALITY: Final = 27  # constant rate factor of H.264, as long as the size allows it
SPEED: Final = 2.0  # times reality

Write = Callable[[bytes | NDArray[np.uint8]], None]


def require_rendering() -> None:
    """Check that films can be made.

    Raises:
        ImportError: A library is missing; the sentence names the extra.
    """
    for name in ("pygame", "imageio_ffmpeg"):
        require(name, f'a film needs {name}: pip install "ssmash_gym[render]", or say --no-film.')


def film_episode(
    policy: Policy, scenario: ScenarioConfig, seed: int, path: Path, *, speed: float = SPEED
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
    target = path.with_suffix(".mp4")
    target.parent.mkdir(parents=True, exist_ok=True)
    take = Take(policy, scenario, seed)
    frame = take.picture()
    with whole_files([target]) as staged:
        size = (frame.shape[1], frame.shape[0])
        with encoder(staged[target], size, speed / policy.task.control_interval_s, []) as write:
            write(frame)
            while not take.over:
                take.step()
                write(take.picture())
    return take.metrics


def film_side_by_side(
    policies: Sequence[Policy],
    scenario: ScenarioConfig,
    seed: int,
    path: Path,
    *,
    helicopter: str | Helicopter = "generic_tricycle",
    speed: float = SPEED,
    looks: Mapping[str, Style] | None = None,
    largest_bytes: int = LARGEST_BYTES,
) -> dict[str, dict[str, Any]]:
    """Film the same sea driven by each policy, a panel each, as a small MP4 (H.264).

    All panels show the same instant. One whose episode has ended holds its last picture until all have. The picture
    with the highest probe load is written beside the film as JPEG.

    Args:
        policies: What drives the claw, at most six; no two of a name.
        scenario: What the episode is drawn from: sea, helicopter, drive and start are the same for all.
        seed: Of the episode.
        path: File to write.
        helicopter: Name, or ready-made.
        speed: How much faster than in reality it plays.
        looks: Style of each policy by name; the first one stands out by default.
        largest_bytes: What an episode of full length may take.

    Returns:
        Each episode's metrics by the policy's name: those of the evaluation with that seed.

    Raises:
        ConfigurationError: There are too many policies, none, two of a name, or different control intervals.
        ImportError: The extra ``render`` is missing.
    """
    _check(policies)
    require_rendering()
    target, still = path.with_suffix(".mp4"), path.with_suffix(".jpg")
    target.parent.mkdir(parents=True, exist_ok=True)
    looks = looks or styles([policy.name for policy in policies], policies[0].name)
    takes = [Take(policy, scenario, seed, helicopter) for policy in policies]
    task = policies[0].task
    grid = Grid(len(takes), task.horizon_s, 1.3 * task.limits.probe_in_plane_kN)
    panels = [Panel(take.name, looks[take.name].bright, take.film.scene()) for take in takes]
    rate = speed / task.control_interval_s
    with whole_files([target, still]) as staged:
        with encoder(staged[target], grid.size, rate, _small(largest_bytes, task.horizon_s / speed + LAST_S)) as write:
            frame = highest = grid.draw(panels, range(len(panels)))
            write(frame)
            highest_kN = 0.0
            while running := [k for k, take in enumerate(takes) if not take.over]:
                for k in running:
                    _move(takes[k], panels[k])
                frame = grid.draw(panels, running)
                write(frame)
                load_kN = max(panels[k].load_kN[-1] for k in running)
                if load_kN > highest_kN and panels[running[0]].time_s[-1] > task.grace_s:
                    highest, highest_kN = frame, load_kN
            for _ in range(round(LAST_S * rate)):
                write(frame)
        _save_still(staged[still], highest, grid.size)
    return {take.name: take.metrics for take in takes}


class Take:
    """One policy in one episode, step by step.

    Args:
        policy: What drives the claw; told of the simulation where it has `attach`.
        scenario: What the episode is drawn from.
        seed: Of the episode.
        helicopter: Name, or ready-made.

    Attributes:
        film: Draws it; over: whether it has ended; metrics: those of the episode, at its end.
    """

    def __init__(
        self, policy: Policy, scenario: ScenarioConfig, seed: int, helicopter: str | Helicopter = "generic_tricycle"
    ) -> None:
        self.name, self.policy = policy.name, policy
        self.core = TraverseBatch(1, task=policy.task, scenario=scenario, helicopter=helicopter)
        attach(policy, self.core)
        self.observation: NDArray[np.float32] = self.core.reset(seeds=[seed])
        policy.reset(1)
        self.film = Film(self.core, 0, "rgb_array")
        self.over = False
        self.metrics: dict[str, Any] = {}

    def step(self) -> None:
        """One control interval."""
        result = self.core.step(self.policy.act(self.observation))
        self.observation = result.observation
        self.film.note(result)
        if 0 in result.endings:
            self.over, self.metrics = True, dict(result.endings[0]["episode_metrics"])

    def picture(self) -> NDArray[np.uint8]:
        """The picture with all its gauges, (height, width, 3)."""
        return np.ascontiguousarray(self.film.picture())


def _check(policies: Sequence[Policy]) -> None:
    names = [policy.name for policy in policies]
    if not 1 <= len(names) <= MOST:
        raise ConfigurationError(f"a film of {len(names)} policies is refused: 1 to {MOST} can be shown side by side.")
    if len(set(names)) < len(names):
        raise ConfigurationError(f"a film of {', '.join(names)} is refused: no two policies may have the same name.")
    intervals = {policy.task.control_interval_s for policy in policies}
    if len(intervals) > 1:
        raise ConfigurationError(
            f"a film of policies with control intervals of {', '.join(f'{s:g}' for s in sorted(intervals))} s is "
            "refused: they cannot be shown side by side."
        )


def _move(take: Take, panel: Panel) -> None:
    """One control interval of a panel's helicopter."""
    take.step()
    panel.scene = take.film.scene()
    panel.peak_kN = 1e-3 * float(take.core.book.peak_probe_N[0])
    panel.time_s.append(panel.scene.time_s)
    panel.load_kN.append(1e-3 * float(take.core.telemetry.peak_max("probe_in_plane")[0]))


def _small(largest_bytes: int, longest_s: float) -> list[str]:
    """Options of the encoder that keep a film of this length below a size."""
    bits_per_s = round(0.95 * 8 * largest_bytes / longest_s)
    return [
        "-crf", str(QUALITY), "-maxrate", str(bits_per_s), "-bufsize", str(bits_per_s), "-preset", "slow",
        "-movflags", "+faststart",
    ]  # fmt: skip


@contextmanager
def encoder(path: Path, size: tuple[int, int], rate_hz: float, options: list[str]) -> Iterator[Write]:
    """A function that takes one picture after the other: red, green, blue, row by row.

    Args:
        path: Film to write, with its ending.
        size: Width and height [px].
        rate_hz: Pictures a second.
        options: Further ones of the encoder.
    """
    import imageio_ffmpeg

    # The encoder's own choice of quality stands aside where the options name one.
    quality = {"quality": None} if options else {}
    writer = imageio_ffmpeg.write_frames(
        str(path), size, fps=rate_hz, macro_block_size=2, codec="libx264", ffmpeg_log_level="error",
        output_params=options, **quality,
    )  # fmt: skip
    writer.send(None)
    try:
        yield writer.send
    finally:
        writer.close()


def _save_still(path: Path, frame: bytes, size: tuple[int, int]) -> None:
    import pygame

    pygame.image.save(pygame.image.frombytes(frame, size, "RGB"), str(path))
