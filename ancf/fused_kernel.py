"""The fused kernel: Newton's iteration of many samples of one rod, as many at once as fit a SIMD register.

Every lane of the registers solves its own sample. Lanes whose sample is done take the next one, so that no lane
waits for the slowest; a sample that fails leaves no trace in its neighbours, which share nothing but the clock.
One iteration walks the elements once: assemble the front, add what the elements before left, eliminate
(fused_front.py), and then back. The rule of convergence is that of newton.py, with one shortcut: a step whose
successor is estimated to be far below the tolerance ends the iteration as well, if the residual agrees.

Symbols
-------
x, dx    coordinates and last step (n, lanes), dimensionless;  g right-hand side, minus the residual
w        scratch in registers (`Scratch`);  lane arrays see the rows of `memory`
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

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
from ancf.fused_start import bend
from ancf.lanes import as_lanes, rows_from
from ancf.newton import DIVERGED_STEP, FALLING, NOISE_RATIO, NOISE_STEP, PATIENCE, STAGNATION

# A step may be the last when its successor is estimated, from the last two, to be this share of the tolerance.
EARLY = 1e-2
# det [r_x r_y r_z] below which a section has collapsed; as in failure.py.
SMALLEST_VOLUME = 1e-4
IDLE = -1


class Scratch(NamedTuple):
    """Lane arrays of one call, in the order of `fused.scratch_rows`."""

    x: object
    dx: object
    g: object
    dead: object
    M_fixed: object
    M_turning: object
    F_turning: object
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
def scratch(memory, at, width):
    """Lane arrays at their rows of the memory."""
    a = as_lanes(memory, width)
    return Scratch(
        rows_from(a, at.x),
        rows_from(a, at.dx),
        rows_from(a, at.g),
        rows_from(a, at.dead),
        rows_from(a, at.M_fixed),
        rows_from(a, at.M_turning),
        rows_from(a, at.F_turning),
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


@compiled
def newton_step(w, mesh, elastic, projectors, loads, nv):
    """g = minus the residual at x, then dx = K^-1 g with the mixed-integration-point tangent after a step dx."""
    elements, m = mesh.dofs.shape
    pivots = m - nv
    for k in range(3 * nv * (1 + (m // nv - 1) * elements)):
        w.g[k] = w.dead[k]
    for k in range(9 * nv * nv):
        w.carry[k] = 0.0
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
            eliminate(w.front, w.g, W, w.dx, dofs, active, eliminated, count, m)
        leave_carry(w.carry, w.front, pivots, nv, m, symmetric)
        if loads.at[e + 1] >= 0:
            section_load(w.g, w.carry, w.x, dofs[pivots], nv, loads.at[e + 1], loads, w, True)
            symmetric = False
    end = mesh.dofs[elements - 1, pivots:]
    eliminate(w.carry, w.g, w.W_end, w.dx, end, mesh.end, len(mesh.end), len(mesh.end), nv)
    substitute(w.W_end, w.dx, end, mesh.end, len(mesh.end), len(mesh.end), nv)
    for e in range(elements - 1, -1, -1):
        W = rows_from(w.W, 9 * e * pivots * m)
        substitute(W, w.dx, mesh.dofs[e], mesh.active[e], mesh.counts[e, 0], mesh.counts[e, 1], m)


@compiled
def right_hand_side(w, mesh, elastic, projectors, loads, nv):
    """g = minus the residual at x, on what the supports leave free; returns the smallest det [r_x r_y r_z]."""
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
def begin(lane, row, memory, at, problem, loads, start, values):
    """Give a lane a sample: its loads and where it starts."""
    x = memory[at.x : at.x + len(start.x0)]
    fixed, turning = values.fixed, values.turning
    fixed[:] = 0.0
    turning[:] = 0.0
    for k in range(len(loads.moment_load)):
        load = loads.moment_load[k]
        for a in range(3):
            M = problem.moments[row, k] / loads.energy
            if not loads.moment_turns[k]:
                fixed[load, a] += M[a]
                continue
            axis = loads.axes[load, a]
            turning[load, a] += axis[0] * M[0] + axis[1] * M[1] + axis[2] * M[2]
    for load in range(len(fixed)):
        for a in range(3):
            memory[at.M_fixed + 3 * load + a, lane] = fixed[load, a]
            memory[at.M_turning + 3 * load + a, lane] = turning[load, a]
    for k in range(len(loads.dead)):
        memory[at.dead + k, lane] = loads.dead[k]
        memory[at.dx + k, lane] = 0.0
        x[k, lane] = start.x0[k]
    for f in range(len(loads.force_turning)):
        F, turns = problem.forces[row, f], loads.force_turning[f]
        if turns >= 0:
            axes = loads.axes[loads.turning_load[turns]]
            for a in range(3):
                value = axes[a, 0] * F[0] + axes[a, 1] * F[1] + axes[a, 2] * F[2]
                memory[at.F_turning + 3 * turns + a, lane] = value
            continue
        for v in range(loads.dead_shape.shape[1]):
            shape = loads.dead_shape[f, v]
            if shape != 0.0:
                for a in range(3):
                    memory[at.dead + 3 * v + a, lane] += shape * F[a]
    if len(problem.starts):
        for k in range(len(start.x0)):
            x[k, lane] = problem.starts[row if len(problem.starts) > 1 else 0, k]
    elif start.bends:
        bend(x, lane, fixed, turning, start, values.frames, values.carried, values.scratch)


@compiled
def rest(lane, memory, at, start):
    """Leave a lane without a sample at the unloaded reference."""
    memory[:, lane] = 0.0
    for k in range(len(start.x0)):
        memory[at.x + k, lane] = start.x0[k]


@compiled
def largest(memory, first, free, lane):
    """Largest |component| of the vectors that are free; infinite where one is not finite."""
    found = 0.0
    for v in range(len(free)):
        if free[v]:
            for a in range(3):
                size = abs(memory[first + 3 * v + a, lane])
                if not size <= 1e300:
                    return np.inf
                found = max(found, size)
    return found


@njit(nogil=True, cache=True, error_model="numpy")
def solve(problem, found, mesh, elastic, projectors, loads, start, at, values, memory, width):
    """Solve all samples of a batch.

    Parameters
    ----------
    problem : `Problem`;  found : `Found`, written
    at : first row of each field of `Scratch` in `memory` (rows, lanes)
    width : a tuple of as many floats as there are lanes
    """
    w = scratch(memory, at, width)
    lanes, samples = memory.shape[1], len(found.converged)
    nv, n = loads.turning_shape.shape[1], len(start.x0)
    sample, iteration, quiet = values.sample, values.iteration, values.quiet
    step_before, candidate = values.step_before, values.candidate
    following = 0
    busy = 0
    for lane in range(lanes):
        rest(lane, memory, at, start)
        sample[lane] = IDLE
        if following < samples:
            sample[lane] = following
            iteration[lane] = quiet[lane] = 0
            begin(lane, following, memory, at, problem, loads, start, values)
            following += 1
            busy += 1
    while busy > 0:
        newton_step(w, mesh, elastic, projectors, loads, nv)
        check = False
        for lane in range(lanes):
            candidate[lane] = False
            if sample[lane] == IDLE:
                continue
            iteration[lane] += 1
            step = largest(memory, at.dx, mesh.free, lane)
            before = step_before[lane] if iteration[lane] > 1 else np.inf
            step_before[lane] = step
            lost = iteration[lane] >= PATIENCE and step > max(1.0, FALLING * before)
            done = lost or not step <= DIVERGED_STEP
            if not done:
                for k in range(n):
                    memory[at.x + k, lane] += memory[at.dx + k, lane]
                noise = step <= NOISE_STEP and step > NOISE_RATIO * before
                early = step * step <= EARLY * problem.tolerance * before and step < before < np.inf
                candidate[lane] = step <= problem.tolerance or noise or early
                check = check or candidate[lane]
                done = not candidate[lane] and iteration[lane] == problem.max_iterations
            if done:
                candidate[lane] = False
                busy += finish(lane, False, np.inf, sample, found, memory, at, iteration)
                if following < samples:
                    sample[lane] = following
                    iteration[lane] = quiet[lane] = 0
                    begin(lane, following, memory, at, problem, loads, start, values)
                    following += 1
                    busy += 1
                else:
                    rest(lane, memory, at, start)
        if not check:
            continue
        smallest = right_hand_side(w, mesh, elastic, projectors, loads, nv)
        w.node[0] = smallest
        for lane in range(lanes):
            if not candidate[lane]:
                continue
            residual = largest(memory, at.g, mesh.free, lane)
            good = residual <= max(problem.tolerance, problem.floor)
            good = good and memory[at.node, lane] > SMALLEST_VOLUME
            quiet[lane] += 1
            if good or quiet[lane] == STAGNATION or iteration[lane] == problem.max_iterations:
                busy += finish(lane, good, residual, sample, found, memory, at, iteration)
                if following < samples:
                    sample[lane] = following
                    iteration[lane] = quiet[lane] = 0
                    begin(lane, following, memory, at, problem, loads, start, values)
                    following += 1
                    busy += 1
                else:
                    rest(lane, memory, at, start)


@compiled
def finish(lane, converged, residual, sample, found, memory, at, iteration):
    """Write out the sample of a lane; returns the change of the number of busy lanes."""
    row = sample[lane]
    found.converged[row] = converged
    found.residual[row] = residual
    found.iterations[row] = iteration[lane]
    for k in range(found.x.shape[1]):
        found.x[row, k] = memory[at.x + k, lane]
    sample[lane] = IDLE
    return -1
