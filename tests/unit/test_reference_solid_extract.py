"""Reading a solid as a rod: sections, stretch, curvature and stress of fields known in closed form."""

import numpy as np
import pytest

from reference.solid import (
    SolidProblem,
    bent_rod,
    helical_rod,
    section_states,
    section_stress,
    soft_clamp,
    solve_solid,
)
from reference.solid_assembly import SolidAssembly
from reference.solid_forms import MixedForm
from reference.solid_materials import SaintVenantKirchhoff
from reference.solid_mesh import annular_section, circular_section, rectangular_section, rod_mesh
from tests.solid_rods import LAWS, LENGTH, NU, RADIUS, RUBBER, YOUNG, bending_moment, exact_section, rotation

CURVATURE = np.array([3.0, 2.0, -5.0])  # twist and both curvatures [1/m]


def frozen(mesh, u, law=RUBBER, formulation="displacement"):
    """Result with the given displacement: every component is held."""
    result = solve_solid(SolidProblem(mesh, law, np.ones(u.shape, bool), u, formulation=formulation))
    assert result.iterations == 0
    return result


@pytest.mark.parametrize("section", [circular_section(RADIUS), annular_section(RADIUS, 0.6 * RADIUS)])
def test_helix_is_read_back(section):
    mesh = rod_mesh(section, LENGTH, slices=8)
    states = section_states(frozen(mesh, helical_rod(mesh, CURVATURE, 0.0)))
    np.testing.assert_allclose(states.arc_length, np.linspace(0, LENGTH, 17), atol=1e-15)
    np.testing.assert_allclose(states.curvature, np.tile(CURVATURE, (16, 1)), atol=1e-9)
    np.testing.assert_allclose(states.mean_curvature(LENGTH / 4), CURVATURE, atol=1e-9)
    np.testing.assert_allclose(states.axis, states.mean, atol=1e-12)
    np.testing.assert_allclose(states.stretch, 1, atol=1e-3)  # the spline of 17 planes
    assert (states.centre is None) == (section.centre is None)


def test_stretch_and_sections_of_an_affine_map():
    F = np.array([[1.1, 0.05, 0.0], [0.02, 0.95, 0.03], [0.0, 0.04, 0.97]])
    mesh = rod_mesh(circular_section(RADIUS), LENGTH, slices=3)
    states = section_states(frozen(mesh, mesh.nodes @ (F - np.eye(3)).T))
    np.testing.assert_allclose(states.stretch, np.linalg.norm(F[:, 0]), rtol=1e-12)
    np.testing.assert_allclose(states.mean, states.arc_length[:, None] * F[:, 0], atol=1e-15)
    # polar factor of the two section columns
    U, _, Vt = np.linalg.svd(F[:, 1:], full_matrices=False)
    np.testing.assert_allclose(states.rotation[:, :, 1:], np.tile(U @ Vt, (7, 1, 1)), atol=1e-12)


def quadratic_field(mesh, size=2.0):
    """u = quadratic polynomial of X with its gradient: in the space of straight 27-node elements."""
    C = size * np.random.default_rng(3).normal(size=(3, 3, 3))
    C = C + C.swapaxes(1, 2)
    u = np.einsum("ijk,nj,nk->ni", C, mesh.nodes, mesh.nodes)
    return u, lambda X: np.eye(3) + 2 * np.einsum("ijk,...k->...ij", C, X)


