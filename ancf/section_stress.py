"""Strain and stress at points of a rod's sections, at the axial integration points.

There a reduced axial rule is accurate; between them it is not. Everything is for one part of a rod, which has
one material; part 0 is all of a plain rod. Rows m run over the axial points of the part from its base to its
end, n over the points (y, z) asked for: (n,) the same in every section, or (m, n).

Symbols
-------
E_gl    Green-Lagrange strain in the axes of the reference section (x along the axis, y, z), 6-vector
S_pk2   second Piola-Kirchhoff stress in the same axes [Pa], 6-vector
F       deformation gradient from those axes to SCS
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.cable import fibre_gradient, fibre_strain
from ancf.cauchy_green import CauchyGreen
from ancf.errors import InputError, Message
from ancf.hyperelastic import enhanced_potentials, full_potential
from ancf.materials import VOIGT, SaintVenantKirchhoff
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.scene import Rod
from ancf.section_energy import local_gradient, quadrature_degree, strain_matrix
from ancf.sections import Section

Floats = NDArray[np.float64]

_IDENTITY = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


def section_strain(rod: RodModel, q: Floats, y: Floats, z: Floats, part: int = 0) -> Floats:
    """E_gl (m, n, 6) of a rod at the model's coordinates q, shear doubled (materials.py)."""
    if not rod.element.has_section:
        return fibre_strain(rod, q, y, z, part)
    gamma = rod.strain_products(q)[rod.elements_of(part)]
    strain = np.empty((*gamma.shape[:2], np.shape(y)[-1], 6))
    for kind, point, _, weights in _references(rod, y, z, part):
        strain[kind, point] = np.einsum("nap,ep->ena", strain_matrix(weights), gamma[kind, point])
    return strain.reshape(-1, *strain.shape[2:])


def deformation_gradient(rod: RodModel, q: Floats, y: Floats, z: Floats, part: int = 0) -> Floats:
    """F = sum_i v_i (a_i J_l^-1)^T, (m, n, 3, 3)."""
    if not rod.element.has_section:
        return fibre_gradient(rod, q, y, z, part)
    v = rod.generalised(q)[rod.elements_of(part)]
    F = np.empty((*v.shape[:2], np.shape(y)[-1], 3, 3))
    for kind, point, _, weights in _references(rod, y, z, part):
        F[kind, point] = np.einsum("eic,nia->enca", v[kind, point], weights)
    return F.reshape(-1, *F.shape[2:])


def second_stress(rod: RodModel, q: Floats, y: Floats, z: Floats, part: int = 0) -> Floats:
    """S_pk2 (m, n, 6) of a rod at the model's coordinates q, by its law and formulation.

    continuum  S = dPsi/dE at the point
    enhanced   S = dPsi_0/dE at the point + d(Psi - Psi_0)/dE on the axis: the energy, too, has there alone
               what Poisson's ratio adds
    3363       S = dPsi_shape/dE at the point + the volume part with the affine pressure that the energy knows
    cable      S_xx = E_young E_xx, nothing else
    """
    strain = section_strain(rod, q, y, z, part)
    material = rod.rod.parts[part].material
    if not rod.element.has_section:
        return material.young_modulus * strain
    if rod.element.quadratic_section:
        return _with_affine_pressure(rod, q, strain, y, z, part)
    if rod.rod.formulation == "continuum":
        svk = isinstance(material, SaintVenantKirchhoff)
        return strain @ material.hooke() if svk else full_potential(material).stress(strain)
    axis = _axis_strain(rod, q, part)
    if isinstance(material, SaintVenantKirchhoff):
        D_0, D_v = material.enhanced(rod.rod.shear_factors)
        return strain @ D_0 + axis @ D_v
    section, on_axis = enhanced_potentials(material, rod.rod.shear_factors)
    return section.stress(strain) + on_axis.stress(axis)


