r"""Unknowns of a rod that is its own mirror image in a plane, and those of the motions out of it.

The mirror image of a section point (y, z) is another one, so the image of a nodal vector d_x^i d_s^j d_n^k r,
s and n the section axes in the plane and across it, is (-1)^k times its mirror image. A shape that is its own
image has

    k even: both components in the plane,      k odd: the component across it        (3333: 5 of 9 a node),

and motions out of it have the others, of the opposite *parity*. Sections whose axes are neither in the plane
nor across it (round ones only) are turned: vectors by s and n from those by y and z, orders in x stay.

Symbols
-------
P, F   the unknowns of one parity of a node from its nodal vectors and back, (k, 3 v) and (3 v, k), P F = I
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ancf.elements import Element, Order
from ancf.rod_model import RodModel
from ancf.scene_plane import Plane, is_along_axis
from ancf.supports import NodeSupport

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class NodeUnknowns:
    """Unknowns of one parity of a node; the same for all rods of one element that stand alike in their plane.

    Parameters
    ----------
    axes : rows of `Plane.axes`
    normal : the normal in section axes (y, z)
    along_axis : whether the sections stand along and across the plane, else they are turned
    odd : whether these are the motions out of the plane
    """

    element: Element
    axes: tuple[tuple[float, ...], ...]
    normal: tuple[float, float]
    along_axis: bool
    odd: bool

    @cached_property
    def across_y(self) -> bool:
        """Whether the section axis across the plane is y, else it is z or the turned z."""
        return self.along_axis and abs(self.normal[0]) > abs(self.normal[1])

    def is_odd(self, order: Order) -> bool:
        """Whether a vector, by its orders in x and the turned section axes, changes sign in its image."""
        return bool(order[1 if self.across_y else 2] % 2)

    def components(self, order: Order) -> list[int]:
        """Components in the axes of the plane that the unknowns of this parity move of a vector."""
        return [2] if self.is_odd(order) != self.odd else [0, 1]

    def numbers(self, orders: Iterable[Order]) -> Indices:
        """Places 3 i + a of these components of vectors of the given orders."""
        return np.array([3 * i + a for i, order in enumerate(orders) for a in self.components(order)])

    @cached_property
    def listed(self) -> Indices:
        """Places 3 v + a of the unknowns among the components of the nodal vectors by the plane's axes."""
        return self.numbers(self.element.vectors)

    @cached_property
    def _turned(self) -> tuple[Floats, Floats]:
        """Matrices (v, v) from vectors by the section's axes to those by the turned ones, and back."""
        if self.along_axis or not self.element.has_section:
            return np.eye(len(self.element.vectors)), np.eye(len(self.element.vectors))
        y, z = self.normal
        return turned_vectors(self.element, z, -y), turned_vectors(self.element, z, y)

    @cached_property
    def P(self) -> Floats:
        """Unknowns (k, 3 v) of a node from its nodal vectors."""
        return np.asarray(np.kron(self._turned[0], np.array(self.axes).T), dtype=float)[self.listed]

    @cached_property
    def F(self) -> Floats:
        """Nodal vectors (3 v, k) of a node from its unknowns."""
        return np.asarray(np.kron(self._turned[1], np.array(self.axes)), dtype=float)[:, self.listed]

    @cached_property
    def of_element(self) -> Floats:
        """F of all nodes of an element, (3 nodal, m)."""
        return np.asarray(np.kron(np.eye(len(self.element.node_xi)), self.F), dtype=float)


@lru_cache(maxsize=64)
def _shared(node: NodeUnknowns) -> NodeUnknowns:
    """The first of equal ones, with what it has computed."""
    return node


@dataclass(frozen=True, eq=False)
class MirrorUnknowns:
    """Unknowns of one parity of one rod; `first` is the position of its unknowns among those of all rods."""

    rod: RodModel
    node: NodeUnknowns
    first: int

    @cached_property
    def per_node(self) -> int:
        """Unknowns of a node."""
        return len(self.node.listed)

    @property
    def size(self) -> int:
        """Unknowns of the rod, supports not yet taken off."""
        return self.per_node * len(self.rod.q0)

    @property
    def end(self) -> int:
        """One past its last unknown."""
        return self.first + self.size

    @cached_property
    def full(self) -> slice:
        """Where the coordinates of the rod are in the model."""
        return slice(self.rod.first_dof, self.rod.first_dof + self.rod.size)

    @cached_property
    def dofs(self) -> Indices:
        """Unknowns of each element (n_el, m)."""
        nodes = self.rod.mesh.nodes_of[:, :, None] * self.per_node + np.arange(self.per_node)
        return self.first + nodes.reshape(len(nodes), -1)

    def of_elements(self, u: Floats) -> Floats:
        """View (n_el, m) of the unknowns of the elements in those of all rods u (n,)."""
        count, m = self.dofs.shape
        step, item = m - self.per_node, u.itemsize
        return np.ndarray((count, m), u.dtype, u, self.first * item, (step * item, item))

    def dofs_of(self, blocks: Indices) -> Indices:
        """Unknowns (m, ...) of blocks of coordinates (m, nd) on whole nodes of this rod."""
        full = self.rod.q0[0].size
        nodes = (blocks[:, ::full] - self.rod.first_dof) // full
        dofs = nodes[:, :, None] * self.per_node + np.arange(self.per_node)
        return self.first + dofs.reshape(len(blocks), -1)

    def supports(self, full: list[NodeSupport]) -> list[NodeSupport]:
        """Those supports of a model that hold this rod, as conditions on these unknowns."""
        found = []
        for support in full:
            if not self.full.start <= support.dofs[0] < self.full.stop:
                continue
            rows = support.rows @ self.node.F
            if len(rows) == support.rows.shape[1]:
                rows = np.eye(self.per_node)  # all is held
            else:
                rows = rows[np.abs(rows).max(axis=1, initial=0.0) > 1e-12]
                _, singular, right = np.linalg.svd(rows)
                rank = int(np.count_nonzero(singular > 1e-12))
                if rank < len(rows):
                    rows = right[:rank]
            found.append(NodeSupport(self.dofs_of(support.dofs[None])[0], rows))
        return found


def mirror_unknowns(rod: RodModel, plane: Plane, first: int, odd: bool) -> MirrorUnknowns:
    """Unknowns of one parity of a rod that is its own image in a plane."""
    normal = plane.in_section(rod.rod)
    node = NodeUnknowns(rod.element, plane.rows, normal, is_along_axis(normal), odd)
    return MirrorUnknowns(rod, _shared(node), first)


def turned_vectors(element: Element, cosine: float, sine: float) -> Floats:
    """Matrix (v, v) from nodal vectors to those by section axes s = c y + s z, n = -s y + c z.

    d_s^j d_n^k = (c d_y + s d_z)^j (-s d_y + c d_z)^k, multiplied out; the orders in x stay.
    """
    vectors = element.vectors
    matrix = np.zeros((len(vectors), len(vectors)))
    for row, (i, j, k) in enumerate(vectors):
        factors = [(cosine, sine)] * j + [(-sine, cosine)] * k  # coefficients of d_y and d_z
        product = np.ones(1)
        for factor in factors:
            product = np.convolve(product, factor)
        for power_z, coefficient in enumerate(product):
            matrix[row, vectors.index((i, j + k - power_z, power_z))] += coefficient
    return matrix
