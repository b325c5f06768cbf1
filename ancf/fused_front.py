r"""Elimination of one front after the other in 3 x 3 blocks, for several samples at once.

With the pivot block D = A_kk, its rows W_kj = D^-1 A_kj and y_k = D^-1 g_k,

    A_ij -= A_ik W_kj,   g_i -= A_ik y_k;     backwards   x_k = y_k - sum_j>k W_kj x_j.

Row by row: a block gathers its share of the element and of all pivots before it in registers, and is stored
once. Only the upper half is touched where the front is symmetric (A_ik = A_ki^T). The tangent of a moment is
unsymmetric: from its node on, whole fronts are eliminated.

There is no pivoting: near a stable equilibrium no pivot is small, and a sample whose pivot vanishes fails
alone. The signs of the pivots tell a minimum of the potential from other equilibria (stepping.py).
"""

from __future__ import annotations

from ancf.fused_blocks import (
    block,
    block_plus,
    compiled,
    inlined,
    inverse,
    minus_product,
    minus_times_vector,
    product,
    put_block,
    put_vector,
    times_vector,
    transposed,
    vector,
)
from ancf.fused_element import element_block

HUGE = 1e300


@inlined
def _eliminated(A, W, block_ij, i, j, active, steps, m, symmetric):
    """A_ij - sum_k A_ik W_kj over the first pivots."""
    for step in range(steps):
        k = active[step]
        B = transposed(block(A, 9 * (k * m + i))) if symmetric else block(A, 9 * (i * m + k))
        block_ij = minus_product(block_ij, B, block(W, 9 * (k * m + j)))
    return block_ij


@inlined
def _note_signs(signs, A, determinant):
    """Keep the least leading minor of all pivot blocks in row 0 and the sign of the determinant in row 1."""
    one = determinant - determinant + 1.0
    minors = min(A[0], A[0] * A[4] - A[1] * A[3])
    signs[0] = min(min(minors, determinant), signs[0])
    signs[1] = signs[1] * min(max(HUGE * determinant, -1.0 * one), one)


@inlined
def _eliminate_row(A, g, W, y, signs, dofs, active, row, pivots, count, m, symmetric):
    """Right-hand side of a row whose blocks are eliminated; W and y where it is a pivot."""
    i = active[row]
    g_i = vector(g, dofs[i])
    for step in range(min(row, pivots)):
        k = active[step]
        B = transposed(block(A, 9 * (k * m + i))) if symmetric else block(A, 9 * (i * m + k))
        g_i = minus_times_vector(g_i, B, vector(y, dofs[k]))
    put_vector(g, dofs[i], g_i)
    if row < pivots:
        pivot = block(A, 9 * (i * m + i))
        D, determinant = inverse(pivot)
        _note_signs(signs, pivot, determinant)
        put_vector(y, dofs[i], times_vector(D, g_i))
        for column in range(row + 1, count):
            j = active[column]
            put_block(W, 9 * (i * m + j), product(D, block(A, 9 * (i * m + j))))


@compiled
def eliminate_element(
    A, K_N, N, start, at, carry, g, W, y, signs, dofs, active, pivots, count, nv, symmetric
):
    """Assemble the front of an element and eliminate its first `pivots` unknown vectors.

    Parameters
    ----------
    A : front of m x m blocks, scratch;  K_N, N, start, at : the element's tangent (`element_block`)
    carry : what earlier elements left on the first node
    g : right-hand side of the whole rod, at `dofs` of the front places
    W : receives W_kj at block k m + j;  y : receives y_k at `dofs`;  signs : see `_note_signs`
    active : the `count` front places that are unknowns
    """
    m = N.shape[2]
    node = m - 2 * nv
    for row in range(count):
        i = active[row]
        for column in range(row if symmetric else 0, count):
            j = active[column]
            B = element_block(K_N, N, i, j, start, at)
            if node <= i < node + nv and node <= j < node + nv:
                B = block_plus(B, block(carry, 9 * ((i - node) * nv + j - node)))
            B = _eliminated(A, W, B, i, j, active, min(min(row, column), pivots), m, symmetric)
            put_block(A, 9 * (i * m + j), B)
        _eliminate_row(A, g, W, y, signs, dofs, active, row, pivots, count, m, symmetric)


