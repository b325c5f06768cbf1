"""Newton for many rows of loads on one model: the elastic kernel runs over all of them in one product.

The rows share mesh, reference and material, so their elastic forces and tangents come from the same arrays
with a leading axis (energy.py); assembly, loads and band LU follow row by row. Rows end one by one and leave
the others alone: it is `newton` for each of them.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancf.batch_loads import BatchLoads
from ancf.failure import is_collapsed
from ancf.model import Model
from ancf.newton import NewtonRun, Outcome
from ancf.predictor import load_start
from ancf.rod_start import nodal_loads
from ancf.stepping import DIRECT_ITERATIONS, is_stable

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

CHUNK = 64  # rows whose arrays (100 kB each) are worked on at once: more do not fit the caches
# Loads without a closed-form start: one row in so many starts from nothing, the rest from a neighbour ...
STRIDE = 16
# ... unless that is farther than this many E I/L^2 (moments: E I/L): a long step may end on another branch.
NEAR = 1.0


@dataclass(frozen=True, eq=False)
class RowsResult:
    """What Newton found for each row; a row without an equilibrium never spoils the others."""

    q: Floats  # (B, n) last iterates, finite
    converged: NDArray[np.bool_]  # (B,) an equilibrium that may be taken: not collapsed, not unstable
    residual: Floats  # (B,)
    floor: Floats  # (B,)
    iterations: Indices  # (B,)


def solve_rows(
    model: Model, loads: BatchLoads, start: Floats | None = None, deadline: float = np.inf
) -> RowsResult:
    """Newton at the full load of every row.

    Parameters
    ----------
    model : of `loads.scene`
    start : nodal coordinates (B, n) to begin from; None takes `load_start`, or a solved neighbour of the row
    """
    count = len(loads)
    result = RowsResult(
        q=np.tile(model.q0, (count, 1)),
        converged=np.zeros(count, bool),
        residual=np.zeros(count),
        floor=np.zeros(count),
        iterations=np.zeros(count, int),
    )
    for rows in _waves(model, loads, start):
        for chunk in np.array_split(rows, -(-len(rows) // CHUNK)):
            models = [loads.under(model, row) for row in chunk]
            starts = [
                _start(model, loads, int(row), result, deadline) if start is None else start[row]
                for model, row in zip(models, chunk, strict=True)
            ]
            _store(result, chunk, _run(models, starts, deadline))
    return result


def _run(models: list[Model], starts: list[Floats], deadline: float) -> list[NewtonRun]:
    runs = [NewtonRun(model, q, 1.0) for model, q in zip(models, starts, strict=True)]
    for _ in range(DIRECT_ITERATIONS):
        going = [run for run in runs if not run.done]
        if not going or time.perf_counter() > deadline:
            break
        q = np.array([run.q for run in going])
        # All rows step together, so either none or all of them have a previous iterate.
        previous = [run.q_previous for run in going if run.q_previous is not None]
        elastic = models[0].elastic_terms(q, np.array(previous) if previous else None)
        for index, run in enumerate(going):
            try:
                terms = [(Q[index], K[index]) for Q, K in elastic]
                run.advance(*run.model.assembled(terms, run.q, 1.0))
            except np.linalg.LinAlgError:  # a section collapsed to a line: its rotation is undefined
                run.end(Outcome.NOT_FINITE)
    return runs


def _store(result: RowsResult, rows: Indices, runs: list[NewtonRun]) -> None:
    for row, run in zip(rows, runs, strict=True):
        found = run.result
        result.residual[row], result.floor[row] = found.residual, found.floor
        result.iterations[row] = len(found.history)
        accepted = (
            found.converged
            and not is_collapsed(run.model, found.q)
            and is_stable(run.model, found) is not False
        )
        result.converged[row] = accepted
        if np.isfinite(found.q).all():
            result.q[row] = found.q


def _waves(model: Model, loads: BatchLoads, start: Floats | None) -> Iterator[Indices]:
    """Rows in waves, each of which may start from the waves before; one wave where starts are cheap."""
    every = np.arange(len(loads))
    if start is not None or not any(nodal_loads(model.scene, rod).forces for rod in model.rods):
        yield every
        return
    yield every[::STRIDE]
    step = STRIDE // 2
    while step >= 1:
        wave = every[step :: 2 * step]
        if len(wave):
            yield wave
        step //= 2


def _start(model: Model, loads: BatchLoads, row: int, result: RowsResult, deadline: float) -> Floats:
    """Where a row begins: at the nearest of its solved neighbours, or where `solve` would."""
    near = np.arange(max(row - STRIDE, 0), min(row + STRIDE, len(loads) - 1) + 1)
    near = near[result.converged[near]]
    if len(near):
        distance = np.abs(loads.dimensionless[near] - loads.dimensionless[row]).max(axis=1)
        if distance.min() <= NEAR:
            return result.q[near[np.argmin(distance)]]
    bent = load_start(model, deadline) if model.scene.solver.predictor == "auto" else None
    return model.q0 if bent is None else bent
