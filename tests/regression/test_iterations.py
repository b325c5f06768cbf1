"""Iteration counts: our own limits (issue 2, NUMBERS), not physics. A change here is news for the changelog.

12 elements; L/R between 40 and 400; oblique moments have torsion in an arbitrarily rotated plane.
"""

from dataclasses import replace

import numpy as np
import pytest

from ancf.materials import SaintVenantKirchhoff
from ancf.scene import Force, Frame, Moment, Rod, Scene, SolverOptions
from ancf.sections import Circle
from validation.random_rods import RngDraws, random_rotation
from validation.solution_measures import bending_stiffness, solved

WALKED = 60  # iterations in all with predictor = "none"


def rod(element, slenderness, seed):
    base = Frame(rotation=random_rotation(RngDraws(np.random.default_rng(seed))))
    return Rod(
        "rod", 1.0, 12, Circle(1.0 / slenderness), SaintVenantKirchhoff(1e6, 0.3), element=element, base=base
    )


def rolled(element, slenderness, angle, seed):
    """A tip moment that bends by `angle` in a plane turned by the seed, with a third of it as torsion."""
    arm = rod(element, slenderness, seed)
    phi = np.random.default_rng(seed).uniform(0, 2 * np.pi)
    v = arm.base.rotation @ np.array([angle / 3, angle * np.cos(phi), angle * np.sin(phi)])
    return Scene((arm,), moments=(Moment("rod", 1.0, v * bending_stiffness(arm)),))


def pulled(element, slenderness, seed):
    """A tip force P L^2/EI = 10 across the rod."""
    arm = rod(element, slenderness, seed)
    return Scene((arm,), forces=(Force("rod", 1.0, 10 * bending_stiffness(arm) * arm.base.rotation[:, 2]),))


CASES = [
    *[
        ("90 degrees", "3333", L, rolled("3333", L, np.pi / 2, int(L)), 5)
        for L in (40.0, 100.0, 200.0, 400.0)
    ],
    ("90 degrees", "3243", 40.0, rolled("3243", 40.0, np.pi / 2, 1), 8),
    *[("full circle", "3333", L, rolled("3333", L, 2 * np.pi, int(L)), 8) for L in (40.0, 100.0, 400.0)],
    ("full circle", "3243", 40.0, rolled("3243", 40.0, 2 * np.pi, 2), 12),
    *[("tip force", "3333", L, pulled("3333", L, int(L)), 10) for L in (40.0, 400.0)],
]
IDS = [f"{name}-{element}-{L:g}" for name, element, L, _, _ in CASES]


@pytest.mark.parametrize(("name", "element", "slenderness", "scene", "most"), CASES, ids=IDS)
def test_iterations_from_the_predictor(name, element, slenderness, scene, most):
    """One load step; at most so many linear solves."""
    solution = solved(scene)
    assert solution.steps == 1
    assert solution.cutbacks == 0
    assert solution.iterations <= most, f"{name} {element} L/R = {slenderness:g}"


@pytest.mark.parametrize(("name", "element", "slenderness", "scene", "most"), CASES, ids=IDS)
def test_iterations_by_automatic_steps(name, element, slenderness, scene, most):
    """Without the predictor all of them converge by load steps, to the same shape."""
    walked = solved(replace(scene, solver=SolverOptions(predictor="none")))
    assert walked.iterations <= WALKED, f"{name} {element} L/R = {slenderness:g}"
    direct = solved(scene)
    np.testing.assert_allclose(walked.nodes(), direct.nodes(), atol=1e-8)


def test_ten_degrees_of_torsion_do_not_matter():
    """Another sample of directions at 90 degrees: 5 iterations for 3333 whatever the plane."""
    for seed in range(8):
        assert solved(rolled("3333", 40.0, np.pi / 2, seed)).iterations <= 5
