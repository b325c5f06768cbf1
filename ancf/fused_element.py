r"""Elastic force and tangent of one element for several samples at once (energy.py, section_energy.py).

With the tables of fused_tables.py, at each axial point of an element with nodal vectors e:

    v = N e,   gamma_p = v_i . v_j - v0_i . v0_j,   T = H gamma,   Q = N^T (S v),   S_ij = T_ij, 2 T_ii,
    K = N^T (B^T H B + S~ (x) I) N,   T~ = T - H delta,   delta_p = dv_i . dv_j.

T~ is the stress that the last linear step dv predicted (mixed integration point): v_o . v + v . v_o - v_o .
v_o = v . v - dv . dv with v_o = v - dv, so no stress is stored. A start that was bent to its loads node by
node has strains of interpolation, and stiff axes and sections make them stresses that say nothing: its
first tangent goes without (`trust` 0). Measured on the 1520 moments of issue 5: none lost instead of up to
six, 4.0 iterations instead of 4.2.

Symbols
-------
x, dx    coordinates and last step of the whole rod (n,);  G its right-hand side, minus the residual
E, dE    the same of the element, in front order, positions relative to the first node
V, dV    generalised vectors;  gamma, T products and stress;  S resultants by pair, doubled on the diagonal
U, K_v   vectors u and blocks on the generalised vectors, K_N = K_v N of all points
"""

from __future__ import annotations

from ancf.fused_blocks import (
    block,
    block_plus_scaled,
    block_scaled,
    compiled,
    cross,
    dot,
    inlined,
    minus,
    plus_outer,
    plus_scaled,
    put_block,
    put_vector,
    scaled,
    transposed,
    vector,
)


@inlined
def element_vectors(E, x, dofs, relative, anchor):
    """Nodal vectors of an element, positions relative to its first node."""
    origin = vector(x, dofs[anchor])
    for n in range(len(dofs)):
        e = vector(x, dofs[n])
        put_vector(E, 3 * n, minus(e, origin) if relative[n] else e)


@inlined
def generalised(V, E, N, start, at):
    """v_a = sum_n N_an e_n at one point."""
    for a in range(len(start) - 1):
        first = start[a]
        v = scaled(N[a, at[first]], vector(E, 3 * at[first]))
        for k in range(first + 1, start[a + 1]):
            v = plus_scaled(v, N[a, at[k]], vector(E, 3 * at[k]))
        put_vector(V, 3 * a, v)


@inlined
def stress(T, gamma, H, start, at):
    """T_p = sum_q H_pq gamma_q."""
    for p in range(len(start) - 1):
        first = start[p]
        t = H[first] * gamma[at[first]]
        for k in range(first + 1, start[p + 1]):
            t = t + H[k] * gamma[at[k]]
        T[p] = t


@inlined
def products(gamma, V, i, j, products0):
    """gamma_p = v_i . v_j - v0_i . v0_j."""
    for p in range(len(i)):
        gamma[p] = dot(vector(V, 3 * i[p]), vector(V, 3 * j[p])) - products0[p]


@inlined
def vector_force(Q, V, T, pair, first):
    """Q_a = sum_b S_ab v_b, from row `first` on."""
    g = len(pair)
    for a in range(g):
        c = T[pair[a, a]]
        q = scaled(c + c, vector(V, 3 * a))
        for b in range(g):
            if b != a:
                q = plus_scaled(q, T[pair[a, b]], vector(V, 3 * b))
        put_vector(Q, 3 * (first + a), q)


@inlined
def subtract_force(G, Q, N, start, at, dofs):
    """G -= N^T Q, summed over the points."""
    points, g = N.shape[0], N.shape[1]
    for n in range(len(dofs)):
        f = vector(G, dofs[n])
        for point in range(points):
            for k in range(start[n], start[n + 1]):
                f = plus_scaled(f, -N[point, at[k], n], vector(Q, 3 * (point * g + at[k])))
        put_vector(G, dofs[n], f)


@inlined
def stress_vectors(U, V, start, at, coefficient):
    """u = sum_c coefficient_c v_c."""
    for k in range(len(start) - 1):
        first = start[k]
        u = scaled(coefficient[first], vector(V, 3 * at[first]))
        for entry in range(first + 1, start[k + 1]):
            u = plus_scaled(u, coefficient[entry], vector(V, 3 * at[entry]))
        put_vector(U, 3 * k, u)


