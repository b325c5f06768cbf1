r"""Where the fused kernel starts: the rod bent by its moments alone (predictor.py), one sample at a time.

With the moment M carried at x, in units of E I/L, and arc length by L,

    R' = R hat(k_0 + C R^T M),   r' = R e_x

by the exponential midpoint rule between nodes; the chord of an arc is shorter than the arc by
sin(b)/b, b half the angle of bending. A follower moment M = R(x_M) M_0 depends on the frames: three rounds
settle it well enough for a start. Forces do not enter: Newton finds them from here.
"""

from __future__ import annotations

import math

from ancf.fused_blocks import compiled

WORTHLESS_TURN = 1e3  # rad
ROUNDS = 3  # of following moments
SMALL_ANGLE2 = 1e-8  # rad^2; the next terms of the series are 1e-18


@compiled
def _turn(E, v):
    """E = Exp(v), Rodrigues."""
    x, y, z = v[0], v[1], v[2]
    angle2 = x * x + y * y + z * z
    if angle2 < SMALL_ANGLE2:
        a, b = 1.0 - angle2 / 6.0, 0.5 - angle2 / 24.0
    else:
        angle = math.sqrt(angle2)
        half = math.sin(0.5 * angle)
        a, b = math.sin(angle) / angle, 2.0 * half * half / angle2
    E[0, 0], E[0, 1], E[0, 2] = 1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y
    E[1, 0], E[1, 1], E[1, 2] = b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x
    E[2, 0], E[2, 1], E[2, 2] = b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)


@compiled
def _product(C, A, B):
    """C = A B for (3, 3)."""
    for i in range(3):
        for j in range(3):
            C[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@compiled
def _curvature(k, R, M, C, k_0):
    """k = k_0 + C R^T M."""
    for a in range(3):
        k[a] = k_0[a]
    for b in range(3):
        m = R[0, b] * M[0] + R[1, b] * M[1] + R[2, b] * M[2]
        for a in range(3):
            k[a] += C[a, b] * m


@compiled
def _carry(carried, fixed, turning, load_node, frames):
    """Moment in every interval: all those beyond it, following ones turned with their sections."""
    carried[:] = 0.0
    for load in range(len(fixed)):
        node = load_node[load]
        R, M = frames[node], turning[load]
        for a in range(3):
            total = fixed[load, a] + R[a, 0] * M[0] + R[a, 1] * M[1] + R[a, 2] * M[2]
            for i in range(node):
                carried[i, a] += total


@compiled
def _integrate(frames, x, lane, carried, tables, k, E, middle):
    """Section frames from the first node on, and positions into one column of x."""
    per_node = 3 * tables.local.shape[1]
    for i in range(len(carried)):
        h, C, R = tables.h[i], tables.C[i], frames[i]
        _curvature(k, R, carried[i], C, tables.k_0)
        for a in range(3):
            k[a] *= 0.5 * h
        _turn(E, k)
        _product(middle, R, E)
        _curvature(k, middle, carried[i], C, tables.k_0)
        for a in range(3):
            k[a] *= 0.5 * h
        _turn(E, k)
        _product(middle, R, E)
        _product(frames[i + 1], middle, E)
        b2 = k[1] * k[1] + k[2] * k[2]
        b = math.sqrt(b2)
        chord = h * (1.0 - b2 / 6.0 if b2 < SMALL_ANGLE2 else math.sin(b) / b)
        at = i * per_node + 3 * tables.position
        for a in range(3):
            x[at + per_node + a, lane] = x[at + a, lane] + chord * middle[a, 0]


@compiled
def bend(x, lane, fixed, turning, tables, frames, carried, scratch):
    """Write the start into one column of x (n, lanes).

    Parameters
    ----------
    fixed, turning : (loads, 3) moments in space, and in the reference axes of their sections; by E I/L
    frames, carried, scratch : (n_nodes, 3, 3), (n_nodes - 1, 3) and (3, 3, 3)
    """
    k, E, middle = scratch[0, 0], scratch[1], scratch[2]
    nodes, nv = tables.local.shape[:2]
    follows = False
    for load in range(len(turning)):
        for a in range(3):
            follows = follows or turning[load, a] != 0.0
            # A start beyond this is worthless, and its angles have no digits left.
            if not abs(fixed[load, a]) + abs(turning[load, a]) < WORTHLESS_TURN:
                return
    for a in range(3):
        for b in range(3):
            frames[0, a, b] = tables.R_0[0, a, b]
    for round_ in range(ROUNDS if follows else 1):
        _carry(carried, fixed, turning, tables.load_node, tables.R_0 if round_ == 0 else frames)
        _integrate(frames, x, lane, carried, tables, k, E, middle)
    for i in range(nodes):
        for v in range(nv):
            if v == tables.position:
                continue
            for a in range(3):
                R, e = frames[i, a], tables.local[i, v]
                x[3 * (i * nv + v) + a, lane] = R[0] * e[0] + R[1] * e[1] + R[2] * e[2]


@compiled
def begin(lane, row, memory, at, problem, loads, start, state):
    """Give a lane a sample: its loads and where it starts."""
    x = memory[at.x : at.x + len(start.x0)]
    fixed, turning = state.fixed, state.turning
    state.iteration[lane] = state.quiet[lane] = 0
    state.residual[lane] = math.inf
    fixed[:] = 0.0
    turning[:] = 0.0
    for k in range(len(loads.moment_load)):
        load = loads.moment_load[k]
        M = problem.moments[row, k]
        for a in range(3):
            if loads.moment_turns[k]:
                turning[load, a] += _component(loads.axes[load, a], M) / loads.energy
            else:
                fixed[load, a] += M[a] / loads.energy
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
                memory[at.F_turning + 3 * turns + a, lane] = _component(axes[a], F)
            continue
        for v in range(loads.dead_shape.shape[1]):
            shape = loads.dead_shape[f, v]
            if shape != 0.0:
                for a in range(3):
                    memory[at.dead + 3 * v + a, lane] += shape * F[a]
    memory[at.trust, lane] = 1.0
    if len(problem.starts):
        for k in range(len(start.x0)):
            x[k, lane] = problem.starts[row if len(problem.starts) > 1 else 0, k]
    elif start.bends:
        memory[at.trust, lane] = 0.0
        bend(x, lane, fixed, turning, start, state.frames, state.carried, state.scratch)


@compiled
def _component(axis, a):
    """axis . a."""
    return axis[0] * a[0] + axis[1] * a[1] + axis[2] * a[2]


@compiled
def rest(lane, memory, at, start):
    """Leave a lane without a sample at the unloaded reference; scratch, from `E` on, needs no care."""
    for k in range(at.E):
        memory[k, lane] = 0.0
    for k in range(len(start.x0)):
        memory[at.x + k, lane] = start.x0[k]
