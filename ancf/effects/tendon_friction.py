r"""Tendons of given tension with friction: the tension falls along the path by the capstan law.

    Q = -T P,   dQ/de = -T dP/de,

with the pull P of a unit tension on a path with friction (tendon_capstan.py): no potential, and one block
over the whole path, not symmetric.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import without_potential
from ancf.effects.tendon import PulledTendon
from ancf.rod_model import RodModel
from ancf.scene import Tendon
from ancf.tendon_capstan import CapstanPath

Floats = NDArray[np.float64]


def rubbing_tendon(model: RodModel, tendon: Tendon) -> RubbingTendon:
    """The effect of one tendon of given tension with friction."""
    assert tendon.tension is not None
    return RubbingTendon(tendon.tension, CapstanPath(model, tendon.path, tendon.friction))


class RubbingTendon(PulledTendon):
    """A tendon of given tension with friction, pulled at the first point of its path."""

    coupled = True

    def __init__(self, tension: float, path: CapstanPath) -> None:
        super().__init__(tension, path)
        self.capstan = path
        self.dofs = path.unknowns[None]

    def _pieces(self, e: Floats) -> Floats:
        """Nodal vectors (m, nodal, 3) of the pieces from those of the block e (1, nodes, 3)."""
        return e.ravel()[self.capstan.places].reshape(len(self.capstan.places), -1, 3)

    def length(self, e: Floats) -> float:
        """See `PulledTendon.length`."""
        return self.path.length(self._pieces(e))

    def end_share(self, e: Floats) -> float:
        """See `PulledTendon.end_share`."""
        return self.capstan.end_share(self._pieces(e))

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        pull = self.capstan.pull(self._pieces(e))
        total = np.bincount(self.capstan.places.ravel(), pull.ravel())
        return -self.tension * np.asarray(total, dtype=float).reshape(e.shape)

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; K (1, nd, nd)."""
        return self.force(e), -self.tension * self.capstan.pull_rate(self._pieces(e))[None]

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: friction has none."""
        return without_potential(self.tension)
