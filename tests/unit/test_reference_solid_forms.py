"""Displacement and mixed form of the solid reference: derivatives, projection, no locking."""

from functools import cache

import numpy as np
import pytest

from reference.solid import (
    SolidProblem,
    SolidStatus,
    bent_rod,
    clamped,
    full_clamp,
    section_states,
    soft_clamp,
    solve_solid,
)
from reference.solid_assembly import SolidAssembly
from reference.solid_forms import MixedForm, solid_form
from reference.solid_materials import NeoHookean
from reference.solid_mesh import circular_section, rectangular_section, rod_mesh
from tests.solid_rods import (
    LAWS,
    LENGTH,
    RADIUS,
    YOUNG,
    assert_second_order,
    bending_moment,
    exact_section,
    random_displacement,
    rotation,
    small_rod,
)

FORMS = ["displacement", "mixed"]


def forces(form, assembly, u):
    return assembly.internal_force(form.stress(assembly.deformation_gradient(u)))


def tangent(form, assembly, u):
    at = form.linearise(assembly.deformation_gradient(u))
    return assembly.tangent(at.A_pk1, K_element=at.K_element)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", FORMS)
def test_force_is_derivative_of_energy(law, name):
    mesh, assembly = small_rod()
    form = solid_form(name, law, assembly)
    u, du = random_displacement(mesh, size=2e-3), random_displacement(mesh, 6, size=1)
    work = np.sum(forces(form, assembly, u) * du)
    assert_second_order(lambda v: form.energy(assembly.deformation_gradient(v)), work, du, 1e-4, u)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", FORMS)
def test_tangent_is_derivative_of_force(law, name):
    mesh, assembly = small_rod()
    form = solid_form(name, law, assembly)
    u, du = random_displacement(mesh, size=2e-3), random_displacement(mesh, 6, size=1)
    exact = (tangent(form, assembly, u) @ du.ravel()).reshape(-1, 3)
    assert_second_order(lambda v: forces(form, assembly, v), exact, du, 1e-4, u)


@pytest.mark.parametrize("law", LAWS)
def test_mixed_tangent_is_symmetric(law):
    mesh, assembly = small_rod()
    K = tangent(MixedForm(law, assembly), assembly, random_displacement(mesh, size=2e-3)).toarray()
    np.testing.assert_allclose(K, K.T, atol=1e-13 * np.max(K))


@pytest.mark.parametrize("name", FORMS)
def test_stress_rate_is_derivative_of_stress(name):
    mesh, assembly = small_rod()
    form = solid_form(name, LAWS[1], assembly)
    F = assembly.deformation_gradient(random_displacement(mesh, size=2e-3))
    dF = assembly.gradient(random_displacement(mesh, 6, size=1))
    assert_second_order(form.stress, form.linearise(F).stress_rate(dF), dF, 1e-4, F)


def test_rigid_motion_leaves_the_mixed_energy_and_turns_the_force():
    mesh, assembly = small_rod()
    form, R = MixedForm(LAWS[1], assembly), rotation(7)
    u = random_displacement(mesh, size=2e-3)
    moved = (mesh.nodes + u - [1, 2, 3]) @ R.T - mesh.nodes
    F, F_moved = assembly.deformation_gradient(u), assembly.deformation_gradient(moved)
    assert form.energy(F_moved) == pytest.approx(form.energy(F), rel=1e-10)
    force = forces(form, assembly, u)
    np.testing.assert_allclose(forces(form, assembly, moved), force @ R.T, atol=1e-9 * np.max(np.abs(force)))


def test_projection_keeps_linear_fields_and_is_self_adjoint():
    _, assembly = small_rod()
    form = MixedForm(LAWS[0], assembly)
    X = assembly.points
    linear = 1 + 2 * X[..., 0] - 3 * X[..., 1] + 4 * X[..., 2]
    np.testing.assert_allclose(form.project(linear), linear, rtol=1e-12)
    f, g = np.random.default_rng(1).normal(size=(2, *X.shape[:2]))
    once = form.project(f)
    np.testing.assert_allclose(form.project(once), once, atol=1e-12)
    assert assembly.integrate(once * g) == pytest.approx(assembly.integrate(f * form.project(g)), rel=1e-10)
    # a field without mean and slope is removed
    assert np.max(np.abs(form.project(f - once))) < 1e-12


