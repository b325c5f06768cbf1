r"""Stiffnesses between vectors of an element, brought to the nodal vectors they depend on.

Vectors l_k = L_k e and r_k = R_k e are linear in the nodal vectors, and forces on the l_k change by
C_k (3, 3) with the r_k. In the blocks of the elements that is

    dQ/de = sum_k L_k^T R_k (x) C_k,

whose entries are those of the pairs of nodal vectors (n, n') on which some l_k and some r_k depend: the sums
over k are one product with the weights L_kn R_kn'.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class VectorPairs:
    """Weights of the stiffnesses C_k of elements.

    Attributes
    ----------
    entries : places of the results in the blocks (m, nd, nd), flattened, as `SparseEffect.entries`
    """

    def __init__(self, L: Floats, R: Floats) -> None:
        """Of L and R (m, k, nodal), a pair of vectors each."""
        m, _, nodal = L.shape
        left, right = (np.flatnonzero(np.any(one != 0.0, axis=(0, 1))) for one in (L, R))
        weights = L[:, :, left, None] * R[:, :, None, right]
        self.weights = np.ascontiguousarray(np.moveaxis(weights.reshape(m, L.shape[1], -1), 1, 2))
        component = np.arange(3)
        rows = 3 * left[:, None, None, None] + component[:, None]  # n, n', a, a'
        columns = 3 * right[:, None, None] + component
        size = 3 * nodal
        blocks = size * size * np.arange(m)
        self.entries = (blocks[:, None] + (rows * size + columns).ravel()).ravel()

    def entries_of(self, C: Floats) -> Floats:
        """Entries of dQ/de from C (m, k, 3, 3)."""
        m, k = C.shape[:2]
        return (self.weights @ C.reshape(m, k, 9)).ravel()
