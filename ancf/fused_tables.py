r"""Tables of the fused kernel: one rod as index lists and coefficients, everything dimensionless.

The kernel walks the elements from x = 0 to x = L and eliminates as it goes (a frontal method): the *front* of
an element holds the nodal vectors of its inner nodes, then of its first node, then of its last one; the first
two groups are eliminated, the last is carried to the next element. Vectors that a support holds altogether
are no unknowns and are left out of the lists.

At one axial point the material part of the tangent on the generalised vectors v (energy.py) is

    K_ab = sum_d u_(a,bd) v_d^T,   u_(a,q) = sum_c f_ac f_q H_(ac),q v_c,   f_p = 2 on the diagonal, else 1.

H of a straight section with two axes of symmetry has 27 of 225 entries: only those are listed.

Symbols
-------
m, g, P     nodal vectors of an element in front order, generalised vectors, their products
unit        L^(1 - order) of each nodal vector;  energy E_u = E I/L;  forces in E_u / unit
N           (kinds, points, g, m) map to the generalised vectors, times unit
H           (kinds, points, P, P) section stiffness with axial weight, by E_u
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancf.elements import R
from ancf.model import Model
from ancf.rod_model import RodModel
from ancf.section_energy import pairs
from ancf.section_law import QuadraticSection

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Entries of H below this share of the diagonal are rounding of the section quadrature.
ROUNDING = 1e-14


class MeshTables(NamedTuple):
    """Which unknowns belong to which element, in front order."""

    dofs: Indices  # (n_el, m) first of the three unknowns of each nodal vector
    relative: Indices  # (m,) 1 where the vector is a position, which enters relative to the first node's
    anchor: int  # front place of the first node's position
    kind: Indices  # (n_el,)
    active: Indices  # (n_el, m) front places that are unknowns, then -1
    counts: Indices  # (n_el, 2) how many of them are eliminated here, and all
    end: Indices  # places among the last node's vectors that are unknowns
    free: Indices  # (n / 3,) 1 where a nodal vector is an unknown


class ElasticTables(NamedTuple):
    """Elastic kernel: lists `x_start` delimit the entries of each row, as in compressed sparse rows."""

    N: Floats
    row_start: Indices  # rows of N: (g + 1,)
    row_at: Indices  # ... their columns, the anchor left out
    column_start: Indices  # columns of N: (m + 1,)
    column_at: Indices
    i: Indices  # (P,) pairs i <= j
    j: Indices
    pair: Indices  # (g, g) place of a pair
    products0: Floats  # (kinds, points, P) reference products
    H_start: Indices
    H_at: Indices
    H: Floats  # (kinds, points, entries)
    u_start: Indices
    u_vector: Indices  # the c of each entry
    u: Floats  # (kinds, points, entries) f_ac f_q H
    K_start: Indices  # blocks a <= b in the order of the pairs
    K_u: Indices
    K_vector: Indices  # the d of each entry
    normal: Indices  # (3,) the generalised vectors r_x, r_y, r_z on the axis


class ProjectorTables(NamedTuple):
    """Supports that hold combinations of a node's components (free-section clamps)."""

    element: Indices  # (n,)
    place: Indices  # (n,) first front place of the node
    first: Indices  # (n,) 1 where the element is the one that gets the identity of what is held
    P: Floats  # (n, 3 nv, 3 nv)
    dof: Indices  # (n,) first unknown of the node


def front_order(rod: RodModel) -> Indices:
    """Front place -> nodal vector of the element: inner nodes, first node, last node."""
    nv, nodes = len(rod.element.vectors), len(rod.element.node_xi)
    order = [*range(1, nodes - 1), 0, nodes - 1]
    return np.concatenate([node * nv + np.arange(nv) for node in order])


def vector_units(rod: RodModel) -> Floats:
    """L^(1 - order) of each vector of a node (nv,)."""
    return np.array([rod.rod.length ** (1.0 - sum(order)) for order in rod.element.vectors])


