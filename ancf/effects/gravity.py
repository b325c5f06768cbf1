r"""Weight: Q_k = int rho phi_k det J_0 dA dx g, constant over the motion."""

from __future__ import annotations

import numpy as np

from ancf.effects import DeadLoad, Effect
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.scene import Scene
from ancf.section_energy import (
    generalised_shape,
    quadrature_degree,
    reference_gradient,
    section_frame,
    section_points,
)

# Shape functions are cubic at most and det J_0 of a curved element adds a few degrees; 5 points reach
# degree 9, which holds the area of a taper (2) and its second moments (4) as well.
AXIAL_POINTS = 5


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Weight of every rod of the scene."""
    assert scene.gravity is not None
    return [_weight(model, scene.gravity.acceleration) for model in rods]


def _weight(model: RodModel, acceleration: np.ndarray) -> DeadLoad:
    rod, element = model.rod, model.element
    xi, weight = gauss(AXIAL_POINTS)
    first, kind = model.element_kinds
    mass = np.zeros((len(first), element.vectors_per_element))
    for row, index in enumerate(first):
        h = float(model.mesh.h[index])
        N = element.shape(xi, h)
        v0 = generalised_shape(element, xi, h) @ model.e0[index]
        material = model.material_of(index)
        if material.density is None:  # refused when the scene was read
            raise ValueError(f"rod {rod.name!r} has no density")
        frames = section_frame(element, v0) if element.has_section else v0
        for point in range(AXIAL_POINTS):
            if not element.has_section:  # straight in the reference: all its mass is on the axis
                area = model.section_in(index, float(xi[point])).area
                mass[row] += 0.5 * h * weight[point] * material.density * area * N[point, 0]
                continue
            local = rod.prismatic(model.section_in(index, float(xi[point])), material)
            degree = quadrature_degree(element, local)
            y, z, area, phi, weights = section_points(element, local.section, degree)
            _, stretch = reference_gradient(frames[point], v0[point], weights, y, z)
            per_length = material.density * (area * stretch) @ phi
            mass[row] += 0.5 * h * weight[point] * per_length @ N[point]
    return DeadLoad("gravity", model.dofs, np.einsum("en,a->ena", mass[kind], acceleration))
