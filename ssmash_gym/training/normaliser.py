"""The running moments that a policy was trained with, as plain numbers."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text

EPSILON = 1e-8


@dataclass(frozen=True)
class Moments:
    """Mean, variance and count of a running quantity; lists of one number for a scalar."""

    mean: list[float]
    variance: list[float]
    count: float

    @classmethod
    def of(cls, running: Any) -> Self:
        """Take them from a Stable-Baselines3 `RunningMeanStd`."""
        mean, variance = (np.atleast_1d(np.asarray(x, dtype=np.float64)) for x in (running.mean, running.var))
        return cls(mean.tolist(), variance.tolist(), float(running.count))

    def into(self, running: Any) -> None:
        """Put them into a Stable-Baselines3 `RunningMeanStd`."""
        running.mean = np.asarray(self.mean).reshape(np.shape(running.mean))
        running.var = np.asarray(self.variance).reshape(np.shape(running.var))
        running.count = self.count


@dataclass(frozen=True)
class Normaliser:
    """Frozen normalisation.

    Attributes:
        observation: Moments of the observations; None when they are used as they are.
        reward: Moments of the return; None when rewards are used as they are.
        clip: Bound of normalised values.
    """

    observation: Moments | None
    reward: Moments | None
    clip: float

    @classmethod
    def of(cls, wrapper: Any) -> Self:
        """Take it from a Stable-Baselines3 `VecNormalize`."""
        observation = Moments.of(wrapper.obs_rms) if wrapper.norm_obs else None
        reward = Moments.of(wrapper.ret_rms) if wrapper.norm_reward else None
        return cls(observation, reward, float(wrapper.clip_obs))

    def into(self, wrapper: Any) -> None:
        """Put it into a `VecNormalize` of the same kind."""
        if self.observation is not None:
            self.observation.into(wrapper.obs_rms)
        if self.reward is not None:
            self.reward.into(wrapper.ret_rms)

    def __call__(self, observations: NDArray[np.float32]) -> NDArray[np.float32]:
        """What the policy sees of observations (n, k); moments are not updated."""
        if self.observation is None:
            return observations
        mean, variance = np.asarray(self.observation.mean), np.asarray(self.observation.variance)
        scaled = (observations - mean) / np.sqrt(variance + EPSILON)
        return np.asarray(np.clip(scaled, -self.clip, self.clip), dtype=np.float32)

    def write(self, path: Path) -> None:
        """Write the numbers as JSON."""
        write_text(path, json.dumps(asdict(self), indent=1) + "\n")

    @classmethod
    def read(cls, path: Path) -> Self:
        """The inverse of `write`.

        Raises:
            ConfigurationError: There is no such file, or it holds something else.
        """
        if not path.is_file():
            raise ConfigurationError(
                f"{path.parent}: the normaliser {path.name} is missing; an agent without the moments it was trained "
                "with does something else, so it is refused."
            )
        try:
            document = json.loads(path.read_text(encoding="utf-8"))
            moments = {key: Moments(**document[key]) if document[key] else None for key in ("observation", "reward")}
            return cls(moments["observation"], moments["reward"], float(document["clip"]))
        except (KeyError, TypeError, ValueError) as error:
            raise ConfigurationError(f"{path}: this is no normaliser ({error!r}).") from None
