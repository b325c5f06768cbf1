r"""Coulomb friction of many points along a path of load steps: return mapping with multipliers.

In a step the touching point of a body slips by the tangential part of u, its way since the last accepted
equilibrium. With the normal n, P = I - n n^T, the normal force p, a multiplier l [N] and the stiffness k,

    v = l - k u,   w = P v,   T = w where |w| <= mu p (it sticks), else mu p t, t = w/|w| (it slips).

Between Newton runs l <- T. Where that stands still, a point that sticks has P u = 0, one that slips has
|T| = mu p against its slip: the implicit Euler step of Coulomb's law (Simo and Laursen, Computers and
Structures 42 (1992) 97; Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353). So the stiffness
decides how fast, not what is found, and -T . u >= 0 is what a step dissipates. Its derivative,

    dw = -k P du - ((n . v) I + n v^T) dn,   dT = dw, or (mu p/|w|) (I - t t^T) dw + mu t dp:

no potential, and no symmetry where points slip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


ON_LIMIT = 1.0 - 1e-9  # rounding of |T| = mu p


@dataclass(frozen=True, eq=False)
class Traction:
    """Tangential forces T (..., 3) [N] of points, and what their derivative needs."""

    T: Floats
    v: Floats
    size: Floats  # |w| (...)
    limit: Floats  # mu p (...)

    def taken(self, which: NDArray[np.intp]) -> Traction:
        """Some of the points."""
        return Traction(self.T[which], self.v[which], self.size[which], self.limit[which])

    @property
    def slips(self) -> Flags:
        """Points (...) at their limit, also those that begin a step there; what carries nothing slips."""
        return ~(self.size < ON_LIMIT * self.limit)


def traction(limit: Floats, k: Floats, n: Floats, u: Floats, multiplier: Floats) -> Traction:
    """Return mapping of points from limit mu p, k (...), n, u and multiplier (..., 3)."""
    v = multiplier - k[..., None] * u
    w = v - np.sum(n * v, axis=-1, keepdims=True) * n
    size = np.linalg.norm(w, axis=-1)
    share = np.where(size < limit, 1.0, limit / np.maximum(size, 1e-300))
    return Traction(share[..., None] * w, v, size, limit)


def derivative(found: Traction, mu: float, k: Floats, n: Floats) -> tuple[Floats, Floats, Floats]:
    """dT by the way u (..., 3, 3) [N/m], the normal n (..., 3, 3) [N] and the normal force p (..., 3)."""
    one = np.eye(3)
    slips = found.slips[..., None]
    t = found.T / np.maximum(found.limit, 1e-300)[..., None]
    along = t[..., :, None] * t[..., None, :]
    share = (found.limit / np.maximum(found.size, 1e-300))[..., None, None]
    M = np.where(slips[..., None], share * (one - along), one)
    P = one - n[..., :, None] * n[..., None, :]
    by_u = -k[..., None, None] * (M @ P)
    across = np.sum(n * found.v, axis=-1)[..., None, None] * one + n[..., :, None] * found.v[..., None, :]
    return by_u, -M @ across, np.where(slips, mu * t, 0.0)
