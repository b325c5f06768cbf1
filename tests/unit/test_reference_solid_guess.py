"""Start values of the solid reference and load steps: the answer does not depend on the way to it."""

from dataclasses import replace

import numpy as np
import pytest

from reference.rotation import exp
from reference.solid import (
    SolidProblem,
    SolidStatus,
    bent_rod,
    clamped,
    full_clamp,
    helical_rod,
    lifted_rod,
    section_states,
    soft_clamp,
    solve_in_steps,
    solve_solid,
)
from reference.solid_assembly import SolidAssembly
from reference.solid_materials import NeoHookean
from reference.solid_mesh import circular_section, rod_mesh
from tests.solid_rods import LENGTH, NU, RADIUS, RUBBER, YOUNG, bending_moment

CURVATURE = np.array([3.0, 2.0, -5.0])  # twist and both curvatures [1/m]


def rod(law=RUBBER, slices=6, **changes):
    mesh = rod_mesh(circular_section(RADIUS, core=1), LENGTH, slices)
    values = {"fixed": soft_clamp(mesh), "guess": np.zeros(mesh.nodes.shape), **changes}
    return SolidProblem(mesh, law, **values)


def test_start_value_bent_both_ways_has_axial_stress_only():
    # Saint Venant: E (k_y z - k_z y) along the axis, nothing across, and shear G t r from the twist
    mesh = rod_mesh(circular_section(RADIUS, core=2), LENGTH, slices=4)
    assembly = SolidAssembly(mesh, soft_clamp(mesh))
    k = 1e-4 * np.array([0.5, 1.0, -2.0]) / RADIUS
    stress = RUBBER.stress(assembly.deformation_gradient(helical_rod(mesh, k, NU)))
    # back to the section's frame; what remains is the interpolation of the rim and of the arc
    x, y, z = np.moveaxis(assembly.points, -1, 0)
    local = exp(x[..., None] * k).swapaxes(-1, -2) @ stress
    size = YOUNG * np.linalg.norm(k) * RADIUS
    G = YOUNG / (2 * (1 + NU))
    expected = np.zeros_like(local)
    expected[..., 0, 0] = YOUNG * (k[1] * z - k[2] * y)
    expected[..., 0, 1] = expected[..., 1, 0] = -G * k[0] * z
    expected[..., 0, 2] = expected[..., 2, 0] = G * k[0] * y
    assert np.sqrt(np.mean((local - expected) ** 2)) < 0.01 * size


def test_bent_rod_is_the_planar_helix():
    mesh = rod().mesh
    x = mesh.nodes + bent_rod(mesh, np.pi / LENGTH, 0.0)
    y, z = mesh.section.nodes.T
    end = x[mesh.plane(-1)]
    radius = LENGTH / np.pi
    np.testing.assert_allclose(end, np.column_stack([0 * y, 2 * radius - y, z]), atol=1e-15)


def test_lifting_a_helix_gives_the_helix():
    mesh = rod().mesh
    s = np.linspace(0, LENGTH, 41)
    helix = helical_rod(mesh, CURVATURE, NU)
    x = mesh.nodes + helical_rod(mesh, CURVATURE, 0.0)
    axis = x[np.arange(13) * len(mesh.section.nodes) + mesh.section.centre]
    # a finer helix gives the stations
    fine = rod_mesh(circular_section(RADIUS, core=1), LENGTH, 20)
    position = (fine.nodes + helical_rod(fine, CURVATURE, 0.0))[
        np.arange(41) * len(mesh.section.nodes) + mesh.section.centre
    ]
    np.testing.assert_allclose(position[::10], axis[::3], atol=1e-12)
    lifted = lifted_rod(mesh, s, position, exp(s[:, None] * CURVATURE), np.tile(CURVATURE, (41, 1)), NU)
    np.testing.assert_allclose(lifted, helix, atol=1e-7 * LENGTH)  # the spline of 41 stations