def held_vectors(model: Model) -> tuple[NDArray[np.bool_], dict[int, Floats]]:
    """Nodal vectors (n / 3,) that supports hold altogether, and the projectors of the nodes with others.

    The keys are the first unknowns of the nodes.
    """
    held = np.zeros(model.n // 3, dtype=bool)
    mixed: dict[int, Floats] = {}
    for support in model.supports:
        first = int(support.dofs[0])
        projector = mixed.pop(first, np.eye(len(support.dofs)))
        projector = support.projector @ projector
        blocks = projector.reshape(-1, 3, projector.shape[1])
        zero = ~blocks.any(axis=(1, 2))
        held[support.dofs[::3] // 3] |= zero
        free = projector.copy()
        free[np.repeat(zero, 3), np.repeat(zero, 3)] = 1.0
        if not np.array_equal(free, np.eye(len(free))):
            mixed[first] = projector
    return held, mixed


def mesh_tables(rod: RodModel, held: NDArray[np.bool_]) -> MeshTables:
    """Lists of unknowns of each element."""
    element = rod.element
    nv = len(element.vectors)
    order = front_order(rod)
    dofs = 3 * (rod.mesh.nodes_of[:, order // nv] * nv + order % nv)
    pivots = len(order) - nv
    active = np.full(dofs.shape, -1)
    counts = np.empty((len(dofs), 2), dtype=np.int64)
    for index, row in enumerate(dofs):
        places = np.flatnonzero(~held[row // 3])
        active[index, : len(places)] = places
        counts[index] = np.count_nonzero(places < pivots), len(places)
    return MeshTables(
        dofs=np.ascontiguousarray(dofs, dtype=np.int64),
        relative=np.array([element.vectors[v % nv] == R for v in order], dtype=np.int64),
        anchor=pivots - nv + element.vectors.index(R),
        kind=np.asarray(rod.element_kinds[1], dtype=np.int64),
        active=active.astype(np.int64),
        counts=counts,
        end=np.flatnonzero(~held[dofs[-1, pivots:] // 3]).astype(np.int64),
        free=(~held).astype(np.int64),
    )


def elastic_tables(rod: RodModel) -> ElasticTables:
    """Index lists and coefficients of the elastic kernel."""
    element, elastic = rod.element, rod.elastic
    first, _ = rod.element_kinds
    order, kinds = front_order(rod), len(first)
    energy = rod.bending_stiffness / rod.rod.length
    rows = first if len(elastic.N) > 1 else [0] * kinds
    N = (elastic.N[rows] * np.tile(vector_units(rod), len(element.node_xi)))[..., order]
    assert isinstance(elastic.section, QuadraticSection)
    H = elastic.section.H[first if len(elastic.section.H) > 1 else [0] * kinds] / energy
    i, j = pairs(N.shape[2])
    g = N.shape[2]
    pair = np.zeros((g, g), dtype=np.int64)
    pair[i, j] = pair[j, i] = np.arange(len(i))
    v0 = elastic.v0[first]
    products0 = np.ascontiguousarray(np.sum(v0[:, :, i] * v0[:, :, j], axis=-1))

    anchor = mesh_anchor(rod)
    used = np.any(N != 0.0, axis=(0, 1))
    without_anchor = used.copy()
    without_anchor[:, anchor] = False
    size = np.sqrt(np.einsum("kpaa->kpa", H))
    listed = np.any(np.abs(H) > ROUNDING * size[..., None] * size[..., None, :], axis=(0, 1))

    row_start, row_at = _lists(without_anchor)
    column_start, column_at = _lists(used.T)
    H_start, H_at = _lists(listed)
    row_of = np.repeat(np.arange(len(i)), np.diff(H_start))

    u_index: dict[tuple[int, int], int] = {}  # (a, q) -> place
    u_start, u_vector, u_value = [0], [], []
    blocks: list[list[tuple[int, int]]] = []
    for a, b in zip(i, j, strict=True):
        terms = []
        for d in range(g):
            q = int(pair[b, d])
            if (a, q) not in u_index:
                entries = [c for c in range(g) if listed[pair[a, c], q]]
                if not entries:
                    continue
                u_index[a, q] = len(u_index)
                factor = 2.0 if b == d else 1.0
                for c in entries:
                    u_vector.append(c)
                    u_value.append((2.0 if a == c else 1.0) * factor * H[:, :, pair[a, c], q])
                u_start.append(len(u_vector))
            terms.append((u_index[a, q], d))
        blocks.append(terms)
    count = len(element.directors)
    return ElasticTables(
        N=np.ascontiguousarray(N),
        row_start=row_start,
        row_at=row_at,
        column_start=column_start,
        column_at=column_at,
        i=i.astype(np.int64),
        j=j.astype(np.int64),
        pair=pair,
        products0=products0,
        H_start=H_start,
        H_at=H_at,
        H=np.ascontiguousarray(H[:, :, row_of, H_at]),
        u_start=np.array(u_start),
        u_vector=np.array(u_vector),
        u=np.ascontiguousarray(np.moveaxis(np.array(u_value), 0, -1)),
        K_start=np.cumsum([0, *map(len, blocks)]),
        K_u=np.array([u for terms in blocks for u, _ in terms], dtype=np.int64),
        K_vector=np.array([d for terms in blocks for _, d in terms], dtype=np.int64),
        normal=np.array([0, count + element.y_director - 1, count + element.z_director - 1]),
    )


def mesh_anchor(rod: RodModel) -> int:
    """Front place of the first node's position."""
    nv = len(rod.element.vectors)
    return (len(rod.element.node_xi) - 2) * nv + rod.element.vectors.index(R)


def projector_tables(rod: RodModel, mesh: MeshTables, mixed: dict[int, Floats]) -> ProjectorTables:
    """Where the projectors of `held_vectors` act: on both elements of their node."""
    nv, m = len(rod.element.vectors), mesh.dofs.shape[1]
    found = []
    for dof, P in mixed.items():
        touching = [(e, p) for e in range(len(mesh.dofs)) for p in range(0, m, nv) if mesh.dofs[e, p] == dof]
        found += [(e, p, index == 0, dof, P) for index, (e, p) in enumerate(touching)]
    found.sort(key=lambda entry: entry[:2])  # the kernel meets them element by element
    columns = [np.array([entry[k] for entry in found], dtype=np.int64) for k in range(4)]
    P = np.array([entry[4] for entry in found]).reshape(len(found), 3 * nv, 3 * nv)
    return ProjectorTables(columns[0], columns[1], columns[2], P, columns[3])


def _lists(present: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Compressed rows of a pattern: where each row starts, and the columns."""
    start = np.concatenate([[0], np.cumsum(present.sum(axis=1))])
    return start.astype(np.int64), np.nonzero(present)[1].astype(np.int64)
