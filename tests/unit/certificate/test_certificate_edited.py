"""Each way to edit a certificate is refused, and its reason named."""

from __future__ import annotations

import copy
import json
from dataclasses import replace

import pytest

from tests.certificates import CASE
from tests.regimes import REGIME
from validation import digests
from validation.certificate import build, seal
from validation.criteria import Verdict, judge
from validation.domain import domain_of
from validation.runner import Run


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
