"""Closed forms and collocated solutions that check the solid: Rivlin's, homogeneous, manufactured."""

import numpy as np
import pytest

from reference.homogeneous import (
    equibiaxial,
    principal_mooney_rivlin,
    principal_neo_hookean,
    principal_saint_venant_kirchhoff,
    uniaxial,
)
from reference.invariant_laws import cofactor, invariants, mooney_rivlin, neo_hookean, saint_venant_kirchhoff
from reference.manufactured import WaveMotion, body_force, traction
from reference.rivlin import flexure_of_block, poynting_stretch, torsion_of_cylinder
from reference.rivlin_compressible import flexure_compressible, torsion_compressible
from reference.uniaxial import uniaxial_saint_venant_kirchhoff

C10, C01 = 0.3, 0.1
MU = 2 * (C10 + C01)
GAUSS = np.polynomial.legendre.leggauss(40)
LAWS = {
    "svk": saint_venant_kirchhoff(1.0, 0.3),
    "nh": neo_hookean(1.0, 0.3),
    "mr": mooney_rivlin(C10, C01, 2.0),
}


def slope(function, at, step=1e-3):
    """Eighth-order central difference (Fornberg 1988): 1e-12 for smooth functions of size 1."""
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    return sum(w / step * (function(at + k * step) - function(at - k * step)) for k, w in weights.items())


def nearly_incompressible(nu):
    """Mooney-Rivlin with the bulk modulus of a Poisson ratio."""
    return mooney_rivlin(C10, C01, MU * 2 * (1 + nu) / (3 * (1 - 2 * nu)))


# --- flexure ------------------------------------------------------------------------------------------------


def flexure_energy(curvature, thickness=1.2):
    """int mu/2 (l^2 + l^-2 - 2) dX over the thickness, l^2 = 2 k X + sqrt(1 + (k h)^2)."""
    X, weight = GAUSS[0] * thickness / 2, GAUSS[1] * thickness / 2
    square = 2 * curvature * X + np.sqrt(1 + (curvature * thickness) ** 2)
    return weight @ (MU / 2 * (square + 1 / square - 2))


@pytest.mark.parametrize("curvature", [0.1, 0.7, 2.0])
def test_flexure_couple_is_the_slope_of_the_energy(curvature):
    exact = flexure_of_block(curvature, 1.2, C10, C01)
    assert exact.moment == pytest.approx(slope(flexure_energy, curvature), rel=1e-10)


def test_flexure_keeps_the_area_and_its_faces_free():
    exact = flexure_of_block(0.7, 1.2, C10, C01)
    # area of the sector by angle = area of the block by length; k^2 r_i r_o = 1 (Rivlin 1949)
    assert (exact.outer_radius**2 - exact.inner_radius**2) / 2 * 0.7 == pytest.approx(1.2, rel=1e-14)
    assert exact.inner_radius * exact.outer_radius * 0.7**2 == pytest.approx(1, rel=1e-14)


def test_thin_flexure_has_the_plane_strain_modulus():
    # E/(1 - nu^2) at nu = 1/2 is 4 mu; the next term is of order (k h)^2
    assert flexure_of_block(1e-3, 1.2, C10, C01).moment == pytest.approx(
        4 * MU * 1.2**3 / 12 * 1e-3, rel=1e-6
    )


@pytest.mark.parametrize(("curvature", "thickness"), [(0.0, 1.0), (-1.0, 1.0), (1.0, 0.0)])
def test_flexure_refuses_what_is_not_bent(curvature, thickness):
    with pytest.raises(ValueError, match="both must be positive"):
        flexure_of_block(curvature, thickness, C10, C01)


# --- torsion ------------------------------------------------------------------------------------------------


def torsion_energy(twist, stretch, radius=1.3):
    """2 pi int (c10 (I1 - 3) + c01 (I2 - 3)) R dR, with C of r = R/sqrt(l), theta + tau Z, l Z by hand."""
    R, weight = radius / 2 * (1 + GAUSS[0]), radius / 2 * GAUSS[1]
    I1 = 2 / stretch + stretch**2 + (twist * R) ** 2 / stretch
    I2 = 2 * stretch + 1 / stretch**2 + (twist * R / stretch) ** 2
    return 2 * np.pi * weight @ ((C10 * (I1 - 3) + C01 * (I2 - 3)) * R)


@pytest.mark.parametrize(("twist", "stretch"), [(0.5, 1.0), (0.8, 1.2), (-0.6, 0.85)])
def test_torsion_couple_and_force_are_slopes_of_the_energy(twist, stretch):
    exact = torsion_of_cylinder(twist, 1.3, C10, C01, stretch)
    assert exact.moment == pytest.approx(slope(lambda t: torsion_energy(t, stretch), twist), rel=1e-10)
    assert exact.axial_force == pytest.approx(slope(lambda s: torsion_energy(twist, s), stretch), rel=1e-9)