def _axis_strain(rod: RodModel, q: Floats, part: int) -> Floats:
    """The strain (m, 1, 6) that ``enhanced`` has on the axis: section_energy.axis_part."""
    if rod.element.linear_section:
        centre = np.zeros(1)
        return section_strain(rod, q, centre, centre, part)
    y, z, area = _section_rules(rod, part)
    weight = area * _volumes(rod, y, z, part)
    strain = section_strain(rod, q, y, z, part)
    return np.einsum("mn,mna->ma", weight / weight.sum(axis=1, keepdims=True), strain)[:, None]


def _section_rules(rod: RodModel, part: int) -> Floats:
    """Points y, z and weights (3, m, n) of the section rule at the axial points of a part."""
    material = rod.rod.parts[part].material
    degree = quadrature_degree(rod.element, rod.rod.prismatic(rod.rod.section, material))
    return np.moveaxis(np.array([section.quadrature(degree) for section in part_sections(rod, part)]), 1, 0)


def _with_affine_pressure(
    rod: RodModel, q: Floats, strain: Floats, y: Floats, z: Floats, part: int
) -> Floats:
    """S = dPsi_shape/dE + p dg/dE at the points, with the affine pressure p that the energy knows.

    p = Pi U'(Pi g), g = tr E for Saint Venant-Kirchhoff and J for rubber, Pi the projection on affine
    functions of (y, z) over the section: nothing else carries the section's force and moment.
    """
    material = rod.rod.parts[part].material
    y_r, z_r, area = _section_rules(rod, part)  # (m, n_r)
    at_rule = section_strain(rod, q, y_r, z_r, part)
    functions = np.stack([np.ones_like(y_r), y_r, z_r], axis=-1)  # (m, n_r, 3)
    weighted = (area * _volumes(rod, y_r, z_r, part))[..., None] * functions
    gram = np.swapaxes(weighted, -1, -2) @ functions

    def affine(values: Floats) -> Floats:
        """Coefficients (m, 3) of Pi of values (m, n_r)."""
        return np.linalg.solve(gram, np.einsum("mna,mn->ma", weighted, values)[..., None])[..., 0]

    def at_points(coefficients: Floats, places: Floats) -> Floats:
        """Affine functions (m, 3) at places (n, 3) or (m, n, 3)."""
        return (places @ coefficients[..., None])[..., 0]

    here = np.stack([np.ones_like(y), y, z], axis=-1)
    if isinstance(material, SaintVenantKirchhoff):
        pressure = material.lame_lambda * at_points(affine(at_rule[..., :3].sum(axis=-1)), here)
        return strain @ material.shape_and_volume()[0] + pressure[..., None] * _IDENTITY
    theta = at_points(affine(CauchyGreen(at_rule).excess), functions)
    pressure = at_points(affine(material.volume.derivatives(theta)[1]), here)
    C = CauchyGreen(strain)
    return material.shape.stress(strain) + (pressure * C.J)[..., None] * C.C_inv


def cauchy_stress(rod: RodModel, q: Floats, y: Floats, z: Floats, part: int = 0) -> Floats:
    """Cauchy stress F S F^T / det F (m, n, 3, 3) [Pa] in SCS."""
    F = deformation_gradient(rod, q, y, z, part)
    S = tensor(second_stress(rod, q, y, z, part), shear=1.0)
    return F @ S @ np.swapaxes(F, -1, -2) / np.linalg.det(F)[..., None, None]


def check_places(rod: Rod, at: float, y: Floats, z: Floats) -> None:
    """Refuse places off the rod: stress there would be extrapolated. Raises InputError."""
    rod.check_place(at)
    section = rod.section_at(at)
    lost = [i for i in range(len(y)) if not section.contains(y[i], z[i], 1e-6)]
    if lost:
        i = lost[0]
        raise InputError(
            Message(
                "There is no stress outside the section.", f"rod {rod.name!r}, point {i}",
                f"(y, z) = ({y[i]:.6g}, {z[i]:.6g}) m is not in the {type(section).__name__.lower()}",
                "another unit, or a point in the bore", "take points of the section, in m",
            )
        )  # fmt: skip


