"""Effects: one module each, imported only when a scene lists the effect.

An effect acts on dense blocks of unknowns and knows nothing of the other effects, of assembly or of Newton.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def blocks_of(q: Floats, dofs: NDArray[np.intp]) -> Floats:
    """Nodal vectors (m, nd / 3, 3) of the blocks dofs (m, nd)."""
    return q[dofs].reshape(len(dofs), dofs.shape[1] // 3, 3)


class Effect(ABC):
    """What the solver asks of an effect.

    `dofs` (m, nd) are the unknowns of its m blocks; `force` and `force_and_tangent` take the nodal vectors of
    the blocks e (m, nd / 3, 3) and return the generalised force Q (m, nd / 3, 3) at load factor 1 and
    dQ/de (m, nd, nd), None where Q is constant. `potential` returns V [J] with Q = -dV/de, or None where the
    effect has none.
    """

    name: str
    dofs: NDArray[np.intp]
    # A load grows with the load factor; what is passive (a spring, an obstacle) is there from the beginning.
    passive: bool = False
    # Whether blocks join unknowns that no element joins: then the tangent is sparse instead of a band.
    coupled: bool = False
    # Whether something is held fixed in a Newton run and moved between runs: by `search` and `augment`.
    settles: bool = False

    @abstractmethod
    def force(self, e: Floats) -> Floats:
        """Generalised force Q (m, nd / 3, 3)."""

    @abstractmethod
    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats | None]:
        """Q and the tangent dQ/de (m, nd, nd), None where it is zero."""

    @abstractmethod
    def potential(self, e: Floats) -> float | None:
        """Potential V [J], None for an effect without one."""

    def search(self, q: Floats) -> None:
        """Look at q (n,) for the blocks of the Newton run that begins there; with `settles` only."""
        return

    def augment(self, q: Floats) -> bool:
        """Move what a Newton run holds fixed (multipliers of contact); whether there was anything to move."""
        return False

    def release(self) -> None:
        """Forget what `augment` has found."""
        return

    def room(self, q: Floats, q_new: Floats) -> float:
        """Share of the way from q to q_new (n,) that one step may take; above 1 as much more."""
        return np.inf

    def report(self, e: Floats) -> dict[str, Any]:
        """What there is to tell in the result (passive_reports.py), plain Python."""
        return {}


class DeadLoad(Effect):
    """A load whose generalised force is constant: Q = S^T F (paper eq. 20)."""

    def __init__(self, name: str, dofs: NDArray[np.intp], Q: Floats) -> None:
        self.name = name
        self.dofs = dofs
        self.Q = Q

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return self.Q

    def force_and_tangent(self, e: Floats) -> tuple[Floats, None]:
        """See `Effect.force_and_tangent`: a dead load has no tangent."""
        return self.Q, None

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`: V = -Q . e."""
        return -float(np.sum(self.Q * e))
