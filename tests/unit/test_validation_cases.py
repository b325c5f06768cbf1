"""Case files: what is not complete is refused, naming file, case and key."""

from __future__ import annotations

import copy

import pytest

from validation.cases import CaseError, load_cases
from validation.problems import PROBLEMS, run_case
from validation.scenes import as_toml

FAMILY = """
row = "TO"
title = "Torsion"
problem = "torsion stiffness"
loads = "torsion"
shows = "A circle twists with its polar moment."
[reference]
name = "Saint-Venant"
independence = "closed form"
source = "Timoshenko"
[scene]
[[scene.rod]]
length = 0.4
elements = 2
section = { shape = "circle", radius = 0.01 }
material = { young_modulus = 1.0e6, poisson_ratio = 0.3 }
[[limit]]
quantity = "torsion constant"
value = 1e-6
unit = "-"
reason = "a circle does not warp"
[[case]]
id = "A"
[[case]]
id = "B"
rod = { elements = 5, element = "3243" }
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "a.toml").write_text(FAMILY)
    return tmp_path


def change(folder, old: str, new: str):
    assert old in FAMILY
    (folder / "a.toml").write_text(FAMILY.replace(old, new))


def refusal(folder) -> str:
    with pytest.raises(CaseError) as caught:
        load_cases(folder)
    return str(caught.value)


def test_a_case_takes_over_its_family_and_changes_it(folder):
    first, second = load_cases(folder)
    assert (first.id, first.rod["elements"]) == ("A", 2)
    assert (second.rod["elements"], second.rod["element"]) == (5, "3243")
    assert second.rod["section"] == {"shape": "circle", "radius": 0.01}
    assert second.reproduce == "ancf validate --case B"


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('unit = "-"', 'unit = "-"\nunits = "m"', "Unknown key 'units'"),
        ('reason = "a circle does not warp"', 'reason = " "', "A limit has no reason"),
        ('reason = "a circle does not warp"\n', "", "The key 'reason' is missing"),
        ("value = 1e-6", "value = 0.0", "A limit must be a positive number"),
        ("value = 1e-6", "value = nan", "A limit must be a positive number"),
        ("value = 1e-6", "value = true", "A limit must be a positive number"),
        ('independence = "closed form"', 'independence = "trust me"', "Unknown independence"),
        ('shows = "A circle twists with its polar moment."\n', "", "The case has no shows"),
        ('id = "B"', 'id = "A"', "Two cases are named A"),
        ('id = "B"', 'id = "B"\nset = "weekly"', "Unknown set"),
        ('problem = "torsion stiffness"\n', "", "The key 'problem' is missing"),
        ("[[limit]]", "[[limits]]", "Unknown key 'limits'"),
        ('row = "TO"', "row = ", "The case file cannot be read"),
    ],
)
def test_incomplete_files_are_refused(folder, old, new, expected):
    change(folder, old, new)
    message = refusal(folder)
    assert message.startswith(expected)
    for part in ("where:", "value:", "cause:", "try:"):
        assert part in message


def test_a_folder_without_cases_is_refused(tmp_path):
    assert refusal(tmp_path).startswith("There are no validation cases")


def test_shipped_cases_load_and_name_known_problems():
    cases = load_cases()
    assert {case.problem for case in cases} <= set(PROBLEMS)
    # Every row of the benchmark table that belongs to this report.
    assert {"RM", "PT", "AX", "HX", "PB", "LK", "TO", "EL", "MO", "CB", "pins"} <= {
        case.row for case in cases
    }
    assert all(case.required for case in cases if case.set == "quick")


def test_a_case_is_judged(folder):
    result = run_case(load_cases(folder)[0])
    assert result.verdict == "PASS"
    assert [finding.quantity for finding in result.findings] == ["torsion constant"]


def test_a_limit_that_nothing_meets_fails_the_case(folder):
    change(
        folder,
        '[[case]]\nid = "A"',
        '[[limit]]\nquantity = "warping"\nvalue = 1.0\nunit = "-"\nreason = "x"\n[[case]]\nid = "A"',
    )
    result = run_case(load_cases(folder)[0])
    assert result.verdict == "FAIL"
    assert "warping" in result.reason


def test_a_quantity_without_limit_fails_the_case(folder):
    change(folder, 'quantity = "torsion constant"', 'quantity = "torsion"')
    result = run_case(load_cases(folder)[0])
    assert result.verdict == "FAIL"
    assert "torsion constant" in result.reason


def test_a_warning_that_the_solver_does_not_give_fails_the_case(folder):
    change(folder, 'id = "A"', 'id = "A"\nwarning = "cannot warp"')
    result = run_case(load_cases(folder)[0])
    assert result.verdict == "FAIL"
    assert "does not warn" in result.reason


def test_a_scene_that_cannot_be_solved_fails_its_case_only(folder):
    change(folder, 'id = "A"', 'id = "A"\nrod = { section = { shape = "circle", radius = -1.0 } }')
    first, second = load_cases(folder)
    assert run_case(first).verdict == "FAIL"
    assert "SceneError" in run_case(first).reason
    assert run_case(second).verdict == "PASS"


def test_a_scene_as_text_is_the_same_scene(folder):
    import tomllib

    case = load_cases(folder)[1]
    scene = copy.deepcopy(case.scene)
    scene["moment"] = [{"value": [0.0, 1e-7, -2.5], "frame": "body"}]
    scene["gravity"] = {"acceleration": [0, 0, -9.81]}
    assert tomllib.loads(as_toml(scene)) == scene


MATRIX = """
[[vary.element]]
name = "3333"
[[vary.element]]
name = "3243"
rod = { element = "3243", elements = 4 }
set = "full"
[[vary.law]]
name = "hard"
rod = { elements = 2 }
parameters = { angle = 1.0 }
[[vary.law]]
name = "soft"
set = "quick"
"""


def test_a_matrix_is_every_combination_of_its_axes(folder):
    file = next(folder.glob("*.toml"))
    file.write_text(file.read_text(encoding="utf-8") + MATRIX, encoding="utf-8")
    cases = {case.id: case for case in load_cases(folder) if case.place}
    row = load_cases(folder)[0].row
    assert list(cases) == [f"{row}-{e}-{law}" for e in ("3333", "3243") for law in ("hard", "soft")]
    both = cases[f"{row}-3243-hard"]
    assert both.place == {"element": "3243", "law": "hard"}
    assert both.rod["element"] == "3243"
    assert both.rod["elements"] == 2  # the later axis decides
    assert both.parameters["angle"] == 1.0
    assert both.set == cases[f"{row}-3243-soft"].set == "full"
    assert cases[f"{row}-3333-soft"].set == "quick"


def test_a_limit_may_be_for_some_cases_only(folder):
    limit = '[[limit]]\ncases = "*B"\nquantity = "warping"\nvalue = 1.0\nunit = "-"\nreason = "x"\n'
    change(folder, '[[case]]\nid = "A"', limit + '[[case]]\nid = "A"')
    first, second = load_cases(folder)
    assert [limit.quantity for limit in first.limits] == ["torsion constant"]
    assert [limit.quantity for limit in second.limits] == ["torsion constant", "warping"]
    change(folder, '[[case]]\nid = "A"', limit.replace("*B", "*Z") + '[[case]]\nid = "A"')
    assert "A limit is for no case" in refusal(folder)


def test_a_family_without_a_case_and_a_variant_without_a_name_are_refused(folder):
    file = next(folder.glob("*.toml"))
    text = file.read_text(encoding="utf-8")
    file.write_text(text[: text.index("[[case]]")], encoding="utf-8")
    assert "has no case" in refusal(folder)
    file.write_text(text + '[[vary.law]]\nset = "quick"\n', encoding="utf-8")
    assert "'name' is missing" in refusal(folder)
