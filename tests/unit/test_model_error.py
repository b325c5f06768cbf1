"""Known errors of sections against the solid: single numbers, and the tip that they move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ancf
from ancf.error_estimate import estimate_error
from ancf.hyperelastic import NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.model_error import model_errors, relative_defect
from ancf.refinement import first_mesh
from ancf.scene import Force, Moment, Rod, Scene, Support
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle
from ancf.segments import Segment

E = 1e6
SVK, RUBBER = SaintVenantKirchhoff(E, 0.3), NeoHookean(E, 0.49)


def defect(element: str, section, law=SVK, formulation: str = "enhanced", curvature=(0.0, 0.0, 0.0)):
    """dm/m under the moment of a thin rod with these curvatures (twist, about y, about z)."""
    I_z, I_y = np.diag(section.second_moments)
    G = E / (2.0 * (1.0 + law.poisson_ratio))
    moment = np.array(curvature) * [G * (I_y + I_z), E * I_y, E * I_z]
    return relative_defect(element, formulation, section, law, moment)


@pytest.mark.parametrize(
    ("element", "law", "c"),
    # c of the element less the exact one (reference/section.py; tables of the module)
    [("3333", SVK, 0.924 - 1.505), ("3363", SVK, 1.444 - 1.505), ("3333", RUBBER, 0.619 - 0.369)],
)
def test_bending_of_a_disc(element, law, c):
    found = defect(element, Circle(0.02), law, curvature=(0.0, 3.0, 4.0))
    np.testing.assert_allclose(found, [0.0, c * 0.01, c * 0.01], atol=1e-12)  # kappa R = 0.1


def test_twist_adds_to_the_error_of_bending():
    """0.1 (t R)^2 on top of what bending does, and with its sign: .924 - 1.505, .619 - .369 (tables)."""
    found = defect("3333", Circle(0.02), curvature=(10.0, 0.0, 5.0))
    assert found[2] == pytest.approx(-0.581 * 0.1**2 - 0.1 * 0.2**2)
    soft = defect("3333", Circle(0.02), RUBBER, curvature=(10.0, 0.0, 5.0))
    assert soft[2] == pytest.approx(0.250 * 0.1**2 + 0.1 * 0.2**2)


def test_half_the_height_stands_for_the_radius_of_a_strip():
    """4 I/A is (h/2)^2 4/3 for a rectangle."""
    found = defect("3333", Rectangle(0.04, 0.02), replace(SVK, poisson_ratio=0.0), curvature=(0.0, 0.0, 2.5))
    assert found[2] == pytest.approx((1.374 - 1.499) * 0.05**2 * 4.0 / 3.0)


@pytest.mark.parametrize(
    ("element", "section", "ratio"),
    [
        ("3333", Circle(1.0), 1.0),
        ("3333", Annulus(1.0, 0.5), 1.0),
        ("3333", Ellipse(2.0, 1.0), 4 * 2 * 8 / (2 + 8) ** 2),  # pi a^3 b^3/(a^2 + b^2) over I_p
        ("3363", Ellipse(2.0, 1.0), 1.0),
        ("3333", Rectangle(1.0, 1.0), 0.140577 * 6.0),  # shared/benchmarks.md, TO
        ("3363", Rectangle(2.0, 1.0), 0.22868 * 2 / (0.266667 * 2)),  # the same, 2:1
    ],
)
def test_torsion_is_against_saint_venant(element, section, ratio):
    assert 1.0 + defect(element, section)[0] == pytest.approx(ratio, rel=6e-3)


def test_torsion_of_a_polygon_is_saint_venants_rule():
    """Equilateral triangle of side 1: J = sqrt(3)/80 (Timoshenko), I_p = sqrt(3)/48."""
    triangle = Polygon(((0.0, 0.0), (1.0, 0.0), (0.5, np.sqrt(3) / 2)))
    assert 1.0 + defect("3333", triangle)[0] == pytest.approx(48.0 / 80.0, rel=0.13)


def test_the_continuum_of_linear_sections_locks():
    """(1 - nu)/((1 + nu)(1 - 2 nu)) = 1.3462 at 0.3 (shared/theory.md 3)."""
    assert 1.0 / (1.0 + defect("3333", Circle(1.0), formulation="continuum")[2]) == pytest.approx(
        1.3462, rel=1e-4
    )
    assert abs(defect("3363", Circle(1.0), formulation="continuum")[2]) < 1e-12


def test_tubes_flatten_and_strips_curve_across():
    tube = defect("3363", Annulus(0.011, 0.009), curvature=(0.0, 0.0, 2.0))
    # Brazier: 1.5 (1 - nu^2)(kappa r^2/t)^2 with r = 0.01, t = 0.002
    assert tube[2] == pytest.approx(-1.5 * 0.91 * 0.1**2, rel=0.13)
    strip = defect("3333", Rectangle(0.002, 0.05), curvature=(0.0, 0.0, 10.0))
    assert 0.05 < strip[2] < 0.3**2 / 0.91  # on the way from E I to E I/(1 - nu^2)
    assert defect("3363", Rectangle(0.002, 0.05), curvature=(0.0, 0.0, 10.0))[2] == pytest.approx(
        0.0, abs=1e-4
    )


def tips(rod: Rod, names: tuple[str, ...] = ("3333", "3363"), **loads) -> dict[str, float]:
    """Model errors of the tip of one rod."""
    solution = ancf.solve(first_mesh(Scene((rod,), **loads), 1e-5))
    found = estimate_error(solution)
    assert found is not None
    return model_errors(found, names)[0]


def test_the_tip_of_a_bent_rod_moves_by_its_change_of_turn():
    """d r/d theta of a circular arc, times theta and dm/m; theta = pi/2: |d r/d theta| = .4668 L."""
    R = 1e-3
    moment = E * np.pi * R**4 / 4.0 * np.pi / 2
    errors = tips(
        Rod("rod", 1.0, 0, Circle(R), SVK), moments=(Moment("rod", 1.0, np.array([0.0, 0, moment])),)
    )
    strain = (np.pi / 2 * R) ** 2
    slope = np.hypot(2 / np.pi * 2 / np.pi, 2 / np.pi - 4 / np.pi**2)
    assert errors["3333"] == pytest.approx((1.505 - 0.924) * strain * np.pi / 2 * slope, rel=1e-3)
    assert errors["3363"] == pytest.approx((1.505 - 1.444) * strain * np.pi / 2 * slope, rel=1e-3)


def test_it_makes_no_difference_which_element_found_the_shape():
    """A rod of 3363 has the continuum, which is not what a 3333 in its place would have."""
    R = 1e-3
    loads = (Moment("rod", 1.0, np.array([0.0, 0.0, E * np.pi * R**4 / 4.0])),)
    rod = Rod("rod", 1.0, 0, Circle(R), SVK, supports=(Support(0.0, "free_section_clamp"),))
    linear = tips(rod, moments=loads)
    quadratic = tips(replace(rod, element="3363", formulation=""), moments=loads)
    assert quadratic == pytest.approx(linear, rel=1e-3)


def test_a_steep_taper_is_too_stiff_by_its_slope_squared():
    """The tip under a small couple: w = int M (L - x)/(E I) dx, so dw/w is the mean of s^2."""
    segment = Segment(1.0, 0, Circle(0.2), SVK, Circle(0.1))
    rod = Rod.of_segments("rod", (segment,))
    moment = (Moment("rod", 1.0, np.array([0.0, 0.0, 1e-3])),)
    solution = ancf.solve(first_mesh(Scene((rod,), moments=moment), 1e-5))
    deflection = solution.tip().position[1]
    assert tips(rod, moments=moment)["3333"] == pytest.approx(0.1**2 * deflection, rel=1e-2)


def test_a_dead_force_holds_its_tip():
    """Stretched by 100 E I/L^2 the same defect moves the tip much less than without the pull."""
    rod = Rod("rod", 1.0, 0, Circle(1e-3), SVK, supports=(Support(0.0, "free_section_clamp"),))
    unit = E * np.pi * 1e-12 / 4.0
    bend = (Moment("rod", 1.0, np.array([0.0, 0.0, unit])),)
    free, pulled = (
        tips(rod, moments=bend, forces=forces)["3333"]
        for forces in ((), (Force("rod", 1.0, np.array([100.0 * unit, 0.0, 0.0])),))
    )
    assert 0.0 < pulled < 0.05 * free