def test_curvature_is_that_of_the_section_frame():
    # a rigid turn of the whole rod leaves twist and curvatures alone
    mesh = rod_mesh(circular_section(RADIUS, core=1), LENGTH, slices=4)
    Q = rotation(7)
    turned = (mesh.nodes + helical_rod(mesh, CURVATURE, 0.0)) @ Q.T - mesh.nodes
    states = section_states(frozen(mesh, turned))
    np.testing.assert_allclose(states.rotation[0], Q, atol=1e-12)
    np.testing.assert_allclose(states.curvature, np.tile(CURVATURE, (8, 1)), atol=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_stress_at_points_is_that_of_the_law(law):
    mesh = rod_mesh(rectangular_section(0.02, 0.03, 2, 3), 0.05, slices=3)
    u, F = quadratic_field(mesh)
    points = np.random.default_rng(4).uniform([-0.01, -0.015], [0.01, 0.015], size=(7, 2))
    for s in (0.0, 0.021, 0.05):
        stress = section_stress(frozen(mesh, u, law), s, points)
        exact = F(np.column_stack([np.full(7, s), points]))
        np.testing.assert_allclose(stress.F, exact, atol=1e-12)
        np.testing.assert_allclose(stress.pk1, law.stress(exact), atol=1e-9 * YOUNG)
        J = np.linalg.det(exact)[:, None, None]
        np.testing.assert_allclose(J * stress.cauchy, stress.pk1 @ exact.swapaxes(1, 2), atol=1e-10 * YOUNG)
        np.testing.assert_allclose(stress.cauchy, stress.cauchy.swapaxes(1, 2), atol=1e-9 * YOUNG)


@pytest.mark.parametrize("formulation", ["displacement", "mixed"])
def test_stress_at_integration_points_is_that_of_the_form(formulation):
    mesh = rod_mesh(circular_section(RADIUS), 0.05, slices=2)
    u, _ = quadratic_field(mesh)
    law = LAWS[1]
    result = frozen(mesh, u, law, formulation)
    assembly = SolidAssembly(mesh, np.ones(u.shape, bool))
    F = assembly.deformation_gradient(u)
    expected = MixedForm(law, assembly).stress(F) if formulation == "mixed" else law.stress(F)
    element, plane = 19, slice(3, 27, 3)
    X = assembly.points[element]
    for point in range(27)[plane]:
        stress = section_stress(result, X[point, 0], X[point, None, 1:])
        np.testing.assert_allclose(stress.F[0], F[element, point], atol=1e-12)
        np.testing.assert_allclose(stress.pk1[0], expected[element, point], atol=1e-9 * YOUNG)


def test_stress_outside_the_rod_is_refused():
    mesh = rod_mesh(annular_section(RADIUS, 0.6 * RADIUS), 0.05, slices=2)
    result = frozen(mesh, np.zeros(mesh.nodes.shape))
    with pytest.raises(ValueError, match=r"s is 0\.06 m; it must lie between 0 and the length 0\.05 m"):
        section_stress(result, 0.06, np.array([[0.008, 0.0]]))
    for outside in ([0.0, 0.0], [0.0, 0.011]):
        with pytest.raises(ValueError, match=rf"y = 0.0 m, z = {outside[1]} m lies outside the section"):
            section_stress(result, 0.02, np.array([[0.008, 0.0], outside]))
    with pytest.raises(ValueError, match=r"margin is 0\.03 m; it must leave a part of the length"):
        section_states(result).mean_curvature(0.03)


def bent(theta, slices=20):
    mesh = rod_mesh(circular_section(RADIUS, core=2), LENGTH, slices)
    moment = np.array([0, 0, bending_moment(theta)])
    guess = bent_rod(mesh, theta / LENGTH, NU)
    result = solve_solid(SolidProblem(mesh, RUBBER, soft_clamp(mesh), guess, moment=moment))
    assert result.converged, result.reason
    return result


def test_curvature_at_mid_span_is_the_exact_section_answer():
    # Away from the end layers, which keep the tip angle 6e-5 off, nothing remains but the mesh:
    # its section (the gap at vanishing load) and its slices (fourth order).
    theta = np.pi / 2
    fine, coarse, section = (
        section_states(bent(angle, slices)).mean_curvature(LENGTH / 4)[2] * LENGTH / angle - 1
        for angle, slices in [(theta, 30), (theta, 20), (1e-5, 8)]
    )
    thin = theta * RADIUS / LENGTH
    exact = exact_section(thin, SaintVenantKirchhoff(1.0, NU)).curvature / thin - 1
    corrected = fine - section + (fine - coarse) / (1.5**4 - 1)
    assert corrected == pytest.approx(exact, abs=1e-5)


def test_stress_of_a_bent_section_is_navier():
    theta = 1e-3
    result = bent(theta, slices=10)
    points = np.array([[y, 0.0] for y in (-0.009, -0.004, 0.0, 0.005, 0.0095)])
    stress = section_stress(result, 0.23, points)
    R = section_states(result).rotation[11]
    local = R.T @ stress.cauchy @ R
    size = YOUNG * theta / LENGTH * RADIUS
    np.testing.assert_allclose(local[:, 0, 0], -YOUNG * theta / LENGTH * points[:, 0], atol=0.02 * size)
    assert np.max(np.abs(local[:, 1:, 1:])) < 0.05 * size
