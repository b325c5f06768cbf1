"""Exact section problem against closed forms, the thin limit, the 3-D solid and its own refinement."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from reference.bending import BendingSection, pure_bending_moment
from reference.rotation import exp, log
from reference.section import SectionStatus, bend, bend_and_twist, extend, stiffness, twist
from reference.section_form import SectionForm
from reference.solid import solid_pure_bending
from reference.solid_couple import section_moments, section_rotation
from reference.solid_materials import MooneyRivlin, NeoHookean, SaintVenantKirchhoff
from reference.solid_mesh import annular_section, circular_section, elliptic_section, rectangular_section
from reference.torsion import torsion_constant_circle, torsion_constant_ellipse, torsion_constant_rectangle

R, L, E = 0.01, 0.4, 1e6  # m, m, Pa
EI = E * np.pi * R**4 / 4
CIRCLE = circular_section(R, 2, 1)
COARSE = circular_section(R, 1, 1)  # 1e-5: for identities that hold on every mesh
SVK = SaintVenantKirchhoff(E, 0.3)
RUBBER = NeoHookean(E, 0.4999)
MOONEY = MooneyRivlin(1e5, 6e4, 3e8)
LAWS = [SVK, NeoHookean(E, 0.3), NeoHookean(E, 0.49), RUBBER, MOONEY]


@pytest.mark.parametrize(
    ("angle", "gap"),
    # relative angle above M L/EI, nu = 0.3, L/R = 40; independent prototype, four digits
    [(np.pi / 4, 5.816e-4), (np.pi / 2, 2.3362e-3), (np.pi, 9.504e-3), (2 * np.pi, 4.088e-2)],
)
def test_angle_at_given_couple(angle: float, gap: float) -> None:
    state = bend(CIRCLE, SVK, moment=EI * angle / L)
    assert state.status is SectionStatus.CONVERGED
    assert state.curvature * L / angle - 1 == pytest.approx(gap, abs=3e-7 + 2.5e-4 * gap)


@pytest.mark.parametrize("law", [SVK, RUBBER], ids=["svk", "rubber"])
def test_couple_converges_to_1e_8(law: SaintVenantKirchhoff | NeoHookean) -> None:
    couples = [bend(circular_section(R, n, 1), law, curvature=5.0).couple[2] for n in (1, 2, 3)]
    changes = np.abs(np.diff(couples) / couples[-1])
    assert 1e-6 < changes[0] < 1e-4
    assert changes[1] < 1e-8
    assert changes[1] < changes[0] / 1000  # so core 3 is within 1e-10 of the limit


def test_order_2_converges_with_fourth_power() -> None:
    """Energy of biquadratic elements: h^4; order 4 on a fine mesh is the limit."""
    limit = bend(circular_section(R, 4, 1), SVK, curvature=5.0).couple[2]
    errors = [
        bend(circular_section(R, n, n // 2), SVK, curvature=5.0, order=2).couple[2] / limit - 1
        for n in (2, 4, 8)
    ]
    assert_allclose(np.log2(np.abs(errors[:-1]) / np.abs(errors[1:])), 4.0, atol=0.15)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49, 0.4999])
def test_stiffness_of_straight_circle(nu: float) -> None:
    bar = stiffness(CIRCLE, NeoHookean(E, nu))
    assert_allclose([bar.EI_y, bar.EI_z], EI, rtol=1e-10)
    assert pytest.approx(E * np.pi * R**2, rel=2e-7) == bar.EA  # area of the mesh with match_I
    assert pytest.approx(E / (2 * (1 + nu)) * np.pi * R**4 / 2, rel=1e-6) == bar.GJ


def test_stiffness_of_other_sections() -> None:
    law, G = NeoHookean(E, 0.3), E / 2.6
    square = stiffness(rectangular_section(R, R, 4), law)
    assert pytest.approx(0.140577, abs=6e-7) == square.GJ / G / R**4  # Timoshenko, Goodier art. 109
    oblong = stiffness(rectangular_section(R, 2 * R, 3, 6), law)
    assert pytest.approx(torsion_constant_rectangle(R, 2 * R), rel=5e-6) == oblong.GJ / G
    assert_allclose(
        [oblong.EI_y, oblong.EI_z], [E * R * (2 * R) ** 3 / 12, E * 2 * R * R**3 / 12], rtol=1e-10
    )
    ellipse = stiffness(elliptic_section(R, 2 * R, 3), law)
    assert pytest.approx(torsion_constant_ellipse(R, 2 * R), rel=1e-6) == ellipse.GJ / G
    pipe = stiffness(annular_section(R, R / 2, 4), law)
    assert pytest.approx(torsion_constant_circle(R, R / 2), rel=1e-6) == pipe.GJ / G


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_thin_limit(law: SaintVenantKirchhoff | NeoHookean | MooneyRivlin) -> None:
    """M -> EI kappa with a gap of order (kappa R)^2: a quarter when kappa is halved."""
    I_b = law.young_modulus * np.pi * R**4 / 4
    gaps = [bend(COARSE, law, curvature=k).couple[2] / (I_b * k) - 1 for k in (4.0, 2.0)]
    assert -2 * (4.0 * R) ** 2 < gaps[0] < -0.2 * (4.0 * R) ** 2
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.01)


def test_bending_without_poisson_effect() -> None:
    """The exact section is softer than one that may only stretch, and that softer than a rigid one."""
    law, kappa = SaintVenantKirchhoff(E, 0.0), 5.0
    fibres = BendingSection.circle(R)
    stretching = pure_bending_moment(kappa, E, fibres, "stretching").moment
    rigid = pure_bending_moment(kappa, E, fibres, "rigid")
    state = bend(CIRCLE, law, curvature=kappa)
    assert state.couple[2] < stretching < rigid.moment
    assert state.couple[2] == pytest.approx(stretching, rel=2 * (kappa * R) ** 2)
    # mean axial strain -(3/8) (kappa R)^2 of the rigid section, unchanged to this order
    assert state.velocity[0] - 1 == pytest.approx(-0.375 * (kappa * R) ** 2, rel=0.02)
    assert rigid.axial_stretch - 1 == pytest.approx(-0.375 * (kappa * R) ** 2, rel=0.01)


@pytest.mark.parametrize("c01", [0.0, 6e4])
def test_rivlin_torsion_with_poynting_effect(c01: float) -> None:
    """Incompressible cylinder free to lengthen (Rivlin 1949): with psi per reference length,

    W/A = c10 (l^2 + 2/l + psi^2 R^2/(2 l)) + c01 (2 l + 1/l^2 + psi^2 R^2/(2 l^2)), dW/dl = 0, M = dW/dpsi.
    """
    c10, psi, I_p, A = 1e5, 50.0, np.pi * R**4 / 2, np.pi * R**2
    p2 = psi**2 * I_p / A

    def pull(s: float) -> float:
        return c10 * (2 * s - 2 / s**2 - p2 / s**2) + c01 * (2 - 2 / s**3 - 2 * p2 / s**3)

    stretch = float(brentq(pull, 0.9, 1.5, xtol=1e-14))  # pyright: ignore[reportArgumentType]
    couple = 2 * psi * I_p * (c10 / stretch + c01 / stretch**2)
    bulk = 1e5 * 1e5  # gap of order c10/K
    state = twist(circular_section(R, 3), MooneyRivlin(c10, c01, bulk), twist=psi)
    assert stretch > 1.01
    assert state.axial_stretch == pytest.approx(stretch, abs=2e-7)
    assert state.couple[0] == pytest.approx(couple, rel=3e-6)


def test_uniaxial_extension_of_incompressible_rubber() -> None:
    """P = mu (s - 1/s^2) (Treloar): within 1 - 2 nu of it at nu = 0.4999."""
    area = COARSE.area
    state = extend(COARSE, RUBBER, stretch=1.5)
    assert state.force[0] / area == pytest.approx(E / (2 * 1.4999) * (1.5 - 1 / 2.25), rel=1e-4)
    back = extend(COARSE, RUBBER, force=float(state.force[0]))
    assert back.axial_stretch == pytest.approx(1.5, rel=1e-10)
    field = state.stress()
    assert_allclose(field.pk1[..., 0, 0], state.force[0] / area, rtol=1e-9)
    assert_allclose(field.cauchy[..., 1:, 1:], 0.0, atol=1e-6 * E)


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_energy_is_the_work_of_the_couple(law: SaintVenantKirchhoff | NeoHookean | MooneyRivlin) -> None:
    """U(b) - U(a) = int M dkappa, five Gauss points."""
    low, high = 4.0, 12.0
    x, w = np.polynomial.legendre.leggauss(5)
    middle, half = (low + high) / 2, (high - low) / 2
    work = sum(
        weight * half * bend(COARSE, law, curvature=middle + half * at).couple[2]
        for at, weight in zip(x, w, strict=True)
    )
    gain = bend(COARSE, law, curvature=high).energy - bend(COARSE, law, curvature=low).energy
    assert gain == pytest.approx(work, rel=1e-8)


def test_stress_carries_the_couple_and_no_force() -> None:
    state = bend_and_twist(CIRCLE, SVK, [0.6 * EI / L, 1.0 * EI / L, -2.0 * EI / L])
    field = state.stress()
    first = field.weights[..., None] * field.pk1[..., 0]
    assert_allclose(first.sum(axis=(0, 1)), 0.0, atol=1e-12 * E * R**2)
    # the couple about the mean point; positions of the points from k x u = F_1 - a - spin d_spin u
    assert_allclose(state.couple, [0.6 * EI / L, EI / L, -2.0 * EI / L], rtol=1e-10)
    arm = field.points[..., 1] * first[..., 0], -field.points[..., 0] * first[..., 0]
    assert_allclose([np.sum(a) for a in arm], state.couple[1:], rtol=0.02)


@pytest.mark.parametrize("law", [SVK, RUBBER], ids=["svk", "rubber"])
def test_stress_at_any_point_is_that_of_the_integration_points(law: SaintVenantKirchhoff) -> None:
    state = bend_and_twist(CIRCLE, law, EI / L * np.array([0.6, 1.0, -2.0]))
    field = state.stress()
    at = state.stress(field.points.reshape(-1, 2)[::7])
    assert_allclose(at.F, field.F.reshape(-1, 3, 3)[::7], atol=1e-10)
    assert_allclose(at.cauchy, field.cauchy.reshape(-1, 3, 3)[::7], atol=1e-6 * abs(field.cauchy).max())
    with pytest.raises(ValueError, match="point 1 of 2 lies outside"):
        state.stress(np.array([[0.0, 0.0], [1.2 * R, 0.0]]))


def test_free_surface_of_the_bent_bar() -> None:
    """Fibre stress E e of bending towards +y, compression there; no traction on the rim (to 1e-3 of it)."""
    at = bend(circular_section(R, 4), SVK, curvature=1.0).stress(np.array([[R, 0.0], [-R, 0.0], [0.0, R]]))
    E_R = E * 1.0 * R
    assert_allclose(at.cauchy[:, 0, 0], [-E_R, E_R, 0.0], atol=0.03 * E_R)
    assert_allclose(at.cauchy[:2, 1, 1], 0.0, atol=1e-3 * E_R)


def test_bend_and_twist_is_the_helix_in_the_thin_limit() -> None:
    """theory: k = M/EI, spin = nu M_x/EI; R = Exp(L k) Exp(L spin e_x)."""
    moment = 1e-2 * EI * np.array([0.7, -0.5, 0.4])
    state = bend_and_twist(CIRCLE, SVK, moment)
    assert_allclose(state.screw, moment / EI, rtol=3e-6)
    assert state.spin == pytest.approx(0.3 * moment[0] / EI, rel=1e-5)
    assert_allclose(np.cross(state.screw, state.couple), 0.0, atol=1e-14 * EI)


def test_bend_and_twist_does_not_depend_on_the_azimuth_of_the_mesh() -> None:
    """An exact circle knows no azimuth: the pose turns with the couple."""
    moment = EI / L * np.array([1.2, 0.0, 2.0])
    turned = exp([0.7, 0.0, 0.0])
    first = bend_and_twist(CIRCLE, SVK, moment).pose(L)
    second = bend_and_twist(CIRCLE, SVK, turned @ moment).pose(L)
    assert_allclose(second.centre, turned @ first.centre, atol=1e-13)
    assert_allclose(second.rotation, turned @ first.rotation @ turned.T, atol=1e-12)


def test_bend_and_twist_joins_bending_and_torsion() -> None:
    bent = bend(CIRCLE, SVK, moment=2 * EI / L)
    assert_allclose(bend_and_twist(CIRCLE, SVK, [0, 0, 2 * EI / L]).screw, bent.screw, atol=1e-9)
    assert_allclose(bend_and_twist(CIRCLE, SVK, [0, 0, 2 * EI / L]).spin, 0.0, atol=1e-9)
    torsion = twist(CIRCLE, SVK, moment=2 * EI / L)
    slight = bend_and_twist(CIRCLE, SVK, [2 * EI / L, 0, 1e-7 * EI / L])
    assert slight.twist == pytest.approx(torsion.twist, rel=1e-8)
    assert bend_and_twist(CIRCLE, SVK, [2 * EI / L, 0, 0]).twist == pytest.approx(torsion.twist, rel=1e-12)


def test_pose_is_that_of_the_solid() -> None:
    """Same section elements (order 2); the axial error of the solid is of order 4 and extrapolated."""
    moment = EI * np.pi / 2 / L
    half, whole = (solid_pure_bending(L, R, E, 0.3, moment, slices=n) for n in (12, 24))
    angles = [log(solid.tip_rotation)[2] for solid in (half, whole)]
    pose = bend(CIRCLE, SVK, moment=moment, order=2).pose(L)
    assert log(pose.rotation)[2] == pytest.approx((16 * angles[1] - angles[0]) / 15, rel=3e-5)
    tip = (16 * whole.tip_position - half.tip_position) / 15
    assert_allclose(pose.mean, tip, atol=3e-5 * L)


def test_pose_follows_the_screw() -> None:
    """The far section of two lengths is the section of the second seen from the first."""
    state = bend_and_twist(circular_section(R, 2), SVK, EI / L * np.array([1.0, 0.5, 2.0]))
    half, whole = state.pose(L / 2), state.pose(L)
    screw = exp(L / 2 * state.screw)
    # the base's centre is at the origin: x(s) = p(s) + S(s) x(0)
    assert_allclose(whole.centre, half.centre + screw @ half.centre, atol=1e-14)
    assert_allclose(whole.rotation, screw @ half.rotation @ exp([L / 2 * state.spin, 0, 0]), atol=1e-13)
    assert_allclose(np.linalg.norm(whole.mean - whole.centre), np.linalg.norm(state.centre), atol=1e-15)


def test_section_frame_is_the_polar_rotation() -> None:
    state = bend_and_twist(CIRCLE, SVK, EI / L * np.array([2.0, 1.0, 4.0]), order=2)
    turn = state.turn[1:, 1:]
    W = section_moments(CIRCLE.nodes @ turn.T, CIRCLE.mass)
    assert_allclose(section_rotation(state.positions, W), np.eye(3), atol=1e-12)
    assert_allclose(CIRCLE.mass.sum(axis=0) @ state.positions, 0.0, atol=1e-14 * R**2)


def test_geometry_of_the_bent_bar() -> None:
    state = bend(CIRCLE, SVK, curvature=5.0)
    assert state.axis_radius == pytest.approx(state.velocity[0] / 5.0, rel=1e-12)
    assert state.pitch == pytest.approx(0.0, abs=1e-12)
    assert_allclose(state.warping, 0.0, atol=1e-13 * R)  # mirror plane
    # Saint-Venant: v = nu kappa (y^2 - z^2)/2, less its mean 0, to (kappa R)^2
    y, z = state.nodes.T
    assert_allclose(state.in_plane[:, 0], 0.3 * 5.0 * (y**2 - z**2) / 2, atol=0.03 * 5.0 * R**2)
    assert state.centre[0] == 0.0
    fibre = 1.0 - 5.0 * y  # stretch of the fibres
    assert_allclose(state.velocity[0] - 5.0 * state.positions[:, 1], fibre, atol=0.5 * (5.0 * R) ** 2)


def test_warping_of_the_twisted_rectangle() -> None:
    """Saint-Venant warping of a narrow strip, -twist y z when |y| >> |z| (Timoshenko, Goodier art. 108)."""
    strip = rectangular_section(10 * R, R, 8, 1)
    state = twist(strip, SVK, twist=0.1)
    y, z = state.nodes.T
    inner = np.abs(y) < 2.6 * R
    spread = 0.1 * np.abs(y * z)[inner].max()
    assert_allclose(state.warping[inner], -0.1 * (y * z)[inner], atol=1e-3 * spread)


def test_largest_couple_is_reported() -> None:
    """The softening law has a largest couple; the state returned is the last that converged."""
    state = bend(COARSE, SVK, moment=0.6 * EI / R)
    assert state.status is SectionStatus.NOT_CONVERGED
    assert 0 < state.fraction < 1
    assert "largest couple" in state.message
    assert np.all(np.isfinite(state.positions))
    assert state.couple[2] == pytest.approx(state.fraction * 0.6 * EI / R, rel=1e-9)


def test_bending_off_the_principal_axis_is_no_screw() -> None:
    oblong = rectangular_section(R, 2 * R)
    turned = dataclasses.replace(oblong, nodes=oblong.nodes @ exp([0.3, 0, 0])[1:, 1:].T)
    assert bend(turned, SVK, curvature=3.0).status is SectionStatus.NOT_HELICAL
    assert bend(oblong, SVK, curvature=3.0).status is SectionStatus.CONVERGED


def test_zero_load_is_the_straight_bar() -> None:
    state = bend_and_twist(CIRCLE, RUBBER, [0.0, 0.0, 0.0])
    assert state.status is SectionStatus.CONVERGED
    pose = state.pose(L)
    assert_allclose(pose.centre, [L, 0, 0], atol=1e-12 * L)
    assert_allclose(pose.rotation, np.eye(3), atol=1e-12)
    assert state.axis_radius > 1e6 * R
    straight = extend(CIRCLE, SVK, stretch=1.0)
    assert straight.axis_radius == np.inf
    assert straight.pitch == pytest.approx(1.0, rel=1e-12)


def test_refusals() -> None:
    with pytest.raises(ValueError, match="exactly one of curvature and moment"):
        bend(CIRCLE, SVK)
    with pytest.raises(ValueError, match="2 are given"):
        twist(CIRCLE, SVK, twist=1.0, moment=1.0)
    with pytest.raises(ValueError, match="stretch is nan"):
        extend(CIRCLE, SVK, stretch=float("nan"))
    with pytest.raises(ValueError, match="three finite numbers"):
        bend_and_twist(CIRCLE, SVK, [1.0, np.inf, 0.0])
    with pytest.raises(ValueError, match="circles and annuli only"):
        bend_and_twist(rectangular_section(R, R), SVK, [0.1, 0.0, 0.1])
    with pytest.raises(ValueError, match="circles and annuli only"):  # corners and mid-sides: two radii
        bend_and_twist(rectangular_section(R, R, 1), SVK, [0.1, 0.0, 0.1])
    with pytest.raises(ValueError, match="order is 1"):
        bend(CIRCLE, SVK, curvature=1.0, order=1)


@pytest.mark.parametrize("mixed", [True, False])
def test_thin_walls_and_slender_sections_are_no_trouble_for_the_projection(mixed):
    """Monomials of the whole section are dependent on a wall of R/100 (condition 6e19): M = E I kappa."""
    wall = bend(annular_section(R, 0.99 * R, 8), NeoHookean(1e6, 0.49), curvature=1e-4, mixed=mixed)
    assert wall.couple[2] == pytest.approx(1e6 * np.pi * R**4 * (1 - 0.99**4) / 4 * 1e-4, rel=1e-4)
    strip = bend(rectangular_section(R, 20 * R, 2, 40), NeoHookean(1e6, 0.49), curvature=1e-4, mixed=mixed)
    assert strip.couple[2] == pytest.approx(1e6 * 20 * R**4 / 12 * 1e-4, rel=1e-3)


def test_the_projection_is_one():
    """Pi Pi = Pi, and polynomials of its degree are left as they are."""
    form = SectionForm(annular_section(R, 0.9 * R, 4), NeoHookean(1e6, 0.49), True, 4)
    Pi = form.projection
    np.testing.assert_allclose(Pi @ Pi, Pi, atol=1e-9)
    y, z = form.shapes.points[..., 0], form.shapes.points[..., 1]
    cubic = 1.0 + y - 2 * z**2 + y * z**2
    np.testing.assert_allclose((Pi @ cubic[..., None])[..., 0], cubic, atol=1e-8)
