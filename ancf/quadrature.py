"""Quadrature rules on an interval, exact to a stated polynomial degree."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray


@lru_cache(maxsize=64)
def gauss(points: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Gauss-Legendre rule on [-1, 1], exact to degree ``2 points - 1``.

    Returns abscissae (points,) [-] and weights (points,) [-]; the weights sum to 2.
    """
    xi, weight = np.polynomial.legendre.leggauss(points)
    xi.setflags(write=False)
    weight.setflags(write=False)
    return xi, weight


def points_for_degree(degree: int) -> int:
    """Smallest number of Gauss points that integrates polynomials of this degree exactly."""
    return degree // 2 + 1
