"""Loads of the solid reference: tangents by differences, resultants, thin-rod and documented answers."""

from dataclasses import replace

import numpy as np
import pytest

from reference.solid import (
    SolidProblem,
    bent_rod,
    clamped,
    full_clamp,
    helical_rod,
    soft_clamp,
    solve_in_steps,
    solve_solid,
)
from reference.solid_couple import (
    couple_force,
    resultant_force,
    section_moments,
    section_rotation,
    section_spin,
)
from reference.solid_mesh import circular_section, rod_mesh
from reference.solid_newton import Newton
from reference.solid_problem import LOADS
from tests.solid_rods import (
    LENGTH,
    NU,
    RADIUS,
    RUBBER,
    SECOND_MOMENT,
    YOUNG,
    assert_second_order,
    bending_moment,
    random_displacement,
    rotation,
)

AREA = np.pi * RADIUS**2
FORCE = YOUNG * SECOND_MOMENT / LENGTH**2  # unit of a dimensionless tip force
GA_S = YOUNG / (2 * (1 + NU)) * AREA * 6 * (1 + NU) / (7 + 6 * NU)  # Cowper 1966, circle


def turned_section(seed=9):
    section = circular_section(RADIUS, core=1)
    rng = np.random.default_rng(seed)
    X = np.column_stack([np.zeros(len(section.nodes)), section.nodes])
    x = X @ (np.eye(3) + 0.1 * rng.normal(size=(3, 3))).T @ rotation(seed).T
    share = section.mass.sum(axis=0) / section.area
    return x + 0.02 * RADIUS * rng.normal(size=x.shape), section_moments(section.nodes, section.mass), share


@pytest.mark.parametrize("seed", [9, 10])
def test_follower_couple_is_the_turned_couple_and_its_tangent_follows(seed):
    x, W, _ = turned_section(seed)
    carried, zero = np.array([0.3, -1.0, 0.7]), np.zeros(3)

    def force(y):
        return couple_force(section_spin(y, W), zero, carried)[0]

    total = np.cross(x, force(x)).sum(axis=0)
    np.testing.assert_allclose(total, section_rotation(x, W) @ carried, rtol=1e-12, atol=1e-12)
    dx = np.random.default_rng(12).normal(size=x.shape)
    exact = (couple_force(section_spin(x, W), zero, carried)[1] @ dx.ravel()).reshape(-1, 3)
    assert_second_order(force, exact, dx, 0.05 * RADIUS, x)


def test_tip_force_has_its_resultant_at_the_area_mean_and_its_tangent_follows():
    x, W, share = turned_section()
    dead, carried = np.array([1.0, 2, 3]), np.array([0.3, -1.0, 0.7])

    def force(y):
        return resultant_force(section_spin(y, W), share, dead, carried)[0]

    resultant = dead + section_rotation(x, W) @ carried
    np.testing.assert_allclose(force(x).sum(axis=0), resultant, rtol=1e-13)
    np.testing.assert_allclose(np.cross(x, force(x)).sum(axis=0), np.cross(share @ x, resultant), atol=1e-12)
    dx = np.random.default_rng(12).normal(size=x.shape)
    exact = (resultant_force(section_spin(x, W), share, dead, carried)[1] @ dx.ravel()).reshape(-1, 3)
    assert_second_order(force, exact, dx, 0.05 * RADIUS, x)


@pytest.mark.parametrize("formulation", ["displacement", "mixed"])
@pytest.mark.parametrize("load", LOADS)
def test_newton_direction_solves_the_linearised_balance(load, formulation):
    # the out-of-balance force along the Newton step falls to zero with the square of the step
    mesh = rod_mesh(circular_section(0.1, core=1), 0.3, slices=2)
    size = {"moment": 1.0, "follower_moment": 1.0, "force": 10.0, "follower_force": 10.0, "start_force": 10.0,
            "body_force": 1e3}  # fmt: skip
    value = size[load] * YOUNG * 1e-4 * np.array([0.3, -1.0, 0.7])
    u = np.where(full_clamp(mesh), 0, random_displacement(mesh, size=2e-3))
    problem = SolidProblem(mesh, RUBBER, full_clamp(mesh), u, formulation=formulation, **{load: value})
    newton = Newton(problem, begin=0.0)
    newton.p = newton.form.point_pressure(newton.F)  # else the tangent is that of a stress-free start
    newton.evaluate()
    before, du = newton.right, newton.direction()
    errors = []
    for fraction in (0.02, 0.01):
        newton.restart(replace(problem, guess=u + fraction * du), newton.p)
        newton.evaluate()
        errors.append(np.linalg.norm(newton.right - (1 - fraction) * before))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.1)


def rod(core=1, slices=8, support=soft_clamp, **loads):
    mesh = rod_mesh(circular_section(RADIUS, core), LENGTH, slices)
    return SolidProblem(mesh, RUBBER, support(mesh), np.zeros(mesh.nodes.shape), **loads)


