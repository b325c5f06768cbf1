r"""Tendons: cables of given tension through points of the sections; with friction: tendon_friction.py.

A tendon is pulled by its tension T along its whole path, so with its length l (tendon_path.py)

    V = T l,   Q = -T dl/de,   dQ/de = -T d2l/de2.

That is all: the line load of its curvature, thrust and couples where it ends follow (Rucker, Webster, IEEE
Trans. Robotics 27 (2011) 1033, eq. 13-24, in the limit of a rigid section). Forces and moments of a tendon
balance: what it pulls at the first point of its path is part of the rod, not of the reaction of a support.
A tendon of controlled length is a constraint (tendon_length.py), its tension the multiplier.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect
from ancf.rod_model import RodModel
from ancf.scene import Scene
from ancf.tendon_path import TendonPath

Floats = NDArray[np.float64]


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Tendons of given tension of the scene."""
    models = {model.rod.name: model for model in rods}
    found: list[Effect] = []
    for tendon in scene.pulled_tendons:
        if tendon.friction > 0.0:
            from ancf.effects.tendon_friction import rubbing_tendon

            found.append(rubbing_tendon(models[tendon.rod], tendon))
        else:
            assert tendon.tension is not None
            found.append(PulledTendon(tendon.tension, TendonPath(models[tendon.rod], tendon.path)))
    return found


class PulledTendon(Effect):
    """A tendon of given tension."""

    name = "tendon"

    def __init__(self, tension: float, path: TendonPath) -> None:
        self.tension = tension  # N
        self.path = path
        self.dofs = path.dofs

    def length(self, e: Floats) -> float:
        """Length [m] at the nodal vectors e (m, nodal, 3)."""
        return self.path.length(e)

    def end_share(self, e: Floats) -> float:
        """Share of the tension at the last point of the path."""
        return 1.0

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return -self.tension * self.path.slope(e)

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; symmetric."""
        return self.force(e), -self.tension * self.path.bend(e)

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: V = T l."""
        return self.tension * self.length(e)
