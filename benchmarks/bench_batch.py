"""What the fused kernel costs: the batch of issue 5, one row, threads, compiling.

    OPENBLAS_NUM_THREADS=1 python benchmarks/bench_batch.py

1520 spatial tip moments (|M_x| <= 0.8, |M_y|, |M_z| <= 3 E I/L) on a straight round rod of 8 elements 3333,
cold. Times are CPU times of one core, medians of several runs; tip errors are against 64 elements, in
lengths.
"""

from __future__ import annotations

import importlib
import statistics
import threading
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ancf import fused
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Moment, Rod, Scene
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


def compile_seconds(rows: int) -> float:
    """CPU time of compiling, or of loading from the cache, in this process."""
    model = moment_model(40.0, 0.3)
    fused.tables(model, rows)
    importlib.import_module("ancf.fused_kernel")
    moments, none = sample_moments(model)[:rows], np.empty((rows, 0, 3))
    warm = 0.0
    started = time.process_time()
    fused.solve_rows(model, moments, none)
    return time.process_time() - started - warm
