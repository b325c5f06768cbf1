"""The recheck accepts equilibria and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

import ancf
from validation.recheck import energy_error, work_error

EI = 1e6 * np.pi * 0.01**4 / 4
L = 0.4
LOADS = {
    "force": {"force": [{"value": [0, 5 * EI / L**2, EI / L**2]}]},
    "force off the axis": {"force": [{"value": [0, 2 * EI / L**2, 0], "offset": [0.004, 0.003]}]},
    "follower force": {"force": [{"value": [0, 5 * EI / L**2, 0], "direction": "follower"}]},
    "moment": {"moment": [{"value": [EI / L, 0, 3 * EI / L]}]},
    "follower moment": {"moment": [{"value": [0, EI / L, 3 * EI / L], "direction": "follower", "at": 0.6}]},
    "line load": {"line_load": [{"value": [0, 8 * EI / L**3, 0]}]},
    "follower line load": {"line_load": [{"value": [0, 8 * EI / L**3, 0], "direction": "follower"}]},
    "gravity": {"gravity": {"acceleration": [0, 0, -9.81]}},
}


def solved(loads, law="saint-venant-kirchhoff", **rod):
    table = {
        "length": L, "elements": 6, "section": {"shape": "circle", "radius": 0.01},
        "material": {"law": law, "young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1070.0}, **rod,
    }  # fmt: skip
    solution = ancf.solve(ancf.scene_from_dict({"rod": [table], **loads}))
    assert solution.status == "converged"
    return solution


@pytest.mark.parametrize("curvature", [[0, 0, 0], [1.0, 0.5, 2.0]], ids=["straight", "curved"])
@pytest.mark.parametrize("name", LOADS)
def test_equilibria_balance(name, curvature):
    """Work of stress and loads agree to rounding."""
    solution = solved(LOADS[name], curvature=curvature)
    assert work_error(solution, np.random.default_rng(1)) < 1e-7
    assert energy_error(solution) < 1e-10


@pytest.mark.parametrize("element", ["3243", "3363"])
def test_rubber_on_other_elements_balances(element):
    solution = solved(LOADS["force"], law="neo-hookean", element=element)
    assert work_error(solution, np.random.default_rng(1)) < 1e-6
    assert energy_error(solution) < 1e-6


@pytest.mark.parametrize("name", LOADS)
def test_what_is_no_equilibrium_is_seen(name):
    """A thousandth of the load too much, a tip moved by 1e-5 of the length: either is far above the limit."""
    solution = solved(LOADS[name])
    rng = np.random.default_rng(1)
    assert work_error(replace(solution, load_factor=1.001), rng) > 1e-5
    moved = solution.q.copy()
    moved[-9:-6] += 1e-5 * L
    assert work_error(replace(solution, q=moved), rng) > 1e-5
