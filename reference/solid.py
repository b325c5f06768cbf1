"""Three-dimensional solid reference: a rod with its supports and loads, solved with scikit-fem.

Independent of the beam code. The ends decide what is compared: a start face free to contract (`soft_clamp`)
and a couple without a rigid plate (`solid_couple`) leave the O((kappa R)^2) difference between solid and
beam; a fixed face or a plate hides it, each by an O(R/L) stiffening (2.1e-3 at R/L = 1/40, reference study).
"""

from __future__ import annotations

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from reference.solid_cost import SolidTooLarge
from reference.solid_extract import SectionStates, SectionStress, section_states, section_stress
from reference.solid_forms import formulation_for
from reference.solid_guess import bent_rod, clamped, helical_rod, lifted_rod
from reference.solid_materials import SaintVenantKirchhoff
from reference.solid_mesh import RodMesh, circular_section, rod_mesh
from reference.solid_newton import solve_solid
from reference.solid_problem import SolidProblem, SolidResult, SolidStatus
from reference.solid_steps import solve_in_steps

__all__ = [
    "SectionStates",
    "SectionStress",
    "SolidProblem",
    "SolidResult",
    "SolidStatus",
    "SolidTooLarge",
    "bent_rod",
    "clamped",
    "full_clamp",
    "helical_rod",
    "lifted_rod",
    "section_states",
    "section_stress",
    "soft_clamp",
    "solid_pure_bending",
    "solve_in_steps",
    "solve_solid",
]

Array = NDArray[np.float64]


def solid_pure_bending(
    length: float,
    radius: float,
    young_modulus: float,
    poisson_ratio: float,
    moment: float,
    core: int = 2,
    rings: int = 1,
    slices: int = 20,
) -> SolidResult:
    """Bend a straight circular Saint Venant-Kirchhoff rod along x by an end couple about z.

    Mixed form near nu = 1/2 (`formulation_for`).

    Parameters
    ----------
    length, radius : float
        [m].
    young_modulus : float
        [Pa].
    poisson_ratio : float
        [-].
    moment : float
        [N m], about z, fixed in space.
    core, rings, slices : int
        Core quads per side, rings of the section mesh, elements along the axis.

    Raises
    ------
    ValueError
        For sizes that are not positive, a moment that is not finite, a law outside its range.

    Notes
    -----
    Relative errors of the tip angle (reference study): section -4.4e-3, -3.2e-4, -5e-5 at core 1, 2, 3 and
    nu = 0.3; axis -0.0136 (h^2 kappa/R)^2 with h = length/slices. Theta = pi: about 1.3 s.
    """
    for name, size in [("length", length), ("radius", radius)]:
        if not size > 0:
            raise ValueError(f"{name} is {size} m; it must be positive.")
    for name, count in [("core", core), ("rings", rings), ("slices", slices)]:
        if count < 1:
            raise ValueError(f"{name} is {count}; at least 1 is needed.")
    if not np.isfinite(moment):
        raise ValueError(f"moment is {moment} N m; it must be finite.")
    begin = perf_counter()
    material = SaintVenantKirchhoff(young_modulus, poisson_ratio)
    mesh = rod_mesh(circular_section(radius, core, rings), length, slices)
    curvature = moment / (young_modulus * np.pi * radius**4 / 4)
    problem = SolidProblem(
        mesh=mesh,
        material=material,
        fixed=soft_clamp(mesh),
        guess=bent_rod(mesh, curvature, poisson_ratio),
        moment=np.array([0.0, 0.0, moment]),
        formulation=formulation_for(material),
    )
    return solve_solid(problem, begin=begin)


def soft_clamp(mesh: RodMesh) -> NDArray[np.bool_]:
    """Support of the start face that leaves it free to contract, for bending; returns (n, 3) bool.

    u_x = 0 on the face, u_y = u_z = 0 on the axis, u_z = 0 at the rim node on +y. A hollow section has no
    node on the axis: there u_y = 0 at the rim nodes on +z and -z, which move alike in bending. For bending
    about z only: about y, the rim node moves along z. Not for torsion: three scalars then hold the face in
    its plane (13 to 21 % too soft, reference study).
    """
    fixed = np.zeros(mesh.nodes.shape, bool)
    start, section = mesh.plane(0), mesh.section
    fixed[start, 0] = True
    fixed[start[section.rim[0]], 2] = True
    if section.centre is None:
        fixed[start[[section.rim[1], section.rim[3]]], 1] = True
    else:
        fixed[start[section.centre], 1:] = True
    return fixed


def full_clamp(mesh: RodMesh) -> NDArray[np.bool_]:
    """Support of the start face that holds all of it, for torsion; returns (n, 3) bool.

    Stiffens bending by an O(R/L) Poisson layer: 2.1e-3 of the tip angle at R/L = 1/40 (reference study).
    """
    fixed = np.zeros(mesh.nodes.shape, bool)
    fixed[mesh.plane(0)] = True
    return fixed
