"""Tapered and stepped rods against closed forms of the thin rod: values, orders, jumps along the rod.

Thin rod: curvature M/(E I(x)), stretch N/(E A(x)), integrated by scipy.integrate.quad. The beams are so
slender that what finite thickness adds, about (kappa R)^2, is below the limits.
"""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from ancf.elements import ELEMENTS, SECTION_ELEMENTS
from ancf.hyperelastic import NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.scene import Force, Gravity, Moment, Rod, Scene, Support
from ancf.sections import Circle
from ancf.segments import Segment
from validation.solution_measures import solved

E, NU, DENSITY = 1e6, 0.3, 1000.0
SOFT = SaintVenantKirchhoff(E, NU, DENSITY)
R = 0.005
CLAMP = (Support(),)
FREE = (Support(0.0, "free_section_clamp"),)


def stiffness(radius, modulus=E):
    return modulus * np.pi * radius**4 / 4


def taper(ratio, elements, element="3333", radius=R, material=SOFT, supports=CLAMP):
    """One metre from the radius at the base to the radius over `ratio` at the tip."""
    segment = Segment(1.0, elements, Circle(radius), material, Circle(radius / ratio))
    return Rod.of_segments("rod", (segment,), element=element, supports=supports)


def stepped(moduli, elements, element="3333", radius=R, nu=NU, supports=CLAMP):
    """Half a metre of each modulus."""
    laws = [SaintVenantKirchhoff(modulus, nu, DENSITY) for modulus in moduli]
    pieces = tuple(Segment(0.5, elements, Circle(radius), law) for law in laws)
    return Rod.of_segments("rod", pieces, element=element, supports=supports)


def bent(rod, M):
    """Turn of the tip about z [rad], 0 to 2 pi, and its position in the plane, under a moment M."""
    tip = solved(Scene((rod,), moments=(Moment("rod", 1.0, np.array([0.0, 0.0, M])),))).tip()
    return np.arctan2(tip.rotation[1, 0], tip.rotation[0, 0]) % (2 * np.pi), tip.position[:2]


def arc(curvature, length=1.0):
    """Turn and end of the plane curve with the given curvature(x), from the origin along x."""

    def turn(x):
        return quad(curvature, 0, x, epsrel=1e-12, epsabs=0)[0]

    x, y = (quad(lambda s, f=f: f(turn(s)), 0, length, epsrel=1e-10)[0] for f in (np.cos, np.sin))
    return turn(length), np.array([x, y])


def rates(errors):
    return np.log2(np.abs(errors[:-1]) / np.abs(errors[1:]))


# --- taper -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("ratio", [2.0, 10.0])
def test_deflection_of_a_tapered_cantilever(element, ratio):
    """Small tip force: w = int P (L - x)^2/(E I(x)) dx = P L^3 ratio/(3 E I_base) for a cone, by hand.

    int_0^1 (1-x)^2/(1-cx)^4 dx = 1/(3 (1-c)) with 1 - c = 1/ratio. Shear adds less than (R/L)^2.
    """
    # 3243 bends its elements with one curvature each: second order, here 1e-2 at a taper of 10:1.
    elements, limit = (64, 2e-2) if element == "3243" else (32, 2e-3)
    P = 1e-5 * stiffness(R) / ratio
    rod = taper(ratio, elements, element)
    tip = solved(Scene((rod,), forces=(Force("rod", 1.0, np.array([0.0, P, 0.0])),))).tip().position
    expected = P * ratio / (3 * stiffness(R))
    quadrature = quad(lambda x: P * (1 - x) ** 2 / stiffness(R * (1 - x + x / ratio)), 0, 1)[0]
    assert quadrature == pytest.approx(expected, rel=1e-9)
    assert tip[1] == pytest.approx(expected, rel=limit)


@pytest.mark.parametrize(("element", "order"), [("3333", 4.0), ("3243", 2.0)])
def test_small_turn_of_a_taper_converges_with_the_order_of_the_element(element, order):
    """3333: two Gauss points integrate M/(E I) to fourth order; 3243 to second, one curvature an element."""
    theta, _ = arc(lambda x: 1e-2 / stiffness(R * (1 - 0.5 * x)) * stiffness(R / 2))
    M = 1e-2 * stiffness(R / 2)
    errors = np.array([bent(taper(2.0, n, element), M)[0] - theta for n in (4, 8, 16)])
    assert np.all(np.abs(rates(errors) - order) < 0.2), rates(errors)


