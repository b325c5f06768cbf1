"""Tangent by central differences of a block force: the paper's numerical tangent (eq. 38-41).

The paper perturbs every coordinate of the model in turn; a block force depends on the coordinates of its
block only, so perturbing all blocks at once gives the same matrix with 2 nd evaluations instead of 2 n.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Central differences: error h^2 f''' + eps f / h is least near eps^(1/3).
RELATIVE_STEP = float(np.cbrt(np.finfo(float).eps))


def difference_tangent(force: Callable[[Floats], Floats], e: Floats, unit: Floats) -> Floats:
    """dQ/de (m, nd, nd) of force(e) -> Q for blocks e (m, nd / 3, 3); `unit` scales the steps."""
    m, vectors, _ = e.shape
    K = np.empty((m, 3 * vectors, 3 * vectors))
    for column in range(3 * vectors):
        vector, component = divmod(column, 3)
        step = RELATIVE_STEP * unit[:, vector, component]
        ahead, behind = e.copy(), e.copy()
        ahead[:, vector, component] += step
        behind[:, vector, component] -= step
        # The step that was really taken, after rounding.
        taken = ahead[:, vector, component] - behind[:, vector, component]
        K[:, :, column] = (force(ahead) - force(behind)).reshape(m, -1) / taken[:, None]
    return K
