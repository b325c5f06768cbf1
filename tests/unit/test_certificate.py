"""The certificate: valid for the code that earned it, and each way to cheat it is named."""

from __future__ import annotations

import copy
import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from tests.regimes import REGIME
from validation import certificate, certify, convergence, digests
from validation.cases import load_cases
from validation.certificate import NotValidated, build, require, seal, verify, write
from validation.criteria import Verdict, judge, worst
from validation.digests import PACKAGE, Roots
from validation.domain import domain_of
from validation.expected import expected_checks
from validation.hard_cases import HardResult, hard_cases
from validation.locking import LockingPoint, SlendernessRow
from validation.outcome import Outcome
from validation.problems import CaseResult
from validation.properties import PROPERTIES
from validation.property_runs import PropertyResult
from validation.reference_checks import CheckResult
from validation.runner import Run
from validation.work_precision import WorkPoint

# The copies of these tests have to earn their certificate.
LEFT_OUT = shutil.ignore_patterns("__pycache__", "certificate.json")
CASE, CASE_FILE = "HX-3333-24", "05_helix.toml"


def findings(limits, error=0.0):
    """Numbers that meet their limits ten times over, or miss them by what is documented."""
    return [
        judge(
            limit,
            limit.quantity.replace("[[]", "[").replace("*", "any"),
            limit.documented or limit.value / 10,
            error,
        )
        for limit in limits
    ]


def passing_run(roots):
    """A full run in which everything passed, without the twenty minutes."""
    cases = load_cases(roots.cases)
    expected = expected_checks(cases)
    run = Run("full", "2026-01-01 00:00 UTC", expected=cases, seconds={"total": 1.0})
    for case in cases:
        held = findings(case.limits)
        run.cases.append(CaseResult(case, worst(f.verdict for f in held), held, Outcome({}, []), 0.1))
    for study in convergence.studies(True):
        limits = expected[f"order {study.name} {study.element}"].limits
        run.convergence.append(convergence.StudyResult(study, [1.0], study.promised, findings(limits)))
    for name, expectation in expected.items():
        if name.startswith("reference "):
            run.reference_checks.append(
                CheckResult(name.removeprefix("reference "), "", (1.0,), {}, {}, findings(expectation.limits))
            )
    for check in PROPERTIES:
        (held,) = findings(expected[f"property {check.name}"].limits)
        run.properties.append(
            PropertyResult(check.name, check.title, check.bound, check.unit, 3, held, (1, 2, 3), 0.1)
        )
    for case in hard_cases():
        deviation = None if case.deviation is None else case.limit / 10
        run.hard_cases.append(
            HardResult(case, Verdict.PASS, case.expected[0], "", 1, 0, 5, 1e-12, 1e-12, deviation, 0.1)
        )
    run.locking.append(LockingPoint("3333", "enhanced", 0.3, 1.0, 1.0))
    run.slenderness.append(SlendernessRow(20, 1, [0.1], [0.1]))
    run.work.append(WorkPoint("3333", "8 elements", 100, 1e-4, 0.1, 0.1, 7, 5))
    run.regimes = {case.id: [REGIME] for case in cases if case.id in (CASE, "HX-3333-12")}
    run.subject = digests.of_solver(roots)
    run.configuration = digests.of_judges(roots) | {
        f"case {case.id}": digests.of_case(case) for case in cases if case.required
    }
    return run


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """One copy of the three packages: the tree itself is never touched, nor read twice while it changes."""
    folder = tmp_path_factory.mktemp("sources")
    for name in ("ancf", "reference", "validation"):
        shutil.copytree(PACKAGE.parent / name, folder / name, ignore=LEFT_OUT)
    return folder


@pytest.fixture(scope="module")
def run(sources):
    return passing_run(roots_in(sources))


@pytest.fixture(scope="module")
def statement(run):
    return build(run)


def roots_in(folder):
    return Roots(*(folder / name for name in ("ancf", "reference", "validation")))


@pytest.fixture
def tree(sources, tmp_path, statement):
    """Packages and the certificate that they earned."""
    shutil.copytree(sources, tmp_path, dirs_exist_ok=True)
    write(statement, tmp_path / "certificate.json")
    return tmp_path


def reasons(tree, file=None):
    found = verify(file or tree / "certificate.json", roots_in(tree))
    assert found.valid is (not found.reasons)
    return found.reasons


@pytest.fixture
def refused(sources, tmp_path):
    """Reasons against a certificate (a statement or bytes) for code that nobody touched."""

    def judged(content):
        path = tmp_path / "certificate.json"
        if isinstance(content, bytes):
            path.write_bytes(content)
        else:
            write(content, path)
        return reasons(sources, path)

    return judged


