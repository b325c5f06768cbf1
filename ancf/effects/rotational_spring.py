"""Springs that resist the rotation of a section and the displacement of its point (turning_springs.py)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.effects.spring import ReferenceSpring
from ancf.rod_model import RodModel
from ancf.scene import Spring
from ancf.turning_springs import TurningSprings

Floats = NDArray[np.float64]


class RotationalSpring(ReferenceSpring):
    """A spring that resists displacements and rotations from the reference."""

    def __init__(self, model: RodModel, spring: Spring) -> None:
        super().__init__(model, spring)
        point = model.section_point(spring.at)
        k = spring.rotational_stiffness[None, None]
        self.turning = TurningSprings(
            model, self.dofs, point.N[None, None], point.W[None, None], np.ones((1, 1)), k
        )

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return super().force(e) + self.turning.force(e)

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; symmetric."""
        (Q, K), (Q_turning, K_turning) = super().force_and_tangent(e), self.turning.force_and_tangent(e)
        return Q + Q_turning, K + K_turning

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        return super().potential(e) + self.turning.potential(e)

    def is_known(self, q: Floats) -> bool:
        """See `Effect.is_known`: less than half a turn."""
        return self.turning.is_known(q)

    def report(self, e: Floats) -> dict[str, Any]:
        """See `PointSpring.report`; also its moment [N m] on the rod, and the rotation vector [rad]."""
        theta = self.turning.rotation_vectors(e)[0, 0]
        return super().report(e) | {"moment": self.turning.moment(e).tolist(), "rotation": theta.tolist()}
