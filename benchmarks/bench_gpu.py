"""What the fused kernel does on a GPU: issue 5's rod and moments, in batches of several sizes.

    OPENBLAS_NUM_THREADS=1 python benchmarks/bench_gpu.py

Asked: 500 000 solves per second on one data-centre GPU, better 2 million, batch size stated. Wall time, by
the median of five calls, of the kernel's `solve_rows` (copies to and from the device included) and of
`solve_batch` around it. Skipped where there is no GPU.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import bench_batch
import numpy as np
import pytest

import ancf
from ancf import fused

# The tiles of an H100 (132 multiprocessors, 8 warps each) have 33 792 lanes.
BATCHES = (1520, 33_792, 135_168, 540_672)


def moments_of(model: ancf.model.Model, rows: int) -> bench_batch.Floats:
    """Moments (rows, 1, 3) [N m]: those of bench_batch.py again and again."""
    return np.resize(bench_batch.sample_moments(model), (rows, 1, 3))


def solve(model: ancf.model.Model, moments: bench_batch.Floats) -> None:
    """One batch; none may be lost."""
    from ancf.fused_cuda import solve_rows

    assert solve_rows(model, moments, np.empty((len(moments), 0, 3))).converged.all()


@pytest.mark.skipif(bool(fused.no_gpu()), reason=fused.no_gpu())
@pytest.mark.parametrize("rows", BATCHES)
def bench_tip_moments(benchmark, rows):
    """8 elements 3333, L/R = 40."""
    model = bench_batch.moment_model(40.0, 0.3)
    moments = moments_of(model, rows)
    benchmark.pedantic(solve, (model, moments), rounds=5, warmup_rounds=1)
    benchmark.extra_info["solves per second"] = rows / benchmark.stats.stats.median


def wall_seconds(call: Callable[[], object], repeats: int = 5) -> float:
    """Median wall time of a call [s]."""
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        call()
        times.append(time.perf_counter() - started)
    return statistics.median(times)


def main() -> None:
    """Print the table."""
    if reason := fused.no_gpu():
        print(f"Skipped: {reason}")
        return
    from ancf.fused_cuda import cuda

    print(cuda.get_current_device().name)
    model = bench_batch.moment_model(40.0, 0.3)
    started = time.perf_counter()
    solve(model, moments_of(model, 1))
    print(f"first call, compiling or from the cache: {time.perf_counter() - started:.1f} s")
    print("   batch   solves/s   of solve_batch")
    for rows in BATCHES:
        moments = moments_of(model, rows)
        kernel = wall_seconds(lambda moments=moments: solve(model, moments))
        whole = wall_seconds(
            lambda moments=moments: ancf.solve_batch(model.scene, moments[:, 0], engine="cuda")
        )
        print(f"{rows:8d} {rows / kernel:10.0f} {rows / whole:16.0f}")


if __name__ == "__main__":
    main()
