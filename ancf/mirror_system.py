"""Linear systems on the unknowns of one parity of all rods (mirror_unknowns.py), between full vectors."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.band import BandPattern, Factors
from ancf.linear_system import LinearSystem
from ancf.mirror_unknowns import MirrorUnknowns, mirror_unknowns
from ancf.scene_plane import Plane

if TYPE_CHECKING:
    from ancf.model import Model

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


class Parity:
    """The unknowns of one parity of a model: u (n,) of coordinates q, forces, and where blocks go.

    Parameters
    ----------
    model : the full model
    plane : the plane of its scene
    odd : whether these are the motions out of the plane
    symmetric : whether tangents on them are symmetric
    """

    def __init__(self, model: Model, plane: Plane, odd: bool, symmetric: bool) -> None:
        self.model = model
        self.symmetric = symmetric
        self.rods: list[MirrorUnknowns] = []
        first = 0
        for rod in model.rods:
            self.rods.append(mirror_unknowns(rod, plane, first, odd))
            first = self.rods[-1].end
        self.n = first

    @cached_property
    def pattern(self) -> BandPattern:
        """Band of a tangent."""
        return BandPattern(self.n, max(rod.dofs.shape[1] for rod in self.rods) - 1)

    @cached_property
    def system(self) -> LinearSystem:
        """Supports, scales and factorisation of a tangent."""
        unit, force_unit = np.empty(self.n), np.empty(self.n)
        for rod in self.rods:
            here = slice(rod.first, rod.end)
            nodal = self.model.unit[rod.full].reshape(len(rod.rod.q0), -1, 3)[:, :, 0]
            unit[here] = nodal[:, rod.node.listed // 3].ravel()
            force_unit[here] = rod.rod.bending_stiffness / rod.rod.rod.length / unit[here]
        supports = [support for rod in self.rods for support in rod.supports(self.model.supports)]
        return LinearSystem(self.pattern, supports, unit, force_unit, self.model.counters, self.symmetric)

    @property
    def unknowns(self) -> int:
        """Number of unknowns that the supports leave."""
        return self.n - sum(len(s.rows) for s in self.system.supports)

    def of(self, q: Floats) -> Floats:
        """The unknowns u (n,) of coordinates q."""
        return _joined([self._nodes(rod, q) @ rod.node.P.T for rod in self.rods])

    def to_full(self, u: Floats) -> Floats:
        """Coordinates q of the unknowns u (n,)."""
        return self._full(u, [rod.node.F.T for rod in self.rods])

    def force_of(self, Q: Floats) -> Floats:
        """Forces (n,) on the unknowns, F^T Q."""
        return _joined([self._nodes(rod, Q) @ rod.node.F for rod in self.rods])

    @staticmethod
    def _nodes(rod: MirrorUnknowns, q: Floats) -> Floats:
        return q[rod.full].reshape(len(rod.rod.q0), -1)

    def _full(self, u: Floats, matrices: list[Floats]) -> Floats:
        nodes = [u[rod.first : rod.end].reshape(-1, rod.per_node) for rod in self.rods]
        return _joined([here @ matrix for here, matrix in zip(nodes, matrices, strict=True)])

    def add_tangents(self, flat: Floats, rod: MirrorUnknowns, K: Floats) -> None:
        """Add the tangents (n_el, m, m) of the elements of a rod to the flat band storage."""
        count, m, _ = K.shape
        _add_neighbours(self.pattern.blocks(flat, rod.first, m - rod.per_node, m, count), K)

    def element_forces_to_full(self, forces: Iterable[Floats]) -> Floats:
        """Forces Q = P^T Q_u on the coordinates (N,), for which F^T Q = Q_u sums those on the elements.

        Parameters
        ----------
        forces : (n_el, m) of each rod
        """
        Q_u = np.zeros(self.n)
        for rod, Q in zip(self.rods, forces, strict=True):
            _add_neighbours(rod.of_elements(Q_u), Q)
        return self._full(Q_u, [rod.node.P for rod in self.rods])

    def blocks_of(self, dofs: Indices) -> tuple[Floats, Indices]:
        """F on one block (nd, m) and the unknowns (blocks, m) of blocks of coordinates dofs on one rod."""
        first = int(dofs[0, 0])
        rod = next(rod for rod in self.rods if rod.full.start <= first < rod.full.stop)
        return rod.node.of_element, rod.dofs_of(dofs)


def _add_neighbours(blocks: Floats, added: Floats) -> None:
    """Add to blocks (n_el, ...) whose neighbours share the entries of a node: every other one at once."""
    blocks[::2] += added[::2]
    blocks[1::2] += added[1::2]


def _joined(parts: list[Floats]) -> Floats:
    """The numbers of all rods in a row."""
    return parts[0].ravel() if len(parts) == 1 else np.concatenate(parts, axis=None)


class PlanarSystem(LinearSystem):
    """The linear algebra of a model on its planar unknowns; right sides and displacements are full (N,)."""

    def __init__(self, full: LinearSystem, side: Parity) -> None:
        super().__init__(full.pattern, full.supports, full.unit, full.force_unit, full.counters)
        self.side = side

    def supported(self, flat: Floats) -> Floats:
        """See `LinearSystem.supported`, on the planar unknowns."""
        return self.side.system.supported(flat)

    def factorise(self, flat: Floats) -> Factors:
        """See `LinearSystem.factorise`."""
        return self.side.system.factorise(flat)

    def is_positive_definite(self, flat: Floats) -> bool:
        """See `LinearSystem.is_positive_definite`, for motions in the plane."""
        return self.side.system.is_positive_definite(flat)

    def negative_eigenvalues(self, flat: Floats) -> int:
        """See `LinearSystem.negative_eigenvalues`, for motions in the plane."""
        return self.side.system.negative_eigenvalues(flat)

    def solve(self, lu: Factors, right: Floats) -> Floats:
        """See `LinearSystem.solve`; (N,) alone."""
        return self.side.to_full(self.side.system.solve(lu, self.side.force_of(right)))

    def solve_transposed(self, lu: Factors, goal: Floats) -> Floats:
        """Not used on the way to an equilibrium: adjoints belong to the full model."""
        raise NotImplementedError("adjoints are solved on the full model")

    def row_sum(self, flat: Floats, q: Floats) -> float:
        """See `LinearSystem.row_sum`."""
        return self.side.system.row_sum(flat, self.side.of(q))
