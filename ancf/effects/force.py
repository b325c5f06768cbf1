r"""Point force on a material point of a section (paper eq. 19-22), dead or follower.

The point (y, z) of the section at x has r = sum_k phi_k(y, z) d_k(x), so Q = S^T F with S = sum_k phi_k N_k;
on sections that are not linear in (y, z) it is spread over the section (section_energy.force_weights).
A follower force turns with the section (turning_force.py).
"""

from __future__ import annotations

import numpy as np

from ancf.effects import DeadLoad, Effect
from ancf.rod_model import RodModel
from ancf.scene import Scene
from ancf.section_energy import force_weights
from ancf.turning_force import TurningForce


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
            section = (point.dofs[None], point.N[None, None], point.W[None, None])
            effects.append(FollowerForce(*section, shape[None, None], load.value))
    return effects


class FollowerForce(TurningForce):
    """A force [N] that keeps its direction relative to the section."""

    name = "force"