def edit(path, old, new, count=1):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, count))


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
    assert [entry["load"] for entry in predicate["domain"]] == ["bending"]


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


# --- the certificate itself is edited -------------------------------------------------------------------


def entry(data, name=f"case {CASE}"):
    return data["predicate"]["evidence"][name]


def fail_to_pass(data):
    """A run with a failed check, told as if it had passed."""
    entry(data)["findings"][0]["observed"] = 1.0


def inconclusive_to_pass(data):
    entry(data)["findings"][0]["reference_error"] = 0.5


def no_number(data):
    entry(data)["findings"][0]["observed"] = None


def raise_limit(data):
    entry(data)["findings"][0] |= {"limit": 1.0, "observed": 0.5}


def drop_case(data):
    name = f"case {CASE}"
    del data["predicate"]["evidence"][name]
    data["predicate"]["passedTests"].remove(name)


def drop_check(data):
    del entry(data)["findings"][0]


def drop_order(data):
    name = "order bending 3243"
    del data["predicate"]["evidence"][name]
    data["predicate"]["passedTests"].remove(name)


def drop_reference_check(data):
    name = next(name for name in data["predicate"]["evidence"] if name.startswith("reference "))
    del data["predicate"]["evidence"][name]
    data["predicate"]["passedTests"].remove(name)


def foreign_regime(data):
    """A check that the code does not know brings its own domain."""
    regime = {**REGIME, "law": "mooney-rivlin"}
    data["predicate"]["evidence"]["case invented"] = {**entry(data), "regimes": [regime]}
    data["predicate"]["passedTests"] = sorted([*data["predicate"]["passedTests"], "case invented"])
    data["predicate"]["domain"] = domain_of([REGIME, regime])


def property_with_a_regime(data):
    """A check that measures no accuracy speaks for the domain."""
    name = next(name for name in data["predicate"]["evidence"] if name.startswith("property "))
    data["predicate"]["evidence"][name]["regimes"] = [{**REGIME, "kappa_R": 0.5}]
    data["predicate"]["domain"] = domain_of([REGIME, {**REGIME, "kappa_R": 0.5}])


def other_rod(data):
    """A case of element 3333 speaks for 3363."""
    regime = {**REGIME, "element": "3363", "formulation": "continuum"}
    data["predicate"]["evidence"][f"case {CASE}"]["regimes"].append(regime)
    data["predicate"]["domain"] = domain_of([REGIME, regime])


def empty(data):
    data["predicate"] |= {"evidence": {}, "passedTests": [], "warnedTests": [], "domain": []}


def set_predicate(key, value):
    def change(data):
        data["predicate"][key] = value

    change.__name__ = f"set_{key}"
    return change


def widen_domain(data):
    data["predicate"]["domain"][0]["poisson_ratio"][1] = 0.4999


def other_code(data):
    data["subject"][0]["digest"]["sha256"] = "0" * 64


def no_subject(data):
    data["subject"] = []


def no_case_digest(data):
    data["predicate"]["configuration"] = [
        item for item in data["predicate"]["configuration"] if item["name"] != f"case {CASE}"
    ]


def status_of_hard_case(data):
    entry(data, "hard case full circle, L/R = 40")["status"] = "limit_point"


def hide_reason(data):
    entry(data)["reason"] = "NoEquilibrium: limit_point"


CHEATS = [
    (fail_to_pass, "case HX-3333-24: 'tip position' is stated PASS, but 1.0 against limit 0.001 is FAIL"),
    (inconclusive_to_pass, "against limit 0.001 is INCONCLUSIVE"),
    (no_number, "case HX-3333-24: 'tip position' is stated PASS, but None against limit 0.001 is FAIL"),
    (raise_limit, "case HX-3333-24: limit of 'tip position' was 1.0, is 0.001 now"),
    (drop_case, "case HX-3333-24 is missing from the run"),
    (drop_check, "case HX-3333-24: no number for 'tip position'"),
    (drop_order, "order bending 3243 is missing from the run"),
    (drop_reference_check, "is missing from the run"),
    (foreign_regime, "case invented does not measure accuracy, but speaks for the domain of validity"),
    (property_with_a_regime, "does not measure accuracy, but speaks for the domain of validity"),
    (other_rod, "case HX-3333-24 speaks for rods that are not in that case"),
    (empty, "nothing was run"),
    (set_predicate("scope", "quick"), "it is of a quick run, not of a full one"),
    (set_predicate("complete", False), "it is of a part of the validation, not of the whole"),
    (set_predicate("result", "WARNED"), "result does not follow from the verdicts"),
    (set_predicate("passedTests", []), "passedTests does not follow from the verdicts"),
    (set_predicate("failedTests", ["case X"]), "failedTests does not follow from the verdicts"),
    (widen_domain, "the domain of validity is not the one of the cases that passed"),
    (other_code, "ancf/__init__.py changed"),
    (no_subject, "ancf/__init__.py was added"),
    (no_case_digest, "case HX-3333-24 was added"),
    (status_of_hard_case, "hard case full circle, L/R = 40: ended 'limit_point', must end in converged"),
    (hide_reason, "case HX-3333-24: stated PASS, but its numbers say FAIL"),
]


