"""What the sections of an element cannot do: second-order fields, warping, flattening, curving across."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.hyperelastic import MooneyRivlin, NeoHookean
from ancf.sections import Annulus, Circle, Ellipse, Rectangle

if TYPE_CHECKING:
    from ancf.rod_model import RodModel
    from ancf.solution import Solution

Floats = NDArray[np.float64]

# Linear sections lack the second-order lateral field of rubber: c errs by up to .25 in neo-Hookean bending,
# by .6 to 1.1 in Mooney-Rivlin (section energy of the enhanced formulation against reference/section.py, nu =
# .3 to .49); 1 % at these strains.
LINEAR_SECTION_LIMIT = {NeoHookean: 0.2, MooneyRivlin: 0.1}
# Quadratic sections were compared with the exact section answer up to a full circle of L/R = 40.
QUADRATIC_SECTION_LIMIT = 0.17
# What a section that keeps its shape may lose against one that flattens or curves across; see `_flattening`
# and `_anticlastic`.
SHAPE_LIMIT = 0.01
# Against reference/section.py (neo-Hookean, nu = .3 and .49, strips 1:5 to 1:20): 31 for small w^2 kappa/h.
ANTICLASTIC = 31.0
# 3363 curves across as a parabola; beyond this w^2 kappa/h the curvature sits at the edges and 3363 is too
# soft by 1 to 2 %, at twice it by up to 4 % (same comparison).
PARABOLA_LIMIT = 10.0
# Torsion in a section moment that is worth a warning where the section's torsion stiffness is not exact.
TORSION_SHARE = 1e-3


def section_warnings(solution: Solution, rod: RodModel, strain: Floats) -> Iterator[str]:
    """One sentence for each limit of the sections that a solution leaves.

    Parameters
    ----------
    strain : Green-Lagrange strain (sections, skin and axis last, 6)
    """
    yield from _section(rod, strain)
    if isinstance(rod.rod.section, Circle):
        return  # a disc has nothing to warp, to flatten or to curve across
    name = rod.rod.name
    axes, moment = solution.section_axes(name), solution.section_forces(name).moment
    local = np.einsum("nia,ni->na", axes, moment)  # about the section's normal, y and z
    yield from _torsion(rod, local)
    yield from _flattening(rod, local)
    yield from _anticlastic(rod, local)


def _section(rod: RodModel, strain: Floats) -> Iterator[str]:
    """What the section cannot follow, by how much the strain varies over it: curvature or twist times radius.

    Uniform states are exact in every element and law, so they do not count.
    """
    spread = float(np.max(np.abs(strain[:, :-1] - strain[:, -1:]) * np.array([1, 1, 1, 0.5, 0.5, 0.5])))
    if rod.element.quadratic_section:
        if spread > QUADRATIC_SECTION_LIMIT:
            yield (
                f"the strain varies by {spread:.2g} from axis to skin: the quadratic section of "
                f"{rod.element.name} was compared with the exact section answer up to "
                f"{QUADRATIC_SECTION_LIMIT:g} only"
            )
        return
    limit = LINEAR_SECTION_LIMIT.get(type(rod.rod.material))
    if limit is not None and spread > limit:
        yield (
            f"the strain varies by {spread:.2g} from axis to skin (above {limit:g}): a linear section "
            "lacks the second-order lateral field of rubber, an error in bending that grows with the square, "
            "is 1 % there and stays at every mesh; use 3363"
        )


def _torsion(rod: RodModel, moment: Floats) -> Iterator[str]:
    """Torsion stiffness: exact where the element's sections can take the warping of the section."""
    section = rod.rod.section
    # Saint-Venant warping is nothing on a ring, and y z on an ellipse.
    exact = (Annulus, Ellipse) if rod.element.quadratic_section else Annulus
    if isinstance(section, exact):
        return
    total = float(np.sum(moment**2))
    share = float(np.sum(moment[:, 0] ** 2)) / total if total > 0.0 else 0.0
    if share <= TORSION_SHARE:
        return
    if rod.element.quadratic_section:
        limit = (
            f"sections of {rod.element.name} warp by y z, y^2 and z^2 only: torsion stiffness is too high, "
            "on rectangles by up to 19 %, and more on thin or angular sections"
        )
    else:
        limit = (
            f"sections of {rod.element.name} cannot warp: torsion stiffness G (I_y + I_z) is too high unless "
            "round"
        )
    yield f"known limit: {share:.1%} of the squared section moment is torsion, and {limit}"


def _flattening(rod: RodModel, moment: Floats) -> Iterator[str]:
    """Tubes flatten in bending and lose 1.5 (1 - nu^2)(kappa r^2/t)^2 of their moment (Brazier 1927).

    r mean radius, t wall. The exact section problem gives the same within 10 % for r/t from 4.5 up, and more
    on thicker walls; no section here can show it.
    """
    section = rod.rod.section
    if not isinstance(section, Annulus):
        return
    wall = section.radius - section.inner_radius
    kappa = float(np.max(np.linalg.norm(_curvatures(rod, moment), axis=1)))
    nu = rod.rod.material.poisson_ratio
    loss = 1.5 * (1.0 - nu**2) * (kappa * (section.radius - 0.5 * wall) ** 2 / wall) ** 2
    if loss > SHAPE_LIMIT:
        yield (
            f"the tube would flatten: curvature {kappa:.3g} 1/m costs it about {loss:.1%} of its moment "
            f"(Brazier; above {SHAPE_LIMIT:.0%}), which sections of {rod.element.name} cannot show; a tube "
            "collapses when a third is lost"
        )


def _anticlastic(rod: RodModel, moment: Floats) -> Iterator[str]:
    """Strips curve across as well, and are stiffer by nu^2 x/(1 + (1 - nu^2) x), x = (w^2 kappa/h)^2/31.

    h height in the plane of bending, w width. From E I of a narrow beam to E I/(1 - nu^2) of a plate (Searle;
    Ashwell 1950).
    """
    section = rod.rod.section
    if not isinstance(section, Rectangle | Ellipse):
        return
    sides = 2.0 * np.abs(section.outline(4)).max(axis=0)  # along y, z
    kappa_y, kappa_z = np.abs(_curvatures(rod, moment)).max(axis=0)
    ratio = max(sides[1] ** 2 * kappa_z / sides[0], sides[0] ** 2 * kappa_y / sides[1])
    nu = rod.rod.material.poisson_ratio
    x = float(ratio) ** 2 / ANTICLASTIC
    gain = nu**2 * x / (1.0 + (1.0 - nu**2) * x)
    if rod.element.quadratic_section:
        if ratio > PARABOLA_LIMIT and gain > SHAPE_LIMIT:
            yield (
                f"the strip is wide for its curvature, width^2 curvature/height = {ratio:.3g} (above "
                f"{PARABOLA_LIMIT:g}): it curves across at its edges only, and the quadratic section of "
                f"{rod.element.name} is too soft by a few percent"
            )
    elif gain > SHAPE_LIMIT:
        yield (
            f"a strip so wide curves across and would be {gain:.1%} stiffer (above {SHAPE_LIMIT:.0%}; "
            f"width^2 curvature/height = {ratio:.3g}), which the linear section of {rod.element.name} cannot "
            "show; use 3363"
        )


def _curvatures(rod: RodModel, moment: Floats) -> Floats:
    """Curvature about the section's y and z (n, 2) [1/m] that the moments (n, 3) make in the thin rod."""
    return moment[:, 1:] / (rod.rod.material.young_modulus * np.diag(rod.rod.section.second_moments)[::-1])
