"""Hyperelastic laws of the solid reference, written in the deformation gradient.

Symbols: `F` deformation gradient (..., 3, 3) [-], `Psi` energy density [J/m^3], `P_pk1` = dPsi/dF [Pa],
`A_pk1` = dP/dF (..., 3, 3, 3, 3) [Pa] with index order iJkL, `G` = F^-T, `X` = -dG/dF. Written in F on
purpose: the beam code uses the Green-Lagrange strain, so an error in one is not repeated in the other.

Every law is a sum Psi(F) = Psi_shape(F) + U(g(F)) of a part that stays bounded as nu -> 1/2 and an energy of
one scalar measure g of the change of volume; a mixed form interpolates g (solid_forms.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from reference.solid_tensors import (
    IDENTITY,
    IDENTITY_4,
    green_lagrange,
    invariants,
    inverse_transpose,
    jacobian,
    outer,
    second_invariant_slope,
)

Array = NDArray[np.float64]


class ShapeLaw(Protocol):
    """Energy, stress and tangent of a law or of a part of one."""

    def energy(self, F: Array) -> Array:
        """Energy density (...) [J/m^3]."""
        ...

    def stress(self, F: Array) -> Array:
        """First Piola-Kirchhoff stress (..., 3, 3) [Pa]."""
        ...

    def tangent(self, F: Array) -> Array:
        """Tangent dP_iJ/dF_kL (..., 3, 3, 3, 3) [Pa]."""
        ...


class SolidMaterial(Protocol):
    """What the solver asks of a law; arrays carry any leading batch axes."""

    @property
    def young_modulus(self) -> float:
        """Young's modulus at small strain [Pa], the unit of stress of the convergence test."""
        ...

    @property
    def poisson_ratio(self) -> float:
        """Poisson ratio at small strain [-]."""
        ...

    @property
    def lame_mu(self) -> float:
        """Shear modulus at small strain [Pa]."""
        ...

    @property
    def lame_lambda(self) -> float:
        """First Lame parameter at small strain [Pa]."""
        ...

    @property
    def shape(self) -> ShapeLaw:
        """The part Psi_shape of the law without the energy of the volume."""
        ...

    def volume_measure(self, F: Array) -> tuple[Array, Array, Array]:
        """Measure g (...) of the volume, dg/dF (..., 3, 3) and d2g/dF2 (..., 3, 3, 3, 3) [-]."""
        ...

    def volume_energy(self, theta: Array) -> tuple[Array, Array, Array]:
        """U, U', U'' (...) [Pa] at values theta of the measure."""
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

    @property
    def shape(self) -> SaintVenantKirchhoff:
        """mu E:E: the law with lambda = 0 and the same mu."""
        return SaintVenantKirchhoff(2 * self.lame_mu, 0.0)

    def volume_measure(self, F: Array) -> tuple[Array, Array, Array]:
        """g = tr E, dg/dF = F, d2g/dF2 = I (x) I."""
        trace = np.trace(green_lagrange(F), axis1=-2, axis2=-1)
        return trace, F, np.broadcast_to(IDENTITY_4, (*F.shape, 3, 3))

    def volume_energy(self, theta: Array) -> tuple[Array, Array, Array]:
        """U = lambda/2 theta^2."""
        k = self.lame_lambda
        return k / 2 * theta**2, k * theta, np.full_like(theta, k)

    def energy(self, F: Array) -> Array:
        """Energy density, Psi = lambda/2 (tr E)^2 + mu E:E (...) [J/m^3]."""
        E_gl = green_lagrange(F)
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
        E_gl = green_lagrange(F)
        trace = np.trace(E_gl, axis1=-2, axis2=-1)
        return self.lame_lambda * trace[..., None, None] * IDENTITY + 2 * self.lame_mu * E_gl


