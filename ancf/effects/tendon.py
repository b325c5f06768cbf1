r"""Tendons: cables of given tension through points of the sections; with friction: tendon_friction.py.

A tendon is pulled by its tension T along its whole path, so with its length l (tendon_path.py)

    V = T l,   Q = -T dl/de,   dQ/de = -T d2l/de2.

That is all: the line load of its curvature, thrust and couples where it ends follow (Rucker, Webster, IEEE
Trans. Robotics 27 (2011) 1033, eq. 13-24, in the limit of a rigid section). Forces and moments of a tendon
balance: what it pulls at the first point of its path is part of the rod, not of the reaction of a support.
A tendon of controlled length is a constraint (tendon_length.py), its tension the multiplier.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.effects import Effect, SparseEffect
from ancf.rod_model import RodModel
from ancf.scene import Scene
from ancf.tendon_path import TendonPath
from ancf.vector_pairs import VectorPairs

Floats = NDArray[np.float64]

IDENTITY = np.eye(3)


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


class PulledTendon(SparseEffect):
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

    @cached_property
    def _pairs(self) -> VectorPairs:
        return VectorPairs(self.path.weight[..., None] * self.path.a, self.path.a)

    @cached_property
    def entries(self) -> NDArray[np.intp]:  # type: ignore[override]
        """See `SparseEffect`: of the nodal vectors that move the path."""
        return self._pairs.entries

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return -self.tension * self.path.slope(e)

    def force_and_entries(self, e: Floats) -> tuple[Floats, Floats]:
        """See `SparseEffect.force_and_entries`; symmetric."""
        t, stretch = self.path.tangents(e)
        along = t[..., None] * t[..., None, :]
        across = (IDENTITY - along) * (-self.tension / stretch)[..., None, None]
        return -self.tension * self.path.on_nodes(t), self._pairs.entries_of(across)

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: V = T l."""
        return self.tension * self.length(e)
