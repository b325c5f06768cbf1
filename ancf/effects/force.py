r"""Point force on a material point of a section (paper eq. 19-22), dead or follower.

The point (y, z) of the section at x has r = sum_k phi_k(y, z) d_k(x), so Q = S^T F with S = sum_k phi_k N_k;
on sections that are not linear in (y, z) it is spread over the section (section_energy.force_weights).
A follower force turns with the section, F = R F_0, dF = dw x F with the spin dw of rotation.py.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import DeadLoad, Effect, without_potential
from ancf.rod_model import RodModel, SectionPoint
from ancf.rotation import hat, section_rotation
from ancf.scene import Scene
from ancf.section_energy import force_weights

Floats = NDArray[np.float64]


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Point forces of the scene."""
    models = {model.rod.name: model for model in rods}
    effects: list[Effect] = []
    for load in scene.forces:
        model = models[load.rod]
        point = model.section_point(load.at)
        y, z = (float(value) for value in load.offset)
        shape = force_weights(model.element, model.rod.section_at(load.at), y, z) @ point.N
        if load.direction == "fixed":
            effects.append(DeadLoad("force", point.dofs[None], np.outer(shape, load.value)[None]))
        else:
            effects.append(FollowerForce(point, shape, load.value))
    return effects


class FollowerForce(Effect):
    """A force that keeps its direction relative to the section."""

    name = "force"

    def __init__(self, point: SectionPoint, shape: Floats, value: Floats) -> None:
        self.dofs = point.dofs[None]
        self.point = point
        self.shape = shape  # (nodal,)
        self.value = value  # (3,) N, at the reference

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`: Q = S^T R F_0."""
        R = section_rotation(self.point.N @ e[0], self.point.W).R
        return np.outer(self.shape, R @ self.value)[None]

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`: dQ = -S^T hat(F) dw."""
        rotation = section_rotation(self.point.N @ e[0], self.point.W)
        F = rotation.R @ self.value
        dw = np.einsum("ikc,kn->inc", rotation.spin(), self.point.N)
        dF = -np.einsum("ij,jnc->inc", hat(F), dw)
        size = 3 * len(self.shape)
        K = np.einsum("m,inc->minc", self.shape, dF).reshape(1, size, size)
        return np.outer(self.shape, F)[None], K

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: a follower force has none."""
        return without_potential(self.value)
