"""Where the rows of a batch begin: where `solve` would, or at a solved neighbour in the order of the rows.

A start under forces is an equilibrium of its own (rod_start.py) and dearer than the solve that follows. Rows
of a sweep are close to each other: one in STRIDE finds its own start, the rest follow in waves that halve the
distance, from the nearest row solved before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ancf.batch_rows import BatchLoads, RowsResult
from ancf.model import Model
from ancf.predictor import load_start

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

STRIDE = 16
# E I/L^2 (moments: E I/L) from a neighbour, beyond which a row finds its own start: a long step may end on
# another branch.
NEAR = 1.0


def solve_in_waves(
    model: Model,
    loads: BatchLoads,
    newton: Callable[[Model, BatchLoads, Floats], RowsResult],
    deadline: float = np.inf,
) -> RowsResult:
    """Solve all rows by `newton(model, loads, starts)`, which takes some rows and their starts (B, n)."""
    result = RowsResult.empty(len(loads), model.n)
    for rows in _waves(len(loads), dear_starts(model)):
        starts = np.array([_start(model, loads, int(row), result, deadline) for row in rows])
        result.put(rows, newton(model, loads.taken(rows), starts))
    return result


def dear_starts(model: Model) -> bool:
    """Whether the scene has more than moments, under which no start is known in closed form."""
    scene = model.scene
    values = [
        load.value for load in (*scene.forces, *scene.line_loads, *scene.line_moments, *scene.pressures)
    ]
    values += [] if scene.gravity is None else [scene.gravity.acceleration]
    values += [tendon.tension for tendon in scene.pulled_tendons]
    acting = any(np.any(value) for value in values)
    return acting or scene.held_on_the_way or bool(scene.controlled_tendons or scene.added)


def _waves(count: int, dear: bool) -> Iterator[Indices]:
    """Rows in waves, each of which may start from the waves before; one wave where starts are cheap."""
    every = np.arange(count)
    yield every[::STRIDE] if dear else every
    step = STRIDE // 2
    while dear and step >= 1:
        if step < count:
            yield every[step :: 2 * step]
        step //= 2


def _start(model: Model, loads: BatchLoads, row: int, result: RowsResult, deadline: float) -> Floats:
    near = np.arange(max(row - STRIDE, 0), min(row + STRIDE, len(loads) - 1) + 1)
    near = near[result.converged[near]]
    if len(near):
        distance = np.abs(loads.dimensionless[near] - loads.dimensionless[row]).max(axis=1)
        if distance.min() <= NEAR:
            return result.q[near[np.argmin(distance)]]
    predicts = model.scene.solver.predictor == "auto"
    bent = load_start(loads.under(model, row), deadline) if predicts else None
    return model.q0 if bent is None else bent