def along_rod(rod: RodModel, values: Floats, at: float, part: int = 0) -> Floats:
    """Values (m, ...) of the axial points of a part at a fraction of the rod's length: linear between and
    beyond them. Stress jumps where parts meet, so nothing is taken from the other side.
    """
    x = rod.axial_abscissae[rod.elements_of(part)].ravel() / rod.rod.length
    if len(x) == 1:
        return values[0]
    i = int(np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2))
    return values[i] + (at - x[i]) / (x[i + 1] - x[i]) * (values[i + 1] - values[i])


def part_sections(rod: RodModel, part: int) -> list[Section]:
    """The sections (m,) at the axial points of a part."""
    xi, _ = gauss(rod.axial_points)
    elements = range(*rod.elements_of(part).indices(len(rod.dofs)))
    return [rod.section_in(element, float(s)) for element in elements for s in xi]


def part_skin(rod: RodModel, part: int, points: int) -> tuple[Floats, Floats]:
    """Outline (y, z) of the sections at the axial points of a part: (n,) of a prismatic one, else (m, n)."""
    segment = rod.rod.parts[part]
    if not segment.tapered:
        y, z = segment.section.outline(points).T
        return y, z
    y, z = np.moveaxis(np.array([section.outline(points) for section in part_sections(rod, part)]), -1, 0)
    return y, z


def along_fibres(rod: RodModel, at: float, part: int, y: Floats, z: Floats) -> tuple[Floats, Floats]:
    """Points (n,) of the section at a fraction of the length, carried to the axial points of its part.

    (m, n) along straight lines that keep their share of the radius of gyration, which on all shapes but
    polygons and tubes run in the skin and parallel to it: stress is smooth along them, and leaves the section
    along lines parallel to the axis. A prismatic part gives (n,) back.
    """
    if not rod.rod.parts[part].tapered:
        return y, z

    def size(section: Section) -> Floats:
        return np.sqrt(np.diag(section.second_moments) / section.area)

    share = np.array([size(section) for section in part_sections(rod, part)]) / size(rod.rod.section_at(at))
    return share[:, :1] * y, share[:, 1:] * z


def tensor(voigt: Floats, shear: float) -> Floats:
    """Symmetric tensors (..., 3, 3) from 6-vectors; strains carry a factor 2 in shear (materials.py)."""
    full = np.empty((*voigt.shape[:-1], 3, 3))
    for row, (a, b) in enumerate(VOIGT):
        full[..., a, b] = full[..., b, a] = voigt[..., row] * (1.0 if a == b else shear)
    return full


def _volumes(rod: RodModel, y: Floats, z: Floats, part: int) -> Floats:
    """Reference volume det J_0 per area and length (m, n), 1 on straight rods."""
    volume = np.empty((*rod.axial_abscissae[rod.elements_of(part)].shape, np.shape(y)[-1]))
    for kind, point, J_l, _ in _references(rod, y, z, part):
        volume[kind, point] = np.linalg.det(J_l)
    return volume.reshape(-1, volume.shape[-1])


def _references(
    rod: RodModel, y: Floats, z: Floats, part: int
) -> list[tuple[NDArray[np.bool_], int, Floats, Floats]]:
    """Elements of one kind (mask in the part), axial point, and the J_l and a J_l^-1 (section_energy.py) that
    they share.

    Curvature is constant along a rod, so alike elements have the same reference in section axes.
    """
    first, kinds = rod.element_kinds
    v0, kinds = rod.elastic.v0, kinds[rod.elements_of(part)]
    # One row of points for each element and axial point; alike elements have the same.
    shape = (len(kinds), rod.axial_points, np.shape(y)[-1])
    y, z = (np.broadcast_to(p, shape) if np.ndim(p) == 1 else np.reshape(p, shape) for p in (y, z))
    found = []
    for row in np.unique(kinds):
        alike = kinds == row
        here = int(np.argmax(alike))
        for point in range(rod.axial_points):
            local = local_gradient(rod.element, v0[first[row], point], y[here, point], z[here, point])
            found.append((alike, point, *local))
    return found
