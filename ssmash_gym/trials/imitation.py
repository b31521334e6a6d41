"""Behaviour cloning: a small network learns the commands of recorded episodes from what was observed (extra ``train``).

Supervised learning and nothing more: where the clone comes into states that its teacher never met, nothing tells it
what to do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.training.network import Network
from ssmash_gym.training.normaliser import Moments, Normaliser
from ssmash_gym.trials.demonstrations import Demonstration

CLIP: Final = 10.0  # of standardised observations
LEAST_VARIANCE: Final = 1e-4  # of an observation: one that hardly varies is not blown up
AXES: Final = ("along", "across")

Array = NDArray[np.float64]
Tell = Callable[[float], None]


@dataclass(frozen=True)
class Settings:
    """How a clone is trained; all numbers are assumed.

    Attributes:
        layers: Units of the hidden layers, tanh.
        epochs: Passes over the samples, at most.
        patience: Passes without a smaller validation error after which it stops.
        batch_size: Samples of a gradient step.
        learning_rate: Of Adam, falling to nothing by a half cosine over `epochs`.
        validation: Share of the seeds that are held back.
        seed: Of first weights, order of samples, and choice of those seeds.
    """

    layers: tuple[int, ...] = (64, 64)
    epochs: int = 60
    patience: int = 20
    batch_size: int = 256
    learning_rate: float = 1e-3
    validation: float = 0.2
    seed: int = 0


@dataclass(frozen=True)
class Fit:
    """A clone.

    Attributes:
        network: Mean of the policy; its outputs are commands.
        normaliser: Of its observations.
        curve: Errors after each pass: ``epoch``, ``training``, ``validation``, in variances of the commands.
        best_epoch: Pass whose network was kept.
        errors: On the validation episodes, by axis: ``rmse`` of the command, ``explained`` share of its variance.
    """

    network: Network
    normaliser: Normaliser
    curve: list[dict[str, float]]
    best_epoch: int
    errors: dict[str, dict[str, float | None]]


def split(made: Sequence[Demonstration], settings: Settings) -> tuple[list[Demonstration], list[Demonstration]]:
    """Episodes to train on, and episodes to validate with: no seed stands on both sides.

    Args:
        made: All.
        settings: Of the training.

    Raises:
        ConfigurationError: They are all of one seed.
    """
    seeds = sorted({one.seed for one in made})
    if len(seeds) < 2:
        raise ConfigurationError("the recorded episodes are of one seed only: there is none left to validate with.")
    held = max(1, round(settings.validation * len(seeds)))
    order = np.random.default_rng(settings.seed).permutation(len(seeds))
    back = {seeds[k] for k in order[:held]}
    return [one for one in made if one.seed not in back], [one for one in made if one.seed in back]


def samples(made: Sequence[Demonstration]) -> tuple[NDArray[np.float32], Array]:
    """Observations (n, k) and the commands that followed them (n, 2), of all episodes one after the other."""
    return np.concatenate([one.observations[:-1] for one in made]), np.concatenate([one.actions for one in made])


def fit(
    training: Sequence[Demonstration],
    validation: Sequence[Demonstration],
    settings: Settings,
    tell: Tell = lambda share: None,
) -> Fit:
    """Train a clone; the same episodes and settings give the same bits.

    The squared error of each command is taken in units of that command's variance: else the small commands across the
    track would hardly count.

    Args:
        training: Episodes to learn from.
        validation: Episodes that choose the pass that is kept.
        settings: Of the training.
        tell: Told the share that is done.

    Raises:
        ImportError: PyTorch is missing; the sentence names the extra.
    """
    require("torch", 'cloning needs PyTorch: pip install "ssmash_gym[train]".')
    observed, commands = samples(training)
    normaliser = standardised(observed)
    scale = np.maximum(commands.std(axis=0), 1e-3)
    held, held_commands = samples(validation)
    with _alone(settings.seed):
        layers, curve, best = _trained(
            (normaliser(observed), commands / scale), (normaliser(held), held_commands / scale), settings, tell
        )
    *hidden, (weight, bias) = layers
    last = (np.asarray(weight * scale, dtype=np.float32), np.asarray(bias * scale, dtype=np.float32))
    weights, biases = zip(*hidden, last, strict=True)
    network = Network(weights, biases, "tanh")
    return Fit(network, normaliser, curve, best, errors(network(normaliser(held)), held_commands))


def standardised(observed: NDArray[np.float32]) -> Normaliser:
    """A normaliser to mean 0 and variance 1 of these observations."""
    mean = observed.mean(axis=0, dtype=np.float64)
    variance = np.maximum(observed.var(axis=0, dtype=np.float64), LEAST_VARIANCE)
    return Normaliser(Moments(mean.tolist(), variance.tolist(), float(len(observed))), None, CLIP)


def errors(found: NDArray[np.float32], wanted: Array) -> dict[str, dict[str, float | None]]:
    """Error of commands by axis.

    Args:
        found: The clone's, clipped here as they are when it drives, (n, 2).
        wanted: The teacher's.
    """
    apart = np.clip(found.astype(np.float64), -1.0, 1.0) - wanted
    told: dict[str, dict[str, float | None]] = {}
    for k, axis in enumerate(AXES):
        variance = float(np.var(wanted[:, k]))
        missed = float(np.mean(apart[:, k] ** 2))
        told[axis] = {"rmse": missed**0.5, "explained": 1.0 - missed / variance if variance > 0.0 else None}
    return told


@contextmanager
def _alone(seed: int) -> Iterator[None]:
    """PyTorch on one thread, with a generator of its own."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            yield
    finally:
        torch.set_num_threads(threads)


