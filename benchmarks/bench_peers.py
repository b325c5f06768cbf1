"""Exudyn's beams under the tip force of `ancf cost`, beside ours; all are built anew for each solve."""

import pytest

import ancf
from validation.cost.families import families
from validation.cost.peers import EXUDYN, solve_exudyn

FORCE = next(family for family in families() if family.name == "tip force")
# Load steps that each needs with 16 elements.
STEPS = {"GeometricallyExactBeam": 16}


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
def bench_ancf(benchmark, element):
    """16 elements, set-up included."""
    formulation = "continuum" if element == "3363" else "enhanced"
    scene = ancf.scene_from_dict(FORCE.with_rod(element=element, elements=16, formulation=formulation))
    assert benchmark(ancf.solve, scene).status == "converged"


@pytest.mark.parametrize("kind", EXUDYN)
def bench_exudyn(benchmark, kind):
    """16 elements, building the system included."""
    pytest.importorskip("exudyn")
    found = benchmark(solve_exudyn, kind, FORCE, 16, STEPS.get(kind, 1))
    assert found.position is not None
