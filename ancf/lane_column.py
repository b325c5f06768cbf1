r"""One lane of a lane array, as a thread of a GPU sees it: the same kernels, one sample a thread.

The rows of a C-contiguous array (rows, W) lie side by side in memory, so that W threads, each with its own
column, read whole cache lines together. W is part of the type, as in lanes.py: the distance from row to row
is then known when the kernel is compiled, and a 3 x 3 block is read with one address and nine offsets. (A
strided NumPy view would carry a stride and a length in registers and test every index for its sign.)

Called from Python, as by numba's simulator of CUDA, the same names give NumPy views.
"""

from __future__ import annotations

import operator

from llvmlite import ir
from numba.core import types
from numba.core.datamodel import models
from numba.core.datamodel.registry import register_default
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, signature
from numba.np.arrayobj import make_array

from ancf.lanes import DOUBLE, infer_global, rows_from


class LaneColumnType(types.Type):
    """Type of a pointer to one of `width` columns."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"lane_column({width})")


@register_default(LaneColumnType)
class LaneColumnModel(models.PrimitiveModel):
    """A lane column is a pointer to its first number."""

    def __init__(self, dmm, fe_type: LaneColumnType) -> None:
        super().__init__(dmm, fe_type, DOUBLE.as_pointer())


def as_column(array, lane, width):
    """One column of a C-contiguous float64 array (rows, W); `width` is a tuple of W floats."""
    return array[:, lane]


@infer_global(as_column)
class _Column(AbstractTemplate):
    def generic(self, args, kws):
        return signature(LaneColumnType(args[2].count), args[0], types.intp, args[2])


@lower_builtin(as_column, types.Array, types.Integer, types.UniTuple)
def _lower_column(context, builder, sig, args):
    data = make_array(sig.args[0])(context, builder, args[0]).data
    return builder.gep(builder.bitcast(data, DOUBLE.as_pointer()), [args[1]])


@infer_global(rows_from)
class _Rows(AbstractTemplate):
    def generic(self, args, kws):
        return signature(args[0], args[0], types.intp) if isinstance(args[0], LaneColumnType) else None


@infer_global(operator.getitem)
class _Read(AbstractTemplate):
    def generic(self, args, kws):
        return signature(types.float64, args[0], types.intp) if isinstance(args[0], LaneColumnType) else None


@infer_global(operator.setitem)
class _Write(AbstractTemplate):
    def generic(self, args, kws):
        if not isinstance(args[0], LaneColumnType):
            return None
        return signature(types.none, args[0], types.intp, types.float64)


@lower_builtin(rows_from, LaneColumnType, types.Integer)
def _lower_row(context, builder, sig, args):
    column, row = args
    return builder.gep(column, [builder.mul(row, ir.Constant(row.type, sig.args[0].width))])


@lower_builtin(operator.getitem, LaneColumnType, types.Integer)
def _lower_read(context, builder, sig, args):
    return builder.load(_lower_row(context, builder, sig, args), align=8)


@lower_builtin(operator.setitem, LaneColumnType, types.Integer, types.Float)
def _lower_write(context, builder, sig, args):
    builder.store(args[2], _lower_row(context, builder, sig, args[:2]), align=8)
    return context.get_dummy_value()
