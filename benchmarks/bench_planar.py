"""Planar scenes on planar unknowns and in full: whole solves, and one iteration (asked: 2 times faster)."""

import pytest

import ancf
from ancf.model import Model
from ancf.reductions import chosen, reduced

LOADS = {"force": [0.5, 4.0, 0.0], "moment": [0.0, 0.0, 2.0]}
every_size = pytest.mark.parametrize("elements", [8, 16, 32, 64, 1000])
every_element = pytest.mark.parametrize("element", ["3333", "3243", "3363"])
both = pytest.mark.parametrize("reduction", ["planar", "full"])


@both
@pytest.mark.parametrize("load", LOADS)
@every_element
@every_size
def bench_planar_solve(benchmark, make_scene, elements, element, load, reduction):
    """From a scene to a record: start, iterations, stability in and out of the plane."""
    scene = make_scene(elements, element, {"reduction": reduction}, **{load: LOADS[load]})
    solution = benchmark(ancf.solve, scene)
    assert solution.status == "converged"
    assert solution.reductions or reduction == "full"


@both
@every_element
@every_size
def bench_planar_iteration(benchmark, make_scene, elements, element, reduction):
    """Residual, tangent, factors and step at the solution."""
    scene = make_scene(elements, element, {"reduction": reduction}, force=LOADS["force"])
    full = Model(scene)
    model, q = reduced(full, chosen(scene)), ancf.solve(scene).q

    def iterate() -> None:
        forces, flat = model.residual_and_tangent(q, 1.0, q)
        model.system.solve(model.system.factorise(flat), forces.at(1.0))

    benchmark(iterate)