@dataclass(frozen=True)
class NeoHookean:
    """Compressible neo-Hookean law, Psi = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2.

    Parameters
    ----------
    young_modulus : float
        [Pa], positive.
    poisson_ratio : float
        [-], -1 < nu < 0.5.

    Notes
    -----
    Bonet, Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed. (2008), eq. 6.28. The
    energy of the volume has its inflexion at J = e: not for large dilatation.
    """

    young_modulus: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        SaintVenantKirchhoff(self.young_modulus, self.poisson_ratio)  # the same two constants and limits

    @property
    def lame_lambda(self) -> float:
        """First Lame parameter [Pa]."""
        return SaintVenantKirchhoff(self.young_modulus, self.poisson_ratio).lame_lambda

    @property
    def lame_mu(self) -> float:
        """Shear modulus [Pa]."""
        return self.young_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def shape(self) -> NeoHookean:
        """mu/2 (I1 - 3 - 2 ln J): the law with lambda = 0 and the same mu."""
        return NeoHookean(2 * self.lame_mu, 0.0)

    def volume_measure(self, F: Array) -> tuple[Array, Array, Array]:
        """g = J with its derivatives."""
        return jacobian(F)

    def volume_energy(self, theta: Array) -> tuple[Array, Array, Array]:
        """U = lambda/2 (ln theta)^2."""
        k, log = self.lame_lambda, np.log(theta)
        return k / 2 * log**2, k * log / theta, k * (1 - log) / theta**2

    def energy(self, F: Array) -> Array:
        """Energy density, Psi = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2 (...) [J/m^3]."""
        log = np.log(np.linalg.det(F))
        trace = np.trace(green_lagrange(F), axis1=-2, axis2=-1)  # (I1 - 3)/2 without cancellation
        return self.lame_mu * (trace - log) + self.lame_lambda / 2 * log**2

    def stress(self, F: Array) -> Array:
        """First Piola-Kirchhoff stress, P = mu (F - G) + lambda ln J G (..., 3, 3) [Pa]."""
        G = inverse_transpose(F)
        log = np.log(np.linalg.det(F))[..., None, None]
        return self.lame_mu * (F - G) + self.lame_lambda * log * G

    def tangent(self, F: Array) -> Array:
        """Tangent A = mu I (x) I + (mu - lambda ln J) X + lambda G (x) G [Pa]."""
        G = inverse_transpose(F)
        k = self.lame_mu - self.lame_lambda * np.log(np.linalg.det(F))
        A_pk1 = np.einsum("...,...iL,...kJ->...iJkL", k, G, G) + outer(self.lame_lambda * G, G)
        return A_pk1 + self.lame_mu * IDENTITY_4


@dataclass(frozen=True)
class Isochoric:
    """Mooney-Rivlin energy of the isochoric strain, Psi = c10 (J^-2/3 I1 - 3) + c01 (J^-4/3 I2 - 3)."""

    c10: float
    c01: float

    def energy(self, F: Array) -> Array:
        """Energy density (...) [J/m^3]."""
        J, I1, I2 = invariants(F)
        return self.c10 * (J ** (-2 / 3) * I1 - 3) + self.c01 * (J ** (-4 / 3) * I2 - 3)

    def stress(self, F: Array) -> Array:
        """P = c10 J^-2/3 (2 F - 2/3 I1 G) + c01 J^-4/3 (dI2/dF - 4/3 I2 G) (..., 3, 3) [Pa]."""
        J, I1, I2 = (s[..., None, None] for s in invariants(F))
        G = inverse_transpose(F)
        first = J ** (-2 / 3) * (2 * F - 2 / 3 * I1 * G)
        second = J ** (-4 / 3) * (second_invariant_slope(F) - 4 / 3 * I2 * G)
        return self.c10 * first + self.c01 * second

    def tangent(self, F: Array) -> Array:
        """Tangent (..., 3, 3, 3, 3) [Pa], the derivative of `stress`.

        c10 J^-2/3 [2 I (x) I - 4/3 (G (x) F + F (x) G) + I1 (2/3 X + 4/9 G (x) G)]
        + c01 J^-4/3 [d2I2/dF2 - 4/3 (G (x) I2' + I2' (x) G) + I2 (4/3 X + 16/9 G (x) G)], I2' = dI2/dF.
        """
        J, I1, I2 = (s[..., None, None, None, None] for s in invariants(F))
        G = inverse_transpose(F)
        X, GG = np.einsum("...iL,...kJ->...iJkL", G, G), outer(G, G)
        slope, C, b = second_invariant_slope(F), F.swapaxes(-1, -2) @ F, F @ F.swapaxes(-1, -2)
        first = 2 * IDENTITY_4 - 4 / 3 * (outer(G, F) + outer(F, G)) + I1 * (2 / 3 * X + 4 / 9 * GG)
        second = 4 * outer(F, F) + 2 * I1 * IDENTITY_4 - 2 * np.einsum("...iL,...kJ->...iJkL", F, F)
        second -= 2 * np.einsum("ik,...JL->...iJkL", IDENTITY, C)
        second -= 2 * np.einsum("...ik,JL->...iJkL", b, IDENTITY)
        second += -4 / 3 * (outer(G, slope) + outer(slope, G)) + I2 * (4 / 3 * X + 16 / 9 * GG)
        return self.c10 * J ** (-2 / 3) * first + self.c01 * J ** (-4 / 3) * second


