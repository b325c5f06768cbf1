"""References of the gallery against other closed forms and against each other; no ancf here."""

import math

import numpy as np
import pytest

from reference import rotation as rot
from reference.actuation import tendon_rod
from reference.arcs import Piece, chain_tip, concentric_curvature
from reference.catenary import hanging_cable
from reference.constant_curvature import constant_curvature_pose
from reference.rod import RodLoads, RodProperties, solve_rod
from reference.spring import Helix, close_coiled_stiffness, pulled_spring, turns
from reference.tendon_arm import ArmSection, ArmTendon, tendon_arm_tip

ALONG_Z = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]).T


# --- cable -------------------------------------------------------------------------------------------------


def test_flat_cable_is_a_parabola():
    """H = w l^2/(8 f) and L = l + 8 f^2/(3 l) for a small sag f (Irvine, ch. 1.4), to (f/l)^2 = 1e-4."""
    span, sag, weight = 10.0, 0.1, 3.0
    cable = hanging_cable(span + 8 * sag**2 / (3 * span), span, weight, 1e12)
    assert cable.sag == pytest.approx(sag, rel=1e-3)
    assert cable.horizontal == pytest.approx(weight * span**2 / (8 * sag), rel=1e-3)
    assert cable.vertical == pytest.approx(0.5 * weight * span, rel=1e-3)


def test_stiff_cable_is_the_catenary():
    """y = a cosh(x/a), L = 2 a sinh(l/(2 a)), with a = 1: sag cosh(l/2) - 1, H = w a."""
    cable = hanging_cable(2 * math.sinh(1.2), 2.4, 5.0, 1e15)
    assert cable.horizontal == pytest.approx(5.0, rel=1e-9)
    assert cable.sag == pytest.approx(math.cosh(1.2) - 1, rel=1e-9)


def test_narrow_cable_hangs_in_two_halves():
    """As the span goes to zero: two bars of L/2, each stretched by w (L/2)^2/(2 EA) under its own weight."""
    length, weight, EA = 2.0, 4.0, 100.0
    cable = hanging_cable(length, 1e-6, weight, EA)
    assert cable.sag == pytest.approx(length / 2 + weight * (length / 2) ** 2 / (2 * EA), rel=1e-4)


def test_spans_that_no_cable_has_are_refused():
    for span in (0.0, -1.0, 3.0):
        with pytest.raises(ValueError, match="span"):
            hanging_cable(1.0, span, 1.0, 1.0)


# --- spring ------------------------------------------------------------------------------------------------


def helix(R, pitch, n):
    return Helix(
        2 * math.pi * n * R / math.cos(pitch), math.cos(pitch) ** 2 / R, math.sin(pitch) * math.cos(pitch) / R
    )


def test_geometry_of_the_helix():
    spring = helix(0.02, 0.3, 4.5)
    assert spring.radius == pytest.approx(0.02)
    assert spring.sine == pytest.approx(math.sin(0.3))
    assert turns(spring) == pytest.approx(4.5)


def test_close_coiled_spring_is_wahls():
    """k -> G d^4/(8 D^3 n) for a -> 0: of first order only in a^2 and delta."""
    R, r, n, E, nu = 0.02, 0.001, 6.0, 2e11, 0.3
    EI, G = E * math.pi * r**4 / 4, E / (2 * (1 + nu))
    spring = helix(R, 1e-3, n)
    force, _ = pulled_spring(spring, EI, EI / (1 + nu), 1e-6)
    assert force / 1e-6 == pytest.approx(close_coiled_stiffness(G, 2 * r, 2 * R, n), rel=1e-4)


@pytest.mark.parametrize("extension", [0.01, 0.05, -0.01])
def test_wrench_is_the_derivative_of_the_energy(extension):
    """dU/d delta = F at ends that do not turn, U = L (GJ (tau' - tau)^2 + EI (kappa' - kappa)^2)/2."""
    spring, EI, GJ = helix(0.02, 0.15, 5.0), 3.0, 2.2

    def energy(delta):
        sine = spring.sine + delta / spring.length
        kappa, tau = spring.rate * math.sqrt(1 - sine**2), spring.rate * sine
        return spring.length * (GJ * (tau - spring.twist) ** 2 + EI * (kappa - spring.curvature) ** 2) / 2

    h = 1e-6
    slope = (energy(extension + h) - energy(extension - h)) / (2 * h)
    assert pulled_spring(spring, EI, GJ, extension)[0] == pytest.approx(slope, rel=1e-7)


def test_a_wire_cannot_be_longer_than_it_is():
    spring = helix(0.02, 0.15, 5.0)
    with pytest.raises(ValueError, match="longer wire"):
        pulled_spring(spring, 1.0, 1.0, spring.length)