def test_torsion_at_fixed_length_pushes():
    # Rivlin 1949: N = -pi/2 a^4 tau^2 (c10 + 2 c01), M = pi a^4 tau (c10 + c01)
    exact = torsion_of_cylinder(0.5, 2.0, C10, C01)
    assert exact.axial_force == pytest.approx(-np.pi / 2 * 16 * 0.25 * (C10 + 2 * C01), rel=1e-14)
    assert exact.moment == pytest.approx(np.pi * 16 * 0.5 * (C10 + C01), rel=1e-14)


def test_poynting_stretch_frees_the_ends():
    stretch = poynting_stretch(0.8, 1.3, C10, C01)
    assert stretch > 1
    force = torsion_of_cylinder(0.8, 1.3, C10, C01, stretch)
    assert abs(force.axial_force) < 1e-13 * force.moment
    # (a tau)^2/12 (c10 + 2 c01)/(c10 + c01) at first
    small = poynting_stretch(1e-3, 1.0, C10, C01) - 1
    assert small == pytest.approx(1e-6 / 12 * (C10 + 2 * C01) / (C10 + C01), rel=1e-6)
    assert poynting_stretch(0.0, 1.0, C10, C01) == 1.0


def test_torsion_refuses_what_is_no_cylinder():
    with pytest.raises(ValueError, match="both must be positive"):
        torsion_of_cylinder(0.5, 1.0, C10, C01, 0.0)


# --- the same with change of volume -------------------------------------------------------------------------


def test_compressible_families_tend_to_rivlins_in_first_order():
    gaps = []
    for nu in (0.4995, 0.49995):
        law = nearly_incompressible(nu)
        bent, twisted = flexure_compressible(law, 0.7, 1.2), torsion_compressible(law, 0.6, 1.0, 1.1)
        flexure, torsion = flexure_of_block(0.7, 1.2, C10, C01), torsion_of_cylinder(0.6, 1.0, C10, C01, 1.1)
        gaps.append(
            [
                bent.moment / flexure.moment - 1,
                bent.radius[0] / flexure.inner_radius - 1,
                bent.radius[-1] / flexure.outer_radius - 1,
                twisted.moment / torsion.moment - 1,
                twisted.axial_force - torsion.axial_force,
            ]
        )
    np.testing.assert_allclose(np.array(gaps[0]) / gaps[1], 10, rtol=0.02)


@pytest.mark.parametrize("name", LAWS)
def test_small_flexure_and_torsion_are_linear_elastic(name):
    law = LAWS[name]
    tangent = law.tangent(np.eye(3))
    mu, lam = tangent[0, 1, 0, 1], tangent[0, 0, 1, 1]
    plane = 4 * mu * (lam + mu) / (lam + 2 * mu)  # E/(1 - nu^2)
    # the next terms are of order (k h)^2 = 1.4e-4 and (a tau)^2 = 1.7e-6
    bent = flexure_compressible(law, 1e-2, 1.2)
    assert bent.moment == pytest.approx(plane * 1.2**3 / 12 * 1e-2, rel=1e-4)
    assert torsion_compressible(law, 1e-3, 1.3).moment == pytest.approx(
        mu * np.pi / 2 * 1.3**4 * 1e-3, rel=1e-5
    )


@pytest.mark.parametrize("name", LAWS)
def test_compressible_torsion_comes_from_one_energy(name):
    law = LAWS[name]
    by_stretch = slope(lambda s: torsion_compressible(law, 0.6, 1.0, s).moment, 1.05, 1e-2)
    by_twist = slope(lambda t: torsion_compressible(law, t, 1.0, 1.05).axial_force, 0.6, 1e-2)
    assert by_stretch == pytest.approx(by_twist, rel=1e-8)


def test_radius_between_the_points():
    law = nearly_incompressible(0.4999999)
    bent = flexure_compressible(law, 0.7, 1.2)
    X = np.array([-0.6, -0.37, 0.0, 0.21, 0.6])
    exact = np.sqrt(2 * X / 0.7 + np.sqrt(1 + (0.7 * 1.2) ** 2) / 0.7**2)
    np.testing.assert_allclose(bent.radius_at(X), exact, rtol=1e-6)


def test_collocation_refuses_what_has_no_answer():
    # Saint Venant-Kirchhoff softens to nothing in compression
    with pytest.raises(ValueError, match="try a smaller deformation"):
        flexure_compressible(saint_venant_kirchhoff(1.0, 0.3), 5.0, 1.0)


# --- homogeneous stretch ------------------------------------------------------------------------------------


def test_uniaxial_saint_venant_kirchhoff_is_the_known_closed_form():
    found = uniaxial(principal_saint_venant_kirchhoff(2.0, 0.3), 1.25)
    known = uniaxial_saint_venant_kirchhoff(found.stress * 0.7, 2.0, 0.3, 0.7)
    assert known.axial == pytest.approx(1.25, rel=1e-12)
    assert known.lateral == pytest.approx(found.free, rel=1e-12)


