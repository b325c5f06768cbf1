"""`accuracy` in [solver]: what is read and refused, chosen and reported, and what is said where it fails."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ancf
import ancf.accuracy
from ancf.accuracy_record import Accuracy
from ancf.cli import main
from ancf.element_choice import candidates, choose, left_for_mesh
from ancf.errors import InputError, SceneError
from ancf.model import Model
from reference.helix import helix_tip_moment

RADIUS, YOUNG = 0.001, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4.0
ROD: dict[str, Any] = {
    "length": 1.0,
    "section": {"shape": "circle", "radius": RADIUS},
    "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3},
}
QUARTER = [{"value": [0.0, 0.0, EI * np.pi / 2]}]
FREE = [{"at": 0.0, "kind": "free_section_clamp"}]


def scene(accuracy: Any = 1e-3, rod: dict[str, Any] | None = None, **tables: Any) -> dict[str, Any]:
    """A slender rod bent to a quarter circle; None removes a key of the rod."""
    merged = {key: value for key, value in {**ROD, **(rod or {})}.items() if value is not None}
    solver = {"accuracy": accuracy, **tables.pop("solver", {})}
    return {"rod": [merged], "moment": QUARTER, "solver": solver, **tables}


def solved(*args: Any, **keys: Any) -> ancf.Solution:
    """The solution of such a scene."""
    return ancf.solve(ancf.scene_from_dict(scene(*args, **keys)))


# --- what is read and refused ------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [0, 9e-9, 0.2, -1e-3, float("nan"), float("inf")])
def test_an_accuracy_out_of_range_is_refused(value):
    with pytest.raises(SceneError) as refused:
        ancf.scene_from_dict(scene(value))
    assert refused.value.message.where == "scene: solver.accuracy"
    assert "between 1e-8 and 0.1" in refused.value.message.value or "finite" in refused.value.message.value


def test_an_accuracy_of_another_type_is_refused():
    with pytest.raises(SceneError, match="accuracy has the wrong type"):
        ancf.scene_from_dict(scene("fine", rod={}, solver={"accuracy": [1e-3]}))


def test_elements_beside_accuracy_are_refused():
    with pytest.raises(SceneError) as refused:
        ancf.scene_from_dict(scene(rod={"elements": 12}))
    message = refused.value.message
    assert message.what == "Elements and accuracy are both given."
    assert message.where == "scene: rod[0].elements"
    assert message.value == "elements = 12 beside accuracy in [solver]"
    assert message.advice == "remove elements, or accuracy"


def test_elements_of_a_segment_beside_accuracy_are_refused():
    piece = {key: ROD[key] for key in ROD}
    data = scene(rod=dict.fromkeys(ROD) | {"segments": [piece, {**piece, "elements": 3}]})
    with pytest.raises(SceneError) as refused:
        ancf.scene_from_dict(data)
    assert refused.value.message.where == "scene: rod[0].segments[1].elements"


def test_without_accuracy_elements_are_needed():
    data = scene()
    del data["solver"]["accuracy"]
    with pytest.raises(SceneError, match='"elements" is missing'):
        ancf.scene_from_dict(data)


def test_elements_given_in_python_are_refused_when_it_is_solved():
    asked = ancf.scene_from_dict(scene())
    meshed = replace(asked, rods=(replace(asked.rods[0], elements=12),))
    with pytest.raises(InputError) as refused:
        ancf.solve(meshed)
    assert refused.value.message.where == "rod[0].elements"
    assert "leave elements away (0 in Python)" in str(refused.value)


def test_a_start_or_a_state_has_no_mesh_to_belong_to(tmp_path):
    asked = ancf.scene_from_dict(scene())
    with pytest.raises(InputError, match="A start and accuracy are both given"):
        ancf.solve(asked, start=np.zeros(72))
    solution = ancf.solve(asked)
    solution.save(tmp_path / "state.npz")
    with pytest.raises(InputError, match="A start and accuracy are both given"):
        ancf.resume(asked, tmp_path / "state.npz")
    again = ancf.resume(solution.scene, tmp_path / "state.npz")
    assert again.iterations <= 2
    np.testing.assert_allclose(again.tip().position, solution.tip().position, atol=1e-9)


# --- what is chosen ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("wanted", [1e-2, 1e-4, 1e-6])
def test_the_accuracy_is_met_against_the_helix(wanted):
    """Closed form (shared/theory.md 1); at L/R = 1e4 finite strain, (kappa R)^2, is 2e-8."""
    radius = 1e-4
    second = np.pi * radius**4 / 4.0
    moment = np.array([0.8, 1.0, -1.2]) * YOUNG * second
    data = scene(wanted, {"section": {"shape": "circle", "radius": radius}}, moment=[{"value": moment}])
    solution = ancf.solve(ancf.scene_from_dict(data))
    GJ = YOUNG / 2.6 * 2.0 * second
    exact = helix_tip_moment(moment, 1.0, YOUNG * second, GJ, 1.0)
    error = float(np.linalg.norm(solution.tip().position - exact.position[0]))
    accuracy = solution.accuracy
    assert accuracy is not None and accuracy.estimate is not None
    assert error <= wanted
    assert 0.5 <= accuracy.estimate / error <= 2.0
    assert accuracy.met and not accuracy.warnings


def test_the_scene_of_the_answer_gives_the_answer_again():
    solution = solved(1e-4)
    assert solution.scene.solver.accuracy is None
    assert solution.scene.rods[0].elements == len(solution.scene.rods[0].breaks) - 1
    again = ancf.solve(solution.scene)
    np.testing.assert_allclose(again.tip().position, solution.tip().position, atol=1e-9)


def test_a_thick_rod_gets_quadratic_sections_where_the_clamp_lets_them():
    """Linear sections err by some 7e-4 L at L/R = 40 and 90 degrees (README, table of elements)."""
    thick = {"section": {"shape": "circle", "radius": 0.025}}
    moment = [{"value": [0.0, 0.0, YOUNG * np.pi * 0.025**4 / 4.0 * np.pi / 2]}]
    free = solved(3e-4, {**thick, "supports": FREE}, moment=moment)
    assert free.scene.rods[0].element == "3363"
    assert free.accuracy is not None and free.accuracy.met
    held = solved(3e-4, thick, moment=moment)
    assert held.scene.rods[0].element == "3333"
    assert held.status == "converged"
    (warning,) = [text for text in held.warnings if "accuracy" in text]
    assert warning.startswith(
        "accuracy = 0.0003 is not met: the sections of 3333 move the tip by about 0.00066"
    )
    assert 'with kind = "free_section_clamp" in place of "clamp" the program may take 3363' in warning
    coarse = solved(2e-3, {**thick, "supports": FREE}, moment=moment)
    assert coarse.scene.rods[0].element == "3333"


@pytest.mark.parametrize("keys", [{"element": "3243"}, {"formulation": "enhanced"}, {"axial_rule": "full"}])
def test_whoever_gives_the_element_keeps_it(keys):
    asked = ancf.scene_from_dict(scene(rod={**keys, "supports": FREE}))
    assert candidates(asked, asked.rods[0]) == [keys.get("element", "3333")]


def test_joined_rods_and_the_papers_moment_keep_linear_sections():
    asked = ancf.scene_from_dict(scene(rod={"supports": FREE}))
    assert candidates(asked, asked.rods[0]) == ["3333", "3363"]
    paper = [{**QUARTER[0], "definition": "vorticity"}]
    vorticity = ancf.scene_from_dict(scene(rod={"supports": FREE}, moment=paper))
    assert candidates(vorticity, vorticity.rods[0]) == ["3333"]
    rods = [{**ROD, "name": "a", "supports": FREE}, {**ROD, "name": "b", "base": {"position": [1, 0, 0]}}]
    joint = {"kind": "rigid", "a": {"rod": "a", "at": 1.0}, "b": {"rod": "b", "at": 0.0}}
    joined = ancf.scene_from_dict({"rod": rods, "joint": [joint], "solver": {"accuracy": 1e-3}})
    assert [candidates(joined, rod) for rod in joined.rods] == [["3333", "3363"]] * 2
    clamped = replace(joined, rods=(ancf.scene_from_dict(scene()).rods[0], joined.rods[1]))
    assert [candidates(clamped, rod) for rod in clamped.rods] == [["3333"]] * 2


def test_the_cheapest_element_that_suffices_is_chosen():
    assert choose({"3333": 1e-5, "3363": 1e-6}, 1e-3) == "3333"
    assert choose({"3333": 8e-4, "3363": 1e-6}, 1e-3) == "3363"  # more than 0.7 of what is wanted
    assert choose({"3333": 5e-3, "3363": 2e-3}, 1e-3) == "3363"  # neither suffices: the better
    assert choose({"3333": 5e-3, "3363": 4e-3}, 1e-3) == "3333"  # not better enough
    assert left_for_mesh(1e-3, 4e-4) == pytest.approx(0.9 * 6e-4)
    assert left_for_mesh(1e-3, 9.9e-4) == pytest.approx(0.9e-4)
    assert left_for_mesh(1e-3, 2e-3) == pytest.approx(0.9e-3)


def test_elements_gather_where_a_taper_bends():
    """M/(E I) at the thin end is 256 times that at the thick one."""
    piece = {**ROD, "section_end": {"shape": "circle", "radius": RADIUS / 4}}
    data = scene(1e-4, dict.fromkeys(ROD) | {"segments": [piece]}, moment=[{"value": [0, 0, 0.05 * EI]}])
    lengths = np.diff(ancf.solve(ancf.scene_from_dict(data)).scene.rods[0].breaks)
    assert lengths[0] > 2.0 * lengths[-1]


def test_the_worst_of_several_rods_counts():
    rods = [{**ROD, "name": "stiff"}, {**ROD, "name": "soft"}]
    moments = [{"rod": "stiff", "value": [0, 0, 0.1 * EI]}, {"rod": "soft", "value": [0, 0, 5.0 * EI]}]
    both = ancf.solve(ancf.scene_from_dict({"rod": rods, "moment": moments, "solver": {"accuracy": 1e-4}}))
    alone = ancf.solve(
        ancf.scene_from_dict({"rod": rods[1:], "moment": moments[1:], "solver": {"accuracy": 1e-4}})
    )
    assert both.accuracy is not None and alone.accuracy is not None
    assert both.accuracy.estimate == pytest.approx(alone.accuracy.estimate, rel=1e-6)
    assert both.scene.rod("stiff").elements < both.scene.rod("soft").elements


def test_a_rod_held_at_its_tip_is_judged_by_the_place_that_moves_most():
    supports = [{"at": 0.0}, {"at": 1.0}]
    data = scene(1e-4, {"supports": supports}, moment=[], line_load=[{"value": [0, 200 * EI, 0]}])
    solution = ancf.solve(ancf.scene_from_dict(data))
    assert solution.accuracy is not None and solution.accuracy.estimate is not None
    assert 1e-9 < solution.accuracy.estimate <= 1e-4


# --- what cannot be met ------------------------------------------------------------------------------------


def test_a_time_that_is_too_short_says_so_and_gives_the_best_it_has(monkeypatch):
    clock = iter(np.arange(0.0, 1e4, 1e-3))  # every look at the clock takes a millisecond
    monkeypatch.setattr(ancf.accuracy.time, "perf_counter", lambda: float(next(clock)))
    best = None
    for seconds in (0.005, 0.04, 0.08):
        solution = solved(1e-6, moment=[{"value": [0, 0, 5 * EI]}], solver={"max_seconds": seconds})
        accuracy = solution.accuracy
        assert accuracy is not None and not accuracy.met
        if solution.status == "converged":
            best = accuracy
            assert f"max_seconds = {seconds:g} s is used up" in accuracy.warnings[0]
    assert best is not None and best.estimate is not None and best.estimate > 1e-6


def test_too_many_elements_are_not_taken(monkeypatch):
    monkeypatch.setattr(ancf.accuracy, "MOST_ELEMENTS", 20)
    solution = solved(1e-6, {"element": "3333"}, moment=[{"value": [0, 0, 5 * EI]}])
    accuracy = solution.accuracy
    assert accuracy is not None and accuracy.estimate is not None
    assert solution.status == "converged"
    assert accuracy.estimate > 1e-6 and not accuracy.met
    assert "and the program chooses 20 at the most" in solution.warnings[0]
    assert solution.as_dict()["error_estimate"] == accuracy.estimate


def test_no_equilibrium_is_the_status_and_the_accuracy_is_unknown():
    solution = solved(1e-3, moment=[], force=[{"value": [0, 1e300, 0]}], solver={"max_steps": 3})
    assert solution.status != "converged"
    assert solution.accuracy is not None and solution.accuracy.estimate is None
    result = solution.as_dict()
    assert result["error_estimate"] is None
    assert result["accuracy"]["met"] is False
    assert any("no error estimate" in text for text in result["warnings"])


def test_a_dearer_element_without_equilibrium_is_left_again(monkeypatch):
    """3363 is made to fail: the answer of 3333 is returned, and says what its sections leave."""
    real = ancf.accuracy.estimate_error
    monkeypatch.setattr(
        ancf.accuracy,
        "estimate_error",
        lambda solution, *args: None if solution.scene.rods[0].element == "3363" else real(solution, *args),
    )
    moment = [{"value": [0.0, 0.0, YOUNG * np.pi * 0.025**4 / 4.0 * np.pi / 2]}]
    solution = solved(
        3e-4, {"section": {"shape": "circle", "radius": 0.025}, "supports": FREE}, moment=moment
    )
    assert solution.scene.rods[0].element == "3333"
    assert solution.accuracy is not None
    assert [trial.element for trial in solution.accuracy.tried].count("3363") == ancf.accuracy.ATTEMPTS
    assert "the sections of 3333" in solution.warnings[0]


def test_a_rod_without_a_mesh_makes_no_model():
    with pytest.raises(InputError) as refused:
        Model(ancf.scene_from_dict(scene()))
    assert refused.value.message.where == "rod 'rod'"
    assert "solve it with ancf.solve" in refused.value.message.advice


def test_an_estimate_overrides_the_rule_of_thumb_for_long_elements():
    """Elements that turn by more than 0.7 rad are warned about, unless their error is known to be small."""
    solution = solved(1e-2, moment=[{"value": [0, 0, 3.0 * EI]}])
    assert solution.scene.rods[0].elements == 4
    assert solution.accuracy is not None and solution.accuracy.met
    assert solution.warnings == []
    assert any("elements are too long" in text for text in ancf.solve(solution.scene).warnings)


# --- how it is reported ------------------------------------------------------------------------------------


def test_the_record_in_the_result():
    solution = solved(1e-4)
    result = solution.as_dict()
    record = result["accuracy"]
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert record["wanted"] == 1e-4
    assert record["met"] is True
    assert result["error_estimate"] == record["estimate"] <= 1e-4
    assert record["rods"]["rod"]["elements"] == len(record["rods"]["rod"]["breaks"]) - 1
    assert record["tried"][-1]["estimate"] == record["estimate"]
    assert record["tried"][-1]["unknowns"] == result["unknowns"]
    assert result["seconds"]["total"] > 0.0


def test_a_scene_without_accuracy_reports_none():
    result = ancf.solve(solved().scene).as_dict()
    assert result["error_estimate"] is None
    assert "accuracy" not in result


def test_the_estimate_must_hold_to_be_met():
    record = Accuracy(1e-3, 9e-4, 2e-4, (), ())
    assert not record.met
    assert record.warnings[0].startswith("accuracy = 0.001 is not met")
    assert replace(record, model_error=None).met
    assert replace(record, model_error=5e-5).met


TOML = """
[[rod]]
name = "arm"
length = 1.0
section = { shape = "circle", radius = 0.001 }
material = { young_modulus = 1e6, poisson_ratio = 0.3 }
[[moment]]
value = [0, 0, 1.2337e-6]
[solver]
accuracy = 1e-3
"""


def test_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "arm.toml"
    path.write_text(TOML)
    assert main(["check", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["accuracy"] == {"wanted": 1e-3, "first_mesh": {"arm": 6}}
    assert found["rods"]["arm"]["elements"] is None
    assert main(["check", str(path)]) == 0
    text = " ".join(capsys.readouterr().err.split())
    assert "rod arm: 1 m, elements to be chosen, first 3333 enhanced" in text
    assert "accuracy: 0.001 of the length at the tip" in text
    assert "on the first mesh, of 6 elements" in text
    assert main(["solve", str(path)]) == 0
    text = " ".join(capsys.readouterr().err.split())
    assert "accuracy 0.001 met: estimated tip error / length 3.7e-05 by the mesh" in text
    assert "arm: 6 x 3333, chosen in 1 round" in text
    assert main(["solve", str(path), "--json", "--out", str(tmp_path / "out")]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["accuracy"]["met"] is True
    path.write_text(TOML.replace("1e-3", "1.0"))
    assert main(["solve", str(path)]) == 2
    assert "solver.accuracy" in capsys.readouterr().err


def test_the_modules_load_only_when_asked():
    code = (
        "import sys, ancf; s = ancf.scene_from_dict({'rod': [{'length': 1.0, 'elements': 2, 'section': "
        "{'shape': 'circle', 'radius': 0.01}, 'material': {'young_modulus': 1e6, 'poisson_ratio': 0.3}}]}); "
        "ancf.solve(s).as_dict(); print([m for m in sys.modules if m.startswith('ancf.') and "
        "m.split('.')[1] in ('accuracy', 'error_estimate', 'refinement', 'model_error', 'element_choice')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
