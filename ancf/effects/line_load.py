r"""Force per reference length on the centre line of a rod, dead or follower: Q = int N_0^T f dx."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import DeadLoad, Effect, SparseEffect, without_potential
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rotation import hat
from ancf.scene import Scene
from ancf.section_spin import SectionAxes, section_map
from ancf.vector_pairs import VectorPairs

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


class FollowerLineLoad(SparseEffect):
    """A line load that keeps its direction relative to each section."""

    name = "line_load"

    def __init__(self, dofs: NDArray[np.intp], N: Floats, W: Floats, shape: Floats, value: Floats) -> None:
        self.dofs = dofs
        self.value = value  # (3,) N/m, at the reference
        to_b, E = section_map(N, W)
        self.to_b = to_b.reshape(len(N), -1, to_b.shape[-1])  # (n_el, points 2, nodal)
        self.f = (E.reshape(-1, 3, 3) @ value).T  # (3, n_el points) in the axes of the sections
        self.hat_f = hat(self.f.T)
        self._pairs = VectorPairs(np.repeat(shape, 2, axis=1), self.to_b)
        self.entries = self._pairs.entries
        self._to_nodes = np.ascontiguousarray(np.swapaxes(shape, 1, 2))

    def _turned(self, e: Floats) -> SectionAxes:
        return SectionAxes.of((self.to_b @ e).reshape(-1, 2, 3))

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`: Q = int N_0^T R f_0 dx."""
        return self._to_nodes @ self._turned(e).vector(self.f).reshape(len(e), -1, 3)

    def force_and_entries(self, e: Floats) -> tuple[Floats, Floats]:
        """See `SparseEffect.force_and_entries`: dQ = -int N_0^T hat(f) dw dx (section_spin.py)."""
        axes = self._turned(e)
        df = np.swapaxes(axes.vector_change(self.hat_f), 1, 2).reshape(len(e), -1, 3, 3)  # points, b
        Q = self._to_nodes @ axes.vector(self.f).reshape(len(e), -1, 3)
        return Q, self._pairs.entries_of(df)

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: a follower load has none."""
        return without_potential(self.value)
