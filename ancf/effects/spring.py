r"""Springs between a point of a section and the ground.

The point has the place c = S e, with the weights S of a point force (section_energy.force_weights), so spring
and force do the same work. A spring to the reference resists displacements by its stiffness matrix k, one to
an anchor a changes of its length l = |c - a| from the free length l_0:

    V = 1/2 u^T k u, u = c - c_0,        F = -k u,              dF/dc = -k,
    V = 1/2 k (l - l_0)^2,               F = -k (l - l_0) t,    dF/dc = -k (t t^T + (1 - l_0/l) (I - t t^T)),

t = (c - a)/l, and Q = S^T F. A spring shorter than its anchor is away pulls from the beginning. One to the
reference may resist the rotation of the section too (rotational_spring.py).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect
from ancf.rod_model import RodModel
from ancf.scene import Scene, Spring
from ancf.section_energy import force_weights

Floats = NDArray[np.float64]


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Springs of the scene."""
    models = {model.rod.name: model for model in rods}
    return [_spring(models[spring.rod], spring) for spring in scene.springs]


def _spring(model: RodModel, spring: Spring) -> Effect:
    if spring.anchor is not None:
        return AnchoredSpring(model, spring)
    if np.any(spring.rotational_stiffness):
        from ancf.effects.rotational_spring import RotationalSpring

        return RotationalSpring(model, spring)
    return ReferenceSpring(model, spring)


class PointSpring(Effect):
    """What both kinds share: a force F(c) on one point, and its tangent."""

    name = "spring"
    passive = True

    def __init__(self, model: RodModel, spring: Spring) -> None:
        self.spring = spring
        point = model.section_point(spring.at)
        self.S = point.N[0]  # (nodal,)
        if np.any(spring.offset):
            y, z = (float(value) for value in spring.offset)
            self.S = force_weights(model.element, model.rod.section_at(spring.at), y, z) @ point.N
        self.dofs = point.dofs[None]

    def force_on(self, c: Floats) -> tuple[Floats, Floats]:
        """F (3,) [N] on the point at c (3,), and dF/dc (3, 3)."""
        raise NotImplementedError

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return np.outer(self.S, self.force_on(self.S @ e[0])[0])[None]

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; symmetric."""
        F, dF = self.force_on(self.S @ e[0])
        size = 3 * len(self.S)
        K = np.einsum("m,n,ab->manb", self.S, self.S, dF).reshape(1, size, size)
        return np.outer(self.S, F)[None], K

    def report(self, e: Floats) -> dict[str, Any]:
        """The spring's entry in the result: its force [N] on the rod."""
        F, _ = self.force_on(self.S @ e[0])
        return {"rod": self.spring.rod, "at": self.spring.at, "force": F.tolist()}


class ReferenceSpring(PointSpring):
    """A spring that resists displacements from the reference."""

    def __init__(self, model: RodModel, spring: Spring) -> None:
        super().__init__(model, spring)
        self.k = spring.stiffness  # (3, 3) N/m, SCS
        self.c_0 = self.S @ model.q0.reshape(-1, 3)[(self.dofs[0, ::3] - model.first_dof) // 3]

    def force_on(self, c: Floats) -> tuple[Floats, Floats]:
        """See `PointSpring.force_on`."""
        return -self.k @ (c - self.c_0), -self.k

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        u = self.S @ e[0] - self.c_0
        return 0.5 * float(u @ self.k @ u)


class AnchoredSpring(PointSpring):
    """A spring along the line to a point of the ground."""

    def __init__(self, model: RodModel, spring: Spring) -> None:
        super().__init__(model, spring)
        assert spring.anchor is not None
        self.k = float(spring.stiffness[0, 0])  # N/m
        self.anchor = spring.anchor - model.rod.base.position  # as the nodes
        c_0 = self.S @ model.q0.reshape(-1, 3)[(self.dofs[0, ::3] - model.first_dof) // 3]
        distance = float(np.linalg.norm(c_0 - self.anchor))
        self.free_length = distance if spring.free_length is None else spring.free_length

    def length(self, e: Floats) -> float:
        """Length l [m]."""
        return float(np.linalg.norm(self.S @ e[0] - self.anchor))

    def force_on(self, c: Floats) -> tuple[Floats, Floats]:
        """See `PointSpring.force_on`; not finite where a spring of some free length has none left."""
        arm = c - self.anchor
        if self.free_length == 0.0:
            return -self.k * arm, -self.k * np.eye(3)
        length = np.linalg.norm(arm)
        share = 1.0 - self.free_length / length
        t = arm / length
        along = np.outer(t, t)
        return -self.k * share * arm, -self.k * (along + share * (np.eye(3) - along))

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        return 0.5 * self.k * (self.length(e) - self.free_length) ** 2

    def report(self, e: Floats) -> dict[str, Any]:
        """See `PointSpring.report`; also its length [m]."""
        return super().report(e) | {"length": self.length(e)}
