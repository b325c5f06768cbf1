"""A scene simulates exactly the effects it lists: one of zero magnitude changes no bit of the answer, and one
that is not listed is neither called, imported nor built.

Every effect of `EFFECT_MODULES` has an entry in `ZERO`, or says in `EXCUSED` why it has no zero magnitude.
"""

from __future__ import annotations

import subprocess
import sys
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ancf
from ancf.scene_effects import EFFECT_MODULES

ROOT = Path(__file__).parents[2]
SCENES = sorted([*(ROOT / "examples").glob("*.toml"), *(ROOT / "validation/contract_scenes").glob("*.toml")])

# Field of the scene -> its table, and that table at zero magnitude.
ZERO: dict[str, tuple[str, Any]] = {
    "moments": ("moment", [{"value": [0.0, 0.0, 0.0], "at": 0.37, "direction": "follower"}]),
    "forces": ("force", [{"value": [0.0, 0.0, 0.0], "at": 0.37, "offset": [0.001, 0.0]}]),
    "line_loads": ("line_load", [{"value": [0.0, 0.0, 0.0], "direction": "follower"}]),
    "line_moments": ("line_moment", [{"value": [0.0, 0.0, 0.0]}]),
    "gravity": ("gravity", {"acceleration": [0.0, 0.0, 0.0]}),
    "magnets": ("magnet", [{"remanence": [0.1, 0.0, 0.0], "field": [0.0, 0.0, 0.0]}]),
    "tendons": ("tendon", [{"tension": 0.0, "path": [[0.1, 0.002, 0.0], [0.9, 0.0, 0.002]]}]),
    "springs": ("spring", [{"stiffness": 0.0, "at": 0.37}]),
    "foundations": ("foundation", [{"stiffness": 0.0}]),
    "pressures": ("pressure", [{"value": 0.0, "chamber": {"radius": 0.002}}]),
}
EXCUSED: dict[str, str] = {  # field -> why there is no zero magnitude
    "contacts": "an obstacle out of reach makes the solver walk, so that it cannot be jumped through",
}

ROD: dict[str, Any] = {
    "length": 0.4,
    "elements": 5,
    "section": {"shape": "circle", "radius": 0.01},
    "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
}
EI = 1e6 * np.pi * 0.01**4 / 4
LOADED: dict[str, dict[str, Any]] = {
    "space": {
        "rod": [ROD],
        "force": [{"value": [0.0, 2.0 * EI / 0.16, EI / 0.16]}],
        "moment": [{"value": [0.5 * EI / 0.4, 0.0, EI / 0.4]}],
    },
    "plane": {"rod": [ROD], "force": [{"value": [0.0, 2.0 * EI / 0.16, 0.0]}]},
    "rubber": {
        "rod": [{**ROD, "element": "3363", "material": {**ROD["material"], "law": "neo-hookean"}}],
        "line_load": [{"value": [0.0, EI / 0.064, 0.0]}],
    },
}


def test_every_effect_is_covered():
    assert set(ZERO) | set(EXCUSED) == set(EFFECT_MODULES)
    assert not set(ZERO) & set(EXCUSED) and all(EXCUSED.values())


@pytest.mark.parametrize("field", ZERO)
@pytest.mark.parametrize("loaded", LOADED)
@pytest.mark.parametrize("reduction", ["full", "auto"])
def test_zero_magnitude_is_absence(field, loaded, reduction):
    """Bit for bit with reduction = "full"; 1e-12 of the length where a reduction is chosen by the scene."""
    table, zero = ZERO[field]
    scene = {**LOADED[loaded], "solver": {"reduction": reduction}}
    listed = scene.get(table, [])
    without = ancf.solve(ancf.scene_from_dict(scene))
    more = zero if isinstance(zero, dict) else [*listed, *zero]
    added = ancf.solve(ancf.scene_from_dict({**scene, table: more}))
    assert without.status == added.status == "converged"
    if reduction == "full":
        np.testing.assert_array_equal(added.q, without.q)
        assert [i.step for i in added.history] == [i.step for i in without.history]
    else:
        np.testing.assert_allclose(added.tip().position, without.tip().position, rtol=0, atol=0.4e-12)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_only_what_is_listed_is_called(path):
    """Of all effects those of the scene's tables, each in every iteration."""
    scene = ancf.load_scene(path)
    solution = ancf.solve(scene)
    tables = {module for field, module in EFFECT_MODULES.items() if getattr(scene, field)}
    joints = {"joint"} if scene.joints else set()
    assert set(solution.effects) == {"elastic"} | tables | joints
    built = {effect.name for effect in solution.model.effects}
    if scene.controlled_tendons:  # conditions, not loads
        built.add("tendon")
    assert built == tables
    for name in tables:
        assert solution.effects[name]["calls"] >= solution.iterations


def test_what_is_not_listed_is_not_imported():
    """In interpreters of their own: a scene of one effect imports its module and no other of ancf.effects."""
    code = """
import sys, json
import ancf
for scene in json.loads(sys.argv[1]):
    assert ancf.solve(ancf.scene_from_dict(scene)).status == "converged"
print(json.dumps(sorted(n.split(".")[-1] for n in sys.modules if n.startswith("ancf.effects."))))
"""
    import json

    def imported(*scenes: dict[str, Any]) -> list[str]:
        command = [sys.executable, "-c", code, json.dumps(scenes)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return json.loads(done.stdout)

    for field, module in EFFECT_MODULES.items():
        if field in ZERO:
            table, zero = ZERO[field]
            assert imported({"rod": [ROD], table: zero}) == [module]
    assert imported({"rod": [ROD]}) == []


def test_what_is_not_listed_takes_no_memory():
    """Not a byte of a solve comes from the module of an unlisted effect, all being imported."""
    for field in ZERO:
        table, zero = ZERO[field]
        ancf.solve(ancf.scene_from_dict({"rod": [ROD], table: zero}))
    scene = ancf.scene_from_dict(LOADED["plane"])
    tracemalloc.start(1)
    try:
        solution = ancf.solve(scene)
        taken = tracemalloc.take_snapshot()
    finally:
        tracemalloc.stop()
    assert solution.status == "converged"
    files = {Path(stat.traceback[0].filename) for stat in taken.statistics("filename")}
    effects = {path.stem for path in files if path.parent.name == "effects"}
    assert effects - {"__init__"} == {"force"}