@pytest.mark.parametrize("stretch", [0.7, 1.6])
def test_homogeneous_stretch_tends_to_the_incompressible_one(stretch):
    # Rivlin 1948: P = 2 (l - l^-2)(c10 + c01/l) uniaxial, 2 (l - l^-5)(c10 + c01 l^2) equibiaxial
    stress = principal_mooney_rivlin(C10, C01, 1e7)
    one, two = uniaxial(stress, stretch), equibiaxial(stress, stretch)
    assert one.stress == pytest.approx(2 * (stretch - stretch**-2) * (C10 + C01 / stretch), rel=1e-6)
    assert two.stress == pytest.approx(2 * (stretch - stretch**-5) * (C10 + C01 * stretch**2), rel=1e-6)
    assert two.free == pytest.approx(stretch**-2, rel=1e-6)
    neo = uniaxial(principal_neo_hookean(3 * 0.99999999, 0.49999998), stretch)
    assert neo.stress == pytest.approx(stretch - stretch**-2, rel=1e-6)


def test_homogeneous_stretch_refuses_what_has_no_equilibrium():
    with pytest.raises(ValueError, match="no free stretch"):
        # the lateral strain -nu e would need a negative square
        uniaxial(principal_saint_venant_kirchhoff(1.0, 0.45), 2.0)


# --- laws in invariants -------------------------------------------------------------------------------------


def deformations():
    return np.eye(3) + 0.15 * np.random.default_rng(4).normal(size=(3, 3, 3))


@pytest.mark.parametrize("name", LAWS)
def test_stress_in_invariants_is_the_slope_of_the_energy(name):
    F, dF = deformations(), np.random.default_rng(5).normal(size=(3, 3, 3))
    law = LAWS[name]
    power = np.imag(law.energy(F + 1e-30j * dF)) / 1e-30
    np.testing.assert_allclose(np.sum(law.stress(F) * dF, axis=(-2, -1)), power, rtol=1e-12)
    np.testing.assert_allclose(law.tangent(F), np.moveaxis(law.tangent(F), (-4, -3), (-2, -1)), atol=1e-13)


def test_invariants_and_cofactor():
    F = deformations()
    C = F.swapaxes(-1, -2) @ F
    eigenvalues = np.linalg.eigvalsh(C)
    I1, I2, J = invariants(F)
    np.testing.assert_allclose(I1, eigenvalues.sum(-1), rtol=1e-13)
    a, b, c = eigenvalues.T
    np.testing.assert_allclose(I2, a * b + b * c + c * a, rtol=1e-13)
    np.testing.assert_allclose(J, np.linalg.det(F), rtol=1e-13)
    np.testing.assert_allclose(cofactor(F), J[:, None, None] * np.linalg.inv(F).swapaxes(-1, -2), rtol=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_principal_stress_is_the_diagonal_of_the_tensor(name):
    principal = {
        "svk": principal_saint_venant_kirchhoff(1.0, 0.3),
        "nh": principal_neo_hookean(1.0, 0.3),
        "mr": principal_mooney_rivlin(C10, C01, 2.0),
    }[name]
    P = LAWS[name].stress(np.diag([1.2, 0.9, 1.05]))
    assert principal(1.2, 0.9, 1.05) == pytest.approx(P[0, 0], rel=1e-13)
    assert principal(0.9, 1.05, 1.2) == pytest.approx(P[1, 1], rel=1e-13)


# --- manufactured motion ------------------------------------------------------------------------------------

WAVES = np.array([[1.2, 1.5, 1.1], [1.3, -1.1, -1.2], [-1.0, 1.4, 1.3]])
POINTS = np.random.default_rng(6).uniform(-0.5, 0.5, (5, 3))


def test_motion_and_its_gradient_belong_together():
    motion = WaveMotion(0.12, WAVES, np.array([0.3, 0.5, -0.4]))
    F = motion.deformation_gradient(POINTS)
    for axis in range(3):
        step = 1e-30j * np.eye(3)[axis]
        np.testing.assert_allclose(np.imag(motion.position(POINTS + step)) / 1e-30, F[..., axis], rtol=1e-13)
    shears = WaveMotion(0.12, WAVES - np.diag(np.diag(WAVES)), np.zeros(3))
    np.testing.assert_allclose(np.linalg.det(shears.deformation_gradient(POINTS)), 1, rtol=1e-13)


@pytest.mark.parametrize("name", LAWS)
def test_body_force_balances_the_traction_of_a_small_cube(name):
    """The force on a cube is what its faces do not balance: int b dV + int t dA = 0, by Gauss's rule."""
    motion, law = WaveMotion(0.12, WAVES, np.array([0.3, 0.5, -0.4])), LAWS[name]
    t, w = np.polynomial.legendre.leggauss(8)
    t, w = 0.2 * t, 0.2 * w
    X = np.stack(np.meshgrid(t, t, t, indexing="ij"), -1)
    total = np.einsum("i,j,k,ijkc->c", w, w, w, body_force(motion, law, X))
    inside = total.copy()
    for axis in range(3):
        for side in (-1, 1):
            face = np.insert(np.stack(np.meshgrid(t, t, indexing="ij"), -1), axis, 0.2 * side, axis=-1)
            normal = np.broadcast_to(side * np.eye(3)[axis], face.shape)
            total += np.einsum("i,j,ijc->c", w, w, traction(motion, law, face, normal))
    assert np.linalg.norm(inside) > 1e-3
    np.testing.assert_allclose(total, 0, atol=1e-12)