# --- arcs --------------------------------------------------------------------------------------------------


def test_chain_of_equal_arcs_is_one_arc():
    theta, phi, length = 1.3, 0.7, 0.4
    exact = constant_curvature_pose(theta, phi, length)  # along Z
    # Towards (C, S) (c - 1): the arc bends about (S, -C, 0) in space, ALONG_Z^T of it in the section.
    k = ALONG_Z.T @ np.array([math.sin(phi), -math.cos(phi), 0.0]) * theta / length
    tip, frame = chain_tip([Piece(0.1, k), Piece(0.25, k), Piece(0.05, k)], ALONG_Z)
    np.testing.assert_allclose(tip, exact.position[0], atol=1e-14)
    np.testing.assert_allclose(frame, exact.rotation[0] @ ALONG_Z, atol=1e-14)


def test_pieces_follow_and_stretch():
    """A quarter circle of radius 1 about z, then straight on along y, stretched by 1.5."""
    tip, frame = chain_tip([Piece(math.pi / 2, (0, 0, 1.0)), Piece(2.0, stretch=1.5)])
    np.testing.assert_allclose(tip, [1.0, 4.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(frame, rot.exp([0, 0, math.pi / 2]), atol=1e-14)


def test_concentric_curvature_is_the_weighted_mean():
    assert concentric_curvature([1.0, 3.0], [8.0, 0.0]) == 2.0  # (1 x 8 + 3 x 0)/4
    assert concentric_curvature([2.0, 2.0], [5.0, -5.0]) == 0.0


# --- tendons -----------------------------------------------------------------------------------------------

SECTION = ArmSection(0.4, 0.01, 1e6, 0.3)


def test_one_tendon_is_the_former_reference():
    """reference/actuation.py integrates the same equations by another way (exponential steps)."""
    path = [[0.0, 0.006, 0.0], [0.6, -0.002, 0.004], [0.9, 0.0, 0.005]]
    tip, error = tendon_arm_tip([SECTION], [ArmTendon(1.0, path)])
    exact, other = tendon_rod(0.4, 0.01, 1e6, 0.3, 1.0, path)
    assert np.linalg.norm(tip - exact) < error + other + 1e-9


def test_weight_alone_is_the_former_reference():
    """reference/rod.py: collocation of the boundary-value problem under a line load."""
    section = ArmSection(0.4, 0.01, 1e6, 0.3, density=200.0)
    tip, error = tendon_arm_tip([section], [], gravity=(0.0, -9.81, 2.0))
    weight = 200.0 * section.area * np.array([0.0, -9.81, 2.0])
    exact = solve_rod(RodProperties.circle(0.4, 0.01, 1e6, 0.3), RodLoads(line_load=weight))
    assert np.linalg.norm(tip - exact.position[0]) < 10 * error + 1e-9


def test_two_sections_are_two_arcs():
    """Straight tendons bend by exactly T d/(E I) in each section and shorten it by T/(E A)."""
    far = ArmSection(0.3, 0.005, 1e6, 0.3)
    T, d, p = 0.5, 0.006, 0.004
    tendons = [ArmTendon(T, [[0, d, 0], [4 / 7, d, 0]]), ArmTendon(T, [[0, 0, p], [1, 0, p]])]
    EI = [s.stiffness[1][1] for s in (SECTION, far)]
    short = [1 - 2 * T / (1e6 * SECTION.area), 1 - T / (1e6 * far.area)]
    # p x (-T e_x): a tendon at +y bends about +z, one at +z about -y.
    arcs = [
        Piece(0.4, (0.0, -T * p / EI[0], T * d / EI[0]), short[0]),
        Piece(0.3, (0.0, -T * p / EI[1], 0.0), short[1]),
    ]
    tip, _ = tendon_arm_tip([SECTION, far], tendons)
    np.testing.assert_allclose(tip, chain_tip(arcs)[0], atol=1e-8)
    assert (np.abs(tip) > 0.01).all()


def test_the_base_turns_everything():
    path = [[0.0, 0.006, 0.0], [1.0, -0.002, 0.004]]
    section = ArmSection(0.4, 0.01, 1e6, 0.3, density=500.0)
    gravity, turn = np.array([1.0, -9.0, 3.0]), rot.exp([0.4, 1.1, -0.6])
    plain, _ = tendon_arm_tip([section], [ArmTendon(1.0, path)], gravity=gravity)
    turned, _ = tendon_arm_tip([section], [ArmTendon(1.0, path)], turn, turn @ gravity)
    np.testing.assert_allclose(turned, turn @ plain, atol=1e-8)