@dataclass(frozen=True)
class MooneyRivlin:
    """Mooney-Rivlin law, Psi = c10 (J^-2/3 I1 - 3) + c01 (J^-4/3 I2 - 3) + K/2 (J - 1)^2.

    Parameters
    ----------
    c10, c01 : float
        [Pa], with a positive sum: mu = 2 (c10 + c01).
    bulk_modulus : float
        K [Pa], positive.

    Notes
    -----
    Holzapfel, Nonlinear Solid Mechanics (2000), eq. 6.146 with the isochoric split. The isochoric part of
    c01 makes the law non-convex at extreme dilatation; meant for K much larger than mu.
    """

    c10: float
    c01: float
    bulk_modulus: float

    def __post_init__(self) -> None:
        if not self.c10 + self.c01 > 0:
            raise ValueError(f"c10 + c01 is {self.c10 + self.c01} Pa; it must be positive.")
        if not self.bulk_modulus > 0:
            raise ValueError(f"bulk_modulus is {self.bulk_modulus} Pa; it must be positive.")

    @property
    def lame_mu(self) -> float:
        """Shear modulus, mu = 2 (c10 + c01) [Pa]."""
        return 2 * (self.c10 + self.c01)

    @property
    def lame_lambda(self) -> float:
        """First Lame parameter, K - 2 mu/3 [Pa]."""
        return self.bulk_modulus - 2 / 3 * self.lame_mu

    @property
    def young_modulus(self) -> float:
        """Young's modulus at small strain, 9 K mu/(3 K + mu) [Pa]."""
        return 9 * self.bulk_modulus * self.lame_mu / (3 * self.bulk_modulus + self.lame_mu)

    @property
    def poisson_ratio(self) -> float:
        """Poisson ratio at small strain, (3 K - 2 mu)/(2 (3 K + mu)) [-]."""
        return (3 * self.bulk_modulus - 2 * self.lame_mu) / (2 * (3 * self.bulk_modulus + self.lame_mu))

    @property
    def shape(self) -> Isochoric:
        """The two isochoric terms."""
        return Isochoric(self.c10, self.c01)

    def volume_measure(self, F: Array) -> tuple[Array, Array, Array]:
        """g = J with its derivatives."""
        return jacobian(F)

    def volume_energy(self, theta: Array) -> tuple[Array, Array, Array]:
        """U = K/2 (theta - 1)^2."""
        k = self.bulk_modulus
        return k / 2 * (theta - 1) ** 2, k * (theta - 1), np.full_like(theta, k)

    def energy(self, F: Array) -> Array:
        """Energy density (...) [J/m^3]."""
        return self.shape.energy(F) + self.volume_energy(np.linalg.det(F))[0]

    def stress(self, F: Array) -> Array:
        """First Piola-Kirchhoff stress, P = P_shape + K (J - 1) J G (..., 3, 3) [Pa]."""
        J, J_F, _ = jacobian(F)
        return self.shape.stress(F) + self.volume_energy(J)[1][..., None, None] * J_F

    def tangent(self, F: Array) -> Array:
        """Tangent A = A_shape + K J_F (x) J_F + K (J - 1) J_FF (..., 3, 3, 3, 3) [Pa]."""
        J, J_F, J_FF = jacobian(F)
        slope = self.volume_energy(J)[1][..., None, None, None, None]
        return self.shape.tangent(F) + self.bulk_modulus * outer(J_F, J_F) + slope * J_FF
