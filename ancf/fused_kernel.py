"""The fused kernel: Newton's iteration of many samples of one rod, as many at once as fit a SIMD register.

Every lane of the registers solves its own sample. Lanes whose sample is done take the next one, so that no
lane waits for the slowest; a sample that fails leaves no trace in its neighbours, which share nothing but
the clock. One iteration walks the elements once: assemble the front, add what the elements before left,
eliminate (fused_front.py), and then back. The rule of convergence is that of newton.py, with one shortcut:
a step whose successor is estimated to be far below the tolerance ends the iteration as well, if the
residual agrees.

Symbols
-------
x, dx    coordinates and last step (n, lanes), dimensionless;  g right-hand side, minus the residual
w        scratch in registers (`Scratch`);  lane arrays see the rows of `memory`
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import njit

from ancf.failure import SMALLEST_VOLUME
from ancf.fused_blocks import compiled
from ancf.fused_element import element_force, element_tangent
from ancf.fused_front import (
    assemble,
    eliminate,
    eliminate_element,
    leave_carry,
    project,
    project_vector,
    substitute,
    take_carry,
)
from ancf.fused_load import section_load
from ancf.fused_start import begin, rest
from ancf.lanes import as_lanes, rows_from
from ancf.newton import DIVERGED_STEP, FALLING, NOISE_RATIO, NOISE_STEP, PATIENCE, STAGNATION

# A step may be the last when its successor, estimated from the last two, is this share of the tolerance.
EARLY = 1e-2
HUGE = 1e300
# What a lane is doing.
IDLE, RUNNING, CANDIDATE, CONVERGED, FAILED = 0, 1, 2, 3, 4


class Scratch(NamedTuple):
    """Lane arrays of one call, in the order of `fused.scratch_rows`."""

    x: object
    dx: object
    g: object
    dead: object
    M_fixed: object
    M_turning: object
    F_turning: object
    trust: object
    signs: object
    E: object
    dE: object
    V: object
    dV: object
    gamma: object
    T: object
    Q: object
    U: object
    K_v: object
    K_N: object
    front: object
    carry: object
    W: object
    W_end: object
    node: object


@compiled
def scratch(a, at):
    """Lane arrays at their rows of one."""
    return Scratch(
        rows_from(a, at.x),
        rows_from(a, at.dx),
        rows_from(a, at.g),
        rows_from(a, at.dead),
        rows_from(a, at.M_fixed),
        rows_from(a, at.M_turning),
        rows_from(a, at.F_turning),
        rows_from(a, at.trust),
        rows_from(a, at.signs),
        rows_from(a, at.E),
        rows_from(a, at.dE),
        rows_from(a, at.V),
        rows_from(a, at.dV),
        rows_from(a, at.gamma),
        rows_from(a, at.T),
        rows_from(a, at.Q),
        rows_from(a, at.U),
        rows_from(a, at.K_v),
        rows_from(a, at.K_N),
        rows_from(a, at.front),
        rows_from(a, at.carry),
        rows_from(a, at.W),
        rows_from(a, at.W_end),
        rows_from(a, at.node),
    )


@njit(inline="always")
def newton_step(w, mesh, elastic, projectors, loads, nv):
    """g = minus the residual at x, and dx = K^-1 g with the mixed-integration-point tangent (old dx)."""
    elements, m = mesh.dofs.shape
    pivots = m - nv
    for k in range(3 * nv * (1 + (m // nv - 1) * elements)):
        w.g[k] = w.dead[k]
    for k in range(9 * nv * nv):
        w.carry[k] = 0.0
    w.signs[0] = 1.0
    w.signs[1] = 1.0
    symmetric = True
    if loads.at[0] >= 0:
        section_load(w.g, w.carry, w.x, mesh.dofs[0, pivots - nv], nv, loads.at[0], loads, w, True)
        symmetric = False
    projector = 0
    for e in range(elements):
        dofs, active = mesh.dofs[e], mesh.active[e]
        eliminated, count = mesh.counts[e]
        element_tangent(w.g, w.x, w.dx, e, mesh, elastic, w)
        N, W = elastic.N[mesh.kind[e]], rows_from(w.W, 9 * e * pivots * m)
        start, at = elastic.column_start, elastic.column_at
        if projector == len(projectors.element) or projectors.element[projector] > e:
            eliminate_element(
                w.front,
                w.K_N,
                N,
                start,
                at,
                w.carry,
                w.g,
                W,
                w.dx,
                w.signs,
                dofs,
                active,
                eliminated,
                count,
                nv,
                symmetric,
            )
        else:
            assemble(w.front, w.K_N, N, start, at, active, count)
            while projector < len(projectors.element) and projectors.element[projector] == e:
                P, node = projectors.P[projector], projectors.place[projector]
                project(w.front, P, node, nv, m, projectors.first[projector], w.node)
                project_vector(w.g, projectors.dof[projector], P, w.node)
                projector += 1
            take_carry(w.front, w.carry, pivots - nv, nv, m)
            eliminate(w.front, w.g, W, w.dx, w.signs, dofs, active, eliminated, count, m)
        leave_carry(w.carry, w.front, pivots, nv, m, symmetric)
        if loads.at[e + 1] >= 0:
            section_load(w.g, w.carry, w.x, dofs[pivots], nv, loads.at[e + 1], loads, w, True)
            symmetric = False
    end = mesh.dofs[elements - 1, pivots:]
    eliminate(w.carry, w.g, w.W_end, w.dx, w.signs, end, mesh.end, len(mesh.end), len(mesh.end), nv)
    substitute(w.W_end, w.dx, end, mesh.end, len(mesh.end), len(mesh.end), nv)
    for e in range(elements - 1, -1, -1):
        W = rows_from(w.W, 9 * e * pivots * m)
        substitute(W, w.dx, mesh.dofs[e], mesh.active[e], mesh.counts[e, 0], mesh.counts[e, 1], m)
    for k in range(len(projectors.element)):  # rounding leaves something in what the supports hold
        project_vector(w.dx, projectors.dof[k], projectors.P[k], w.node)


@njit(inline="always")
def right_hand_side(w, mesh, elastic, projectors, loads, nv):
    """g = minus the residual at x, on what the supports leave free; returns the least det [r_x r_y r_z]."""
    elements, m = mesh.dofs.shape
    pivots = m - nv
    for k in range(3 * nv * (1 + (m // nv - 1) * elements)):
        w.g[k] = w.dead[k]
    smallest = w.g[0] * 0.0 + 1.0
    for e in range(elements):
        smallest = element_force(w.g, w.x, e, mesh, elastic, w, smallest)
    for b in range(elements + 1):
        if loads.at[b] >= 0:
            dof = mesh.dofs[0, pivots - nv] if b == 0 else mesh.dofs[b - 1, pivots]
            section_load(w.g, w.carry, w.x, dof, nv, loads.at[b], loads, w, False)
    for k in range(len(projectors.element)):
        project_vector(w.g, projectors.dof[k], projectors.P[k], w.node)
    return smallest


@compiled
def largest(memory, first, free, lane):
    """Largest |component| of the vectors that are free; infinite where one is not finite."""
    found = 0.0
    for v in range(len(free)):
        if free[v]:
            for a in range(3):
                size = abs(memory[first + 3 * v + a, lane])
                if not size <= HUGE:
                    return np.inf
                found = max(found, size)
    return found


@compiled
def after_step(lane, step, state, problem, memory, at, size):
    """Take the step of one lane and judge it by its length; a candidate still has to show its residual."""
    iteration = state.iteration[lane] = state.iteration[lane] + 1
    before = state.step[lane] if iteration > 1 else np.inf
    state.step[lane] = step
    if not step <= DIVERGED_STEP or (iteration >= PATIENCE and step > max(1.0, FALLING * before)):
        return FAILED
    memory[at.trust, lane] = 1.0
    for k in range(size):
        memory[at.x + k, lane] += memory[at.dx + k, lane]
    noise = step <= NOISE_STEP and step > NOISE_RATIO * before
    early = step < before < np.inf and step * step <= EARLY * problem.tolerance * before
    if step <= problem.tolerance or noise or early:
        return CANDIDATE
    return FAILED if iteration == problem.max_iterations else RUNNING


@compiled
def after_check(lane, residual, sound, state, problem):
    """Judge a candidate by its residual, and by whether its state is `sound`."""
    state.residual[lane] = residual
    if residual <= max(problem.tolerance, problem.floor):
        return CONVERGED if sound else FAILED
    state.quiet[lane] += 1
    over = state.quiet[lane] == STAGNATION or state.iteration[lane] == problem.max_iterations
    return FAILED if over else RUNNING


def _solve(problem, found, mesh, elastic, projectors, loads, start, at, state, memory, width):
    """Solve all samples of a batch.

    Parameters
    ----------
    problem, found : `fused.Problem`, and `fused.Found`, which is written
    at : first row of each field of `Scratch` in `memory` (rows, lanes)
    width : a tuple of as many floats as there are lanes
    """
    w = scratch(as_lanes(memory, width), at)
    lanes, samples, size = memory.shape[1], len(found.converged), len(start.x0)
    nv = loads.turning_shape.shape[1]
    sample, status = state.sample, state.status
    for lane in range(lanes):
        rest(lane, memory, at, start)
        status[lane] = IDLE
    following = busy = np.int64(0)
    while True:
        for lane in range(lanes):
            if status[lane] == IDLE and following < samples:
                begin(lane, following, memory, at, problem, loads, start, state)
                sample[lane], status[lane] = following, RUNNING
                following += 1
                busy += 1
        if busy == 0:
            return
        newton_step(w, mesh, elastic, projectors, loads, nv)
        check = False
        for lane in range(lanes):
            if status[lane] == RUNNING:
                step = largest(memory, at.dx, mesh.free, lane)
                status[lane] = after_step(lane, step, state, problem, memory, at, size)
                check = check or status[lane] == CANDIDATE
        if check:
            w.node[0] = right_hand_side(w, mesh, elastic, projectors, loads, nv)
            for lane in range(lanes):
                if status[lane] == CANDIDATE:
                    residual = largest(memory, at.g, mesh.free, lane)
                    sign = memory[at.signs + problem.sign[sample[lane]], lane]
                    sound = memory[at.node, lane] > SMALLEST_VOLUME and sign > 0.0
                    status[lane] = after_check(lane, residual, sound, state, problem)
        for lane in range(lanes):
            if status[lane] == CONVERGED or status[lane] == FAILED:
                row = sample[lane]
                found.converged[row] = status[lane] == CONVERGED
                found.residual[row], found.iterations[row] = state.residual[lane], state.iteration[lane]
                for k in range(size):
                    found.x[row, k] = memory[at.x + k, lane]
                rest(lane, memory, at, start)
                status[lane] = IDLE
                busy -= 1


def digest():
    """Digest of the sources that are compiled together.

    In the function's name it gives each version its own file in numba's cache, which watches one source file
    only, and which does not survive that a class it has stored moves to another module.
    """
    folder, total = Path(__file__).parent, hashlib.sha256()
    others = [folder / name for name in ("lanes.py", "lane_column.py", "newton.py", "failure.py")]
    for path in sorted([*others, *folder.glob("fused*.py")]):
        total.update(path.read_bytes())
    return total.hexdigest()[:16]


_solve.__qualname__ = f"solve_{digest()}"
solve = njit(nogil=True, cache=True, error_model="numpy")(_solve)
