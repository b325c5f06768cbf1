"""What the chosen element and law cannot do, said as warnings in every result that leaves their range."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf import cable
from ancf.failure import LARGEST_TURN, element_turns
from ancf.hyperelastic import Law, MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.scene_rod_checks import LARGEST_FLOOR
from ancf.section_stress import part_skin, section_strain, tensor
from ancf.section_validity import section_warnings
from ancf.sections import Section
from ancf.segments import STEEP

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
# Elements with r_x at their nodes keep the axial strain continuous: worth a sentence from this jump on.
STIFFNESS_JUMP = 1.01
# Share of its own stretch that an element of a cable loses where r_x is held (measured, 1 and 5 %).
HELD_STRETCH = 0.12
LARGEST_HELD = 5e-4
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
        cause = (
            "the section forces of the stiffest or shortest segment have this error, the shape has not"
            if any(rod.segments for rod in solution.scene.rods)
            else "so close to 0.5 the Poisson ratio takes all digits; 0.4999 serves as incompressible"
        )
        found.append(
            f"rounding leaves a residual of {solution.residual:.2g} E I/L^2 (above {LARGEST_FLOOR:g}): "
            + cause
        )
    for rod in solution.model.rods:
        strains = [_strain(solution, rod, part) for part in range(len(rod.rod.parts))]
        texts = [
            # An estimate that is small enough knows better.
            *(() if solution.accuracy is not None and solution.accuracy.met else _turns(solution, rod)),
            *_held_stretch(solution, rod),
            *_law(rod, strains),
            *section_warnings(solution, rod, strains),
        ]
        found += [f"rod {rod.rod.name!r}: {text}" for text in texts]
    return found


def largest_strain(solution: Solution, rod: RodModel) -> float:
    """Largest component of the Green-Lagrange strain of a rod, on its skin and axis."""
    return max(float(np.max(np.abs(_strain(solution, rod, part)))) for part in range(len(rod.rod.parts)))


def _strain(solution: Solution, rod: RodModel, part: int) -> Floats:
    """Strain (sections, skin and axis last, 6) of a part of a rod."""
    skin = [np.atleast_2d(side) for side in part_skin(rod, part, OUTLINE_POINTS)]
    y, z = (np.concatenate([side, np.zeros((len(side), 1))], axis=1) for side in skin)
    plain = len(y) == 1 and not rod.rod.parts[part].tapered
    return section_strain(rod, solution.q, *((y[0], z[0]) if plain else (y, z)), part)


def _discretisation(rod: RodModel) -> Iterator[str]:
    """Limits of formulation and axial rule."""
    spec, element = rod.rod, rod.element
    factors = {
        poisson_locking(part.material.poisson_ratio, section if element.warps else None): part.material
        for part in spec.parts
        for section in (part.section, part.last_section)
    }
    factor = max(factors, key=lambda value: abs(np.log(value)))
    nu = factors[factor].poisson_ratio
    if spec.formulation == "continuum" and not element.quadratic_section and nu != 0.0:
        section = "a section that moves in its plane by y z only" if element.warps else "a linear section"
        yield (
            f'known limit: formulation "continuum" with {section} bends as if E I were {factor:.4g} '
            f"times its value at nu = {nu:.4g} (Poisson locking, at every mesh and for every law); "
            'use "enhanced"'
        )
    if rod.axial_points < element.axial_points:
        yield (
            f"axial_rule {rod.axial_points} is below the {element.axial_points} points that element "
            f"{element.name} needs: zero-energy modes may spoil the answer"
        )
    slenderness = max(
        part.length / part.elements / section.radius_of_gyration
        for part in spec.parts
        for section in (part.section, part.last_section)
    )
    locks = rod.axial_points >= element.locks_from and not rod.assumes_strains
    if locks and slenderness > LOCKING_SLENDERNESS:
        advice = "use 3333 with its default rule" if element.has_section else "use the default rule"
        yield (
            f"{element.name} with {rod.axial_points} axial points locks in bending: element length "
            f"/ radius of gyration = {slenderness:.0f} (above {LOCKING_SLENDERNESS:.0f}); {advice}, "
            "or more elements"
        )
    yield from _profile(rod)


def _profile(rod: RodModel) -> Iterator[str]:
    """Limits where segments meet and where they taper."""
    parts, element = rod.rod.parts, rod.element
    slope = max(part.slope for part in parts)
    if slope > STEEP:
        yield (
            f"the skin of a tapered segment is inclined by {slope:.2g} (above {STEEP:g}): plane sections "
            f"make it too stiff in bending by about the square of that, {slope**2:.1%}, at every mesh"
        )
    stiffness = [
        [part.material.young_modulus * section.area for section in (part.section, part.last_section)]
        for part in parts
    ]
    jump = max((max(a[1] / b[0], b[0] / a[1]) for a, b in pairwise(stiffness)), default=1.0)
    if jump > STIFFNESS_JUMP and any(order[0] > 0 for order in element.vectors):
        yield (
            f"known limit: axial stiffness jumps by a factor of {jump:.3g} where two segments meet, and the "
            f"strain of {element.name}, whose nodes carry r_x, cannot: stretching errs in proportion to the "
            "length of the elements there (bending does not); use 3333"
        )


def poisson_locking(nu: float, section: Section | None = None) -> float:
    """Bending stiffness over E I of a linear section under the full law (shared/theory.md, section 3).

    With a `section` that has r_yz: strain -k y along the axis comes with w = c y z, hence c y along z and the
    shear c z, of energy 1/2 int [(lambda + 2 mu)(k^2 + c^2) y^2 - 2 lambda k c y^2 + mu c^2 z^2] dA, least at
    c = lambda k/(lambda + 2 mu + mu int z^2/int y^2); about the axis where it helps less.
    """
    locked = (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
    if section is None:
        return locked
    law = SaintVenantKirchhoff(1.0, nu)
    flat = section.principal_second_moments
    softened = law.lame_lambda + law.lame_mu * (2.0 + flat[1] / flat[0])
    return locked - law.lame_lambda**2 / softened


def _held_stretch(solution: Solution, rod: RodModel) -> Iterator[str]:
    """A clamp of a cable holds r_x, and its stretch with it."""
    if rod.element.has_section:
        return
    strain = np.abs(cable.axial_strain(rod, solution.q)).max(axis=1)
    for support in rod.rod.supports:
        if support.kind != "clamp":
            continue
        node = rod.node_at(support.at)
        beside = [index for index in (node - 1, node) if 0 <= index < len(strain)]
        lost = HELD_STRETCH * sum(strain[index] * rod.mesh.h[index] for index in beside) / rod.rod.length
        if lost > LARGEST_HELD:
            yield (
                f"the clamp at {support.at:g} holds r_x of the cable, which cannot stretch there: {lost:.1e} "
                f'of the length is lost (above {LARGEST_HELD:g}); use "free_section_clamp", which holds the '
                "direction of r_x only"
            )


def _turns(solution: Solution, rod: RodModel) -> Iterator[str]:
    turn = float(element_turns(rod, solution.q).max())
    if turn > LARGEST_TURN:
        yield (
            f"elements are too long for this shape: one turns by {turn:.2g} rad between its ends (above "
            f"{LARGEST_TURN:g}); use at least {turn / (0.5 * LARGEST_TURN):.0f} times as many"
        )


def _law(rod: RodModel, strains: list[Floats]) -> Iterator[str]:
    """Range of each law of a rod, from the strain of its parts (sections, skin and axis last, 6).

    One sentence serves Saint Venant-Kirchhoff and a linear section, whose errors are of one size.
    """
    laws = dict.fromkeys(type(part.material) for part in rod.rod.parts)
    for law in laws:
        of_law = [
            strain for part, strain in zip(rod.rod.parts, strains, strict=True) if type(part.material) is law
        ]
        if law is SaintVenantKirchhoff:
            yield from _small_strain(rod, of_law)
        else:
            yield from _rubber(rod, law, of_law)


def _small_strain(rod: RodModel, strains: list[Floats]) -> Iterator[str]:
    largest = max(float(np.max(np.abs(strain))) for strain in strains)
    if largest > STRAIN_LIMIT:
        section = "" if rod.element.quadratic_section else " and a linear section"
        advice = "use neo-hookean" if rod.element.quadratic_section else "use 3363 and neo-hookean"
        yield (
            f"largest Green-Lagrange strain {largest:.2g} exceeds {STRAIN_LIMIT:g}: Saint "
            f"Venant-Kirchhoff{section} departs from a rubber there, in bending by about the square of "
            f"the strain, and softens in compression; {advice}"
        )


def _rubber(rod: RodModel, law: type[Law], strains: list[Floats]) -> Iterator[str]:
    squares = [1.0 + 2.0 * np.linalg.eigvalsh(tensor(strain, shear=0.5)) for strain in strains]
    stretches = [np.sqrt(np.maximum(square, 0.0)) for square in squares]  # a flat section leaves -1e-16
    name, limit = NAMES[law], STRETCH_LIMIT[law]
    low, high = min(s.min() for s in stretches), max(s.max() for s in stretches)
    if not 1.0 / limit <= low <= high <= limit:
        yield (
            f"principal stretches reach from {low:.3g} to {high:.3g}, beyond "
            f"{1.0 / limit:.3g} to {limit:g}: rubber leaves the {name} law there, and stiffens"
        )
    # `enhanced` has the law's volume energy on the axis alone: linear sections cannot contract by fibres.
    counted = [s[:, -1:] if rod.rod.formulation == "enhanced" else s for s in stretches]
    volume = np.concatenate([np.prod(s, axis=-1).ravel() for s in counted]) - 1.0
    worst = float(volume[np.argmax(np.abs(volume))])
    if abs(worst) > VOLUME_LIMIT:
        yield (
            f"the volume changes by {worst:.0%} (beyond {VOLUME_LIMIT:.0%}): the volume energy of {name} is "
            "a choice of form there, not a property of the material"
        )
