"""Models as ONNX graphs: poses (n, 3, 4) in metres in, moments (n, 3) in newton metres out.

Normalisers and features are part of the graph. float64, so that it agrees with the NumPy forward pass to
rounding.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate.architecture import Architecture, Pooling
from surrogate.baselines import CHOICES, Polynomial
from surrogate.equivariant import EquivariantNetwork
from surrogate.fit import AnyModel
from surrogate.networks import PoseNetwork
from surrogate.onnx_helix import body_columns, helix_inverse, to_moments
from surrogate.onnx_nodes import Graph, Value, joined
from surrogate.whole_file import write_bytes

Floats = NDArray[np.float64]


def onnx_model(model: AnyModel) -> Any:
    """The graph as an `onnx.ModelProto`.

    Raises
    ------
    ModuleNotFoundError : without the package `onnx`. TypeError : radial basis functions, closed form.
    """
    graph = Graph()
    pose = Value(graph, "pose")
    if isinstance(model, PoseNetwork):
        x = (pose.shaped(-1, 12) - model.normaliser.mean) / model.normaliser.deviation
        return graph.model(_layers(model.architecture, model.weights, x) * model.moment_unit)
    if isinstance(model, EquivariantNetwork):
        v, _ = helix_inverse(body_columns(graph, pose, model.arm), model.arm.twist_ratio)
        return graph.model(to_moments(_with_residual(model, v), model.arm))
    if isinstance(model, Polynomial):
        columns = body_columns(graph, pose, model.arm)
        _, log = helix_inverse(columns, model.arm.twist_ratio)
        x = (joined([*columns[0::4], *log]) - model.normaliser.mean) / model.normaliser.deviation
        padded = joined([x.taken([0]) * 0.0 + 1.0, x])
        first, second, third = (padded.taken(CHOICES[:, k]) for k in range(3))
        v = first * second * third @ model.coefficients
        return graph.model(to_moments([v.taken([k]) for k in range(3)], model.arm))
    raise TypeError(f"models of the kind {type(model).__name__} have no graph")


def write_onnx(model: AnyModel, path: Path) -> None:
    """Write the graph to a file."""
    write_bytes(path, onnx_model(model).SerializeToString())


def _layers(architecture: Architecture, weights: list[tuple[Floats, Floats]], x: Value) -> Value:
    """`Architecture.forward`."""
    left, stages = iter(weights), architecture.stages
    for number, stage in enumerate(stages):
        if isinstance(stage.layer, Pooling):
            x = x.graph.node("ReduceMean", x.taken(stage.index), axes=[-1], keepdims=0)
            continue
        W, b = next(left)
        if len(stage.index) > 1:
            x = (x.taken(stage.index) @ W + b).shaped(-1, stage.index.shape[0] * W.shape[1])
        else:
            x = x @ W + b
        if number < len(stages) - 1:
            x = x.apply("Tanh")
    return x


def _with_residual(model: EquivariantNetwork, v: list[Value]) -> list[Value]:
    """v with what the network adds (equivariant.py)."""
    tau, y, z = v
    invariants = joined(
        [2.0 / model.largest[0] * (tau * tau) - 1.0, 2.0 / model.largest[1] * (y * y + z * z) - 1.0]
    )
    h = _layers(model.architecture, model.weights, invariants) * model.scale
    h_0, h_1, h_2 = (h.taken([k]) for k in range(3))
    return [tau * (1.0 + h_0), y * (1.0 + h_1) - tau * h_2 * z, z * (1.0 + h_1) + tau * h_2 * y]