# 3243 at 10:1 locks: at the tip it would need elements of a twentieth of the length.
@pytest.mark.parametrize(
    ("element", "ratio", "limit"),
    [
        ("3333", 2.0, 1e-3),
        ("3333", 10.0, 4e-3),
        ("3363", 2.0, 1e-3),
        ("3363", 10.0, 4e-3),
        ("3243", 2.0, 2e-2),
    ],
)
def test_large_turn_of_a_taper(element, ratio, limit):
    """kappa = M/(E I(x)) at any turn; here a quarter circle, most of it near the tip. Finite strain: 1e-4."""
    C = quad(lambda x: 1 / stiffness(R * (1 - x + x / ratio)), 0, 1, epsrel=1e-12)[0]
    M = np.pi / 2 / C
    theta, end = arc(lambda x: M / stiffness(R * (1 - x + x / ratio)))
    errors = []
    for n in (16, 32, 64):
        turn, position = bent(taper(ratio, n, element), M)
        errors.append([abs(turn - theta), np.linalg.norm(position - end)])
    errors = np.array(errors)
    assert errors[-1, 0] < limit
    assert errors[-1, 1] < limit / 5
    # Order two at least on the way there; 2:1 has arrived at the error of thickness with 16 elements.
    if ratio == 10.0 or element == "3243":
        assert np.all(rates(errors[:, 0]) > 2.0), rates(errors[:, 0])


@pytest.mark.parametrize("element", SECTION_ELEMENTS)
@pytest.mark.parametrize("ratio", [1.5, 10.0])
def test_a_hanging_cone_stretches_under_its_weight(element, ratio):
    """u = int_0^1 N/(E A) dx, N = rho g int_x^1 A: a cone by closed form, nu = 0, load too small to matter.

    With A = A_0 a(x)^2, a = 1 - c x, int_x^1 a^2 = (a(x)^3 - a(1)^3)/(3 c).
    """
    c, g = 1 - 1 / ratio, 1e-3
    material = SaintVenantKirchhoff(E, 0.0, DENSITY)

    def strain(x):
        a = 1 - c * x
        return DENSITY * g * (a**3 - (1 - c) ** 3) / (3 * c) / (E * a**2)

    expected = quad(strain, 0, 1)[0]
    by_hand = (
        DENSITY * g / (3 * c * E) * (0.5 * (1 - (1 - c) ** 2) / c - (1 - c) ** 3 * (1 / (1 - c) - 1) / c)
    )
    assert expected == pytest.approx(by_hand, rel=1e-12)
    # Free to strain at the base as well: a clamp holds r_x of 3243.
    rod = taper(ratio, 16, element, R, material, FREE)
    tip = solved(Scene((rod,), gravity=Gravity(np.array([g, 0.0, 0.0])))).tip().position
    assert tip[0] - 1.0 == pytest.approx(expected, rel=2e-4)


# --- steps -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("jump", [10.0, 1e4])
@pytest.mark.parametrize("element", ["3333", "3363"])
def test_a_stepped_rod_bends_to_two_arcs(element, jump):
    """Quarter circle in all; the stiff half takes 1/(1 + jump) of it. Fourth order down to thickness.

    Where quadratic sections bend by unlike curvatures they hold each other's in-plane field, as a clamp does:
    the rod bends as if it were shorter there by some 0.1 R. It is no error of the mesh: half of R halves it.
    """
    theta, radius = np.pi / 2, 0.001
    M = theta / (0.5 / stiffness(radius, E * jump) + 0.5 / stiffness(radius))
    curvatures = M / stiffness(radius, E * jump), M / stiffness(radius)
    turn, end = 0.0, np.zeros(2)
    for k in curvatures:  # an arc of half a metre after the other
        sine, cosine = np.sin(turn + 0.5 * k) - np.sin(turn), np.cos(turn) - np.cos(turn + 0.5 * k)
        turn, end = turn + 0.5 * k, end + np.array([sine, cosine]) / k
    assert turn == pytest.approx(theta, rel=1e-12)
    errors = []
    for n in (2, 4, 8):
        turn, position = bent(stepped((E * jump, E), n, element, radius), M)
        errors.append([turn - theta, np.linalg.norm(position - end)])
    errors = np.abs(errors)
    if element == "3363":
        assert np.all(errors[1:] < 0.15 * radius * curvatures[1])
        return
    assert np.all(errors[1] < errors[0] / 12)
    assert np.all(errors[2] < 1e-4)


@pytest.mark.parametrize("jump", [10.0, 1e4])
@pytest.mark.parametrize("element", ["3333", "3363"])
def test_a_stepped_rod_stretches_piece_by_piece(element, jump):
    """Free to contract, nu = 0: each half has its own stretch s with E (s^3 - s)/2 = P/A, on any mesh."""
    P = 1e-2 * E * np.pi * R**2
    rod = stepped((E * jump, E), 2, element, nu=0.0, supports=FREE)
    tip = solved(Scene((rod,), forces=(Force("rod", 1.0, np.array([P, 0.0, 0.0])),))).tip().position
    halves = [
        brentq(lambda s, m=m: m * (s**3 - s) / 2 - 1e-2 * E, 0.9, 1.5, xtol=1e-15) for m in (E * jump, E)
    ]
    assert tip[0] == pytest.approx(0.5 * sum(halves), rel=1e-12)


