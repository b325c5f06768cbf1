"""Solutions against the Reissner rod of reference/ (collocation, 1e-9, no code shared) and the follower's
closed form.

What separates the two on a slender rod is finite strain, (section radius / bending radius)^2, and the mesh.
theory.md 3: 6.6e-4 at L/R = 100 for |M| L/E I = 2.5 with 12 elements; 2e-3 is demanded of all loads here.
"""

from dataclasses import replace

import numpy as np
import pytest

from ancf.materials import SaintVenantKirchhoff
from ancf.scene import Force, Frame, Gravity, LineLoad, Moment, Rod, Scene
from ancf.sections import Circle, Rectangle
from reference.analytic import helix_tip_moment
from reference.rod import RodLoads, RodProperties, solve_rod
from validation.random_rods import RngDraws, random_rotation
from validation.solution_measures import bending_stiffness, solved

LIMIT = 2e-3
NU, DENSITY = 0.3, 900.0


def reference(rod, **loads):
    """The same rod and loads in reference/; J = I_y + I_z, which a section that stays plane has."""
    I_z, I_y = rod.section.second_moments[0, 0], rod.section.second_moments[1, 1]
    properties = RodProperties.from_section(
        rod.length,
        rod.material.young_modulus,
        NU,
        rod.section.area,
        I_y,
        I_z,
        curvature=rod.curvature,
        base_position=rod.base.position,
        base_rotation=rod.base.rotation,
    )
    return solve_rod(properties, RodLoads(**loads), np.array([0.0, 0.4, 1.0]) * rod.length, tolerance=1e-9)


def arm(seed, curved):
    """Rectangle 1.5 : 1 of slenderness 100, bases in any direction."""
    rng = np.random.default_rng(seed)
    return Rod(
        "arm",
        1.0,
        16,
        Rectangle(0.03, 0.02),
        SaintVenantKirchhoff(1e6, NU, DENSITY),
        base=Frame(rng.uniform(-1, 1, 3), random_rotation(RngDraws(rng))),
        curvature=rng.uniform(-0.8, 0.8, 3) if curved else np.zeros(3),
    )


@pytest.mark.parametrize("curved", [False, True], ids=["straight", "curved"])
@pytest.mark.parametrize(
    "kind", ["force", "follower force", "moment", "follower moment", "line load", "gravity", "all"]
)
def test_every_load_on_a_rod(kind, curved):
    rod = arm(len(kind), curved)
    rng = np.random.default_rng(len(kind) + 10 * curved)
    unit = bending_stiffness(rod)
    f, m, w = (rng.uniform(-1, 1, 3) * size * unit for size in (2.0, 1.5, 2.0))
    weight = DENSITY * rod.section.area
    loads, scene = {
        "force": ({"tip_force": f}, {"forces": (Force("arm", 1.0, f),)}),
        "follower force": (
            {"follower_tip_force": f},
            {"forces": (Force("arm", 1.0, f, direction="follower"),)},
        ),
        "moment": ({"tip_moment": m}, {"moments": (Moment("arm", 1.0, m),)}),
        "follower moment": ({"follower_tip_moment": m}, {"moments": (Moment("arm", 1.0, m, "follower"),)}),
        "line load": ({"line_load": w}, {"line_loads": (LineLoad("arm", w),)}),
        "gravity": ({"line_load": w}, {"gravity": Gravity(w / weight)}),
        "all": (
            {"tip_force": f, "tip_moment": m, "line_load": w},
            {
                "forces": (Force("arm", 1.0, f),),
                "moments": (Moment("arm", 1.0, m),),
                "line_loads": (LineLoad("arm", w),),
            },
        ),
    }[kind]
    exact = reference(rod, **loads)
    solution = solved(Scene((rod,), **scene))
    for i, at in enumerate((0.0, 0.4, 1.0)):
        pose = solution.pose(None, at)
        np.testing.assert_allclose(pose.position, exact.position[i], atol=LIMIT)
        np.testing.assert_allclose(pose.rotation, exact.rotation[i], atol=2 * LIMIT)
    # the support carries what the rod carries at its base; dead forces add up exactly
    force, moment = solution.reaction()
    np.testing.assert_allclose(force, -exact.force[0], atol=(LIMIT if "follower" in kind else 1e-8) * unit)
    np.testing.assert_allclose(moment, -exact.moment[0], atol=2 * LIMIT * unit)


@pytest.mark.parametrize("nu", [0.3, 0.49])
def test_follower_moment_is_a_helix_too(nu):
    """theory.md 4: M_space = Exp(psi e) M_ref, psi = nu (M . e) L/E I; differs from the fixed one by psi."""
    rod = replace(arm(3, False), section=Circle(0.01), material=SaintVenantKirchhoff(1e6, nu), elements=12)
    unit = bending_stiffness(rod)
    M = rod.base.rotation @ np.array([1.2, 0.9, -1.1]) * unit
    solution = solved(Scene((rod,), moments=(Moment("arm", 1.0, M, "follower"),)))
    axis = rod.base.rotation[:, 0]
    exact = helix_tip_moment(M, 1.0, unit, unit / (1 + nu), 1.0, axis, "follower")
    fixed = helix_tip_moment(M, 1.0, unit, unit / (1 + nu), 1.0, axis, "fixed")
    assert np.linalg.norm(solution.tip().position - rod.base.position - exact.position[0]) < 1e-3
    assert np.linalg.norm(exact.position[0] - fixed.position[0]) > 0.05
    np.testing.assert_allclose(solution.tip().rotation, exact.rotation[0], atol=LIMIT)


def test_vorticity_moment_turns_the_end_gradient_only():
    """theory.md 4: a spurious angle of r_x at the tip, growing as 1/h, while r, r_y and r_z are clean."""
    angles = []
    for elements in (4, 8, 16):
        rod = Rod("arm", 1.0, elements, Circle(0.05), SaintVenantKirchhoff(1e6, 0.3), element="3243")
        M = np.array([0.0, 0.0, 1e-2 * bending_stiffness(rod)])
        section, paper = (
            solved(Scene((rod,), moments=(Moment("arm", 1.0, M, "fixed", kind),))).tip()
            for kind in ("section", "vorticity")
        )
        angles.append(paper.r_x[1] - section.r_x[1])
        np.testing.assert_allclose(paper.position, section.position, atol=2e-4)
        np.testing.assert_allclose(paper.r_y, section.r_y, atol=2e-4)
        assert abs(section.r_x[1] + section.r_y[0]) < 1e-5  # no shear, no spike: r_x stays normal to r_y
    assert abs(angles[-1]) > 1e-4
    np.testing.assert_allclose(np.array(angles[1:]) / angles[:-1], 2.0, rtol=0.1)
