r"""Terms of a section's energy per length, as functions of the strain products gamma of the section.

At section point n the Green-Lagrange strain is E_n = B_n gamma, hence

    U = sum_n w_n Psi(B_n gamma),   T = dU/dgamma = sum_n w_n B_n^T S_n,   H = sum_n w_n B_n^T D_n B_n.

Strain comes from differences of products, never from F^T F - I, so unstressed sections are exactly so.
Arrays: gamma and T (m, pairs), H (m, pairs, pairs), of m alike sections.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.cauchy_green import CauchyGreen
from ancf.potentials import Potential, VolumeEnergy

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Term:
    """A potential on one rule of section points.

    Parameters
    ----------
    potential : energy density of the strain
    weights_local : (n, vectors, 3) with F = sum_i v_i weights_local_i^T in section axes
    B : (n, 6, pairs) strain from gamma
    weight : (n,) [m2], det J_0 included
    """

    potential: Potential
    weights_local: Floats
    B: Floats
    weight: Floats

    @cached_property
    def _rows(self) -> Floats:
        """B as one matrix (6 n, pairs)."""
        return np.ascontiguousarray(self.B.reshape(-1, self.B.shape[-1]))

    def strain(self, gamma: Floats) -> Floats:
        """Strain (m, n, 6) of products (m, pairs)."""
        return (gamma @ self._rows.T).reshape(len(gamma), -1, 6)

    def energy(self, gamma: Floats) -> Floats:
        """Energy per length (m,) [J/m]."""
        return self.potential.energy(self.strain(gamma)) @ self.weight

    def resultants(self, gamma: Floats) -> Floats:
        """T per length (m, pairs)."""
        return self._to_products(self.potential.stress(self.strain(gamma)))

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """T (m, pairs) and H (m, pairs, pairs) per length."""
        S, D = self.potential.response(self.strain(gamma))
        D_B = (self.weight[:, None, None] * D) @ self.B
        H = self._rows.T @ D_B.reshape(len(gamma), -1, D_B.shape[-1])
        return self._to_products(S), H

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """T (m, pairs) of the linear law at gamma_previous."""
        S, D = self.potential.response(self.strain(gamma_previous))
        step = self.strain(gamma - gamma_previous)
        return self._to_products(S + (D @ step[..., None])[..., 0])

    def _to_products(self, S: Floats) -> Floats:
        return (self.weight[:, None] * S).reshape(len(S), -1) @ self._rows


@dataclass(frozen=True)
class ProjectedTerm:
    r"""A law whose volume energy sees the volume ratio J only through its affine part over the section.

        U = int Psi_shape(E) dA + int U(theta) dA,   theta = Pi J,   Pi: L2 projection on {1, y, z}.

    With the pressure p = Pi U'(theta), also affine, and c_i = int phi_i J dA for orthonormal phi_i,

        dU = int (S_shape + p dJ/dE) : dE dA,
        d2U = int dE : (D_shape + p d2J/dE2) : dE dA + sum_ij dc_i (int U'' phi_i phi_j dA) dc_j.

    A quadratic section can give J any affine distribution and nothing more, so this is all that may be
    asked of it; more locks (points on a ring do so by an amount that depends on the direction of bending).

    Parameters
    ----------
    affine : (n, 3) the functions phi_i at the points; the others as in `Term`
    """

    shape: Potential
    volume: VolumeEnergy
    weights_local: Floats
    B: Floats
    weight: Floats
    affine: Floats

    @cached_property
    def _rows(self) -> Floats:
        return np.ascontiguousarray(self.B.reshape(-1, self.B.shape[-1]))

    def _strain(self, gamma: Floats) -> Floats:
        return (gamma @ self._rows.T).reshape(len(gamma), -1, 6)

    def _projected(self, values: Floats) -> Floats:
        """Pi of values (m, n) at the points."""
        return ((self.weight * values) @ self.affine) @ self.affine.T

    def energy(self, gamma: Floats) -> Floats:
        """Energy per length (m,) [J/m]."""
        strain = self._strain(gamma)
        theta = self._projected(CauchyGreen(strain).excess)
        return (self.shape.energy(strain) + self.volume.derivatives(theta)[0]) @ self.weight

    def resultants(self, gamma: Floats) -> Floats:
        """T per length (m, pairs)."""
        strain = self._strain(gamma)
        C = CauchyGreen(strain)
        pressure = self._projected(self.volume.derivatives(self._projected(C.excess))[1])
        return self._to_products(self.shape.stress(strain) + (pressure * C.J)[..., None] * C.C_inv)

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """T (m, pairs) and H (m, pairs, pairs) per length."""
        S, D, dc, stiffness = self._parts(gamma)
        D_B = (self.weight[:, None, None] * D) @ self.B
        H = self._rows.T @ D_B.reshape(len(gamma), -1, D_B.shape[-1])
        return self._to_products(S), H + np.swapaxes(dc, -1, -2) @ stiffness @ dc

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """T (m, pairs) of the linear law at gamma_previous."""
        S, D, dc, stiffness = self._parts(gamma_previous)
        dgamma = gamma - gamma_previous
        T = self._to_products(S + (D @ self._strain(dgamma)[..., None])[..., 0])
        return T + (np.swapaxes(dc, -1, -2) @ (stiffness @ (dc @ dgamma[..., None])))[..., 0]

    def _parts(self, gamma: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """S, D at the points, dc/dgamma (m, 3, pairs) and int U'' phi phi^T dA (m, 3, 3)."""
        strain = self._strain(gamma)
        C = CauchyGreen(strain)
        _, slope, curve = self.volume.derivatives(self._projected(C.excess))
        pressure = self._projected(slope)
        S, D = self.shape.response(strain)
        dJ = C.J[..., None] * C.C_inv
        weighted = self.weight[:, None] * self.affine
        dc = (weighted.T[:, :, None] * dJ[:, None]).reshape(len(gamma), len(weighted.T), -1) @ self._rows
        stiffness = (weighted.T * curve[:, None]) @ self.affine
        return S + pressure[..., None] * dJ, D + pressure[..., None, None] * C.J_second, dc, stiffness

    def _to_products(self, S: Floats) -> Floats:
        return (self.weight[:, None] * S).reshape(len(S), -1) @ self._rows


@dataclass(frozen=True)
class QuadraticTerm:
    """U = 1/2 gamma^T H gamma with one H (pairs, pairs) per length: Saint Venant-Kirchhoff in a rod that has
    rubber as well.
    """

    H: Floats

    def energy(self, gamma: Floats) -> Floats:
        """Energy per length (m,) [J/m]."""
        return 0.5 * np.sum(gamma * self.resultants(gamma), axis=-1)

    def resultants(self, gamma: Floats) -> Floats:
        """T per length (m, pairs)."""
        return gamma @ self.H

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """T (m, pairs) and H (m, pairs, pairs) per length."""
        return self.resultants(gamma), np.broadcast_to(self.H, (len(gamma), *self.H.shape))

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """T (m, pairs): a linear law predicts exactly."""
        return self.resultants(gamma)
