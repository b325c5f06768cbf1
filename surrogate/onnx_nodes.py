"""Arithmetic that writes itself down as ONNX nodes, in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

OPSET, IR_VERSION = 17, 9  # read by onnxruntime 1.16 and later


class Graph:
    """Nodes and constants of a graph from poses to moments."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def constant(self, value: Any) -> Value:
        """A constant; floats are float64."""
        from onnx import numpy_helper  # pyright: ignore[reportMissingImports]

        name = f"constant{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.asarray(value), name))
        return Value(self, name)

    def node(self, kind: str, *given: Value, **attributes: Any) -> Value:
        """The value of an ONNX operator."""
        from onnx import helper  # pyright: ignore[reportMissingImports]

        name = f"{kind.lower()}{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, [v.name for v in given], [name], **attributes))
        return Value(self, name)

    def model(self, result: Value) -> Any:
        """The checked `onnx.ModelProto`: input `pose` (n, 3, 4), output `moment` (n, 3)."""
        from onnx import TensorProto, checker, helper  # pyright: ignore[reportMissingImports]

        nodes = [*self.nodes, helper.make_node("Identity", [result.name], ["moment"])]
        graph = helper.make_graph(
            nodes,
            "tip pose to tip moment",
            [helper.make_tensor_value_info("pose", TensorProto.DOUBLE, ["n", 3, 4])],
            [helper.make_tensor_value_info("moment", TensorProto.DOUBLE, ["n", 3])],
            self.constants,
        )
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], producer_name="ancf")
        model.ir_version = IR_VERSION
        checker.check_model(model)
        return model


class Value:
    """A tensor of a graph; plain numbers and arrays become constants."""

    __array_ufunc__ = None  # arrays leave their products with it to it

    def __init__(self, graph: Graph, name: str) -> None:
        self.graph = graph
        self.name = name

    def _with(self, kind: str, other: Any, swapped: bool = False) -> Value:
        if not isinstance(other, Value):
            other = self.graph.constant(np.asarray(other, dtype=float))
        return self.graph.node(kind, *((other, self) if swapped else (self, other)))

    def __add__(self, other: Any) -> Value:
        return self._with("Add", other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Value:
        return self._with("Sub", other)

    def __rsub__(self, other: Any) -> Value:
        return self._with("Sub", other, swapped=True)

    def __mul__(self, other: Any) -> Value:
        return self._with("Mul", other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Value:
        return self._with("Div", other)

    def __rtruediv__(self, other: Any) -> Value:
        return self._with("Div", other, swapped=True)

    def __matmul__(self, other: Any) -> Value:
        return self._with("MatMul", other)

    def __rmatmul__(self, other: Any) -> Value:
        return self._with("MatMul", other, swapped=True)

    def at_least(self, other: Any) -> Value:
        """The larger of two."""
        return self._with("Max", other)

    def at_most(self, other: Any) -> Value:
        """The smaller of two."""
        return self._with("Min", other)

    def less_than(self, other: Any) -> Value:
        """Where it is less, as booleans."""
        return self._with("Less", other)

    def where(self, yes: Value, no: Value) -> Value:
        """Of booleans: one value or another."""
        return self.graph.node("Where", self, yes, no)

    def apply(self, kind: str) -> Value:
        """An operator of one tensor: Sin, Cos, Sqrt, Abs, Tanh."""
        return self.graph.node(kind, self)

    def taken(self, places: NDArray[Any] | list[int]) -> Value:
        """Columns (n, ..) by number."""
        index = self.graph.constant(np.asarray(places, dtype=np.int64))
        return self.graph.node("Gather", self, index, axis=1)

    def shaped(self, *shape: int) -> Value:
        """The same numbers in another shape."""
        return self.graph.node("Reshape", self, self.graph.constant(np.array(shape, dtype=np.int64)))


def joined(values: list[Value]) -> Value:
    """Columns side by side."""
    return values[0].graph.node("Concat", *values, axis=1)


def arctan2(y: Value, x: Value) -> Value:
    """atan2 in float64, which ONNX and onnxruntime have in float32 only.

    2 atan(y/(h + |x|)) in float32, and twice b + sin(angle - b), which cubes the error.
    """
    from onnx import TensorProto  # pyright: ignore[reportMissingImports]

    h, across = (x * x + y * y).apply("Sqrt"), x.apply("Abs")
    ratio = (y / (h + across)).graph.node("Cast", y / (h + across), to=TensorProto.FLOAT)
    b = 2.0 * y.graph.node("Cast", ratio.apply("Atan"), to=TensorProto.DOUBLE)
    for _ in range(2):
        b = b + (y * b.apply("Cos") - across * b.apply("Sin")) / h
    half_turn = y.less_than(0.0).where(y.graph.constant(-np.pi), y.graph.constant(np.pi))
    return x.less_than(0.0).where(half_turn - b, b)
