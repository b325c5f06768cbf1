r"""How much the radius of a chamber under pressure grows beyond what sections of straight vectors show.

A hole of radius a in a disc of radius b grows under the pressure p by (Lame, plane stress, small strain)

    s(b) = p/E [(b^2 + a^2)/(b^2 - a^2) + nu]

where it is in the middle. Off the middle the thinnest wall h gives way: the growth lies between that of the
disc and that of a ring of this wall, and is their geometric mean within 6 % (plane finite elements, walls
down to a tenth of the radius; tests/unit/test_chamber_swelling.py),

    s = sqrt(s(b) s(a + h)).

Linear sections widen as a whole, by (1 - nu) p A_c/(E A), which does not count. The force of a chamber is its
pressure times its area, hence larger by (1 + s)^2. Walls that fibres hold do not grow.
"""

from __future__ import annotations

import math

import numpy as np

from ancf.hyperelastic import Law
from ancf.scene import Pressure, Rod
from ancf.sections import Annulus, Circle, Section


def swelling(section: Section, chamber: Pressure, law: Law) -> float | None:
    """Relative growth of a chamber's radius that a section leaves out; None unless it is round.

    inf where the chamber has no wall.
    """
    if not isinstance(section, Circle | Annulus):
        return None
    outer, offset, hole = section.radius, float(np.linalg.norm(chamber.centre)), chamber.radius
    if isinstance(section, Annulus):  # the pressure is that in the bore
        offset, hole = 0.0, max(section.inner_radius, chamber.radius)
    wall = outer - hole - offset
    if wall <= 0.0:
        return math.inf
    strain, nu = chamber.value / law.young_modulus, law.poisson_ratio
    ratios = [(b**2 + hole**2) / (b**2 - hole**2) + nu for b in (outer, hole + wall)]
    shown = (1.0 - nu) * math.pi * chamber.radius**2 / section.area
    return strain * (math.sqrt(ratios[0] * ratios[1]) - shown)


def largest_swelling(rod: Rod, chamber: Pressure) -> float | None:
    """The largest along a chamber, at three places of each segment; None unless all sections are round."""
    found = []
    for part, begin, end in zip(rod.parts, rod.ends[:-1], rod.ends[1:], strict=True):
        first, last = max(begin, chamber.start), min(end, chamber.end)
        if first < last:
            places = np.linspace(first, last, 3)
            sections = [part.section_at(float((at - begin) / (end - begin))) for at in places]
            found += [swelling(section, chamber, part.material) for section in sections]
    known = [one for one in found if one is not None]
    return max(known, key=abs) if len(known) == len(found) else None
