r"""Elimination of one front after the other in 3 x 3 blocks, for several samples at once.

With the pivot block D = A_kk, its rows W_kj = D^-1 A_kj and y_k = D^-1 g_k,

    A_ij -= A_ik W_kj,   g_i -= A_ik y_k;     backwards   x_k = y_k - sum_j>k W_kj x_j.

Only the upper half is touched where the front is symmetric (A_ik = A_ki^T). There is no pivoting: an elastic
tangent with all its unknowns has pivots of the size of its stiffness, and a sample whose pivot vanishes fails
alone. The tangent of a moment is unsymmetric: from its node on, whole fronts are eliminated.
"""

from __future__ import annotations

from numba import njit

from ancf.fused_blocks import (
    block,
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


@njit(nogil=True)
def mirror(A, active, count, m):
    """Fill the lower half of a front from the upper."""
    for row in range(count):
        i = active[row]
        for column in range(row):
            j = active[column]
            put_block(A, 9 * (i * m + j), transposed(block(A, 9 * (j * m + i))))


@njit(nogil=True)
def eliminate(A, g, W, y, dofs, active, pivots, count, m, symmetric):
    """Eliminate the first `pivots` of the `count` unknown vectors listed in `active` from a front.

    Parameters
    ----------
    A : front of m x m blocks;  g : right-hand side of the whole rod, at `dofs` of the front places
    W : receives W_kj at block k m + j;  y : receives y_k at `dofs`
    """
    for step in range(pivots):
        k = active[step]
        D = inverse(block(A, 9 * (k * m + k)))
        y_k = times_vector(D, vector(g, dofs[k]))
        put_vector(y, dofs[k], y_k)
        for column in range(step + 1, count):
            j = active[column]
            put_block(W, 9 * (k * m + j), product(D, block(A, 9 * (k * m + j))))
        for row in range(step + 1, count):
            i = active[row]
            B = transposed(block(A, 9 * (k * m + i))) if symmetric else block(A, 9 * (i * m + k))
            put_vector(g, dofs[i], minus_times_vector(vector(g, dofs[i]), B, y_k))
            for column in range(row if symmetric else step + 1, count):
                j = active[column]
                at = 9 * (i * m + j)
                put_block(A, at, minus_product(block(A, at), B, block(W, 9 * (k * m + j))))


@njit(nogil=True)
def substitute(W, x, dofs, active, pivots, count, m):
    """x_k = y_k - sum_j>k W_kj x_j for the pivots of one front, last first; x holds y before."""
    for step in range(pivots - 1, -1, -1):
        k = active[step]
        x_k = vector(x, dofs[k])
        for column in range(step + 1, count):
            j = active[column]
            x_k = minus_times_vector(x_k, block(W, 9 * (k * m + j)), vector(x, dofs[j]))
        put_vector(x, dofs[k], x_k)


@njit(nogil=True)
def take_carry(A, carry, place, nv, m, symmetric):
    """Add what earlier elements left on a node, nv x nv blocks, to the front from `place` on."""
    for r in range(nv):
        for s in range(r if symmetric else 0, nv):
            at = 9 * ((place + r) * m + place + s)
            source = 9 * (r * nv + s)
            for k in range(9):
                A[at + k] = A[at + k] + carry[source + k]


@njit(nogil=True)
def leave_carry(carry, A, place, nv, m, symmetric):
    """Copy what an element leaves on its last node, as a whole matrix."""
    for r in range(nv):
        for s in range(r if symmetric else 0, nv):
            B = block(A, 9 * ((place + r) * m + place + s))
            put_block(carry, 9 * (r * nv + s), B)
            if symmetric and r != s:
                put_block(carry, 9 * (s * nv + r), transposed(B))


@njit(nogil=True)
def project(A, P, place, nv, m, first, scratch):
    """P A P on the rows and columns of one node of a whole front.

    P (3 nv, 3 nv) is the projector of the supports; where `first`, what they hold gets a 1 on the diagonal.
    """
    size = 3 * nv
    for n in range(3 * m):
        for side in range(2):
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


@njit(nogil=True)
def project_vector(g, dof, P, scratch):
    """P g on one node."""
    for s in range(len(P)):
        scratch[s] = g[dof + s]
    for r in range(len(P)):
        total = P[r, 0] * scratch[0]
        for s in range(1, len(P)):
            total = total + P[r, s] * scratch[s]
        g[dof + r] = total


@njit(nogil=True)
def _entry(m, row, column):
    """Place of a scalar entry of a front stored in blocks."""
    return 9 * ((row // 3) * m + column // 3) + 3 * (row % 3) + column % 3
