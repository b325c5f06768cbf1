"""The CNN as an ONNX graph: poses (n, 3, 4) in metres in, moments (n, 3) in newton metres out.

The normaliser is part of the graph. float64, so that it agrees with the NumPy forward pass to rounding.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate.architecture import Pooling
from surrogate.networks import PoseNetwork

OPSET, IR_VERSION = 17, 9  # ReduceMean with its axes as an attribute; read by onnxruntime 1.16 and later


def onnx_model(network: PoseNetwork) -> Any:
    """The graph as an `onnx.ModelProto`; raises ModuleNotFoundError without the package `onnx`."""
    from onnx import TensorProto, checker, helper, numpy_helper  # pyright: ignore[reportMissingImports]

    nodes: list[Any] = []
    constants: list[Any] = []

    def constant(name: str, value: NDArray[Any]) -> str:
        constants.append(numpy_helper.from_array(np.ascontiguousarray(value), name))
        return name

    def node(kind: str, *given: str, **attributes: Any) -> str:
        name = f"{kind.lower()}{len(nodes)}"
        nodes.append(helper.make_node(kind, list(given), [name], **attributes))
        return name

    flat = constant("flat", np.array([-1, 12]))
    x = node("Reshape", "pose", flat)
    x = node("Sub", x, constant("mean", network.normaliser.mean))
    x = node("Div", x, constant("deviation", network.normaliser.deviation))
    weights, stages = iter(network.weights), network.architecture.stages
    for number, stage in enumerate(stages):
        if isinstance(stage.layer, Pooling):
            x = node("Gather", x, constant(f"pool{number}", stage.index.astype(np.int64)), axis=1)
            x = node("ReduceMean", x, axes=[-1], keepdims=0)
            continue
        W, b = next(weights)
        if len(stage.index) > 1:
            x = node("Gather", x, constant(f"patches{number}", stage.index.astype(np.int64)), axis=1)
        x = node("MatMul", x, constant(f"weight{number}", W))
        x = node("Add", x, constant(f"bias{number}", b))
        if len(stage.index) > 1:
            x = node(
                "Reshape", x, constant(f"shape{number}", np.array([-1, stage.index.shape[0] * W.shape[1]]))
            )
        if number < len(stages) - 1:
            x = node("Tanh", x)
    nodes.append(helper.make_node("Mul", [x, constant("unit", np.array(network.moment_unit))], ["moment"]))
    graph = helper.make_graph(
        nodes,
        "tip pose to tip moment",
        [helper.make_tensor_value_info("pose", TensorProto.DOUBLE, ["n", 3, 4])],
        [helper.make_tensor_value_info("moment", TensorProto.DOUBLE, ["n", 3])],
        constants,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], producer_name="ancf")
    model.ir_version = IR_VERSION
    checker.check_model(model)
    return model


def write_onnx(network: PoseNetwork, path: Path) -> None:
    """Write the graph to a file."""
    path.write_bytes(onnx_model(network).SerializeToString())
