"""A trained agent as an ONNX file (extra ``onnx``): one graph from the environment's observation to its action.

The graph is written from the agent's plain numbers, without PyTorch. It holds the frozen normaliser, the network, and
the bound of the action, so whoever runs it needs no code of this package: put in ``observation`` (n, k) as the
environment gives it, take out ``action`` (n, 2), both in single precision. Inside, weights are kept in single and sums
are taken in double precision, as in `ssmash_gym.training.network`. The file's metadata say what the numbers are.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import ssmash_gym
from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.files import whole_file
from ssmash_gym.training.agent import Agent, inputs
from ssmash_gym.training.normaliser import EPSILON, Normaliser

OPSET: Final = 17  # and the format of the file: old enough for runtimes of the last years
FILE_FORMAT: Final = 8
INPUT: Final = "observation"
OUTPUT: Final = "action"
TOLERANCE: Final = 1e-6  # of an action, by rounding in another order of summation


def require_onnx(*libraries: str) -> None:
    """Check that the libraries for ONNX files are there.

    Args:
        libraries: Which; ``onnx`` and ``onnxruntime`` when none is named.

    Raises:
        ImportError: One is missing; the sentence names the extra.
    """
    for name in libraries or ("onnx", "onnxruntime"):
        require(name, f'ONNX files need {name}, which is not installed: pip install "ssmash_gym[onnx]".')


def export_onnx(agent: Agent, path: Path) -> None:
    """Write an agent's ONNX file, whole or not at all.

    Raises:
        ImportError: The extra ``onnx`` is missing.
    """
    require_onnx("onnx")
    import onnx

    model = onnx_model(agent)
    onnx.checker.check_model(model, full_check=True)
    with whole_file(path) as temporary:
        temporary.write_bytes(model.SerializeToString())


def onnx_model(agent: Agent) -> Any:
    """The agent as an ``onnx.ModelProto``."""
    from onnx import TensorProto, helper

    graph = _Graph(INPUT)
    graph.add("Cast", "wide", to=TensorProto.DOUBLE)
    _normalise(graph, agent.normaliser)
    network = agent.network
    last = len(network.weights) - 1
    for k, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
        graph.add("Gemm", f"layer_{k}", {f"weight_{k}": weight, f"bias_{k}": bias})
        if k < last:
            _activate(graph, network.activation, f"hidden_{k}")
    if network.squash:
        graph.add("Tanh", "squashed")
    graph.add("Clip", "bounded", {"lowest": -1.0, "highest": 1.0})
    graph.add("Cast", OUTPUT, to=TensorProto.FLOAT)
    sizes = network.sizes
    made = helper.make_graph(
        graph.nodes,
        agent.name,
        [helper.make_tensor_value_info(INPUT, TensorProto.FLOAT, ["n", sizes[0]])],
        [helper.make_tensor_value_info(OUTPUT, TensorProto.FLOAT, ["n", sizes[-1]])],
        graph.numbers,
    )
    model = helper.make_model(
        made,
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=FILE_FORMAT,
        producer_name="ssmash_gym",
        producer_version=ssmash_gym.__version__,
        doc_string=f"{agent.training.description} A research model on assumed numbers. Not for use on a ship.".strip(),
    )
    helper.set_model_props(model, metadata(agent))
    return model


class _Graph:
    """A chain of nodes in double precision, each fed with the output of the one before, and the numbers they hold.

    Args:
        start: Name of the graph's input.

    Attributes:
        nodes, numbers: For ``onnx.helper.make_graph``.
        end: Name of the chain's last output.
    """

    def __init__(self, start: str) -> None:
        self.nodes: list[Any] = []
        self.numbers: list[Any] = []
        self.end = start

    def add(self, operator: str, name: str, numbers: Mapping[str, Any] | None = None, **attributes: Any) -> None:
        """Append a node that makes `name`, with `numbers` as its further inputs; arrays of float32 stay such."""
        from onnx import helper

        further = [self.hold(key, value) for key, value in (numbers or {}).items()]
        self.nodes.append(helper.make_node(operator, [self.end, *further], [name], name=name, **attributes))
        self.end = name

    def hold(self, name: str, value: Any) -> str:
        """Keep a number or an array in the file; returns its name in double precision."""
        from onnx import TensorProto, helper, numpy_helper

        array = np.asarray(value)
        self.numbers.append(numpy_helper.from_array(array, name))
        if array.dtype == np.float64:
            return name
        wide = f"{name}_wide"
        self.nodes.append(helper.make_node("Cast", [name], [wide], name=wide, to=TensorProto.DOUBLE))
        return wide


def _normalise(graph: _Graph, normaliser: Normaliser) -> None:
    """The normaliser's arithmetic; what the policy sees is rounded to single precision, as there."""
    from onnx import TensorProto

    if normaliser.observation is None:
        return
    moments = normaliser.observation
    graph.add("Sub", "shifted", {"mean": np.array(moments.mean)})
    graph.add("Div", "scaled", {"deviation": np.sqrt(np.array(moments.variance) + EPSILON)})
    graph.add("Clip", "clipped", {"least": -normaliser.clip, "greatest": normaliser.clip})
    graph.add("Cast", "normalised", to=TensorProto.FLOAT)
    graph.add("Cast", "normalised_wide", to=TensorProto.DOUBLE)


