r"""Couples per length on the sections of a rod, conjugate to their spin: Q = int N^T couple(m) dx.

Each section takes a couple as a point moment does (moment.py), here in its own axes (section_spin.py). What
differs between effects is how the couple stands to them: with its components M in the axes that turn with the
section by dw, dM = A dw,

    fixed in space       A = hat(M)
    turning with it      A = 0
    magnetic             M = p x B, p in the section, B in space:  A = hat(p) hat(B),  V = -int p . B dx.
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from ancf.effects import SparseEffect
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.section_spin import SectionAxes, section_map
from ancf.vector_pairs import VectorPairs

Floats = NDArray[np.float64]

# Places in a matrix of (y, z; components) of its entries by pairs of vectors.
BY_PAIRS = np.arange(36).reshape(2, 3, 2, 3).swapaxes(1, 2).ravel()


class DistributedCouple(SparseEffect):
    """Couples on all sections of a rod, at the axial points of its strain energy; blocks are elements.

    Attributes
    ----------
    E : (n_el points, 3, 3) axes of the sections in the reference, as rows
    weight : (n_el points,) [m] of the integral
    """

    def __init__(self, model: RodModel) -> None:
        xi, _ = gauss(model.axial_points)
        self.dofs = model.dofs
        N = np.array([model.element.shape(xi, float(h)) for h in model.mesh.h])
        to_b, E = section_map(N, model.weights_at(xi, N @ model.e0[:, None]))
        self.to_b = to_b.reshape(len(N), -1, to_b.shape[-1])  # (n_el, points 2, nodal)
        self.E = E.reshape(-1, 3, 3)
        self.weight = model.axial_weights.ravel()
        first, second = (np.repeat(to_b, 2, axis=2), np.tile(to_b, (1, 1, 2, 1)))
        self._pairs = VectorPairs(*(one.reshape(len(N), -1, one.shape[-1]) for one in (first, second)))
        self.entries = self._pairs.entries
        self._to_nodes = np.ascontiguousarray(np.swapaxes(self.to_b, 1, 2))

    @abstractmethod
    def couple(self, axes: SectionAxes) -> Floats:
        """Couples (3, n_el points) [N m] in the axes of the sections, weight included."""

    @abstractmethod
    def couple_change(self, axes: SectionAxes, M: Floats) -> Floats | None:
        """Matrix A (n_el points, 3, 3) with dM = A dw, weight included; None where it is zero."""

    def axes(self, e: Floats) -> SectionAxes:
        """Axes of the sections at the nodal vectors e (n_el, nodal, 3)."""
        return SectionAxes.of((self.to_b @ e).reshape(-1, 2, 3))

    def _force(self, axes: SectionAxes, mu: Floats) -> Floats:
        return self._to_nodes @ axes.couple(mu).reshape(len(self.dofs), -1, 3)

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        axes = self.axes(e)
        return self._force(axes, axes.mu(self.couple(axes)))

    def force_and_entries(self, e: Floats) -> tuple[Floats, Floats]:
        """See `SparseEffect.force_and_entries`; symmetric where the couple has a potential."""
        axes = self.axes(e)
        M = self.couple(axes)
        mu = axes.mu(M)
        K = axes.couple_tangent(mu, self.couple_change(axes, M))
        K = K.reshape(-1, 36).take(BY_PAIRS, 1).reshape(len(self.dofs), -1, 3, 3)
        return self._force(axes, mu), self._pairs.entries_of(K)
