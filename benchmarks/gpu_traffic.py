"""Memory that one solve on a GPU moves, counted by running its thread as Python (no GPU needed).

    python benchmarks/gpu_traffic.py

Issue 5's rod and moments. The bound is that of an H100's memory, 3.35 TB/s, if the kernel reached it; a cache
is modelled as one that drops what was not used for longest, with a warp's share of the chip's 50 MB: 47 kB,
or 184 rows of a tile.
"""

from __future__ import annotations

import os

os.environ["NUMBA_DISABLE_JIT"] = "1"

from collections import OrderedDict
from collections.abc import Sequence

import bench_batch
import numpy as np

from ancf import fused, fused_lane

SAMPLES = 8
BANDWIDTH = 3.35e12  # byte/s
CACHES = (1, 184)  # rows
ROW = 8  # bytes a lane


class CountedColumn:
    """A lane column that notes every access: the row of a load, ~row of a store."""

    def __init__(self, column: bench_batch.Floats, noted: list[int], first: int = 0) -> None:
        self.column, self.noted, self.first = column, noted, first

    def __getitem__(self, at):
        if isinstance(at, slice):
            return CountedColumn(self.column, self.noted, self.first + at.start)
        self.noted.append(self.first + at)
        return self.column[self.first + at]

    def __setitem__(self, at, value):
        self.noted.append(~(self.first + at))
        self.column[self.first + at] = value


def accesses() -> list[int]:
    """Rows that a thread loads and stores in SAMPLES solves."""
    model = bench_batch.moment_model(40.0, 0.3)
    tables = fused.tables_of(model, fused.FEW)
    moments = bench_batch.sample_moments(model)[:SAMPLES]
    problem = fused.problem_of(model, moments, np.empty((SAMPLES, 0, 3)), None, None, tables.floor, 25)
    found = fused.Found(
        np.empty((SAMPLES, model.n)), np.zeros(SAMPLES, bool), np.empty(SAMPLES), np.zeros(SAMPLES, np.int64)
    )
    noted: list[int] = []
    states, memories = fused_lane.tile_arrays(tables, 1, np.zeros)
    fused_lane.TILE = 1  # this lane takes every sample
    fused_lane.as_column = lambda memory, lane, width: CountedColumn(memory[:, lane], noted)
    fused_lane.solve_lane(0, 0, 1, problem, found, model.unit, *tables[:6], states, memories)
    assert found.converged.all()
    return noted


def beyond_cache(noted: Sequence[int], rows: int) -> int:
    """Loads that miss a cache of so many rows, and stored rows that it has to give up."""
    cached: OrderedDict[int, bool] = OrderedDict()
    moved = 0
    for access in noted:
        stores = access < 0
        row = ~access if stores else access
        moved += row not in cached and not stores
        cached[row] = cached.get(row, False) or stores
        cached.move_to_end(row)
        if len(cached) > rows:
            moved += cached.popitem(last=False)[1]
    return moved


def main() -> None:
    """Print the bounds."""
    with np.errstate(all="ignore"):
        noted = accesses()
    print(f"{len(noted) / SAMPLES:.0f} loads and stores a solve, {ROW * len(noted) / SAMPLES / 1e6:.2f} MB")
    for rows in CACHES:
        size = ROW * beyond_cache(noted, rows) / SAMPLES
        print(f"cache of {rows:3d} rows: {size / 1e6:.2f} MB, {BANDWIDTH / size / 1e6:.1f} million solves/s")


if __name__ == "__main__":
    main()
