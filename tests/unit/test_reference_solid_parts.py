"""Parts of the solid reference: law, mesh, assembly, block solver, end couple, patch test.

"Reference study" marks numbers derived in this project with independent code before this module was written.
"""

import numpy as np
import pytest
from scipy.sparse import bmat, csr_array, random_array
from scipy.sparse.linalg import spsolve

from reference.solid import SolidProblem, soft_clamp, solve_solid
from reference.solid_assembly import SolidAssembly
from reference.solid_couple import couple_force, section_moments, section_rotation, section_spin
from reference.solid_linear import solve_block_tridiagonal
from reference.solid_materials import SaintVenantKirchhoff
from reference.solid_mesh import circular_section, rod_mesh
from tests.solid_rods import (
    LENGTH,
    NU,
    RADIUS,
    RUBBER,
    YOUNG,
    assert_second_order,
    random_displacement,
    rotation,
    small_rod,
)

# --- law ----------------------------------------------------------------------------------------------------


def deformations(n=4):
    return np.eye(3) + 0.2 * np.random.default_rng(1).normal(size=(n, 3, 3))


def test_stress_is_derivative_of_energy():
    F, dF = deformations(), np.random.default_rng(2).normal(size=(4, 3, 3))
    exact = np.sum(RUBBER.stress(F) * dF, axis=(-2, -1))
    assert_second_order(RUBBER.energy, exact, dF, 1e-3, F)


def test_tangent_is_derivative_of_stress():
    F, dF = deformations(), np.random.default_rng(2).normal(size=(4, 3, 3))
    exact = np.einsum("...iJkL,...kL->...iJ", RUBBER.tangent(F), dF)
    assert_second_order(RUBBER.stress, exact, dF, 1e-3, F)


def test_law_is_objective_and_isotropic():
    F, Q = deformations(), rotation(3)
    np.testing.assert_allclose(RUBBER.energy(Q @ F), RUBBER.energy(F), rtol=1e-13)
    np.testing.assert_allclose(RUBBER.energy(F @ Q), RUBBER.energy(F), rtol=1e-13)
    np.testing.assert_allclose(RUBBER.stress(Q @ F), Q @ RUBBER.stress(F), atol=1e-9 * YOUNG)


def test_uniaxial_stress_is_young_modulus_times_green_lagrange_strain():
    # S = E E_xx when the lateral strains are -nu E_xx: Hooke's law in Green-Lagrange strain.
    stretch = 1.2
    E_xx = (stretch**2 - 1) / 2
    lateral = np.sqrt(1 - 2 * NU * E_xx)
    P = RUBBER.stress(np.diag([stretch, lateral, lateral]))
    np.testing.assert_allclose(P, np.diag([stretch * YOUNG * E_xx, 0, 0]), atol=1e-10 * YOUNG)


def test_law_refuses_what_is_outside_its_range():
    with pytest.raises(ValueError, match=r"poisson_ratio is 0\.5"):
        SaintVenantKirchhoff(YOUNG, 0.5)
    with pytest.raises(ValueError, match=r"young_modulus is -1"):
        SaintVenantKirchhoff(-1, NU)


# --- mesh ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("core", "rings"), [(1, 1), (2, 1), (3, 2)])
def test_matched_section_has_the_exact_second_moment(core, rings):
    section = circular_section(RADIUS, core, rings)
    np.testing.assert_allclose(section.second_moments, np.pi * RADIUS**4 / 4 * np.eye(2), atol=1e-22)
    # the area then errs in the eighth order of the arc, by -1.3e-7 at core 2 (reference study)
    assert section.area == pytest.approx(np.pi * RADIUS**2, rel=3.4e-5 / core**8)


def test_unmatched_quadratic_arcs_miss_the_second_moment():
    # -1.6e-3 for eight arcs (reference study). A parabola through three points of an arc of half angle
    # t = pi/8 lies inside the circle by R t^4/8 (u^2 - u^4); the mean over u is t^4/60, and I ~ R^4.
    section = circular_section(RADIUS, core=2, match_I=False)
    error = section.second_moments[0, 0] / (np.pi * RADIUS**4 / 4) - 1
    assert error == pytest.approx(-4 * (np.pi / 8) ** 4 / 60, rel=0.05)
    assert error == pytest.approx(-1.6e-3, abs=0.05e-3)