@pytest.mark.parametrize("law", LAWS)
def test_mixed_form_of_an_even_stretch_is_the_law(law):
    mesh, assembly = small_rod()
    F = np.broadcast_to(
        [[1.1, 0.05, 0.0], [0.02, 0.95, 0.03], [0.0, 0.04, 0.97]], (*assembly.volume.shape, 3, 3)
    )
    form = MixedForm(law, assembly)
    np.testing.assert_allclose(form.stress(F), law.stress(F), atol=1e-11 * YOUNG)
    volume = mesh.section.area * mesh.length
    assert form.energy(F) == pytest.approx(law.energy(F[0, 0]) * volume, rel=1e-12)


def test_mixed_rod_has_six_zero_modes():
    mesh, assembly = small_rod()
    K = tangent(MixedForm(NeoHookean(YOUNG, 0.499), assembly), assembly, np.zeros(mesh.nodes.shape))
    eigenvalues = np.linalg.eigvalsh(K.toarray())
    assert np.all(np.abs(eigenvalues[:6]) < 1e-11 * eigenvalues[-1])
    # the softest mode that strains does not feel the bulk modulus: as soft as at nu = 0.3 within a factor 2
    softest = np.linalg.eigvalsh(
        tangent(MixedForm(NeoHookean(YOUNG, 0.3), assembly), assembly, np.zeros(mesh.nodes.shape)).toarray()
    )[6]
    assert softest / 2 < eigenvalues[6] < 2 * softest


@cache
def curvature_gap(theta, nu, formulation, core=2, slices=20):
    """Relative gap of the curvature at mid-span against the thin rod."""
    mesh = rod_mesh(circular_section(RADIUS, core), LENGTH, slices)
    kappa = theta / LENGTH
    result = solve_solid(
        SolidProblem(
            mesh,
            NeoHookean(YOUNG, nu),
            soft_clamp(mesh),
            bent_rod(mesh, kappa, nu),
            moment=np.array([0, 0, bending_moment(theta)]),
            formulation=formulation,
        )
    )
    assert result.converged, result.reason
    return section_states(result).mean_curvature(LENGTH / 4)[2] / kappa - 1


@pytest.mark.parametrize("nu", [0.3, 0.4999])
def test_mixed_bending_is_the_exact_section_answer(nu):
    theta = np.pi / 2
    exact = exact_section(theta * RADIUS / LENGTH, NeoHookean(1.0, nu), degree=7).curvature
    exact_gap = exact / (theta * RADIUS / LENGTH) - 1
    # section error: the gap at vanishing load; axial error: fourth order in the slices
    fine, coarse = (curvature_gap(theta, nu, "mixed", slices=n) for n in (20, 12))
    axial = (fine - coarse) / ((20 / 12) ** 4 - 1)
    corrected = fine - curvature_gap(1e-4, nu, "mixed") + axial
    assert corrected == pytest.approx(exact_gap, abs=2e-5)
    # uncorrected: the mesh is stiff by less than 1e-3, at every nu
    assert 0 < exact_gap - fine < 1e-3


def test_displacement_form_locks_and_the_mixed_form_does_not():
    # Reference study, tip angle, nu = 0.49, core 2: displacements -2.40e-3 raw, mixed within 5e-4.
    theta = np.pi / 2
    assert curvature_gap(theta, 0.49, "displacement") < -2e-3
    drift = curvature_gap(theta, 0.4999, "mixed") - curvature_gap(theta, 0.3, "mixed")
    assert abs(drift) < 6e-4


def test_pressure_of_its_own_makes_nearly_incompressible_rods_easy():
    # Full clamp, nu = 0.4999, 90 degrees: 203 factorisations in 27 load steps with the pressure of the
    # displacements (reference study); from the bent start they did not converge at all.
    mesh = rod_mesh(circular_section(RADIUS, core=1), LENGTH, 10)
    law, fixed, kappa = NeoHookean(YOUNG, 0.4999), full_clamp(mesh), np.pi / 2 / LENGTH
    guess = clamped(bent_rod(mesh, kappa, 0.4999), fixed)
    moment = np.array([0, 0, bending_moment(np.pi / 2)])
    result = solve_solid(SolidProblem(mesh, law, fixed, guess, moment=moment, formulation="mixed"))
    assert result.converged, result.reason
    assert result.iterations <= 8


