r"""Section laws: energy of the strain products gamma at every axial point, as the elastic kernel needs it.

Quadratic, for Saint Venant-Kirchhoff (section_energy.py): U = 1/2 gamma^T H gamma with constant H.

By quadrature, for rubber: at section point n the Green-Lagrange strain is E_n = B_n gamma, hence

    U = sum_n w_n Psi(B_n gamma),   T = dU/dgamma = sum_n w_n B_n^T S_n,   H = sum_n w_n B_n^T D_n B_n.

Strain comes from differences of products, never from F^T F - I, so unstressed sections are exactly so.

`predicted` is the stress of the mixed-integration-point tangent (energy.py): T(gamma_o) + H(gamma_o) (gamma -
gamma_o) with the products gamma that the last linear step from gamma_o predicted.

Arrays: gamma and T (n_el, points, pairs), v (n_el, points, vectors, 3), H (n_el or 1, points, pairs, pairs);
the axial weight is included everywhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ancf.cauchy_green import CauchyGreen
from ancf.potentials import Potential, VolumeEnergy

Floats = NDArray[np.float64]


class SectionLaw(Protocol):
    """Energy of the sections of one rod as a function of the strain products."""

    def energy(self, gamma: Floats) -> float:
        """Strain energy [J]."""
        ...

    def resultants(self, gamma: Floats) -> Floats:
        """T = dU/dgamma."""
        ...

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """T and H = dT/dgamma, symmetric."""
        ...

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """T that the linear law at gamma_previous predicts for gamma."""
        ...

    def smallest_volume(self, v: Floats) -> Floats | None:
        """Smallest det F of each section (n_el, points); None, or inf at a section, where the law is finite
        whatever it is.
        """
        ...


@dataclass(frozen=True)
class QuadraticSection:
    """U = 1/2 gamma^T H gamma with H (n_el or 1, points, pairs, pairs)."""

    H: Floats

    def energy(self, gamma: Floats) -> float:
        """See `SectionLaw.energy`."""
        return 0.5 * float(np.sum(gamma * self.resultants(gamma)))

    def resultants(self, gamma: Floats) -> Floats:
        """See `SectionLaw.resultants`."""
        return (self.H @ gamma[..., None])[..., 0]

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """See `SectionLaw.response`."""
        return self.resultants(gamma), self.H

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """See `SectionLaw.predicted`: a linear law predicts exactly."""
        return self.resultants(gamma)

    def smallest_volume(self, v: Floats) -> None:
        """See `SectionLaw.smallest_volume`: strain alone counts, and it is finite."""
        return


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


@dataclass(frozen=True)
class AlikeSections:
    """Axial points with one reference in section axes: which they are, their axial weights, their terms."""

    points: NDArray[np.intp]  # (m,) places in the flattened (n_el, points)
    axial_weight: Floats  # (m,) [m]
    terms: tuple[Term | ProjectedTerm | QuadraticTerm, ...]

    def of(self, gamma: Floats) -> Floats:
        """The products (batch times m, pairs) of these points, from all (..., n_el, points, pairs)."""
        flat = gamma.reshape(*gamma.shape[:-3], -1, gamma.shape[-1])
        return flat[..., self.points, :].reshape(-1, gamma.shape[-1])

    def shaped(self, values: Floats, gamma: Floats) -> Floats:
        """Values (batch times m, ...) of these points as (..., m, ...) with the batch axes of gamma."""
        return values.reshape(*gamma.shape[:-3], len(self.points), *values.shape[1:])


@dataclass(frozen=True)
class QuadratureSection:
    """Potentials summed over section points, one group of alike sections after the other."""

    groups: tuple[AlikeSections, ...]

    def energy(self, gamma: Floats) -> float:
        """See `SectionLaw.energy`."""
        return float(
            sum(
                np.sum(group.axial_weight * group.shaped(term.energy(group.of(gamma)), gamma))
                for group in self.groups
                for term in group.terms
            )
        )

    def resultants(self, gamma: Floats) -> Floats:
        """See `SectionLaw.resultants`."""
        return self._summed(gamma, lambda group, term: (term.resultants(group.of(gamma)),))[0]

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """See `SectionLaw.response`."""
        T, H = self._summed(gamma, lambda group, term: term.response(group.of(gamma)))
        return T, H

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """See `SectionLaw.predicted`."""
        return self._summed(
            gamma, lambda group, term: (term.predicted(group.of(gamma_previous), group.of(gamma)),)
        )[0]

    def _summed(
        self, gamma: Floats, values: Callable[[AlikeSections, Term | ProjectedTerm | QuadraticTerm], tuple]
    ) -> list[Floats]:
        """Values of the terms, each an array (m, ...) a group, summed and put in place (..., points, ...)."""
        places = gamma.shape[:-1]
        found: list[Floats] = []
        for group in self.groups:
            parts = [values(group, term) for term in group.terms]
            for which, part in enumerate(zip(*parts, strict=True)):
                total = group.shaped(np.sum(part, axis=0), gamma)
                if which == len(found):
                    found.append(
                        np.empty((*places[:-2], places[-2] * places[-1], *total.shape[len(places) - 1 :]))
                    )
                weight = group.axial_weight.reshape(-1, *(1,) * (total.ndim - len(places) + 1))
                found[which][(*(slice(None),) * (len(places) - 2), group.points)] = weight * total
        return [value.reshape(*places, *value.shape[len(places) - 1 :]) for value in found]

    def smallest_volume(self, v: Floats) -> Floats:
        """See `SectionLaw.smallest_volume`: over the points of every rule; inf where strain alone counts."""
        flat = v.reshape(*v.shape[:-4], -1, *v.shape[-2:])
        smallest = np.full(flat.shape[:-2], np.inf)
        for group in self.groups:
            for term in group.terms:
                if isinstance(term, QuadraticTerm):
                    continue
                # Columns of F (..., m, n, 3): the triple product is the determinant.
                c_x, c_y, c_z = np.einsum(
                    "...miv,nia->a...mnv", flat[..., group.points, :, :], term.weights_local
                )
                determinant = np.sum(np.cross(c_x, c_y) * c_z, axis=-1).min(axis=-1)
                smallest[..., group.points] = np.minimum(smallest[..., group.points], determinant)
        return smallest.reshape(v.shape[:-2])
