r"""Couples per length on the sections of a rod, conjugate to their spin: Q = int N^T couple(m) dx.

Each section takes a couple as a point moment does (moment.py): Q_k = mu x (R W_k), mu = G^-1 m. What differs
between effects is the couple as a function of the section's rotation R,

    fixed in space       m = m_0             dm = 0
    turning with it      m = R m_0           dm = dw x m
    magnetic             m = (R p) x B       dm = (dw x R p) x B,     V = -int (R p) . B dx
    elastic              turning_springs.py.
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rotation import SectionRotation, hat, section_rotation

Floats = NDArray[np.float64]


class DistributedCouple(Effect):
    """Couples on all sections of a rod, at the axial points of its strain energy; blocks are elements."""

    def __init__(self, model: RodModel) -> None:
        xi, _ = gauss(model.axial_points)
        N = np.array([model.element.shape(xi, float(h)) for h in model.mesh.h])
        W = model.weights_at(xi, N @ model.e0[:, None])
        self._place(model.dofs, N, W, model.axial_weights)

    def _place(self, dofs: NDArray[np.intp], N: Floats, W: Floats, weight: Floats) -> None:
        """Take the sections of the blocks dofs (n_el, nd), with their integration weights (n_el, points).

        N (n_el, points, directors, nodal) maps nodal vectors to directors, W (n_el, points, directors, 3)
        are the weights of the section rotation.
        """
        self.dofs, self.N, self.W = dofs, N, W
        self.weight = weight[..., None]
        # (n_el, nodal, points directors): sums over points and directors are one product.
        self._to_nodes = np.moveaxis(N, 3, 1).reshape(len(N), N.shape[3], -1)

    @abstractmethod
    def couple(self, R: Floats) -> Floats:
        """Couple per length (n_el, points, 3) [N m/m] on sections turned by R (n_el, points, 3, 3)."""

    @abstractmethod
    def couple_change(self, R: Floats, m: Floats) -> Floats | float:
        """Matrix D (n_el, points, 3, 3) with dm = D dw; 0.0 where it is constant."""

    def _rotation(self, e: Floats) -> SectionRotation:
        return section_rotation(self.N @ e[:, None], self.W)

    def _force(self, rotation: SectionRotation, m: Floats) -> Floats:
        Q_d = rotation.couple(self.weight * m)
        return self._to_nodes @ Q_d.reshape(len(Q_d), -1, 3)

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        rotation = self._rotation(e)
        return self._force(rotation, self.couple(rotation.R))

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; symmetric where the couple has a potential."""
        rotation = self._rotation(e)
        m = self.couple(rotation.R)
        dw = rotation.spin()
        *places, _, directors, _ = dw.shape
        dw = dw.reshape(*places, 3, 3 * directors)
        change = self.couple_change(rotation.R, m)
        dm = change if isinstance(change, float) else self.weight[..., None] * (change @ dw)
        K_d = rotation.couple_tangent(self.weight * m, dm, dw)
        count, points = places
        size = 3 * self.N.shape[-1]
        # First the columns, component by component, then the rows.
        K_d = np.moveaxis(K_d.reshape(count, points, 3 * directors, directors, 3), 4, 3)
        right = K_d.reshape(count, points, 9 * directors, directors) @ self.N  # (.., directors 3 3, nodal)
        right = right.reshape(count, points * directors, 3, 3, -1).swapaxes(3, 4)
        K = self._to_nodes @ right.reshape(count, points * directors, -1)
        return self._force(rotation, m), K.reshape(count, size, size)


def turning(m: Floats) -> Floats:
    """D of a couple that turns with its section: dm = dw x m = -hat(m) dw."""
    return -hat(m)
