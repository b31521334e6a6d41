"""From a configuration to a Stable-Baselines3 model on the native batch."""

from __future__ import annotations

from typing import Any

from ssmash_gym.errors import require
from ssmash_gym.training.config import TrainingConfig
from ssmash_gym.training.seeds import TRAINING, block, network_seed


def require_training() -> None:
    """Check that the libraries for training are there.

    Raises:
        ImportError: One is missing; the sentence names the extra.
    """
    for name in ("torch", "stable_baselines3", "tensorboard"):
        require(name, f'training needs {name}, which is not installed: pip install "ssmash_gym[train]".')


def make_environment(config: TrainingConfig) -> Any:
    """The native batch behind a `VecNormalize`, seeded from the training block."""
    from stable_baselines3.common.vec_env import VecNormalize

    from ssmash_gym.envs.sb3 import TraverseVecEnv
    from ssmash_gym.training.stagger import Staggered

    section = config.environment
    native = TraverseVecEnv(section.count, task=section.task, scenario=section.scenario, threads=section.threads)
    wrapper = VecNormalize(
        Staggered(native),
        norm_obs=config.normalise.observation,
        norm_reward=config.normalise.reward,
        clip_obs=config.normalise.clip,
        clip_reward=config.normalise.clip,
        gamma=config.ppo.gamma,
    )
    native._seeds = list(block(config.seed, TRAINING, section.count))  # `seed` could only count up from one number
    return wrapper


def make_model(config: TrainingConfig, environment: Any) -> Any:
    """A fresh PPO model; same configuration and seed, same weights.

    Raises:
        ImportError: PyTorch or Stable-Baselines3 is missing.
    """
    require_training()
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.utils import set_random_seed

    torch.set_num_threads(config.torch_threads)
    set_random_seed(network_seed(config.seed))  # not PPO's own `seed`: that would reseed the environment too
    ppo, network = config.ppo, config.network
    activations = {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU, "elu": torch.nn.ELU}
    layers = list(network.layers)
    model = PPO(
        "MlpPolicy",
        environment,
        learning_rate=Linear(ppo.learning_rate, ppo.learning_rate_end),
        n_steps=ppo.steps_per_update,
        batch_size=ppo.batch_size,
        n_epochs=ppo.epochs,
        gamma=ppo.gamma,
        gae_lambda=ppo.gae_lambda,
        clip_range=ppo.clip_range,
        ent_coef=ppo.entropy,
        vf_coef=ppo.value_weight,
        max_grad_norm=ppo.gradient_norm,
        target_kl=ppo.target_kl,
        policy_kwargs={
            "net_arch": {"pi": layers, "vf": layers},
            "activation_fn": activations[network.activation],
            "log_std_init": network.log_std,
        },
        device="cpu",
    )
    policy: Any = model.policy
    with torch.no_grad():
        policy.action_net.bias.copy_(torch.tensor(network.initial_action))
    return model


class Linear:
    """Linear schedule from the start of the training to its end.

    Args:
        start: Value at the start.
        end: Value at the end.
    """

    def __init__(self, start: float, end: float) -> None:
        self.start, self.end = start, end

    def __call__(self, remaining: float) -> float:
        """Value when a share `remaining` of the steps is left."""
        return self.end + remaining * (self.start - self.end)
