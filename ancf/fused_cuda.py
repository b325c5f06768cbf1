r"""The fused kernel on a CUDA GPU (extra `cuda`): one sample a thread, the functions of the CPU kernel.

numba-cuda compiles the `njit` functions that a kernel calls for the device, from the same Python source; a
lane array is then the thread's own column (lane_column.py) of its warp's tile (rows, 32). Everything is
float64. Tables are copied to the device once a model.

Notes
-----
For 8 elements 3333 and sm_90, ptxas gives a thread 255 registers and spills 144 bytes; its 6591 rows of a
tile take 53 kB. Memory limits: a solve loads and stores 2.6 MB, of which a warp's share of an H100's L2 lets
1.6 MB through (benchmarks/gpu_traffic.py), so that 3.35 TB/s bound it by 2.1 million solves per second, 1.3
without any cache. Not measured yet: no GPU was at hand (benchmarks/bench_gpu.py). Arguments take 5152 bytes,
which needs a driver and tools of CUDA 12.1 or later.
"""

from __future__ import annotations

from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numba import cuda as numba_cuda
from numpy.typing import NDArray

from ancf.batch_rows import RowsResult
from ancf.fused import FEW, Found, problem_of, tables_of, turns
from ancf.fused_kernel import digest
from ancf.fused_lane import TILE, solve_lane, tile_arrays
from ancf.model import Model

Floats = NDArray[np.float64]

cuda: Any = numba_cuda  # its annotations do not describe kernels

# The kernel needs all 255 registers of a thread, so that 8 warps fill the register file of a multiprocessor.
RESIDENT = 8
# Fraction of the free memory that the tiles may take.
SHARE = 0.8


class Resident(NamedTuple):
    """What stays on the device: `fused.Tables` up to `at`, and the units of the coordinates."""

    unit: Any
    tables: tuple[Any, ...]


_resident: WeakKeyDictionary[Model, Resident] = WeakKeyDictionary()


def present() -> bool:
    """Whether there is a GPU with a driver."""
    return bool(cuda.is_available())


def kernel(problem, found, unit, mesh, elastic, projectors, loads, start, at, states, memories):
    """Solve every sample of a batch; a block is one warp, which owns one tile of `states` and `memories`."""
    solve_lane(
        cuda.blockIdx.x,
        cuda.threadIdx.x,
        cuda.gridDim.x,
        problem,
        found,
        unit,
        mesh,
        elastic,
        projectors,
        loads,
        start,
        at,
        states,
        memories,
    )


kernel.__qualname__ = f"kernel_{digest()}"  # names its file in numba's cache, as in fused_kernel.py
_compiled: Any = cuda.jit(cache=True)(kernel)


def solve_rows(
    model: Model,
    moments: Floats,
    forces: Floats,
    start: Floats | None = None,
    *,
    tolerance: float | None = None,
    max_iterations: int = 25,
) -> RowsResult:
    """Solve one rod under many loads, as `fused.solve_rows` with the same parameters.

    Raises the errors of numba-cuda where there is no GPU (`fused.no_gpu`) or no memory for a single tile.
    """
    rows, floor = len(moments), tables_of(model, FEW).floor
    with turns:
        unit, tables = _on_device(model)
        problem = _copied(problem_of(model, moments, forces, start, tolerance, floor, max_iterations))
        found: Any = Found(
            cuda.device_array((rows, model.n)),
            cuda.device_array(rows, np.bool_),
            cuda.device_array(rows),
            cuda.device_array(rows, np.int64),
        )
        if rows:
            tiles = _tiles(model, rows)
            states, memories = tile_arrays(tables_of(model, FEW), tiles, cuda.device_array)
            _compiled[tiles, TILE](problem, found, unit, *tables, states, memories)
        x, converged, residual, iterations = (array.copy_to_host() for array in found)
    return RowsResult(x, converged, residual, np.full(rows, floor), iterations)


def _tiles(model: Model, rows: int) -> int:
    """How many warps work at a time: as the rows need, the device keeps running, and its memory takes."""
    context = cuda.current_context()
    # Numba's simulator has no multiprocessors, and endless memory.
    resident = RESIDENT * getattr(context.device, "MULTIPROCESSOR_COUNT", 1)
    room = SHARE * context.get_memory_info().free / (8 * TILE * len(tables_of(model, FEW).memory))
    return max(1, int(min(-(-rows // TILE), resident, room)))


def _on_device(model: Model) -> Resident:
    if model not in _resident:
        tables = tables_of(model, FEW)
        parts = (tables.mesh, tables.elastic, tables.projectors, tables.loads, tables.start, tables.at)
        _resident[model] = Resident(cuda.to_device(model.unit), tuple(_copied(part) for part in parts))
    return _resident[model]


def _copied(record: Any) -> Any:
    """A record with its arrays copied to the device, in rows, so that all models are of the same types."""
    return type(record)(
        *(
            cuda.to_device(np.ascontiguousarray(value)) if isinstance(value, np.ndarray) else value
            for value in record
        )
    )