@pytest.mark.parametrize(("cheat", "named"), CHEATS, ids=lambda value: getattr(value, "__name__", ""))
def test_an_edited_certificate_is_refused(refused, statement, cheat, named):
    edited = copy.deepcopy(statement)
    cheat(edited)
    assert refused(edited) == ["its content does not match its checksum: it was damaged or edited"]
    # The checksum is no secret. Whoever computes it again is caught by what does not fit together.
    assert any(named in reason for reason in refused(seal(edited)))


def test_failed_rewritten_to_passed_everywhere(refused, run):
    """Verdicts and lists are rewritten to fit each other, the number is left as measured."""
    bad = run.cases[[r.case.id for r in run.cases].index(CASE)]
    failed = [judge(bad.findings[0].limit, "tip position", 0.5), *bad.findings[1:]]
    cases = [replace(r, verdict=Verdict.FAIL, findings=failed) if r is bad else r for r in run.cases]
    honest = build(replace(run, cases=cases))
    assert honest["predicate"]["result"] == "FAILED"
    assert f"case {CASE} is FAIL" in refused(honest)
    text = json.dumps(honest).replace('"FAIL"', '"PASS"').replace('"FAILED"', '"PASSED"')
    edited = json.loads(text)
    edited["predicate"] |= {
        "failedTests": [],
        "passedTests": sorted([*edited["predicate"]["passedTests"], f"case {CASE}"]),
    }
    assert f"case {CASE} is FAIL" in refused(seal(edited))


@pytest.mark.parametrize("verdict", [Verdict.FAIL, Verdict.INCONCLUSIVE])
def test_a_run_that_did_not_pass(refused, run, verdict):
    error = 0.0 if verdict is Verdict.FAIL else 1.0
    bad = run.properties[0]
    finding = judge(bad.finding.limit, bad.name, 2.0, error)
    failed = replace(run, properties=[replace(bad, finding=finding), *run.properties[1:]])
    assert f"property {bad.name} is {verdict}" in refused(build(failed))


def test_quick_partial_and_empty_runs(refused, run):
    assert "it is of a quick run, not of a full one" in refused(build(replace(run, scope="quick")))
    partial = replace(run, selection=(CASE,), cases=[r for r in run.cases if r.case.id == CASE])
    assert "it is of a part of the validation, not of the whole" in refused(build(partial))
    assert "case HX-3333-12 is missing from the run" in refused(build(partial))
    nothing = Run("full", run.started, subject=run.subject, configuration=run.configuration)
    assert build(nothing)["predicate"]["result"] == "FAILED"
    found = refused(build(nothing))
    assert "nothing was run" in found and "case HX-3333-24 is missing from the run" in found


@pytest.mark.parametrize(
    "content", [b"", b"{", b"\xff", b"[]", b"null", b'{"_type": "https://in-toto.io/Statement/v1"}']
)
def test_a_file_that_is_no_certificate(refused, content):
    assert len(refused(content)) == 1


@pytest.mark.parametrize("size", [0.1, 0.5, 0.999])
def test_a_truncated_certificate(refused, statement, size):
    text = json.dumps(statement).encode()
    assert "it is not JSON" in refused(text[: int(size * len(text))])[0]


def test_an_id_of_another_certificate(refused, statement):
    edited = {key: value for key, value in statement.items() if key != "checksum"} | {"id": "0" * 64}
    edited["checksum"] = digests.of_json(edited)
    assert refused(edited) == ["its id does not match its content: it was edited"]


@pytest.mark.parametrize("key", ["subject", "predicate"])
@pytest.mark.parametrize("value", [None, 5, "text", {}])
def test_content_of_the_wrong_shape_is_refused_without_a_traceback(refused, statement, key, value):
    edited = {k: v for k, v in statement.items() if k != "checksum"} | {key: value}
    edited["checksum"] = digests.of_json(edited)
    assert refused(edited)


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