def test_where_two_poisson_ratios_meet_the_stretch_is_held_within_a_radius():
    """Contraction cannot jump, so a length of the order of R stretches less: 0.1 R nu of it, at most R."""
    P = 1e-2 * E * np.pi * R**2
    rod = stepped((1e4 * E, E), 64, supports=FREE)
    tip = solved(Scene((rod,), forces=(Force("rod", 1.0, np.array([P, 0.0, 0.0])),))).tip().position
    stretch = [brentq(lambda s, m=m: m * (s**3 - s) / 2 - 1e-2 * E, 0.9, 1.5) for m in (1e4 * E, E)]
    lost = (0.5 * sum(stretch) - tip[0]) / (stretch[1] - 1.0)
    assert 0.0 < lost < NU * R


def test_nodal_r_x_cannot_jump_and_its_error_falls_with_the_first_power():
    """3243: the elements at the joint share r_x. 4e-2, 2e-2, 1e-2 of the elongation; the result says so."""
    P = 1e-2 * E * np.pi * R**2
    expected = sum(
        0.5 * (brentq(lambda s, m=m: m * (s**3 - s) / 2 - 1e-2 * E, 0.9, 1.5, xtol=1e-15) - 1.0)
        for m in (10 * E, E)
    )
    errors = []
    for n in (2, 4, 8, 16):
        rod = stepped((10 * E, E), n, "3243", nu=0.0, supports=FREE)
        solution = solved(Scene((rod,), forces=(Force("rod", 1.0, np.array([P, 0.0, 0.0])),)))
        errors.append((solution.tip().position[0] - 1.0) / expected - 1.0)
        assert any("axial stiffness jumps by a factor of 10 where" in text for text in solution.warnings)
    assert np.all(np.abs(rates(np.array(errors)) - 1.0) < 0.05)
    assert errors[0] == pytest.approx(-4e-2, rel=0.1)  # non-regression: our own number


@pytest.mark.parametrize("element", ELEMENTS)
def test_laws_may_change_along_the_rod(element):
    """Small tip force on Saint Venant-Kirchhoff, then neo-Hooke of a third of its modulus: w by quad."""
    pieces = (
        Segment(0.5, 8, Circle(R), SOFT),
        Segment(0.5, 8, Circle(R), NeoHookean(E / 3, 0.45, DENSITY)),
    )
    P = 1e-4 * stiffness(R)
    rod = Rod.of_segments("rod", pieces, element=element)
    tip = solved(Scene((rod,), forces=(Force("rod", 1.0, np.array([0.0, 0.0, P])),))).tip().position
    w = (
        P
        * (quad(lambda x: (1 - x) ** 2, 0, 0.5)[0] + 3 * quad(lambda x: (1 - x) ** 2, 0.5, 1)[0])
        / stiffness(R)
    )
    assert tip[2] == pytest.approx(w, rel=2e-3)


# --- extremes ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("load", ["moment", "force"])
@pytest.mark.parametrize("share", [1e-2, 1e-4])
@pytest.mark.parametrize("element", ["3333", "3363"])
def test_an_element_may_be_ten_thousand_times_shorter_than_its_neighbours(element, share, load):
    """An element of `share` h between elements of h: the shape is that of the uniform mesh (16 elements)."""
    h, radius = 1 / 16, 0.01
    pieces = (
        Segment(0.5, 8, Circle(radius), SOFT),
        Segment(share * h, 1, Circle(radius), SOFT),
        Segment(0.5 - share * h, 8, Circle(radius), SOFT),
    )
    rods = Rod.of_segments("rod", pieces, element=element), Rod("rod", 1.0, 16, Circle(radius), SOFT, element)
    size = stiffness(radius) * (np.pi / 2 if load == "moment" else 3.0)
    found = []
    for rod in rods:
        moment = (Moment("rod", 1.0, np.array([0.0, 0.0, size])),) if load == "moment" else ()
        force = (Force("rod", 1.0, np.array([0.0, size, 0.0])),) if load == "force" else ()
        solution = solved(Scene((rod,), moments=moment, forces=force))
        assert solution.steps == 1 and solution.iterations <= 8
        found.append(solution.tip().position)
    np.testing.assert_allclose(found[0], found[1], atol=1e-6)


def test_stiff_and_short_at_once():
    """A stiff insert (1e4) of a ten-thousandth of an element: the rest of the rod does not notice."""
    h, radius = 1 / 16, 0.01
    stiff = SaintVenantKirchhoff(1e4 * E, NU, DENSITY)
    pieces = (
        Segment(0.5, 8, Circle(radius), SOFT),
        Segment(1e-4 * h, 1, Circle(radius), stiff),
        Segment(0.5 - 1e-4 * h, 8, Circle(radius), SOFT),
    )
    M = stiffness(radius) * np.pi / 2
    turn, position = bent(Rod.of_segments("rod", pieces), M)
    plain, end = bent(Rod("rod", 1.0, 16, Circle(radius), SOFT), M)
    assert turn == pytest.approx(plain, abs=2e-5) and position == pytest.approx(end, abs=1e-5)
