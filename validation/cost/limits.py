r"""Where a ladder of meshes leads: Richardson's extrapolation that claims no more than the ladder shows.

With differences d_1 = |x_2 - x_1|, d_2 = |x_3 - x_2| of the last three meshes, whose lengths are in one
ratio g, the observed order is p = log(d_1/d_2)/log g; the limit is x_3 + (x_3 - x_2)/(g^p - 1), and its error
bar is the whole of that correction. Where the differences do not fall there is no order: the last mesh stands
for the limit, and the bar is the last difference.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# An order beyond that of any element here is luck; a low one extrapolates far, so it is not trusted at all.
ORDERS = (1.0, 6.0)
ROUNDING = 1e-9  # of the length: what tolerance and rounding leave


@dataclass(frozen=True)
class LadderLimit:
    """Limit of a ladder, its error bar and the observed order (None where there is none)."""

    value: Floats
    bar: float
    order: float | None


def ladder_limit(meshes: Sequence[int], values: Sequence[Floats]) -> LadderLimit | None:
    """Limit of values (k,) each, by meshes of growing numbers of elements.

    Parameters
    ----------
    meshes : number of elements of each mesh, ascending
    values : the quantity on each mesh, dimensionless; distances are Euclidean

    Returns
    -------
    None for fewer than two meshes: one mesh shows nothing about its error.
    """
    if len(values) < 2:
        return None
    last = [np.asarray(v, float) for v in values[-3:]]
    d_2 = float(np.linalg.norm(last[-1] - last[-2]))
    found = LadderLimit(last[-1], max(d_2, ROUNDING), None)
    if len(last) < 3:
        return found
    ratios = (meshes[-2] / meshes[-3], meshes[-1] / meshes[-2])
    d_1 = float(np.linalg.norm(last[1] - last[0]))
    if d_2 <= ROUNDING:
        return found
    if d_1 <= d_2 or abs(ratios[0] / ratios[1] - 1.0) > 1e-9:
        return found
    order = math.log(d_1 / d_2) / math.log(ratios[1])
    if order < ORDERS[0]:
        return LadderLimit(last[-1], found.bar, order)
    share = 1.0 / (ratios[1] ** min(order, ORDERS[1]) - 1.0)
    correction = share * (last[-1] - last[-2])
    return LadderLimit(last[-1] + correction, max(share * d_2, ROUNDING), order)
