"""Strain and stress at points of a rod's sections, at the axial integration points.

There a reduced axial rule is accurate; between them it is not. Rows m run over the axial points of the rod
from its base to its end, n over the points (y, z) asked for.

Symbols
-------
E_gl    Green-Lagrange strain in the axes of the reference section (x along the axis, y, z), 6-vector
S_pk2   second Piola-Kirchhoff stress in the same axes [Pa], 6-vector
F       deformation gradient from those axes to SCS
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.cauchy_green import CauchyGreen
from ancf.errors import InputError, Message
from ancf.hyperelastic import enhanced_potentials, full_potential
from ancf.materials import VOIGT, SaintVenantKirchhoff
from ancf.rod_model import RodModel
from ancf.scene import Rod
from ancf.section_energy import local_gradient, quadrature_degree, strain_matrix

Floats = NDArray[np.float64]

_IDENTITY = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


def section_strain(rod: RodModel, q: Floats, y: Floats, z: Floats) -> Floats:
    """E_gl (m, n, 6) of a rod at the model's coordinates q, shear doubled (materials.py)."""
    gamma = rod.elastic.gamma(rod.generalised(q))
    strain = np.empty((*gamma.shape[:2], len(y), 6))
    for kind, point, _, weights in _references(rod, y, z):
        strain[kind, point] = np.einsum("nap,ep->ena", strain_matrix(weights), gamma[kind, point])
    return strain.reshape(-1, len(y), 6)


def deformation_gradient(rod: RodModel, q: Floats, y: Floats, z: Floats) -> Floats:
    """F = sum_i v_i (a_i J_l^-1)^T, (m, n, 3, 3)."""
    v = rod.generalised(q)
    F = np.empty((*v.shape[:2], len(y), 3, 3))
    for kind, point, _, weights in _references(rod, y, z):
        F[kind, point] = np.einsum("eic,nia->enca", v[kind, point], weights)
    return F.reshape(-1, len(y), 3, 3)


def second_stress(rod: RodModel, q: Floats, y: Floats, z: Floats) -> Floats:
    """S_pk2 (m, n, 6) of a rod at the model's coordinates q, by its law and formulation.

    continuum  S = dPsi/dE at the point
    enhanced   S = dPsi_0/dE at the point + d(Psi - Psi_0)/dE on the axis: the energy, too, has there alone
               what Poisson's ratio adds
    3363       S = dPsi_shape/dE at the point + the volume part with the affine pressure that the energy knows
    """
    strain = section_strain(rod, q, y, z)
    material = rod.rod.material
    if rod.element.quadratic_section:
        return _with_affine_pressure(rod, q, strain, y, z)
    if rod.rod.formulation == "continuum":
        svk = isinstance(material, SaintVenantKirchhoff)
        return strain @ material.hooke() if svk else full_potential(material).stress(strain)
    centre = np.zeros(1)
    axis = section_strain(rod, q, centre, centre)
    if isinstance(material, SaintVenantKirchhoff):
        D_0, D_v = material.enhanced(rod.rod.shear_factors)
        return strain @ D_0 + axis @ D_v
    section, on_axis = enhanced_potentials(material, rod.rod.shear_factors)
    return section.stress(strain) + on_axis.stress(axis)


