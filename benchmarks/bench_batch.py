"""What the fused kernel costs: the batch of issue 5, one row, threads, compiling.

    OPENBLAS_NUM_THREADS=1 python benchmarks/bench_batch.py

1520 spatial tip moments (|M_x| <= 0.8, |M_y|, |M_z| <= 3 E I/L) on a straight round rod of 8 elements 3333,
cold. Times are CPU times of one core, medians of several runs; tip errors are against 64 elements, in
lengths.
"""

from __future__ import annotations

import os
import platform
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf import fused
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Force, Moment, Rod, Scene
from ancf.sections import Circle

Floats = NDArray[np.float64]

SAMPLES = 1520
LARGEST = np.array([0.8, 3.0, 3.0])  # E I/L
FINE = 64


def rod(slenderness: float, poisson_ratio: float, elements: int) -> Rod:
    """Straight round rod of length 1 m."""
    law = SaintVenantKirchhoff(1e6, poisson_ratio)
    return Rod("rod", 1.0, elements, Circle(1.0 / slenderness), law)


def moment_model(slenderness: float, poisson_ratio: float, elements: int = 8) -> Model:
    """The rod under a tip moment."""
    load = Moment("rod", 1.0, np.array([0.0, 0.0, 1.0]))
    return Model(Scene((rod(slenderness, poisson_ratio, elements),), moments=(load,)))


def sample_moments(model: Model, seed: int = 0) -> Floats:
    """Moments (SAMPLES, 1, 3) [N m]."""
    unit = model.rods[0].bending_stiffness / model.rods[0].rod.length
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (SAMPLES, 1, 3)) * LARGEST * unit


def cpu_seconds(call: Callable[[], object], repeats: int = 5) -> float:
    """Median CPU time of a call [s]."""
    times = []
    for _ in range(repeats):
        started = time.process_time()
        call()
        times.append(time.process_time() - started)
    return statistics.median(times)


def tip_positions(model: Model, q: Floats) -> Floats:
    """Positions (B, 3) of the free end."""
    return q.reshape(len(q), -1, len(model.rods[0].element.vectors), 3)[:, -1, 0]


def batch_row(slenderness: float, poisson_ratio: float) -> str:
    """One line of the table."""
    model, fine = (moment_model(slenderness, poisson_ratio, n) for n in (8, FINE))
    moments, none = sample_moments(model), np.empty((SAMPLES, 0, 3))
    found = fused.solve_rows(model, moments, none)
    best = fused.solve_rows(fine, moments, none)
    both = found.converged & best.converged
    error = np.linalg.norm(tip_positions(model, found.q) - tip_positions(fine, best.q), axis=1)[both]
    seconds = cpu_seconds(lambda: fused.solve_rows(model, moments, none))
    return (
        f"{slenderness:6g} {poisson_ratio:6g} {SAMPLES / seconds:10.0f} {np.mean(found.iterations):10.2f}"
        f" {np.count_nonzero(~found.converged):6d} {np.median(error):12.1e} {np.max(error):10.1e}"
    )


def threaded(workers: int) -> float:
    """Solves per second of wall time by several threads, each with its own model."""
    models = [moment_model(40.0, 0.3) for _ in range(workers)]
    moments, none = sample_moments(models[0]), np.empty((SAMPLES, 0, 3))

    def work(model: Model) -> None:
        for _ in range(5):
            fused.solve_rows(model, moments, none)

    for model in models:
        fused.solve_rows(model, moments, none)
    threads = [threading.Thread(target=work, args=(model,)) for model in models]
    started = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return 5 * workers * SAMPLES / (time.perf_counter() - started)


def first_call_seconds(rows: int, cache: str) -> float:
    """CPU time [s] of the first call in a new process, less that of the second: compiling, or loading."""
    code = (
        "import sys, time, bench_batch as b, numpy as np\n"
        "from ancf import fused\n"
        "rows = int(sys.argv[1]); model = b.moment_model(40.0, 0.3)\n"
        "call = lambda: fused.solve_rows(model, b.sample_moments(model)[:rows], np.empty((rows, 0, 3)))\n"
        "times = [time.process_time()]\n"
        "for _ in range(2): call(); times.append(time.process_time())\n"
        "print(times[1] - times[0] - (times[2] - times[1]))\n"
    )
    here = Path(__file__).parent
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": cache,
        "PYTHONPATH": os.pathsep.join(map(str, [here, here.parent])),
    }
    output = subprocess.run(
        [sys.executable, "-c", code, str(rows)], env=environment, capture_output=True, text=True, check=True
    )
    return float(output.stdout)


def one_row_seconds(repeats: int = 500) -> float:
    """CPU time [s] of a call with one row that bends the rod by 90 degrees, warm."""
    model = moment_model(40.0, 0.3)
    moment = np.array([[[0.0, 0.0, 0.5 * np.pi]]]) * model.rods[0].bending_stiffness
    none = np.empty((1, 0, 3))
    fused.solve_rows(model, moment, none)
    return cpu_seconds(lambda: [fused.solve_rows(model, moment, none) for _ in range(repeats)]) / repeats


def readable_seconds(repeats: int = 20) -> float:
    """CPU time [s] of `ancf.solve` on the same rod and moment."""
    model = moment_model(40.0, 0.3)
    value = np.array([0.0, 0.0, 0.5 * np.pi]) * model.rods[0].bending_stiffness
    scene = replace(model.scene, moments=(replace(model.scene.moments[0], value=value),))
    return cpu_seconds(lambda: [ancf.solve(scene) for _ in range(repeats)]) / repeats


def force_row(slenderness: float) -> str:
    """Iterations of the dead tip forces P L^2/EI = 1, 5, 10 from the straight shape."""
    load = Force("rod", 1.0, np.array([0.0, 1.0, 0.0]))
    model = Model(Scene((rod(slenderness, 0.3, 8),), forces=(load,)))
    forces = np.array([[[0.0, P, 0.0]] for P in (1.0, 5.0, 10.0)]) * model.rods[0].bending_stiffness
    found = fused.solve_rows(model, np.empty((3, 0, 3)), forces)
    return f"{slenderness:6g}  {found.iterations}  lost {np.count_nonzero(~found.converged)}"


def main() -> None:
    """Print the tables."""
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print("\n   L/R     nu   solves/s iterations   lost   median err    largest    (one core, CPU time)")
    for slenderness, poisson_ratio in ((40.0, 0.3), (40.0, 0.49), (100.0, 0.3), (500.0, 0.3), (500.0, 0.49)):
        print(batch_row(slenderness, poisson_ratio))
    print("\nTip force P L^2/EI = 1, 5, 10 from the straight shape, iterations by L/R")
    for slenderness in (40.0, 100.0, 400.0):
        print(force_row(slenderness))
    print(f"\nOne row, warm, 90 degrees: {1e3 * one_row_seconds():.3f} ms")
    print(f"ancf.solve of the same: {1e3 * readable_seconds():.2f} ms")
    for workers in (1, 2):
        print(f"{workers} threads: {threaded(workers):.0f} solves per second of wall time")
    with tempfile.TemporaryDirectory() as cache:
        for rows in (1, 100):
            compiling, loading = (first_call_seconds(rows, cache) for _ in range(2))
            print(f"first call with {rows} rows: compiling {compiling:.1f} s, from the cache {loading:.2f} s")


if __name__ == "__main__":
    main()
