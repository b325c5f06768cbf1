"""What the chosen element and law cannot do, said as warnings in every result that leaves their range."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.failure import LARGEST_TURN, element_turns
from ancf.hyperelastic import MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.scene_rods import LARGEST_FLOOR
from ancf.section_stress import section_strain, tensor
from ancf.section_validity import section_warnings

if TYPE_CHECKING:
    from ancf.model import Model
    from ancf.rod_model import RodModel
    from ancf.solution import Solution

Floats = NDArray[np.float64]

# Exact bending of a circle is M = E I kappa [1 - c (kappa R)^2] (reference/section.py, nu = .3 to .49): c =
# 1.45 to 1.51 for Saint Venant-Kirchhoff, .37 to .45 for neo-Hookean, .37 to .75 for Mooney-Rivlin. The first
# is softer than rubber by about (kappa R)^2, which nears 1 % at this strain.
STRAIN_LIMIT = 0.08
NAMES = {NeoHookean: "neo-Hookean", MooneyRivlin: "Mooney-Rivlin"}
# Treloar, The Physics of Rubber Elasticity (1975), ch. 5: natural rubber follows the neo-Hookean law up to a
# stretch of about 1.5 and Mooney's up to about 2; beyond, chains of finite length stiffen.
STRETCH_LIMIT = {NeoHookean: 1.5, MooneyRivlin: 2.0}
# lambda/2 (ln J)^2 and K/2 (J - 1)^2 have the same pressure to first order; they differ by 3/2 (J - 1) of it.
VOLUME_LIMIT = 0.2
# Curvature-thickness locking of full axial rules reaches 1 % of the tip at this slenderness of an element.
LOCKING_SLENDERNESS = 25.0
OUTLINE_POINTS = 16


def scene_warnings(model: Model) -> list[str]:
    """Limits of a scene that are known before it is solved, one sentence each."""
    return [f"rod {rod.rod.name!r}: {text}" for rod in model.rods for text in _discretisation(rod)]


def validity_warnings(solution: Solution) -> list[str]:
    """Warnings of a solution, one sentence each with the number that caused it and its limit."""
    found = scene_warnings(solution.model)
    if solution.stable is False:
        found.append(
            "this equilibrium is unstable: its tangent has a negative eigenvalue, as beyond a buckling load; "
            "a small lateral load leads to the stable branch"
        )
    if solution.residual > LARGEST_FLOOR:
        found.append(
            f"rounding leaves a residual of {solution.residual:.2g} E I/L^2 (above {LARGEST_FLOOR:g}): so "
            "close to 0.5 the Poisson ratio takes all digits; 0.4999 serves as incompressible"
        )
    for rod in solution.model.rods:
        y, z = np.vstack([rod.rod.section.outline(OUTLINE_POINTS), np.zeros(2)]).T  # the axis comes last
        strain = section_strain(rod, solution.q, y, z)
        texts = [
            *_turns(solution, rod),
            *_law(rod, strain),
            *section_warnings(solution, rod, strain),
        ]
        found += [f"rod {rod.rod.name!r}: {text}" for text in texts]
    return found


def _discretisation(rod: RodModel) -> Iterator[str]:
    """Limits of formulation and axial rule."""
    spec, element = rod.rod, rod.element
    nu = spec.material.poisson_ratio
    if spec.formulation == "continuum" and not element.quadratic_section and nu != 0.0:
        factor = (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
        yield (
            f'known limit: formulation "continuum" with a linear section bends as if E I were {factor:.4g} '
            f"times its value at nu = {nu:.4g} (Poisson locking, at every mesh and for every law); "
            'use "enhanced"'
        )
    if rod.axial_points < element.axial_points:
        yield (
            f"axial_rule {rod.axial_points} is below the {element.axial_points} points that element "
            f"{element.name} needs: zero-energy modes may spoil the answer"
        )
    slenderness = spec.length / spec.elements / spec.section.radius_of_gyration
    if rod.axial_points >= element.locks_from and slenderness > LOCKING_SLENDERNESS:
        yield (
            f"{element.name} with {rod.axial_points} axial points locks in bending: element length "
            f"/ radius of gyration = {slenderness:.0f} (above {LOCKING_SLENDERNESS:.0f}); use 3333 with its "
            "default rule, or more elements"
        )


def _turns(solution: Solution, rod: RodModel) -> Iterator[str]:
    turn = float(element_turns(rod, solution.q).max())
    if turn > LARGEST_TURN:
        yield (
            f"elements are too long for this shape: one turns by {turn:.2g} rad between its ends (above "
            f"{LARGEST_TURN:g}); use at least {turn / (0.5 * LARGEST_TURN):.0f} times as many"
        )


def _law(rod: RodModel, strain: Floats) -> Iterator[str]:
    """Range of the law, from the strain (sections, skin and axis last, 6).

    One sentence serves Saint Venant-Kirchhoff and a linear section, whose errors are of one size.
    """
    material = rod.rod.material
    if isinstance(material, SaintVenantKirchhoff):
        largest = float(np.max(np.abs(strain)))
        if largest > STRAIN_LIMIT:
            section = "" if rod.element.quadratic_section else " and a linear section"
            advice = "use neo-hookean" if rod.element.quadratic_section else "use 3363 and neo-hookean"
            yield (
                f"largest Green-Lagrange strain {largest:.2g} exceeds {STRAIN_LIMIT:g}: Saint "
                f"Venant-Kirchhoff{section} departs from a rubber there, in bending by about the square of "
                f"the strain, and softens in compression; {advice}"
            )
        return
    squares = 1.0 + 2.0 * np.linalg.eigvalsh(tensor(strain, shear=0.5))
    stretch = np.sqrt(np.maximum(squares, 0.0))  # a flat section leaves -1e-16
    name, limit = NAMES[type(material)], STRETCH_LIMIT[type(material)]
    if not 1.0 / limit <= stretch.min() <= stretch.max() <= limit:
        yield (
            f"principal stretches reach from {stretch.min():.3g} to {stretch.max():.3g}, beyond "
            f"{1.0 / limit:.3g} to {limit:g}: rubber leaves the {name} law there, and stiffens"
        )
    # `enhanced` has the law's volume energy on the axis alone: linear sections cannot contract by fibres.
    counted = stretch[:, -1:] if rod.rod.formulation == "enhanced" else stretch
    volume = np.prod(counted, axis=-1) - 1.0
    worst = float(volume.flat[np.argmax(np.abs(volume))])
    if abs(worst) > VOLUME_LIMIT:
        yield (
            f"the volume changes by {worst:.0%} (beyond {VOLUME_LIMIT:.0%}): the volume energy of {name} is "
            "a choice of form there, not a property of the material"
        )
