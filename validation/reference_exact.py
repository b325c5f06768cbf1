"""The solid reference on bodies whose exact answer is known: stretch, flexure and torsion.

Each function returns relative errors by name. Lengths in m with bodies of size 1, moduli in Pa near 1: the
answers do not depend on the units.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.bodies import Body, distorted
from reference.homogeneous import HomogeneousStretch
from reference.rivlin import Flexure, Torsion
from reference.rivlin_compressible import RadialSolution
from reference.solid_forms import Formulation
from reference.solid_materials import SolidMaterial
from reference.solid_mesh import circular_section, rectangular_section, rod_mesh
from validation.criteria import largest

Floats = NDArray[np.float64]

WIDTH = 0.3  # of the bent block, in the direction that is held


def stretched_block(
    material: SolidMaterial,
    formulation: Formulation,
    stretch: float,
    directions: int,
    exact: HomogeneousStretch,
) -> dict[str, float]:
    """Distorted unit cube, one or two directions prescribed by rollers, the others free.

    Errors of the free stretch and of the nominal stress.
    """
    mesh = distorted(rod_mesh(rectangular_section(1.0, 1.0, 2, 2), 1.0, 2), 0.04)
    X = mesh.nodes - [0.0, -0.5, -0.5]
    fixed = X < 1e-9
    fixed[:, :directions] |= X[:, :directions] > 1 - 1e-9
    start = np.full(3, exact.free)
    start[:directions] = stretch
    body = Body(mesh, material, formulation, fixed)
    # The free directions start 5 % off, so that the answer is found and not given.
    u = body.equilibrium(X * np.where(np.arange(3) < directions, start - 1, 1.05 * start - 1))
    far = X[:, 0] > 1 - 1e-9
    free = 1 + u[X[:, 2] > 1 - 1e-9, 2]
    stress = float(body.force(u)[far, 0].sum())
    return {
        "free stretch": float(np.abs(free - exact.free).max()) / exact.free,
        "stress": abs(stress / exact.stress - 1),
    }


def bent_block(
    material: SolidMaterial,
    formulation: Formulation,
    curvature: float,
    thickness: float,
    cells: int,
    exact: Flexure | RadialSolution,
) -> dict[str, float]:
    """Block bent to a quarter of a ring in plane strain; errors of the couple and of the two radii.

    Two rollers hold it: the start section may only move along y, the end section, a quarter turn on, only
    along x. The exact motion glides on both, so there is no end layer and nothing of it is prescribed.
    """
    mesh = rod_mesh(rectangular_section(thickness, WIDTH, cells, 1), np.pi / 2 / curvature, 2 * cells)
    X = mesh.nodes
    fixed = np.zeros(X.shape, bool)
    fixed[:, 2] = True
    fixed[mesh.plane(0), 0] = True
    fixed[mesh.plane(-1), 1] = True
    k = curvature
    radius = np.sqrt(2 * X[:, 1] / k + np.sqrt(1 + (k * thickness) ** 2) / k**2)  # without change of volume
    angle = k * X[:, 0]
    x = np.column_stack([radius * np.sin(angle), radius * np.cos(angle), X[:, 2]])
    x[mesh.plane(0), 0] = 0.0
    x[mesh.plane(-1), 1] = 0.0
    body = Body(mesh, material, formulation, fixed)
    x = X + body.equilibrium(x - X)
    start = mesh.plane(0)
    moment = -float(x[start, 1] @ body.force(x - X)[start, 0]) / WIDTH
    inner, outer = float(x[start, 1].min()), float(x[start, 1].max())
    if isinstance(exact, Flexure):
        radii = exact.inner_radius, exact.outer_radius
    else:
        radii = float(exact.radius[0]), float(exact.radius[-1])
    return {
        "couple": abs(moment / exact.moment - 1),
        "radii": largest(abs(inner / radii[0] - 1), abs(outer / radii[1] - 1)),
    }


def twisted_cylinder(
    material: SolidMaterial,
    formulation: Formulation,
    twist: float,
    stretch: float,
    cells: int,
    exact: Torsion | RadialSolution,
) -> dict[str, float]:
    """Cylinder of radius 1 and length 1, its ends on the exact motion, its side free.

    Errors of the couple, and of the axial force by the Poynting scale c tau^2 a^4 pi/2 ~ couple x twist.
    The body is as stiff as the law, so `exact` of the incompressible law is met only as nu goes to 1/2.
    """
    mesh = rod_mesh(circular_section(1.0, cells, cells), 1.0, cells)
    X = mesh.nodes
    R = np.hypot(X[:, 1], X[:, 2])
    r = exact.radius_at(R) if isinstance(exact, RadialSolution) else R / np.sqrt(stretch)
    angle = np.arctan2(X[:, 2], X[:, 1]) + twist * X[:, 0]
    x = np.column_stack([stretch * X[:, 0], r * np.cos(angle), r * np.sin(angle)])
    fixed = np.zeros(X.shape, bool)
    fixed[[*mesh.plane(0), *mesh.plane(-1)]] = True
    body = Body(mesh, material, formulation, fixed)
    x = X + body.equilibrium(x - X)
    end = mesh.plane(-1)
    f = body.force(x - X)[end]
    moment = float(x[end, 1] @ f[:, 2] - x[end, 2] @ f[:, 1])
    return {
        "couple": abs(moment / exact.moment - 1),
        "axial force": abs(float(f[:, 0].sum()) - exact.axial_force) / abs(exact.moment * twist),
    }
