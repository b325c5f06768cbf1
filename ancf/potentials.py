r"""Potentials: energy densities of Green-Lagrange strain, the parts that rubber laws are summed from.

A potential takes the strain as a 6-vector in the order of materials.py, shear doubled, and gives energy,
stress S = dPsi/dE and tangent D = dS/dE in the same order. The stresses are C^-1 times a polynomial without
constant term: no strain gives exactly no stress. All need det F > 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ancf.cauchy_green import IDENTITY, SYMMETRIC_IDENTITY, CauchyGreen, outer, product

Floats = NDArray[np.float64]


class Potential(Protocol):
    """Energy density of Green-Lagrange strain (..., 6) with its first and second derivative."""

    def energy(self, strain: Floats) -> Floats:
        """Psi (...) [J/m3]."""
        ...

    def stress(self, strain: Floats) -> Floats:
        """Second Piola-Kirchhoff stress S = dPsi/dE (..., 6) [Pa]."""
        ...

    def response(self, strain: Floats) -> tuple[Floats, Floats]:
        """Stress (..., 6) and tangent D = dS/dE (..., 6, 6) [Pa]."""
        ...


@dataclass(frozen=True)
class NeoHookeanShape:
    """Psi = mu/2 (I_1 - 3 - 2 ln J): no lateral strain in simple tension, Young's modulus 2 mu."""

    mu: float

    def energy(self, strain: Floats) -> Floats:
        """See `Potential.energy`: mu (t - ln J)."""
        C = CauchyGreen(strain)
        return self.mu * (C.trace - C.log_J)

    def stress(self, strain: Floats) -> Floats:
        """See `Potential.stress`: mu (I - C^-1) = 2 mu C^-1 E."""
        C = CauchyGreen(strain)
        return 2.0 * self.mu * product(C.C_inv, C.E)

    def response(self, strain: Floats) -> tuple[Floats, Floats]:
        """See `Potential.response`."""
        C = CauchyGreen(strain)
        return 2.0 * self.mu * product(C.C_inv, C.E), 2.0 * self.mu * C.twisted


class VolumeEnergy(Protocol):
    """Energy density of the volume ratio, given as excess = J - 1."""

    def derivatives(self, excess: Floats) -> tuple[Floats, Floats, Floats]:
        """U, dU/dJ, d2U/dJ2 (...) [Pa]."""
        ...


@dataclass(frozen=True)
class LogarithmicVolume:
    """U = lambda/2 (ln J)^2."""

    lame_lambda: float

    def derivatives(self, excess: Floats) -> tuple[Floats, Floats, Floats]:
        """See `VolumeEnergy.derivatives`."""
        log_J, J = np.log1p(excess), 1.0 + excess
        slope = self.lame_lambda * log_J / J
        return 0.5 * self.lame_lambda * log_J**2, slope, self.lame_lambda * (1.0 - log_J) / J**2


@dataclass(frozen=True)
class QuadraticVolume:
    """U = K/2 (J - 1)^2."""

    bulk_modulus: float

    def derivatives(self, excess: Floats) -> tuple[Floats, Floats, Floats]:
        """See `VolumeEnergy.derivatives`."""
        K = self.bulk_modulus
        return 0.5 * K * excess**2, K * excess, np.full_like(excess, K)


@dataclass(frozen=True)
class OfVolume:
    """Psi = U(J) as a potential of strain."""

    of: VolumeEnergy

    def energy(self, strain: Floats) -> Floats:
        """See `Potential.energy`."""
        return self.of.derivatives(CauchyGreen(strain).excess)[0]

    def stress(self, strain: Floats) -> Floats:
        """See `Potential.stress`: U' J C^-1."""
        C = CauchyGreen(strain)
        return (self.of.derivatives(C.excess)[1] * C.J)[..., None] * C.C_inv

    def response(self, strain: Floats) -> tuple[Floats, Floats]:
        """See `Potential.response`."""
        C = CauchyGreen(strain)
        _, slope, curve = self.of.derivatives(C.excess)
        S = (slope * C.J)[..., None] * C.C_inv
        return S, (curve * C.J**2)[..., None, None] * C.volume_volume + slope[..., None, None] * C.J_second


