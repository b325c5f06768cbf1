r"""Tendons: cables of given tension through points of the sections, without friction.

A tendon runs through (y(x), z(x)), linear in x between the points of its path; its place c(x) = r(x, y, z) is
linear in the nodal vectors, and so is c' = a^T e with

    a = sum_k phi_k(y, z) N_k' + (phi_k,y y' + phi_k,z z') N_k.

It is pulled by its tension T along its whole path, so with its length l = int |c'| dx

    V = T l,   Q = -T int a t^T dx,   dQ/de = -T int (a a^T) (x) (I - t t^T)/|c'| dx,   t = c'/|c'|.

That is all: the line load of its curvature, thrust and couples where it ends follow (Rucker, Webster, IEEE
Trans. Robotics 27 (2011) 1033, eq. 13-24, in the limit of a rigid section). Forces and moments of a tendon
balance: what it pulls at the first point of its path is part of the rod, not of the reaction of a support.

The integral takes the axial points of the strain energy, so that the tension does no work where the element
is blind; an element with points of the path inside is cut there.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.scene import Scene, Tendon

Floats = NDArray[np.float64]


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Tendons of the scene."""
    models = {model.rod.name: model for model in rods}
    return [PulledTendon(models[tendon.rod], tendon) for tendon in scene.tendons]


class PulledTendon(Effect):
    """A tendon of given tension."""

    name = "tendon"

    def __init__(self, model: RodModel, tendon: Tendon) -> None:
        self.tension = tendon.tension  # N
        elements, rows, lengths = [], [], []
        for element, x, slopes, weight in _pieces(model, tendon):
            h = float(model.mesh.h[element])
            xi = 2.0 * (x - model.mesh.breaks[element]) / h - 1.0
            N, N_x = model.element.shape(xi, h), model.element.shape(xi, h, derivative=1)
            y, z = (np.interp(x, tendon.path[:, 0] * model.rod.length, tendon.path[:, k]) for k in (1, 2))
            phi, phi_y, phi_z = model.element.section_monomials(y, z)
            along = phi_y * slopes[0] + phi_z * slopes[1]
            rows.append(np.einsum("pk,pkn->pn", phi, N_x) + np.einsum("pk,pkn->pn", along, N))
            elements.append(element)
            lengths.append(weight)
        self.dofs = model.dofs[elements]
        self.a = np.array(rows)  # (m, points, nodal) [1/m]
        self.weight = np.array(lengths)  # (m, points) [m]
        self._weighted = self.weight[..., None] * self.a
        pairs = self._weighted[..., :, None] * self.a[..., None, :]
        self._pairs = np.swapaxes(pairs.reshape(*self.weight.shape, -1), 1, 2)  # (m, nodal^2, points)

    def _tangents(self, e: Floats) -> tuple[Floats, Floats]:
        """t (m, points, 3) and |c'| (m, points)."""
        c = self.a @ e
        stretch = np.linalg.norm(c, axis=-1)
        return c / stretch[..., None], stretch

    def length(self, e: Floats) -> float:
        """Length [m] at the nodal vectors e (m, nodal, 3)."""
        return float(np.sum(self.weight * self._tangents(e)[1]))

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        t, _ = self._tangents(e)
        return -self.tension * (np.swapaxes(self._weighted, 1, 2) @ t)

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; symmetric."""
        t, stretch = self._tangents(e)
        across = (np.eye(3) - t[..., :, None] * t[..., None, :]) * (-self.tension / stretch[..., None, None])
        m, _, nodal = self.a.shape
        K = (self._pairs @ across.reshape(m, -1, 9)).reshape(m, nodal, nodal, 3, 3)
        Q = -self.tension * (np.swapaxes(self._weighted, 1, 2) @ t)
        return Q, K.transpose(0, 1, 3, 2, 4).reshape(m, 3 * nodal, 3 * nodal)

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`: V = T l."""
        return self.tension * self.length(e)


def _pieces(model: RodModel, tendon: Tendon) -> Iterator[tuple[int, Floats, Floats, Floats]]:
    """Element, points x, slopes (y', z') and weights of every piece of the path that lies in one element."""
    xi, weight = gauss(model.axial_points)
    path = tendon.path * [model.rod.length, 1.0, 1.0]
    breaks = model.mesh.breaks
    for (x_a, *from_), (x_b, *to) in pairwise(path):
        slopes = (np.array(to) - from_) / (x_b - x_a)
        first, last = (
            np.searchsorted(breaks, x_a, side="right") - 1,
            np.searchsorted(breaks, x_b, side="left"),
        )
        for element in range(first, last):
            a, b = max(x_a, breaks[element]), min(x_b, breaks[element + 1])
            yield int(element), a + 0.5 * (b - a) * (1.0 + xi), slopes, 0.5 * (b - a) * weight