@inlined
def blocks(K_v, U, V, T, tables):
    """K_ab = sum_d u_(a,bd) v_d^T + S_ab I for a <= b."""
    start = tables.K_start
    for p in range(len(start) - 1):
        t = T[p]
        s = t + t if tables.i[p] == tables.j[p] else t
        zero = t - t
        A = (s, zero, zero, zero, s, zero, zero, zero, s)
        for entry in range(start[p], start[p + 1]):
            A = plus_outer(A, vector(U, 3 * tables.K_u[entry]), vector(V, 3 * tables.K_vector[entry]))
        put_block(K_v, 9 * p, A)


@inlined
def _symmetric_block(K_v, a, b, pair):
    """Block (a, b) of a symmetric matrix of which only the upper half is kept."""
    B = block(K_v, 9 * pair[a, b])
    return B if a <= b else transposed(B)


@inlined
def half(K_N, K_v, N, first, tables, active, count):
    """Rows `first` to `first` + g of K_N = K_v N, for the unknowns of the element."""
    g, m = N.shape
    start, at = tables.column_start, tables.column_at
    for a in range(g):
        for place in range(count):
            n = active[place]
            k = start[n]
            B = block_scaled(N[at[k], n], _symmetric_block(K_v, a, at[k], tables.pair))
            for k in range(start[n] + 1, start[n + 1]):
                B = block_plus_scaled(B, N[at[k], n], _symmetric_block(K_v, a, at[k], tables.pair))
            put_block(K_N, 9 * ((first + a) * m + n), B)


@inlined
def element_block(K_N, N, i, j, start, at):
    """Block (i, j) of K = N^T K_v N, summed over the points."""
    points, g, m = N.shape
    k = start[i]
    A = block_scaled(N[0, at[k], i], block(K_N, 9 * (at[k] * m + j)))
    for k in range(start[i] + 1, start[i + 1]):
        A = block_plus_scaled(A, N[0, at[k], i], block(K_N, 9 * (at[k] * m + j)))
    for point in range(1, points):
        for k in range(start[i], start[i + 1]):
            A = block_plus_scaled(A, N[point, at[k], i], block(K_N, 9 * ((point * g + at[k]) * m + j)))
    return A


@compiled
def element_force(G, x, e, mesh, tables, w, smallest):
    """Subtract the elastic force of element e from G.

    Returns the smaller of `smallest` and det [r_x r_y r_z] at its axial points.
    """
    dofs, kind, g = mesh.dofs[e], mesh.kind[e], len(tables.pair)
    element_vectors(w.E, x, dofs, mesh.relative, mesh.anchor)
    r_x, r_y, r_z = tables.normal
    for point in range(tables.N.shape[1]):
        generalised(w.V, w.E, tables.N[kind, point], tables.row_start, tables.row_at)
        products(w.gamma, w.V, tables.i, tables.j, tables.products0[kind, point])
        stress(w.T, w.gamma, tables.H[kind, point], tables.H_start, tables.H_at)
        vector_force(w.Q, w.V, w.T, tables.pair, point * g)
        area = cross(vector(w.V, 3 * r_y), vector(w.V, 3 * r_z))
        smallest = min(dot(vector(w.V, 3 * r_x), area), smallest)
    subtract_force(G, w.Q, tables.N[kind], tables.column_start, tables.column_at, dofs)
    return smallest


@compiled
def element_tangent(G, x, dx, e, mesh, tables, w):
    """Subtract the elastic force of element e from G and leave K_v N of its points in w.K_N."""
    dofs, kind, g = mesh.dofs[e], mesh.kind[e], len(tables.pair)
    element_vectors(w.E, x, dofs, mesh.relative, mesh.anchor)
    element_vectors(w.dE, dx, dofs, mesh.relative, mesh.anchor)
    trust = w.trust[0]
    for point in range(tables.N.shape[1]):
        N, H = tables.N[kind, point], tables.H[kind, point]
        generalised(w.V, w.E, N, tables.row_start, tables.row_at)
        generalised(w.dV, w.dE, N, tables.row_start, tables.row_at)
        products(w.gamma, w.V, tables.i, tables.j, tables.products0[kind, point])
        stress(w.T, w.gamma, H, tables.H_start, tables.H_at)
        vector_force(w.Q, w.V, w.T, tables.pair, point * g)
        for p in range(len(tables.i)):
            w.gamma[p] = trust * w.gamma[p] - dot(
                vector(w.dV, 3 * tables.i[p]), vector(w.dV, 3 * tables.j[p])
            )
        stress(w.T, w.gamma, H, tables.H_start, tables.H_at)
        stress_vectors(w.U, w.V, tables.u_start, tables.u_vector, tables.u[kind, point])
        blocks(w.K_v, w.U, w.V, w.T, tables)
        half(w.K_N, w.K_v, N, point * g, tables, mesh.active[e], mesh.counts[e, 1])
    subtract_force(G, w.Q, tables.N[kind], tables.column_start, tables.column_at, dofs)
