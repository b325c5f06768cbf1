"""Displacement form and condensed Q2/P1 mixed form of the solid's internal energy.

Symbols: `F` deformation gradient (n_el, n_qp, 3, 3), `g` volume measure of the law (tr E or J), `Pi` the
element-wise L2 projection on {1, X, Y, Z}, `theta` = Pi g, `p` = Pi U'(theta) pressure-like stress [Pa],
`phi` orthonormal basis of {1, X, Y, Z} in an element [m^-3/2].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from reference.solid_assembly import SolidAssembly
from reference.solid_materials import SolidMaterial

Array = NDArray[np.float64]
Formulation = Literal["displacement", "mixed"]
MIXED_ABOVE = 0.4  # Poisson ratio: 0.45 with displacements errs by 1e-3 on the coarsest mesh


def formulation_for(material: SolidMaterial) -> Formulation:
    """Mixed where displacements alone would lock, near nu = 1/2."""
    return "mixed" if material.poisson_ratio > MIXED_ABOVE else "displacement"


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Tangent of a form at one state.

    `A_pk1` (n_el, n_qp, 3, 3, 3, 3) [Pa] acts point by point and belongs to the stress `P_pk1`; `K_element`
    (n_el, 81, 81) [N/m], rows a i and columns k b, couples the points of an element; `projected` are the
    factors of the latter's stress.
    """

    P_pk1: Array
    A_pk1: Array
    K_element: Array | None = None
    projected: tuple[Array, Array, Array] | None = None

    def stress_rate(self, dF: Array) -> Array:
        """dP = A_pk1 dF + Pi(U'' Pi dg) dg/dF (n_el, n_qp, 3, 3) [Pa]."""
        n_el, n_qp = dF.shape[:2]
        dP = (self.A_pk1.reshape(n_el, n_qp, 9, 9) @ dF.reshape(n_el, n_qp, 9, 1)).reshape(dF.shape)
        if self.projected is None:
            return dP
        return dP + self.pressure_rate(dF)[..., None, None] * self.projected[0]

    def pressure_rate(self, dF: Array) -> Array:
        """dp = Pi(U'' Pi dg) (n_el, n_qp) [Pa]; zero in the displacement form."""
        if self.projected is None:
            return np.zeros(dF.shape[:2])
        g_F, phi, weighted_C = self.projected
        dg = np.sum(g_F * dF, axis=(-2, -1))
        return (phi @ (weighted_C @ dg[..., None]))[..., 0]


class SolidForm(Protocol):
    """Internal energy of a discrete solid as a function of the deformation gradient at its points."""

    def energy(self, F: Array) -> float:
        """Strain energy [J]."""
        ...

    def stress(self, F: Array) -> Array:
        """Stress that the nodal forces integrate (n_el, n_qp, 3, 3) [Pa]."""
        ...

    def point_pressure(self, F: Array) -> Array:
        """p at the integration points (n_el, n_qp) [Pa]; zero in the displacement form."""
        ...

    def linearise(self, F: Array, p: Array | None = None) -> Linearisation:
        """Tangent at F; the mixed form takes the pressure p (n_el, n_qp) instead of its own if given."""
        ...

    def inadmissible(self, F: Array) -> str:
        """Why the law has no value at F, and where; empty if it has one."""
        ...

    def pressure(self, F: Array, element: NDArray[np.int64], X: Array) -> Array | None:
        """Projected p [Pa] at reference points (m, 3) of the elements (m,); None in the displacement form."""
        ...


def solid_form(formulation: Formulation, material: SolidMaterial, assembly: SolidAssembly) -> SolidForm:
    """Form by name; raises `ValueError` for an unknown one."""
    if formulation == "displacement":
        return DisplacementForm(material, assembly)
    if formulation == "mixed":
        return MixedForm(material, assembly)
    raise ValueError(f'formulation is "{formulation}"; "displacement" and "mixed" are known.')


class DisplacementForm:
    """int Psi(F) dV. Locks where the law is nearly incompressible: nu above about 0.45."""

    def __init__(self, material: SolidMaterial, assembly: SolidAssembly) -> None:
        self.material = material
        self.assembly = assembly

    def energy(self, F: Array) -> float:
        """Strain energy, int Psi(F) dV [J]."""
        return self.assembly.integrate(self.material.energy(F))

    def stress(self, F: Array) -> Array:
        """First Piola-Kirchhoff stress of the law."""
        return self.material.stress(F)

    def point_pressure(self, F: Array) -> Array:
        """Zero: the law has all of the stress."""
        return np.zeros(F.shape[:2])

    def linearise(self, F: Array, p: Array | None = None) -> Linearisation:
        """Tangent of the law, point by point."""
        return Linearisation(self.material.stress(F), self.material.tangent(F))

    def inadmissible(self, F: Array) -> str:
        """Where det F is not positive."""
        return _inverted_point(F)

    def pressure(self, F: Array, element: NDArray[np.int64], X: Array) -> None:
        """There is none."""


