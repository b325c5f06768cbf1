r"""Point moment on a section, in two definitions, fixed in space or following the section.

Section (default): conjugate to the spin of the polar rotation R of the section (section_spin.py),

    Q_k = mu x (R W_k),   mu = G^-1 M,   dw = G^-1 sum_k (R W_k) x dd_k.

Then sum_k d_k x Q_k = M and the power is M . w, both exactly.

Vorticity (paper eq. 23-36): half the skew part of the velocity gradient L = J_dot J^-1,

    Q_a = 1/2 M x g^a,  g^a rows of J^-1, J = [r_x r_y r_z],  dQ_a/dr_b = -1/2 (M x g^b)(g^a)^T.

It works on half the shear as well, so r_x at a loaded end turns by a spurious angle that grows with mesh
refinement; r, r_y and r_z are clean. A follower moment is M = R M_0, dM = dw x M. No moment in space has a
potential.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect, without_potential
from ancf.rod_model import RodModel, SectionPoint
from ancf.rotation import SectionRotation, hat, section_rotation
from ancf.scene import Scene
from ancf.section_couples import SectionMoments

Floats = NDArray[np.float64]


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Point moments of the scene."""
    models = {model.rod.name: model for model in rods}
    effects: list[Effect] = []
    for load in scene.moments:
        model = models[load.rod]
        follower = load.direction == "follower"
        after = model.section_point(load.at)
        if load.definition == "section":
            effects.append(SectionMoment(after, load.value, follower))
            continue
        linear = [model.element.y_director, model.element.z_director]
        before = model.section_point(load.at, before=True)
        if np.array_equal(before.dofs, after.dofs):
            effects.append(VorticityMoment(after, load.value, follower, linear))
        else:  # r_x may jump on an element boundary: half the moment on each side
            effects += [VorticityMoment(side, 0.5 * load.value, follower, linear) for side in (before, after)]
    return effects


class SectionMoment(SectionMoments):
    """Moment [N m] conjugate to the spin of the section's polar rotation."""

    name = "moment"

    def __init__(self, point: SectionPoint, value: Floats, follower: bool) -> None:
        section = (point.dofs[None], point.N[None, None], point.W[None, None])
        super().__init__(*section, np.ones((1, 1)), value, follower)
        self.point = point


class VorticityMoment(Effect):
    """The paper's moment: conjugate to the vorticity of the material at the point."""

    name = "moment"

    def __init__(self, point: SectionPoint, value: Floats, follower: bool, linear: list[int]) -> None:
        self.dofs = point.dofs[None]
        self.point = point
        self.value = value  # (3,) N m, SCS, at the reference
        self.follower = follower
        # Map (3, nodal) from nodal vectors to r_x, r_y, r_z on the axis.
        self.to_gradient = np.stack([point.N_x[0], *(point.N[k] for k in linear)])

    def _rotation(self, e: Floats) -> SectionRotation:
        return section_rotation(self.point.N @ e[0], self.point.W)

    def _moment(self, rotation: SectionRotation) -> Floats:
        return rotation.R @ self.value if self.follower else self.value

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: a moment in space has none."""
        return without_potential(self.value)

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        to_gradient = self.to_gradient
        g = np.linalg.inv((to_gradient @ e[0]).T)
        Q = to_gradient.T @ (0.5 * np.cross(self._moment(self._rotation(e)), g))
        return np.asarray(Q[None], dtype=float)

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; unsymmetric."""
        to_gradient = self.to_gradient
        g = np.linalg.inv((to_gradient @ e[0]).T)
        rotation = self._rotation(e)
        M = self._moment(rotation)
        M_x_g = np.cross(M, g)
        dQ = -0.5 * np.einsum("bi,ac->aibc", M_x_g, g)
        K = _to_nodes(to_gradient, to_gradient, dQ)
        if self.follower:
            # dM x g^a with dM = dw x M
            dM = -np.einsum("ij,jkc->ikc", hat(M), rotation.spin())
            K += _to_nodes(to_gradient, self.point.N, -0.5 * np.einsum("aij,jkc->aikc", hat(g), dM))
        return np.asarray((to_gradient.T @ (0.5 * M_x_g))[None], dtype=float), K


def _to_nodes(left: Floats, right: Floats, dQ: Floats) -> Floats:
    """Bring dQ (l, 3, k, 3) on vectors left @ e, right @ e to the nodal vectors: (1, nd, nd)."""
    K = np.einsum("lm,likc,kn->minc", left, dQ, right)
    size = 3 * left.shape[1]
    return np.asarray(K.reshape(1, size, size), dtype=float)
