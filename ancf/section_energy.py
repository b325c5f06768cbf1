r"""Strain energy of a section as a function of the products of a few vectors (the Gram form).

At one axial point the columns of the position gradient are combinations of the *generalised vectors*

    v = (d_0', d_1', ..., d_1, d_2, ...)   (r_x, r_yx, r_zx, r_y, r_z for a linear section),

J_e = sum_i v_i a_i(y, z)^T. Green-Lagrange strain is linear in the products v_i . v_j minus their
reference values, gamma_p = v_i . v_j - v0_i . v0_j for pairs p = (i, j), i <= j. A Saint Venant-Kirchhoff
section therefore has the energy (per weight of the axial rule)

    U = 1/2 gamma^T H gamma,   H = int B^T D B det J_0 dA,   strain = B gamma,

with H constant: exact over the section, objective by construction, zero without round-off when unstressed.
Rubber has Psi(B gamma) at section points instead (section_law.py).

What is integrated where, so that nothing locks:

* quadratic sections (3363): everything but the volume part over the section, the volume part on the affine
  part of tr E or J (`affine_functions`), which is all that quadratic sections can follow: pressure is affine;
* linear sections, ``enhanced``: a law without lateral contraction over the section, on the axis the rest
  (`SaintVenantKirchhoff.enhanced`, `enhanced_potentials`); with r_yz (3343) the rest sees the mean strain of
  the section, so that constant strain causes the right forces on r_yz where int y z dA is not zero;
* linear sections, ``continuum``: the law over the section (paper eq. 16-17); locks with Poisson's ratio.

Symbols
-------
R_0  section frame of the reference at the axial point: x normal to the section, y and z nearest to r_y, r_z
J_0  reference gradient; J_l = R_0^T J_0 the same in section axes, constant over straight sections only
B    (6, pairs) strain-displacement matrix in section axes, Voigt order of materials.py
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ancf.elements import Element
from ancf.errors import Message, SceneError
from ancf.hyperelastic import enhanced_potentials, full_potential
from ancf.materials import VOIGT, SaintVenantKirchhoff
from ancf.scene import Rod
from ancf.section_terms import ProjectedTerm, Term
from ancf.sections import Section

Floats = NDArray[np.float64]
Rule = tuple[Floats, Floats, Floats]  # y, z, weight

# Curved: J_0^-1 and det J_0 make the integrand a quotient 1/(1 - kappa y)^3; degree 16 leaves 1e-12 at
# kappa R = 0.1.
CURVED_DEGREE = 16
RUBBER_DEGREE = 8


def quadrature_degree(element: Element, rod: Rod) -> int:
    """Degree in (y, z) that the section quadrature of a rod has to integrate."""
    if np.any(rod.curvature):
        return CURVED_DEGREE
    if isinstance(rod.material, SaintVenantKirchhoff):
        return element.section_degree
    return RUBBER_DEGREE


def pairs(count: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Index pairs (i, j), i <= j, of the symmetric products of `count` generalised vectors."""
    return np.triu_indices(count)


def gradient_weights(element: Element, y: Floats, z: Floats) -> Floats:
    """Coefficients a (n, generalised vectors, 3) with J_e = sum_i v_i a_i^T at section points (y, z)."""
    phi, phi_y, phi_z = element.section_monomials(y, z)
    count = len(element.directors)
    weights = np.zeros((len(phi), 2 * count - 1, 3))
    weights[:, :count, 0] = phi
    weights[:, count:, 1] = phi_y[:, 1:]
    weights[:, count:, 2] = phi_z[:, 1:]
    return weights


def generalised_shape(element: Element, xi: Floats, h: float) -> Floats:
    """Map (n, generalised vectors, nodal vectors of the element) from nodal vectors to v at xi (n,)."""
    N = {order: element.shape(xi, h, derivative=order) for order in {i for i, _, _ in element.generalised}}
    return np.stack([N[i][:, element.directors.index((j, k))] for i, j, k in element.generalised], axis=1)


