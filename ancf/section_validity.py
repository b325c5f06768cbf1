"""What the sections of an element cannot do: second-order fields, warping, flattening, curving across."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.hyperelastic import Law, MooneyRivlin, NeoHookean
from ancf.section_stress import part_sections
from ancf.sections import Annulus, Circle, Ellipse, Rectangle, Section

if TYPE_CHECKING:
    from ancf.rod_model import RodModel
    from ancf.scene import Pressure
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
# What a linear section adds to the couple of a chamber, of p A_c times the outer radius; `chamber_warnings`.
WALL_LIMIT = 0.01
# Torsion in a section moment that is worth a warning where the section's torsion stiffness is not exact.
TORSION_SHARE = 1e-3


@dataclass(frozen=True)
class _Places:
    """The axial points of a rod: section, material and local moment (about the normal, y and z) at each."""

    sections: list[Section]
    materials: list[Law]
    moment: Floats  # (n, 3) N m

    def of(self, *shapes: type[Section]) -> tuple[list[Section], Floats, Floats]:
        """Sections of these shapes, their Poisson ratios (m,) and curvatures about y and z (m, 2) [1/m].

        Curvature is what the moments make in the thin rod.
        """
        rows = [i for i, section in enumerate(self.sections) if isinstance(section, shapes)]
        sections, laws = [self.sections[i] for i in rows], [self.materials[i] for i in rows]
        second = np.array([np.diag(section.second_moments)[::-1] for section in sections]).reshape(-1, 2)
        young = np.array([law.young_modulus for law in laws])[:, None]
        nu = np.array([law.poisson_ratio for law in laws])
        return sections, nu, self.moment[rows, 1:] / (young * second)


def section_warnings(solution: Solution, rod: RodModel, strains: list[Floats]) -> Iterator[str]:
    """One sentence for each limit of the sections that a solution leaves, the worst of the rod.

    Parameters
    ----------
    strains : Green-Lagrange strain (sections, skin and axis last, 6) of each part of the rod
    """
    yield from _section(rod, strains)
    parts = rod.rod.parts
    if all(isinstance(part.section, Circle) for part in parts):
        return  # a disc has nothing to warp, to flatten or to curve across
    name = rod.rod.name
    axes, moment = solution.section_axes(name), solution.section_forces(name).moment
    local = np.einsum("nia,ni->na", axes, moment)  # about the section's normal, y and z
    sections = [part_sections(rod, part) for part in range(len(parts))]
    materials = [part.material for part, found in zip(parts, sections, strict=True) for _ in found]
    places = _Places([section for found in sections for section in found], materials, local)
    yield from _torsion(rod, places)
    yield from _flattening(rod, places)
    yield from _anticlastic(rod, places)


def chamber_warnings(rod: RodModel, chamber: Pressure) -> Iterator[str]:
    """A chamber off the axis, whose wall a linear section does not feel in bending.

    Bending by kappa, a uniaxial stress E kappa y, changes a chamber at the distance e from the axis by the
    volume A_c kappa e (1 - 2 nu) per length; by Betti's theorem its pressure is worth the couple
    p A_c e (1 - 2 nu).
    The lateral strain of a linear section does not vary with y and leaves p A_c e.
    """
    if rod.element.quadratic_section:
        return
    ends = rod.rod.ends
    reached = [
        part for part, first, last in zip(rod.rod.parts, ends[:-1], ends[1:], strict=True)
        if first < chamber.end and last > chamber.start
    ]  # fmt: skip
    nu = max((part.material.poisson_ratio for part in reached), key=abs)
    offset = float(np.hypot(*chamber.centre))
    if 2.0 * abs(nu) * offset > WALL_LIMIT * max(part.section.outer_radius for part in reached):
        yield (
            f"known limit: a chamber {offset:.3g} m off the axis bends {rod.element.name} by p A_c e, as if "
            f"fibres held its wall; a bare wall of nu = {nu:.3g} pushes back and leaves 1 - 2 nu = "
            f"{1.0 - 2.0 * nu:.3g} of that; use 3363 for a chamber without fibres"
        )


def _section(rod: RodModel, strains: list[Floats]) -> Iterator[str]:
    """What the section cannot follow, by how much the strain varies over it: curvature or twist times radius.

    Uniform states are exact in every element and law, so they do not count.
    """
    shear = np.array([1, 1, 1, 0.5, 0.5, 0.5])
    spreads = [float(np.max(np.abs(strain[:, :-1] - strain[:, -1:]) * shear)) for strain in strains]
    if rod.element.quadratic_section:
        spread = max(spreads)
        if spread > QUADRATIC_SECTION_LIMIT:
            yield (
                f"the strain varies by {spread:.2g} from axis to skin: the quadratic section of "
                f"{rod.element.name} was compared with the exact section answer up to "
                f"{QUADRATIC_SECTION_LIMIT:g} only"
            )
        return
    limits = [LINEAR_SECTION_LIMIT.get(type(part.material), np.inf) for part in rod.rod.parts]
    spread, limit = max(zip(spreads, limits, strict=True), key=lambda pair: pair[0] / pair[1])
    if spread > limit:
        yield (
            f"the strain varies by {spread:.2g} from axis to skin (above {limit:g}): a linear section "
            "lacks the second-order lateral field of rubber, an error in bending that grows with the square, "
            "is 1 % there and stays at every mesh; use 3363"
        )


def _torsion(rod: RodModel, places: _Places) -> Iterator[str]:
    """Torsion stiffness: exact where the element's sections can take the warping of the section."""
    # Saint-Venant warping is nothing on discs and rings, and y z on an ellipse.
    exact = (Circle, Annulus, Ellipse) if rod.element.warps else (Circle, Annulus)
    wrong = [not isinstance(section, exact) for section in places.sections]
    total = float(np.sum(places.moment**2))
    share = float(np.sum(places.moment[wrong, 0] ** 2)) / total if total > 0.0 else 0.0
    if share <= TORSION_SHARE:
        return
    if rod.element.warps:
        powers = "y z, y^2 and z^2" if rod.element.quadratic_section else "y z"
        limit = (
            f"sections of {rod.element.name} warp by {powers} only: torsion stiffness is too high, "
            "on rectangles by up to 19 %, and more on thin or angular sections"
        )
    else:
        limit = (
            f"sections of {rod.element.name} cannot warp: torsion stiffness G (I_y + I_z) is too high unless "
            "round"
        )
    yield f"known limit: {share:.1%} of the squared section moment is torsion, and {limit}"


