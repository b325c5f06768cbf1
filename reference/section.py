"""Exact finite-strain answer of a prismatic bar in uniform bending, twist and extension.

Far from its ends such a bar moves as a screw, so that three dimensions reduce to a problem on the section
(`section_form`), exact for any strain, law and Poisson ratio up to its mesh. Circle of two core quads and
one ring: couple within 3e-7, four core quads 2e-9 (Saint Venant-Kirchhoff, nu = 0.3, kappa R up to 0.16).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from skfem import Basis, ElementQuad2, MeshQuad2

from reference.rotation import exp
from reference.section_form import STRAINS, SectionForm
from reference.section_newton import SectionLoad, SectionStatus, solve_section
from reference.section_state import SectionPose, SectionState
from reference.section_tangent import BarStiffness, coupled_tangent, stiffness_of, tangent
from reference.solid_materials import SolidMaterial
from reference.solid_mesh import SectionMesh

__all__ = [
    "BarStiffness",
    "SectionPose",
    "SectionState",
    "SectionStatus",
    "bend",
    "bend_and_twist",
    "coupled_tangent",
    "extend",
    "stiffness",
    "tangent",
    "twist",
]

Array = NDArray[np.float64]
Mixed = bool | Literal["auto"]

ORDER = 4  # of the field on each quad
MIXED_ABOVE = 0.45  # Poisson ratio from which "auto" projects the energy of the volume
PARALLEL = 1e-6  # largest |k x couple| by |k| |couple|: beyond it the bar is no screw
SLIGHT_BENDING = 1e-9  # of the couple: less is pure torsion
ROUND = 1e-3  # of the radius: larger scatter of the rim is no circle


def bend(
    section: SectionMesh,
    material: SolidMaterial,
    curvature: float | None = None,
    moment: float | None = None,
    mixed: Mixed = "auto",
    order: int = ORDER,
) -> SectionState:
    """Bend a bar about z, towards +y, without axial force.

    dU/du = 0, int P_1 dA = 0, with k = curvature e_z or couple = moment e_z; F = [a + k x u | u_y | u_z].

    Parameters
    ----------
    section : SectionMesh
        z must be one of its principal axes.
    material : SolidMaterial
        The law.
    curvature : float, optional
        Rotation of the sections per reference length [1/m]; this or `moment`.
    moment : float, optional
        Couple about z [N m].
    mixed : bool or "auto"
        Q2/P1 (order p: Qp/P(p-1)) against volumetric locking; "auto" from a Poisson ratio of 0.45.
    order : int
        Of the field on each quad; 2 is the element of the solid.

    Returns
    -------
    SectionState
        Its status is "not_converged" beyond the largest couple of the law, "not_helical" when z is no
        principal axis.

    Raises
    ------
    ValueError
        When not exactly one of curvature and moment is given, or it is not finite.
    """
    form = _form(section, material, mixed, order)
    name, given = _one_of(curvature=curvature, moment=moment)
    return _solve(form, _about_axis(form, 5, given, name == "curvature"))


def twist(
    section: SectionMesh,
    material: SolidMaterial,
    twist: float | None = None,
    moment: float | None = None,
    mixed: Mixed = "auto",
    order: int = ORDER,
) -> SectionState:
    """Twist a bar about x without axial force; it may warp and change its length (Poynting).

    The limit k = twist e_x of the screw. `twist` [1/m] per reference length or `moment` [N m]; the other
    parameters and the failures are those of `bend`.
    """
    form = _form(section, material, mixed, order)
    name, given = _one_of(twist=twist, moment=moment)
    return _solve(form, _about_axis(form, 3, given, name == "twist"))


def extend(
    section: SectionMesh,
    material: SolidMaterial,
    stretch: float | None = None,
    force: float | None = None,
    mixed: Mixed = "auto",
    order: int = ORDER,
) -> SectionState:
    """Extend a straight bar to a `stretch` [-] or by a `force` [N]; the rest as in `bend`."""
    form = _form(section, material, mixed, order)
    name, given = _one_of(stretch=stretch, force=force)
    held, value = np.arange(STRAINS) >= 3, np.zeros(STRAINS)
    held[0] = name == "stretch"
    value[0] = given if held[0] else given / (form.stress_unit * form.size**2)
    return _solve(form, SectionLoad(held, value))


def bend_and_twist(
    section: SectionMesh,
    material: SolidMaterial,
    moment: ArrayLike,
    mixed: Mixed = "auto",
    order: int = ORDER,
) -> SectionState:
    """Bend and twist a circular bar by a couple that is constant in space.

    k is parallel to the couple, and the material turns about its own axis by the spin in the screw's frame:
    int u x P_1 dA = moment, int P_1 dA = 0, k x moment = 0.

    Parameters
    ----------
    section : SectionMesh
        Circle or annulus.
    material : SolidMaterial
        The law.
    moment : (3,) [N m]
        In the frame of the base section.
    mixed, order
        As in `bend`.

    Raises
    ------
    ValueError
        For another section, or a moment that is not three finite numbers.

    Notes
    -----
    Stationarity in the spin is no equation of equilibrium: turning the material along the bar makes its
    conjugate force constant, not zero. The spin follows from k x moment = 0. Solved with the bending about
    z, where the mesh is symmetric, and turned.
    """
    moment = np.asarray(moment, float)
    if moment.shape != (3,) or not np.all(np.isfinite(moment)):
        raise ValueError(f"moment is {moment} N m; three finite numbers are needed.")
    _check_round(section)
    form = _form(section, material, mixed, order)
    across = float(np.hypot(moment[1], moment[2]))
    held, value = np.zeros(STRAINS, bool), np.zeros(STRAINS)
    unit = form.stress_unit * form.size**3
    value[3] = moment[0] / unit
    if across <= SLIGHT_BENDING * np.linalg.norm(moment):
        held[6] = True
        return _solve(form, SectionLoad(held, value))
    value[5] = across / unit
    angle = np.arctan2(moment[2], moment[1]) - np.pi / 2  # takes e_z to the bending couple
    return _solve(form, SectionLoad(held, value, aligned=True), exp([angle, 0.0, 0.0]))


def stiffness(
    section: SectionMesh, material: SolidMaterial, mixed: Mixed = "auto", order: int = ORDER
) -> BarStiffness:
    """Stiffness EA, EI_y, EI_z, GJ of the undeformed bar, from the linearised section problem."""
    return stiffness_of(_form(section, material, mixed, order))


def _form(section: SectionMesh, material: SolidMaterial, mixed: Mixed, order: int) -> SectionForm:
    if mixed == "auto":
        mixed = material.poisson_ratio >= MIXED_ABOVE
    return SectionForm(section, material, mixed, order)


def _one_of(**values: float | None) -> tuple[str, float]:
    """Name and value of the only one that is given."""
    given = [(name, value) for name, value in values.items() if value is not None]
    if len(given) != 1:
        raise ValueError(f"exactly one of {' and '.join(values)} is needed, {len(given)} are given.")
    name, value = given[0]
    if not np.isfinite(value):
        raise ValueError(f"{name} is {value}; it must be finite.")
    return name, value


def _about_axis(form: SectionForm, axis: int, given: float, is_strain: bool) -> SectionLoad:
    """Load about strain axis 3 (x) or 5 (z): the rotation of the sections (k held) or the couple."""
    held, value = np.zeros(STRAINS, bool), np.zeros(STRAINS)
    held[3:6], held[6] = is_strain, True
    value[axis] = given * form.size if is_strain else given / (form.stress_unit * form.size**3)
    return SectionLoad(held, value)


def _solve(form: SectionForm, load: SectionLoad, turn: Array | None = None) -> SectionState:
    point = solve_section(form, load)
    status, message = point.status, "converged"
    k, couple = point.e[3:6], point.forces.gradient[-4:-1]
    across = float(np.linalg.norm(np.cross(k, couple)))
    k_size, couple_size = float(np.linalg.norm(k)), float(np.linalg.norm(couple))
    noise = form.round_off * (k_size + couple_size)
    if status is not SectionStatus.CONVERGED:
        message = (
            f"Newton's method reached {point.fraction:.3g} of the load. Either no equilibrium exists beyond "
            "(the law softens, or has a largest couple) or the mesh is too coarse: ask for less, prescribe "
            "the deformation where a force or couple is given, or refine the section."
        )
    elif across > PARALLEL * k_size * couple_size + noise:
        status = SectionStatus.NOT_HELICAL
        message = (
            f"rotation {k / form.size} 1/m and couple are not parallel: the bar is not in equilibrium as a "
            "screw. Bend a section about a principal axis; bend and twist circles only."
        )
    return SectionState(form, load, point, status, message, np.eye(3) if turn is None else turn)


def _check_round(section: SectionMesh) -> None:
    mesh = MeshQuad2(np.ascontiguousarray(section.nodes.T), MeshQuad2.from_mesh(section.grid).t)
    basis = Basis(mesh, ElementQuad2())
    edges = [basis.get_dofs(np.array([edge])).all() for edge in mesh.boundary_facets()]
    radii = np.linalg.norm(section.nodes, axis=1)[np.array(edges)]  # ends and middle of every edge
    if np.ptp(radii, axis=1).max() > ROUND * radii.max():
        raise ValueError(
            f"an edge of the section lies between {radii.min():.6g} and {radii.max():.6g} m from its axis; "
            "bending with twist is a screw motion for circles and annuli only."
        )
