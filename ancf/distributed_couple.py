r"""Couples per length on the sections of a rod, conjugate to their spin: Q = int N^T couple(m) dx.

Each section takes a couple as a point moment does (moment.py): Q_k = mu x (R W_k), mu = G^-1 m. What differs
between effects is the couple as a function of the section's rotation R,

    fixed in space       m = m_0             dm = 0
    turning with it      m = R m_0           dm = dw x m
    magnetic             m = (R p) x B       dm = (dw x R p) x B,     V = -int (R p) . B dx.
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
        self.dofs = model.dofs
        self.N = np.array([model.element.shape(xi, float(h)) for h in model.mesh.h])
        d0 = self.N @ model.e0[:, None]
        self.W = model.weights_at(xi, d0)
        self.weight = model.axial_weights[..., None]

    @abstractmethod
    def couple(self, R: Floats) -> Floats:
        """Couple per length (n_el, points, 3) [N m/m] on sections turned by R (n_el, points, 3, 3)."""

    @abstractmethod
    def couple_change(self, R: Floats, m: Floats) -> Floats | float:
        """Matrix D (n_el, points, 3, 3) with dm = D dw; 0.0 where it is constant."""

    def _rotation(self, e: Floats) -> SectionRotation:
        return section_rotation(self.N @ e[:, None], self.W)

    def _force(self, rotation: SectionRotation, m: Floats) -> Floats:
        return np.einsum("epkn,epka->ena", self.N, rotation.couple(self.weight * m))

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
        K_d = K_d.reshape(*places, directors, 3, directors, 3)
        K = np.einsum("epkm,epkalc,epln->emanc", self.N, K_d, self.N, optimize=True)
        size = 3 * self.N.shape[-1]
        return self._force(rotation, m), K.reshape(len(K), size, size)


def turning(m: Floats) -> Floats:
    """D of a couple that turns with its section: dm = dw x m = -hat(m) dw."""
    return -hat(m)