def _flattening(rod: RodModel, places: _Places) -> Iterator[str]:
    """Tubes flatten in bending and lose 1.5 (1 - nu^2)(kappa r^2/t)^2 of their moment (Brazier 1927).

    r mean radius, t wall. The exact section problem gives the same within 10 % for r/t from 4.5 up, and more
    on thicker walls; no section here can show it.
    """
    sections, nu, curvatures = places.of(Annulus)
    if not sections:
        return
    radius, inner = np.array([(s.radius, s.inner_radius) for s in sections if isinstance(s, Annulus)]).T
    wall = radius - inner
    kappa = np.linalg.norm(curvatures, axis=1)
    losses = 1.5 * (1.0 - nu**2) * (kappa * (radius - 0.5 * wall) ** 2 / wall) ** 2
    worst = int(np.argmax(losses))
    loss = losses[worst]
    if loss > SHAPE_LIMIT:
        yield (
            f"the tube would flatten: curvature {kappa[worst]:.3g} 1/m costs it about {loss:.1%} of its "
            f"moment (Brazier; above {SHAPE_LIMIT:.0%}), which sections of {rod.element.name} cannot show; "
            "a tube collapses when a third is lost"
        )


def _anticlastic(rod: RodModel, places: _Places) -> Iterator[str]:
    """Strips curve across as well, and are stiffer by nu^2 x/(1 + (1 - nu^2) x), x = (w^2 kappa/h)^2/31.

    h height in the plane of bending, w width. From E I of a narrow beam to E I/(1 - nu^2) of a plate (Searle;
    Ashwell 1950).
    """
    sections, nu, curvatures = places.of(Rectangle, Ellipse)
    if not sections:
        return
    side_y, side_z = 2.0 * np.abs([section.outline(4) for section in sections]).max(axis=1).T
    kappa_y, kappa_z = np.abs(curvatures).T
    ratios = np.maximum(side_z**2 * kappa_z / side_y, side_y**2 * kappa_y / side_z)
    x = ratios**2 / ANTICLASTIC
    gains = nu**2 * x / (1.0 + (1.0 - nu**2) * x)
    worst = int(np.argmax(gains))
    ratio, gain = ratios[worst], gains[worst]
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
