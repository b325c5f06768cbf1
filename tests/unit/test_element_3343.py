"""3343: r_yz lets a rectangle warp in torsion, and strains of the section come from the nodes.

Its torsion constant is 4 I_y I_z/(I_y + I_z): .266667 a b^3 on a 2:1 rectangle against .416667 of a linear
section (benchmarks, row TO).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ancf.elements
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.rotation import log
from ancf.scene import Force, Moment, Rod, Scene, Support
from ancf.sections import Circle, Ellipse, Polygon, Rectangle
from ancf.solver import solve
from ancf.validity import poisson_locking
from reference.elastica import elastica_tip_force
from reference.helix import helix_tip_moment

YOUNG, LENGTH = 1e6, 0.4
SVK = SaintVenantKirchhoff(YOUNG, 0.3)


def twist(element: str, section, nu: float = 0.0) -> float:
    """G J [N m2] of a rod of 8 elements from the tip angle under a small torque."""
    rod = Rod("arm", LENGTH, 8, section, SaintVenantKirchhoff(YOUNG, nu), element, supports=(Support(),))
    torque = 1e-9
    solution = solve(Scene((rod,), moments=(Moment("arm", 1.0, np.array([torque, 0.0, 0.0])),)))
    assert solution.status == "converged"
    return torque * LENGTH / log(solution.tip().rotation)[0]


@pytest.mark.parametrize("nu", [0.0, 0.45])
def test_bilinear_section_warps(nu):
    """The clamp restrains warping, so the rod is a little stiffer than the limit."""
    b, G = 0.01, YOUNG / (2 * (1 + nu))
    rectangle = Rectangle(2 * b, b)
    assert twist("3333", rectangle, nu) / (2 * G * b**4) == pytest.approx(5 / 12, rel=1e-6)
    assert twist("3343", rectangle, nu) / (2 * G * b**4) == pytest.approx(4 / 15, rel=2e-2)
    assert twist("3343", Circle(b), nu) / G == pytest.approx(np.pi * b**4 / 2, rel=1e-6)


def test_an_ellipse_twists_as_saint_venant_says():
    """J = pi a^3 b^3/(a^2 + b^2) (Timoshenko and Goodier, art. 106); clamp as above, and no warning."""
    a, b = 0.012, 0.006
    exact = np.pi * a**3 * b**3 / (a**2 + b**2)
    assert twist("3343", Ellipse(a, b)) / (YOUNG / 2) == pytest.approx(exact, rel=2e-2)
    for element, warned in (("3333", True), ("3343", False)):
        rod = Rod("arm", LENGTH, 8, Ellipse(a, b), SVK, element)
        found = solve(Scene((rod,), moments=(Moment("arm", 1.0, np.array([1e-5, 0.0, 0.0])),)))
        assert any("torsion" in text for text in found.warnings) == warned


def test_bending_is_that_of_3333_where_nothing_locks():
    """A small angle, nu = 0: warping and strains of the section do not take part."""
    tips = []
    for element in ("3333", "3343"):
        rod = Rod("arm", LENGTH, 8, Rectangle(0.01, 0.01), SaintVenantKirchhoff(YOUNG, 0.0), element)
        moment = np.array([0.0, 0.0, 1e-3 * YOUNG * 1e-8 / 12 / LENGTH])
        tips.append(solve(Scene((rod,), moments=(Moment("arm", 1.0, moment),))).tip().position)
    assert tips[0] == pytest.approx(tips[1], abs=1e-10)


@pytest.mark.parametrize(
    ("slenderness", "elements", "bound"), [(200, 12, 5e-4), (500, 12, 5e-4), (500, 24, 1e-4)]
)
def test_tip_error_of_slender_rods(slenderness, elements, bound):
    """Issue 5, NUMBERS: P L^2/EI = 10 and |M| L/EI = 2.5 against the thin rod; at L/R = 200 and 24 elements
    finite strain alone leaves 1.3e-4 and 2.1e-4.
    """
    radius = 1.0 / slenderness
    EI = YOUNG * np.pi * radius**4 / 4
    rod = Rod("arm", 1.0, elements, Circle(radius), SVK, "3343")
    force = solve(Scene((rod,), forces=(Force("arm", 1.0, np.array([0.0, 10 * EI, 0.0])),))).tip().position
    thin = elastica_tip_force(10.0)
    assert np.linalg.norm(force - [1 - thin.u, thin.w, 0.0]) <= bound
    v = 2.5 * np.array([0.6, 0.5, -0.8]) / np.linalg.norm([0.6, 0.5, -0.8])
    moment = solve(Scene((rod,), moments=(Moment("arm", 1.0, EI * v),))).tip().position
    exact = helix_tip_moment(EI * v, 1.0, EI, EI / 1.3, [1.0])
    assert np.linalg.norm(moment - exact.position[0]) <= bound


def test_the_mesh_error_falls_with_order_four_at_any_slenderness():
    """Against 48 elements, P L^2/EI = 10: 4 to 12 elements; the error does not depend on L/R."""
    errors = {}
    for slenderness in (500, 2000):
        radius = 1.0 / slenderness
        EI = YOUNG * np.pi * radius**4 / 4
        rod = Rod("arm", 1.0, 48, Circle(radius), SVK, "3343")
        load = (Force("arm", 1.0, np.array([0.0, 10 * EI, 0.0])),)
        tips = [solve(Scene((replace(rod, elements=n),), forces=load)).tip().position for n in (4, 6, 12, 48)]
        errors[slenderness] = [float(np.linalg.norm(tip - tips[-1])) for tip in tips[:-1]]
        assert np.log(errors[slenderness][0] / errors[slenderness][2]) / np.log(3.0) > 3.8
    assert np.all(np.array(errors[2000]) < 2.0 * np.array(errors[500]))
    assert errors[2000][2] < 1e-5


def test_a_numbered_rule_takes_every_strain_at_its_points():
    """`axial_rule` as a number, or full, means compatible strains: with the default's number of points the
    3333 of the same mesh bends alike (r_yz takes no part at nu = 0).
    """
    tips = []
    for element, rule in (("3333", "default"), ("3343", 2), ("3343", "default")):
        radius = 1.0 / 500
        EI = YOUNG * np.pi * radius**4 / 4
        law = SaintVenantKirchhoff(YOUNG, 0.0)
        rod = Rod("arm", 1.0, 6, Circle(radius), law, element, axial_rule=rule)
        load = (Force("arm", 1.0, np.array([0.0, 10 * EI, 0.0])),)
        tips.append(solve(Scene((rod,), forces=load)).tip().position)
    assert tips[0] == pytest.approx(tips[1], abs=1e-6)
    assert np.linalg.norm(tips[1] - tips[2]) > 1e-3  # what locking was left


def test_constant_strain_of_a_skew_section_loads_r_yz_rightly():
    """On an angle int y z dA != 0: a stretch by the end tractions of a uniform state is an equilibrium."""
    angle = Polygon(((0.0, 0.0), (0.02, 0.0), (0.02, 0.005), (0.005, 0.005), (0.005, 0.02), (0.0, 0.02)))
    rod = Rod("arm", LENGTH, 3, angle, SVK, "3343")
    elastic = Model(Scene((rod,))).rods[0].elastic
    F = np.diag([1.02, 0.99, 0.99])
    Q = elastic.force(elastic.e0 @ F.T)
    S = SVK.hooke()[0] @ [*(0.5 * (np.diag(F) ** 2 - 1.0)), 0.0, 0.0, 0.0]
    product = float(angle.second_moments[0, 1])
    assert abs(product) > 1e-10
    # r_yz' carries P_xx int y z dA; its shape functions are those of r (column 0).
    np.testing.assert_allclose(Q[0, [3, -1], 0] / Q[0, [0, -4], 0], product / angle.area, rtol=1e-9)
    np.testing.assert_allclose(Q[0, -4, 0], 1.02 * S * angle.area, rtol=1e-9)


@pytest.mark.parametrize("nu", [0.3, 0.45])
def test_what_is_left_of_poisson_locking_under_the_full_law(nu):
    """r_yz follows half of the lateral field: EI_eff/EI from the energy minimum in `poisson_locking`, about
    both axes the worse; the clamp, which holds r_yz, adds some 0.3 %.
    """
    height, width = 0.01, 0.02
    ratios = []
    for axis, (h, w) in ((2, (height, width)), (1, (width, height))):
        EI = YOUNG * w * h**3 / 12
        rod = Rod(
            "arm", LENGTH, 8, Rectangle(height, width), SaintVenantKirchhoff(YOUNG, nu), "3343", "continuum"
        )
        moment = np.zeros(3)
        moment[axis] = 1e-4 * EI / LENGTH
        found = solve(Scene((rod,), moments=(Moment("arm", 1.0, moment),)))
        ratios.append(1e-4 / log(found.tip().rotation)[axis])
    assert max(ratios) == pytest.approx(poisson_locking(nu, Rectangle(height, width)), rel=5e-3)
    assert max(ratios) < poisson_locking(nu)


def test_the_element_is_the_published_one():
    """Three nodes with r, r_y, r_z, r_yz (benchmarks.md, TO: "with a yz term")."""
    element = ancf.elements.ELEMENTS["3343"]
    assert element.node_xi == (-1.0, 0.0, 1.0)
    assert element.vectors == ((0, 0, 0), (0, 1, 0), (0, 0, 1), (0, 1, 1))
    assert element.assumed == (("section", element.node_xi),)