@compiled
def eliminate(A, g, W, y, signs, dofs, active, pivots, count, m):
    """Eliminate the first `pivots` unknown vectors from a whole front that is assembled already."""
    for row in range(count):
        i = active[row]
        for column in range(count):
            j = active[column]
            at = 9 * (i * m + j)
            steps = min(min(row, column), pivots)
            put_block(A, at, _eliminated(A, W, block(A, at), i, j, active, steps, m, False))
        _eliminate_row(A, g, W, y, signs, dofs, active, row, pivots, count, m, False)


@compiled
def assemble(A, K_N, N, start, at, active, count):
    """Fill the whole front of an element."""
    m = N.shape[2]
    for k in range(9 * m * m):
        A[k] = 0.0
    for row in range(count):
        for column in range(count):
            i, j = active[row], active[column]
            put_block(A, 9 * (i * m + j), element_block(K_N, N, i, j, start, at))


@compiled
def substitute(W, x, dofs, active, pivots, count, m):
    """x_k = y_k - sum_j>k W_kj x_j for the pivots of one front, last first; x holds y before."""
    for step in range(pivots - 1, -1, -1):
        k = active[step]
        x_k = vector(x, dofs[k])
        for column in range(step + 1, count):
            j = active[column]
            x_k = minus_times_vector(x_k, block(W, 9 * (k * m + j)), vector(x, dofs[j]))
        put_vector(x, dofs[k], x_k)


@compiled
def take_carry(A, carry, node, nv, m):
    """Add what earlier elements left on a node, nv x nv blocks, to a whole front."""
    for r in range(nv):
        for s in range(nv):
            at = 9 * ((node + r) * m + node + s)
            put_block(A, at, block_plus(block(A, at), block(carry, 9 * (r * nv + s))))


@compiled
def leave_carry(carry, A, place, nv, m, symmetric):
    """Copy what an element leaves on its last node, as a whole matrix."""
    for r in range(nv):
        for s in range(r if symmetric else 0, nv):
            B = block(A, 9 * ((place + r) * m + place + s))
            put_block(carry, 9 * (r * nv + s), B)
            if symmetric and r != s:
                put_block(carry, 9 * (s * nv + r), transposed(B))


@compiled
def project(A, P, place, nv, m, first, scratch):
    """P A P on the rows and columns of one node of a whole front.

    P (3 nv, 3 nv) is the projector of the supports; where `first`, what they hold gets a 1 on the diagonal.
    """
    size = 3 * nv
    for side in range(2):  # A P, then P (A P)
        for n in range(3 * m):
            for s in range(size):
                scratch[s] = A[_entry(m, 3 * place + s, n) if side else _entry(m, n, 3 * place + s)]
            for r in range(size):
                total = P[r, 0] * scratch[0]
                for s in range(1, size):
                    total = total + P[r, s] * scratch[s]
                A[_entry(m, 3 * place + r, n) if side else _entry(m, n, 3 * place + r)] = total
    if first:
        for r in range(size):
            for s in range(size):
                at = _entry(m, 3 * place + r, 3 * place + s)
                A[at] = A[at] + ((1.0 if r == s else 0.0) - P[r, s])


@compiled
def project_vector(g, dof, P, scratch):
    """P g on one node."""
    for s in range(len(P)):
        scratch[s] = g[dof + s]
    for r in range(len(P)):
        total = P[r, 0] * scratch[0]
        for s in range(1, len(P)):
            total = total + P[r, s] * scratch[s]
        g[dof + r] = total


@compiled
def _entry(m, row, column):
    """Place of a scalar entry of a front stored in blocks."""
    return 9 * ((row // 3) * m + column // 3) + 3 * (row % 3) + column % 3
