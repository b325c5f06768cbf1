"""One warm solve through `ancf.solve`, from a scene already read to a record of the equilibrium."""

import math

import pytest

import ancf


@pytest.mark.parametrize("element", ["3333", "3243"])
def bench_90_degrees_8_elements(benchmark, make_scene, element):
    """Tip moment (asked: at most 3 ms with 3333)."""
    solution = benchmark(ancf.solve, make_scene(8, element, moment=[0.0, 0.0, math.pi / 2]))
    assert solution.status == "converged"


@pytest.mark.parametrize("predictor", ["auto", "none"])
def bench_tip_force_in_space_16_elements(benchmark, make_scene, predictor):
    """P L^2/EI = 10 from the straight shape (asked: at most 5 ms)."""
    scene = make_scene(16, solver={"predictor": predictor}, force=[0.0, -8.0, -6.0])
    solution = benchmark(ancf.solve, scene)
    assert solution.status == "converged"


def bench_reading_a_scene(benchmark, make_scene):
    """What comes before: a dictionary to validated records."""
    benchmark(make_scene, 8, moment=[0.0, 0.0, 1.0])