def test_given_pressure_enters_stress_and_tangent():
    # p against p + 1: one d2g/dF2 more in the tangent, one dg/dF more in the stress, nothing else
    mesh, assembly = small_rod()
    form = MixedForm(LAWS[1], assembly)
    F = assembly.deformation_gradient(random_displacement(mesh, size=2e-3))
    p = form.point_pressure(F)
    own, same, more = form.linearise(F), form.linearise(F, p), form.linearise(F, p + YOUNG)
    np.testing.assert_array_equal(own.A_pk1, same.A_pk1)
    np.testing.assert_allclose(own.P_pk1, form.stress(F), atol=1e-12 * YOUNG)
    _, g_F, g_FF = LAWS[1].volume_measure(F)
    np.testing.assert_allclose(more.P_pk1 - own.P_pk1, YOUNG * g_F, atol=1e-9 * YOUNG)
    np.testing.assert_allclose(more.A_pk1 - own.A_pk1, YOUNG * g_FF, atol=1e-9 * YOUNG)
    np.testing.assert_array_equal(more.K_element, own.K_element)


@pytest.mark.parametrize("name", FORMS)
def test_pressure_rate_is_derivative_of_pressure(name):
    mesh, assembly = small_rod()
    form = solid_form(name, LAWS[1], assembly)
    F = assembly.deformation_gradient(random_displacement(mesh, size=2e-3))
    dF = assembly.gradient(random_displacement(mesh, 6, size=1))
    rate = form.linearise(F).pressure_rate(dF)
    if name == "displacement":
        assert not np.any(rate)
        assert not np.any(form.point_pressure(F))
    else:
        assert_second_order(form.point_pressure, rate, dF, 1e-4, F)


def test_mixed_patch_of_homogeneous_stretch_is_exact():
    mesh = rod_mesh(rectangular_section(0.2, 0.15, 2, 2), 0.3, slices=2)
    F = np.array([[1.1, 0.05, 0.0], [0.02, 0.95, 0.03], [0.0, 0.04, 0.97]])
    law = NeoHookean(YOUNG, 0.499)
    x, y, z = np.abs(mesh.nodes.T)
    boundary = (x < 1e-9) | (x > 0.3 - 1e-9) | (y > 0.1 - 1e-9) | (z > 0.075 - 1e-9)
    affine = mesh.nodes @ (F - np.eye(3)).T
    guess = affine + np.where(boundary[:, None], 0, random_displacement(mesh, size=1e-4))
    fixed = np.repeat(boundary[:, None], 3, axis=1)
    result = solve_solid(SolidProblem(mesh, law, fixed, guess, formulation="mixed"))
    assert result.converged, result.reason
    np.testing.assert_allclose(result.positions, mesh.nodes @ F.T, atol=1e-11)


def test_projected_volume_outside_the_law_is_named():
    # ln of a negative projected volume: one point of an element is pulled far beyond the others.
    _, assembly = small_rod()
    form = MixedForm(LAWS[1], assembly)
    F = np.tile(np.eye(3), (*assembly.volume.shape, 1, 1))
    local = np.linalg.norm(assembly.points[0] - assembly.points[0].mean(axis=0), axis=1)
    far = int(np.argmax(local))
    F[0, far] = 20 * np.eye(3)
    reason = form.inadmissible(F)
    assert reason.startswith("projected volume -")
    assert "in element 0, point" in reason
    F[0, far] = -np.eye(3)
    assert form.inadmissible(F).startswith(f"det F = -1.00e+00 in element 0, point {far}")


def test_inadmissible_start_of_the_mixed_form_is_a_status():
    mesh, _ = small_rod()
    fixed = np.zeros(mesh.nodes.shape, bool)
    problem = SolidProblem(mesh, LAWS[1], fixed, -2 * mesh.nodes * [0, 1, 0], formulation="mixed")
    result = solve_solid(problem)
    assert result.status is SolidStatus.INVERTED_ELEMENT
    assert np.isinf(result.strain_energy)
    assert np.all(result.reactions == 0)


def test_unknown_form_is_refused():
    mesh, assembly = small_rod()
    with pytest.raises(ValueError, match='formulation is "hybrid"; "displacement" and "mixed"'):
        solid_form("hybrid", LAWS[0], assembly)  # pyright: ignore[reportArgumentType]
    assert isinstance(solid_form("mixed", LAWS[0], SolidAssembly(mesh, assembly.fixed)), MixedForm)
