"""From a configuration to a Stable-Baselines3 model on the native batch: PPO, SAC, or TQC of sb3-contrib."""

from __future__ import annotations

from typing import Any, Final

from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.training.config import TrainingConfig
from ssmash_gym.training.sections import Sac, Tqc
from ssmash_gym.training.seeds import TRAINING, block, network_seed

LIBRARIES: Final = {"ppo": "stable_baselines3", "sac": "stable_baselines3", "tqc": "sb3_contrib"}


def require_training(algorithm: str = "ppo") -> None:
    """Check that the libraries for training are there.

    Raises:
        ImportError: One is missing; the sentence names the extra.
    """
    for name in ("torch", "stable_baselines3", "tensorboard", LIBRARIES[algorithm]):
        require(name, f'training needs {name}, which is not installed: pip install "ssmash_gym[train]".')


def make_environment(config: TrainingConfig) -> Any:
    """The native batch behind a `VecNormalize`, seeded from the training block."""
    from stable_baselines3.common.vec_env import VecNormalize

    from ssmash_gym.envs.sb3 import TraverseVecEnv
    from ssmash_gym.training.costs import Priced
    from ssmash_gym.training.stagger import Staggered

    section = config.environment
    native = TraverseVecEnv(section.count, task=section.task, scenario=section.scenario, threads=section.threads)
    staggered = Staggered(native)
    wrapper = VecNormalize(
        Priced(staggered, config.costs) if config.costs else staggered,
        norm_obs=config.normalise.observation,
        norm_reward=config.normalise.reward,
        clip_obs=config.normalise.clip,
        clip_reward=config.normalise.clip,
        gamma=config.learner.gamma,
    )
    native._seeds = list(block(config.seed, TRAINING, section.count))  # `seed` could only count up from one number
    return wrapper


def layer(environment: Any, kind: type) -> Any:
    """The wrapper of that kind around the native batch, None if there is none."""
    while environment is not None and not isinstance(environment, kind):
        environment = getattr(environment, "venv", None)
    return environment


def chosen_device(config: TrainingConfig) -> str:
    """Where the networks are: ``cpu`` or ``cuda``.

    Raises:
        ConfigurationError: A GPU is asked for, and there is none that PyTorch could use.
    """
    import torch

    there = torch.cuda.is_available()
    if config.device == "cuda" and not there:
        raise ConfigurationError("training: device = 'cuda' is refused: PyTorch finds no GPU; take cpu or auto.")
    return "cuda" if there and config.device != "cpu" else "cpu"


def make_model(config: TrainingConfig, environment: Any) -> Any:
    """A fresh model; same configuration and seed, same weights.

    Raises:
        ImportError: A library is missing; the sentence names the extra.
        ConfigurationError: A GPU is asked for, and there is none.
    """
    require_training(config.algorithm)
    import torch
    from stable_baselines3.common.utils import set_random_seed

    device = chosen_device(config)
    torch.set_num_threads(config.torch_threads)
    set_random_seed(network_seed(config.seed))  # not the model's own `seed`: that would reseed the environment too
    if config.algorithm == "ppo":
        return _ppo(config, environment, device)
    return _off_policy(config, environment, device)


def _ppo(config: TrainingConfig, environment: Any, device: str) -> Any:
    import torch
    from stable_baselines3 import PPO

    ppo, layers = config.ppo, list(config.network.layers)
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
            "activation_fn": _activation(config),
            "log_std_init": config.network.log_std,
        },
        device=device,
    )
    policy: Any = model.policy
    with torch.no_grad():
        policy.action_net.bias.copy_(torch.tensor(config.network.initial_action))
    return model


def _off_policy(config: TrainingConfig, environment: Any, device: str) -> Any:
    """SAC or TQC; the first mean action and exploration are set through the last layers."""
    import torch

    section = config.learner
    assert isinstance(section, Sac)
    layers = list(config.network.layers)
    more: dict[str, Any] = {}
    networks: dict[str, Any] = {"net_arch": {"pi": layers, "qf": layers}, "activation_fn": _activation(config)}
    if isinstance(section, Tqc):
        from sb3_contrib import TQC

        kind: Any = TQC
        more["top_quantiles_to_drop_per_net"] = section.dropped
        networks |= {"n_quantiles": section.quantiles, "n_critics": section.critics}
    else:
        from stable_baselines3 import SAC

        kind = SAC
    if section.n_steps > 1:
        more["n_steps"] = section.n_steps
    model = _self_started(kind)(
        "MlpPolicy",
        environment,
        learning_rate=Linear(section.learning_rate, section.learning_rate_end),
        buffer_size=section.buffer_size,
        learning_starts=section.learning_starts,
        batch_size=section.batch_size,
        tau=section.tau,
        gamma=section.gamma,
        train_freq=section.train_every,
        gradient_steps=section.gradient_steps,
        ent_coef=f"auto_{section.first_entropy}" if section.entropy is None else section.entropy,
        target_entropy="auto" if section.target_entropy is None else section.target_entropy,
        policy_kwargs=networks,
        device=device,
        **more,
    )
    with torch.no_grad():
        model.actor.mu.weight.mul_(0.01)  # as PPO begins: the same nearly everywhere
        model.actor.mu.bias.copy_(torch.atanh(torch.tensor(config.network.initial_action)))
        model.actor.log_std.weight.mul_(0.01)
        model.actor.log_std.bias.fill_(config.network.log_std)
    return model


def _self_started(kind: Any) -> Any:
    """SAC or TQC that collects its first transitions with its first policy, not with commands out of a hat.

    At random the claw goes nowhere: no goal is ever seen, and what is learned is to stop where the reward first falls.
    """

    class SelfStarted(kind):  # type: ignore[misc]
        def _sample_action(self, learning_starts: int, action_noise: Any = None, n_envs: int = 1) -> Any:
            return super()._sample_action(0, action_noise, n_envs)

    return SelfStarted


def _activation(config: TrainingConfig) -> Any:
    import torch

    return {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU, "elu": torch.nn.ELU}[config.network.activation]


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
