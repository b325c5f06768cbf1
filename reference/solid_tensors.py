"""Tensor functions of the deformation gradient that the laws share.

Symbols: `F` (..., 3, 3) [-], `J` = det F, `C` = F^T F, `G` = F^-T, `X`_iJkL = G_iL G_kJ = -dG_iJ/dF_kL.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

IDENTITY = np.eye(3)
IDENTITY_4 = np.einsum("ik,JL->iJkL", IDENTITY, IDENTITY)


def inverse_transpose(F: Array) -> Array:
    """G = F^-T (..., 3, 3)."""
    return np.asarray(np.linalg.inv(F).swapaxes(-1, -2), dtype=np.float64)


def jacobian(F: Array) -> tuple[Array, Array, Array]:
    """J = det F, dJ/dF = J G, d2J/dF2 = J (G (x) G - X)."""
    J = np.linalg.det(F)
    G = inverse_transpose(F)
    J_FF = J[..., None, None, None, None] * (outer(G, G) - np.einsum("...iL,...kJ->...iJkL", G, G))
    return J, J[..., None, None] * G, J_FF


def invariants(F: Array) -> tuple[Array, Array, Array]:
    """J and the invariants I1 = tr C, I2 = (I1^2 - tr C^2)/2 (...)."""
    C = F.swapaxes(-1, -2) @ F
    I1 = np.trace(C, axis1=-2, axis2=-1)
    return np.linalg.det(F), I1, (I1**2 - np.sum(C**2, axis=(-2, -1))) / 2


def second_invariant_slope(F: Array) -> Array:
    """dI2/dF = 2 (I1 F - F C) (..., 3, 3)."""
    C = F.swapaxes(-1, -2) @ F
    return 2 * (np.trace(C, axis1=-2, axis2=-1)[..., None, None] * F - F @ C)


def outer(A: Array, B: Array) -> Array:
    """A_iJ B_kL (..., 3, 3, 3, 3)."""
    return A[..., :, :, None, None] * B[..., None, None, :, :]


def green_lagrange(F: Array) -> Array:
    """Green-Lagrange strain, E = (H + H^T + H^T H)/2 with H = F - I (..., 3, 3) [-]."""
    H = F - IDENTITY
    return (H + H.swapaxes(-1, -2) + H.swapaxes(-1, -2) @ H) / 2
