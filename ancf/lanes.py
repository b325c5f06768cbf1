r"""SIMD registers as numbers for numba: several samples side by side in one value.

A `Lanes` value holds the same quantity of W samples in one register (LLVM's <W x double>) and adds, subtracts
and multiplies like a float. A lane array is a C-contiguous float64 array (rows, W) seen as rows of such
values, so that kernels are written once, as for one sample:

    a = as_lanes(A, WIDTH)
    a[k] = a[i] * b[j] - c[k]

Written out, LLVM keeps all values of a 3 x 3 block in registers; its own loop vectoriser gives up on kernels
with index tables, because it cannot see that the arrays do not overlap. Products may be fused with sums
(FMA).

W is part of the *type*, carried by a tuple of W floats: numba's cache keys on types and does not see
constants of a module. Arrays must outlive their lane arrays, which hold bare pointers: pass them in as
arguments.
"""

from __future__ import annotations

import math
import operator
from typing import Any

from llvmlite import ir
from numba import extending
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.datamodel.registry import register_default
from numba.core.imputils import lower_builtin
from numba.core.typing import templates
from numba.core.typing.templates import AbstractTemplate, signature
from numba.np.arrayobj import make_array

FUSED = ("contract",)  # allows a * b + c in one instruction
DOUBLE = ir.DoubleType()

# Numba's own annotations do not say what these return.
intrinsic: Any = extending.intrinsic
infer_global: Any = templates.infer_global


class LanesType(types.Type):
    """Type of one register of `width` samples."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"lanes({width})")


class LaneArrayType(types.Type):
    """Type of a pointer to rows of `width` samples."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"lane_array({width})")


def _vector(width: int) -> ir.VectorType:
    return ir.VectorType(DOUBLE, width)


@register_default(LanesType)
class LanesModel(models.PrimitiveModel):
    """A register is an LLVM vector."""

    def __init__(self, dmm: Any, fe_type: LanesType) -> None:
        super().__init__(dmm, fe_type, _vector(fe_type.width))


@register_default(LaneArrayType)
class LaneArrayModel(models.PrimitiveModel):
    """A lane array is a pointer to its first number."""

    def __init__(self, dmm: Any, fe_type: LaneArrayType) -> None:
        super().__init__(dmm, fe_type, DOUBLE.as_pointer())


@intrinsic
def as_lanes(typing_context, array, width):
    """The rows of a C-contiguous float64 array (rows, W) as a lane array; `width` is a tuple of W floats."""
    target = LaneArrayType(width.count)

    def generate(context, builder, sig, args):
        return builder.bitcast(make_array(sig.args[0])(context, builder, args[0]).data, DOUBLE.as_pointer())

    return target(array, width), generate


def _arithmetic(function: Any, instruction: str) -> None:
    """Teach numba a binary operator between registers, and between a register and a float."""

    class _Template(AbstractTemplate):
        def generic(self, args, kws):
            if len(args) != 2 or not any(isinstance(a, LanesType) for a in args):
                return None
            lanes = args[0] if isinstance(args[0], LanesType) else args[1]
            if all(a == lanes or isinstance(a, types.Float) for a in args):
                return signature(lanes, *args)
            return None

    infer_global(function)(_Template)

    def lower(context, builder, sig, args):
        width = sig.return_type.width
        both = [
            a if isinstance(t, LanesType) else _splat(builder, a, width)
            for a, t in zip(args, sig.args, strict=True)
        ]
        return getattr(builder, instruction)(*both, flags=FUSED)

    for pair in ((LanesType, LanesType), (LanesType, types.Float), (types.Float, LanesType)):
        lower_builtin(function, *pair)(lower)


def _splat(builder: Any, number: Any, width: int) -> Any:
    """A register that holds one number in every lane."""
    first = builder.insert_element(
        ir.Constant(_vector(width), ir.Undefined), number, ir.Constant(ir.IntType(32), 0)
    )
    places = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
    return builder.shuffle_vector(first, ir.Constant(_vector(width), ir.Undefined), places)


for _function, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _arithmetic(_function, _instruction)


def _extremum(function: Any, comparison: str) -> None:
    """Teach numba `min` or `max` of two registers, lane by lane; the second where one is not a number."""

    class _Template(AbstractTemplate):
        def generic(self, args, kws):
            lanes = isinstance(args[0], LanesType) and args == (args[0], args[0])
            return signature(args[0], *args) if lanes else None

    infer_global(function)(_Template)

    def lower(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered(comparison, *args), *args)

    lower_builtin(function, LanesType, LanesType)(lower)


_extremum(min, "<")
_extremum(max, ">")


@infer_global(math.sqrt)
class _SquareRoot(AbstractTemplate):
    def generic(self, args, kws):
        return signature(args[0], *args) if isinstance(args[0], LanesType) else None


@lower_builtin(math.sqrt, LanesType)
def _lower_square_root(context, builder, sig, args):
    vector = _vector(sig.return_type.width)
    kind = ir.FunctionType(vector, [vector])
    name = f"llvm.sqrt.v{vector.count}f64"
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), args)


def rows_from(array, start):
    """The lane array that begins at a row of another."""
    return array[start:]


@infer_global(rows_from)
class _Rows(AbstractTemplate):
    def generic(self, args, kws):
        return signature(args[0], args[0], types.intp) if isinstance(args[0], LaneArrayType) else None


@lower_builtin(rows_from, LaneArrayType, types.Integer)
def _lower_rows(context, builder, sig, args):
    width = ir.Constant(args[1].type, sig.args[0].width)
    return builder.gep(args[0], [builder.mul(args[1], width)])


@infer_global(operator.getitem)
class _Read(AbstractTemplate):
    def generic(self, args, kws):
        if isinstance(args[0], LaneArrayType):
            return signature(LanesType(args[0].width), args[0], types.intp)
        return None


@infer_global(operator.setitem)
class _Write(AbstractTemplate):
    def generic(self, args, kws):
        if not isinstance(args[0], LaneArrayType):
            return None
        value = args[2] if isinstance(args[2], types.Float) else LanesType(args[0].width)
        return signature(types.none, args[0], types.intp, value)


def _row(builder: Any, array: Any, index: Any, width: int) -> Any:
    start = builder.gep(array, [builder.mul(index, ir.Constant(index.type, width))])
    return builder.bitcast(start, _vector(width).as_pointer())


@lower_builtin(operator.getitem, LaneArrayType, types.Integer)
def _lower_read(context, builder, sig, args):
    array, index = args
    return builder.load(_row(builder, array, index, sig.args[0].width), align=8)


@lower_builtin(operator.setitem, LaneArrayType, types.Integer, LanesType)
@lower_builtin(operator.setitem, LaneArrayType, types.Integer, types.Float)
def _lower_write(context, builder, sig, args):
    array, index, value = args
    width = sig.args[0].width
    if not isinstance(sig.args[2], LanesType):
        value = _splat(builder, value, width)
    builder.store(value, _row(builder, array, index, width), align=8)
    return context.get_dummy_value()