def _with_affine_pressure(rod: RodModel, q: Floats, strain: Floats, y: Floats, z: Floats) -> Floats:
    """S = dPsi_shape/dE + p dg/dE at the points, with the affine pressure p that the energy knows.

    p = Pi U'(Pi g), g = tr E for Saint Venant-Kirchhoff and J for rubber, Pi the projection on affine
    functions of (y, z) over the section: nothing else carries the section's force and moment.
    """
    material = rod.rod.material
    y_r, z_r, area = rod.rod.section.quadrature(quadrature_degree(rod.element, rod.rod))
    at_rule = section_strain(rod, q, y_r, z_r)
    functions = np.column_stack([np.ones_like(y_r), y_r, z_r])
    weighted = (area * _volumes(rod, y_r, z_r))[..., None] * functions  # (m, n_r, 3)
    gram = np.swapaxes(weighted, -1, -2) @ functions

    def affine(values: Floats) -> Floats:
        """Coefficients (m, 3) of Pi of values (m, n_r)."""
        return np.linalg.solve(gram, np.einsum("mna,mn->ma", weighted, values)[..., None])[..., 0]

    here = np.stack([np.ones_like(y), y, z])
    if isinstance(material, SaintVenantKirchhoff):
        pressure = material.lame_lambda * affine(at_rule[..., :3].sum(axis=-1)) @ here
        return strain @ material.shape_and_volume()[0] + pressure[..., None] * _IDENTITY
    theta = affine(CauchyGreen(at_rule).excess) @ functions.T
    pressure = affine(material.volume.derivatives(theta)[1]) @ here
    C = CauchyGreen(strain)
    return material.shape.stress(strain) + (pressure * C.J)[..., None] * C.C_inv


def cauchy_stress(rod: RodModel, q: Floats, y: Floats, z: Floats) -> Floats:
    """Cauchy stress F S F^T / det F (m, n, 3, 3) [Pa] in SCS."""
    F = deformation_gradient(rod, q, y, z)
    S = tensor(second_stress(rod, q, y, z), shear=1.0)
    return F @ S @ np.swapaxes(F, -1, -2) / np.linalg.det(F)[..., None, None]


def check_places(rod: Rod, at: float, y: Floats, z: Floats) -> None:
    """Refuse places off the rod: stress there would be extrapolated. Raises InputError."""
    if not 0.0 <= at <= 1.0:
        raise InputError(
            Message(
                "There is no stress off the rod.", f"rod {rod.name!r}, at = {at:g}", "0 <= at <= 1",
                "a length instead of a fraction of it", "divide by the length",
            )
        )  # fmt: skip
    lost = [i for i in range(len(y)) if not rod.section.contains(y[i], z[i], 1e-6)]
    if lost:
        i = lost[0]
        raise InputError(
            Message(
                "There is no stress outside the section.", f"rod {rod.name!r}, point {i}",
                f"(y, z) = ({y[i]:.6g}, {z[i]:.6g}) m is not in the {type(rod.section).__name__.lower()}",
                "another unit, or a point in the bore", "take points of the section, in m",
            )
        )  # fmt: skip


def along_rod(rod: RodModel, values: Floats, at: float) -> Floats:
    """Values (m, ...) of the axial points at a fraction of the length: linear between and beyond them."""
    x = rod.axial_abscissae.ravel() / rod.rod.length
    if len(x) == 1:
        return values[0]
    i = int(np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2))
    return values[i] + (at - x[i]) / (x[i + 1] - x[i]) * (values[i + 1] - values[i])


def tensor(voigt: Floats, shear: float) -> Floats:
    """Symmetric tensors (..., 3, 3) from 6-vectors; strains carry a factor 2 in shear (materials.py)."""
    full = np.empty((*voigt.shape[:-1], 3, 3))
    for row, (a, b) in enumerate(VOIGT):
        full[..., a, b] = full[..., b, a] = voigt[..., row] * (1.0 if a == b else shear)
    return full


def _volumes(rod: RodModel, y: Floats, z: Floats) -> Floats:
    """Reference volume det J_0 per area and length (m, n), 1 on straight rods."""
    volume = np.empty((*rod.axial_abscissae.shape, len(y)))
    for kind, point, J_l, _ in _references(rod, y, z):
        volume[kind, point] = np.linalg.det(J_l)
    return volume.reshape(-1, len(y))


def _references(rod: RodModel, y: Floats, z: Floats) -> list[tuple[NDArray[np.bool_], int, Floats, Floats]]:
    """Elements of one kind (mask), axial point, and the J_l and a J_l^-1 (section_energy.py) that they share.

    Curvature is constant along a rod, so elements of one length have the same reference in section axes.
    """
    first, kinds = rod.element_kinds
    v0 = rod.elastic.v0
    return [
        (kinds == row, point, *local_gradient(rod.element, v0[index, point], y, z))
        for row, index in enumerate(first)
        for point in range(rod.axial_points)
    ]
