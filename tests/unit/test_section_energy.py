"""Strain in the Gram form against the tensor, the paper's cylindrical form, frames and weights."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ancf.elements import ELEMENTS, SECTION_ELEMENTS
from ancf.errors import SceneError
from ancf.materials import VOIGT, SaintVenantKirchhoff
from ancf.scene import Rod
from ancf.section_energy import (
    director_weights,
    generalised_shape,
    gradient_weights,
    local_gradient,
    section_frame,
    section_stiffness,
    straight_reference,
    straight_section_stiffness,
    strain_matrix,
)
from ancf.sections import Annulus, Circle, Rectangle
from tests.strategies import draws, rotations
from validation import kernel_measures as kernel
from validation.random_rods import RodRange, random_model, random_rotation, random_state, random_vector

every_element = pytest.mark.parametrize("name", ELEMENTS)
every_section = pytest.mark.parametrize("name", SECTION_ELEMENTS)


@every_section
@given(st.integers(0, 2**20))
def test_strain_matrix_is_green_lagrange(name, seed):
    """B gamma = (F^T F - I)/2 in Voigt order with doubled shear, for any vectors v and any reference v0."""
    element, rng = ELEMENTS[name], np.random.default_rng(seed)
    count = 2 * len(element.directors) - 1
    v0 = straight_reference(element) + 0.05 * rng.normal(size=(count, 3))
    v = rng.normal(size=(count, 3))
    y, z = rng.uniform(-0.3, 0.3, (2, 4))
    _, weights = local_gradient(element, v0, y, z)
    i, j = np.triu_indices(count)
    gamma = np.sum(v[i] * v[j], axis=1) - np.sum(v0[i] * v0[j], axis=1)
    found = strain_matrix(weights) @ gamma
    a = gradient_weights(element, y, z)
    J, J0 = (np.einsum("ia,nib->nab", x, a) for x in (v, v0))
    F = J @ np.linalg.inv(J0) @ section_frame(element, v0)
    E = 0.5 * (np.swapaxes(F, -1, -2) @ F - np.eye(3))
    expected = np.stack([E[:, p, q] * (1 if p == q else 2) for p, q in VOIGT], axis=-1)
    np.testing.assert_allclose(found, expected, atol=1e-11)


@every_section
def test_generalised_vectors_are_the_derivatives_of_the_position(name):
    """r' = sum phi_k v_k and r - r(0, 0) = sum phi_k v_(K + k - 1) for r = sum phi_k d_k, anywhere in the
    section; r' by differences of r along the element.
    """
    element, h, t = ELEMENTS[name], 0.7, 1e-6
    e = np.random.default_rng(3).normal(size=(element.vectors_per_element, 3))
    xi, count = 0.31, len(element.directors)

    def r(xi, y, z):
        return element.section_monomials(y, z)[0][0] @ (element.shape(np.array([xi]), h)[0] @ e)

    v = generalised_shape(element, np.array([xi]), h)[0] @ e
    dx = 2.0 * t / h
    for y, z in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.4, -0.7)):
        phi = element.section_monomials(y, z)[0][0]
        np.testing.assert_allclose(
            phi @ v[:count], (r(xi + dx, y, z) - r(xi - dx, y, z)) / (2 * t), atol=1e-8
        )
        np.testing.assert_allclose(phi[1:] @ v[count:], r(xi, y, z) - r(xi, 0, 0), atol=1e-13)


@every_section
@given(source=draws())
def test_cylindrical_gradient_is_the_cartesian_one(name, source):
    """Paper eq. 42-45 with the corrections of paper-map.md, on a straight round rod in BCS:

    F = I + T [[D11, D12, D13/r], [D21, D22, (D23 - u_t)/r], [D31, D32, (D33 + u_r)/r]] T^T,

    D_ij = d u_i / d(x, r, theta),
    T the rotation about x by theta. The derivatives are central differences of the displacement in (x, r,
    theta).
    """
    allowed = RodRange(curved=(False,), shapes=("circle",), slenderness=(8.0, 20.0))
    model = random_model(source, name, allowed)
    element, A_o = model.element, model.rod.base.rotation
    state = random_state(source, model, 0.2)
    e, e0 = (x[model.mesh.nodes_of[0]].reshape(-1, 3) @ A_o for x in (state, model.q0))  # BCS: columns A_o^T
    h = model.mesh.h[0]
    R = model.rod.section.outer_radius

    def rotation(theta):
        return np.array([[1, 0, 0], [0, np.cos(theta), -np.sin(theta)], [0, np.sin(theta), np.cos(theta)]])

    def displacement(x, r, theta):
        """(u_x, u_r, u_theta) of the material point (x, r, theta)."""
        phi = element.section_monomials(r * np.cos(theta), r * np.sin(theta))[0][0]
        return rotation(theta).T @ (phi @ element.shape(np.array([2 * x / h - 1]), h)[0] @ (e - e0))

    x, r, theta = 0.4 * h, source.number(0.2, 1.0) * R, source.number(-3.0, 3.0)
    steps = 1e-5 * np.array([h, R, 1.0])
    D = np.column_stack(
        [
            (displacement(*(np.array([x, r, theta]) + s)) - displacement(*(np.array([x, r, theta]) - s)))
            / (2 * s.sum())
            for s in np.diag(steps)
        ]
    )
    u = displacement(x, r, theta)
    inner = np.array(
        [
            [D[0, 0], D[0, 1], D[0, 2] / r],
            [D[1, 0], D[1, 1], (D[1, 2] - u[2]) / r],
            [D[2, 0], D[2, 1], (D[2, 2] + u[1]) / r],
        ]
    )
    cylindrical = np.eye(3) + rotation(theta) @ inner @ rotation(theta).T
    y, z = (np.array([r * f(theta)]) for f in (np.cos, np.sin))
    _, J = kernel.frame_and_gradients(
        model, state[model.mesh.nodes_of[0]].reshape(-1, 3), 2 * x / h - 1, h, y, z
    )
    # differences: t^2 u''' and eps u / t, u up to the length of the rod over steps of 1e-5 R
    np.testing.assert_allclose(cylindrical, A_o.T @ J[0], atol=1e-7 * (1 + np.abs(u).max() / R))


@given(rotations(), draws())
def test_section_frame_is_the_polar_rotation_of_the_section(rotation, source):
    """A sheared reference r_y, r_z: x is the section normal, y and z are as near to r_y, r_z as can be,
    equally.
    """
    element = ELEMENTS["3333"]
    shear = source.number(-0.3, 0.3)
    r_y, r_z = rotation @ [0, np.cos(shear), np.sin(shear)], rotation @ [0, np.sin(shear), np.cos(shear)]
    v0 = np.zeros((5, 3))
    v0[0], v0[3], v0[4] = random_vector(source), r_y, r_z
    np.testing.assert_allclose(section_frame(element, v0), rotation, atol=1e-13)


def test_overlapping_reference_is_refused():
    """det J_0 = 1 - kappa_z y <= 0 beyond the centre of curvature: the message names the point."""
    element = ELEMENTS["3333"]
    v0 = np.zeros((5, 3))
    v0[0], v0[1], v0[3], v0[4] = [1, 0, 0], [-2.0, 0, 0], [0, 1, 0], [0, 0, 1]
    y = np.array([0.1, 0.51])
    with pytest.raises(SceneError, match=r"overlaps itself.*\n.*y = 0.51 m"):
        local_gradient(element, v0, y, np.zeros(2))
    J, weights = local_gradient(element, v0, y[:1], np.zeros(1))
    np.testing.assert_allclose(J[0], np.diag([0.8, 1.0, 1.0]), atol=1e-15)
    # F = sum_i v_i (a_i J_l^-1)^T = I at the reference
    np.testing.assert_allclose(np.einsum("ia,nib->nab", v0, weights)[0], np.eye(3), atol=1e-15)


@given(draws())
def test_director_weights_are_first_moments_of_the_monomials(source):
    """W_k = sum_b (int phi_k s_b dA) E_b: second moments of the section along the reference directors, 0 for
    the axis.
    """
    rotation = random_rotation(source)
    section = Rectangle(0.3, 0.1)
    d0 = np.vstack([random_vector(source), rotation[:, 1], rotation[:, 2]])
    W = director_weights(ELEMENTS["3333"], section, d0)
    I_z, I_y = 0.3**3 * 0.1 / 12, 0.3 * 0.1**3 / 12
    np.testing.assert_allclose(W, [[0, 0, 0], I_z * rotation[:, 1], I_y * rotation[:, 2]], atol=1e-17)
    assert not W[0].any()


def stiffness(section, material, formulation="enhanced", factors=(1.0, 1.0)):
    """H of one point of a straight 3333 rod along x."""
    rod = Rod("rod", 1.0, 1, section, material, formulation=formulation, shear_factors=factors)
    v0 = np.zeros((5, 3))
    v0[0], v0[3], v0[4] = np.eye(3)
    H = section_stiffness(ELEMENTS["3333"], rod, v0)
    shared = straight_section_stiffness(ELEMENTS["3333"], section, material, formulation, factors)
    np.testing.assert_allclose(shared, H, rtol=1e-13, atol=1e-13 * np.abs(H).max())
    return H


@pytest.mark.parametrize(("nu", "factor"), [(0.3, 1.3461538), (0.45, 3.7931034), (0.49, 17.1140940)])
def test_locking_factor_of_a_section(nu, factor):
    """theory.md 3: the full Hooke matrix bends with E (1-nu)/((1+nu)(1-2nu)), the enhanced form with E."""
    section, material = Annulus(0.02, 0.01), SaintVenantKirchhoff(3.0, nu)
    I = np.pi * (0.02**4 - 0.01**4) / 4  # noqa: E741
    # the product r_x . r_yx is the slope in y of the axial strain: U = 1/2 E I kappa^2
    assert stiffness(section, material, "continuum")[1, 1] == pytest.approx(3.0 * I * factor, rel=1e-7)
    assert stiffness(section, material, "enhanced")[1, 1] == pytest.approx(3.0 * I, rel=1e-12)


def test_shear_factors_go_to_their_own_shear():
    """interface.md: k_y scales gamma_xy, k_z gamma_xz, in `enhanced` only."""
    A = np.pi * 0.01
    H = stiffness(Circle(0.1), SaintVenantKirchhoff(2.6, 0.3), "enhanced", (0.7, 0.9))
    # pairs of (r_x, r_yx, r_zx, r_y, r_z): number 3 is r_x . r_y = gamma_xy, number 4 is gamma_xz; G = 1
    assert H[3, 3] == pytest.approx(0.7 * A, rel=1e-12)
    assert H[4, 4] == pytest.approx(0.9 * A, rel=1e-12)
    plain = stiffness(Circle(0.1), SaintVenantKirchhoff(2.6, 0.3), "continuum", (0.7, 0.9))
    assert plain[3, 3] == pytest.approx(A, rel=1e-12)


def test_one_matrix_serves_every_straight_rod():
    """The cache keys on section, material, formulation and factors: unequal rods must not share."""
    circle, soft = Circle(0.1), SaintVenantKirchhoff(1.0, 0.3)
    matrices = [
        stiffness(circle, soft),
        stiffness(circle, soft, "continuum"),
        stiffness(circle, soft, "enhanced", (0.5, 1.0)),
        stiffness(circle, SaintVenantKirchhoff(1.0, 0.2)),
        stiffness(Circle(0.2), soft),
        stiffness(Rectangle(0.1, 0.2), soft),
        stiffness(Rectangle(0.2, 0.1), soft),
    ]
    for i, a in enumerate(matrices):
        assert not any(np.allclose(a, b, rtol=1e-6) for b in matrices[:i])
