"""The fused kernel for one lane alone: what a thread of a GPU does with its samples, one after the other.

The mathematics is that of fused_kernel.py, function by function; only the clock differs. Lanes come in tiles
of 32, the threads of a warp: they walk the same elements at the same time, and one that is done takes its
next sample at once, beside neighbours that are still iterating.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ancf.failure import SMALLEST_VOLUME
from ancf.fused import Tables
from ancf.fused_blocks import compiled
from ancf.fused_kernel import (
    CANDIDATE,
    CONVERGED,
    RUNNING,
    after_check,
    after_step,
    largest,
    newton_step,
    right_hand_side,
    scratch,
)
from ancf.fused_memory import Lanes
from ancf.fused_start import begin
from ancf.lane_column import as_column

TILE = 32
WIDTH = (0.0,) * TILE


def tile_arrays(tables: Tables, tiles: int, empty: Any) -> tuple[Lanes, Any]:
    """State of all lanes, and memory (tiles, rows, 32), neighbours in the last axis.

    `empty` makes an array of a shape and a type; what it holds does not matter.
    """
    state = {
        name: empty((tiles, TILE) if array.ndim == 1 else (tiles, *array.shape, TILE), array.dtype)
        for name, array in tables.state._asdict().items()
    }
    return Lanes(**state), empty((tiles, len(tables.memory), TILE), np.float64)


@compiled
def _state_of(state, tile, lane):
    """State of one tile, with the scratch of one lane."""
    return Lanes(
        state.sample[tile],
        state.status[tile],
        state.iteration[tile],
        state.quiet[tile],
        state.step[tile],
        state.residual[tile],
        state.fixed[tile, :, :, lane],
        state.turning[tile, :, :, lane],
        state.frames[tile, :, :, :, lane],
        state.carried[tile, :, :, lane],
        state.scratch[tile, :, :, :, lane],
    )


@compiled
def solve_lane(
    tile, lane, tiles, problem, found, unit, mesh, elastic, projectors, loads, start, at, states, memories
):
    """Solve every sample of a batch that falls to one lane of one of the `tiles`.

    Parameters
    ----------
    problem, found : `fused.Problem`, and `fused.Found`, which is written, x in SI units
    unit : (n,) of the coordinates
    at : first row of each field of `Scratch` in a tile of memory
    states, memories : `tile_arrays`
    """
    state, memory = _state_of(states, tile, lane), memories[tile]
    w = scratch(as_column(memory, lane, WIDTH), at)
    size, nv = len(start.x0), loads.turning_shape.shape[1]
    sample, samples = tile * TILE + lane, len(found.converged)
    idle = True
    while sample < samples:
        if idle:
            begin(lane, sample, memory, at, problem, loads, start, state)
            idle = False
        newton_step(w, mesh, elastic, projectors, loads, nv)
        step = largest(memory, at.dx, mesh.free, lane)
        status = after_step(lane, step, state, problem, memory, at, size)
        if status == CANDIDATE:
            smallest = right_hand_side(w, mesh, elastic, projectors, loads, nv)
            residual = largest(memory, at.g, mesh.free, lane)
            sound = smallest > SMALLEST_VOLUME and w.signs[problem.sign[sample]] > 0.0
            status = after_check(lane, residual, sound, state, problem)
        if status != RUNNING:
            found.converged[sample] = status == CONVERGED
            found.residual[sample], found.iterations[sample] = state.residual[lane], state.iteration[lane]
            for k in range(size):
                found.x[sample, k] = memory[at.x + k, lane] * unit[k]
            sample += tiles * TILE
            idle = True
