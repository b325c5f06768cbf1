r"""Force per reference length on the centre line of a rod, dead or follower: Q = int N_0^T f dx."""

from __future__ import annotations

import numpy as np

from ancf.effects import DeadLoad, Effect
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.scene import Scene
from ancf.turning_force import TurningForce

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


class FollowerLineLoad(TurningForce):
    """A line load [N/m] that keeps its direction relative to each section."""

    name = "line_load"