def test_supports_carry_the_loads():
    # exact for the discrete rod: the moment of a dead tip force acts at the area mean of the end section
    loads = {
        "moment": np.array([0.1, 0.2, 0.3]) * bending_moment(1),
        "follower_moment": np.array([-0.1, 0.3, 0.2]) * bending_moment(1),
        "force": np.array([0.1, 0.5, -0.4]) * FORCE,
        "follower_force": np.array([0.2, -0.3, 0.5]) * FORCE,
    }
    result = solve_in_steps(rod(slices=4, support=full_clamp, **loads), 2)
    assert result.converged, result.reason
    R, tip = result.tip_rotation, result.tip_position
    force = loads["force"] + R @ loads["follower_force"]
    moment = loads["moment"] + R @ loads["follower_moment"] + np.cross(tip, force)
    np.testing.assert_allclose(result.reaction_force, -force, atol=1e-8 * FORCE)
    np.testing.assert_allclose(result.reaction_moment, -moment, atol=1e-8 * bending_moment(1))


def test_supports_carry_the_weight():
    problem = rod(slices=4, body_force=np.array([0.0, -2 * FORCE / (AREA * LENGTH), 0.0]))
    result = solve_in_steps(problem, 1)
    assert result.converged, result.reason
    weight = problem.body_force * problem.mesh.section.area * LENGTH
    np.testing.assert_allclose(result.reaction_force, -weight, atol=1e-9 * FORCE)


def test_a_start_force_takes_the_load_off_the_point_supports_of_a_soft_clamp():
    force = np.array([0.0, FORCE, 0.0])
    result = solve_in_steps(rod(slices=6, force=force, start_force=-force), 1)
    assert result.converged, result.reason
    assert np.abs(result.reactions[:, 1:]).max() < 1e-8 * FORCE
    held = solve_in_steps(rod(slices=6, force=force), 1)
    assert np.abs(held.reactions[:, 1:]).max() > 0.99 * FORCE


def test_small_tip_force_bends_the_timoshenko_rod():
    # F L^3/(3 EI) + F L/(G A_s); the section is stiff by 3.2e-4 at core 2 (reference study)
    result = solve_solid(rod(core=2, slices=20, force=np.array([0, 1e-5 * FORCE, 0])))
    exact = 1e-5 * FORCE * (LENGTH**3 / (3 * YOUNG * SECOND_MOMENT) + LENGTH / GA_S)
    assert result.tip_position[1] == pytest.approx(exact, rel=4e-4)


def test_small_weight_bends_the_timoshenko_rod():
    # q L^4/(8 EI) + q L^2/(2 G A_s); the section as above
    q = 1e-5 * FORCE / LENGTH
    result = solve_solid(rod(core=2, slices=20, body_force=np.array([0, 0, q / AREA])))
    exact = q * (LENGTH**4 / (8 * YOUNG * SECOND_MOMENT) + LENGTH**2 / (2 * GA_S))
    assert result.tip_position[2] == pytest.approx(exact, rel=4e-4)


def test_follower_couple_in_the_plane_is_the_fixed_one():
    # a couple about z turns about z: both are the same load
    base = rod(slices=6)
    base = replace(base, guess=bent_rod(base.mesh, np.pi / LENGTH, NU))
    moment = np.array([0, 0, bending_moment(np.pi)])
    fixed, follower = (
        solve_solid(replace(base, moment=moment)),
        solve_solid(replace(base, follower_moment=moment)),
    )
    np.testing.assert_allclose(follower.positions, fixed.positions, atol=1e-10 * LENGTH)


def test_torsion_and_its_poynting_shortening():
    # Reference study, core 2, 10 slices, pi/2: twist +3.8e-4 above M L/GJ, shortening 2.1e-4 of the length
    twist = np.pi / 2
    problem = rod(core=2, slices=10, support=full_clamp)
    guess = clamped(helical_rod(problem.mesh, np.array([twist / LENGTH, 0, 0]), NU), problem.fixed)
    moment = np.array([YOUNG / (2 * (1 + NU)) * 2 * SECOND_MOMENT * twist / LENGTH, 0, 0])
    result = solve_solid(replace(problem, guess=guess, moment=moment))
    assert result.converged, result.reason
    R = result.tip_rotation
    assert np.arctan2(R[2, 1], R[1, 1]) / twist - 1 == pytest.approx(3.8e-4, abs=0.1e-4)
    assert 1 - result.tip_position[0] / LENGTH == pytest.approx(2.1e-4, abs=0.1e-4)


def test_load_factor_scales_every_load():
    loads = {name: np.array([1.0, 2, 3]) * (k + 1) for k, name in enumerate(LOADS)}
    half = rod(slices=1, **loads).with_load_factor(0.5)
    for name in LOADS:
        np.testing.assert_array_equal(getattr(half, name), loads[name] / 2)


def test_loads_of_the_wrong_shape_are_named():
    with pytest.raises(ValueError, match=r"follower_force has the shape \(2,\); \(3,\) is needed"):
        rod(slices=1, follower_force=np.zeros(2))
    with pytest.raises(ValueError, match="body_force is not finite"):
        rod(slices=1, body_force=np.array([0, np.nan, 0]))
