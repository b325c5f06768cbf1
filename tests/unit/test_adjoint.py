"""Transposed solves: the adjoint of a linear goal, with supports, joints and unsymmetric tangents."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ancf

SECTION = {"shape": "rectangle", "height_y": 0.02, "width_z": 0.03}
SOFT = {"young_modulus": 1e6, "poisson_ratio": 0.3}
ROD: dict[str, Any] = {"length": 0.5, "elements": 2, "section": SECTION, "material": SOFT}
TURNED = {"x_axis": [1.0, 2.0, 0.5], "y_axis": [0.0, 1.0, 0.3]}
MOMENT = [{"value": [0.005, 0.01, -0.02]}]
FREE = [{"at": 0.0, "kind": "free_section_clamp"}]
SCENES: dict[str, dict[str, Any]] = {
    "clamp, moment": {"rod": [{**ROD, "base": TURNED}], "moment": MOMENT},
    "free section, 3363": {
        "rod": [{**ROD, "elements": 6, "element": "3363", "base": TURNED, "supports": FREE}],
        "moment": MOMENT,
    },
    "joint to the ground": {
        "rod": [{**ROD, "element": "3243"}],
        "force": [{"at": 0.5, "value": [0, 0.05, 0.02], "direction": "follower"}],
        "joint": [
            {"kind": "rigid", "a": {"rod": "rod", "at": 0.0}, "b": "ground"},
            {"kind": "ball", "a": {"rod": "rod", "at": 1.0}, "b": "ground"},
        ],
    },
    "two rods": {
        "rod": [
            {**ROD, "name": "a", "supports": [{"at": 0.0}]},
            {**ROD, "name": "b", "base": {"position": [0.5, 0, 0]}},
        ],
        "moment": [{**MOMENT[0], "rod": "b"}],
        "joint": [{"kind": "rigid", "a": {"rod": "a", "at": 1.0}, "b": {"rod": "b", "at": 0.0}}],
    },
}


@pytest.mark.parametrize("name", SCENES)
def test_the_adjoint_weighs_forces_as_the_goal_weighs_their_displacements(name):
    solution = ancf.solve(ancf.scene_from_dict(SCENES[name]))
    assert solution.status == "converged"
    model = solution.model
    _, flat = model.residual_and_tangent(solution.q, 1.0)
    system = model.system
    lu = system.factorise(flat)
    rng = np.random.default_rng(1)
    forces = rng.normal(size=(model.n, 3)) * model.force_unit[:, None]
    goals = rng.normal(size=(model.n, 2)) / model.unit[:, None]
    z = system.solve_transposed(lu, goals)
    expected = goals.T @ system.solve(lu, forces)
    np.testing.assert_allclose(z.T @ forces, expected, rtol=1e-6, atol=1e-9 * np.max(np.abs(expected)))
    np.testing.assert_allclose(system.solve_transposed(lu, goals[:, 0]), z[:, 0], rtol=1e-6, atol=1e-9)
