"""Assembly and linear solution of the solid reference: pattern and slots once, one `bincount` per iteration.

Symbols: `u` nodal displacement (n, 3) [m], `B` shape function gradients, `F` deformation gradient, `P_pk1`
first Piola-Kirchhoff stress, `A_pk1` its tangent, `Q_int` nodal forces [N], `K` tangent [N/m].
Arrays at integration points have the shape (n_el, n_qp, ...).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs
from scipy.sparse import bsr_array, csr_array
from skfem import Basis, ElementHex2

from reference.solid_mesh import RodMesh

Array = NDArray[np.float64]

getrf, getrs = get_lapack_funcs(("getrf", "getrs"), dtype=np.float64)

VOLUME_ORDER = 5  # 27 points; 8 points leave the 27-node element rank deficient (reference study)


class SolidAssembly:
    """Discrete operators of one rod mesh with supports.

    Parameters
    ----------
    mesh : RodMesh
        The mesh.
    fixed : (n, 3) bool
        Held displacement components. Their rows and columns become those of the identity, so the
        pattern never changes.
    """

    def __init__(self, mesh: RodMesh, fixed: NDArray[np.bool_]) -> None:
        basis = Basis(mesh.hexes, ElementHex2(), intorder=VOLUME_ORDER)
        gradients = np.stack([np.moveaxis(np.asarray(f[0].grad), 0, -1) for f in basis.basis])
        self.mesh = mesh
        self.fixed = fixed
        self.B = np.ascontiguousarray(np.moveaxis(gradients, 0, -1))  # (n_el, n_qp, 3, 27)
        self.volume = np.asarray(basis.dx)  # (n_el, n_qp)
        n_el, n_qp = self.volume.shape
        weighted = self.B * self.volume[..., None, None]
        self._B_left = np.ascontiguousarray(weighted.reshape(n_el, n_qp * 3, 27).swapaxes(1, 2))
        self._find_pattern()

    def deformation_gradient(self, u: Array) -> Array:
        """Deformation gradient, F = I + du/dX (n_el, n_qp, 3, 3) [-]."""
        return np.eye(3) + self.gradient(u)

    def gradient(self, u: Array) -> Array:
        """Displacement gradient du_i/dX_J (n_el, n_qp, 3, 3) [-]."""
        return (self.B @ u[self.mesh.elements][:, None]).swapaxes(-1, -2)

    def integrate(self, density: Array) -> float:
        """Integral of a density (n_el, n_qp) over the reference volume."""
        return float(np.sum(self.volume * density))

    def internal_force(self, P_pk1: Array) -> Array:
        """Nodal forces, Q_int_ai = int P_iJ dN_a/dX_J dV (n, 3) [N]."""
        n_el = len(P_pk1)
        nodal = self._B_left @ P_pk1.swapaxes(-1, -2).reshape(n_el, -1, 3)
        slot = 3 * self.mesh.elements[..., None] + np.arange(3)
        total = np.bincount(slot.ravel(), nodal.ravel(), minlength=3 * len(self.mesh.nodes))
        return np.asarray(total, float).reshape(-1, 3)

    def tangent(self, A_pk1: Array, K_load: Array | None = None) -> csr_array:
        """Tangent, K_aibk = int dN_a/dX_J A_iJkL dN_b/dX_L dV - K_load, supports applied.

        `A_pk1` (n_el, n_qp, 3, 3, 3, 3) [Pa]; `K_load` (3 ns, 3 ns) [N/m] acts on the end section.
        """
        n_el, n_qp = self.volume.shape
        T = np.moveaxis(A_pk1, 3, 2).reshape(n_el, n_qp, 27, 3) @ self.B  # rows J i k, columns b
        K_el = self._B_left @ T.reshape(n_el, 3 * n_qp, 243)
        data = np.asarray(np.bincount(self._slots, K_el.ravel(), minlength=len(self._held)), float)
        if K_load is not None:
            data[self._end_slots] -= K_load.ravel()
        data[self._held] = 0.0
        data[self._held_diagonal] = 1.0
        n_nodes = len(self.mesh.nodes)
        blocks = data.reshape(-1, 3, 3)
        return csr_array(bsr_array((blocks, self._indices, self._indptr), shape=(3 * n_nodes, 3 * n_nodes)))

    def solve(self, K: csr_array, right: Array) -> Array:
        """Solve K du = right (n, 3); the block of a slice is its first plane and its middle plane."""
        size = 6 * len(self.mesh.section.nodes)
        starts = [*range(0, right.size, size), right.size]
        return solve_block_tridiagonal(K, right.ravel(), starts).reshape(-1, 3)

    def _find_pattern(self) -> None:
        """Node-wise pattern of the mesh plus the dense end section, and the slot of every entry."""
        elements, n_nodes = self.mesh.elements, len(self.mesh.nodes)
        end = self.mesh.plane(-1)
        pair = elements[:, :, None] * n_nodes + elements[:, None, :]  # (n_el, a, b)
        end_pair = end[:, None] * n_nodes + end
        keys, slot = np.unique(np.concatenate([pair.ravel(), end_pair.ravel()]), return_inverse=True)
        row, self._indices = np.divmod(keys, n_nodes)
        self._indptr = np.searchsorted(row, np.arange(n_nodes + 1))

        i, k = np.arange(3)[:, None], np.arange(3)
        element_slot = slot[: pair.size].reshape(pair.shape)
        # order a i k b, as the products in `tangent` leave the entries
        slots = 9 * element_slot[:, :, None, None, :] + (3 * i + k)[:, :, None]
        self._slots = slots.ravel()
        end_slot = slot[pair.size :].reshape(end_pair.shape)
        self._end_slots = (9 * end_slot[:, None, :, None] + 3 * i[:, :, None] + k).ravel()  # a i b k

        fixed_row, fixed_col = self.fixed[row], self.fixed[self._indices]
        self._held = (fixed_row[:, :, None] | fixed_col[:, None, :]).ravel()
        diagonal = (row == self._indices)[:, None, None] & np.eye(3, dtype=bool)
        self._held_diagonal = self._held & diagonal.ravel()


def solve_block_tridiagonal(K: csr_array, right: Array, starts: list[int]) -> Array:
    """Solve K x = right by dense LU of the blocks between `starts`, pivoting inside each block.

    Unsymmetric and indefinite K are allowed: the tangent of a bent rod is indefinite along Newton.
    Cost O(n b^2) for blocks of size b.

    Raises
    ------
    numpy.linalg.LinAlgError
        When a pivot block is singular.
    """
    b = right.astype(float)
    shared, y, Y = np.zeros(0, int), np.zeros(0), np.zeros((0, 0))
    kept = []
    for block, (start, stop) in enumerate(pairwise(starts)):
        strip, first = _dense_rows(K, start, stop)
        pivot, upper = strip[:, start - first : stop - first], strip[:, stop - first :]
        if block:
            # Only the plane between two slices couples them: skip the empty rows and columns.
            lower = strip[:, : start - first]
            rows = np.flatnonzero(lower.any(axis=1))
            pivot[np.ix_(rows, shared - start)] -= lower[rows] @ Y[len(Y) - lower.shape[1] :]
            b[start + rows] -= lower[rows] @ y[len(y) - lower.shape[1] :]
        lu, piv, info = getrf(pivot)
        if info != 0:
            raise np.linalg.LinAlgError(f"pivot block {block} of {len(starts) - 1} is singular")
        columns = np.flatnonzero(upper.any(axis=0))
        y = getrs(lu, piv, b[start:stop])[0]
        Y = getrs(lu, piv, upper[:, columns])[0]
        shared = stop + columns
        kept.append((start, stop, shared, y, Y))
    x = np.empty_like(b)
    for start, stop, shared, y, Y in reversed(kept):
        x[start:stop] = y - Y @ x[shared]
    return x


def _dense_rows(K: csr_array, start: int, stop: int) -> tuple[Array, int]:
    """Rows `start:stop` of K as a dense matrix over their occupied columns, and the first of these."""
    entries = slice(K.indptr[start], K.indptr[stop])
    columns = K.indices[entries]
    rows = np.repeat(np.arange(stop - start), np.diff(K.indptr[start : stop + 1]))
    first = min(int(columns.min()), start)
    strip = np.zeros((stop - start, max(int(columns.max()) + 1, stop) - first), order="F")
    strip[rows, columns - first] = K.data[entries]
    return strip, first
