"""A trained policy in plain NumPy: used without PyTorch, with bits that do not depend on the size of the batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]


def _relu(x: Float32) -> Float32:
    return np.maximum(x, np.float32(0.0))


def _elu(x: Float32) -> Float32:
    return np.asarray(np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0))), dtype=np.float32)


ACTIVATIONS: Final[Mapping[str, Callable[[Float32], Float32]]] = {"tanh": np.tanh, "relu": _relu, "elu": _elu}


@dataclass(frozen=True)
class Network:
    """The mean of the policy: a perceptron.

    Attributes:
        weights: For each layer (inputs, outputs).
        biases: For each layer (outputs,).
        activation: Key of `ACTIVATIONS`, of the hidden layers.
    """

    weights: tuple[Float32, ...]
    biases: tuple[Float32, ...]
    activation: str

    def __call__(self, inputs: Float32) -> Float32:
        """Outputs (n, outputs) for inputs (n, inputs)."""
        x = inputs
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            x = ACTIVATIONS[self.activation](_affine(x, weight, bias))
        return _affine(x, self.weights[-1], self.biases[-1])

    def arrays(self) -> dict[str, Float32]:
        """All numbers by name, for an npz file."""
        named = {f"weight_{k}": w for k, w in enumerate(self.weights)}
        return named | {f"bias_{k}": b for k, b in enumerate(self.biases)}

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, Any], activation: str) -> Network:
        """The inverse of `arrays`."""
        layers = range(sum(name.startswith("weight_") for name in arrays))
        weights = tuple(np.asarray(arrays[f"weight_{k}"], dtype=np.float32) for k in layers)
        biases = tuple(np.asarray(arrays[f"bias_{k}"], dtype=np.float32) for k in layers)
        return cls(weights, biases, activation)


def _affine(x: Float32, weight: Float32, bias: Float32) -> Float32:
    """``x @ weight + bias``, summed input by input: a matrix product's bits would depend on the number of rows."""
    total = np.broadcast_to(bias, (x.shape[0], bias.size)).astype(np.float32)
    for k in range(weight.shape[0]):
        total += x[:, k : k + 1] * weight[k]
    return total


def policy_network(policy: Any, activation: str) -> Network:
    """The mean of a Stable-Baselines3 actor-critic policy.

    Args:
        policy: An `ActorCriticPolicy` with a perceptron.
        activation: Name of its activation.
    """
    hidden: Sequence[Any] = [layer for layer in policy.mlp_extractor.policy_net if hasattr(layer, "weight")]
    layers = [*hidden, policy.action_net]
    weights = tuple(np.ascontiguousarray(layer.weight.detach().cpu().numpy().T) for layer in layers)
    biases = tuple(layer.bias.detach().cpu().numpy().copy() for layer in layers)
    return Network(weights, biases, activation)
