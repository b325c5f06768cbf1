"""Assembly of the solid reference: pattern and slots once, one `bincount` per iteration.

Symbols: `u` nodal displacement (n, 3) [m], `B` shape function gradients, `F` deformation gradient, `P_pk1`
first Piola-Kirchhoff stress, `A_pk1` its tangent, `Q_int` nodal forces [N], `K` tangent [N/m].
Arrays at integration points have the shape (n_el, n_qp, ...).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csr_array
from skfem import Basis, ElementHex2

from reference.solid_mesh import RodMesh

Array = NDArray[np.float64]

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
        values = np.stack([np.asarray(f[0]) for f in basis.basis])[:, 0]  # the same in every element
        self.mesh = mesh
        self.fixed = fixed
        self.B = np.ascontiguousarray(np.moveaxis(gradients, 0, -1))  # (n_el, n_qp, 3, 27)
        self.volume = np.asarray(basis.dx)  # (n_el, n_qp)
        n_el, n_qp = self.volume.shape
        weighted = self.B * self.volume[..., None, None]
        self.points = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)  # (n_el, n_qp, 3) [m]
        element_share = self.volume @ values.T  # (n_el, 27)
        self.nodal_volume = np.asarray(
            np.bincount(mesh.elements.ravel(), element_share.ravel(), minlength=len(mesh.nodes)), float
        )  # int N_a dV (n,) [m^3]
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

    def moments(self, weights: Array, directions: Array) -> Array:
        """Nodal forces of a stress field against weights, int f_m dN_a/dX_J D_iJ dV (n_el, 27, 3, m).

        `weights` f (n_el, n_qp, m), `directions` D (n_el, n_qp, 3, 3): the element forces of the mixed form.
        """
        n_el, m = len(weights), weights.shape[-1]
        product = directions.swapaxes(-1, -2)[..., None] * weights[:, :, None, None, :]  # q J i m
        return (self._B_left @ product.reshape(n_el, -1, 3 * m)).reshape(n_el, 27, 3, m)

    def tangent(self, A_pk1: Array, K_load: Array | None = None, K_element: Array | None = None) -> csr_array:
        """Tangent, K_aibk = int dN_a/dX_J A_iJkL dN_b/dX_L dV + K_element - K_load, supports applied.

        `A_pk1` (n_el, n_qp, 3, 3, 3, 3) [Pa]; `K_load` (3 ns, 3 ns) [N/m] acts on the end section;
        `K_element` (n_el, 81, 81) [N/m], rows a i and columns k b, is what the mixed form adds.
        """
        n_el, n_qp = self.volume.shape
        T = np.moveaxis(A_pk1, 3, 2).reshape(n_el, n_qp, 27, 3) @ self.B  # rows J i k, columns b
        K_el = self._B_left @ T.reshape(n_el, 3 * n_qp, 243)
        if K_element is not None:
            K_el = K_el.reshape(K_element.shape) + K_element
        data = np.asarray(np.bincount(self._slots, K_el.ravel(), minlength=len(self._held)), float)
        if K_load is not None:
            data[self._end_slots] -= K_load.ravel()
        data[self._held] = 0.0
        data[self._held_diagonal] = 1.0
        n_nodes = len(self.mesh.nodes)
        blocks = data.reshape(-1, 3, 3)
        return csr_array(bsr_array((blocks, self._indices, self._indptr), shape=(3 * n_nodes, 3 * n_nodes)))

    @property
    def block_starts(self) -> list[int]:
        """First unknown of every block and the end; a block is the first and the middle plane of a slice."""
        n = self.mesh.nodes.size
        return [*range(0, n, 6 * len(self.mesh.section.nodes)), n]

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
