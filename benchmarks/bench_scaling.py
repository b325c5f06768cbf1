"""Time against the number of elements (asked: flat by element from 100 to 10 000, which in at most 15 s)."""

import pytest

import ancf


@pytest.mark.parametrize("element", ["3243", "3333"])
@pytest.mark.parametrize("elements", [100, 1000, 10_000])
def bench_tip_force(benchmark, make_scene, element, elements):
    """P L^2/EI = 1."""
    scene = make_scene(elements, element, force=[0.0, 1.0, 0.0])
    solution = benchmark.pedantic(ancf.solve, (scene,), rounds=5 if elements <= 1000 else 1, warmup_rounds=1)
    benchmark.extra_info["microseconds by element"] = 1e6 * benchmark.stats.stats.min / elements
    assert solution.status == "converged"
