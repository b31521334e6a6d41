"""A trained policy in plain numbers: used without PyTorch, with bits that do not depend on the size of the batch.

It computes in double precision, and the result is rounded to single precision once. So the order in which sums are
taken hardly shows: an ONNX file of the same numbers gives the same actions but for the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numba
import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Array = NDArray[np.float64]


def _relu(x: Array) -> Array:
    return np.maximum(x, 0.0)


def _elu(x: Array) -> Array:
    return np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0)))


ACTIVATIONS: Final[Mapping[str, Callable[[Array], Array]]] = {"tanh": np.tanh, "relu": _relu, "elu": _elu}
MODULES: Final = {"Tanh": "tanh", "ReLU": "relu", "ELU": "elu"}  # what PyTorch calls them


@dataclass(frozen=True)
class Network:
    """The mean of the policy: a perceptron.

    Attributes:
        weights: For each layer (inputs, outputs).
        biases: For each layer (outputs,).
        activation: Key of `ACTIVATIONS`, of the hidden layers.
        squash: Whether the outputs pass a tanh, as those of SAC and TQC do.
    """

    weights: tuple[Float32, ...]
    biases: tuple[Float32, ...]
    activation: str
    squash: bool = False

    def __call__(self, inputs: Float32) -> Float32:
        """Outputs (n, outputs) for inputs (n, inputs)."""
        *hidden, last = self._layers
        x = np.ascontiguousarray(inputs, dtype=np.float64)
        for weight, bias in hidden:
            x = ACTIVATIONS[self.activation](_affine(x, weight, bias))
        outputs = _affine(x, *last)
        return np.asarray(np.tanh(outputs) if self.squash else outputs, dtype=np.float32)

    @cached_property
    def _layers(self) -> list[tuple[Array, Array]]:
        """Weights and biases of each layer in double precision."""
        return [
            (np.ascontiguousarray(weight, dtype=np.float64), np.ascontiguousarray(bias, dtype=np.float64))
            for weight, bias in zip(self.weights, self.biases, strict=True)
        ]

    @property
    def sizes(self) -> list[int]:
        """Units of each layer, inputs first."""
        return [weight.shape[0] for weight in self.weights] + [self.biases[-1].size]

    def arrays(self) -> dict[str, Float32]:
        """All numbers by name, for an npz file."""
        named = {f"weight_{k}": w for k, w in enumerate(self.weights)}
        return named | {f"bias_{k}": b for k, b in enumerate(self.biases)}

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, Any], activation: str, squash: bool = False) -> Network:
        """The inverse of `arrays`.

        Raises:
            ValueError: The arrays do not follow each other as the layers of a perceptron do.
        """
        layers = range(sum(name.startswith("weight_") for name in arrays))
        weights = tuple(np.asarray(arrays[f"weight_{k}"], dtype=np.float32) for k in layers)
        biases = tuple(np.asarray(arrays[f"bias_{k}"], dtype=np.float32) for k in layers)
        shapes = [weight.shape for weight in weights]
        ends = [shape[1:] for shape in shapes]
        if not shapes or ends != [bias.shape for bias in biases] or ends[:-1] != [shape[:1] for shape in shapes[1:]]:
            raise ValueError(f"weights of the shapes {shapes} are no perceptron")
        return cls(weights, biases, activation, squash)


@numba.njit(nogil=True)
def _affine(x: Array, weight: Array, bias: Array) -> Array:
    """``x @ weight + bias``, summed input by input in this order, each product rounded before it is added.

    A matrix product's bits would depend on the number of rows and on the processor. Compiled without fast-math, this
    has the bits of ``total += x[:, k : k + 1] * weight[k]`` in NumPy, which takes a hundred times as long.
    """
    total = np.empty((x.shape[0], weight.shape[1]))
    for row in range(x.shape[0]):
        for j in range(weight.shape[1]):
            total[row, j] = bias[j]
        for k in range(weight.shape[0]):
            value = x[row, k]
            for j in range(weight.shape[1]):
                total[row, j] += value * weight[k, j]
    return total


def policy_network(policy: Any) -> Network:
    """The mean of a Stable-Baselines3 policy: of an actor-critic (PPO), or of SAC's or TQC's actor.

    Args:
        policy: A policy with a perceptron and no features of its own.

    Raises:
        ValueError: It is of another kind.
    """
    hidden, head, squash = _parts(policy)
    layers: Sequence[Any] = [*(layer for layer in hidden if hasattr(layer, "weight")), head]
    used = {type(layer).__name__ for layer in hidden if not hasattr(layer, "weight")}
    if len(used) > 1 or not used <= set(MODULES):
        raise ValueError(f"hidden layers with {', '.join(sorted(used))}: one of {', '.join(MODULES)} is known")
    weights = tuple(np.ascontiguousarray(layer.weight.detach().cpu().numpy().T) for layer in layers)
    biases = tuple(layer.bias.detach().cpu().numpy().copy() for layer in layers)
    return Network(weights, biases, MODULES[used.pop()] if used else "tanh", squash)


def take_last_layer(policy: Any, network: Network) -> None:
    """Give a Stable-Baselines3 policy the last layer of a network that `policy_network` has made from it."""
    import torch

    _, head, _ = _parts(policy)
    with torch.no_grad():
        head.weight.copy_(torch.from_numpy(np.ascontiguousarray(network.weights[-1].T)))
        head.bias.copy_(torch.from_numpy(network.biases[-1]))


def _parts(policy: Any) -> tuple[Any, Any, bool]:
    """Hidden layers and last layer of a policy's mean, and whether a tanh follows.

    Raises:
        ValueError: The policy is of a kind that is not known here.
    """
    actor: Any = getattr(policy, "actor", None) or policy
    if getattr(actor, "use_sde", False):
        raise ValueError("exploration that depends on the state (use_sde) is not known here")
    if hasattr(actor, "mlp_extractor"):
        return actor.mlp_extractor.policy_net, actor.action_net, False
    if hasattr(actor, "latent_pi"):
        return actor.latent_pi, actor.mu, True
    raise ValueError(f"{type(policy).__name__} holds no perceptron that is known here")
