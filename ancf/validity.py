"""What the chosen element and law cannot do, said as warnings in every result that leaves their range."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancf.failure import LARGEST_TURN, element_turns
from ancf.section_energy import local_gradient, strain_matrix
from ancf.sections import Annulus, Circle

if TYPE_CHECKING:
    from ancf.rod_model import RodModel
    from ancf.solution import Solution

# Saint Venant-Kirchhoff in bending departs from every rubber by about 1.4 (kappa R)^2: 1 % at this strain.
STRAIN_LIMIT = 0.08
# Curvature-thickness locking of full axial rules reaches 1 % of the tip at this slenderness of an element.
LOCKING_SLENDERNESS = 25.0
# A circle's J; other linear sections twist without warping and are too stiff by more than this.
TORSION_SHARE = 1e-3


def validity_warnings(solution: Solution) -> list[str]:
    """Warnings of a solution, one sentence each with the number that caused it."""
    found = []
    if solution.stable is False:
        found.append(
            "this equilibrium is unstable: its tangent has a negative eigenvalue, as beyond a buckling load; "
            "a small lateral load leads to the stable branch"
        )
    for rod in solution.model.rods:
        found += [f"rod {rod.rod.name!r}: {text}" for text in _of_rod(solution, rod)]
    return found


def _of_rod(solution: Solution, rod: RodModel) -> list[str]:
    spec, found = rod.rod, []
    nu = spec.material.poisson_ratio
    if spec.formulation == "continuum" and nu != 0.0:
        factor = (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
        found.append(
            f'known limit: formulation "continuum" with a linear section bends as if E I were {factor:.4g} '
            f'times its value at nu = {nu:g} (Poisson locking, at every mesh); use "enhanced"'
        )
    if rod.axial_points < rod.element.axial_points:
        found.append(
            f"axial_rule {rod.axial_points} is below the {rod.element.axial_points} points that element "
            f"{rod.element.name} needs: zero-energy modes may spoil the answer"
        )
    turn = float(element_turns(rod, solution.q).max())
    if turn > LARGEST_TURN:
        found.append(
            f"elements are too long for this shape: one turns by {turn:.2g} rad between its ends (above "
            f"{LARGEST_TURN:g}); use at least {turn / (0.5 * LARGEST_TURN):.0f} times as many"
        )
    strain = largest_strain(solution, rod)
    if strain > STRAIN_LIMIT:
        found.append(
            f"largest Green-Lagrange strain {strain:.2g} exceeds {STRAIN_LIMIT:g}: Saint Venant-Kirchhoff "
            "and a linear section depart from a real solid there, in bending by 1.4 times the strain squared"
        )
    slenderness = spec.length / spec.elements / rod.rod.section.radius_of_gyration
    locks = rod.axial_points >= rod.element.locks_from
    if locks and slenderness > LOCKING_SLENDERNESS:
        found.append(
            f"{rod.element.name} with {rod.axial_points} axial points locks in bending: element length "
            f"/ radius of gyration = {slenderness:.0f} (above {LOCKING_SLENDERNESS:.0f}); use 3333 with its "
            "default rule, or more elements"
        )
    if not isinstance(spec.section, Circle | Annulus):
        share = twist_share(solution, rod)
        if share > TORSION_SHARE:
            found.append(
                f"known limit: {share:.1%} of the squared section moment is torsion, and sections of "
                f"{rod.element.name} cannot warp: torsion stiffness G (I_y + I_z) is too high unless round"
            )
    return found


def largest_strain(solution: Solution, rod: RodModel) -> float:
    """Largest Green-Lagrange strain component at the axial points on the outline of the section.

    Sections of elements of one length have the same reference (constant curvature), so one strain matrix per
    kind of element and axial point serves all.
    """
    y, z = rod.rod.section.outline(16).T
    gamma = rod.elastic.gamma(rod.generalised(solution.q))
    v0 = rod.elastic.v0
    first, kind = rod.element_kinds
    largest = 0.0
    for row, index in enumerate(first):
        for point in range(rod.axial_points):
            _, weights = local_gradient(rod.element, v0[index, point], y, z)
            strain = gamma[kind == row, point] @ np.concatenate(strain_matrix(weights)).T
            largest = max(largest, float(np.max(np.abs(strain))))
    return largest


def twist_share(solution: Solution, rod: RodModel) -> float:
    """Share of the twisting moment in the squared section moment, summed over the rod."""
    moment = solution.section_forces(rod.rod.name).moment
    along = np.einsum("ni,ni->n", moment, solution.section_axes(rod.rod.name)[:, :, 0])
    total = float(np.sum(moment**2))
    return float(np.sum(along**2)) / total if total > 0.0 else 0.0
