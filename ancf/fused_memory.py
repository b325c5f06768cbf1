"""Memory of the fused kernel: one array of registers, row by row, and the state of each lane."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancf.fused_load_tables import LoadTables
from ancf.fused_tables import ElasticTables, MeshTables

Floats = NDArray[np.float64]

CACHE_LINE = 64  # bytes


class Lanes(NamedTuple):
    """State of the lanes (lanes,), and scratch of the start."""

    sample: NDArray[np.int64]
    status: NDArray[np.int64]
    iteration: NDArray[np.int64]
    quiet: NDArray[np.int64]  # candidates that had too large a residual
    step: Floats
    residual: Floats
    fixed: Floats  # (loads, 3)
    turning: Floats  # (loads, 3)
    frames: Floats  # (n_nodes, 3, 3)
    carried: Floats  # (n_nodes - 1, 3)
    scratch: Floats  # (3, 3, 3)


class Rows(NamedTuple):
    """Sizes, or first rows, of the fields of `fused_kernel.Scratch` (what they hold is said there)."""

    x: int
    dx: int
    g: int
    dead: int
    M_fixed: int
    M_turning: int
    F_turning: int
    trust: int
    signs: int
    E: int
    dE: int
    V: int
    dV: int
    gamma: int
    T: int
    Q: int
    U: int
    K_v: int
    K_N: int
    front: int
    carry: int
    W: int
    W_end: int
    node: int


def lane_states(loads: int, nodes: int, lanes: int) -> Lanes:
    """Arrays for the lanes of a rod with so many loaded sections and nodes."""
    return Lanes(
        sample=np.zeros(lanes, np.int64),
        status=np.zeros(lanes, np.int64),
        iteration=np.zeros(lanes, np.int64),
        quiet=np.zeros(lanes, np.int64),
        step=np.zeros(lanes),
        residual=np.zeros(lanes),
        fixed=np.zeros((loads, 3)),
        turning=np.zeros((loads, 3)),
        frames=np.zeros((nodes, 3, 3)),
        carried=np.zeros((nodes - 1, 3)),
        scratch=np.zeros((3, 3, 3)),
    )


def scratch_memory(
    n: int, mesh: MeshTables, elastic: ElasticTables, loads: LoadTables, lanes: int
) -> tuple[Rows, Floats]:
    """First row of each field, and the memory (rows, lanes) of a model with n unknowns."""
    first = np.cumsum([0, *_sizes(n, mesh, elastic, loads)])
    return Rows(*map(int, first[:-1])), _aligned(int(first[-1]), lanes)


def _sizes(n: int, mesh: MeshTables, elastic: ElasticTables, loads: LoadTables) -> Rows:
    """Rows that each field needs."""
    elements, m = mesh.dofs.shape
    nv = loads.turning_shape.shape[1]
    pairs, points, g = len(elastic.i), *elastic.N.shape[1:3]
    pivots = m - nv
    return Rows(
        x=n,
        dx=n,
        g=n,
        dead=n,
        M_fixed=3 * len(loads.node),
        M_turning=3 * len(loads.node),
        F_turning=3 * len(loads.turning_load),
        trust=1,
        signs=2,
        E=3 * m,
        dE=3 * m,
        V=3 * g,
        dV=3 * g,
        gamma=pairs,
        T=pairs,
        Q=3 * points * g,
        U=3 * (len(elastic.u_start) - 1),
        K_v=9 * pairs,
        K_N=9 * points * g * m,
        front=9 * m * m,
        carry=9 * nv * nv,
        W=9 * elements * pivots * m,
        W_end=9 * nv * nv,
        node=3 * nv,
    )


def _aligned(rows: int, lanes: int) -> Floats:
    """Memory (rows, lanes) that begins on a cache line, so that no register straddles two."""
    memory = np.zeros(rows * lanes + CACHE_LINE // 8)
    skip = (-memory.ctypes.data % CACHE_LINE) // 8
    return memory[skip : skip + rows * lanes].reshape(rows, lanes)
