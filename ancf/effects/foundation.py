r"""Elastic foundation: springs spread along a rod, each between a point of the axis and its reference place.

    V = 1/2 int u^T k u dx,   u = N (e - e_0),   Q = -int N^T k u dx,   dQ/de = -int N^T k N dx,

with the stiffness matrix k [N/m2] per reference length: the bed of Winkler (Hetenyi, Beams on Elastic
Foundation, 1946, ch. 1), which does not know where the rod has gone to. Of a stiffness across the axis alone
nothing holds the rod along it. The tangent is constant. With rotational stiffnesses: rotational_bed.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect, SparseEffect
from ancf.mesh import reference_axis
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.scene import Foundation, Scene
from ancf.vector_pairs import VectorPairs

Floats = NDArray[np.float64]

AXIAL_POINTS = 4  # exact for the square of a cubic axis


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Foundations of the scene."""
    models = {model.rod.name: model for model in rods}
    return [_bed(models[bed.rod], bed) for bed in scene.foundations]


def _bed(model: RodModel, bed: Foundation) -> Effect:
    if np.any(bed.rotational_stiffness):
        from ancf.effects.rotational_bed import RotationalBed

        return RotationalBed(model, bed)
    return ElasticFoundation(model, bed)


class ElasticFoundation(SparseEffect):
    """A bed of springs; blocks are the elements on it."""

    name = "foundation"
    passive = True

    def __init__(self, model: RodModel, bed: Foundation) -> None:
        self.bed = bed
        breaks, length = model.mesh.breaks, model.rod.length
        ends = np.clip(breaks, bed.start * length, bed.end * length)
        elements = self.elements = np.flatnonzero(np.diff(ends) > 0.0)
        xi, weight = gauss(AXIAL_POINTS)
        half = 0.5 * np.diff(ends)[elements, None]
        x = self.x = ends[elements, None] + half * (1.0 + xi)  # (m, points) m
        self.weight = half * weight  # (m, points) m
        N = [
            model.element.shape(2.0 * (places - breaks[i]) / h - 1.0, h)[:, 0]
            for i, h, places in zip(elements, model.mesh.h[elements], x, strict=True)
        ]
        self.N = np.array(N)  # (m, points, nodal)
        self.k = self.weight[..., None, None] * self.stiffness_of(model, bed.stiffness)  # [N/m]
        self.dofs = model.dofs if len(elements) == len(model.dofs) else model.dofs[elements]
        self.e_0 = model.e0[elements]
        size = 3 * self.N.shape[-1]
        K = np.einsum("mpi,mpj,mpab->miajb", self.N, self.N, self.k, optimize=True)
        self.K = -K.reshape(len(K), size, size)
        self.entries = VectorPairs(self.N, self.N).entries
        self.values = self.K.ravel()[self.entries]

    def stiffness_of(self, model: RodModel, along: Floats) -> Floats:
        """Matrices (m, points, 3, 3) in SCS of stiffnesses (3,) along the axes of the bed."""
        axes = self.bed.axes
        if axes is None:
            _, frame = reference_axis(self.x.ravel(), model.rod.curvature)
            axes = (model.rod.base.rotation @ frame).reshape(*self.x.shape, 3, 3)
        return (axes * along) @ np.swapaxes(axes, -1, -2) + np.zeros((*self.x.shape, 1, 1))

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return (self.K @ (e - self.e_0).reshape(len(e), -1, 1)).reshape(e.shape)

    def force_and_entries(self, e: Floats) -> tuple[Floats, Floats]:
        """See `SparseEffect.force_and_entries`; symmetric and constant."""
        return self.force(e), self.values

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        u = self.N @ (e - self.e_0)
        return 0.5 * float(np.einsum("mpa,mpab,mpb->", u, self.k, u))

    def report(self, e: Floats) -> dict[str, Any]:
        """The bed's entry in the result: its force [N] on the rod, and the largest displacement [m]."""
        u = self.N @ (e - self.e_0)
        force = -np.einsum("mpab,mpb->a", self.k, u)
        largest = float(np.max(np.linalg.norm(u, axis=-1)))
        return {"rod": self.bed.rod, "force": force.tolist(), "displacement": largest}