def test_lifting_needs_the_whole_rod():
    mesh = rod().mesh
    turns = np.tile(np.eye(3), (3, 1, 1))
    for s in ([0, 0.2, 0.3], [0.0, 0.5, 0.4], [0.1, 0.2, LENGTH]):
        with pytest.raises(ValueError, match="must rise from 0 to the rod's length"):
            lifted_rod(mesh, np.array(s), np.zeros((3, 3)), turns, np.zeros((3, 3)), NU)


def test_clamped_guess_rests_on_its_support():
    mesh = rod().mesh
    fixed = full_clamp(mesh)
    guess = bent_rod(mesh, 5.0, NU)
    held = clamped(guess, fixed)
    np.testing.assert_array_equal(held[fixed], 0)
    np.testing.assert_array_equal(held[~fixed], guess[~fixed])
    assert np.all(fixed[mesh.plane(0)])
    assert np.sum(fixed) == 3 * len(mesh.section.nodes)


@pytest.mark.parametrize("formulation", ["displacement", "mixed"])
def test_straight_start_and_bent_start_meet(formulation):
    law = RUBBER if formulation == "displacement" else NeoHookean(YOUNG, 0.49)
    theta = np.pi if formulation == "displacement" else np.pi / 2
    straight = rod(law, moment=np.array([0, 0, bending_moment(theta)]), formulation=formulation)
    bent = replace(straight, guess=bent_rod(straight.mesh, theta / LENGTH, law.poisson_ratio))
    slow, fast = solve_in_steps(straight), solve_solid(bent)
    assert slow.converged, slow.reason
    assert fast.converged, fast.reason
    np.testing.assert_allclose(slow.positions, fast.positions, atol=1e-8 * LENGTH)
    assert slow.iterations > fast.iterations


def test_lifted_start_and_helical_start_meet_in_space():
    k = CURVATURE / 5
    G = YOUNG / (2 * (1 + NU))
    stiffness = np.array([2 * G, YOUNG, YOUNG]) * np.pi * RADIUS**4 / 4
    problem = rod(follower_moment=stiffness * k)
    problem = replace(problem, fixed=full_clamp(problem.mesh))
    guess = clamped(helical_rod(problem.mesh, k, NU), problem.fixed)
    direct = solve_solid(replace(problem, guess=guess))
    states = section_states(direct)
    curvature = np.vstack([states.curvature, states.curvature[-1:]])
    again = lifted_rod(problem.mesh, states.arc_length, states.axis, states.rotation, curvature, NU)
    lifted = solve_solid(replace(problem, guess=clamped(again, problem.fixed)))
    stepped = solve_in_steps(problem, 1)
    for other in (lifted, stepped):
        assert other.converged, other.reason
        np.testing.assert_allclose(other.positions, direct.positions, atol=1e-8 * LENGTH)


def test_a_step_that_fails_is_halved():
    # from the straight shape a quarter circle takes more than the four iterations allowed
    problem = rod(slices=4, moment=np.array([0, 0, bending_moment(np.pi / 2)]), max_iterations=4)
    assert not solve_solid(problem).converged
    result = solve_in_steps(problem, 1)
    assert result.converged, result.reason
    assert result.problem is problem


def test_steps_that_lead_nowhere_say_how_far_they_came():
    problem = rod(slices=2, moment=np.array([0, 0, 1e5 * bending_moment(1)]), max_iterations=3)
    result = solve_in_steps(problem, 1)
    assert result.status is not SolidStatus.CONVERGED
    assert result.reason.startswith("load factor 0.0")
    assert "a step of 2.0e-03 fails: " in result.reason
    assert np.all(np.isfinite(result.positions))
    assert np.isfinite(result.strain_energy)


def test_number_of_steps_is_checked():
    with pytest.raises(ValueError, match="steps is 0; at least 1"):
        solve_in_steps(rod(slices=1), 0)
