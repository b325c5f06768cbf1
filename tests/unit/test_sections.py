"""Section quadrature against closed-form moments."""

from math import gamma, pi

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle
from tests.strategies import sections

POWERS = [(p, q) for p in range(9) for q in range(9) if p + q <= 8]


def disc_moment(p, q):
    """Integral of y^p z^q over the unit disc: 2 G((p+1)/2) G((q+1)/2) / (G((p+q)/2 + 1) (p+q+2)), 0 if a
    power is odd.

    Polar coordinates and the beta function (Abramowitz, Stegun 6.2.1).
    """
    if p % 2 or q % 2:
        return 0.0
    return 2.0 * gamma((p + 1) / 2) * gamma((q + 1) / 2) / (gamma((p + q) / 2 + 1) * (p + q + 2))


def segment_moment(p, length):
    """Integral of y^p over [-length/2, length/2]."""
    return 0.0 if p % 2 else 2.0 * (length / 2) ** (p + 1) / (p + 1)


def green_moment(corners, p, q):
    """Integral of y^p z^q over a polygon as the boundary integral of y^(p+1) z^q dz / (p+1), edge by edge
    (Green).
    """
    t, w = np.polynomial.legendre.leggauss(12)
    total = 0.0
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        y, z = (0.5 * (a[i] + b[i]) + 0.5 * (b[i] - a[i]) * t for i in (0, 1))
        total += np.sum(w * y ** (p + 1) * z**q) * 0.5 * (b[1] - a[1]) / (p + 1)
    return total


SHAPES = [
    (Circle(1.3), lambda p, q: 1.3 ** (p + q + 2) * disc_moment(p, q)),
    (Annulus(1.3, 0.7), lambda p, q: (1.3 ** (p + q + 2) - 0.7 ** (p + q + 2)) * disc_moment(p, q)),
    (Ellipse(1.3, 0.7), lambda p, q: 1.3 ** (p + 1) * 0.7 ** (q + 1) * disc_moment(p, q)),
    (Rectangle(1.3, 0.7), lambda p, q: segment_moment(p, 1.3) * segment_moment(q, 0.7)),
]


