r"""Forces that keep their direction relative to the section they act on, on one or spread along a rod.

With f_0 (3,) at the reference and the rotation R of each section (section_spin.py),

    Q = int S^T R f_0 dx,   dQ = -int S^T hat(f) dw dx,   f = R f_0,

S the weights of the nodal vectors in the point of the section that carries the force. There is no potential.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import SparseEffect, without_potential
from ancf.rotation import hat
from ancf.section_spin import SectionAxes, section_map
from ancf.vector_pairs import VectorPairs

Floats = NDArray[np.float64]


class TurningForce(SparseEffect):
    """Forces of one value on `points` sections of each of the blocks.

    Parameters
    ----------
    dofs : (m, nd) unknowns of the blocks
    N : (m, points, directors, nodal) the directors of the sections from the nodal vectors
    W : (m, points, directors, 3) weights of the section rotation
    shape : (m, points, nodal) weights of the nodal vectors in the loaded points, times those of the integral
    value : (3,) [N, or N/m] in SCS at the reference
    """

    def __init__(self, dofs: NDArray[np.intp], N: Floats, W: Floats, shape: Floats, value: Floats) -> None:
        self.dofs = dofs
        self.value = value
        to_b, E = section_map(N, W)
        self._to_b = to_b.reshape(len(dofs), -1, to_b.shape[-1])
        self._f = (E.reshape(-1, 3, 3) @ value).T  # (3, m points) in the axes of the sections
        self._hat_f = hat(self._f.T)
        self._to_nodes = np.ascontiguousarray(np.swapaxes(shape, 1, 2))
        self._pairs = VectorPairs(np.repeat(shape, 2, axis=1), self._to_b)
        self.entries = self._pairs.entries

    def _force(self, e: Floats) -> tuple[Floats, SectionAxes]:
        axes = SectionAxes.of((self._to_b @ e).reshape(-1, 2, 3))
        return self._to_nodes @ axes.vector(self._f).reshape(len(e), -1, 3), axes

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        return self._force(e)[0]

    def force_and_entries(self, e: Floats) -> tuple[Floats, Floats]:
        """See `SparseEffect.force_and_entries`; unsymmetric."""
        Q, axes = self._force(e)
        change = np.swapaxes(axes.vector_change(self._hat_f), 1, 2)  # by points, b
        return Q, self._pairs.entries_of(change.reshape(len(e), -1, 3, 3))

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: a force that turns has none."""
        return without_potential(self.value)
