r"""Gauge pressure in closed chambers along a rod: V = -p (volume of the chamber), V_c = int det F dA dx.

det F is trilinear in the generalised vectors v = N e: with J_e = sum_i v_i a_i(y, z)^T (section_energy.py),

    V_c = sum_ijk T_ijk v_i . (v_j x v_k),   T_ijk = int a_ix a_jy a_kz dA dx.

Only the part of T counts that changes its sign with every exchange; brought to the nodal vectors it is the
constant A_lmn of an element, and with u_lm = sum_n A_lmn e_n

    V_c = 1/3 sum_l e_l . dV_c/de_l,   dV_c/de_l = sum_m e_m x u_lm,   d2V_c/de_l de_m = -2 hat(u_lm).

The pressure follows the walls and the end caps, and has a potential because the chamber is closed. A chamber
off the axis bends the rod by p A_c times its offset, less 2 nu of that where the section feels its wall
(3363; linear sections bend as if fibres held it: section_validity.py); the thrust on its end caps stretches
it. The chamber is part of the section as far as stiffness goes: give the section that carries (an annulus
round a bore).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rotation import hat
from ancf.scene import Pressure, Scene
from ancf.section_energy import generalised_shape, gradient_weights
from ancf.sections import Circle

Floats = NDArray[np.float64]

# det F of quadratic sections: one factor of degree 2 and two of degree 1 in (y, z), or less.
SECTION_DEGREE = 4
TURN = -2.0 * hat(np.eye(3)).reshape(3, 9)  # u @ TURN = -2 hat(u)


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Chambers under pressure of the scene."""
    models = {model.rod.name: model for model in rods}
    return [Chamber(models[pressure.rod], pressure) for pressure in scene.pressures]


class Chamber(Effect):
    """A closed chamber; blocks are the elements it runs through."""

    name = "pressure"

    def __init__(self, model: RodModel, pressure: Pressure) -> None:
        self.value = pressure.value  # Pa
        breaks, length = model.mesh.breaks, model.rod.length
        ends = np.clip(breaks, pressure.start * length, pressure.end * length)
        elements = np.flatnonzero(np.diff(ends) > 0.0)
        self.dofs = model.dofs[elements]
        y, z, area = Circle(pressure.radius).quadrature(SECTION_DEGREE)
        a = gradient_weights(model.element, y + pressure.centre[0], z + pressure.centre[1])
        T = np.einsum("n,ni,nj,nk->ijk", area, *np.moveaxis(a, 2, 0), optimize=True)
        # Elements of one length with the same share of the chamber have the same A_lmn.
        pieces = np.column_stack([breaks[:-1], breaks[1:], ends[:-1], ends[1:]])[elements]
        alike = np.round((pieces - pieces[:, :1]) / length, 12)
        _, first, kind = np.unique(alike, axis=0, return_index=True, return_inverse=True)
        self.groups = [
            (np.flatnonzero(kind.ravel() == index), _alternating(model, T, *pieces[row]))
            for index, row in enumerate(first)
        ]

    def _tangent(self, e: Floats) -> Floats:
        """Second derivative of the volume (m, 3 nodal, 3 nodal) [m]."""
        nodal = e.shape[1]
        found = np.empty((len(e), nodal, 3, nodal, 3))
        for rows, A in self.groups:
            u = (A @ e[rows].swapaxes(0, 1).reshape(nodal, -1)).reshape(nodal, nodal, len(rows), 3)
            found[rows] = (u @ TURN).reshape(nodal, nodal, len(rows), 3, 3).transpose(2, 0, 3, 1, 4)
        return found.reshape(len(e), 3 * nodal, 3 * nodal)

    def _slope(self, e: Floats, tangent: Floats) -> Floats:
        """dV_c/de (m, nodal, 3), which is of second degree: half the tangent's product with e."""
        return 0.5 * (tangent @ e.reshape(len(e), -1, 1)).reshape(e.shape)

    def volume(self, e: Floats) -> float:
        """Volume of the chamber [m3]."""
        return float(np.sum(e * self._slope(e, self._tangent(e)))) / 3.0

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return self.value * self._slope(e, self._tangent(e))

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; symmetric."""
        tangent = self._tangent(e)
        return self.value * self._slope(e, tangent), self.value * tangent

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`: V = -p V_c."""
        return -self.value * self.volume(e)


def _alternating(model: RodModel, T: Floats, begin: float, end: float, first: float, last: float) -> Floats:
    """A_lmn (nodal^2, nodal) [m2 or m3 by the vectors] of an element, with the chamber from first to last.

    T : of a section (generalised vectors, ..., ...), symmetric in nothing
    """
    # The axial points of the strain energy: no work where the element is blind.
    xi, weight = gauss(model.axial_points)
    x = first + 0.5 * (last - first) * (1.0 + xi)
    N = generalised_shape(model.element, 2.0 * (x - begin) / (end - begin) - 1.0, end - begin)
    S = T + np.transpose(T, (1, 2, 0)) + np.transpose(T, (2, 0, 1))
    S = 0.5 * (S - np.transpose(S, (0, 2, 1)))
    A = np.einsum("p,ijk,pil,pjm,pkn->lmn", 0.5 * (last - first) * weight, S, N, N, N, optimize=True)
    return A.reshape(-1, A.shape[-1])
