"""One residual and tangent of 12 elements at a bent state: analytic, and by two kinds of differences."""

import pytest

import ancf
from ancf.model import Model
from validation.cost.scaling import by_coordinates


@pytest.fixture
def bent(make_scene):
    """Coordinates at the solution."""
    return ancf.solve(make_scene(12, force=[0.0, 1.0, 0.0])).q


@pytest.mark.parametrize("tangent", ["analytic", "finite-difference"])
def bench_assembly(benchmark, make_scene, bent, tangent):
    """Ours: the differences of all elements at once."""
    model = Model(make_scene(12, solver={"tangent": tangent}, force=[0.0, 1.0, 0.0]))
    benchmark(model.residual_and_tangent, bent, 1.0)


def bench_the_papers_differences(benchmark, make_scene, bent):
    """By one coordinate of the model after the other (eq. 38-41); asked: 20 times the analytic one."""
    benchmark(by_coordinates, Model(make_scene(12, force=[0.0, 1.0, 0.0])), bent)