@lru_cache(maxsize=256)
def shared_shape(element: Element, xi: tuple[float, ...], h: float) -> Floats:
    """`generalised_shape`; every scene with this element length shares it."""
    N = generalised_shape(element, np.array(xi), h)
    N.setflags(write=False)
    return N


def section_frame(element: Element, v0: Floats) -> Floats:
    """Section frames R_0 (..., 3, 3) of reference vectors v0 (..., generalised vectors, 3)."""
    count = len(element.directors)
    r_y, r_z = v0[..., count + element.y_director - 1, :], v0[..., count + element.z_director - 1, :]
    normal = np.cross(r_y, r_z)
    frame = np.stack([normal / np.sqrt(np.vecdot(normal, normal))[..., None], r_y, r_z], axis=-1)
    left, _, right = np.linalg.svd(frame)
    return left @ right


def local_gradient(element: Element, v0: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
    """Reference gradient in section axes J_l (n, 3, 3) and the coefficients a J_l^-1 (n, vectors, 3).

    F = J_e (R_0^T J_0)^-1 = sum_i v_i (a_i J_l^-1)^T, so the second result gives F and the strain in section
    axes for any v. Raises `SceneError` when det J_0 <= 0: the section reaches past the centre of curvature.
    """
    weights = gradient_weights(element, y, z)
    J_l, _ = reference_gradient(section_frame(element, v0), v0, weights, y, z)
    return J_l, weights @ np.linalg.inv(J_l)


def reference_gradient(
    frame: Floats, v0: Floats, weights: Floats, y: Floats, z: Floats
) -> tuple[Floats, Floats]:
    """J_l (n, 3, 3) and its determinant (n,) at the points y, z of a section with the weights a there."""
    J_l = np.einsum("ba,bi,nij->naj", frame, v0.T, weights)
    determinant = np.linalg.det(J_l)
    if np.min(determinant) <= 0.0:
        worst = int(np.argmin(determinant))
        raise SceneError(
            Message(
                "The reference configuration overlaps itself.",
                f"section point y = {y[worst]:.3g} m, z = {z[worst]:.3g} m",
                f"det J_0 = {determinant[worst]:.3g}, must be positive",
                "the curvature is larger than 1 / section radius, or elements are too long for it",
                "reduce `curvature` or the section, or use more elements",
            )
        )
    return J_l, determinant


@lru_cache(maxsize=256)
def section_points(element: Element, section: Section, degree: int) -> tuple[Floats, ...]:
    """Points y, z (n,), their weights (n,) [m2], phi (n, directors) and `gradient_weights` of a section."""
    y, z, area = section.quadrature(degree)
    phi, _, _ = element.section_monomials(y, z)
    found = (y, z, area, phi, gradient_weights(element, y, z))
    for values in found:
        values.setflags(write=False)
    return found


def strain_matrix(weights_local: Floats) -> Floats:
    """B (n, 6, pairs): Green-Lagrange strain in section axes (shear doubled) from the products gamma."""
    i, j = pairs(weights_local.shape[1])
    B = np.empty((len(weights_local), 6, len(i)))
    half = np.where(i == j, 0.5, 1.0)  # an off-diagonal product stands for two entries of the Gram matrix
    for row, (a, b) in enumerate(VOIGT):
        product = (
            weights_local[:, i, a] * weights_local[:, j, b] + weights_local[:, j, a] * weights_local[:, i, b]
        )
        B[:, row] = product * half * (0.5 if a == b else 1.0)
    return B


def section_stiffness(element: Element, rod: Rod, v0: Floats) -> Floats:
    """Matrix H (pairs, pairs) [N m^(...)] of one axial point of a Saint Venant-Kirchhoff rod, per length.

    Parameters
    ----------
    v0 : reference generalised vectors (generalised vectors, 3) at the point
    """
    assert isinstance(rod.material, SaintVenantKirchhoff)
    degree = quadrature_degree(element, rod)
    return _stiffness(element, rod.section, rod.material, rod.formulation, rod.shear_factors, v0, degree)


@lru_cache(maxsize=256)
def straight_section_stiffness(
    element: Element,
    section: Section,
    material: SaintVenantKirchhoff,
    formulation: str,
    shear_factors: tuple[float, float],
) -> Floats:
    """`section_stiffness` of a straight rod: the same at every point and in every scene with these data."""
    v0 = straight_reference(element)
    H = _stiffness(element, section, material, formulation, shear_factors, v0, element.section_degree)
    H.setflags(write=False)
    return H


def straight_reference(element: Element) -> Floats:
    """Reference generalised vectors (generalised vectors, 3) of a straight rod along x."""
    count = len(element.directors)
    v0 = np.zeros((2 * count - 1, 3))
    v0[0] = (1.0, 0.0, 0.0)
    v0[count + element.y_director - 1] = (0.0, 1.0, 0.0)
    v0[count + element.z_director - 1] = (0.0, 0.0, 1.0)
    return v0


def _stiffness(
    element: Element,
    section: Section,
    material: SaintVenantKirchhoff,
    formulation: str,
    shear_factors: tuple[float, float],
    v0: Floats,
    degree: int,
) -> Floats:
    rule = section.quadrature(degree)
    if element.quadratic_section:
        shape, _ = material.shape_and_volume()
        H = _integrate(element, v0, rule, shape) + _integrate_trace(element, v0, rule, material.lame_lambda)
        return 0.5 * (H + H.T)
    if formulation == "continuum":
        H = _integrate(element, v0, rule, material.hooke())
    else:
        volume, axis = material.enhanced(shear_factors)
        _, B, weight = axis_part(element, section, v0, rule)
        H = _integrate(element, v0, rule, volume) + weight[0] * B[0].T @ axis @ B[0]
    return 0.5 * (H + H.T)


def shear_energy_matrix(element: Element, rod: Rod, v0: Floats) -> Floats:
    """Matrix H (pairs, pairs) of int mu E : E dA, for any law (`v0` as in `section_stiffness`)."""
    rule = rod.section.quadrature(quadrature_degree(element, rod))
    shape = rod.material.lame_mu * np.diag([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
    return _integrate(element, v0, rule, shape)


def section_terms(element: Element, rod: Rod, v0: Floats) -> tuple[Term | ProjectedTerm, ...]:
    """Potentials of a rubber rod on their section points, as in `section_stiffness` (`v0` likewise)."""
    assert not isinstance(rod.material, SaintVenantKirchhoff)
    rule = rod.section.quadrature(quadrature_degree(element, rod))
    if element.quadratic_section:
        y, z, weight = rule
        J_l, weights_local = local_gradient(element, v0, y, z)
        weight = weight * np.linalg.det(J_l)
        B, affine = strain_matrix(weights_local), affine_functions(y, z, weight)
        law = rod.material
        return (ProjectedTerm(law.shape, law.volume, weights_local, B, weight, affine),)
    y, z, weight = rule
    J_l, weights_local = local_gradient(element, v0, y, z)
    everywhere = (weights_local, strain_matrix(weights_local), weight * np.linalg.det(J_l))
    if rod.formulation == "continuum":
        return (Term(full_potential(rod.material), *everywhere),)
    section, axis = enhanced_potentials(rod.material, rod.shear_factors)
    return Term(section, *everywhere), Term(axis, *axis_part(element, rod.section, v0, rule))


def axis_part(element: Element, section: Section, v0: Floats, rule: Rule) -> tuple[Floats, Floats, Floats]:
    """What the part of ``enhanced`` that belongs to the axis sees: the strain there, or the section's mean.

    Returns
    -------
    a J_l^-1 on the axis (1, vectors, 3), B (1, 6, pairs) and weight (1,) [m2].
    """
    centre = np.zeros(1)
    J_l, on_axis = local_gradient(element, v0, centre, centre)
    if element.linear_section:
        return on_axis, strain_matrix(on_axis), section.area * np.linalg.det(J_l)
    y, z, weight = rule
    J_l, weights_local = local_gradient(element, v0, y, z)
    weight = weight * np.linalg.det(J_l)
    mean = np.tensordot(weight / weight.sum(), strain_matrix(weights_local), axes=1)
    return on_axis, mean[None], np.array([weight.sum()])


def affine_functions(y: Floats, z: Floats, weight: Floats) -> Floats:
    """Combinations (n, 3) of 1, y, z that are orthonormal on the points with their weights."""
    functions = np.column_stack([np.ones_like(y), y, z])
    gram = functions.T @ (weight[:, None] * functions)
    return functions @ np.linalg.inv(np.linalg.cholesky(gram)).T


def _integrate_trace(element: Element, v0: Floats, rule: Rule, modulus: float) -> Floats:
    """Matrix of modulus/2 int (Pi tr E)^2 dA with the projection Pi on affine functions."""
    y, z, weight = rule
    J_l, weights_local = local_gradient(element, v0, y, z)
    weight = weight * np.linalg.det(J_l)
    trace = strain_matrix(weights_local)[:, :3].sum(axis=1)
    coefficients = (weight[:, None] * affine_functions(y, z, weight)).T @ trace
    return modulus * coefficients.T @ coefficients


def _integrate(element: Element, v0: Floats, rule: Rule, D: Floats) -> Floats:
    y, z, weight = rule
    J_l, weights_local = local_gradient(element, v0, y, z)
    B = strain_matrix(weights_local)
    return np.einsum("n,nap,ab,nbq->pq", weight * np.linalg.det(J_l), B, D, B, optimize=True)


def director_weights(element: Element, section: Section | Sequence[Section], d0: Floats) -> Floats:
    """Weights W (..., directors, 3) [m4] of the section rotation: W_k = sum_b (int phi_k s_b dA) E_b.

    Parameters
    ----------
    section : the section of all places, or a section for each of the n places in order
    d0 : (..., directors, 3) reference directors, whose (1, 0) and (0, 1) rows are E_y and E_z
    """
    E = d0[..., [element.y_director, element.z_director], :]
    if isinstance(section, Section):
        return np.einsum("kb,...bi->...ki", _section_moments(element, section), E)
    moments = np.array([_section_moments(element, one) for one in section])
    return np.einsum("nkb,nbi->nki", moments, E.reshape(-1, *E.shape[-2:])).reshape(d0.shape)


def force_weights(element: Element, section: Section, y: float, z: float) -> Floats:
    """Weights (directors,) of a unit force at the point (y, z) on the directors of its section.

    Linear sections: the monomials phi_k(y, z). Others would bulge under a force on one point, as a solid does
    without bound; there the force is spread as the affine traction t with the same resultant and moment
    (Saint-Venant), int phi_k t dA, which equals phi_k(y, z) for the linear monomials.
    """
    if element.linear_section:
        return element.section_monomials(np.array([y]), np.array([z]))[0][0]
    points_y, points_z, weight = section.quadrature(element.section_degree)
    # The point is carried along with weight 0, so that the affine functions are known on it as well.
    points_y, points_z, weight = np.append(points_y, y), np.append(points_z, z), np.append(weight, 0.0)
    phi, _, _ = element.section_monomials(points_y, points_z)
    affine = affine_functions(points_y, points_z, weight)
    return affine[-1] @ (affine.T @ (weight[:, None] * phi))


@lru_cache(maxsize=256)
def _section_moments(element: Element, section: Section) -> Floats:
    """int phi_k (y, z) dA, (directors, 2) [m4 for linear directors]."""
    y, z, weight = section.quadrature(element.section_degree)
    phi, _, _ = element.section_monomials(y, z)
    moments = np.einsum("n,nk,nb->kb", weight, phi, np.column_stack([y, z]))
    moments[0] = 0.0  # the axis runs through the centroid; remove the rounding
    moments.setflags(write=False)
    return moments
