"""`ancf cost` from outside: one JSON object of finite numbers, refusals in five parts, exit codes."""

import json
import math
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from ancf.errors import InputError
from validation.cost import run, scaling
from validation.cost.cli import cost
from validation.cost.families import families
from validation.cost.points import CostPoint

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
app = typer.Typer()
app.command()(cost)


def call(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=False)


def numbers(value):
    if isinstance(value, dict):
        for item in value.values():
            yield from numbers(item)
    elif isinstance(value, list):
        for item in value:
            yield from numbers(item)
    elif isinstance(value, float):
        yield value


def test_a_scene_as_json_and_files(tmp_path):
    result = call(EXAMPLES / "quarter-circle.toml", "--json", "--out", tmp_path / "out")
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    assert json.loads((tmp_path / "out" / "cost.json").read_text()) == found
    assert found["schema"] == 1 and found["kind"] == "scene" and found["scope"] == "quick"
    assert all(math.isfinite(v) for v in numbers(found))
    assert {k["element"] for k in found["ladders"]} >= {"3333", "3243", "3363"}
    first = found["needs"][0]
    assert first["target"] == 0.01 and first["reached"] and first["seconds"] > 0.0
    assert found["seconds"] > 0.0 and found["threads"]
    assert (tmp_path / "out" / "cost-scene.svg").read_text().startswith("<svg")


def test_a_scene_for_people():
    result = call(EXAMPLES / "quarter-circle.toml")
    assert result.exit_code == 0
    assert "for 0.1 %" in result.stdout and "3333, enhanced" in result.stdout
    assert "threads" in result.stdout


def test_the_families_as_json(monkeypatch, tmp_path):
    """One family on one mesh: what all of them would give, in seconds."""
    bending = families()[1]
    monkeypatch.setattr(run, "families", lambda: [bending])
    monkeypatch.setattr(run, "MESHES", (2, 4, 8))
    monkeypatch.setattr(scaling, "COUNTS", (10, 20))
    result = call("--json", "--out", tmp_path)
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    assert all(math.isfinite(v) for v in numbers(found))
    (family,) = found["families"]
    assert family["reference"]["error"] < 1e-8 and family["reference"]["source"]
    beams = [p for p in family["points"] if p["kind"] == "beam"]
    assert {p["tangent"] for p in beams} == {"analytic", "finite-difference"}
    assert {p["predictor"] for p in beams} == {"auto", "none"}
    by_tangent = {p["tangent"]: p["error"] for p in beams if p["elements"] == 8 and p["model"] == "3333"}
    assert by_tangent["analytic"] == pytest.approx(by_tangent["finite-difference"], rel=1e-3)
    parts = next(p["parts"] for p in beams if p["status"] == "converged")
    assert set(parts) == {"setup", "kinematics", "assembly", "effects", "linear_solve", "rest"}
    assert any("soromox" in text for text in family["omissions"])
    assert family["recommendation"].startswith("For 1e-3 L")
    assert [s["elements"] for s in found["scaling"]] == [10, 20]
    assert all(r["paper_ratio"] > 1.0 for r in found["tangent_ratio"])
    assert (tmp_path / "cost-helix.svg").exists()


def test_what_an_element_cannot_do_is_an_omission(monkeypatch):
    """3363 refuses shear factors: the Princeton beam without that variant, and with the reason."""
    princeton = families()[-1]
    monkeypatch.setattr(run, "MESHES", (8,))
    found = run.measure(princeton)
    assert any("3363" in text and "shear_factors" in text for text in found.omissions)
    assert any(p.model == "3363" and p.converged for p in found.points)


def test_a_failure_is_drawn_and_listed(monkeypatch):
    from validation.report.figures_cost import family_figure
    from validation.report.style import styled

    helix = families()[1]
    monkeypatch.setattr(run, "MESHES", (1, 8))
    found = run.measure(helix)
    failed = [p for p in found.points if not p.converged]
    assert failed and all(p.error is None for p in failed)
    assert any("3363" in text and "1 element" in text for text in found.omissions)
    with styled():
        assert "cost-family" in family_figure(found)


@pytest.mark.parametrize("arguments", [("--quick", "--full"), ("nowhere.toml",)])
def test_refusals_have_five_parts(arguments):
    with pytest.raises(InputError) as caught:
        call(*arguments)
    message = caught.value.message
    assert all((message.what, message.where, message.value, message.cause, message.advice))


def test_a_file_for_a_folder_is_refused(tmp_path):
    taken = tmp_path / "taken"
    taken.write_text("")
    with pytest.raises(InputError, match="output folder is a file"):
        call(EXAMPLES / "quarter-circle.toml", "--out", taken)


def test_no_equilibrium_is_exit_code_three(tmp_path):
    path = tmp_path / "crushed.toml"
    text = (EXAMPLES / "quarter-circle.toml").read_text().split("[[moment]]")[0]
    path.write_text(text + "[[force]]\nat = 1.0\nvalue = [-1e300, 0, 0]\n[solver]\nmax_steps = 3\n")
    result = call(path, "--json")
    assert result.exit_code == 3
    found = json.loads(result.stdout)
    assert not any(need["reached"] for need in found["needs"])
    assert found["omissions"]


def test_default_settings_come_first_and_names_are_words():
    point = CostPoint("3333", "beam", "enhanced", 8, "8 elements", "finite-difference", "none", "converged")
    assert point.label == "3333, difference tangent, no predictor"
    for element in run.ELEMENTS.values():
        first = next(run.settings(element, families()[0], False))
        assert first.formulation == element.formulations[0] and not first.solver