@pytest.mark.parametrize(("section", "exact"), SHAPES, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize(("p", "q"), POWERS)
def test_moments_of_the_shapes_are_exact(section, exact, p, q):
    assert section.moment(p, q) == pytest.approx(exact(p, q), rel=1e-13, abs=1e-14)


@given(sections("polygon"))
def test_moments_of_polygons_are_greens(section):
    for p, q in POWERS:
        exact = green_moment(section.corners, p, q)
        assert section.moment(p, q) == pytest.approx(exact, rel=1e-11, abs=1e-13 * section.area)


def test_moments_of_a_polygon_that_is_not_convex():
    """L-shape 2 x 2 with legs 0.5: area and second moments from two rectangles (parallel axes)."""
    angle = Polygon(((0, 0), (2, 0), (2, 0.5), (0.5, 0.5), (0.5, 2), (0, 2)))
    area = 2 * 0.5 + 0.5 * 1.5
    centre = (2 * 0.5 * 1.0 + 0.5 * 1.5 * 0.25) / area  # same for y and z
    first = 0.5 * 2**3 / 12 + 1.0 * (1.0 - centre) ** 2 + 1.5 * 0.5**3 / 12 + 0.75 * (0.25 - centre) ** 2
    product = 1.0 * (1.0 - centre) * (0.25 - centre) + 0.75 * (0.25 - centre) * (1.25 - centre)
    assert angle.area == pytest.approx(area, rel=1e-14)
    np.testing.assert_allclose(angle.second_moments, [[first, product], [product, first]], rtol=1e-13)


def test_a_polygon_drawn_far_away_keeps_its_digits():
    """Differences of the corners come first: coordinates that float64 holds exactly lose nothing."""
    corners = np.array([(0.0, 0.0), (2.0, 0.0), (2.5, 1.0), (0.0, 1.5)])
    near, far = (
        Polygon(tuple(map(tuple, corners + shift))) for shift in (0.0, 2.0**40)
    )  # exactly representable
    np.testing.assert_allclose(far.corners, near.corners, atol=1e-15)
    np.testing.assert_allclose(far.second_moments, near.second_moments, rtol=1e-14)


def test_second_moments_name_the_axes():
    """[[int y^2, int y z], [int y z, int z^2]]: a rectangle tall in y is stiff about z, h^3 w / 12."""
    tall = Rectangle(0.3, 0.1)
    np.testing.assert_allclose(
        tall.second_moments, np.diag([0.3**3 * 0.1 / 12, 0.3 * 0.1**3 / 12]), rtol=1e-13, atol=1e-18
    )
    assert Circle(2.0).second_moments[0, 0] == pytest.approx(pi * 2.0**4 / 4, rel=1e-14)


@given(sections())
def test_the_centroid_is_on_the_axis(section):
    assert abs(section.moment(1, 0)) < 1e-12 * section.area
    assert abs(section.moment(0, 1)) < 1e-12 * section.area


@given(sections(), st.integers(0, 6))
def test_a_rule_of_lower_degree_gives_the_same_moments(section, degree):
    """The rule for degree n is exact for all degrees up to n: compare with the rule for 16."""
    for p in range(degree + 1):
        q = degree - p
        y, z, w = section.quadrature(degree)
        Y, Z, W = section.quadrature(16)
        fine = np.sum(W * Y**p * Z**q)
        assert np.sum(w * y**p * z**q) == pytest.approx(fine, rel=1e-10, abs=1e-12 * section.area)


@pytest.mark.parametrize("section", [Circle(1.0), Annulus(1.0, 0.6), Ellipse(2.0, 1.0), Rectangle(2.0, 1.0)])
@pytest.mark.parametrize("degree", [2, 4, 7, 8, 16])
def test_the_rule_has_the_mirrors_of_the_section(section, degree):
    """Else a rod of rubber leaves the plane of its load: by 5e-8 L with nine angles on a circle."""
    rule = np.column_stack(section.quadrature(degree))
    turned = rule[:, [1, 0, 2]] * [-1, 1, 1]
    quarter = [turned] if isinstance(section, Circle | Annulus) else []
    for image in [rule * [-1, 1, 1], rule * [1, -1, 1], *quarter]:
        gaps = np.abs(image[:, None] - rule).max(axis=2)
        assert gaps.min(axis=1).max() < 1e-14


@given(sections())
def test_points_weights_and_outline_belong_together(section):
    _, _, w = section.quadrature(4)
    assert w.sum() == pytest.approx(section.area, rel=1e-13)
    outline = section.outline(400)
    following = np.roll(outline, -1, axis=0)
    enclosed = 0.5 * np.sum(
        outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]
    )  # > 0: counter-clockwise
    bore = pi * section.inner_radius**2 if isinstance(section, Annulus) else 0.0
    assert enclosed - bore == pytest.approx(section.area, rel=2e-3)  # 400 chords of a circle: 4e-5
    assert section.outer_radius == pytest.approx(np.hypot(*outline.T).max(), rel=1e-12)
    assert all(section.contains(*point) for point in outline)
    assert not any(
        section.contains(*(1.01 * section.outer_radius * np.array([np.cos(a), np.sin(a)]))) for a in range(7)
    )


def test_contains():
    assert Annulus(1.0, 0.5).contains(0.0, 0.7)
    assert not Annulus(1.0, 0.5).contains(0.0, 0.2)
    assert Ellipse(2.0, 1.0).contains(1.9, 0.0)
    assert not Ellipse(2.0, 1.0).contains(0.0, 1.9)
    assert Rectangle(2.0, 1.0).contains(0.99, 0.49)
    assert not Rectangle(2.0, 1.0).contains(0.49, 0.99)
    assert not Rectangle(2.0, 1.0).contains(1.01, 0.0)
    angle = Polygon(((0, 0), (2, 0), (2, 0.5), (0.5, 0.5), (0.5, 2), (0, 2)))
    assert not angle.contains(1.0, 1.0)  # in the notch
    low = angle.corners[0]
    assert angle.contains(low[0] + 0.25, low[1] + 1.5)
    assert angle.contains(low[0] + 1.5, low[1] + 0.25)
