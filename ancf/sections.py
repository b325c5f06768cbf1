"""Cross-sections of a rod: quadrature exact for polynomials, area and second moments.

A section lives in the plane (y, z) of its rod, with its centroid on the axis.

Symbols
-------
A          area [m2]
I_y, I_z   second moments int z^2 dA, int y^2 dA [m4]; bending about y, about z
I_yz       product moment int y z dA [m4], zero for every shape here but the polygon
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.quadrature import gauss, points_for_degree

Floats = NDArray[np.float64]


class Section(ABC):
    """A cross-section: `quadrature`, `outline` and the moments that follow from them."""

    @abstractmethod
    def quadrature(self, degree: int) -> tuple[Floats, Floats, Floats]:
        """Points y, z (n,) [m] and weights (n,) [m2], exact for polynomials in y, z up to `degree`."""

    @abstractmethod
    def outline(self, points: int = 48) -> Floats:
        """Points (n, 2) [m] around the outer boundary, counter-clockwise, not closed."""

    def moment(self, power_y: int, power_z: int) -> float:
        """Integral of y^power_y z^power_z over the section [m^(2 + power_y + power_z)]."""
        y, z, weight = self.quadrature(power_y + power_z)
        return float(np.sum(weight * y**power_y * z**power_z))

    @cached_property
    def area(self) -> float:
        """A [m2]."""
        return self.moment(0, 0)

    @cached_property
    def second_moments(self) -> Floats:
        """Symmetric matrix (2, 2) [m4] of int (y, z) (y, z)^T dA = [[I_z, I_yz], [I_yz, I_y]]."""
        return np.array([[self.moment(2, 0), self.moment(1, 1)], [self.moment(1, 1), self.moment(0, 2)]])

    @cached_property
    def principal_second_moments(self) -> Floats:
        """Principal second moments (2,) [m4], the smaller first."""
        return np.asarray(np.linalg.eigvalsh(self.second_moments), dtype=float)

    @cached_property
    def weaker_second_moment(self) -> float:
        """Smaller principal second moment [m4]."""
        return float(self.principal_second_moments[0])

    @cached_property
    def radius_of_gyration(self) -> float:
        """sqrt(I / A) of the weaker bending axis [m]."""
        return float(np.sqrt(self.weaker_second_moment / self.area))

    @cached_property
    def outer_radius(self) -> float:
        """Largest distance of a boundary point from the axis [m]."""
        return float(np.max(np.hypot(*self.outline().T)))

    @abstractmethod
    def contains(self, y: float, z: float, tolerance: float = 1e-9) -> bool:
        """Whether the point (y, z) [m] lies in the section or on its boundary."""


def _disc_quadrature(degree: int, radius: float, inner_radius: float) -> tuple[Floats, Floats, Floats]:
    """Exact rule on a disc or annulus in (r, theta), int f r dr dtheta (paper eq. 42).

    With t = r^2 every monomial that survives the angular sum is a polynomial in t: Gauss in t, and more than
    `degree` equal angles, which integrate cos(k theta) exactly for k up to `degree`. Their number is a
    multiple of four, so that the rule has the mirrors and quarter turns of the section: the energy of rubber
    is no polynomial and would show the lack of one as an asymmetry of 1e-7.
    """
    xi, weight_t = gauss(points_for_degree(max(degree // 2, 1)))
    t_low, t_high = inner_radius**2, radius**2
    r = np.sqrt(0.5 * (t_low + t_high) + 0.5 * (t_high - t_low) * xi)
    angles = 4 * (degree // 4 + 1)
    theta = 2.0 * np.pi * (np.arange(angles) + 0.5) / angles
    weight = 0.25 * (t_high - t_low) * weight_t * (2.0 * np.pi / angles)
    y = np.outer(r, np.cos(theta)).ravel()
    z = np.outer(r, np.sin(theta)).ravel()
    return y, z, np.repeat(weight, angles)


@dataclass(frozen=True)
class Circle(Section):
    """A disc of given radius [m]."""

    radius: float

    def quadrature(self, degree: int) -> tuple[Floats, Floats, Floats]:
        """See `Section.quadrature`."""
        return _disc_quadrature(degree, self.radius, 0.0)

    def outline(self, points: int = 48) -> Floats:
        """See `Section.outline`."""
        angle = 2.0 * np.pi * np.arange(points) / points
        return self.radius * np.column_stack([np.cos(angle), np.sin(angle)])

    def contains(self, y: float, z: float, tolerance: float = 1e-9) -> bool:
        """See `Section.contains`."""
        return bool(np.hypot(y, z) <= self.radius * (1.0 + tolerance))


@dataclass(frozen=True)
class Annulus(Section):
    """A ring between inner and outer radius [m]."""

    radius: float
    inner_radius: float

    def quadrature(self, degree: int) -> tuple[Floats, Floats, Floats]:
        """See `Section.quadrature`."""
        return _disc_quadrature(degree, self.radius, self.inner_radius)

    def outline(self, points: int = 48) -> Floats:
        """See `Section.outline`."""
        return Circle(self.radius).outline(points)

    def contains(self, y: float, z: float, tolerance: float = 1e-9) -> bool:
        """See `Section.contains`; the bore does not belong to the section."""
        distance = np.hypot(y, z)
        return bool(self.inner_radius * (1.0 - tolerance) <= distance <= self.radius * (1.0 + tolerance))


@dataclass(frozen=True)
class Ellipse(Section):
    """An ellipse with semi-axes along y and z [m]."""

    semi_axis_y: float
    semi_axis_z: float

    def quadrature(self, degree: int) -> tuple[Floats, Floats, Floats]:
        """See `Section.quadrature`: the unit disc, stretched."""
        y, z, weight = _disc_quadrature(degree, 1.0, 0.0)
        return self.semi_axis_y * y, self.semi_axis_z * z, self.semi_axis_y * self.semi_axis_z * weight

    def outline(self, points: int = 48) -> Floats:
        """See `Section.outline`."""
        return Circle(1.0).outline(points) * (self.semi_axis_y, self.semi_axis_z)

    def contains(self, y: float, z: float, tolerance: float = 1e-9) -> bool:
        """See `Section.contains`."""
        return bool(np.hypot(y / self.semi_axis_y, z / self.semi_axis_z) <= 1.0 + tolerance)


@dataclass(frozen=True)
class Rectangle(Section):
    """A rectangle, `height_y` along y and `width_z` along z [m]."""

    height_y: float
    width_z: float

    def quadrature(self, degree: int) -> tuple[Floats, Floats, Floats]:
        """See `Section.quadrature`: a tensor Gauss rule."""
        xi, weight = gauss(points_for_degree(degree))
        y, z = np.meshgrid(0.5 * self.height_y * xi, 0.5 * self.width_z * xi, indexing="ij")
        area_weight = 0.25 * self.height_y * self.width_z * np.outer(weight, weight)
        return y.ravel(), z.ravel(), area_weight.ravel()

    def outline(self, points: int = 48) -> Floats:
        """See `Section.outline`: the four corners, whatever `points` is."""
        y, z = 0.5 * self.height_y, 0.5 * self.width_z
        return np.array([[y, -z], [y, z], [-y, z], [-y, -z]])

    def contains(self, y: float, z: float, tolerance: float = 1e-9) -> bool:
        """See `Section.contains`."""
        return bool(
            2.0 * abs(y) <= self.height_y * (1.0 + tolerance)
            and 2.0 * abs(z) <= self.width_z * (1.0 + tolerance)
        )


@dataclass(frozen=True)
class Polygon(Section):
    """A simple polygon, corners (y, z) [m] counter-clockwise; moved so that its centroid is the origin."""

    points: tuple[tuple[float, float], ...]

    @cached_property
    def corners(self) -> Floats:
        """Corners (n, 2) [m] relative to the centroid."""
        p = np.asarray(self.points, dtype=float)
        p = p - p[0]  # differences first: a polygon far from its origin keeps its digits
        following = np.roll(p, -1, axis=0)
        cross = p[:, 0] * following[:, 1] - following[:, 0] * p[:, 1]
        centroid = ((p + following) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())
        return p - centroid

    def quadrature(self, degree: int) -> tuple[Floats, Floats, Floats]:
        """See `Section.quadrature`: a fan of triangles from the centroid.

        On a polygon that is not star-shaped some triangles count negatively; the sum is exact all the same
        because the integrand is one polynomial over the whole plane.
        """
        a = self.corners
        b = np.roll(a, -1, axis=0)
        xi, weight = gauss(points_for_degree(degree + 1))  # + 1: Jacobian of the collapsed square
        u, v = np.meshgrid(0.5 * (1.0 + xi), 0.5 * (1.0 + xi), indexing="ij")
        point = u.ravel()[:, None, None] * (
            (1.0 - v).ravel()[:, None, None] * a + v.ravel()[:, None, None] * b
        )
        twice_area = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
        weights = (0.25 * np.outer(weight, weight) * u).ravel()[:, None] * twice_area
        return point[..., 0].ravel(), point[..., 1].ravel(), weights.ravel()

    def outline(self, points: int = 48) -> Floats:
        """See `Section.outline`: the corners, whatever `points` is."""
        return self.corners.copy()

    def contains(self, y: float, z: float, tolerance: float = 1e-9) -> bool:
        """See `Section.contains` (even-odd rule; points within tolerance of an edge count as inside)."""
        a, b = self.corners, np.roll(self.corners, -1, axis=0)
        edge, to_point = b - a, np.array([y, z]) - a
        along = np.clip(np.sum(edge * to_point, axis=1) / np.sum(edge**2, axis=1), 0.0, 1.0)
        if np.min(np.linalg.norm(to_point - along[:, None] * edge, axis=1)) <= tolerance * self.outer_radius:
            return True
        crosses = (a[:, 1] > z) != (b[:, 1] > z)
        with np.errstate(divide="ignore", invalid="ignore"):
            left = y < a[:, 0] + (z - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
        return bool(np.count_nonzero(crosses & left) % 2)