def _activate(graph: _Graph, activation: str, name: str) -> None:
    """The hidden layers' activation; runtimes know ``Elu`` in single precision only, so it is put together."""
    if activation != "elu":
        graph.add({"tanh": "Tanh", "relu": "Relu"}[activation], name)
        return
    from onnx import helper

    start = graph.end
    graph.add("Min", f"{name}_low", {f"{name}_zero": 0.0})
    graph.add("Exp", f"{name}_exp")
    graph.add("Sub", f"{name}_below", {f"{name}_one": 1.0})
    low = graph.end
    graph.nodes.append(helper.make_node("Relu", [start], [f"{name}_above"], name=f"{name}_above"))
    graph.nodes.append(helper.make_node("Add", [low, f"{name}_above"], [name], name=name))
    graph.end = name


def metadata(agent: Agent) -> dict[str, str]:
    """What the file says about itself, as texts; lists and mappings as JSON."""
    task, claw = agent.task, agent.task.claw
    told: dict[str, Any] = {
        "name": agent.name,
        "description": agent.training.description,
        "observation": inputs(task),
        "observation_clip": task.observation_clip,
        "action": [
            {"name": "along", "unit": "m/s", "scale": claw.speed_along_m_s},
            {"name": "across", "unit": "m/s", "scale": claw.speed_across_m_s},
        ],
        "residual": None if task.residual is None else task.residual.model_dump(mode="json"),
        "control_interval_s": task.control_interval_s,
        "version": str(agent.about.get("versions", {}).get("ssmash_gym", ssmash_gym.__version__)),
        "configuration": str(agent.about.get("configuration", "")),
        "seed": agent.training.seed,
    }
    return {key: value if isinstance(value, str) else json.dumps(value) for key, value in told.items()}


def run_onnx(path: Path, observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Actions (n, 2) that an ONNX file gives for observations (n, k), on one thread of the processor.

    Raises:
        ImportError: The extra ``onnx`` is missing.
    """
    require_onnx("onnxruntime")
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])
    (actions,) = session.run([OUTPUT], {INPUT: observations})
    return np.asarray(actions)


def check_onnx(agent: Agent, path: Path, observations: Sequence[NDArray[np.float32]]) -> float:
    """Compare an ONNX file with its agent.

    Args:
        agent: The agent that it was made of.
        path: The file.
        observations: Batches (n, k) to try.

    Returns:
        The largest difference of an action.

    Raises:
        ConfigurationError: It is larger than `TOLERANCE`.
    """
    worst = max(float(np.max(np.abs(run_onnx(path, batch) - agent.act(batch)))) for batch in observations)
    if worst > TOLERANCE:
        raise ConfigurationError(f"{path}: the ONNX file's actions differ from the agent's by {worst:.1e}.")
    return worst