class MixedForm:
    """int Psi_shape(F) dV + int U(Pi g) dV, condensed element by element: same unknowns, symmetric.

    First variation int p dg dV with p = Pi U'(Pi g); tangent int [dg Pi(U'' Pi dg) + p d2g] dV.

    Notes
    -----
    Q2/P1-discontinuous: the inf-sup stable pair for hexahedra with P1 in physical coordinates (Boffi, Brezzi,
    Fortin, Mixed Finite Element Methods and Applications, 2013, section 8.6.3.1).
    """

    def __init__(self, material: SolidMaterial, assembly: SolidAssembly) -> None:
        self.material = material
        self.assembly = assembly
        self._mean = assembly.points.mean(axis=1)
        size = assembly.volume.sum(axis=1) ** (1 / 3)
        self._scale = size
        n_el = len(size)
        monomials = self._monomials(np.arange(n_el)[:, None], assembly.points)
        self._weighted = assembly.volume[..., None]  # (n_el, n_qp, 1)
        mass = monomials.swapaxes(-1, -2) @ (self._weighted * monomials)
        self._orthonormal = np.linalg.inv(np.linalg.cholesky(mass)).swapaxes(-1, -2)
        self.phi = monomials @ self._orthonormal  # (n_el, n_qp, 4)

    def project(self, f: Array) -> Array:
        """Pi f = phi int phi f dV (n_el, n_qp)."""
        return (self.phi @ self._coefficients(f))[..., 0]

    def energy(self, F: Array) -> float:
        """Strain energy, int [Psi_shape(F) + U(Pi g)] dV [J]."""
        theta = self.project(self.material.volume_measure(F)[0])
        return self.assembly.integrate(self.material.shape.energy(F) + self.material.volume_energy(theta)[0])

    def stress(self, F: Array) -> Array:
        """P = P_shape + p dg/dF (n_el, n_qp, 3, 3) [Pa]."""
        g, g_F, _ = self.material.volume_measure(F)
        return self.material.shape.stress(F) + self._pressure(g)[..., None, None] * g_F

    def point_pressure(self, F: Array) -> Array:
        """p = Pi U'(Pi g) at the integration points (n_el, n_qp) [Pa]."""
        return self._pressure(self.material.volume_measure(F)[0])

    def linearise(self, F: Array, p: Array | None = None) -> Linearisation:
        """Point by point A_shape + p d2g/dF2; between the points of an element G C G^T.

        G_am = int phi_m dg/du_a dV, C_mn = int phi_m U'' phi_n dV. The derivative of `stress` unless another
        pressure is given.
        """
        law = self.material
        g, g_F, g_FF = law.volume_measure(F)
        slope = law.volume_energy(self.project(g))[2]
        p = self._pressure(g) if p is None else p
        P_pk1 = law.shape.stress(F) + p[..., None, None] * g_F
        A_pk1 = law.shape.tangent(F) + p[..., None, None, None, None] * g_FF
        C = self.phi.swapaxes(-1, -2) @ (self._weighted * slope[..., None] * self.phi)
        G = self.assembly.moments(self.phi, g_F)  # (n_el, a, i, m)
        n_el = len(G)
        rows, columns = G.reshape(n_el, 81, 4), G.swapaxes(1, 2).reshape(n_el, 81, 4)
        K_element = rows @ C @ columns.swapaxes(-1, -2)
        weighted_C = C @ (self._weighted * self.phi).swapaxes(-1, -2)
        return Linearisation(P_pk1, A_pk1, K_element, (g_F, self.phi, weighted_C))

    def inadmissible(self, F: Array) -> str:
        """Where det F is not positive, or the projected measure leaves the range of U."""
        inverted = _inverted_point(F)
        if inverted:
            return inverted
        theta = self.project(self.material.volume_measure(F)[0])
        with np.errstate(all="ignore"):
            defined = np.isfinite(self.material.volume_energy(theta)[0])
        if np.all(defined):
            return ""
        element, point = np.argwhere(~defined)[0]
        return f"projected volume {theta[element, point]:.2e} in element {element}, point {point}"

    def pressure(self, F: Array, element: NDArray[np.int64], X: Array) -> Array:
        """p at reference points (m, 3) of the elements (m,) [Pa]."""
        theta = self.project(self.material.volume_measure(F)[0])
        coefficients = self._coefficients(self.material.volume_energy(theta)[1])[..., 0]
        phi = self._monomials(element, X)[:, None, :] @ self._orthonormal[element]
        return np.sum(phi[:, 0] * coefficients[element], axis=-1)

    def _pressure(self, g: Array) -> Array:
        """p = Pi U'(Pi g) (n_el, n_qp) [Pa]."""
        return self.project(self.material.volume_energy(self.project(g))[1])

    def _coefficients(self, f: Array) -> Array:
        """int phi_m f dV (n_el, 4, 1)."""
        return self.phi.swapaxes(-1, -2) @ (self._weighted * f[..., None])

    def _monomials(self, element: NDArray[np.int64], X: Array) -> Array:
        """1, X, Y, Z about the element's mean, over its size (..., 4)."""
        local = (X - self._mean[element]) / self._scale[element][..., None]
        return np.concatenate([np.ones((*local.shape[:-1], 1)), local], axis=-1)


def _inverted_point(F: Array) -> str:
    """Smallest det F of all integration points and where it is, if it is not positive."""
    J = np.linalg.det(F)
    element, point = np.unravel_index(np.argmin(J), J.shape)
    if J[element, point] > 0:
        return ""
    return f"det F = {J[element, point]:.2e} in element {element}, point {point}"
