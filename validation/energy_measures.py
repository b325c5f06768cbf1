"""Energy and constant-strain forces of a rod, from its law in the deformation gradient (`reference/`).

The kernel writes every law in Green-Lagrange strain; what is measured here shares nothing with it but the
shape functions and the section's quadrature.

Symbols
-------
q      nodal vectors of a rod (n_nodes, vectors, 3); e the same per element (n_el, nodal, 3)
F      deformation gradient, by section axes of the reference where it is called local
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.hyperelastic import Law, MooneyRivlin, NeoHookean
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.section_stress import cauchy_stress
from reference import solid_materials as solid
from validation.kernel_measures import frame_and_gradients, nodal_units, per_element

Floats = NDArray[np.float64]

# One order above the kernel's own rules for curved sections (16), so that both agree to 1e-10 only if both
# have converged.
CHECK_DEGREE = 20


def solid_law(material: Law) -> solid.SolidMaterial:
    """The same law as `reference/` has it."""
    if isinstance(material, MooneyRivlin):
        return solid.MooneyRivlin(material.c10, material.c01, material.bulk_modulus)
    if isinstance(material, NeoHookean):
        return solid.NeoHookean(material.young_modulus, material.poisson_ratio)
    return solid.SaintVenantKirchhoff(material.young_modulus, material.poisson_ratio)


def integrated_energy(model: RodModel, q: Floats) -> float:
    """Strain energy [J] as the volume integral of the law's density, with the rule of each formulation.

    Quadratic sections: the shape part over the section, the volume part of the affine part of its measure.
    Linear sections, ``continuum``: everything over the section; ``enhanced``: Psi_0 of
    `unconstrained_density` over the section, Psi - Psi_0 (shear factors 1) on the axis times
    the area; of an element with r_yz at the section's mean of C. Strains of the section that an element takes
    from its nodes are taken from there in the metric.
    """
    total = 0.0
    for e, e0, h in zip(per_element(model, q), model.e0, model.mesh.h, strict=True):
        for xi, weight in zip(*gauss(model.axial_points), strict=True):
            total += 0.5 * h * weight * _section_energy(model, e, e0, xi, h)
        if _is_controlled(model):
            total += _swelling_energy(model, e, e0, h)
    return float(total)


def _is_controlled(model: RodModel) -> bool:
    """Whether the rod has the energy besides that its axial points miss of the sections."""
    return model.rod.axial_rule == "default" and model.element.long_from > 0.0


def _swelling_energy(model: RodModel, e: Floats, e0: Floats, h: float) -> float:
    """Energy [J] of the second difference of the section's metric over the nodes.

    1/2 c h/45 int 2 mu E : E dA with 2 E_ab = C_ab(-1) - 2 C_ab(0) + C_ab(1) less its reference value, a, b
    in {y, z}, and c = rho h/(h^2 + (k rho)^2), rho^2 = I/A.
    """
    section = model.rod.section
    y, z, area = section.quadrature(CHECK_DEGREE)
    change = np.zeros((len(y), 3, 3))
    for xi, share in ((-1.0, 1.0), (0.0, -2.0), (1.0, 1.0)):
        for sign, x in ((1.0, e), (-1.0, e0)):
            _, J = frame_and_gradients(model, x, xi, h, y, z)
            change[:, 1:, 1:] += sign * share * (np.swapaxes(J, -1, -2) @ J)[:, 1:, 1:]
    R0, J0 = frame_and_gradients(model, e0, 0.0, h, y, z)
    to_local = np.linalg.inv(J0) @ R0
    E = 0.5 * np.swapaxes(to_local, -1, -2) @ change @ to_local
    rho = float(np.sqrt(section.weaker_second_moment / section.area))
    c = rho * h / (h**2 + (model.element.long_from * rho) ** 2)
    density = model.rod.material.lame_mu * np.sum(E * E, axis=(-2, -1))
    return c * h / 45.0 * float(np.sum(area * np.linalg.det(J0) * density))


def _section_energy(model: RodModel, e: Floats, e0: Floats, xi: float, h: float) -> float:
    """Energy per reference length [J/m] of one section."""
    rod = model.rod
    law = solid_law(rod.material)

    def state(y: Floats, z: Floats) -> tuple[Floats, Floats]:
        """Local F (n, 3, 3), seen along the axes of the reference section, and det J_0 (n,)."""
        _, J = frame_and_gradients(model, e, xi, h, y, z)
        R0, J0 = frame_and_gradients(model, e0, xi, h, y, z)
        to_local = np.linalg.inv(J0) @ R0
        if rod.axial_rule == "default" and model.element.assumed:
            J = _sampled_at_nodes(model, e, e0, J, J0, xi, h, y, z)
        return J @ to_local, np.linalg.det(J0)

    y, z, area = rod.section.quadrature(CHECK_DEGREE)
    F, volume = state(y, z)
    if model.element.quadratic_section:
        theta = affine_part(law.volume_measure(F)[0], y, z, area * volume)
        return float(np.sum(area * volume * (law.shape.energy(F) + law.volume_energy(theta)[0])))
    if rod.formulation == "continuum":
        return float(np.sum(area * volume * law.energy(F)))
    bending = float(np.sum(area * volume * unconstrained_density(rod.material, F, rod.shear_factors)))
    centre, volume_c = state(np.zeros(1), np.zeros(1))
    on_axis = rod.section.area * float(volume_c[0])
    if not model.element.linear_section:  # the mean of C = F^T F over the section
        on_axis = float(np.sum(area * volume))
        C = np.einsum("n,nki,nkj->ij", area * volume / on_axis, F, F)
        centre = np.linalg.cholesky(C).T[None]
    axis = float(law.energy(centre)[0] - unconstrained_density(rod.material, centre)[0])
    return bending + on_axis * axis


def _sampled_at_nodes(
    model: RodModel, e: Floats, e0: Floats, J: Floats, J0: Floats, xi: float, h: float, y: Floats, z: Floats
) -> Floats:
    """Any J (n, 3, 3) with the metric J^T J of an element whose strains of the section come from its nodes.

    The change of the metric by y and z, (J^T J - J0^T J0)_ab with a, b in {y, z}, is interpolated by the
    polynomial through its values at the nodes; an orthogonal factor before J changes no law.
    """
    assert model.element.assumed == (("section", model.element.node_xi),)
    nodes = np.array(model.element.node_xi)

    def change(J: Floats, J0: Floats) -> Floats:
        return np.swapaxes(J, -1, -2) @ J - np.swapaxes(J0, -1, -2) @ J0

    at_nodes = np.array(
        [
            change(*(frame_and_gradients(model, x, xi_n, h, y, z)[1] for x in (e, e0)))[:, 1:, 1:]
            for xi_n in nodes
        ]
    )
    coefficients = np.polyfit(nodes, at_nodes.reshape(len(nodes), -1), len(nodes) - 1)
    section = np.array([np.polyval(column, xi) for column in coefficients.T]).reshape(at_nodes.shape[1:])
    metric = np.swapaxes(J, -1, -2) @ J
    metric[:, 1:, 1:] = (np.swapaxes(J0, -1, -2) @ J0)[:, 1:, 1:] + section
    return np.asarray(np.swapaxes(np.linalg.cholesky(metric), -1, -2), dtype=float)


def affine_part(values: Floats, y: Floats, z: Floats, weight: Floats) -> Floats:
    """Values (n,) of the function a + b y + c z nearest to the given values, by weighted least squares."""
    functions = np.column_stack([np.ones_like(y), y / np.max(np.abs(y)), z / np.max(np.abs(z))])
    weighted = weight[:, None] * functions  # some weights of an angle section are negative
    found = np.linalg.solve(weighted.T @ functions, weighted.T @ values)
    return functions @ found


def patch_force(model: RodModel, F: Floats) -> float:
    """Error of the nodal forces of a straight rod in the constant-strain state r = F X, relative to the
    largest.

    P = dPsi/dF is constant, so by parts the force on director k is [N_k] P e_x int phi_k dA at the two ends
    plus int N_k dx (P e_y int dphi_k/dy dA + P e_z int dphi_k/dz dA), whatever the element lengths.
    """
    rod, element = model.rod, model.element
    P = solid_law(rod.material).stress(F) @ rod.base.rotation  # columns: stress on the faces of the section
    y, z, area = rod.section.quadrature(4)
    phi, phi_y, phi_z = (np.einsum("n,nk->k", area, values) for values in element.section_monomials(y, z))
    expected = np.zeros((len(model.e0), element.vectors_per_element, 3))
    for index, h in enumerate(model.mesh.h):
        ends = element.shape(np.array([-1.0, 1.0]), h)
        xi, weight = gauss(4)
        mean = 0.5 * h * np.einsum("x,xkn->kn", weight, element.shape(xi, h))
        expected[index] = np.einsum("kn,k,i->ni", ends[1] - ends[0], phi, P[:, 0])
        expected[index] += np.einsum("kn,k,i->ni", mean, phi_y, P[:, 1])
        expected[index] += np.einsum("kn,k,i->ni", mean, phi_z, P[:, 2])
    found = model.elastic.force(model.e0 @ F.T)
    unit = np.tile(nodal_units(model, float(np.min(model.mesh.h))), (len(element.node_xi), 1))
    return float(np.max(np.abs((found - expected) * unit)) / np.max(np.abs(expected * unit)))


def patch_stress(model: RodModel, F: Floats) -> float:
    """Error of the Cauchy stress P F^T/det F at all axial points and on the outline, in the state r = F X."""
    P = solid_law(model.rod.material).stress(F)
    expected = P @ F.T / np.linalg.det(F)
    y, z = np.vstack([model.rod.section.outline(8), np.zeros(2)]).T
    found = cauchy_stress(model, (model.q0 @ F.T).ravel(), y, z)
    return float(np.max(np.abs(found - expected)) / np.max(np.abs(expected)))


def unconstrained_density(material: Law, F: Floats, factors: tuple[float, float] = (1.0, 1.0)) -> Floats:
    """Density (n,) [J/m3] of `enhanced` over a linear section: Poisson ratio 0, the same E_young and shears.

    Saint Venant-Kirchhoff: sum of E_young/2 E_aa^2 and 2 G k E_ab^2 (theory.md 3). Rubbers: the same rubber
    with nu = 0 and E_young, whose shear modulus is E_young/2, and (k G - E_young/2)/2 (2 E_ab)^2 for each
    shear. Section axes of the reference.
    """
    young, G = material.young_modulus, material.lame_mu
    k_y, k_z = factors
    strain = 0.5 * (np.swapaxes(F, -1, -2) @ F - np.eye(3))
    shear = np.stack([strain[:, 1, 2], strain[:, 0, 2], strain[:, 0, 1]], axis=-1)
    moduli = G * np.array([1.0, k_z, k_y])
    if isinstance(material, MooneyRivlin):
        share = 0.5 * young / G
        law = solid.MooneyRivlin(share * material.c10, share * material.c01, young / 3.0)
        return law.energy(F) + 2.0 * shear**2 @ (moduli - 0.5 * young)
    if isinstance(material, NeoHookean):
        return solid.NeoHookean(young, 0.0).energy(F) + 2.0 * shear**2 @ (moduli - 0.5 * young)
    normal = np.diagonal(strain, axis1=-2, axis2=-1)
    return 0.5 * young * np.sum(normal**2, axis=-1) + 2.0 * shear**2 @ moduli
