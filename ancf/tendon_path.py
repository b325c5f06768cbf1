r"""The path of a tendon through the sections of a rod: its length and the derivatives of that.

A tendon runs through (y(x), z(x)), linear in x between the points of its path; its place c(x) = r(x, y, z) is
linear in the nodal vectors, and so is c' = a^T e with

    a = sum_k phi_k(y, z) N_k' + (phi_k,y y' + phi_k,z z') N_k,

    l = int |c'| dx,   dl/de = int a t^T dx,   d2l/de2 = int (a a^T) (x) (I - t t^T)/|c'| dx,   t = c'/|c'|.

The integral takes the axial points of the strain energy, so that the tension does no work where the element
is blind; an element with points of the path inside is cut there.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ancf.quadrature import gauss
from ancf.rod_model import RodModel

Floats = NDArray[np.float64]


class TendonPath:
    """Pieces of the path that lie in one element each, in order along the rod.

    Attributes
    ----------
    dofs : (m, nd) unknowns of the element of each piece
    a : (m, points, nodal) [1/m] weights of the nodal vectors in c'
    weight : (m, points) [m] of the integral
    ends : (m, 2, nodal) weights in c' at both ends of each piece
    starts : (m,) whether a piece begins at a point of the path
    """

    def __init__(self, model: RodModel, points: Floats) -> None:
        xi, share = gauss(model.axial_points)
        pieces = list(_pieces(model, points))
        rows = []
        for element, a, b, slopes, _ in pieces:
            x = a + 0.5 * (b - a) * (1.0 + np.array([-1.0, *xi, 1.0]))
            rows.append(_tangent_weights(model, element, x, points, slopes))
        every = np.array(rows)
        self.dofs = model.dofs[[element for element, *_ in pieces]]
        self.a = every[:, 1:-1]
        self.ends = every[:, [0, -1]]
        self.weight = 0.5 * np.array([[b - a] for _, a, b, *_ in pieces]) * share
        self.starts = np.array([starts for *_, starts in pieces])

    def tangents(self, e: Floats) -> tuple[Floats, Floats]:
        """t (m, points, 3) and |c'| (m, points) at the nodal vectors e (m, nodal, 3)."""
        c = self.a @ e
        stretch = np.sqrt(np.add.reduce(c * c, -1))
        return c / stretch[..., None], stretch

    def length(self, e: Floats) -> float:
        """Length l [m]."""
        return float(np.sum(self.weight * self.tangents(e)[1]))

    @cached_property
    def _weighted(self) -> Floats:
        """a^T times the weights (m, nodal, points)."""
        return np.ascontiguousarray(np.swapaxes(self.weight[..., None] * self.a, 1, 2))

    @cached_property
    def _pairs(self) -> Floats:
        """a a^T times the weights (m, nodal^2, points)."""
        pairs = self.weight[..., None, None] * self.a[..., :, None] * self.a[..., None, :]
        return np.swapaxes(pairs.reshape(*self.weight.shape, -1), 1, 2)

    def slope(self, e: Floats, share: Floats | float = 1.0) -> Floats:
        """dl/de (m, nodal, 3), points counted by a share (m, points)."""
        t, _ = self.tangents(e)
        return self.on_nodes(t * np.asarray(share)[..., None])

    def on_nodes(self, t: Floats) -> Floats:
        """int a t^T dx (m, nodal, 3) of vectors t (m, points, 3)."""
        return self._weighted @ t

    def bend(self, e: Floats, share: Floats | float = 1.0) -> Floats:
        """d2l/de2 (m, nd, nd), points counted by a share (m, points)."""
        t, stretch = self.tangents(e)
        across = (np.eye(3) - t[..., :, None] * t[..., None, :]) * (share / stretch)[..., None, None]
        m, points, nodal = self.a.shape
        K = (self._pairs @ across.reshape(m, points, 9)).reshape(m, nodal, nodal, 3, 3)
        return K.transpose(0, 1, 3, 2, 4).reshape(m, 3 * nodal, 3 * nodal)


def _tangent_weights(model: RodModel, element: int, x: Floats, points: Floats, slopes: Floats) -> Floats:
    """a (points, nodal) at places x [m] inside one element; slopes (2,) of y and z there."""
    h = float(model.mesh.h[element])
    xi = 2.0 * (x - model.mesh.breaks[element]) / h - 1.0
    N, N_x = model.element.shape(xi, h), model.element.shape(xi, h, derivative=1)
    y, z = (np.interp(x, points[:, 0] * model.rod.length, points[:, k]) for k in (1, 2))
    phi, phi_y, phi_z = model.element.section_monomials(y, z)
    along = phi_y * slopes[0] + phi_z * slopes[1]
    return np.einsum("pk,pkn->pn", phi, N_x) + np.einsum("pk,pkn->pn", along, N)


def _pieces(model: RodModel, points: Floats) -> Iterator[tuple[int, float, float, Floats, bool]]:
    """Element, ends [m], slopes (y', z') of each piece in one element, and whether a path point begins it."""
    path = points * [model.rod.length, 1.0, 1.0]
    breaks = model.mesh.breaks
    for (x_a, *from_), (x_b, *to) in pairwise(path):
        slopes = (np.array(to) - from_) / (x_b - x_a)
        first, last = (
            np.searchsorted(breaks, x_a, side="right") - 1,
            np.searchsorted(breaks, x_b, side="left"),
        )
        for element in range(first, last):
            yield (
                int(element),
                max(x_a, breaks[element]),
                min(x_b, breaks[element + 1]),
                slopes,
                element == first,
            )
