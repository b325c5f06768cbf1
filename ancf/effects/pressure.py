r"""Gauge pressure in closed chambers along a rod: V = -p (volume of the chamber), V_c = int det F dA dx.

det F is trilinear in the generalised vectors v = N e: with J_e = sum_i v_i a_i(y, z)^T (section_energy.py),

    V_c = sum_ijk T_ijk v_i . (v_j x v_k),   T_ijk = int a_ix a_jy a_kz dA dx.

Only the part of T counts that changes its sign with every exchange; brought to the nodal vectors it is the
constant A_lmn of an element, and with u_lm = sum_n A_lmn e_n

    V_c = 1/3 sum_l e_l . dV_c/de_l,   dV_c/de_l = sum_m e_m x u_lm,   d2V_c/de_l de_m = -2 hat(u_lm),

where u_lm = -u_ml: pairs l < m tell all.

The pressure follows the walls and the end caps, and has a potential because the chamber is closed. A chamber
off the axis bends the rod by p A_c times its offset, less 2 nu of that where the section feels its wall
(3363; linear sections bend as if fibres held it: section_validity.py); the thrust on its end caps stretches
it. The chamber is part of the section as far as stiffness goes: give the section that carries (an annulus
round a bore).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect, SparseEffect
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.scene import Pressure, Scene
from ancf.section_energy import generalised_shape, gradient_weights
from ancf.section_spin import TWICE_ROUND
from ancf.sections import Circle

Floats = NDArray[np.float64]

# det F of quadratic sections: one factor of degree 2 and two of degree 1 in (y, z), or less.
SECTION_DEGREE = 4
# Where the components of a vector u stand in hat(u) with a plus, and with a minus.
PLUS, MINUS = np.array([[2, 1], [0, 2], [1, 0]]), np.array([[1, 2], [2, 0], [0, 1]])


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Chambers under pressure of the scene."""
    models = {model.rod.name: model for model in rods}
    return [Chamber(models[pressure.rod], pressure) for pressure in scene.pressures]


class Chamber(SparseEffect):
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
        nodal = self.dofs.shape[1] // 3
        self.l, self.m = np.triu_indices(nodal, 1)
        # Of elements that are alike: which they are, and 2 A_lmn of the pairs l < m (pairs, nodal).
        self.groups = [
            (
                np.flatnonzero(kind.ravel() == index),
                2.0 * _alternating(model, T, *pieces[row])[self.l, self.m],
            )
            for index, row in enumerate(first)
        ]
        self.entries = np.concatenate([self._entries(rows) for rows, _ in self.groups])

    def _entries(self, rows: NDArray[np.intp]) -> NDArray[np.intp]:
        """Places of 2 u_lm, once more for its exchange u_ml = -u_lm, and of both with the other sign."""
        nd = self.dofs.shape[1]
        found = []
        for plus, minus in ((MINUS, PLUS), (PLUS, MINUS)):  # dQ/de = -2 p hat(u)
            for n, other, places in ((self.l, self.m, plus), (self.m, self.l, minus)):
                row, column = 3 * n[:, None] + places[:, 0], 3 * other[:, None] + places[:, 1]
                found.append((nd * row + column)[..., None] + nd * nd * rows)  # pairs, components, elements
        return np.concatenate(found, axis=None)

    def _slope(self, twice_A: Floats, e: Floats) -> Floats:
        """dV_c/de = 2 sum_l<m A_lmn e_l x e_m (m, nodal, 3) of alike elements, e (nodal, 3, m)."""
        twice = e.take(TWICE_ROUND, 1)
        a, b = twice.take(self.l, 0), twice.take(self.m, 0)
        products = a[:, 1:4] * b[:, 2:5] - a[:, 2:5] * b[:, 1:4]
        slope = twice_A.T @ products.reshape(len(products), -1)
        return slope.reshape(e.shape).transpose(2, 0, 1)

    def volume(self, e: Floats) -> float:
        """Volume of the chamber [m3]."""
        slopes = ((e[rows], self._slope(twice_A, _by_vectors(e, rows))) for rows, twice_A in self.groups)
        return sum(float(np.sum(part * slope)) for part, slope in slopes) / 3.0

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        Q = np.empty(e.shape)
        for rows, twice_A in self.groups:
            Q[rows] = self.value * self._slope(twice_A, _by_vectors(e, rows))
        return Q

    def force_and_entries(self, e: Floats) -> tuple[Floats, Floats]:
        """See `SparseEffect.force_and_entries`; symmetric."""
        Q, found = np.empty(e.shape), []
        for rows, twice_A in self.groups:
            part = _by_vectors(e, rows)
            Q[rows] = self.value * self._slope(twice_A, part)
            u = (self.value * twice_A) @ part.reshape(len(part), -1)
            found += [u, u, -u, -u]
        return Q, np.concatenate(found, axis=None)

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`: V = -p V_c."""
        return -self.value * self.volume(e)


def _by_vectors(e: Floats, rows: NDArray[np.intp]) -> Floats:
    """Nodal vectors (nodal, 3, m) of some elements."""
    return np.ascontiguousarray(e.take(rows, 0).transpose(1, 2, 0))


def _alternating(model: RodModel, T: Floats, begin: float, end: float, first: float, last: float) -> Floats:
    """A_lmn (nodal, nodal, nodal) [m2 or m3 by the vectors] of an element, the chamber from first to last.

    T : of a section (generalised vectors, ..., ...), symmetric in nothing
    """
    # The axial points of the strain energy: no work where the element is blind.
    xi, weight = gauss(model.axial_points)
    x = first + 0.5 * (last - first) * (1.0 + xi)
    N = generalised_shape(model.element, 2.0 * (x - begin) / (end - begin) - 1.0, end - begin)
    S = T + np.transpose(T, (1, 2, 0)) + np.transpose(T, (2, 0, 1))
    S = 0.5 * (S - np.transpose(S, (0, 2, 1)))
    weights = 0.5 * (last - first) * weight
    return np.einsum("p,ijk,pil,pjm,pkn->lmn", weights, S, N, N, N, optimize=True).astype(float)