def test_rod_mesh_is_numbered_by_planes():
    mesh = rod_mesh(circular_section(RADIUS), LENGTH, slices=3)
    assert len(mesh.section.nodes) == 57  # 12 nine-node quads: 17 corners, 28 edges, 12 centres
    assert mesh.nodes.shape == (7 * 57, 3)
    np.testing.assert_array_equal(mesh.hexes.doflocs[:, mesh.order].T, mesh.nodes)
    np.testing.assert_allclose(mesh.nodes[mesh.plane(-1), 0], LENGTH)
    np.testing.assert_allclose(mesh.nodes[mesh.section.centre, 1:], 0, atol=1e-18)
    assert mesh.nodes[mesh.section.rim[0], 1] == pytest.approx(RADIUS, rel=1e-3)
    assert mesh.nodes[mesh.section.rim[0], 2] == pytest.approx(0, abs=1e-17)
    volume = SolidAssembly(mesh, soft_clamp(mesh)).volume.sum()
    assert volume == pytest.approx(mesh.section.area * LENGTH, rel=1e-13)


# --- assembly -----------------------------------------------------------------------------------------------


def internal_force(assembly, u):
    return assembly.internal_force(RUBBER.stress(assembly.deformation_gradient(u)))


def tangent(assembly, u):
    return assembly.tangent(RUBBER.tangent(assembly.deformation_gradient(u)))


def test_force_is_derivative_of_energy():
    mesh, assembly = small_rod()
    u, du = random_displacement(mesh), random_displacement(mesh, 6, size=1)

    def energy(v):
        return assembly.integrate(RUBBER.energy(assembly.deformation_gradient(v)))

    assert_second_order(energy, np.sum(internal_force(assembly, u) * du), du, 2e-4, u)


def test_tangent_is_derivative_of_force():
    mesh, assembly = small_rod()
    u, du = random_displacement(mesh), random_displacement(mesh, 6, size=1)
    exact = (tangent(assembly, u) @ du.ravel()).reshape(-1, 3)
    assert_second_order(lambda v: internal_force(assembly, v), exact, du, 2e-4, u)


def test_tangent_is_symmetric():
    mesh, assembly = small_rod()
    K = tangent(assembly, random_displacement(mesh)).toarray()
    np.testing.assert_allclose(K, K.T, atol=1e-13 * np.max(K))


def test_rigid_motion_gives_no_force():
    mesh, assembly = small_rod()
    u = (mesh.nodes - [1, 2, 3]) @ rotation(7).T - mesh.nodes
    # round-off of the strain: displacement 3 m by a node spacing of 0.03 m, times 1e-16 and a sum of 27 terms
    assert np.max(np.abs(internal_force(assembly, u))) < 1e-12 * YOUNG * mesh.section.area


def test_unloaded_rod_has_six_zero_modes():
    mesh, assembly = small_rod()
    eigenvalues = np.linalg.eigvalsh(tangent(assembly, np.zeros(mesh.nodes.shape)).toarray())
    assert np.all(np.abs(eigenvalues[:6]) < 1e-12 * eigenvalues[-1])
    assert eigenvalues[6] > 1e-5 * eigenvalues[-1]


def test_held_components_have_identity_rows():
    mesh, free = small_rod()
    assembly = SolidAssembly(mesh, soft_clamp(mesh))
    K, K_free = (tangent(a, random_displacement(mesh)).toarray() for a in (assembly, free))
    held = assembly.fixed.ravel()
    np.testing.assert_array_equal(K[held], np.eye(len(K))[held])
    np.testing.assert_array_equal(K[:, held], np.eye(len(K))[:, held])
    np.testing.assert_array_equal(K[np.ix_(~held, ~held)], K_free[np.ix_(~held, ~held)])


def test_block_solver_agrees_with_superlu():
    rng = np.random.default_rng(8)
    sizes = [5, 7, 4, 6]
    blocks = [
        [random_array((m, n), density=0.5, rng=rng) if abs(i - j) < 2 else None for j, n in enumerate(sizes)]
        for i, m in enumerate(sizes)
    ]
    K = csr_array(bmat(blocks))
    right = rng.normal(size=22)
    x = solve_block_tridiagonal(K, right, [0, 5, 12, 16, 22])
    np.testing.assert_allclose(x, np.asarray(spsolve(K, right)), rtol=1e-9)


def test_block_solver_takes_uncoupled_blocks_and_names_a_singular_one():
    diagonal = np.array([1.0, 2, 3, 4])
    np.testing.assert_allclose(
        solve_block_tridiagonal(csr_array(np.diag(diagonal)), np.ones(4), [0, 2, 4]), 1 / diagonal
    )
    with pytest.raises(np.linalg.LinAlgError, match="pivot block 1 of 2"):
        diagonal[2] = 0
        solve_block_tridiagonal(csr_array(np.diag(diagonal) + np.eye(4, k=1) * 0), np.ones(4), [0, 2, 4])


