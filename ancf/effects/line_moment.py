"""Moment per reference length on the sections of a rod, fixed in space or turning with them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.distributed_couple import DistributedCouple, turning
from ancf.effects import Effect, without_potential
from ancf.rod_model import RodModel
from ancf.scene import Scene

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

    def couple(self, R: Floats) -> Floats:
        """See `DistributedCouple.couple`."""
        return R @ self.value if self.follower else np.broadcast_to(self.value, R.shape[:-1])

    def couple_change(self, R: Floats, m: Floats) -> Floats | float:
        """See `DistributedCouple.couple_change`."""
        return turning(m) if self.follower else 0.0

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: a moment in space has none."""
        return without_potential(self.value)
