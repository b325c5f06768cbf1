"""Newton for many rows of loads on one model: the elastic kernel runs over all of them in one product.

The rows share mesh, reference and material, so their elastic forces and tangents come from the same arrays
with a leading axis (energy.py); assembly, loads and band LU follow row by row. Rows end one by one and leave
the others alone: it is `newton` for each of them.
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from ancf.batch_rows import BatchLoads, RowsResult
from ancf.failure import is_collapsed
from ancf.model import Model
from ancf.newton import NewtonRun, Outcome
from ancf.stepping import DIRECT_ITERATIONS, is_stable

Floats = NDArray[np.float64]

CHUNK = 64  # rows whose arrays (100 kB each) are worked on at once: more do not fit the caches


def solve_rows(model: Model, loads: BatchLoads, start: Floats, deadline: float = np.inf) -> RowsResult:
    """Newton at the full load of every row.

    Parameters
    ----------
    model : of `loads.scene`, or of the same rods under other values
    start : nodal coordinates (B, n) to begin from
    """
    result = RowsResult.empty(len(loads), model.n)
    result.q[:] = start
    for first in range(0, len(loads), CHUNK):
        rows = range(first, min(first + CHUNK, len(loads)))
        runs = _run([loads.under(model, row) for row in rows], start[first : first + CHUNK], deadline)
        for row, run in zip(rows, runs, strict=True):
            _store(result, row, run)
    return result


def _run(models: list[Model], starts: Floats, deadline: float) -> list[NewtonRun]:
    runs = [NewtonRun(model, q, 1.0) for model, q in zip(models, starts, strict=True)]
    for _ in range(DIRECT_ITERATIONS):
        going = [run for run in runs if not run.done]
        if not going or time.perf_counter() > deadline:
            break
        q = np.array([run.q for run in going])
        # All rows step together, so either none or all of them have a previous iterate.
        previous = [run.q_previous for run in going if run.q_previous is not None]
        elastic = list(models[0].elastic_terms(q, np.array(previous) if previous else None))
        for index, run in enumerate(going):
            try:
                terms = [(Q[index], K[index]) for Q, K in elastic]
                run.advance(*run.model.assembled(terms, run.q, 1.0))
            except np.linalg.LinAlgError:  # a section collapsed to a line: its rotation is undefined
                run.end(Outcome.NOT_FINITE)
    return runs


def _store(result: RowsResult, row: int, run: NewtonRun) -> None:
    found = run.result
    sound = found.converged and not is_collapsed(run.model, found.q)
    result.converged[row] = sound and is_stable(run.model, found) is not False
    result.residual[row], result.floor[row] = found.residual, found.floor
    result.iterations[row] = len(found.history)
    if np.isfinite(found.q).all():
        result.q[row] = found.q
