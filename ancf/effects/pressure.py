r"""Gauge pressure in closed chambers along a rod: V = -p (volume of the chamber), V_c = int det F dA dx.

With v the generalised vectors and J_e = sum_i v_i a_i(y, z)^T (section_energy.py) of columns c_x, c_y, c_z,

    V_c = int c_x . (c_y x c_z),   dV_c/dv_i = int sum_a a_ia C_a,   C = [c_y x c_z, c_z x c_x, c_x x c_y],
    d2V_c/dv_i dv_j = int sum_ab a_ia a_jb dC_a/dc_b,   dC_x/dc_y = -hat(c_z), dC_x/dc_z = hat(c_y).

The pressure follows the walls and the end caps, and has a potential because the chamber is closed. A chamber
off the axis bends the rod by p A_c times its offset; the thrust on its end caps stretches it. The chamber is
part of the section as far as stiffness goes: give the section that carries (an annulus round a bore).
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


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Chambers under pressure of the scene."""
    models = {model.rod.name: model for model in rods}
    return [Chamber(models[pressure.rod], pressure) for pressure in scene.pressures]


class Chamber(Effect):
    """A closed chamber; blocks are the elements it runs through."""

    name = "pressure"

    def __init__(self, model: RodModel, pressure: Pressure) -> None:
        self.value = pressure.value  # Pa
        y, z, area = Circle(pressure.radius).quadrature(SECTION_DEGREE)
        self.a = gradient_weights(model.element, y + pressure.centre[0], z + pressure.centre[1])
        breaks = model.mesh.breaks
        ends = np.clip(breaks, pressure.start * model.rod.length, pressure.end * model.rod.length)
        elements = np.flatnonzero(np.diff(ends) > 0.0)
        # The axial points of the strain energy: no work where the element is blind.
        points, weight = gauss(model.axial_points)
        self.dofs = model.dofs[elements]
        self.N = np.empty((len(elements), len(points), self.a.shape[1], model.element.vectors_per_element))
        self.weight = np.empty((len(elements), len(points), len(area)))  # [m3]
        for row, element in enumerate(elements):
            half = 0.5 * (ends[element + 1] - ends[element])
            x = ends[element] + half * (1.0 + points)
            h = float(model.mesh.h[element])
            self.N[row] = generalised_shape(model.element, 2.0 * (x - breaks[element]) / h - 1.0, h)
            self.weight[row] = half * weight[:, None] * area

    def _columns(self, e: Floats) -> Floats:
        """c_x, c_y, c_z (3, m, points, section points, 3)."""
        return np.einsum("nia,mpic->ampnc", self.a, self.N @ e[:, None])

    def volume(self, e: Floats) -> float:
        """Volume of the chamber [m3]."""
        c_x, c_y, c_z = self._columns(e)
        return float(np.sum(self.weight * np.sum(c_x * np.cross(c_y, c_z), axis=-1)))

    def _force(self, c: Floats) -> Floats:
        c_x, c_y, c_z = c
        C = np.stack([np.cross(c_y, c_z), np.cross(c_z, c_x), np.cross(c_x, c_y)])
        Q_v = np.einsum("mpn,nia,ampnc->mpic", self.value * self.weight, self.a, C, optimize=True)
        return np.einsum("mpik,mpic->mkc", self.N, Q_v)

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return self._force(self._columns(e))

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; symmetric."""
        c = self._columns(e)
        h_x, h_y, h_z = hat(c)
        zero = np.zeros_like(h_x)
        dC = np.array([[zero, -h_z, h_y], [h_z, zero, -h_x], [-h_y, h_x, zero]])
        weight = self.value * self.weight
        K_v = np.einsum("mpn,nia,njb,abmpncd->mpicjd", weight, self.a, self.a, dC, optimize=True)
        K = np.einsum("mpik,mpicjd,mpjl->mkcld", self.N, K_v, self.N, optimize=True)
        size = 3 * self.N.shape[-1]
        return self._force(c), K.reshape(len(K), size, size)

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`: V = -p V_c."""
        return -self.value * self.volume(e)
