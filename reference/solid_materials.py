"""Hyperelastic laws of the solid reference, written in the deformation gradient.

Symbols: `F` deformation gradient (..., 3, 3) [-], `Psi` energy density [J/m^3], `P_pk1` = dPsi/dF [Pa],
`A_pk1` = dP/dF (..., 3, 3, 3, 3) [Pa] with index order iJkL. Written in F on purpose: the beam code uses the
Green-Lagrange strain, so an error in one is not repeated in the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

IDENTITY = np.eye(3)


class SolidMaterial(Protocol):
    """What the solver asks of a law; arrays carry any leading batch axes."""

    @property
    def young_modulus(self) -> float:
        """Young's modulus at small strain [Pa], the unit of stress of the convergence test."""
        ...

    def energy(self, F: Array) -> Array:
        """Energy density Psi (...) [J/m^3]."""
        ...

    def stress(self, F: Array) -> Array:
        """First Piola-Kirchhoff stress P_iJ = dPsi/dF_iJ (..., 3, 3) [Pa]."""
        ...

    def tangent(self, F: Array) -> Array:
        """Tangent A_iJkL = dP_iJ/dF_kL (..., 3, 3, 3, 3) [Pa]."""
        ...


@dataclass(frozen=True)
class SaintVenantKirchhoff:
    """Saint Venant-Kirchhoff law, Psi = lambda/2 (tr E)^2 + mu E:E with E = (F^T F - I)/2.

    Parameters
    ----------
    young_modulus : float
        [Pa], positive.
    poisson_ratio : float
        [-], -1 < nu < 0.5.

    Notes
    -----
    Softens in compression and loses ellipticity at a stretch of about 1/sqrt(3): for small strain only.
    """

    young_modulus: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        if not self.young_modulus > 0:
            raise ValueError(f"young_modulus is {self.young_modulus} Pa; it must be positive.")
        if not -1 < self.poisson_ratio < 0.5:
            raise ValueError(f"poisson_ratio is {self.poisson_ratio}; it must lie between -1 and 0.5.")

    @property
    def lame_lambda(self) -> float:
        """First Lame parameter [Pa]."""
        nu = self.poisson_ratio
        return self.young_modulus * nu / ((1 + nu) * (1 - 2 * nu))

    @property
    def lame_mu(self) -> float:
        """Shear modulus [Pa]."""
        return self.young_modulus / (2 * (1 + self.poisson_ratio))

    def energy(self, F: Array) -> Array:
        """Energy density, Psi = lambda/2 (tr E)^2 + mu E:E (...) [J/m^3]."""
        E_gl = _green_lagrange(F)
        trace = np.trace(E_gl, axis1=-2, axis2=-1)
        return self.lame_lambda / 2 * trace**2 + self.lame_mu * np.sum(E_gl**2, axis=(-2, -1))

    def stress(self, F: Array) -> Array:
        """First Piola-Kirchhoff stress, P = F (lambda tr(E) I + 2 mu E) (..., 3, 3) [Pa]."""
        return F @ self._stress_pk2(F)

    def tangent(self, F: Array) -> Array:
        """Tangent A_iJkL = d_ik S_JL + lambda F_iJ F_kL + mu (F_iL F_kJ + (F F^T)_ik d_JL) [Pa].

        Shape (..., 3, 3, 3, 3), major symmetric.
        """
        mu = self.lame_mu
        A_pk1 = np.einsum("...iL,...kJ->...iJkL", mu * F, F)
        A_pk1 += self.lame_lambda * F[..., :, :, None, None] * F[..., None, None, :, :]
        S_pk2, b_mu = self._stress_pk2(F), mu * F @ F.swapaxes(-1, -2)
        for i in range(3):  # the Kronecker deltas; three slices are faster than a product with eye(3)
            A_pk1[..., i, :, i, :] += S_pk2
            A_pk1[..., :, i, :, i] += b_mu
        return A_pk1

    def _stress_pk2(self, F: Array) -> Array:
        """Second Piola-Kirchhoff stress, S = lambda tr(E) I + 2 mu E (..., 3, 3) [Pa]."""
        E_gl = _green_lagrange(F)
        trace = np.trace(E_gl, axis1=-2, axis2=-1)
        return self.lame_lambda * trace[..., None, None] * IDENTITY + 2 * self.lame_mu * E_gl


def _green_lagrange(F: Array) -> Array:
    """Green-Lagrange strain, E = (H + H^T + H^T H)/2 with H = F - I (..., 3, 3) [-]."""
    H = F - IDENTITY
    return (H + H.swapaxes(-1, -2) + H.swapaxes(-1, -2) @ H) / 2
