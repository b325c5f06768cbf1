"""The fused kernel for one lane alone: what a thread of a GPU does with its samples, one after the other.

The mathematics is that of fused_kernel.py, function by function; only the clock differs. Threads of a warp
walk the same elements at the same time, and one that is done takes its next sample at once, beside neighbours
that are still iterating.
"""

from __future__ import annotations

from ancf.failure import SMALLEST_VOLUME
from ancf.fused_blocks import compiled
from ancf.fused_kernel import (
    CANDIDATE,
    CONVERGED,
    FAILED,
    RUNNING,
    after_check,
    after_step,
    largest,
    newton_step,
    right_hand_side,
    scratch,
)
from ancf.fused_start import begin
from ancf.lane_column import as_column


@compiled
def solve_lane(
    first, stride, lane, problem, found, unit, mesh, elastic, projectors, loads, start, at, state, memory, width
):
    """Solve the samples `first`, `first` + `stride` and so on of a batch.

    Parameters
    ----------
    problem, found : `fused.Problem`, and `fused.Found`, which is written; x in SI units
    unit : (n,) of the coordinates
    at : first row of each field of `Scratch` in `memory` (rows, lanes)
    state : `fused_memory.Lanes` with scratch of this lane's own
    width : a tuple of as many floats as there are lanes
    """
    w = scratch(as_column(memory, lane, width), at)
    size, nv = len(start.x0), loads.turning_shape.shape[1]
    sample, samples, status = first, len(found.converged), RUNNING
    if sample < samples:
        begin(lane, sample, memory, at, problem, loads, start, state)
    while sample < samples:
        newton_step(w, mesh, elastic, projectors, loads, nv)
        step = largest(memory, at.dx, mesh.free, lane)
        status = after_step(lane, step, state, problem, memory, at, size)
        if status == CANDIDATE:
            smallest = right_hand_side(w, mesh, elastic, projectors, loads, nv)
            residual = largest(memory, at.g, mesh.free, lane)
            sign = w.signs[0 if len(loads.node) == 0 else 1]
            sound = smallest > SMALLEST_VOLUME and sign > 0.0
            status = after_check(lane, residual, sound, state, problem)
        if status == CONVERGED or status == FAILED:
            found.converged[sample] = status == CONVERGED
            found.residual[sample], found.iterations[sample] = state.residual[lane], state.iteration[lane]
            for k in range(size):
                found.x[sample, k] = memory[at.x + k, lane] * unit[k]
            sample += stride
            if sample < samples:
                begin(lane, sample, memory, at, problem, loads, start, state)