# --- end couple ---------------------------------------------------------------------------------------------


def bent_section(seed=9):
    """Positions of a turned end section with some 10 % of distortion, its moments, a couple."""
    section = circular_section(RADIUS, core=1)
    rng = np.random.default_rng(seed)
    X = np.column_stack([np.zeros(len(section.nodes)), section.nodes])
    x = X @ (np.eye(3) + 0.1 * rng.normal(size=(3, 3))).T @ rotation(seed).T
    x += 0.02 * RADIUS * rng.normal(size=x.shape)
    return x, section_moments(section.nodes, section.mass), rng.normal(size=3)


def couple(x, W, moment):
    return couple_force(section_spin(x, W), moment, np.zeros(3))


def test_section_moments_have_no_sum_and_carry_the_second_moment():
    section = circular_section(RADIUS)
    W = section_moments(section.nodes, section.mass)
    np.testing.assert_allclose(W.sum(axis=0), 0, atol=1e-15 * np.abs(W).sum())
    np.testing.assert_allclose(section.nodes.T @ W[:, 1:], section.second_moments, atol=1e-22)


@pytest.mark.parametrize("seed", [9, 10, 11])
def test_couple_has_no_resultant_and_the_prescribed_moment(seed):
    x, W, moment = bent_section(seed)
    force, _ = couple(x, W, moment)
    assert np.linalg.norm(force.sum(axis=0)) < 1e-14 * np.abs(force).sum()
    origin = np.array([1.0, 2, 3]) * RADIUS
    total = np.cross(x - origin, force).sum(axis=0)
    assert np.linalg.norm(total - moment) < 1e-14 * np.abs(x - origin).max() * np.abs(force).sum()


def test_couple_works_on_the_spin_of_the_polar_rotation():
    x, W, moment = bent_section()
    dx = np.random.default_rng(12).normal(size=x.shape)
    force, _ = couple(x, W, moment)
    R = section_rotation(x, W)

    def work_angle(y):
        spin = section_rotation(y, W) @ R.T
        return moment @ [spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]] / 2

    assert_second_order(work_angle, np.sum(force * dx), dx, 0.05 * RADIUS, x)


def test_couple_tangent_is_derivative_of_force():
    x, W, moment = bent_section()
    dx = np.random.default_rng(12).normal(size=x.shape)
    exact = (couple(x, W, moment)[1] @ dx.ravel()).reshape(-1, 3)
    assert_second_order(lambda y: couple(y, W, moment)[0], exact, dx, 0.05 * RADIUS, x)


def test_section_rotation_is_that_of_a_rigid_section():
    section = circular_section(RADIUS)
    W = section_moments(section.nodes, section.mass)
    X = np.column_stack([np.zeros(57), section.nodes])
    for seed in range(4):
        np.testing.assert_allclose(section_rotation(X @ rotation(seed).T + 1, W), rotation(seed), atol=1e-12)


# --- patch test ---------------------------------------------------------------------------------------------


def test_patch_of_homogeneous_stretch_is_exact():
    """The boundary follows an affine map: inside, Newton finds the same map from a disturbed start."""
    mesh, assembly = small_rod()
    F = np.array([[1.1, 0.05, 0.0], [0.02, 0.95, 0.03], [0.0, 0.04, 0.97]])
    affine = mesh.nodes @ (F - np.eye(3)).T
    radii = np.linalg.norm(mesh.nodes[:, 1:], axis=1)
    boundary = (radii > 0.09) | (mesh.nodes[:, 0] == 0) | (mesh.nodes[:, 0] == mesh.length)
    guess = affine + np.where(boundary[:, None], 0, random_displacement(mesh, size=2e-3))
    result = solve_solid(SolidProblem(mesh, RUBBER, np.repeat(boundary[:, None], 3, axis=1), guess))
    assert result.converged
    np.testing.assert_allclose(result.positions, mesh.nodes @ F.T, atol=1e-13)
    volume = mesh.section.area * mesh.length
    assert result.strain_energy == pytest.approx(RUBBER.energy(F) * volume, rel=1e-12)
    # traction of the end face: P e_x times its area
    radial = (radii > 0.09)[mesh.plane(-1)]
    end_force = internal_force(assembly, affine)[mesh.plane(-1)]
    assert np.sum(~radial) == 17
    weights = mesh.section.mass.sum(axis=0)
    expected = np.outer(weights, RUBBER.stress(F)[:, 0])
    np.testing.assert_allclose(end_force[~radial], expected[~radial], atol=1e-12 * YOUNG * mesh.section.area)
