"""Failures are typed, explained and never NaN."""

import json
from dataclasses import replace

import numpy as np
import pytest

import ancf
from ancf.elements import ELEMENTS
from ancf.materials import SaintVenantKirchhoff
from ancf.scene import Force, Moment, Rod, Scene, SolverOptions, Support
from ancf.sections import Circle

EI = 1e6 * np.pi * 0.02**4 / 4


def scene(force=(0.0, 0.0, 0.0), moment=None, name="3333", **options):
    rod = Rod("rod", 1.0, 8, Circle(0.02), SaintVenantKirchhoff(1e6, 0.3), element=name)
    moments = () if moment is None else (Moment("rod", 1.0, np.array(moment)),)
    return Scene(
        (rod,), moments=moments, forces=(Force("rod", 1.0, np.array(force)),), solver=SolverOptions(**options)
    )


def plain(solution):
    """The JSON form; refuses NaN and infinity."""
    return json.loads(json.dumps(solution.as_dict(), allow_nan=False))


@pytest.mark.parametrize("name", ELEMENTS)
@pytest.mark.parametrize("size", [1e300, 1e308, 1e30, 1e12])
@pytest.mark.parametrize("kind", ["force", "moment"])
def test_absurd_loads_end_in_a_typed_failure(name, size, kind):
    """issue 2: never NaN in a result, whatever the load."""
    load = (0.1 * size, 0.7 * size, -0.3 * size)
    case = (
        scene(load, name=name, max_seconds=5.0)
        if kind == "force"
        else scene(moment=load, name=name, max_seconds=5.0)
    )
    solution = ancf.solve(case)
    assert solution.status in (ancf.Status.NOT_FINITE, ancf.Status.NOT_CONVERGED, ancf.Status.OUT_OF_TIME)
    result = plain(solution)
    assert result["status"] == str(solution.status)
    assert result["reason"]
    assert solution.message is not None
    for part in ("what", "where", "value", "cause", "advice"):
        assert getattr(solution.message, part)
    assert 0.0 <= solution.load_factor < 1.0
    assert np.isfinite(solution.q).all()


def test_the_budget_of_steps_ends_the_search():
    """A roll by 60 degrees an element without predictor needs many steps."""
    solution = ancf.solve(scene(moment=(0.0, 0.0, 12.0 * EI), predictor="none", max_steps=2))
    assert solution.status is ancf.Status.NOT_CONVERGED
    assert solution.steps + solution.cutbacks <= 2
    assert "max_steps = 2" in solution.reason
    assert 0.0 < solution.load_factor < 1.0
    plain(solution)
    # the state is an equilibrium at the load factor it names
    model = solution.model
    g = model.system.project(model.residual(solution.q).at(solution.load_factor)) / model.force_unit
    assert np.abs(g).max() < 1e-9


def test_the_budget_of_time_ends_the_search():
    solution = ancf.solve(scene(moment=(0.0, 0.0, 12.0 * EI), predictor="none", max_seconds=1e-9))
    assert solution.status is ancf.Status.OUT_OF_TIME
    assert "max_seconds = 1e-09" in solution.reason
    plain(solution)


def test_compression_beyond_the_law_is_named():
    """Saint Venant-Kirchhoff carries P = E A (s - s^3)/2 <= 0.19245 E A; a straight strut cannot carry 0.3 E
    A.
    """
    P = 0.3 * 1e6 * np.pi * 0.02**2
    case = scene((-P, 0.0, 0.0))
    free = replace(case.rods[0], supports=(Support(0.0, "free_section_clamp"),), elements=2, length=0.1)
    solution = ancf.solve(replace(case, rods=(free,)))
    assert solution.status in (
        ancf.Status.MATERIAL_UNSTABLE,
        ancf.Status.LIMIT_POINT,
        ancf.Status.INVERTED_ELEMENT,
    )
    assert solution.load_factor < 0.19245 / 0.3 + 1e-6
    plain(solution)


def test_a_converged_solution_says_how_far():
    """theory.md 6: residual at the tolerance or at its float64 floor, which the result reports."""
    solution = ancf.solve(scene(moment=(0.3 * EI, 0.2 * EI, 1.5 * EI)))
    assert solution.status is ancf.Status.CONVERGED
    assert solution.message is None
    assert solution.reason == ""
    assert solution.load_factor == 1.0
    assert 0.0 < solution.residual <= max(1e-10, solution.residual_floor)
    assert solution.history[-1].step <= 1e-10
    assert [h.iteration for h in solution.history] == list(range(1, solution.iterations + 1))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_the_tolerance_is_used(tolerance):
    loose = ancf.solve(scene((0.0, 3.0 * EI, 0.0), tolerance=tolerance, predictor="none"))
    tight = ancf.solve(scene((0.0, 3.0 * EI, 0.0), predictor="none"))
    assert loose.history[-1].step <= tolerance
    assert loose.iterations < tight.iterations


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
@pytest.mark.parametrize("load", [1.0, 5.0, 10.0])
def test_a_small_step_alone_is_not_convergence(tolerance, load):
    """theory.md 6: step *and* residual. A slender rod (A L^2/I = 6e5) answers a step of 1e-3 by a residual of
    0.6.
    """
    rod = Rod("rod", 1.0, 8, Circle(0.0025), SaintVenantKirchhoff(1e6, 0.3))
    force = Force("rod", 1.0, np.array([0.0, load, 0.0]) * 1e6 * np.pi * 0.0025**4 / 4)
    solution = ancf.solve(Scene((rod,), forces=(force,), solver=SolverOptions(tolerance=tolerance)))
    assert solution.status is ancf.Status.CONVERGED
    assert solution.residual <= max(tolerance, solution.residual_floor)
    model = solution.model
    g = model.system.project(model.residual(solution.q).at(1.0)) / model.force_unit
    assert np.abs(g).max() == pytest.approx(solution.residual, rel=1e-6)
