r"""Couples on one section of a rod or spread along it, conjugate to the spin: Q = int N^T couple(m) dx.

Each section takes its couple in its own axes (section_spin.py). What differs between effects is how the
couple stands to them: with its components M in the axes that turn with the section by dw, dM = A dw,

    fixed in space       A = hat(M)
    turning with it      A = 0
    magnetic             M = p x B, p in the section, B in space:  A = hat(p) hat(B),  V = -int p . B dx
    elastic              turning_springs.py.
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from ancf.effects import SparseEffect, without_potential
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rotation import hat
from ancf.section_spin import SectionAxes, section_map
from ancf.vector_pairs import VectorPairs

Floats = NDArray[np.float64]

# Places in a matrix of (y, z; components) of its entries by pairs of vectors.
BY_PAIRS = np.arange(36).reshape(2, 3, 2, 3).swapaxes(1, 2).ravel()


class SectionCouples(SparseEffect):
    """Couples on `points` sections of each of the blocks.

    Parameters
    ----------
    dofs : (m, nd) unknowns of the blocks
    N : (m, points, directors, nodal) the directors of the sections from the nodal vectors
    W : (m, points, directors, 3) weights of the section rotation
    weight : (m, points) of each section, [m] where couples are per length

    Attributes
    ----------
    E : (m points, 3, 3) axes of the sections in the reference, as rows
    """

    def __init__(self, dofs: NDArray[np.intp], N: Floats, W: Floats, weight: Floats) -> None:
        self.dofs = dofs
        self.weight = weight.ravel()
        to_b, E = section_map(N, W)
        self.E = E.reshape(-1, 3, 3)
        m, nodal = len(dofs), N.shape[-1]
        self._to_b = to_b.reshape(m, -1, nodal)
        self._to_nodes = np.ascontiguousarray(np.swapaxes(self._to_b, 1, 2))
        of_forces, of_changes = np.repeat(to_b, 2, axis=2), np.tile(to_b, (1, 1, 2, 1))
        self._pairs = VectorPairs(of_forces.reshape(m, -1, nodal), of_changes.reshape(m, -1, nodal))
        self.entries = self._pairs.entries

    @abstractmethod
    def couple(self, axes: SectionAxes) -> Floats:
        """Couples (3, m points) [N m] in the axes of the sections, weight included."""

    @abstractmethod
    def couple_change(self, axes: SectionAxes, M: Floats) -> Floats | None:
        """Matrix A (m points, 3, 3) with dM = A dw, weight included; None where it is zero."""

    def axes(self, e: Floats) -> SectionAxes:
        """Axes of the sections at the nodal vectors e (m, nodal, 3)."""
        return SectionAxes.of((self._to_b @ e).reshape(-1, 2, 3))

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


class SectionMoments(SectionCouples):
    """Moments of one value (3,) [N m, or N m/m] in SCS at the reference, fixed in space or turning with the
    sections.
    """

    def __init__(
        self, dofs: NDArray[np.intp], N: Floats, W: Floats, weight: Floats, value: Floats, follower: bool
    ) -> None:
        super().__init__(dofs, N, W, weight)
        self.value = value
        self.follower = follower
        self._turning = self.weight * (self.E @ value).T

    def couple(self, axes: SectionAxes) -> Floats:
        """See `SectionCouples.couple`."""
        return self._turning if self.follower else self.weight * axes.local(self.value)

    def couple_change(self, axes: SectionAxes, M: Floats) -> Floats | None:
        """See `SectionCouples.couple_change`."""
        return None if self.follower else hat(M.T)

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: a moment in space has none."""
        return without_potential(self.value)


def all_sections(model: RodModel) -> tuple[NDArray[np.intp], Floats, Floats, Floats]:
    """dofs, N, W and weight of `SectionCouples` for couples per length on all elements of a rod.

    At the axial points of the strain energy: no work where the elements are blind.
    """
    xi, _ = gauss(model.axial_points)
    N = np.array([model.element.shape(xi, float(h)) for h in model.mesh.h])
    return model.dofs, N, model.weights_at(xi, N @ model.e0[:, None]), model.axial_weights
