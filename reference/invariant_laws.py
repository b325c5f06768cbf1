"""The three laws a second time, in the invariants of C: the truth that checks `solid_materials`.

Symbols: `F` deformation gradient, `I1` = tr C, `I2` = (I1^2 - tr C^2)/2, `J` = det F, `W1` = dPsi/dI1 and so
on, `P_pk1` first Piola-Kirchhoff stress. Everything is a power or a logarithm of polynomials in F and holds
for complex F: the imaginary part at F + i h dF is h times the derivative to rounding (Squire, Trapp 1998).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Field = NDArray[Any]  # real or complex
Array = NDArray[np.float64]

COMPLEX_STEP = 1e-30  # no difference is taken, so it may be as small as numbers go


@dataclass(frozen=True)
class InvariantLaw:
    """A law as functions of (I1, I2, J), split into shape and volume as in the mixed form.

    `shape(I1, I2, J)` and `volume(g)` are energies [J/m^3]; `measure(I1, J)` is g [-];
    `slopes(I1, I2, J)` are the three derivatives of the whole energy [Pa].
    """

    shape: Callable[[Field, Field, Field], Field]
    measure: Callable[[Field, Field], Field]
    volume: Callable[[Field], Field]
    slopes: Callable[[Field, Field, Field], tuple[Field | float, Field | float, Field | float]]

    def energy(self, F: Field) -> Field:
        """Energy density, Psi = shape + volume(g) (...) [J/m^3]."""
        I1, I2, J = invariants(F)
        return self.shape(I1, I2, J) + self.volume(self.measure(I1, J))

    def stress(self, F: Field) -> Field:
        """First Piola-Kirchhoff stress, P = 2 W1 F + 2 W2 (I1 F - F F^T F) + WJ cof F (..., 3, 3) [Pa]."""
        I1, I2, J = invariants(F)
        W1, W2, WJ = (np.asarray(w)[..., None, None] for w in self.slopes(I1, I2, J))
        b = F @ F.swapaxes(-1, -2)
        return 2 * W1 * F + 2 * W2 * (I1[..., None, None] * F - b @ F) + WJ * cofactor(F)

    def tangent(self, F: Array) -> Array:
        """Tangent A_iJkL = dP_iJ/dF_kL (..., 3, 3, 3, 3) [Pa] by complex steps, exact to rounding."""
        A_pk1 = np.empty((*F.shape, 3, 3))
        for k in range(3):
            for L in range(3):
                step = np.zeros((3, 3), complex)
                step[k, L] = 1j * COMPLEX_STEP
                A_pk1[..., k, L] = np.imag(self.stress(F + step)) / COMPLEX_STEP
        return A_pk1


def saint_venant_kirchhoff(young_modulus: float, poisson_ratio: float) -> InvariantLaw:
    """Psi = lambda/8 (I1 - 3)^2 + mu/4 (I1^2 - 2 I2 - 2 I1 + 3), from E = (C - I)/2."""
    lam, mu = _lame(young_modulus, poisson_ratio)
    return InvariantLaw(
        shape=lambda I1, I2, J: mu / 4 * (I1**2 - 2 * I2 - 2 * I1 + 3),
        measure=lambda I1, J: (I1 - 3) / 2,
        volume=lambda g: lam / 2 * g**2,
        slopes=lambda I1, I2, J: (lam / 4 * (I1 - 3) + mu / 2 * (I1 - 1), -mu / 2, 0.0),
    )


def neo_hookean(young_modulus: float, poisson_ratio: float) -> InvariantLaw:
    """Psi = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2."""
    lam, mu = _lame(young_modulus, poisson_ratio)
    return InvariantLaw(
        shape=lambda I1, I2, J: mu / 2 * (I1 - 3) - mu * np.log(J),
        measure=lambda I1, J: J,
        volume=lambda g: lam / 2 * np.log(g) ** 2,
        slopes=lambda I1, I2, J: (mu / 2, 0.0, (lam * np.log(J) - mu) / J),
    )


def mooney_rivlin(c10: float, c01: float, bulk_modulus: float) -> InvariantLaw:
    """Psi = c10 (J^(-2/3) I1 - 3) + c01 (J^(-4/3) I2 - 3) + K/2 (J - 1)^2."""
    return InvariantLaw(
        shape=lambda I1, I2, J: c10 * (I1 * J ** (-2 / 3) - 3) + c01 * (I2 * J ** (-4 / 3) - 3),
        measure=lambda I1, J: J,
        volume=lambda g: bulk_modulus / 2 * (g - 1) ** 2,
        slopes=lambda I1, I2, J: (
            c10 * J ** (-2 / 3),
            c01 * J ** (-4 / 3),
            -2 / 3 * c10 * I1 * J ** (-5 / 3) - 4 / 3 * c01 * I2 * J ** (-7 / 3) + bulk_modulus * (J - 1),
        ),
    )


def invariants(F: Field) -> tuple[Field, Field, Field]:
    """I1 = F:F, I2 = cof F:cof F, J = F_0 . (F_1 x F_2) of the columns; each (...)."""
    I1 = np.sum(F * F, axis=(-2, -1))
    cof = cofactor(F)
    return I1, np.sum(cof * cof, axis=(-2, -1)), np.sum(F[..., 0] * cof[..., 0], axis=-1)


def cofactor(F: Field) -> Field:
    """Cofactor dJ/dF by the cross products of the columns (..., 3, 3)."""
    a, b, c = F[..., 0], F[..., 1], F[..., 2]
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)


def _lame(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """First Lame parameter and shear modulus [Pa]."""
    mu = young_modulus / 2 / (1 + poisson_ratio)
    return 2 * mu * poisson_ratio / (1 - 2 * poisson_ratio), mu
