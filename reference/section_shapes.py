"""Shape functions of a section of order 2 or more on the curved quads of a section mesh.

The quads keep their quadratic edges; only the field on them is refined. A quadratic field is one of order 4
on a curved 9-node quad, so that order 4 holds the lateral field of Saint-Venant bending exactly where order 2
errs by the fourth power of the mesh size.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu
from skfem import Basis, ElementQuad2, ElementQuadP, MeshQuad2

from reference.solid_mesh import SectionMesh

Array = NDArray[np.float64]

# Corners, mid-sides and centre of the quad in the order of the 9-node element.
NODES = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5], [0.5, 0.5]])
EDGES = [(0, 1), (1, 2), (3, 2), (0, 3)]  # the direction in which an edge's functions run


class SectionShapes:
    """Values and slopes of the shape functions at the integration points, lengths by `size`.

    Parameters
    ----------
    section : SectionMesh
        The quads; coordinates are counted from the mean point of the section.
    size : float
        Unit of length [m].
    order : int
        2 or more.

    Notes
    -----
    `elements` (n_el, n_b) coefficient of each local function; `phi`, `phi_y`, `phi_z` (n_el, n_qp, n_b);
    `weights` (n_el, n_qp), `points` (n_el, n_qp, 2); `coordinates` (n, 2) coefficients of (y, z).
    """

    def __init__(self, section: SectionMesh, size: float, order: int) -> None:
        if order < 2:
            raise ValueError(f"order is {order}; the section needs 2 or more. Leave it out for the default.")
        mean = section.mass.sum(axis=0) @ section.nodes / section.area
        nodes = (section.nodes - mean) / size
        self.order = order
        self.mesh = MeshQuad2(np.ascontiguousarray(nodes.T), MeshQuad2.from_mesh(section.grid).t)
        self.element = ElementQuad2() if order == 2 else ElementQuadP(order)
        # Products of two functions and the quadratic map's determinant are of degree 2 order + 3 each way.
        basis = Basis(self.mesh, self.element, intorder=2 * order + 3)
        self.elements = basis.dofs.element_dofs.T
        self.signs = self._edge_signs()
        self.weights = np.asarray(basis.dx)
        self.points = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)
        self.phi, self.phi_y, self.phi_z = self._tables(basis)
        self.count = int(self.elements.max()) + 1
        weighted = self.phi * self.weights[..., None]
        mass = weighted.swapaxes(1, 2) @ self.phi
        rows = np.broadcast_to(self.elements[:, :, None], mass.shape).ravel()
        columns = np.broadcast_to(self.elements[:, None, :], mass.shape).ravel()
        whole = coo_array((mass.ravel(), (rows, columns)), shape=(self.count, self.count)).tocsc()
        right = np.stack([self.gather(weighted * self.points[..., i, None]) for i in range(2)], axis=-1)
        self.coordinates = splu(whole).solve(right)

    def gather(self, values: Array) -> Array:
        """Sum (n_el, n_qp, n_b) over the integration points into the coefficients (n,)."""
        local = values.sum(axis=1)
        return np.asarray(np.bincount(self.elements.ravel(), local.ravel(), minlength=self.count), float)

    def at_nodes(self) -> tuple[Array, Array, Array]:
        """Values and slopes (n_el, 9, n_b) at the nodes of each quad, in the order of the section's nodes."""
        basis = Basis(self.mesh, self.element, quadrature=(NODES.T, np.full(9, 1 / 9)))
        return self._tables(basis)

    def node_numbers(self) -> NDArray[np.int64]:
        """Section nodes of each quad (n_el, 9)."""
        return np.asarray(self.mesh.dofs.element_dofs.T, np.int64)

    def _tables(self, basis: Basis) -> tuple[Array, Array, Array]:
        shape = np.asarray(basis.dx).shape
        fields = [field[0] for field in basis.basis]
        values = np.stack([np.broadcast_to(np.asarray(f), shape) for f in fields], axis=-1)
        slopes = np.stack([np.broadcast_to(np.asarray(f.grad), (2, *shape)) for f in fields], axis=-1)
        signs = self.signs[:, None]
        return values * signs, slopes[0] * signs, slopes[1] * signs

    def _edge_signs(self) -> Array:
        """Signs (n_el, n_b) that make the odd functions of an edge agree between its two quads.

        They run along the edge in each quad's own direction; here from its lower to its higher corner.
        """
        signs = np.ones(self.elements.shape)
        if self.order == 2:
            return signs
        corners = self.mesh.t
        for edge, (start, end) in enumerate(EDGES):
            backwards = corners[start] > corners[end]
            for degree in range(3, self.order + 1, 2):
                signs[backwards, 4 + edge * (self.order - 1) + degree - 2] = -1.0
        return signs
