r"""Tendons of controlled length with friction: the drum's tension falls along the path.

The condition is that of tendon_length.py: the cable does not stretch, so its length is that of the path
whatever its tension is along it. The unknown T is the tension at the pulled end, and the rod feels the pull P
of a path with friction (tendon_capstan.py) in place of dl/de:

    g_e = T P(e),   dg_e/de = T dP/de,   dg_e/dT = P,   dl/de the row of the condition.

The tangent is not symmetric. The capstan law is that of a cable that slides towards the drum, which takes it
in; a cable that is let out, or held while loads stretch its path, has less tension at the drum than it says.
A slack tendon does not rub.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.rod_model import RodModel
from ancf.scene import Tendon
from ancf.tendon_capstan import CapstanPath
from ancf.tendon_length import TendonLength

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


class RubbingTendonLength(TendonLength):
    """One tendon of controlled length with friction."""

    conservative = False
    capstan: CapstanPath

    def __init__(self, tendon: Tendon, rods: list[RodModel], first: int) -> None:
        super().__init__(tendon, rods, first)
        self.held_dofs = self.capstan.unknowns

    def _path(self, rod: RodModel) -> CapstanPath:
        self.capstan = CapstanPath(rod, self.tendon.path, self.tendon.friction)
        return self.capstan

    @property
    def _blocks(self) -> Indices:
        return self.capstan.unknowns[None]

    def _pull(self, e: Floats, slope: Floats) -> tuple[Floats, Floats]:
        return self.capstan.pull(e).ravel(), self.capstan.pull_rate(e).ravel()

    def end_tension(self, q: Floats) -> float:
        """See `TendonLength.end_tension`."""
        return self.tension(q) * self.capstan.end_share(self._vectors(q[self.dofs[:-1]]))
