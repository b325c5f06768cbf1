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


def without_potential(value: NDArray[np.float64] | float) -> float | None:
    """`Effect.potential` of a load that has none unless its value is zero."""
    return None if np.any(value) else 0.0


class Effect(ABC):
    """What the solver asks of an effect.

    `dofs` (m, nd) are the unknowns of its m blocks; `force` and `force_and_tangent` take the nodal vectors of
    the blocks e (m, nd / 3, 3) and return the generalised force Q (m, nd / 3, 3) at load factor 1 and
    dQ/de (m, nd, nd), None where Q is constant. `potential` returns V [J] with Q = -dV/de, or None where the
    effect has none; a load of value zero has V = 0, as if it were not listed (`without_potential`).
    """

    name: str
    dofs: NDArray[np.intp]
    # A load grows with the load factor; what is passive (a spring, an obstacle) is there from the beginning.
    passive: bool = False
    # Whether blocks join unknowns that no element joins: then the tangent is sparse instead of a band.
    coupled: bool = False
    # Whether something is held fixed in a Newton run and moved between runs: by `search` and `augment`.
    settles: bool = False
    # Whether the force depends on the way that led to a state, as friction: then every load step counts.
    path_dependent: bool = False

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

    def commit(self, q: Floats) -> None:
        """Begin the next load step at the accepted equilibrium q (n,)."""
        return

    def restart(self) -> None:
        """Go back to the beginning of the load step that has failed."""
        self.release()

    def room(self, q: Floats, q_new: Floats) -> float:
        """Share of the way from q to q_new (n,) that one step may take; above 1 as much more."""
        return np.inf

    def is_known(self, q: Floats) -> bool:
        """Whether q (n,) is a state that the effect can tell from others (turning_springs.py)."""
        return True

    def report(self, e: Floats) -> dict[str, Any]:
        """What there is to tell in the result (passive_reports.py), plain Python."""
        return {}


class SparseEffect(Effect):
    """An effect on few of the nodal vectors, or few pairs of them: most of dQ/de is zero.

    Attributes
    ----------
    entries : (k,) places of the other entries in the blocks dQ/de (m, nd, nd), flattened; each once
    """

    entries: NDArray[np.intp]

    @abstractmethod
    def force_and_entries(self, e: Floats) -> tuple[Floats, Floats]:
        """Q (m, nd / 3, 3) and the entries of dQ/de (k values)."""

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`."""
        Q, values = self.force_and_entries(e)
        m, nd = self.dofs.shape
        K = np.zeros(m * nd * nd)
        K[self.entries] = values.ravel()
        return Q, K.reshape(m, nd, nd)


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