def _trained(
    training: tuple[NDArray[np.float32], Array],
    validation: tuple[NDArray[np.float32], Array],
    settings: Settings,
    tell: Tell,
) -> tuple[list[tuple[NDArray[np.float32], NDArray[np.float32]]], list[dict[str, float]], int]:
    """Weights and biases of each layer after the best pass, the curve, and which pass that was."""
    import torch

    x, y, held_x, held_y = (torch.tensor(np.asarray(part, dtype=np.float32)) for part in (*training, *validation))
    network = _perceptron([x.shape[1], *settings.layers, y.shape[1]])
    optimiser = torch.optim.Adam(network.parameters(), lr=settings.learning_rate)
    falling = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, settings.epochs)
    curve: list[dict[str, float]] = []
    best, least, kept = 0, float("inf"), _layers(network)
    for epoch in range(1, settings.epochs + 1):
        total = 0.0
        for rows in torch.split(torch.randperm(len(x)), settings.batch_size):
            optimiser.zero_grad()
            loss = torch.mean((network(x[rows]) - y[rows]) ** 2)
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            total += float(loss.detach()) * len(rows)
        falling.step()
        with torch.no_grad():
            error = float(torch.mean((network(held_x) - held_y) ** 2))
        curve.append({"epoch": epoch, "training": total / len(x), "validation": error})
        tell(epoch / settings.epochs)
        if error < least:
            best, least, kept = epoch, error, _layers(network)
        elif epoch - best >= settings.patience:
            break
    return kept, curve, best


def _perceptron(sizes: Sequence[int]) -> Any:
    """A perceptron with tanh between its layers."""
    import torch

    layers: list[Any] = []
    for k in range(len(sizes) - 1):
        layers += [torch.nn.Linear(sizes[k], sizes[k + 1]), torch.nn.Tanh()]
    return torch.nn.Sequential(*layers[:-1])


def _layers(network: Any) -> list[tuple[NDArray[np.float32], NDArray[np.float32]]]:
    """Weights (inputs, outputs) and biases of each layer, copied."""
    linear = [layer for layer in network if hasattr(layer, "weight")]
    return [
        (np.ascontiguousarray(one.weight.detach().numpy().T).copy(), one.bias.detach().numpy().copy()) for one in linear
    ]
