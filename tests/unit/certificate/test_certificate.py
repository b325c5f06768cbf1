"""The certificate: valid for the code that earned it, named what changed, given to whole runs only."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from tests.certificates import CASE, CASE_FILE, edit, reasons, roots_in
from tests.regimes import REGIME
from validation import certificate, certify
from validation.certificate import NotValidated, build, require, verify
from validation.criteria import Verdict, judge
from validation.digests import Roots


def test_an_honest_certificate_is_valid(tree):
    assert reasons(tree) == []
    assert require(tree / "certificate.json", roots_in(tree)).id == json.loads(
        (tree / "certificate.json").read_text()
    )["id"]  # fmt: skip


def test_it_is_an_in_toto_test_result(statement):
    assert statement["_type"] == "https://in-toto.io/Statement/v1"
    assert statement["predicateType"] == "https://in-toto.io/attestation/test-result/v0.1"
    predicate = statement["predicate"]
    assert (predicate["result"], predicate["failedTests"]) == ("PASSED", [])
    assert "case HX-3333-24" in predicate["passedTests"]
    names = [entry["name"] for entry in statement["subject"]]
    assert "ancf/energy.py" in names and names == sorted(names)
    assert {"python", "numpy", "scikit-fem", "system"} <= set(predicate["environment"])
    assert [entry["loads"] for entry in predicate["domain"]] == ["bending"]


# --- the code changes under a certificate ---------------------------------------------------------------


def test_one_byte_of_the_solver(tree):
    path = tree / "ancf" / "energy.py"
    data = bytearray(path.read_bytes())
    data[-2] ^= 1
    path.write_bytes(data)
    assert reasons(tree) == ["ancf/energy.py changed"]


def test_an_edit_that_breaks_the_solver_is_named_and_no_traceback(tree):
    (tree / "ancf" / "energy.py").write_text("nonsense\n")
    code = (
        "from pathlib import Path; from validation.certificate import verify;"
        "found = verify(Path('certificate.json')); print(found.valid); print(*found.reasons, sep='\\n')"
    )
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tree, env=environment)
    assert done.stdout.splitlines() == [
        "False", "ancf/energy.py changed",
        "the present code does not load: NameError: name 'nonsense' is not defined",
    ], done.stderr  # fmt: skip


def test_a_file_of_the_solver_added_or_taken_away(tree):
    (tree / "ancf" / "effects" / "magic.py").write_text("")
    (tree / "ancf" / "band.py").unlink()
    assert reasons(tree) == ["ancf/effects/magic.py was added", "ancf/band.py is missing"]


def test_the_judges_count_too(tree):
    edit(tree / "validation" / "criteria.py", "WARN_MARGIN = 1.5", "WARN_MARGIN = 1.0")
    edit(tree / "reference" / "helix.py", "import", "import  ")
    assert reasons(tree) == ["reference/helix.py changed", "validation/criteria.py changed"]


def test_a_module_that_hides_another_is_seen(tree):
    """Python imports a package before a module of its name, wherever the folder really is."""
    (tree / "validation" / "cases" / "__init__.py").write_text("")
    (tree / "elsewhere").mkdir()
    (tree / "ancf" / "newton").symlink_to(tree / "elsewhere", target_is_directory=True)
    assert reasons(tree) == ["ancf/newton was added", "validation/cases/__init__.py was added"]


def test_the_digests_are_of_the_packages_that_are_imported():
    import ancf
    import reference

    assert Roots().ancf == Path(str(ancf.__file__)).parent
    assert Roots().reference == Path(str(reference.__file__)).parent


def test_without_scikit_fem_the_reference_checks_cannot_be_judged(tree, monkeypatch):
    monkeypatch.setitem(sys.modules, "validation.reference_checks", None)
    found = verify(tree / "certificate.json", roots_in(tree))
    assert not found.valid
    assert "is needed to judge it again" in found.reasons[0]


def test_what_only_shows_or_stores_does_not_count(tree):
    (tree / "validation" / "report" / "report.css").write_text("")
    (tree / "reference" / "solved").mkdir(exist_ok=True)
    (tree / "reference" / "solved" / "new.json").write_text("{}")
    (tree / "ancf" / "__pycache__").mkdir()
    (tree / "ancf" / "__pycache__" / "energy.pyc").write_bytes(b"1")
    edit(tree / "validation" / "cases" / CASE_FILE, "Helix under three tip moments", "A helix")
    assert reasons(tree) == []


def test_a_limit_edited(tree):
    edit(tree / "validation" / "cases" / CASE_FILE, "value = 1e-3", "value = 2e-3")
    found = reasons(tree)
    assert "case HX-3333-24 changed" in found
    assert "case HX-3333-24: limit of 'tip position' was 0.001, is 0.002 now" in found


def test_a_documented_miss_edited(tree):
    edit(tree / "validation" / "cases" / CASE_FILE, "documented = 2.70e-2", "documented = 2.71e-2")
    assert any("documented of 'section moment along the rod' was 0.027" in reason for reason in reasons(tree))


def test_a_case_deleted(tree):
    path = tree / "validation" / "cases" / CASE_FILE
    edit(path, '[[case]]\nid = "HX-3243-24"\nrod = { element = "3243" }\n', "")
    assert reasons(tree) == ["case HX-3243-24 is missing"]


def test_a_case_made_easier_or_no_longer_required(tree):
    path = tree / "validation" / "cases" / CASE_FILE
    edit(path, "value = [0.6, 0.5, -0.8]", "value = [0.06, 0.05, -0.08]")
    assert "case HX-3333-24 changed" in reasons(tree)
    edit(path, 'id = "HX-3243-24"', 'id = "HX-3243-24"\nrequired = false')
    assert "case HX-3243-24 is missing" in reasons(tree)


def test_the_case_files_cannot_be_read(tree):
    (tree / "validation" / "cases" / CASE_FILE).write_text("[[")
    assert "The case file cannot be read." in reasons(tree)[0]


def test_no_certificate_at_all(tree):
    (tree / "certificate.json").unlink()
    with pytest.raises(NotValidated) as caught:
        require(tree / "certificate.json", roots_in(tree))
    text = str(caught.value)
    assert "cannot be read" in text and "ancf validate --full" in text
    assert [part in text for part in ("where:", "value:", "cause:", "try:")] == [True] * 4


def test_require_names_what_changed(tree):
    edit(tree / "ancf" / "newton.py", "import", "import  ")
    with pytest.raises(NotValidated, match=r"ancf/newton\.py changed"):
        require(tree / "certificate.json", roots_in(tree))


# --- the id ---------------------------------------------------------------------------------------------


def test_the_id_leaves_out_what_is_measured(run, statement):
    properties = [replace(r, finding=judge(r.finding.limit, r.name, 0.2 * r.bound)) for r in run.properties]
    other = replace(
        run, started="2027-01-01 00:00 UTC", environment={"system": "another"}, versions={"numpy": "9"},
        seconds={"total": 9.0}, regimes={CASE: [{**REGIME, "kappa_R": 0.029999}]},
        properties=properties,
    )  # fmt: skip
    assert build(other) != statement
    assert build(other)["id"] == statement["id"]


def test_the_id_holds_code_verdicts_and_domain(run, statement):
    first = run.properties[0]
    warned = replace(first, finding=judge(first.finding.limit, first.name, 0.9 * first.bound))
    changed = [
        replace(run, subject={**run.subject, "ancf/energy.py": "0" * 64}),
        replace(run, configuration={**run.configuration, f"case {CASE}": "0" * 64}),
        replace(run, properties=[warned, *run.properties[1:]]),
        replace(run, regimes={CASE: [{**REGIME, "law": "neo-hookean"}]}),
    ]
    ids = {build(other)["id"] for other in changed} | {statement["id"]}
    assert len(ids) == 5
    assert build(changed[2])["predicate"]["result"] == "WARNED"


# --- when a run gets one --------------------------------------------------------------------------------


@pytest.fixture
def issue(tree, monkeypatch):
    """`certify` on the copied tree."""
    monkeypatch.setattr(certify, "Roots", lambda: roots_in(tree))
    monkeypatch.setattr(certificate, "Roots", lambda: roots_in(tree))
    monkeypatch.setattr(certificate, "SHIPPED", tree / "validation" / "certificate.json")
    out = tree / "out"
    out.mkdir()
    return lambda run, ship=False: (certify.certify(run, out, ship), out / "certificate.json")


def test_a_full_run_that_passed_is_certified(issue, tree, run):
    written, path = issue(replace(run))
    assert written == [path]
    assert reasons(tree, path) == []
    assert not (tree / "validation" / "certificate.json").exists()
    issue(run, ship=True)
    assert verify(tree / "validation" / "certificate.json", roots_in(tree)).valid
    assert run.certificate == json.loads(path.read_text())["id"]


def test_a_run_that_failed_loses_the_certificate_of_its_folder(issue, run):
    _, path = issue(replace(run))
    failed = replace(run, failed_parts={"locking": "ZeroDivisionError"})
    assert (issue(failed)[0], failed.certificate, path.exists()) == ([], None, False)
    assert failed.certificate_reasons


def test_a_selection_of_a_full_run_is_not_certified_and_leaves_the_folder_alone(issue, run):
    _, path = issue(replace(run))
    kept = path.read_bytes()
    selected = replace(run, selection=(CASE,), certificate=None)
    assert (issue(selected)[0], selected.certificate, path.read_bytes()) == ([], None, kept)


def test_code_edited_while_the_run_went_on_is_not_certified(issue, tree, run):
    edit(tree / "ancf" / "newton.py", "import", "import  ")
    late = replace(run)
    written, path = issue(late)
    assert (written, path.exists()) == ([], False)
    assert late.certificate_reasons == ["ancf/newton.py changed"]


def test_a_quick_run_only_states_whether_the_shipped_one_holds(issue, tree, run):
    quick = replace(run, scope="quick")
    assert (issue(quick)[0], quick.certificate) == ([], None)
    assert "cannot be read" in quick.certificate_reasons[0]
    issue(run, ship=True)
    issue(quick)
    assert (quick.certificate, quick.certificate_reasons) == (run.certificate, [])
    edit(tree / "ancf" / "newton.py", "import", "import  ")
    issue(quick)
    assert (quick.certificate, quick.certificate_reasons) == (None, ["ancf/newton.py changed"])


def test_reading_it_is_light():
    """The data set's gate imports this module only."""
    heavy = "skfem matplotlib jinja2 meshio numpy scipy"
    code = f"import sys, validation.certificate; print([m for m in {heavy.split()} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_known_limit_is_not_part_of_the_domain(run):
    known = [replace(r, verdict=Verdict.KNOWN_LIMIT) if r.case.id in run.regimes else r for r in run.cases]
    assert build(replace(run, cases=known))["predicate"]["domain"] == []


def test_the_certificate_of_this_folder_is_the_default():
    assert verify().path == Path(certificate.__file__).parent / "certificate.json"
