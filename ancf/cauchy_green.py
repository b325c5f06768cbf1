r"""Invariants and inverse of the right Cauchy-Green tensor C = I + 2 E, without cancellation at small strain.

Symmetric tensors are 6-vectors in the order of materials.py. J^2 - 1 is a polynomial in E and ln J =
log1p(J^2 - 1)/2, so that slender rods keep their digits.

Symbols
-------
C_inv   inverse of C, tensor components
t, i_2  tr E and the second invariant of E
x       J^2 - 1 = det C - 1
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.materials import VOIGT

Floats = NDArray[np.float64]

_A, _B = np.array(VOIGT).T
# Voigt place of the tensor components (a, b).
_PLACE = np.zeros((3, 3), dtype=np.intp)
_PLACE[_A, _B] = _PLACE[_B, _A] = np.arange(6)
IDENTITY = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
_SHEAR = np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])  # doubled shears to tensor components
# Identity on symmetric tensors, from strains with doubled shears to stresses.
SYMMETRIC_IDENTITY = np.diag(_SHEAR)


class CauchyGreen:
    """Invariants and inverse of C = I + 2 E for strains (..., 6), without cancellation at small strain."""

    def __init__(self, strain: Floats) -> None:
        E = self.E = strain * _SHEAR
        xx, yy, zz, yz, xz, xy = np.moveaxis(E, -1, 0)
        minors = np.stack([yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy], axis=-1)
        self.trace = xx + yy + zz
        self.i_2 = minors.sum(axis=-1)
        determinant = xx * minors[..., 0] + xy * (xz * yz - xy * zz) + xz * (xy * yz - xz * yy)
        self.x = 2.0 * self.trace + 4.0 * self.i_2 + 8.0 * determinant

    @cached_property
    def log_J(self) -> Floats:
        """Logarithm of J = det F (...)."""
        return 0.5 * np.log1p(self.x)

    @cached_property
    def J(self) -> Floats:
        """Volume ratio det F (...)."""
        return np.sqrt(1.0 + self.x)

    @cached_property
    def excess(self) -> Floats:
        """J - 1 (...)."""
        return self.x / (self.J + 1.0)

    @cached_property
    def C_inv(self) -> Floats:
        """Inverse of C (..., 6): adjugate over J^2."""
        xx, yy, zz, yz, xz, xy = np.moveaxis(2.0 * self.E + IDENTITY, -1, 0)
        adjugate = np.stack(
            [
                yy * zz - yz * yz,
                xx * zz - xz * xz,
                xx * yy - xy * xy,
                xy * xz - xx * yz,
                xy * yz - yy * xz,
                xz * yz - zz * xy,
            ],
            axis=-1,
        )
        return adjugate / (1.0 + self.x)[..., None]

    @cached_property
    def E_squared(self) -> Floats:
        """E^2 (..., 6), tensor components."""
        return product(self.E, self.E)

    @cached_property
    def volume_volume(self) -> Floats:
        """C^-1 (x) C^-1 (..., 6, 6)."""
        return outer(self.C_inv, self.C_inv)

    @cached_property
    def J_second(self) -> Floats:
        """d2J/dE2 (..., 6, 6); dJ/dE = J C^-1."""
        return self.J[..., None, None] * (self.volume_volume - 2.0 * self.twisted)

    @cached_property
    def twisted(self) -> Floats:
        """-1/2 dC^-1/dE: (C^-1_ac C^-1_bd + C^-1_ad C^-1_bc)/2 (..., 6, 6)."""
        C_inv = self.C_inv[..., _PLACE]  # (..., 3, 3)
        a, b = _A[:, None], _B[:, None]
        return 0.5 * (C_inv[..., a, _A] * C_inv[..., b, _B] + C_inv[..., a, _B] * C_inv[..., b, _A])


def outer(a: Floats, b: Floats) -> Floats:
    """Dyadic product (..., 6, 6) of 6-vectors."""
    return a[..., :, None] * b[..., None, :]


def product(a: Floats, b: Floats) -> Floats:
    """Product a b (..., 6) of commuting symmetric tensors, given and returned as tensor components."""
    return (a[..., _PLACE] @ b[..., _PLACE])[..., _A, _B]
