r"""What a cable's axis says of its sections: strain, stress, force and moment.

A cable has no section vectors. Its sections stand across the tangent in the transported frames
(axis_frames.py), and its law (cable_law.py) is that of fibres:

    E_xx(y, z) = eps - y k_z + z k_y,    S_xx = E_young E_xx,    m = E I r_x x r_xx/|r_x|^2 = E I k.

The moment is linear in an element between the places at which its curvature is sampled. The force follows
from equilibrium: the force of an element on its end nodes is that in its middle, line load and weight that it
carries are the difference to other places; the shear force of a shear-free axis has no law.

Symbols
-------
eps     strain of the axis (|r_x|^2 - 1)/2 as the law sees it (n_el, points)
k       rotation of the tangent per reference length (n_el, points, 3) [1/m], a vector across the tangent
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.assumed_strain import interpolated
from ancf.axis_frames import rotations
from ancf.cable_law import CableSection
from ancf.quadrature import gauss

if TYPE_CHECKING:
    from ancf.model import Model
    from ancf.rod_model import RodModel

Floats = NDArray[np.float64]


def cable_section(rod: RodModel) -> CableSection:
    """The law of every axial point, axial weight included."""
    xi, _ = gauss(rod.axial_points)
    first, kind = rod.element_kinds
    stiffness = np.array(
        [
            [
                rod.material_of(index).young_modulus * np.array([section.area, section.weaker_second_moment])
                for section in (rod.section_in(index, float(s)) for s in xi)
            ]
            for index in first
        ]
    )[kind]
    weighted = rod.axial_weights[..., None] * stiffness
    return CableSection(weighted[..., 0], weighted[..., 1])


def section_axes(rod: RodModel, q: Floats) -> Floats:
    """Axes (n_el, points, 3, 3) of the sections at the axial points, columns x, y, z in SCS."""
    xi, _ = gauss(rod.axial_points)
    return rotations(rod, rod.nodal(q), xi)[1] @ rod.rod.base.rotation


def axial_strain(rod: RodModel, q: Floats) -> Floats:
    """eps (n_el, points) as the law sees it."""
    return 0.5 * rod.strain_products(q)[..., 0]


def curvature(rod: RodModel, q: Floats) -> Floats:
    """k (n_el, points, 3)."""
    v = rod.elastic.generalised(rod.element_vectors(q))
    r_x, r_xx = v[:, :, 0], v[:, :, 1]
    k = np.cross(r_x, r_xx) / np.sum(r_x**2, axis=-1, keepdims=True)
    if rod.elastic.assumed is None:
        return k
    return interpolated(rod.element, "curvature", rod.axial_points, k)


def moments(rod: RodModel, q: Floats) -> Floats:
    """Section moments m (n_el, points, 3) [N m]."""
    law = rod.elastic.section
    assert isinstance(law, CableSection)
    return (law.bending / rod.axial_weights)[..., None] * curvature(rod, q)


def axial_forces(rod: RodModel, q: Floats) -> Floats:
    """Forces along the axis E A eps |r_x| (n_el, points) [N]."""
    law = rod.elastic.section
    assert isinstance(law, CableSection)
    stretch = np.linalg.norm(rod.generalised(q)[:, :, 0], axis=-1)
    return law.stretching / rod.axial_weights * axial_strain(rod, q) * stretch


def forces(model: Model, rod: RodModel, q: Floats, load_factor: float) -> Floats:
    """Section forces n (n_el, points, 3) [N]: in the element's middle, less what it carries from there."""
    columns = rod.elastic.position_columns
    middle = rod.elastic.force(rod.element_vectors(q))[:, columns[-1]]
    carried = np.zeros_like(middle)
    for effect in model.effects:
        if effect.dofs is rod.dofs:  # on every element of this rod: weight, line loads, bed
            share = 1.0 if effect.passive else load_factor
            carried += share * effect.force(rod.element_vectors(q))[:, columns].sum(axis=1)
    xi, _ = gauss(rod.axial_points)
    return middle[:, None] - 0.5 * xi[:, None] * carried[:, None]


def fibre_strain(rod: RodModel, q: Floats, y: Floats, z: Floats, part: int) -> Floats:
    """Strain (m, n, 6) at points (n,) or (m, n) of the sections at the axial points of a part: E_xx alone."""
    here = rod.elements_of(part)
    axes = section_axes(rod, q)[here].reshape(-1, 3, 3)
    local = np.einsum("mia,mi->ma", axes, curvature(rod, q)[here].reshape(-1, 3))
    strain = np.zeros((len(axes), np.shape(y)[-1], 6))
    strain[..., 0] = axial_strain(rod, q)[here].reshape(-1, 1) - y * local[:, 2:] + z * local[:, 1:2]
    return strain


def fibre_gradient(rod: RodModel, q: Floats, y: Floats, z: Floats, part: int) -> Floats:
    """F (m, n, 3, 3) of sections that stay plane, rigid and across the tangent, columns by section axes:

    F e_x = r_x + k x (y e_y + z e_z), F e_y = e_y, F e_z = e_z with the section axes e in SCS.
    """
    here = rod.elements_of(part)
    axes = section_axes(rod, q)[here].reshape(-1, 1, 3, 3)
    k = curvature(rod, q)[here].reshape(-1, 1, 3)
    y, z = np.broadcast_arrays(np.asarray(y)[..., None], np.asarray(z)[..., None])
    F = np.repeat(axes, y.shape[-2], axis=1)
    r_x = rod.generalised(q)[here, :, 0].reshape(-1, 1, 3)
    F[..., 0] = r_x + np.cross(k, y * axes[..., 1] + z * axes[..., 2])
    return F
