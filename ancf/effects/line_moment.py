"""Moment per reference length on the sections of a rod, fixed in space or turning with them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.distributed_couple import DistributedCouple
from ancf.effects import Effect, without_potential
from ancf.rod_model import RodModel
from ancf.rotation import hat
from ancf.scene import Scene
from ancf.section_spin import SectionAxes

Floats = NDArray[np.float64]


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Line moments of the scene."""
    models = {model.rod.name: model for model in rods}
    return [
        LineMoment(models[load.rod], load.value, load.direction == "follower") for load in scene.line_moments
    ]


class LineMoment(DistributedCouple):
    """A moment per length [N m/m], value (3,) in SCS at the reference."""

    name = "line_moment"

    def __init__(self, model: RodModel, value: Floats, follower: bool) -> None:
        super().__init__(model)
        self.value = value
        self.follower = follower
        self.turning = self.weight * (self.E @ value).T  # (3, n_el points) N m in the axes, of a follower

    def couple(self, axes: SectionAxes) -> Floats:
        """See `DistributedCouple.couple`."""
        return self.turning if self.follower else self.weight * axes.local(self.value)

    def couple_change(self, axes: SectionAxes, M: Floats) -> Floats | None:
        """See `DistributedCouple.couple_change`."""
        return None if self.follower else hat(M.T)

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: a moment in space has none."""
        return without_potential(self.value)
