r"""Elastic beds that resist the rotation of the sections besides the displacement of the axis.

    V = 1/2 int u^T k u dx + 1/2 int theta . k_theta theta dx

with rotational springs (turning_springs.py) at the same places as the others. A straight rod twisted on such
a bed has GJ theta'' = k_theta theta.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.effects.foundation import ElasticFoundation
from ancf.rod_model import RodModel
from ancf.scene import Foundation
from ancf.section_energy import director_weights
from ancf.turning_springs import TurningSprings

Floats = NDArray[np.float64]


class RotationalBed(ElasticFoundation):
    """A bed of springs against displacements and rotations; blocks are the elements on it."""

    def __init__(self, model: RodModel, bed: Foundation) -> None:
        super().__init__(model, bed)
        breaks, h = model.mesh.breaks[self.elements, None], model.mesh.h[self.elements, None]
        xi = 2.0 * (self.x - breaks) / h - 1.0
        shapes = [model.element.shape(row, float(one)) for row, one in zip(xi, h[:, 0], strict=True)]
        N = np.array(shapes)  # (m, points, directors, nodal)
        sections = [
            model.section_in(int(i), float(s)) for i, row in zip(self.elements, xi, strict=True) for s in row
        ]
        W = director_weights(model.element, sections, N @ self.e_0[:, None])
        k = self.stiffness_of(model, bed.rotational_stiffness)
        self.turning = TurningSprings(model, self.dofs, N, W, self.weight, k)
        self.entries = np.arange(self.K.size)

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return super().force(e) + self.turning.force(e)

    def force_and_entries(self, e: Floats) -> tuple[Floats, Floats]:
        """See `SparseEffect.force_and_entries`; symmetric."""
        Q, K = self.turning.force_and_tangent(e)
        return super().force(e) + Q, (self.K + K).ravel()

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        return super().potential(e) + self.turning.potential(e)

    def is_known(self, q: Floats) -> bool:
        """See `Effect.is_known`: less than half a turn."""
        return self.turning.is_known(q)

    def report(self, e: Floats) -> dict[str, Any]:
        """See `ElasticFoundation.report`; also the moment [N m] on the rod, and the largest angle [rad]."""
        angle = float(np.max(np.linalg.norm(self.turning.rotation_vectors(e), axis=-1)))
        return super().report(e) | {"moment": self.turning.moment(e).tolist(), "rotation": angle}
