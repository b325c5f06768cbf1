r"""Force per reference length on the centre line of a rod, dead or follower: Q = int N_0^T f dx."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import DeadLoad, Effect, without_potential
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rotation import hat, section_rotation
from ancf.scene import Scene

Floats = NDArray[np.float64]

DEAD_POINTS = 2  # exact: the axis is cubic at most
FOLLOWER_POINTS = 3  # the turning direction adds degrees; one point more than the elastic rule of 3333


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Line loads of the scene."""
    models = {model.rod.name: model for model in rods}
    effects: list[Effect] = []
    for load in scene.line_loads:
        model = models[load.rod]
        follower = load.direction == "follower"
        xi, weight = gauss(FOLLOWER_POINTS if follower else DEAD_POINTS)
        h = model.mesh.h
        N = np.array([model.element.shape(xi, length) for length in h])  # (n_el, points, directors, nodal)
        shape = 0.5 * h[:, None, None] * weight[:, None] * N[:, :, 0]  # (n_el, points, nodal)
        if follower:
            W = model.weights_at(xi, N @ model.e0[:, None])
            effects.append(FollowerLineLoad(model.dofs, N, W, shape, load.value))
        else:
            Q = np.einsum("epn,a->ena", shape, load.value)
            effects.append(DeadLoad("line_load", model.dofs, Q))
    return effects


class FollowerLineLoad(Effect):
    """A line load that keeps its direction relative to each section."""

    name = "line_load"

    def __init__(self, dofs: NDArray[np.intp], N: Floats, W: Floats, shape: Floats, value: Floats) -> None:
        self.dofs = dofs
        self.N = N
        self.W = W
        self.shape = shape
        self.value = value  # (3,) N/m, at the reference

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`: Q = int N_0^T R f_0 dx."""
        R = section_rotation(self.N @ e[:, None], self.W).R
        return np.einsum("epn,epa->ena", self.shape, R @ self.value)

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`: dQ = -int N_0^T hat(f) dw dx."""
        rotation = section_rotation(self.N @ e[:, None], self.W)
        f = rotation.R @ self.value
        count, points, _, nodal = self.N.shape
        df_dd = np.swapaxes(-hat(f)[..., None, :, :] @ np.moveaxis(rotation.spin(), 3, 2), 3, 4)
        df = np.swapaxes(df_dd, 2, 4).reshape(count, points, 9, -1) @ self.N
        df = df.reshape(count, points, 3, 3, nodal).swapaxes(3, 4)
        K = np.swapaxes(self.shape, 1, 2) @ df.reshape(count, points, -1)
        return np.einsum("epn,epa->ena", self.shape, f), K.reshape(count, 3 * nodal, 3 * nodal)

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: a follower load has none."""
        return without_potential(self.value)
