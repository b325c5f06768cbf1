r"""Segments: what a rod is made of along its length, each piece with one material and one shape of section.

The dimensions of a tapered segment (radius, semi-axes, sides, corners) run linearly from `section` to
`section_end`. The nodal vectors r_y, r_z stay unit vectors, so (y, z) are metres in the section that is
really there, and J_0 is that of a prismatic rod: a taper enters only through the section over which energy
and weight are integrated. The inclination s of its skin does not enter: sections stay plane although an
inclined skin without traction asks for curved ones, which makes the rod too stiff in bending by about s^2.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.hyperelastic import Law
from ancf.quadrature import gauss
from ancf.sections import Polygon, Section

Floats = NDArray[np.float64]

# Wedge of half-angle a (slope s = tan a) under a couple, plane stress, exact (Timoshenko, Goodier, Theory of
# Elasticity, 3rd ed., art. 38): s_r = 2 M sin 2t/(r^2 (sin 2a - 2 a cos 2a)). The energy of s_r per length
# over M^2/(2 E I(x)) is (8/3) tan^3 a (a - sin(4 a)/4)/(sin 2a - 2 a cos 2a)^2 = 1 + s^2 + O(s^4).
STEEP = 0.1  # slope from which a warning is worth it: 1 % of bending stiffness
# Points of the compliance integral: exact to 1e-6 at a taper of 10:1, where the integrand is 1/x^4.
COMPLIANCE_POINTS = 24


def between(start: Section, end: Section, fraction: float) -> Section:
    """Section whose dimensions lie linearly between those of two sections of one shape, at 0 to 1."""
    if fraction <= 0.0 or start == end:
        return start
    if fraction >= 1.0:
        return end
    # Not a + t (b - a): this form is exact at both ends and the same read from either of them.
    mix = lambda a, b: (1.0 - fraction) * a + fraction * b  # noqa: E731
    if isinstance(start, Polygon) and isinstance(end, Polygon):
        corners = zip(start.points, end.points, strict=True)
        return Polygon(tuple((mix(a[0], b[0]), mix(a[1], b[1])) for a, b in corners))
    names = [field.name for field in fields(start)]  # pyright: ignore[reportArgumentType]
    return type(start)(*(mix(getattr(start, name), getattr(end, name)) for name in names))


@dataclass(frozen=True)
class Segment:
    """A piece of a rod: length [m], number of elements, section, material."""

    length: float
    elements: int
    section: Section
    material: Law
    section_end: Section | None = None  # absent: prismatic

    @property
    def last_section(self) -> Section:
        """The section at the end."""
        return self.section_end or self.section

    @property
    def tapered(self) -> bool:
        """Whether the section changes along the segment."""
        return self.last_section != self.section

    def section_at(self, fraction: float) -> Section:
        """The section at a fraction of the segment's length."""
        return between(self.section, self.last_section, fraction)

    @cached_property
    def bending_compliance(self) -> float:
        """int dx/(E I) [1/(N m)] about the weaker axis of each section."""
        young = self.material.young_modulus
        if not self.tapered:
            return self.length / (young * self.section.weaker_second_moment)
        xi, weight = gauss(COMPLIANCE_POINTS)
        second = [self.section_at(0.5 * (1.0 + s)).weaker_second_moment for s in xi]
        return 0.5 * self.length * float(weight @ (1.0 / (young * np.array(second))))

    @cached_property
    def slope(self) -> float:
        """Largest inclination of the skin against the axis [-]."""
        if not self.tapered:
            return 0.0
        sides = [
            s.corners if isinstance(s, Polygon) else s.outline(4) for s in (self.section, self.last_section)
        ]
        change = float(np.max(np.abs(sides[1] - sides[0])))
        bores = [getattr(s, "inner_radius", 0.0) for s in (self.section, self.last_section)]
        return max(change, abs(bores[1] - bores[0])) / self.length


def starts(segments: tuple[Segment, ...]) -> Floats:
    """Where the segments begin, and where the last one ends (n + 1,) [m]."""
    return np.concatenate([[0.0], np.cumsum([segment.length for segment in segments])])
