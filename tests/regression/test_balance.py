"""Every example and every scene of the contract balances; what each effect applies against statics."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import ancf

ROOT = Path(__file__).parents[2]
SCENES = sorted([*(ROOT / "examples").glob("*.toml"), *(ROOT / "validation/contract_scenes").glob("*.toml")])
BALANCE = 1e-10  # issue "effects", numbers: of the larger of the load and E I/L^2, plus the float64 floor


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_scene_balances(path):
    solution = ancf.solve(ancf.load_scene(path))
    for name in (None, *(rod.name for rod in solution.scene.rods)):
        assert solution.balance(name).relative <= BALANCE + solution.residual_floor
    found = solution.as_dict()["balance"]
    json.dumps(found, allow_nan=False)
    assert found["relative"] <= BALANCE + solution.residual_floor


LENGTH, RADIUS = 0.4, 0.01
ROD = {
    "length": LENGTH,
    "elements": 4,
    "section": {"shape": "circle", "radius": RADIUS},
    "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
    "base": {"position": [3.0, -2.0, 1.0], "x_axis": [0, 1, 0], "y_axis": [0, 0, 1]},
}
WEIGHT = 1000.0 * np.pi * RADIUS**2 * LENGTH * 2.0  # N, rho A L g with g = 2


@pytest.mark.parametrize(
    ("effects", "name", "force", "couple"),
    [
        ({"force": [{"value": [0.01, 0, -0.02]}]}, "force", [0.01, 0, -0.02], [0, 0, 0]),
        ({"moment": [{"value": [1e-3, 2e-3, 0]}]}, "moment", [0, 0, 0], [1e-3, 2e-3, 0]),
        (
            {"moment": [{"value": [1e-3, 2e-3, 0], "definition": "vorticity"}]},
            "moment",
            [0, 0, 0],
            [1e-3, 2e-3, 0],
        ),
        ({"line_moment": [{"value": [1e-2, 0, 5e-3]}]}, "line_moment", [0, 0, 0], [4e-3, 0, 2e-3]),
        ({"gravity": {"acceleration": [0, 0, -2.0]}}, "gravity", [0, 0, -WEIGHT], None),
        ({"line_load": [{"value": [0.05, 0, 0]}]}, "line_load", [0.02, 0, 0], None),
        ({"tendon": [{"tension": 0.2, "path": [[0, 0.005, 0], [1, 0.005, 0]]}]}, "tendon", [0] * 3, [0] * 3),
        ({"pressure": [{"value": 2e3, "chamber": {"radius": 0.005}}]}, "pressure", [0] * 3, [0] * 3),
    ],
)
def test_what_an_effect_applies(effects, name, force, couple):
    """Statics: a load's own force; its moment about the origin is its couple and force x arm; actuators that
    the rod itself carries (tendon, pressure) apply nothing in all."""
    solution = ancf.solve(ancf.scene_from_dict({"rod": [ROD], **effects}))
    found = solution.balance().applied[name]
    np.testing.assert_allclose(found.force, force, atol=1e-13)
    if couple is not None:
        arm = solution.tip().position if name == "force" else np.zeros(3)
        np.testing.assert_allclose(found.moment, np.cross(arm, force) + couple, atol=1e-13)
    clamp_force, clamp_moment = solution.reaction()  # about the base
    supports = solution.balance().reactions["supports"]
    base = ROD["base"]["position"]
    np.testing.assert_allclose(supports.force, clamp_force, atol=1e-13)
    np.testing.assert_allclose(supports.moment, clamp_moment + np.cross(base, clamp_force), atol=1e-13)


def test_unknown_rod():
    solution = ancf.solve(ancf.scene_from_dict({"rod": [ROD], "force": [{"value": [0, 0, 0.01]}]}))
    with pytest.raises(KeyError, match="no rod named 'leg'"):
        solution.balance("leg")