@dataclass(frozen=True)
class MooneyRivlinShape:
    """Psi = c10 (J^(-2/3) I_1 - 3) + c01 (J^(-4/3) I_2 - 3), blind to volume."""

    c10: float
    c01: float

    def energy(self, strain: Floats) -> Floats:
        """See `Potential.energy`; I_1 = 3 + 2 t, I_2 = 3 + 4 t + 4 i_2."""
        C = CauchyGreen(strain)
        first = 3.0 * np.expm1(-2.0 / 3.0 * C.log_J) + 2.0 * C.trace * np.exp(-2.0 / 3.0 * C.log_J)
        second = 3.0 * np.expm1(-4.0 / 3.0 * C.log_J)
        second += 4.0 * (C.trace + C.i_2) * np.exp(-4.0 / 3.0 * C.log_J)
        return self.c10 * first + self.c01 * second

    def stress(self, strain: Floats) -> Floats:
        """See `Potential.stress`."""
        return self._stress(CauchyGreen(strain))

    def _stress(self, C: CauchyGreen) -> Floats:
        """2 C^-1 [c10 J^(-2/3) 2 dev E + c01 J^(-4/3) ((2 + 4 t) E - 4 E^2 - (2 t + 8 i_2)/3 I)]."""
        t, i_2, log_J = C.trace[..., None], C.i_2[..., None], C.log_J[..., None]
        first = 2.0 * C.E - 2.0 / 3.0 * t * IDENTITY
        second = (2.0 + 4.0 * t) * C.E - 4.0 * C.E_squared - (2.0 * t + 8.0 * i_2) / 3.0 * IDENTITY
        weighted = self.c10 * np.exp(-2.0 / 3.0 * log_J) * first
        weighted = weighted + self.c01 * np.exp(-4.0 / 3.0 * log_J) * second
        return 2.0 * product(C.C_inv, weighted)

    def response(self, strain: Floats) -> tuple[Floats, Floats]:
        """See `Potential.response`; with G = I_1 I - C = dI_2/dC.

        D = 4/3 c10 J^(-2/3) [I_1 (C^-1 (x) C^-1 / 3 + T) - I (x) C^-1 - C^-1 (x) I]
          + 4 c01 J^(-4/3) [I (x) I - 1 + 2/3 I_2 (2/3 C^-1 (x) C^-1 + T) - 2/3 (G (x) C^-1 + C^-1 (x) G)],
        T = -1/2 dC^-1/dE.
        """
        C = CauchyGreen(strain)
        I_1 = (3.0 + 2.0 * C.trace)[..., None]
        I_2 = (3.0 + 4.0 * (C.trace + C.i_2))[..., None, None]
        G = (I_1 - 1.0) * IDENTITY - 2.0 * C.E
        I_C = outer(np.broadcast_to(IDENTITY, C.C_inv.shape), C.C_inv)
        G_C = outer(G, C.C_inv)
        first = I_1[..., None] * (C.volume_volume / 3.0 + C.twisted) - I_C - np.swapaxes(I_C, -1, -2)
        second = np.outer(IDENTITY, IDENTITY) - SYMMETRIC_IDENTITY
        second = second + 2.0 / 3.0 * I_2 * (2.0 / 3.0 * C.volume_volume + C.twisted)
        second = second - 2.0 / 3.0 * (G_C + np.swapaxes(G_C, -1, -2))
        log_J = C.log_J[..., None, None]
        D = 4.0 / 3.0 * self.c10 * np.exp(-2.0 / 3.0 * log_J) * first
        return self._stress(C), D + 4.0 * self.c01 * np.exp(-4.0 / 3.0 * log_J) * second


@dataclass(frozen=True)
class QuadraticPotential:
    """Psi = E^T D E / 2 with a constant matrix D (6, 6), given by its rows."""

    rows: tuple[tuple[float, ...], ...]

    @cached_property
    def D(self) -> Floats:
        """The matrix (6, 6) [Pa]."""
        return np.array(self.rows)

    def energy(self, strain: Floats) -> Floats:
        """See `Potential.energy`."""
        return 0.5 * np.sum(strain * (strain @ self.D), axis=-1)

    def stress(self, strain: Floats) -> Floats:
        """See `Potential.stress`."""
        return strain @ self.D

    def response(self, strain: Floats) -> tuple[Floats, Floats]:
        """See `Potential.response`."""
        return strain @ self.D, np.broadcast_to(self.D, (*strain.shape, 6))


@dataclass(frozen=True)
class Total:
    """Sum of potentials."""

    parts: tuple[Potential, ...]

    def energy(self, strain: Floats) -> Floats:
        """See `Potential.energy`."""
        return np.sum([part.energy(strain) for part in self.parts], axis=0)

    def stress(self, strain: Floats) -> Floats:
        """See `Potential.stress`."""
        return np.sum([part.stress(strain) for part in self.parts], axis=0)

    def response(self, strain: Floats) -> tuple[Floats, Floats]:
        """See `Potential.response`."""
        responses = [part.response(strain) for part in self.parts]
        return np.sum([S for S, _ in responses], axis=0), np.sum([D for _, D in responses], axis=0)


@dataclass(frozen=True)
class Difference:
    """One potential less another."""

    whole: Potential
    less: Potential

    def energy(self, strain: Floats) -> Floats:
        """See `Potential.energy`."""
        return self.whole.energy(strain) - self.less.energy(strain)

    def stress(self, strain: Floats) -> Floats:
        """See `Potential.stress`."""
        return self.whole.stress(strain) - self.less.stress(strain)

    def response(self, strain: Floats) -> tuple[Floats, Floats]:
        """See `Potential.response`."""
        S, D = self.whole.response(strain)
        S_less, D_less = self.less.response(strain)
        return S - S_less, D - D_less
